#pragma once
/// The fastest way along a leg by arcs at the edge of what the limits allow. Private to timing.

#include "balance/timing/fastest.hpp"

#include <vector>

namespace balance {

/// @param bounds one per row of the model
/// @return nodes from the leg's begin to its end, t from zero; or a refusal
TimeOptimalLaw integrate_phase_plane(const PathModel& model, const std::vector<double>& bounds, const SegmentRange& leg,
                                     const EndpointRates& rates);

}  // namespace balance
