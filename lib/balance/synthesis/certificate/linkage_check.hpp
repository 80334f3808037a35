#pragma once
/// Whether the polynomials of a linkage state the same problem as the library's own conditions.

#include "balance/synthesis/certificate/box_program.hpp"

#include <optional>

namespace balance::certificate {

/// The least mass at fixed lengths by the conditions that are derived there.
/// @param x all free numbers; those of the counterweights do not matter
/// @return infinite if nothing balances; none if the mechanism cannot be assembled or its conditions are not clear
std::optional<double> compute_min_mass(const DesignSpace& space, const PlanarLinkage& linkage, const VectorX& x);

/// Compares the program of a point with compute_min_mass at random lengths, and the conditions themselves.
/// @return why the polynomials cannot be trusted; empty if they agree
std::string find_disagreement(const DesignSpace& space, const PlanarLinkage& linkage, const VirtualLinkage& dual,
                              const BoxProgram& program, const LengthBox& box);

}  // namespace balance::certificate
