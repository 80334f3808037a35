#pragma once
/// Who cannot say what payloads mean that are taken up and set down on the way.

#include "balance/study/study.hpp"

#include <string>
#include <vector>

namespace balance {

/// @param what that needs payloads which are always there: "conditions", "a controlled run"
/// @param without names, or the section's, of what does not count there; null: it cannot be left out
/// @throws SpecError at the first that is not
void reject_temporary_payloads(const Study& study, const std::string& what,
                               const std::vector<std::string>* without = nullptr);

}  // namespace balance
