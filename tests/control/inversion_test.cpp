// Forward dynamics is the inverse of inverse dynamics: every config, also with springs, loads and friction, at random states.

#include "plant_cases.hpp"

#include "balance/mechanics/dynamics/forward_dynamics.hpp"

#include <random>

using namespace plants;

namespace {

/// Through a random state near the start: the actuated coordinates q₀ + v t + a t²/2, which a cubic spline meets exactly.
Trajectory through_random_state(const Study& study, const Known& start, std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  Trajectory trajectory = study.trajectories.at(0);
  trajectory.drive = DriveKind::joints;
  trajectory.components.clear(), trajectory.remaining_coordinates.clear();
  trajectory.from = trajectory.to = {};
  trajectory.samples = 2;
  const double length = characteristic_length(study.mechanism);
  trajectory::TablePath table;
  table.time = {0, 1e-3, 2e-3, 3e-3};
  table.values.resize(4);
  for (const int c : study.mechanism.actuators) {
    const double unit = study.mechanism.coordinates[c].kind == CoordinateKind::length ? length : 1;
    const double q = start.q[c] + 0.1 * unit * number(random), v = 3 * unit * number(random);
    const double a = 20 * unit * number(random);
    trajectory.from.joints.push_back({c, q});
    for (std::size_t k = 0; k < 4; ++k) {
      const double t = table.time[k];
      table.values[k].push_back(q + v * t + a * t * t / 2);
    }
  }
  trajectory.duration = 3e-3;
  trajectory.path = table;
  return trajectory;
}

/// Coulomb friction is the sign of the speed on both sides only beyond its width.
bool clear_of_friction_width(const Mechanism& mechanism, const VectorX& dq) {
  for (const Friction& friction : mechanism.friction)
    if (std::abs(dq[friction.coordinate]) < 2e-3) return false;
  return true;
}

/// Largest difference of the accelerations against the largest acceleration of the same kind.
double miss(const Mechanism& mechanism, const VectorX& found, const VectorX& right) {
  double worst = 0;
  for (const CoordinateKind kind : {CoordinateKind::angle, CoordinateKind::length}) {
    double error = 0, size = 0;
    for (Eigen::Index c = 0; c < right.size(); ++c) {
      if (mechanism.coordinates[c].kind != kind) continue;
      error = std::max(error, std::abs(found[c] - right[c]));
      size = std::max(size, std::abs(right[c]));
    }
    if (size > 0) worst = std::max(worst, error / size);
  }
  return worst;
}

/// With some of everything that acts on a mechanism.
Mechanism burdened(Mechanism mechanism, std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  const double length = characteristic_length(mechanism), mass = total_mass(mechanism);
  const auto anywhere = [&] {
    return Vector3(Vector3(number(random), number(random), mechanism.space == SpaceKind::planar ? 0 : number(random)) *
                   length);
  };
  const int last = static_cast<int>(mechanism.bodies.size()) - 1;
  mechanism.springs.push_back({"s", 0, last, anywhere(), anywhere(), 50 * mass, 0.1 * length});
  mechanism.springs.push_back({"z", 1, last == 1 ? 0 : last, anywhere(), anywhere(), 30 * mass, 0});
  const int turned = mechanism.actuators.back();
  mechanism.springs.push_back({.name = "t", .stiffness = 5 * mass, .preload = 2 * mass, .coordinate = turned});
  const Vector3 moment = mechanism.space == SpaceKind::planar ? Vector3(0, 0, 1) : Vector3(0.3, -0.5, 1);
  mechanism.loads.push_back(
      {"b", last, anywhere(), model::Frame::body, {}, {10 * mass * anywhere() / length}, {moment}});
  mechanism.loads.push_back({"w",
                             1,
                             anywhere(),
                             model::Frame::world,
                             {0, 1},
                             {mass * anywhere() / length, Vector3::Zero()},
                             {moment, -moment}});
  for (const int c : mechanism.actuators)
    mechanism.friction.push_back(
        {.coordinate = c, .viscous = 0.1 * mass, .coulomb = 0.2 * mass, .coulomb_backward = 0.3 * mass});
  mechanism.attachments.push_back(
      {"cargo", AttachmentKind::payload, last, 0.1 * anywhere(), 0.3 * mass, Matrix3::Zero()});
  return mechanism;
}

}  // namespace

