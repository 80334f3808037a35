#include "balance/mechanics/results/round_off.hpp"
#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/sample_difference.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/control/closed_loop_run.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>

using namespace balance;
using namespace balance::results;

namespace {

/// A swinging link whose counterweight brings the centre of mass onto the pivot, but for a share `off` of its mass. All masses
/// times `heavy`, all lengths times `large`.
std::string link(double off, double heavy = 1, double large = 1) {
  return fmt::format(R"(
space: planar
gravity: [0, -9.81]
bodies:
  link: {{mass: {0}, com: [{1}, 0], inertia: {2}, points: {{O: [0, 0]}}}}
joints:
  J: {{type: revolute, connects: [ground.origin, link.O]}}
counterweights:
  cw: {{on: link, mass: {3}, at: [{4}, 0]}}
actuators: [J]
motion: {{duration: 1, samples: 101, from: {{joints: {{J: 0.3}}}}, to: {{joints: {{J: 1.9}}}}}}
)",
                     0.7 * heavy, 0.3 * large, 0.02 * heavy * large * large, 2.1 * heavy * (1 + off), -0.1 * large);
}

RunResult run(const std::string& text) {
  const Study study = read_spec(text, "link.yaml");
  const RunResult result = simulate(study.mechanism, study.trajectories.at(0));
  REQUIRE_MESSAGE(result.outcome.status == MotionStatus::done, result.outcome.reason);
  return result;
}

const Metric& figures(const RunResult& result, const std::string& quantity) {
  const auto found = std::find_if(result.metrics.begin(), result.metrics.end(),
                                  [&](const Metric& metric) { return metric.quantity == quantity; });
  REQUIRE(found != result.metrics.end());
  return *found;
}

/// What sums in a unit are made of: weights, inertia forces and motions of the whole mechanism.
double scale_of(const std::string& unit, const Mechanism& mechanism, const RunResult& run) {
  const double length = characteristic_length(mechanism), duration = run.time[run.time.size() - 1] - run.time[0];
  double rate = 0, acceleration = 0;
  for (std::size_t c = 0; c < run.coordinate_units.size(); ++c) {
    const double one = run.coordinate_units[c] == "m" ? length : 1;
    const auto column = static_cast<Eigen::Index>(c);
    rate = std::max(rate, run.joint_velocity.col(column).lpNorm<Eigen::Infinity>() / one);
    acceleration = std::max(acceleration, run.joint_acceleration.col(column).lpNorm<Eigen::Infinity>() / one);
  }
  const double weight =
      total_mass(mechanism) * (mechanism.gravity.norm() + length * std::max(acceleration, rate * rate));
  if (unit == "rad" || unit == "1") return 1;
  if (unit == "m") return length;
  if (unit == "rad/s") return rate;
  if (unit == "m/s") return length * rate;
  if (unit == "rad/s^2") return acceleration;
  if (unit == "m/s^2") return length * acceleration;
  if (unit == "N") return weight;
  if (unit == "W") return weight * length / duration;
  return weight * length;  // N m, J
}

Study config(const std::string& name) { return read_spec_file(std::string(BALANCE_CONFIGS "/") + name); }

}  // namespace

TEST_CASE("what round-off leaves of a balanced force is 0, in figures and samples (D2)") {
  const Study study = config("planar-rrr.yaml");
  const RunResult result = simulate(study.mechanism, study.trajectories.at(0));
  for (const char* quantity : {"shaking_force", "com_velocity", "com_acceleration"}) {
    CAPTURE(quantity);
    const Metric& metric = figures(result, quantity);
    CHECK(metric.peak == 0);
    CHECK(metric.rms == 0);
    CHECK(metric.mean == 0);
    CHECK(metric.range == 0);
    CHECK(metric.peak_time == 0);
    CHECK(metric.round_off > 0);
  }
  CHECK(result.shaking_force.isZero(0));
  CHECK(figures(result, "shaking_moment").peak > 10);
}

