#pragma once
/// The bound over all lengths in a design's outputs.

#include "balance/foundation/hdf5/hdf5_writer.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/synthesis/certificate/length_bound.hpp"

#include <optional>
#include <string>

namespace balance::reports {

/// "the proof covers all lengths within the bounds, A–B–C–D as a parallelogram included", and what it does not cover;
/// empty if nothing is bounded.
std::string length_coverage_text(const certificate::LengthBound& bound);

/// Null without a bound.
Json length_bound_json(const std::optional<certificate::LengthBound>& bound);

/// Writes the group `length_bound`; nothing if nothing is bounded.
void add_length_bound(hdf5::Hdf5Writer& file, const certificate::LengthBound& bound);

}  // namespace balance::reports
