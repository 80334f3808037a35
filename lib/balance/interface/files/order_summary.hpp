#pragma once
/// Orders of a run (mechanics/results/orders.hpp) as text, JSON and HDF5: one row per order of a scalar, of a vector and of
/// each of its components.

#include "balance/foundation/hdf5/hdf5_writer.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/mechanics/results/orders.hpp"

#include <string>

namespace balance::files {

/// Efforts, shaking forces and moments, or everything if options.verbose; without orders that are round-off or less than a
/// millionth of the largest.
std::string format_orders(const results::OrderAnalysis& analysis, const TextOptions& options);

/// {coordinate, speed, turns, rows: [{quantity, component, unit, order, mean, cosine, sine, amplitude, phase, forward,
/// backward, share}], fluctuation: {mean_torque, energy_range, coefficient, largest, smallest, flywheel}}.
Json orders_json(const results::OrderAnalysis& analysis);

/// Writes the group `orders`.
void write_orders(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group parent, const results::OrderAnalysis& analysis);

}  // namespace balance::files
