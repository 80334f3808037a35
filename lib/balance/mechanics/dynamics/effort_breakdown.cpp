#include "balance/mechanics/dynamics/effort_breakdown.hpp"

#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <array>
#include <stdexcept>
#include <utility>

namespace balance::dynamics {

namespace {

/// In the order of EffortPart.
constexpr std::array part_members{&RunResult::torque_inertia, &RunResult::torque_velocity, &RunResult::torque_friction,
                                  &RunResult::torque_weight,  &RunResult::torque_spring,   &RunResult::torque_load};
static_assert(part_members.size() == effort_part_names.size());

/// Half-open range of samples of a run.
struct Rows {
  Eigen::Index begin, end;
};

/// @param mechanism with the payloads attached in these rows
MotionOutcome add_parts(const Mechanism& mechanism, const InverseOptions& options, Rows rows, RunResult& result) {
  EquationTerms terms(mechanism, options);
  const StateTable states = extract_independent_states(terms, result);
  MotionOutcome outcome = assemble_at_row(terms, result, rows.begin);
  const bool must_reassemble =
      has_velocity_constraints(mechanism);  // the independent coordinates do not determine the others
  for (Eigen::Index k = rows.begin; k < rows.end && outcome.status == MotionStatus::done; ++k) {
    if (must_reassemble) outcome = assemble_at_row(terms, result, k);
    if (outcome.status != MotionStatus::done) break;
    auto split = terms.split_efforts(states.q.row(k), states.dq.row(k), states.ddq.row(k), result.time[k]);
    outcome = std::move(split.outcome);
    if (outcome.status != MotionStatus::done) break;
    for (std::size_t part = 0; part < part_members.size(); ++part)
      (result.*part_members[part]).row(k) = split.value.parts.col(static_cast<Eigen::Index>(part));
  }
  return outcome;
}

}  // namespace

MotionOutcome add_effort_breakdown(const Mechanism& mechanism, RunResult& result) {
  InverseOptions options;
  const Eigen::Index samples = result.time.size();
  const double duration = result.time[samples - 1] - result.time[0];
  if (duration > 0) options.time_scale = duration;
  for (const auto member : part_members) (result.*member).resize(result.torque.rows(), result.torque.cols());
  const model::PayloadIntervals payload_intervals(mechanism, duration);
  MotionOutcome outcome;
  Rows rows{0, 0};
  for (int k = 0; k < payload_intervals.count(); ++k) {
    rows.begin = rows.end;
    while (rows.end < samples && payload_intervals.index_at(result.time[rows.end]) == k) ++rows.end;
    if (rows.begin < rows.end)
      outcome = add_parts(mechanism_in_interval(mechanism, payload_intervals, k), options, rows, result);
    if (outcome.status != MotionStatus::done) break;
  }
  if (outcome.status != MotionStatus::done)
    for (const auto member : part_members) (result.*member).resize(0, 0);
  for (const auto member : part_members) clear_round_off(member, result);
  return outcome;
}

StateTable extract_independent_states(const EquationTerms& terms, const RunResult& result) {
  if (result.joint_position.cols() != static_cast<Eigen::Index>(terms.mechanism().coordinates.size()))
    throw std::invalid_argument("the run's coordinates are not those of the mechanism");
  StateTable states;
  const auto d = static_cast<Eigen::Index>(terms.independent().size());
  for (Samples* all : {&states.q, &states.dq, &states.ddq}) all->resize(result.joint_position.rows(), d);
  for (Eigen::Index k = 0; k < d; ++k) {
    const int c = terms.independent()[static_cast<std::size_t>(k)];
    states.q.col(k) = result.joint_position.col(c);
    states.dq.col(k) = result.joint_velocity.col(c);
    states.ddq.col(k) = result.joint_acceleration.col(c);
  }
  return states;
}

MotionOutcome assemble_at_row(EquationTerms& terms, const RunResult& result, Eigen::Index row) {
  std::vector<CoordinateValue> guess;
  for (Eigen::Index c = 0; c < result.joint_position.cols(); ++c)
    guess.push_back({static_cast<int>(c), result.joint_position(row, c)});
  return terms.assemble(extract_independent_states(terms, result).q.row(row), guess).outcome;
}

}  // namespace balance::dynamics
