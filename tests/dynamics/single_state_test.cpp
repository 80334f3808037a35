// A single state has what a run has at the moment at which it moves like that.

#include "every_config.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/equation_terms.hpp"
#include "balance/mechanics/dynamics/single_state.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace balance;
using namespace balance::dynamics;

/// Of the terms that a quantity is the sum of: both ways solve the loops to 1e-12 of the length, and rates and forces grow near
/// singularities.
constexpr double state_tolerance = 1e-9;

double size_of(const Quantity& quantity, const RunResult& run) {
  double size = numerics::max_abs(*quantity.samples);
  for (const results::QuantityDefinition& kind : results::quantity_table())
    if (quantity.name == kind.name && kind.terms != nullptr)
      size = std::max(size, numerics::max_abs(run.term_magnitudes.*kind.terms));
  return size;
}

SingleState state_of(const RunResult& run, Eigen::Index row, const std::vector<CoordinateId>& independent) {
  SingleState state;
  state.time = run.time[row];
  for (Eigen::Index c = 0; c < run.joint_position.cols(); ++c) {
    const CoordinateId id(static_cast<int>(c));
    state.configuration.push_back({id, run.joint_position(row, c)});
    if (std::find(independent.begin(), independent.end(), id) == independent.end()) continue;
    state.rates.push_back({id, run.joint_velocity(row, c)});
    state.accelerations.push_back({id, run.joint_acceleration(row, c)});
  }
  return state;
}

void compare(const Mechanism& mechanism, const Trajectory& trajectory, std::mt19937& draws) {
  const RunResult run = simulate(mechanism, trajectory);
  if (run.outcome.status != MotionStatus::done) return;
  const InverseOptions options{
      .independent = {}, .about = trajectory.about, .time_scale = run.time[run.time.size() - 1]};
  for (int draw = 0; draw < 3; ++draw) {
    // not the last one: payloads that are set down at the end are there until then
    const auto row = static_cast<Eigen::Index>(draws() % static_cast<unsigned>(run.time.size() - 1));
    CAPTURE(run.time[row]);
    const EquationTerms terms(mechanism_at_time(mechanism, run.time[row]), options);
    const RunResult state = evaluate_single_state(mechanism, state_of(run, row, terms.independent()), options);
    REQUIRE_MESSAGE(state.outcome.status == MotionStatus::done, state.outcome.reason);
    for (const Quantity& quantity : list_sampled_quantities(run)) {
      if (quantity.name == "mobility") continue;  // of another drive
      CAPTURE(quantity.name);
      const Samples& got = state.*quantity.member;
      REQUIRE(got.cols() == quantity.samples->cols());
      const VectorX is = got.row(0), was = quantity.samples->row(row);
      const bool turn = quantity.columns == results::ColumnKind::quaternion;  // a quaternion's sign means nothing
      const double off =
          turn ? std::min(numerics::max_abs(is - was), numerics::max_abs(is + was)) : numerics::max_abs(is - was);
      CHECK(off <= state_tolerance * size_of(quantity, run));
    }
  }
}

}  // namespace

TEST_CASE("a single state has what a run has at the moment at which it moves like that") {
  std::mt19937 draws(31);
  for (const std::string& file : doors::every_config()) {
    const balance::Study study = balance::read_spec_file(file);
    for (balance::Trajectory trajectory : study.trajectories) {
      if (is_mechanism_dependent(trajectory.law.kind))
        continue;  // takes long, and is a motion like others once it is found
      CAPTURE(file);
      CAPTURE(trajectory.name);
      trajectory.samples = 51;
      compare(study.mechanism, trajectory, draws);
    }
  }
}

TEST_CASE("a state without efforts has everything else, and a note") {
  balance::Study study = doors::config("rr.yaml");
  const balance::RunResult whole = balance::simulate(study.mechanism, study.trajectories.front());
  balance::Mechanism idle = study.mechanism;
  idle.actuators.clear();
  const InverseOptions options{.independent = {"R1", "R2"}};
  std::vector<balance::CoordinateId> both{0, 1};
  const SingleState state = state_of(whole, whole.time.size() / 3, both);
  const balance::RunResult driven = evaluate_single_state(study.mechanism, state, options),
                           left = evaluate_single_state(idle, state, options);
  REQUIRE(left.outcome.status == balance::MotionStatus::done);
  CHECK(left.torque.size() == 0);
  CHECK(left.outcome.notes.back().starts_with("no torques: "));
  // no term differs
  CHECK(left.shaking_force == driven.shaking_force);
  CHECK(left.shaking_moment == driven.shaking_moment);
  CHECK(left.joint_force == driven.joint_force);
}

TEST_CASE("rates of a coordinate that is not independent are refused") {
  const balance::Study study = doors::config("5r.yaml");
  SingleState state;
  state.configuration = study.mechanism.assembly;
  for (std::size_t c = 0; c < study.mechanism.coordinates.size(); ++c)
    if (study.mechanism.coordinates[c].name == "B1") state.rates.push_back({static_cast<int>(c), 1.0});
  REQUIRE(state.rates.size() == 1);
  CHECK_THROWS_AS(evaluate_single_state(study.mechanism, state), std::invalid_argument);
}
