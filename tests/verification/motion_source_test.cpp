/// The two sources of motion behind one interface: a tree's recursions and natural coordinates, which share nothing below it.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/dynamics/tree_motion_source.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"
#include "balance/synthesis/verification/natural_motion_source.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace balance;
using namespace balance::verification;

namespace {

/// Largest difference, in units of the largest value of the first, or of one if that is larger.
double difference(const Samples& a, const Samples& b) {
  REQUIRE(a.rows() == b.rows());
  REQUIRE(a.cols() == b.cols());
  return a.size() == 0 ? 0 : (a - b).cwiseAbs().maxCoeff() / std::max(1.0, a.cwiseAbs().maxCoeff());
}

void compare_sources(const Mechanism& mechanism, const Trajectory& trajectory) {
  const NaturalStart start = find_natural_start(mechanism, trajectory);
  REQUIRE(start.outcome.status == MotionStatus::done);
  const kinematics::CompiledMotion<kinematics::Planar> motion(mechanism, trajectory);
  dynamics::TreeMotionSource<kinematics::Planar> tree(mechanism, motion, trajectory.about, dynamics::Detail::all);
  natural::NaturalMotionSource points(mechanism, trajectory, start.start);
  REQUIRE(tree.outcome().status == MotionStatus::done);
  const double duration = tree.prescribed_motion().duration();
  CHECK(points.prescribed_motion().jump_times() == tree.prescribed_motion().jump_times());
  std::vector<double> times;
  for (int k = 0; k <= 40; ++k) times.push_back(duration * k * k / 1500.0);  // uneven, and beyond the end
  const trajectory::MotionTable a = sample_motion(mechanism, tree, times), b = sample_motion(mechanism, points, times);
  CHECK(a.outcome.status == MotionStatus::done);
  CHECK(b.outcome.status == MotionStatus::done);
  // as in agreement_test.cpp
  CHECK(difference(a.position, b.position) <= 1e-9);
  CHECK(difference(a.velocity, b.velocity) <= 1e-9);
  CHECK(difference(a.acceleration, b.acceleration) <= 1e-9);
  CHECK(difference(a.tool_position, b.tool_position) <= 1e-9);
  CHECK(difference(a.tool_angle, b.tool_angle) <= 1e-9);
  for (std::size_t body = 0; body < mechanism.bodies.size(); ++body) {
    CAPTURE(mechanism.bodies[body].name);
    const auto id = static_cast<BodyId>(body);
    const Vector3 point(0.1, -0.2, 0);
    CHECK(tree.angular_speed(id) == doctest::Approx(points.angular_speed(id)).epsilon(1e-7));
    CHECK(tree.point_speed(id, point) == doctest::Approx(points.point_speed(id, point)).epsilon(1e-7));
  }
}

}  // namespace

TEST_CASE("a tree and natural coordinates move a mechanism through the same configurations, one interface for both") {
  int compared = 0;
  for (const std::string file : {"3rrr", "5r", "four-bar", "slider-crank", "whitworth", "scotch-yoke", "planar-rrr"}) {
    const Study study = read_spec_file(BALANCE_CONFIGS "/" + file + ".yaml");
    for (const Trajectory& trajectory : study.trajectories) {
      if (is_mechanism_dependent(trajectory)) continue;
      CAPTURE(file);
      CAPTURE(trajectory.name);
      compare_sources(study.mechanism, trajectory);
      ++compared;
    }
  }
  CHECK(compared >= 14);
}