TEST_CASE("a small imbalance is no round-off, whatever the units (D2)") {
  // a part in 10⁹ of one mass, on a scale of grams and micrometres and on one of ships
  for (const auto& [heavy, large] : {std::pair{1.0, 1.0}, {1e-15, 1e-6}, {1e9, 1e3}, {1e-30, 1.0}}) {
    CAPTURE(heavy);
    const RunResult balanced = run(link(0, heavy, large)), off = run(link(1e-9, heavy, large));
    CHECK(figures(balanced, "shaking_force").peak == 0);
    CHECK(figures(balanced, "torque[J]").peak > 0);
    const double whole = figures(run(link(1, heavy, large)), "shaking_force").peak;
    CHECK(figures(off, "shaking_force").peak == doctest::Approx(1e-9 * whole).epsilon(1e-4));
  }
}

TEST_CASE("the terms are at least as large as their sum, in every quantity of every kind of run (D2)") {
  const auto check = [](const RunResult& result) {
    REQUIRE_MESSAGE(result.outcome.status == MotionStatus::done, result.outcome.reason);
    for (const Quantity& quantity : list_sampled_quantities(result)) {
      CAPTURE(quantity.name);
      VectorX TermMagnitudes::*const size = term_magnitude_of(quantity.member);
      if (size == nullptr || size == &TermMagnitudes::sliding_variable ||
          quantity.member == &RunResult::torque_variation)
        continue;
      const VectorX& terms = result.term_magnitudes.*size;
      REQUIRE(terms.size() > 0);
      const Eigen::Index columns = quantity.samples->cols(), width = columns / terms.size();
      // Sizes are taken at some hundred moments only, and those of unit quaternions and turns are the unit.
      for (Eigen::Index c = 0; c < columns; ++c)
        CHECK(1.05 * terms[c / width] >= quantity.samples->col(c).cwiseAbs().maxCoeff());
    }
  };
  for (const char* name : {"3rrr.yaml", "delta.yaml", "spring-press.yaml", "scotch-yoke.yaml", "four-bar-in-space.yaml",
                           "geared-five-bar.yaml", "squeezer.yaml", "bricard.yaml"}) {
    CAPTURE(name);
    const Study study = config(name);
    check(simulate(study.mechanism, study.trajectories.at(0)));
    if (std::string(name) == "3rrr.yaml")
      check(verification::simulate_natural(study.mechanism, study.trajectories.at(0)));
  }
  const Study study = config("control-rrr.yaml");
  const auto& controllers = study.controllers;
  const auto law = std::find_if(controllers.begin(), controllers.end(),
                                [](const Controller& controller) { return controller.name == "torque"; });
  REQUIRE(law != controllers.end());
  Trajectory trajectory = study.trajectories.at(0);
  trajectory.samples = 51;
  check(simulate_closed_loop(study.mechanism, trajectory, *law, {}));
}

TEST_CASE("nothing in a run lies between 0 and 1e-12 of what its sums are made of: every config (D2)") {
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS)) {
    if (entry.path().extension() != ".yaml") continue;
    const Study study = read_spec_file(entry.path().string());
    for (Trajectory trajectory : study.trajectories) {
      trajectory.samples = std::min(trajectory.samples, 51L);
      const RunResult run = simulate(study.mechanism, trajectory);
      if (run.outcome.status != MotionStatus::done) continue;
      CAPTURE(entry.path().filename().string());
      CAPTURE(trajectory.name);
      for (const Quantity& quantity : list_sampled_quantities(run)) {
        if (quantity.member == &RunResult::mobility) continue;
        CAPTURE(quantity.name);
        for (Eigen::Index c = 0; c < quantity.samples->cols(); ++c) {
          const std::string& unit = quantity.units[quantity.units.size() == 1 ? 0 : static_cast<std::size_t>(c)];
          const double peak = quantity.samples->col(c).lpNorm<Eigen::Infinity>();
          CHECK((peak == 0 || peak > 1e-12 * scale_of(unit, study.mechanism, run)));
        }
      }
      for (const Metric& metric : run.metrics) {
        CAPTURE(metric.quantity);
        for (const double figure : {metric.peak, metric.rms, metric.mean, metric.range})
          CHECK((figure == 0 || figure > 1e-12 * scale_of(metric.unit, study.mechanism, run)));
      }
    }
  }
}

