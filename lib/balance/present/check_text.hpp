#pragma once
/// What `balance check` finds, as text for people.

#include "balance/analysis/check.hpp"
#include "balance/model/mechanism.hpp"

#include <string>

namespace balance {

/// What the mechanism is, one property a line, ending with a line feed. A mechanism that cannot be assembled has fewer.
std::string check_text(const CheckReport& report, const Mechanism& mechanism);

}  // namespace balance
