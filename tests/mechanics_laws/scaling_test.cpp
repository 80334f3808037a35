// Lengths from micrometres to a thousand kilometres, masses from micrograms to millions of tonnes: every result by its own power.

#include "runs.hpp"
#include "transforms.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/design/design_study.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace scaling_test {

using namespace laws;
using balance::CoordinateKind;

namespace {

constexpr Units all_corners[] = {{1e-6, 1e-9, 1}, {1e6, 1e9, 1}, {1e-6, 1e9, 1e-3}, {1e6, 1e-9, 1e3}};
constexpr std::span corners = std::span(all_corners).first<4 / fewer>();

bool is_length(const Mechanism& m, long coordinate) { return m.coordinates[coordinate].kind == CoordinateKind::length; }

/// Largest difference of b from a · factor, relative to the largest entry or to `least` (in a's units).
double off(const Samples& a, const Samples& b, double factor, double least) {
  if (a.size() == 0) return b.size() == 0 ? 0 : 1e300;
  const double error = (a * factor - b).cwiseAbs().maxCoeff() / (factor * std::max(a.cwiseAbs().maxCoeff(), least));
  return std::isfinite(error) ? error : 1e300;
}

balance::Study scaled(balance::Study study, const Units& by) {
  const Mechanism mechanism = study.mechanism;
  study.mechanism = laws::scaled({mechanism, {}}, by).mechanism;
  for (balance::Trajectory& t : study.trajectories) t = laws::scaled({mechanism, t}, by).trajectory;
  return study;
}

/// What a free number is multiplied by: its bounds and its start go with it. Parameters stay as they are written.
double unit_of(const std::string& path, const Units& by) {
  const auto has = [&](const char* key) { return path.find(key) != std::string::npos; };
  if (path.rfind("parameters", 0) == 0) return 1;
  if (has(".mass")) return by.mass;
  if (has(".inertia")) return by.mass * by.length * by.length;
  if (has(".stiffness")) return by.mass / (by.time * by.time);
  return has(".ratio") || has(".axis") || has(".rpy") ? 1 : by.length;
}

/// What a spec's expressions say of every number, in another size: its inputs are divided by their units and what they make is scaled.
std::shared_ptr<const balance::study::Recording> scaled(const balance::study::Recording& from, const VectorX& units,
                                                        const Units& by) {
  const auto to = std::make_shared<balance::study::Recording>();
  std::vector<balance::Expression> inputs;
  for (const double value : from.inputs) {
    const auto number = std::find(from.free.begin(), from.free.end(), static_cast<int>(inputs.size()));
    const double unit = number == from.free.end() ? 1 : units[number - from.free.begin()];
    to->inputs.push_back(value * unit);
    inputs.push_back(balance::Expression::input(to->graph, value * unit) / unit);
  }
  to->free = from.free;
  const balance::study::RecordedValues<balance::Expression> values(from, inputs);
  const auto mechanism = values.mechanism();
  to->mechanism = laws::scaled({mechanism, {}}, by).mechanism;
  for (const auto& t : values.trajectories()) to->trajectories.push_back(laws::scaled({mechanism, t}, by).trajectory);
  return to;
}

balance::DesignSpace scaled(const balance::DesignSpace& space, const Units& by) {
  balance::Study start = scaled(space.start, by);
  VectorX units(static_cast<long>(start.free_numbers.size()));
  for (long k = 0; k < units.size(); ++k) {
    balance::FreeNumber& number = start.free_numbers[k];
    units[k] = unit_of(number.key_path, by);
    number.lower *= units[k], number.upper *= units[k], number.start *= units[k];
  }
  return {std::move(start), scaled(*space.recording, units, by)};
}

}  // namespace

