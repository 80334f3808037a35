#pragma once
/// Conditions and designs with everything that is told about them, gathered from a spec.

#include "balance/interface/reports/balance_request.hpp"
#include "balance/interface/reports/design_sections.hpp"
#include "balance/motion/study/design_space.hpp"

#include <string>

namespace balance {

/// Why a mechanism cannot have what was asked: no conditions, no design.
struct RequestFailure {
  std::string status;  ///< "not-assembled", "mismatch", "overflow", …; empty: it is not refused
  std::string reason;  ///< one sentence

  explicit operator bool() const { return !status.empty(); }
};

struct ConditionsOutcome {
  RequestFailure refusal;
  ConditionsReportData view;  ///< means something unless refused
};

/// The conditions of the goals with the names of their coefficients, judged with the numbers that the study holds.
/// @param named whether coefficients get the names of the lengths that they are made of
ConditionsOutcome derive_conditions_data(const BalanceRequest& question, const DesignSpace& space, bool named = true);

/// Why a design has no numbers to show.
RequestFailure find_failure(const DesignReport& report);

/// @param options that the design was made with
/// @param balanced the text of the designed spec
/// @param report one that is not refused
DesignReportData make_design_data(const DesignStudyOptions& options, const DesignSpace& space,
                                  const std::string& balanced, DesignReport report);

}  // namespace balance
