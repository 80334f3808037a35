#pragma once
/// The proof of a bound over all lengths as a JSON file that can be checked without the program; docs/certificate.md
/// describes it.

#include "balance/interface/files/result_file.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <string>

namespace balance::reports {

/// @param report of a design whose bound has a proof
/// @param objective its text: "added mass"
std::string format_certificate(const DesignReport& report, const std::string& objective,
                               const files::Provenance& description);

}  // namespace balance::reports