TEST_CASE("forward dynamics gives back the accelerations whose efforts inverse dynamics found") {
  std::mt19937 random(6);
  int tried = 0;
  for (const std::string& file : specs()) {
    CAPTURE(file);
    Study study = config(file);
    const Known start = moment_of(study, 0);
    const Mechanism plain = study.mechanism;
    for (int k = 0; k < 4; ++k) {
      study.mechanism = k % 2 == 0 ? plain : burdened(plain, random);
      Trajectory trajectory = through_random_state(study, start, random);
      const RunResult result = simulate(study.mechanism, trajectory);
      if (result.outcome.status != MotionStatus::done) continue;
      const Known state = known(result, 0);
      if (!clear_of_friction_width(study.mechanism, state.dq)) continue;
      ++tried;
      CAPTURE(k);
      dynamics::ForwardDynamics forward(study.mechanism);
      const MotionOutcome outcome = forward.set_state(state.time, state.q, state.dq);
      REQUIRE_MESSAGE(outcome.status == MotionStatus::done, outcome.reason);
      CHECK(forward.freedoms() <= static_cast<int>(study.mechanism.actuators.size()));
      CHECK(miss(study.mechanism, forward.acceleration(state.efforts), state.ddq) < 1e-9);
      Plant plant(study.mechanism);
      REQUIRE(plant.start(state.time, state.q, state.dq).status == MotionStatus::done);
      CHECK(miss(study.mechanism, plant.acceleration(state.efforts), state.ddq) < 1e-9);
    }
  }
  MESSAGE(tried << " random states");
  CHECK(tried > 100);
}

TEST_CASE("along every trajectory the plant feels what the inverse dynamics says that it exerts") {
  for (const std::string& file : specs()) {
    CAPTURE(file);
    const Study study = config(file);
    Trajectory trajectory = study.trajectories.at(0);
    trajectory.samples = 7;
    const RunResult result = simulate(study.mechanism, trajectory);
    REQUIRE(result.outcome.status == MotionStatus::done);
    Plant plant(study.mechanism, {}, trajectory.about);
    for (long row = 1; row < 6; row += 2) {
      const Known state = known(result, row);
      if (!clear_of_friction_width(study.mechanism, state.dq)) continue;
      REQUIRE(plant.start(state.time, state.q, state.dq).status == MotionStatus::done);
      const Sample& seen = plant.observe(state.efforts);
      const auto close = [&](const Vector3& a, const Samples& all, int axes) {
        double worst = 0;
        for (int i = 0; i < axes; ++i) {
          const double b = all(row, i);
          worst = std::max(worst, std::abs(a[axes == 1 ? 2 : i] - b));
        }
        return worst <= 1e-8 * std::max(1e-3, all.cwiseAbs().maxCoeff());
      };
      CHECK(close(seen.com, result.com_position, result.axes));
      CHECK(close(seen.com_velocity, result.com_velocity, result.axes));
      CHECK(close(seen.shaking_force, result.shaking_force, result.axes));
      CHECK(close(seen.ground_force, result.ground_force, result.axes));
      CHECK(close(seen.shaking_moment, result.shaking_moment, result.moment_axes));
      CHECK(close(seen.ground_moment, result.ground_moment, result.moment_axes));
      CHECK(std::abs(seen.kinetic_energy - result.kinetic_energy(row, 0)) <=
            1e-9 * result.kinetic_energy.cwiseAbs().maxCoeff());
      double reaction = 0;
      for (Eigen::Index c = 0; c < result.joint_force.cols(); ++c)
        reaction = std::max(reaction,
                            std::abs(seen.joint_force[c / result.axes][c % result.axes] - result.joint_force(row, c)));
      if (result.outcome.notes.empty()) CHECK(reaction <= 1e-8 * result.joint_force.cwiseAbs().maxCoeff());
    }
  }
}
