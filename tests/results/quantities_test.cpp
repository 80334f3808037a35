#include "balance/mechanics/results/quantities.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/motion/control/closed_loop_run.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>

namespace quantities_test {

using namespace balance;
using namespace balance::results;

namespace {

Study config(const std::string& name) { return read_spec_file(std::string(BALANCE_CONFIGS) + "/" + name); }

const Metric& metric(const RunResult& result, const std::string& quantity) {
  const auto found = std::find_if(result.metrics.begin(), result.metrics.end(),
                                  [&](const Metric& one) { return one.quantity == quantity; });
  REQUIRE_MESSAGE(found != result.metrics.end(), quantity);
  return *found;
}

RunResult run(const Study& study, long samples, const Vector3& about = Vector3::Zero()) {
  Trajectory trajectory = study.trajectories.front();
  trajectory.samples = samples;
  trajectory.about = about;
  RunResult result = simulate(study.mechanism, trajectory);
  REQUIRE(result.outcome.status == MotionStatus::done);
  return result;
}

Vector3 in_space(const Samples& samples, Eigen::Index row) {
  Vector3 v = Vector3::Zero();
  if (samples.cols() == 1)
    v.z() = samples(row, 0);
  else
    v.head(samples.cols()) = samples.row(row);
  return v;
}

}  // namespace

TEST_CASE("every quantity has a name of its own and an array of its own") {
  std::set<std::string> names;
  for (const QuantityDefinition& kind : quantity_table()) {
    CHECK_MESSAGE(names.insert(kind.name).second, kind.name);
    const auto same = [&](const QuantityDefinition& other) { return other.member == kind.member; };
    CHECK_MESSAGE(std::count_if(quantity_table().begin(), quantity_table().end(), same) == 1, kind.name);
  }
}

TEST_CASE("the moment about the moving centre of mass is that about the fixed point where it is just then") {
  for (const char* name : {"3rrr.yaml", "delta.yaml", "stewart.yaml", "four-bar-in-space.yaml"}) {
    CAPTURE(name);
    const Study study = config(name);
    const RunResult result = run(study, 9);
    for (const Eigen::Index row : {2, 3, 7}) {
      const RunResult there = run(study, 9, in_space(result.com_position, row));
      const double scale = 1 + metric(result, "shaking_moment").peak;
      CHECK((in_space(there.shaking_moment, row) - in_space(result.shaking_moment_com, row)).norm() < 1e-9 * scale);
    }
  }
}

TEST_CASE("the moment about the moving centre of mass does not depend on the point that moments are about") {
  const Study study = config("3rrr.yaml");
  const RunResult here = run(study, 41), there = run(study, 41, {0.3, -2, 0});
  const double scale = metric(there, "shaking_moment").peak;
  CHECK((here.shaking_moment - there.shaking_moment).cwiseAbs().maxCoeff() > 0.1 * scale);
  CHECK((here.shaking_moment_com - there.shaking_moment_com).cwiseAbs().maxCoeff() < 1e-12 * scale);
}

TEST_CASE("the rms of the total torque squared is the sum of the motors' rms squared") {
  for (const char* name : {"3rrr.yaml", "delta.yaml", "rr.yaml"}) {
    CAPTURE(name);
    const Study study = config(name);
    const RunResult result = run(study, 101);
    double sum = 0;
    for (const std::string& motor : result.actuator_names)
      sum += std::pow(metric(result, "torque[" + motor + "]").rms, 2);
    CHECK(metric(result, "total_torque").rms == doctest::Approx(std::sqrt(sum)).epsilon(1e-12));
    CHECK(metric(result, "total_torque").peak >= metric(result, "torque").peak);
  }
}

TEST_CASE("torques and forces have no total, nor has one motor") {
  for (const char* name : {"scara.yaml", "four-bar.yaml"}) {
    CAPTURE(name);
    const RunResult result = run(config(name), 11);
    const std::set<std::string> units(result.actuator_units.begin(), result.actuator_units.end());
    REQUIRE((units.size() > 1 || result.actuator_names.size() == 1));
    CHECK(result.total_torque.size() == 0);
  }
}

TEST_CASE("both formulations and a controller without errors record the same quantities") {
  const Study study = config("3rrr.yaml");
  Trajectory trajectory = study.trajectories.front();
  trajectory.samples = 21;
  const RunResult tree = simulate(study.mechanism, trajectory),
                  natural = verification::simulate_natural(study.mechanism, trajectory);
  REQUIRE(natural.outcome.status == MotionStatus::done);
  for (Samples RunResult::*array : {&RunResult::total_torque, &RunResult::shaking_moment_com}) {
    const double scale = (tree.*array).cwiseAbs().maxCoeff();
    CHECK((tree.*array - natural.*array).cwiseAbs().maxCoeff() < 1e-9 * scale);
  }
  Controller controller;
  controller.type = study::ControllerType::computed_torque;
  controller.period = 1e-4;
  const RunResult led = simulate_closed_loop(study.mechanism, trajectory, controller);
  REQUIRE(led.outcome.status == MotionStatus::done);
  // A torque held for a tenth of a millisecond of a motion of a tenth of a second.
  const double scale = tree.total_torque.maxCoeff();
  CHECK((tree.total_torque - led.total_torque).cwiseAbs().maxCoeff() < 0.05 * scale);
}

TEST_CASE("poses of the bodies are where the tool and the joints say") {
  const Study planar = config("3rrr.yaml");
  RunResult result = run(planar, 31);
  add_body_poses(planar.mechanism, result);
  const Tool& tool = *planar.mechanism.tool;
  CHECK(result.body_names.size() == planar.mechanism.bodies.size() - 1);
  const Eigen::Index b = tool.body - 1;
  for (Eigen::Index k = 0; k < result.time.size(); ++k) {
    const double angle = result.body_orientation(k, b);
    const Eigen::Vector2d place =
        result.body_position.row(k).segment<2>(2 * b).transpose() + Eigen::Rotation2Dd(angle) * tool.position.head<2>();
    CHECK((place - result.tool_position.row(k).transpose()).norm() < 1e-12);
    CHECK(std::remainder(angle - result.tool_orientation(k, 0), 2 * std::numbers::pi) == doctest::Approx(0));
  }
  const Study spatial = config("delta.yaml");
  RunResult moved = run(spatial, 31);
  add_body_poses(spatial.mechanism, moved);
  const Eigen::Index platform = spatial.mechanism.tool->body - 1;
  for (Eigen::Index k = 0; k < moved.time.size(); ++k) {
    const auto q = moved.body_orientation.row(k).segment<4>(4 * platform);
    const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    const Vector3 place =
        moved.body_position.row(k).segment<3>(3 * platform).transpose() + turn * spatial.mechanism.tool->position;
    CHECK((place - moved.tool_position.row(k).transpose()).norm() < 1e-10);
  }
}

TEST_CASE("planar orientations run on past a half turn") {
  Study study = config("four-bar.yaml");
  RunResult result = run(study, 201);
  add_body_poses(study.mechanism, result);
  double largest = 0;
  for (Eigen::Index k = 1; k < result.time.size(); ++k)
    largest =
        std::max(largest, (result.body_orientation.row(k) - result.body_orientation.row(k - 1)).cwiseAbs().maxCoeff());
  CHECK(largest < 0.3);  // one turn in 201 samples by a smooth law
}

}  // namespace quantities_test
