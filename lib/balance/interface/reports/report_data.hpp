#pragma once
/// Report data of conditions and designs, computed from a spec.

#include "balance/interface/reports/balance_request.hpp"
#include "balance/interface/reports/design_sections.hpp"
#include "balance/motion/study/design_space.hpp"

#include <string>

namespace balance::reports {

/// Why a request has no result: no conditions, no design.
struct RequestFailure {
  std::string status;  ///< "not-assembled", "mismatch", "overflow", …; empty: no failure
  std::string reason;  ///< one sentence

  explicit operator bool() const { return !status.empty(); }
};

struct ConditionsOutcome {
  RequestFailure refusal;
  ConditionsReportData view;  ///< valid unless refused
};

/// Derives the conditions of the goals, names their coefficients and evaluates them for the study's numbers.
/// @param with_names whether to name coefficients after the lengths in them
ConditionsOutcome derive_conditions_data(const BalanceRequest& request, const DesignSpace& space,
                                         bool with_names = true);

/// Why a design has no numbers to show, if it has none.
RequestFailure find_failure(const DesignReport& report);

/// @param options those of the design
/// @param balanced the text of the designed spec
/// @param report one without a failure
DesignReportData make_design_data(const DesignStudyOptions& options, const DesignSpace& space,
                                  const std::string& balanced, DesignReport report);

}  // namespace balance::reports
