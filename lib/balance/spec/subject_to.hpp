#pragma once
/// Figures that a design must keep to. Private to the readers.

#include "balance/spec/draft.hpp"

namespace balance::specification {

/// `peak(torque[A1]) <= 12`, or a list of such.
std::vector<FigureLimit> read_figure_limits(const SpecCursor& at, StudyBuilder& draft);

}  // namespace balance::specification
