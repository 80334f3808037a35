#pragma once
/// Several mechanisms as one.

#include "balance/model/mechanism.hpp"

namespace balance {

/// Mechanisms on one ground that do not touch each other: one after the other in every list, names as they are. Space and gravity are
/// the first one's, and so is the tool. What must vanish for all motions of the whole must vanish for all motions of each.
/// @throws std::invalid_argument if there is none, or if space or gravity differ
Mechanism disjoint_union(const std::vector<Mechanism>& mechanisms);

}  // namespace balance
