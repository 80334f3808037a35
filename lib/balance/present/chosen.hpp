#pragma once
/// Which elements a design keeps, for people and programs.

#include "balance/present/design_view.hpp"
#include "balance/write/json_parts.hpp"

namespace balance {

/// "counterweights: cw1 and cw3 are kept, cw2 is left out", and what is known of the least count; empty without choices.
std::string chosen_text(const DesignReport& report);

/// Null without choices.
Json chosen_json(const DesignReport& report);

/// What a design leaves out, where it stands in the spec: for balanced_spec.
std::vector<OfferedElement> left_out(const DesignReport& report);

}  // namespace balance
