// Forces are linear in the inertial parameters.

#include "random_mechanisms.hpp"
#include "runs.hpp"

#include "balance/mechanics/dynamics/inertia_regressor.hpp"

#include <doctest/doctest.h>

#include <random>

using namespace laws;

namespace {

/// At random coordinates, velocities and accelerations of all tree coordinates, loops left open.
template <class S>
void check_linear(const std::string& name, const Mechanism& mechanism, std::mt19937& random) {
  using namespace balance;
  const kinematics::Tree<S> tree = kinematics::compile_tree<S>(mechanism, {});
  std::uniform_real_distribution<double> uniform(-2, 2);
  for (int trial = 0; trial < 5; ++trial) {
    VectorX y(tree.columns), dy(tree.columns), ddy(tree.columns), tau(tree.columns);
    for (VectorX* v : {&y, &dy, &ddy})
      for (double& x : *v) x = uniform(random);
    kinematics::TreeState<S> state(tree.nodes.size());
    compute_poses(tree, y.data(), state);
    compute_velocities(tree, dy.data(), state);
    kinematics::compute_accelerations<S>(tree, dy.data(), ddy.data(), -kinematics::to_vector<S>(mechanism.gravity),
                                         state);
    std::vector<dynamics::Wrench<S>> wrenches(tree.nodes.size());
    inverse_dynamics(tree, state, wrenches, tau.data());
    const VectorX pi = dynamics::list_inertial_parameters<S>(tree);
    const dynamics::InertiaRegressor<S> Y = dynamics::compute_regressor<S>(tree, state);
    REQUIRE(Y.torque.cols() == pi.size());
    const auto near = [&](const VectorX& got, const VectorX& want, const MatrixX& rows) {
      const double scale = (rows.cwiseAbs() * pi.cwiseAbs()).maxCoeff();  // what cancels on the way
      CHECK_MESSAGE((got - want).cwiseAbs().maxCoeff() < 1e-13 * scale, name << ": " << (got - want).transpose());
    };
    near(Y.torque * pi, tau, Y.torque);
    near(Y.force * pi, wrenches[0].force, Y.force);
    if constexpr (std::is_same_v<S, kinematics::Planar>)
      near(Y.moment * pi, VectorX::Constant(1, wrenches[0].moment), Y.moment);
    else
      near(Y.moment * pi, wrenches[0].moment, Y.moment);
  }
}

}  // namespace

TEST_CASE("the regressor of random mechanisms too") {
  std::mt19937 random(11);
  for (std::uint32_t seed = 1; seed <= 20; ++seed)
    for (const balance::SpaceKind space : {balance::SpaceKind::planar, balance::SpaceKind::spatial})
      if (const auto experiment = random_experiment(space, seed)) {
        if (space == balance::SpaceKind::planar)
          check_linear<balance::kinematics::Planar>(experiment->mechanism.name, experiment->mechanism, random);
        else
          check_linear<balance::kinematics::Spatial>(experiment->mechanism.name, experiment->mechanism, random);
      }
}

TEST_CASE("the regressor times the inertial parameters gives the recursion's torques, force and moment") {
  std::mt19937 random(20240601);
  for (const std::string& file : config_names()) {
    const Mechanism mechanism = load(file).mechanism;
    if (mechanism.space == balance::SpaceKind::planar)
      check_linear<balance::kinematics::Planar>(file, mechanism, random);
    else
      check_linear<balance::kinematics::Spatial>(file, mechanism, random);
  }
}

namespace {

/// All masses and inertias multiplied, one by one.
void multiply(Mechanism& m, const std::vector<double>& by) {
  std::size_t k = 0;
  for (std::size_t b = 1; b < m.bodies.size(); ++b, ++k) m.bodies[b].mass *= by[k], m.bodies[b].inertia *= by[k];
  for (auto& extra : m.attachments) extra.mass *= by[k], extra.inertia *= by[k], ++k;
  for (auto& disc : m.discs) disc.mass *= by[k], disc.inertia *= by[k], ++k;
}

std::size_t parts(const Mechanism& m) { return m.bodies.size() - 1 + m.attachments.size() + m.discs.size(); }

void without_other_forces(Mechanism& m) {
  m.loads.clear(), m.springs.clear(), m.force_elements.clear(), m.friction.clear();
}

}  // namespace

TEST_CASE(
    "with twice one body's mass and inertia, its share of every effort and of the shaking force is added once more") {
  // two bodies made heavier together must add what each adds alone
  std::mt19937 random(7);
  for (const std::string& file : config_names()) {
    const balance::Study study = load(file);
    balance::Trajectory trajectory = study.trajectories.front();
    if (trajectory.drive == balance::DriveKind::com) continue;  // there masses change the motion
    trajectory.samples = 41;
    Mechanism base = study.mechanism;
    without_other_forces(base);
    const std::size_t n = parts(base);
    std::vector<double> a(n, 1), b(n, 1), both(n, 1);
    const std::size_t i = random() % n, j = n == 1 ? 0 : (i + 1 + random() % (n - 1)) % n;
    a[i] += 1, b[j] += 2, both[i] += 1, both[j] += 2;
    std::vector<Run> runs;
    for (const auto& by : {std::vector<double>(n, 1), a, b, both}) {
      Mechanism m = base;
      multiply(m, by);
      runs.push_back(run(file, m, trajectory));
      if (runs.back().result.outcome.status != balance::MotionStatus::done) return;
    }
    const auto open = [&](Samples RunResult::*what) {
      const Samples sum = runs[1].result.*what + runs[2].result.*what - runs[0].result.*what;
      return (sum - runs[3].result.*what).cwiseAbs().maxCoeff();
    };
    const double force = force_scale(runs[3], cloud(runs[3])) + balance::model::total_mass(base) * base.gravity.norm();
    CHECK_MESSAGE(open(&RunResult::shaking_force) < 1e-10 * force, file);
    CHECK_MESSAGE(open(&RunResult::shaking_moment) < 1e-10 * force * runs[0].length(), file);
    CHECK_MESSAGE(open(&RunResult::torque) <
                      1e-10 * (force * std::max(1.0, runs[0].length()) + runs[3].result.torque.cwiseAbs().maxCoeff()),
                  file);
  }
}
