#include "balance/equations/effort_parts.hpp"

#include "balance/equations/run_states.hpp"
#include "balance/model/payload_stretches.hpp"
#include "balance/result/round_off.hpp"

#include <array>
#include <utility>

namespace balance {

namespace {

/// In the order of EffortPart.
constexpr std::array part_members{&Result::torque_inertia, &Result::torque_velocity, &Result::torque_friction,
                                  &Result::torque_weight,  &Result::torque_spring,   &Result::torque_load};
static_assert(part_members.size() == effort_part_names.size());

/// Samples of a run from one up to another.
struct Rows {
  Eigen::Index begin, end;
};

/// @param mechanism as it is in these rows
MotionOutcome add_parts(const Mechanism& mechanism, const InverseOptions& options, Rows rows, Result& result) {
  EquationTerms terms(mechanism, options);
  const StateTable states = independent_states(terms, result);
  MotionOutcome outcome = assemble_as(terms, result, rows.begin);
  const bool anew = binds_rates(mechanism);  // the independent coordinates then do not tell the others
  for (Eigen::Index k = rows.begin; k < rows.end && outcome.status == MotionStatus::done; ++k) {
    if (anew) outcome = assemble_as(terms, result, k);
    if (outcome.status != MotionStatus::done) break;
    auto split = terms.split(states.q.row(k), states.dq.row(k), states.ddq.row(k), result.time[k]);
    outcome = std::move(split.outcome);
    if (outcome.status != MotionStatus::done) break;
    for (std::size_t part = 0; part < part_members.size(); ++part)
      (result.*part_members[part]).row(k) = split.value.parts.col(static_cast<Eigen::Index>(part));
  }
  return outcome;
}

}  // namespace

MotionOutcome add_effort_parts(const Mechanism& mechanism, Result& result) {
  InverseOptions options;
  const Eigen::Index samples = result.time.size();
  const double duration = result.time[samples - 1] - result.time[0];
  if (duration > 0) options.time_scale = duration;
  for (const auto member : part_members) (result.*member).resize(result.torque.rows(), result.torque.cols());
  const PayloadStretches stretches(mechanism, duration);
  MotionOutcome outcome;
  Rows rows{0, 0};
  for (int k = 0; k < stretches.count(); ++k) {
    rows.begin = rows.end;
    while (rows.end < samples && stretches.from(result.time[rows.end]) == k) ++rows.end;
    if (rows.begin < rows.end) outcome = add_parts(within(mechanism, stretches, k), options, rows, result);
    if (outcome.status != MotionStatus::done) break;
  }
  if (outcome.status != MotionStatus::done)
    for (const auto member : part_members) (result.*member).resize(0, 0);
  for (const auto member : part_members) clear_round_off(member, result);
  return outcome;
}

}  // namespace balance
