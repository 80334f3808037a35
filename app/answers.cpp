#include "answers.hpp"

#include "failure.hpp"

#include "balance/answers/designed_spec.hpp"
#include "balance/base/error.hpp"

#include <stdexcept>
#include <utility>

namespace balance::app {

ConditionsReportData derive_conditions_or_throw(const GoalOptions& goal, const DesignSpace& space, bool named) {
  ConditionsOutcome answer = derive_conditions_data(make_balance_query(goal, space.start), space, named);
  if (answer.refusal) throw MechanismFailure(answer.refusal.status, answer.refusal.reason);
  return std::move(answer.view);
}

DesignReport design_or_throw(const DesignSpace& space, const DesignStudyOptions& options) {
  try {
    DesignReport report = run_design_study(space, options);
    if (const RequestFailure refusal = find_failure(report)) throw MechanismFailure(refusal.status, refusal.reason);
    return report;
  } catch (const std::invalid_argument& error) {
    // The library was asked something that the spec should not have asked.
    throw SpecError({.place = {.file = space.start.spec_file, .key = "design"}, .message = error.what()});
  }
}

std::string designed_spec_or_throw(const DesignSpace& space, const DesignReport& report) {
  DesignedSpec spec = format_designed_spec(space, report);
  if (spec.refusal) throw MechanismFailure(spec.refusal.status, spec.refusal.reason);
  return std::move(spec.text);
}

}  // namespace balance::app
