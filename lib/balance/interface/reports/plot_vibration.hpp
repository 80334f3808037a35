#pragma once
/// Pictures of a sweep: frequencies of the modes with the lines of the orders (Campbell diagram), growth, amplitudes of
/// every order, transmissibility.

#include "balance/interface/reports/plot.hpp"
#include "balance/interface/reports/vibration_sections.hpp"

namespace balance::reports {

/// One panel each, over the values of the sweep; without driven joints that turn, frequencies and growth alone. Circles are
/// exact amplitudes, lines linear ones.
/// @param view with a sweep
Plot plot_sweep(const VibrationReportData& view, const specification::SpecUnits& units = {});

}  // namespace balance::reports
