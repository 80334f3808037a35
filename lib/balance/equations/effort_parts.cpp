#include "balance/equations/effort_parts.hpp"

#include "balance/equations/run_states.hpp"

#include <array>
#include <utility>

namespace balance {

namespace {

/// In the order of EffortPart.
constexpr std::array part_members{&Result::torque_inertia, &Result::torque_velocity, &Result::torque_friction,
                                  &Result::torque_weight,  &Result::torque_spring,   &Result::torque_load};
static_assert(part_members.size() == effort_part_names.size());

}  // namespace

MotionOutcome add_effort_parts(const Mechanism& mechanism, Result& result) {
  InverseOptions options;
  if (const double duration = result.time[result.time.size() - 1] - result.time[0]; duration > 0)
    options.time_scale = duration;
  EquationTerms terms(mechanism, options);
  const StateTable states = independent_states(terms, result);
  for (const auto member : part_members) (result.*member).resize(result.torque.rows(), result.torque.cols());
  MotionOutcome outcome = assemble_as(terms, result);
  for (Eigen::Index k = 0; k < states.q.rows() && outcome.status == MotionStatus::done; ++k) {
    auto split = terms.split(states.q.row(k), states.dq.row(k), states.ddq.row(k), result.time[k]);
    outcome = std::move(split.outcome);
    if (outcome.status != MotionStatus::done) break;
    for (std::size_t part = 0; part < part_members.size(); ++part)
      (result.*part_members[part]).row(k) = split.value.parts.col(static_cast<Eigen::Index>(part));
  }
  if (outcome.status != MotionStatus::done)
    for (const auto member : part_members) (result.*member).resize(0, 0);
  return outcome;
}

}  // namespace balance
