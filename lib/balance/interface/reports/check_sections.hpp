#pragma once
/// Results of `balance check` as JSON and as text.

#include "balance/interface/files/json.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/synthesis/verification/formulation_check.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"

#include <string>
#include <vector>

namespace balance::reports {

/// One object with the whole report.
/// @param verification adds "verification", the comparison of the two formulations, if not null
Json check_json(const CheckReport& report, const Mechanism& mechanism, const std::vector<std::string>& warnings,
                const verification::VerifyReport* verification = nullptr);

// Results of `balance check` as text.

/// Properties of the mechanism, one per line, ending with a line feed. A mechanism that cannot be assembled has fewer;
/// what there is none of is left out unless verbose. Lines to paste into the spec are in its own units.
std::string check_text(const CheckReport& report, const Mechanism& mechanism, const files::TextOptions& options = {});

// Comparison of the two formulations as text.

/// A table of the largest differences per trajectory and a line on the conditions, ending with a line feed.
std::string verify_text(const verification::VerifyReport& report, const files::TextOptions& options = {});

}  // namespace balance::reports
