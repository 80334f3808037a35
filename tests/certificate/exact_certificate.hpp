#pragma once
// Certificates checked in rational arithmetic: nothing of the library but the polynomials and the multipliers.

#include "balance/synthesis/certificate/length_bound.hpp"

#include <string>

/// Why multipliers do not prove a bound on a box for the geometry's linkage; empty if they do.
std::string find_flaw(const balance::certificate::LengthBox& box, double bound,
                      const balance::certificate::BoxCertificate& multipliers,
                      const balance::certificate::LengthGeometry& geometry);

std::string find_flaw(const balance::certificate::LengthCertificate& certificate,
                      const balance::certificate::LengthGeometry& geometry);

/// Why the steps do not prove a bound for all lengths of their geometry; empty if they do.
std::string find_flaw(const balance::certificate::GeometryProof& proof, double bound);
