#pragma once
/// The phase plane of a path as a picture: laws of motion and what limits leave them.

#include "balance/report/plot_picture.hpp"

namespace balance {

/// The rate s' over the place s: the laws, the largest rates that limits leave, and where the path's acceleration jumps. The line of
/// one law tells by its pens which limit is active where.
/// @throws std::invalid_argument if a run has no phase plane; the message says which
Plot plot_phase_plane(const std::vector<PlotRun>& runs);

}  // namespace balance
