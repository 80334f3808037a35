#pragma once
/// Figures that a design must keep to. Private to the readers.

#include "balance/spec/draft.hpp"

namespace balance::read {

/// `peak(torque[A1]) <= 12`, or a list of such.
std::vector<FigureLimit> read_limits(const Cursor& at, Draft& draft);

}  // namespace balance::read
