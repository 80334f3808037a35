#include "yardsticks.hpp"
#include "fixtures.hpp"

#include "balance/mechanics/dynamics/tree_dynamics.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <random>

using namespace balance;
using namespace balance::kinematics;

namespace {

constexpr double exact = 1e-12;  // of the largest: round-off

/// Random states, torques by the yardstick against those of the recursion, relative to the largest.
template <class S, int Joints, class Yardstick>
double farthest_torque(const Mechanism& mechanism, const Yardstick& yardstick) {
  const Tree<S> tree = compile_tree<S>(mechanism, {});
  TreeState<S> state(tree.nodes.size());
  std::vector<dynamics::Wrench<S>> wrenches(tree.nodes.size());
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-4, 4);
  double worst = 0, scale = 0;
  for (int k = 0; k < 100; ++k) {
    double q[Joints], dq[Joints], ddq[Joints], expected[Joints], found[Joints];
    for (int j = 0; j < Joints; ++j) q[j] = any(random), dq[j] = any(random), ddq[j] = any(random);
    dynamics::open_tree_inverse_dynamics<S>(tree, q, dq, ddq, to_vector<S>(mechanism.gravity), state, wrenches,
                                            expected);
    yardstick.torques(q, dq, ddq, found);
    for (int j = 0; j < Joints; ++j) {
      worst = std::max(worst, std::abs(found[j] - expected[j]));
      scale = std::max(scale, std::abs(expected[j]));
    }
  }
  return worst / scale;
}

double farthest(const Samples& result, int column, long row, bench::Plane value) {
  return std::hypot(result(row, column) - value.x, result(row, column + 1) - value.y);
}

}  // namespace

TEST_CASE("the yardsticks of open chains give the torques of the recursion") {
  const Mechanism rrr = bench::planar_rrr(), arm = bench::seven_joint_arm();
  CHECK(farthest_torque<Planar, 3>(rrr, bench::PlanarRrrYardstick(rrr)) <= exact);
  CHECK(farthest_torque<Spatial, 7>(arm, bench::SevenJointYardstick(arm)) <= exact);
}

TEST_CASE("the yardstick of the 3RRR gives what a run along the tool's line finds") {
  const Mechanism mechanism = bench::three_rrr();
  const Trajectory trajectory = bench::three_rrr_cycloid(41);
  const RunResult result = simulate(mechanism, trajectory);
  const bench::ThreeRrrYardstick yardstick(mechanism, {1, 1, 1});
  const Vector3 &from = *trajectory.from.tool, &to = *trajectory.to.tool;
  const double force = result.joint_force.cwiseAbs().maxCoeff(), torque = result.torque.cwiseAbs().maxCoeff();
  const double acceleration = result.joint_acceleration.cwiseAbs().maxCoeff();
  const double near = 1e-11;  // of the largest: what the run's Newton leaves
  for (long k = 0; k < trajectory.samples; ++k) {
    const bench::ThreeRrrMoment m = yardstick.at(static_cast<double>(k) / static_cast<double>(trajectory.samples - 1),
                                                 {from.x(), from.y()}, {to.x(), to.y()}, trajectory.duration);
    CAPTURE(k);
    CHECK(farthest(result.tool_position, 0, k, m.tool) <= near);
    CHECK(farthest(result.com_position, 0, k, m.com) <= near);
    CHECK(farthest(result.shaking_force, 0, k, m.shaking_force) <= near * force);
    CHECK(std::abs(result.shaking_moment(k, 0) - m.shaking_moment) <= near * torque);
    for (int leg = 0; leg < 3; ++leg) {
      const auto& l = m.legs[leg];
      const double alpha[2] = {l.crank_acceleration, l.coupler_acceleration - l.crank_acceleration};
      for (int i = 0; i < 2; ++i)
        CHECK(std::abs(result.joint_acceleration(k, 3 * leg + i) - alpha[i]) <= near * acceleration);
      const bench::Plane forces[3] = {l.force_A, l.force_B, l.force_C};
      for (int i = 0; i < 3; ++i) CHECK(farthest(result.joint_force, 2 * (3 * leg + i), k, forces[i]) <= near * force);
      CHECK(std::abs(result.torque(k, leg) - l.torque) <= near * torque);
      CHECK(std::abs(result.power(k, leg) - l.power) <= near * result.power.cwiseAbs().maxCoeff());
    }
  }
}