TEST_CASE("motions and forces scale over twelve decades of lengths and eighteen of masses") {
  for (const std::string& file : config_names()) {
    const balance::Study study = load(file);
    for (balance::Trajectory trajectory : study.trajectories) {
      trajectory.samples = 11;
      const Run one = run(file + ": " + trajectory.name, study.mechanism, trajectory);
      for (const Units& by : corners) {
        const Experiment there = laws::scaled({study.mechanism, trajectory}, by);
        const Run other = run(one.name + ", scaled", there.mechanism, there.trajectory);
        if (other.result.outcome.status != balance::MotionStatus::done) continue;
        INFO(one.name << ", lengths times " << by.length << ", masses times " << by.mass);
        const RunResult &a = one.result, &b = other.result;
        const auto* stops = std::get_if<balance::trajectory::WaypointPath>(&trajectory.path);
        const double legs = stops == nullptr ? 1 : 1 + static_cast<double>(stops->points.size());
        const double L = one.length(), T = trajectory.duration / legs;
        const double force =
            a.joint_force.cwiseAbs().maxCoeff() + balance::model::total_mass(one.mechanism) * L / (T * T);
        // positions are solved to 1e-12; what follows from them loses the condition of the equations
        const double allowed = 1e-9 / std::min(1.0, 10 * a.mobility.minCoeff());
        for (long c = 0; c < a.joint_position.cols(); ++c) {
          const double here = is_length(one.mechanism, c) ? L : 1, unit = is_length(one.mechanism, c) ? by.length : 1;
          CHECK(off(a.joint_position.col(c), b.joint_position.col(c), unit, here) < allowed);
          CHECK(off(a.joint_velocity.col(c), b.joint_velocity.col(c), unit / by.time, here / T) < allowed);
          CHECK(off(a.joint_acceleration.col(c), b.joint_acceleration.col(c), unit / by.time / by.time, here / T / T) <
                allowed);
        }
        for (long c = 0; c < a.torque.cols(); ++c) {
          const bool slides = a.actuator_units[c] == "N";
          CHECK(off(a.torque.col(c), b.torque.col(c), slides ? by.force() : by.moment(), force * (slides ? 1 : L)) <
                allowed);
        }
        CHECK(off(a.com_position, b.com_position, by.length, L) < allowed);
        CHECK(off(a.tool_position, b.tool_position, by.length, L) < allowed);
        CHECK(off(a.shaking_force, b.shaking_force, by.force(), force) < allowed);
        CHECK(off(a.shaking_moment, b.shaking_moment, by.moment(), force * L) < allowed);
        CHECK(off(a.ground_force, b.ground_force, by.force(), force) < allowed);
        CHECK(off(a.ground_moment, b.ground_moment, by.moment(), force * L) < allowed);
        CHECK(off(a.joint_force, b.joint_force, by.force(), force) < allowed);
        CHECK(off(a.joint_moment, b.joint_moment, by.moment(), force * L) < allowed);
        CHECK(off(a.kinetic_energy, b.kinetic_energy, by.moment(), force * L * 1e-3) < allowed);
        CHECK(off(a.potential_energy, b.potential_energy, by.moment(), force * L) < allowed);
        CHECK(off(a.power, b.power, by.moment() / by.time, force * L / T) < allowed);
        CHECK(off(a.mobility, b.mobility, 1, 1e-3) < allowed);
        CHECK(std::abs(b.energy / by.moment() - a.energy) <= allowed * (a.energy + force * L));
      }
    }
  }
}

