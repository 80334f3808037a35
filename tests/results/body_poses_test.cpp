#include "balance/mechanics/results/body_poses.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include <string>

using namespace balance;
using namespace balance::results;

namespace {

struct Moved {
  Study study;
  RunResult result;
  BodyPoses poses;

  explicit Moved(const std::string& config, long samples = 21)
      : study(read_spec_file(std::string(BALANCE_CONFIGS) + "/" + config)) {
    Trajectory trajectory = study.trajectories.front();
    trajectory.samples = samples;
    result = simulate(study.mechanism, trajectory);
    REQUIRE(result.outcome.status == MotionStatus::done);
    poses = body_poses(study.mechanism, result);
  }

  Eigen::Quaterniond turn(Eigen::Index k, int body) const {
    const auto q = poses.orientation.row(k).segment<4>(4 * body);
    return {q[0], q[1], q[2], q[3]};
  }
  Vector3 place(Eigen::Index k, int body, const Vector3& p) const {
    return Vector3(poses.position.row(k).segment<3>(3 * body).transpose()) + turn(k, body) * p;
  }
};

// Loops are closed to 1e-12 of the mechanism's size, a metre or less.
constexpr double pose_tolerance = 1e-10;

const std::vector<std::string> configs = {
    "3rrr.yaml",    "slider-crank.yaml", "scotch-yoke.yaml", "whitworth.yaml",         "delta.yaml",
    "stewart.yaml", "spatial-rrr.yaml",  "rccc.yaml",        "four-bar-in-space.yaml", "spatial-slider-crank.yaml",
    "bricard.yaml"};

}  // namespace

TEST_CASE("the tool's point of its body's pose is where the run says the tool is") {
  for (const std::string& config : configs) {
    CAPTURE(config);
    const Moved moved(config);
    if (!moved.study.mechanism.tool) continue;
    const Tool& tool = *moved.study.mechanism.tool;
    for (Eigen::Index k = 0; k < moved.result.time.size(); ++k) {
      const Vector3 place = moved.place(k, tool.body, tool.position);
      for (int axis = 0; axis < moved.result.axes; ++axis)
        CHECK(std::abs(place[axis] - moved.result.tool_position(k, axis)) < pose_tolerance);
    }
  }
}

TEST_CASE("joints that turn in a point hold their two bodies together there, those that close loops too") {
  for (const std::string& config : configs) {
    CAPTURE(config);
    const Moved moved(config);
    for (const Joint& joint : moved.study.mechanism.joints) {
      const bool turns = joint.type == JointType::revolute || joint.type == JointType::universal ||
                         joint.type == JointType::spherical || joint.type == JointType::fixed;
      if (!turns) continue;
      CAPTURE(joint.name);
      for (Eigen::Index k = 0; k < moved.result.time.size(); ++k)
        CHECK(
            (moved.place(k, joint.first, joint.point_first) - moved.place(k, joint.second, joint.point_second)).norm() <
            pose_tolerance);
    }
  }
}

TEST_CASE("the centre of mass of the bodies' poses is that of the run") {
  for (const std::string& config :
       {std::string("slider-crank.yaml"), std::string("stewart.yaml"), std::string("rccc.yaml")}) {
    CAPTURE(config);
    const Moved moved(config);
    const Mechanism& mechanism = moved.study.mechanism;
    REQUIRE(mechanism.discs.empty());
    for (Eigen::Index k = 0; k < moved.result.time.size(); ++k) {
      Vector3 sum = Vector3::Zero();
      for (int b = 1; b < static_cast<int>(mechanism.bodies.size()); ++b)
        sum += mechanism.bodies[static_cast<std::size_t>(b)].mass *
               moved.place(k, b, mechanism.bodies[static_cast<std::size_t>(b)].com);
      for (const Attachment& a : mechanism.attachments) sum += a.mass * moved.place(k, a.body, a.position);
      sum /= total_mass(mechanism);
      for (int axis = 0; axis < moved.result.axes; ++axis)
        CHECK(std::abs(sum[axis] - moved.result.com_position(k, axis)) < pose_tolerance);
    }
  }
}

TEST_CASE("orientations go on smoothly and have length one") {
  const Moved moved("delta.yaml", 101);
  for (int b = 0; b < static_cast<int>(moved.study.mechanism.bodies.size()); ++b)
    for (Eigen::Index k = 0; k < moved.result.time.size(); ++k) {
      CHECK(moved.turn(k, b).norm() == doctest::Approx(1).epsilon(1e-14));
      if (k > 0) CHECK(moved.turn(k, b).dot(moved.turn(k - 1, b)) > 0.9);
    }
}

TEST_CASE("a run of another mechanism has no poses here") {
  const Moved arm("rr.yaml", 3);
  const Study other = read_spec_file(std::string(BALANCE_CONFIGS) + "/3rrr.yaml");
  CHECK_THROWS_AS(body_poses(other.mechanism, arm.result), std::invalid_argument);
}

// Of several mechanisms with all kinds of joints: the momentum of the bodies' motions is that of the recursion, whose
// centre of mass is computed in other coordinates.
TEST_CASE("the bodies' velocities and accelerations give the centre of mass its own") {
  for (const char* name : {"spatial-rrr", "stewart", "delta", "rolling-on-a-plane", "rolling-disc", "bricard", "rccc",
                           "spatial-slider-crank", "scotch-yoke", "whitworth", "5r", "four-bar-in-space", "scara"}) {
    CAPTURE(name);
    const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + name + ".yaml");
    const Mechanism& mechanism = study.mechanism;
    Trajectory trajectory = study.trajectories.at(0);
    trajectory.samples = 7;
    const RunResult run = simulate(mechanism, trajectory);
    REQUIRE(run.outcome.status == MotionStatus::done);
    const auto motions = body_motions(mechanism, run, run.time.size());
    for (Eigen::Index k = 0; k < run.time.size(); ++k) {
      const std::vector<BodyMotion>& bodies = motions[static_cast<std::size_t>(k)];
      Vector3 position = Vector3::Zero(), velocity = Vector3::Zero(), acceleration = Vector3::Zero();
      double mass = 0;
      const auto add = [&](int body, double m, const Vector3& r) {
        const BodyMotion& motion = bodies[static_cast<std::size_t>(body)];
        position += m * motion.point_position(r);
        velocity += m * motion.point_velocity(r);
        acceleration += m * motion.point_acceleration(r);
        mass += m;
      };
      for (std::size_t b = 1; b < mechanism.bodies.size(); ++b)
        add(static_cast<int>(b), mechanism.bodies[b].mass, mechanism.bodies[b].com);
      for (const Attachment& one : mechanism.attachments)
        if (one.body != model::ground) add(static_cast<int>(one.body), one.mass, one.position);
      for (const Disc& one : mechanism.discs)
        if (one.body != model::ground) add(static_cast<int>(one.body), one.mass, one.position);
      const auto is_close = [&](const Vector3& sum, const Samples& column) {
        // round-off of joint coordinates, amplified by the mobility
        const double scale = 1 + column.cwiseAbs().maxCoeff();
        return (sum.head(run.axes) / mass - column.row(k).transpose()).norm() < 1e-9 * scale;
      };
      CHECK(is_close(position, run.com_position));
      CHECK(is_close(velocity, run.com_velocity));
      CHECK(is_close(acceleration, run.com_acceleration));
    }
  }
}
