// Shaking force and moment against the motion of points of mass.

#include "runs.hpp"

#include <doctest/doctest.h>

#include <numeric>

namespace momentum_test {

using namespace laws;

namespace {

Total sum(const std::vector<Total>& parts) {
  Total out;
  for (const Total& part : parts) out.force += part.force, out.moment += part.moment;
  return out;
}

/// Positions good to 1e-12 of the size make second differences on 401 samples good to about 1e-6; badly conditioned mechanisms
/// and those that hurry get a margin.
constexpr double tolerance = 3e-5;

}  // namespace

TEST_CASE("the shaking force is the rate of linear momentum and the shaking moment that of angular momentum") {
  for_each_run(401, [](const Run& run) {
    const Cloud points = cloud(run);
    const double scale = force_scale(run, points), length = run.length() + run.result.moment_reference.norm();
    Worst force, moment;
    for (long k = 0; k < run.samples(); ++k) {
      if (!run.smooth[k]) continue;
      const Total want = sum(momentum_rates(run, points, k));
      force.see((run.row(run.result.shaking_force, k) - want.force).norm() / scale, k);
      const Vector3 about = want.moment - run.result.moment_reference.cross(want.force);
      moment.see((run.moment(run.result.shaking_moment, k) - about).norm() / (scale * length), k);
    }
    CHECK_MESSAGE(force.error < tolerance, run.name << " sample " << force.sample << ": " << force.error);
    CHECK_MESSAGE(moment.error < tolerance, run.name << " sample " << moment.sample << ": " << moment.error);
  });
}

TEST_CASE("the centre of mass is that of all moving points, and its velocity and acceleration are its rates") {
  for_each_run(401, [](const Run& run) {
    const Cloud points = cloud(run);
    const double mass = std::accumulate(points.mass.begin(), points.mass.end(), 0.0), h = run.step();
    CHECK(balance::model::total_mass(run.mechanism) == doctest::Approx(mass).epsilon(1e-12));
    double v = 1e-9 * run.length() / h / 400, a = force_scale(run, points) / mass;
    Worst place, velocity, acceleration;
    for (long k = 0; k < run.samples(); ++k) v = std::max(v, run.row(run.result.com_velocity, k).norm());
    v += a * h * 40;  // a centre of mass at rest has nothing to be compared with
    for (long k = 0; k < run.samples(); ++k) {
      Vector3 com = Vector3::Zero();
      for (std::size_t i = 0; i < points.mass.size(); ++i)
        com += points.mass[i] / mass * points.place(k, static_cast<long>(i));
      place.see((run.row(run.result.com_position, k) - com).norm() / run.length(), k);
      if (!run.smooth[k]) continue;
      for (long i = 0; i < run.result.axes; ++i) {
        velocity.see(std::abs(rate(run.result.com_position, k, i, h) - run.result.com_velocity(k, i)) / v, k);
        acceleration.see(
            std::abs(second_rate(run.result.com_position, k, i, h) - run.result.com_acceleration(k, i)) / a, k);
      }
    }
    CHECK_MESSAGE(place.error < 1e-10, run.name << " sample " << place.sample << ": " << place.error);
    CHECK_MESSAGE(velocity.error < tolerance, run.name << " sample " << velocity.sample << ": " << velocity.error);
    CHECK_MESSAGE(acceleration.error < tolerance,
                  run.name << " sample " << acceleration.sample << ": " << acceleration.error);
  });
}

TEST_CASE("the frame feels weight and loads less the rate of momentum") {
  // All of it is algebra on the same numbers, but points were walked to through joints that are closed to 1e-12.
  for_each_run(101, [](const Run& run) {
    const Cloud points = cloud(run);
    const double rest = 1e-3 * force_scale(run, points);  // at rest nothing may be felt at all
    Worst force, moment;
    for (long k = 0; k < run.samples(); ++k) {
      const Total weight = sum(weights(run, points, k)), load = sum(loads(run, k));
      const Vector3 shake = run.row(run.result.shaking_force, k), about = run.result.moment_reference;
      const double scale = rest + shake.norm() + weight.force.norm() + load.force.norm();
      force.see((run.row(run.result.ground_force, k) - weight.force - load.force + shake).norm() / scale, k);
      const Vector3 outside = weight.moment + load.moment - about.cross(weight.force + load.force);
      const Vector3 inside = run.moment(run.result.shaking_moment, k);
      const double turn = inside.norm() + outside.norm() + scale * run.length();
      moment.see((run.moment(run.result.ground_moment, k) - outside + inside).norm() / turn, k);
    }
    CHECK_MESSAGE(force.error < 1e-10, run.name << " sample " << force.sample << ": " << force.error);
    CHECK_MESSAGE(moment.error < 1e-10, run.name << " sample " << moment.sample << ": " << moment.error);
  });
}

}  // namespace momentum_test
