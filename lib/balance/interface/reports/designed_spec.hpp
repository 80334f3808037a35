#pragma once
/// The spec of a designed mechanism.

#include "balance/interface/reports/report_data.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <string>

namespace balance::reports {

struct DesignedSpec {
  std::string text;
  RequestFailure refusal;  ///< why the text does not give the design; none: read back, it gives the same mechanism
};

/// format_balanced_spec() with the laws of adapted numbers, and without the elements that the design leaves out; these
/// stay, with zero mass, if something else in the spec refers to them. Reads the text back.
DesignedSpec format_designed_spec(const DesignSpace& space, const DesignReport& report);

}  // namespace balance::reports
