// A mass on a line, whose fastest motions are known in closed form.

#include "slider.hpp"

#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace balance;
using namespace balance::time_optimal;
using namespace balance::trajectory;

namespace {

constexpr double distance = 0.6, force = 30, mass = 2;

double fastest(const Mechanism& mechanism, const Trajectory& trajectory) {
  const ResolvedTrajectory timed = resolve_trajectory(mechanism, trajectory);
  INFO(timed.outcome.reason);
  REQUIRE(timed.outcome.status == MotionStatus::done);
  return timed.trajectory.duration;
}

/// With accelerations a and −b between rest and rest: T² = 2 d (1/a + 1/b).
double bang_bang(double a, double b) { return std::sqrt(2 * distance * (1 / a + 1 / b)); }

}  // namespace

TEST_CASE("a mass under a limited force goes by bang-bang") {
  const ResolvedTrajectory timed =
      resolve_trajectory(make_slider({.mass = mass}), slide(distance, {{"force[D]", force}}));
  REQUIRE(timed.outcome.status == MotionStatus::done);
  const double a = force / mass;
  CHECK(timed.trajectory.duration == doctest::Approx(bang_bang(a, a)).epsilon(1e-9));
  REQUIRE(timed.optimised_law->switch_times.size() == 1);
  CHECK(timed.optimised_law->switch_times[0] == doctest::Approx(timed.trajectory.duration / 2).epsilon(1e-8));
  REQUIRE(timed.optimised_law->active_limits.size() == 2);
  CHECK(timed.optimised_law->active_limits[0].limit == "force[D]");
}

TEST_CASE("weight and dry friction take their part of the force") {
  const double g = 4, f = 3;
  const double up = (force - f) / mass - g, down = (force + f) / mass + g;
  const Mechanism slider = make_slider({.mass = mass, .gravity = g, .coulomb = f});
  CHECK(fastest(slider, slide(distance, {{"torque", force}})) == doctest::Approx(bang_bang(up, down)).epsilon(1e-9));
}

TEST_CASE("viscous friction is met by its own closed form") {
  // m v' = ± F − k v; with the rate r = k/m and the speeds ± F/k that it tends to, v and the way are exponentials
  const double k = 5, r = k / mass, limit = force / k;
  const auto way = [&](double t1) {
    const double v = limit * (1 - std::exp(-r * t1)), x1 = limit * t1 - v / r;
    const double t2 = std::log(1 + v / limit) / r;
    return std::pair{x1 + (v + limit) / r * (1 - std::exp(-r * t2)) - limit * t2, t1 + t2};
  };
  double low = 0, high = 10;
  for (int i = 0; i < 200; ++i) ((way((low + high) / 2).first < distance) ? low : high) = (low + high) / 2;
  const Mechanism slider = make_slider({.mass = mass, .viscous = k});
  CHECK(fastest(slider, slide(distance, {{"torque", force}})) == doctest::Approx(way(low).second).epsilon(1e-9));
}

TEST_CASE("a limit of the speed makes a trapezoid") {
  const double a = force / mass, v = 1.5;
  const double expected = distance / v + v / a;
  for (const char* speed :
       {"joint_velocity", "joint_velocity[D]", "tool_velocity", "com_velocity", "tool_velocity[x]"}) {
    CAPTURE(speed);
    const Trajectory trajectory = slide(distance, {{"torque", force}, {speed, v}});
    const ResolvedTrajectory timed = resolve_trajectory(make_slider({.mass = mass}), trajectory);
    INFO(timed.outcome.reason);
    REQUIRE(timed.outcome.status == MotionStatus::done);
    CHECK(timed.trajectory.duration == doctest::Approx(expected).epsilon(1e-9));
    CHECK(timed.optimised_law->switch_times.size() == 2);
  }
  const Trajectory by_energy = slide(distance, {{"torque", force}, {"kinetic_energy", 0.5 * mass * v * v}});
  CHECK(fastest(make_slider({.mass = mass}), by_energy) == doctest::Approx(expected).epsilon(1e-9));
}

TEST_CASE("accelerations, forces and reactions of one mass are the same limit") {
  const double a = force / mass, expected = bang_bang(a, a);
  for (const MotionLimit& limit :
       {MotionLimit{"joint_acceleration", a}, MotionLimit{"tool_acceleration", a}, MotionLimit{"com_acceleration", a},
        MotionLimit{"shaking_force", force}, MotionLimit{"shaking_force[x]", force}, MotionLimit{"ground_force", force},
        MotionLimit{"force[D]", force}}) {
    CAPTURE(limit.quantity);
    CHECK(fastest(make_slider({.mass = mass}), slide(distance, {limit})) == doctest::Approx(expected).epsilon(1e-9));
  }
}