TEST_CASE("a check finds the same freedoms, loops and assembly modes in every size") {
  for (const std::string& file : config_names()) {
    const balance::Study study = load(file);
    const balance::CheckReport a = balance::check_mechanism(study);
    // by powers of two, so that the random restarts take the same ways
    for (const Units& by : {Units{0x1p-20, 0x1p-30, 1}, Units{0x1p20, 0x1p30, 1}}) {
      INFO(file << ", lengths times " << by.length);
      const balance::CheckReport b = balance::check_mechanism(scaled(study, by));
      CHECK(a.outcome.status == b.outcome.status);
      CHECK(a.degrees_of_freedom == b.degrees_of_freedom);
      CHECK(a.redundant == b.redundant);
      CHECK(a.passive_freedoms == b.passive_freedoms);
      CHECK(b.total_mass == doctest::Approx(a.total_mass * by.mass).epsilon(1e-12));
      CHECK((b.com / by.length - a.com).norm() < 1e-9 * balance::model::characteristic_length(study.mechanism));
      REQUIRE(a.modes.size() == b.modes.size());
      for (std::size_t c = 0; c < a.start.size(); ++c) {
        const bool slides = is_length(study.mechanism, static_cast<long>(c));
        CHECK(b.start[c] / (slides ? by.length : 1) == doctest::Approx(a.start[c]).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("conditions have the same rank and coefficients that scale with their parameters") {
  for (const std::string& file : config_names()) {
    const Mechanism m = load(file).mechanism;
    std::vector<balance::Goal> goals{{balance::GoalKind::force, false}, {balance::GoalKind::dynamic, false}};
    if (!m.actuators.empty()) goals.push_back({balance::GoalKind::gyroscopic, false});
    for (const balance::Goal& goal : goals) {
      const balance::Conditions a = balance::derive_conditions(m, {goal});
      for (const Units& by : corners) {
        const balance::Conditions b = balance::derive_conditions(laws::scaled({m, {}}, by).mechanism, {goal});
        INFO(file << ", " << goal_name(goal) << ", lengths times " << by.length << ", masses times " << by.mass);
        CHECK(a.status == b.status);
        REQUIRE(a.rank == b.rank);
        REQUIRE(a.pivots == b.pivots);
        const double L = balance::model::characteristic_length(m);
        const auto unit = [&](int p, double length, double spring) {
          const auto& q = a.parameters[static_cast<std::size_t>(p)];
          return std::pow(length, q.length_power) *
                 (q.owner_kind == balance::dynamics::ParameterOwner::spring ? spring : 1);
        };
        for (int r = 0; r < a.rank; ++r)
          for (int p = 0; p < a.matrix.cols(); ++p) {
            const double spring = 1 / (by.time * by.time);
            const double factor = unit(a.pivots[r], by.length, spring) / unit(p, by.length, spring);
            const double here = unit(a.pivots[r], L, 1) / unit(p, L, 1);
            CHECK(std::abs(b.matrix(r, p) / factor - a.matrix(r, p)) <= 1e-9 * (std::abs(a.matrix(r, p)) + here));
          }
      }
    }
  }
}

TEST_CASE("designs find the same numbers in every size") {
  const std::vector<std::string> files = {
      "5r-design.yaml",          "5r-impossible.yaml",          "rr-design.yaml",
      "spatial-rrr-design.yaml", "planar-rrr-design.yaml",      "spring-balancer-one-link.yaml",
      "3rrr-force-balance.yaml", "four-bar-force-balance.yaml", "slider-crank-force-balance.yaml"};
  for (std::size_t i = 0; i < files.size(); i += fewer) {
    const std::string& file = files[i];
    const balance::DesignSpace space = balance::read_design_space_file(BALANCE_CONFIGS "/" + file);
    balance::DesignStudyOptions options;
    options.compare_trajectories = false;
    options.minimize = {};
    const balance::DesignReport a = balance::run_design_study(space, options);
    for (const Units& by : std::span(all_corners).first<2>()) {
      INFO(file << ", lengths times " << by.length << ", masses times " << by.mass);
      const balance::DesignReport b = balance::run_design_study(scaled(space, by), options);
      CHECK(a.outcome.status == b.outcome.status);
      // of a compromise the least misses are met or not by round-off
      if (a.outcome.status == balance::DesignStatus::balanced)
        CHECK(a.outcome.unmet_conditions == b.outcome.unmet_conditions);
      CHECK(a.outcome.optimality == b.outcome.optimality);
      REQUIRE(a.outcome.x.size() == b.outcome.x.size());
      for (long k = 0; k < a.outcome.x.size(); ++k) {
        const balance::FreeNumber& number = a.free_numbers[static_cast<std::size_t>(k)];
        INFO(number.key_path << ": " << a.outcome.x[k] << ", " << b.outcome.x[k]);
        CHECK(std::abs(b.outcome.x[k] / unit_of(number.key_path, by) - a.outcome.x[k]) <=
              1e-7 * (number.upper - number.lower));
      }
      CHECK(b.mass_after == doctest::Approx(a.mass_after * by.mass).epsilon(1e-7));
    }
  }
}

}  // namespace scaling_test