TEST_CASE("a mechanism that is held has neither rates nor energy of motion, and all of its weight: every config (D2)") {
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS)) {
    if (entry.path().extension() != ".yaml") continue;
    const Study study = read_spec_file(entry.path().string());
    if (study.trajectories.empty()) continue;
    CAPTURE(entry.path().filename().string());
    Trajectory held = study.trajectories.front();
    held.to = held.from;
    held.path = trajectory::LinePath{};
    held.secondary_tasks.clear();
    held.law = {};
    held.samples = 3;
    // in a microsecond as in a year: a rate of a radian in that time has nothing to do with the weight
    Samples weight;
    for (const double duration : {1e-6, 1.0, 3e7}) {
      held.duration = duration;
      RunResult result;
      try {
        result = simulate(study.mechanism, held);
      } catch (const std::invalid_argument&) {
        break;
      }
      if (result.outcome.status != MotionStatus::done) break;
      for (const auto member : {&RunResult::joint_velocity, &RunResult::joint_acceleration, &RunResult::power,
                                &RunResult::com_velocity, &RunResult::com_acceleration, &RunResult::shaking_force,
                                &RunResult::shaking_moment, &RunResult::kinetic_energy})
        CHECK((result.*member).isZero(0));
      const auto& loads = study.mechanism.loads;
      if (std::any_of(loads.begin(), loads.end(), [](const auto& load) { return load.arguments.size() > 1; })) continue;
      if (duration < 1) weight = result.torque;
      CHECK((result.torque - weight).isZero(1e-9 * (1 + weight.norm())));
    }
  }
}

TEST_CASE("natural coordinates find the same zeros (D2)") {
  const Study study = config("planar-rrr.yaml");
  const RunResult result = verification::simulate_natural(study.mechanism, study.trajectories.at(0));
  REQUIRE(result.outcome.status == MotionStatus::done);
  CHECK(figures(result, "shaking_force").peak == 0);
  CHECK(figures(result, "shaking_moment").peak > 10);
}

TEST_CASE("motors that need nothing show nothing (D2)") {
  // a balanced link without inertia about its pivot would need no torque at rest: constant speed instead
  const std::string text = link(0);
  const Study study = read_spec(text + "trajectories: {even: {law: uniform, drive: joints}}\n", "link.yaml");
  const auto even = std::find_if(study.trajectories.begin(), study.trajectories.end(),
                                 [](const Trajectory& trajectory) { return trajectory.name == "even"; });
  REQUIRE(even != study.trajectories.end());
  const RunResult result = simulate(study.mechanism, *even);
  REQUIRE(result.outcome.status == MotionStatus::done);
  for (const char* quantity : {"torque[J]", "power[J]", "shaking_force", "shaking_moment"})
    CHECK(figures(result, quantity).peak == 0);
  CHECK(result.energy == 0);
  CHECK(figures(result, "kinetic_energy").peak > 0);
}

TEST_CASE("curves that differ by round-off only do not differ, and zeros have no ratio (D2)") {
  const Study study = config("planar-rrr.yaml");
  const RunResult one = simulate(study.mechanism, study.trajectories.at(0));
  RunResult other = one;
  other.shaking_force.setConstant(one.round_off.shaking_force[0] / 2);  // another round-off
  for (const auto& [quantity, difference] : comparison::list_differences(one, other)) {
    CAPTURE(quantity);
    CHECK(difference.largest == 0);
    CHECK(difference.rms == 0);
  }
  const comparison::ComparedRuns compared =
      comparison::compare_runs({{"a", "", "", "", "", "", one}, {"b", "", "", "", "", "", other}});
  for (const comparison::ComparedQuantity& quantity : compared.quantities)
    if (quantity.quantity == "shaking_force") CHECK(std::isnan(ratio_to_base(quantity, 1, Statistic::peak)));
}
