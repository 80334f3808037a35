#pragma once
/// What `balance check` finds, as JSON for programs.

#include "balance/interface/files/json.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/synthesis/verification/formulation_check.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"

#include <string>
#include <vector>

namespace balance {

/// One object with everything of the report.
/// @param verified adds "verification", what verify_json says of it, if not null
std::string check_json(const CheckReport& report, const Mechanism& mechanism, const std::vector<std::string>& warnings,
                       const VerifyReport* verified = nullptr);

// What `balance check` finds, as text for people.

/// What the mechanism is, one property a line, ending with a line feed. A mechanism that cannot be assembled has fewer.
std::string check_text(const CheckReport& report, const Mechanism& mechanism);

// What a comparison of the two formulations found, for people and for programs.

/// A table of the largest differences per trajectory and a line on the conditions, ending with a line feed.
std::string verify_text(const VerifyReport& report);

Json verify_json(const VerifyReport& report);

}  // namespace balance
