// Efforts that are stated over time act at every moment.

#include "arms.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/motion/control/control_law.hpp"

#include <algorithm>
#include <numbers>

using namespace arms;

namespace {

using Interpolation = study::EffortTable::Interpolation;

Controller stated(const std::vector<double>& time, const std::vector<double>& effort,
                  Interpolation interpolation = Interpolation::linear) {
  Controller c = controller(study::ControllerType::open_loop, 1000);
  c.efforts.time = time;
  for (const double u : effort) c.efforts.effort.push_back(all(1, u));
  c.efforts.interpolation = interpolation;
  return c;
}

/// Work by Simpson's rule over samples that are evenly spaced, an even number of steps.
double work(const RunResult& r) {
  const Eigen::Index steps = r.time.size() - 1;
  double sum = 0;
  for (Eigen::Index k = 0; k <= steps; ++k)
    sum += (k == 0 || k == steps ? 1 : k % 2 == 1 ? 4 : 2) * r.torque(k, 0) * r.joint_velocity(k, 0);
  return sum * (r.time[1] - r.time[0]) / 3;
}

}  // namespace

TEST_CASE("under torques that are straight between rows an arm without weight moves by cubics") {
  const Study study = arm("", "0");
  const RunResult r = run(study, "rest", stated({0, 0.4, 1}, {1, -0.5, 0.7}), 41);
  for (Eigen::Index k = 0; k < r.time.size(); ++k) {
    const double t = r.time[k], x = std::min(t, 0.4), y = std::max(t - 0.4, 0.0), a = -1.5 / 0.4, b = 1.2 / 0.6;
    const double turned =
        0.2 + (x * x / 2 + a * x * x * x / 6 + (x + a * x * x / 2) * y - 0.5 * y * y / 2 + b * y * y * y / 6) / inertia;
    // the integration's relative tolerance of 1e-9 a step, some ten steps
    CHECK(r.joint_position(k, 0) == doctest::Approx(turned).epsilon(1e-8));
    CHECK(r.torque(k, 0) == doctest::Approx(t < 0.4 ? 1 + a * t : -0.5 + b * y).epsilon(1e-12));
  }
}

TEST_CASE("the motion does not depend on how often it is sampled") {
  const Study study = arm();
  for (const Interpolation way : {Interpolation::linear, Interpolation::spline}) {
    const Controller c = stated({0, 0.2, 0.5, 0.7, 1}, {8, 12, 3, 9, 11}, way);
    const RunResult few = run(study, "rest", c, 3), many = run(study, "rest", c, 301);
    // of some hundred steps
    CHECK(few.joint_position(2, 0) == doctest::Approx(many.joint_position(300, 0)).epsilon(1e-7));
    CHECK(metric(few, "torque[J]").peak == doctest::Approx(metric(many, "torque[J]").peak).epsilon(1e-3));
  }
}

TEST_CASE("what the torques do is what the energy grows by") {
  const Study study = arm();
  std::vector<double> time, effort;
  for (int k = 0; k <= 10; ++k) time.push_back(0.1 * k), effort.push_back(11 * std::cos(0.3 * k) + 2);
  const RunResult r = run(study, "rest", stated(time, effort, Interpolation::spline), 2001);
  const auto energy = [&](Eigen::Index k) { return r.kinetic_energy(k, 0) + r.potential_energy(k, 0); };
  // Simpson's rule errs by h⁴ (5e-4 s); the integration by 1e-9 a step
  CHECK(work(r) == doctest::Approx(energy(r.time.size() - 1) - energy(0)).epsilon(1e-7));
}

TEST_CASE("torques that are held come to those that are not in proportion to the period") {
  const Study study = arm();
  const std::vector<double> time{0, 0.3, 1}, effort{4, 12, 6};
  const RunResult free = run(study, "rest", stated(time, effort), 11);
  double before = 0;
  for (const double rate : {500.0, 1000.0, 2000.0}) {
    Controller c = stated(time, effort);
    c.efforts.is_held = true;
    c.period = 1 / rate;
    const double off = std::abs(run(study, "rest", c, 11).joint_position(10, 0) - free.joint_position(10, 0));
    CHECK(off > 0);
    if (before > 0) CHECK(before / off == doctest::Approx(2).epsilon(0.05));  // first order in the period
    before = off;
  }
}

TEST_CASE("limits cut stated torques where they cross them, and changes are counted between the turns") {
  Controller c = stated({0, 0.5, 1}, {0, 2, -2});
  c.torque_limit = all(1, 1);
  const control::EffortProfile course(c.efforts, c.torque_limit);
  for (const double crossing : {0.25, 0.625, 0.875}) {
    CHECK(std::any_of(course.knots().begin(), course.knots().end(),
                      [&](double knot) { return std::abs(knot - crossing) < 1e-15; }));
    CHECK(std::abs(course.evaluate(crossing)[0]) == doctest::Approx(1).epsilon(1e-14));
  }
  CHECK(course.evaluate(0.4)[0] == 1);
  CHECK(course.saturation(0.4)[0] == 1);
  CHECK(course.saturation(0.2)[0] == 0);
  CHECK(course.evaluate(2)[0] == -1);
  CHECK(course.total_variation(0, 1)[0] == doctest::Approx(3).epsilon(1e-14));
  CHECK(course.total_variation(0.1, 0.2)[0] == doctest::Approx(0.4).epsilon(1e-14));

  const Study study = arm("", "0");
  const RunResult r = run(study, "rest", c, 21);
  CHECK(metric(r, "torque_variation[J]").peak == doctest::Approx(3).epsilon(1e-12));
  CHECK(metric(r, "torque[J]").peak == doctest::Approx(1).epsilon(1e-14));
  CHECK(metric(r, "saturation[J]").mean == doctest::Approx(0.5).epsilon(0.05));  // the share of time, by samples
}

TEST_CASE("a spline through a cubic's values is that cubic") {
  const auto cubic = [](double t) { return 3 - 2 * t + 4 * t * t - 5 * t * t * t; };
  study::EffortTable table{{0, 0.2, 0.3, 0.7, 1}, {}, Interpolation::spline};
  for (const double t : table.time) table.effort.push_back(all(1, cubic(t)));
  const control::EffortProfile course(table, {});
  for (int k = 0; k <= 20; ++k) CHECK(course.evaluate(0.05 * k)[0] == doctest::Approx(cubic(0.05 * k)).epsilon(1e-13));
}

TEST_CASE("a spec's torques are held where it states a rate, and else are not") {
  const auto read = [](const std::string& more) {
    return controller(arm("controllers: {c: {type: open-loop, table: [[0, 1], [1, 2], [2, 0], [3, 1]]" + more + "}}\n"),
                      "c");
  };
  CHECK(read("").is_continuous());
  CHECK(!read("").is_sampled());
  CHECK(read(", rate: 100").is_sampled());
  CHECK(read(", period: 0.01").efforts.is_held);
  CHECK(read(", interpolation: spline").efforts.interpolation == Interpolation::spline);
}
