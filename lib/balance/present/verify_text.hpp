#pragma once
/// What a comparison of the two formulations found, for people and for programs.

#include "balance/analysis/verify.hpp"
#include "balance/write/json_parts.hpp"

#include <string>

namespace balance {

/// A table of the largest differences per trajectory and a line on the conditions, ending with a line feed.
std::string verify_text(const VerifyReport& report);

Json verify_json(const VerifyReport& report);

}  // namespace balance
