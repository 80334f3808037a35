#pragma once
/// Which elements a design keeps, for people and programs.

#include "balance/present/design_view.hpp"
#include "balance/write/json_parts.hpp"

namespace balance {

/// "counterweights: cw1 and cw3 are kept, cw2 is left out", and what is known of the least count; empty without choices.
std::string format_optional_elements(const DesignReport& report);

/// Null without choices.
Json optional_elements_json(const DesignReport& report);

/// What a design leaves out, where it stands in the spec: for format_balanced_spec.
std::vector<OptionalElementText> list_omitted_elements(const DesignReport& report);

}  // namespace balance
