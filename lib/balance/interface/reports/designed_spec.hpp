#pragma once
/// The spec of a designed mechanism as it is written.

#include "balance/interface/reports/report_data.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <string>

namespace balance {

struct DesignedSpec {
  std::string text;
  RequestFailure
      refusal;  ///< why the text is no spec of the design; none: it was read back and says the same mechanism
};

/// format_balanced_spec with the laws of adapted numbers, and without the elements that the design leaves out; they stay, with masses of
/// zero, where something else in the spec names them. The text is read back.
DesignedSpec format_designed_spec(const DesignSpace& space, const DesignReport& report);

}  // namespace balance
