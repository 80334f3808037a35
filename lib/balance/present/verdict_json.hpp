#pragma once
/// A verdict as a piece of a JSON document. Private to the writers: it knows the JSON library.

#include "balance/compare/verdict.hpp"
#include "balance/write/json_parts.hpp"

namespace balance {

/// What is no number is null.
Json verdict_json(const RequirementVerdict& verdict);

}  // namespace balance