TEST_CASE("stated speeds at the ends are met") {
  const double a = force / mass, v0 = 1, v1 = 2;
  Trajectory trajectory = slide(distance, {{"torque", force}});
  trajectory.start_speed = v0;
  trajectory.end_speed = v1;
  const double top = std::sqrt((2 * a * distance + v0 * v0 + v1 * v1) / 2);  // (v² − v0²)/2a + (v² − v1²)/2a = d
  const Mechanism slider = make_slider({.mass = mass});
  CHECK(fastest(slider, trajectory) == doctest::Approx((2 * top - v0 - v1) / a).epsilon(1e-9));
  trajectory.samples = 11;
  const RunResult run = simulate(slider, trajectory);
  REQUIRE(run.outcome.status == MotionStatus::done);
  CHECK(run.joint_velocity(0, 0) == doctest::Approx(v0).epsilon(1e-9));
  CHECK(run.joint_velocity(10, 0) == doctest::Approx(v1).epsilon(1e-9));
  trajectory.end_speed = 5;  // √(1 + 2 · 15 · 0.6) = 4.36 is what can be reached
  CHECK(resolve_trajectory(slider, trajectory).outcome.status == MotionStatus::limits_not_held);
  trajectory.end_speed = 0;
  trajectory.start_speed = 5;
  CHECK(resolve_trajectory(slider, trajectory).outcome.status == MotionStatus::limits_not_held);
}

TEST_CASE("the gentlest law of one mass is bang-bang, with weight, too") {
  for (const double g : {0.0, 4.0}) {
    CAPTURE(g);
    Trajectory trajectory = slide(distance, {});
    trajectory.law.kind = MotionLawKind::min_peak;
    trajectory.min_peak_quantity = "torque";
    trajectory.duration = 0.3;
    const ResolvedTrajectory timed = resolve_trajectory(make_slider({.mass = mass, .gravity = g}), trajectory);
    INFO(timed.outcome.reason);
    REQUIRE(timed.outcome.status == MotionStatus::done);
    // T² = 2 d (1/(f/m − g) + 1/(f/m + g)) = 4 d (f/m)/((f/m)² − g²)
    const double p = 2 * distance / (0.3 * 0.3);
    CHECK(timed.optimised_law->objective_value == doctest::Approx(mass * (p + std::sqrt(p * p + g * g))).epsilon(1e-8));
    CHECK(timed.trajectory.duration == 0.3);
  }
}

TEST_CASE("a law that has time enough is slackened, and its peak is that of rest") {
  Trajectory trajectory = slide(distance, {});
  trajectory.law.kind = MotionLawKind::min_peak;
  trajectory.min_peak_quantity = "torque";
  trajectory.duration = 1e6;
  const ResolvedTrajectory timed = resolve_trajectory(make_slider({.mass = mass, .gravity = 4}), trajectory);
  INFO(timed.outcome.reason);
  REQUIRE(timed.outcome.status == MotionStatus::done);
  CHECK(timed.optimised_law->objective_value == doctest::Approx(8).epsilon(1e-5));
  CHECK(timed.trajectory.duration == 1e6);
}

TEST_CASE("other limits are kept by a gentlest law, or it says what they need") {
  Trajectory trajectory = slide(distance, {{"joint_velocity", 2.5}});
  trajectory.law.kind = MotionLawKind::min_peak;
  trajectory.min_peak_quantity = "torque";
  trajectory.duration = 0.3;
  // trapezoid: T = d/v + v/a
  const ResolvedTrajectory timed = resolve_trajectory(make_slider({.mass = mass}), trajectory);
  INFO(timed.outcome.reason);
  REQUIRE(timed.outcome.status == MotionStatus::done);
  CHECK(timed.optimised_law->objective_value == doctest::Approx(mass * 2.5 / (0.3 - distance / 2.5)).epsilon(1e-8));
  trajectory.duration = 0.2;  // 0.24 s at full speed
  const ResolvedTrajectory refused = resolve_trajectory(make_slider({.mass = mass}), trajectory);
  CHECK(refused.outcome.status == MotionStatus::limits_not_held);
  CHECK(refused.outcome.reason.find("the other limits alone need 0.24") != std::string::npos);
}

TEST_CASE("what cannot be is refused with its reason") {
  const Mechanism heavy = make_slider({.mass = mass, .gravity = 10});
  const auto reason = [&](const Trajectory& trajectory) {
    return resolve_trajectory(heavy, trajectory).outcome.reason;
  };
  CHECK(reason(slide(distance, {{"torque", 15}})).find("force[D] needs 20 N at rest, 5 N more than its limit") !=
        std::string::npos);
  CHECK(reason(slide(distance, {{"joint_velocity", 1}})).find("no limit bounds the acceleration") != std::string::npos);
  CHECK(reason(slide(distance, {{"torque", 20}})).find("leave no way to") != std::string::npos);
  CHECK(reason(slide(0, {{"torque", 40}})) == "the path ends where it begins, and nothing moves on it");
  CHECK(reason(slide(1e-16, {{"torque", 40}})) == "the path ends where it begins, and nothing moves on it");
  CHECK_THROWS_WITH_AS(resolve_trajectory(heavy, slide(distance, {{"power", 5}})),
                       "no law of motion can limit 'power' of this mechanism", std::invalid_argument);
}
