#pragma once
/// Equations of motion at random states, whose rank is that of the mechanism, not of one motion.

#include "balance/synthesis/identification/regression.hpp"

#include <cstdint>
#include <vector>

namespace balance::identification {

/// Rows over all unknowns.
struct ProbeRows {
  MatrixX measured;        ///< of the channels
  MatrixX shaking_force;   ///< without weight
  MatrixX shaking_moment;  ///< about the world's origin
  MatrixX weight;          ///< of the efforts at rest
};

/// @param states as measured: random configurations are near them
/// @param records whose payloads are carried in their states
ProbeRows probe(MotionEquations& equations, const std::vector<UnknownParameter>& unknowns,
                const std::vector<Channel>& channels, const std::vector<MeasuredStates>& states,
                const std::vector<MeasurementRecord>& records, std::uint64_t seed);

/// Sets columns that are round-off beside those of the same unit to zero, in the rows of the channels and in others.
void clear_negligible_columns(const std::vector<UnknownParameter>& unknowns, ProbeRows& probes, MatrixX& rows);

}  // namespace balance::identification
