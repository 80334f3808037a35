#pragma once
/// What `balance check` finds, as JSON for programs.

#include "balance/analysis/check.hpp"
#include "balance/analysis/verify.hpp"
#include "balance/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance {

/// One object with everything of the report.
/// @param verified adds "verification", what verify_json says of it, if not null
std::string check_json(const CheckReport& report, const Mechanism& mechanism, const std::vector<std::string>& warnings,
                       const VerifyReport* verified = nullptr);

}  // namespace balance
