#pragma once
/// The mechanism as the page draws it. Private to the page: it knows the JSON library.

#include "balance/model/mechanism.hpp"
#include "balance/write/json_parts.hpp"

namespace balance {

/// Bodies, joints, attachments, discs, springs and tool with their places; indices as in the mechanism.
Json mechanism_json(const Mechanism& mechanism);

}  // namespace balance
