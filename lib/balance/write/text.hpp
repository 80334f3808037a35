#pragma once
/// Results and checks as text for people.

#include "balance/model/mechanism.hpp"
#include "balance/study/check.hpp"
#include "balance/study/result.hpp"
#include "balance/write/write_options.hpp"

#include <string>

namespace balance {

/// One line on what was run, then a table of the metrics, six significant digits, ending with a line feed.
std::string summary_text(const Result& result, const FileDescription& description);

/// What the mechanism is, one property a line, ending with a line feed. A mechanism that cannot be assembled has fewer.
std::string check_text(const CheckReport& report, const Mechanism& mechanism);

}  // namespace balance
