#include "balance/mechanics/results/body_poses.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include <string>

using namespace balance;

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
constexpr double tolerance = 1e-10;

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
        CHECK(std::abs(place[axis] - moved.result.tool_position(k, axis)) < tolerance);
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
            tolerance);
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
        CHECK(std::abs(sum[axis] - moved.result.com_position(k, axis)) < tolerance);
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
