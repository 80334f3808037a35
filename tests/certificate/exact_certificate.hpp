#pragma once
// Certificates checked in rational arithmetic: nothing of the library but the polynomials and the multipliers.

#include "balance/synthesis/certificate/length_bound.hpp"
#include "balance/synthesis/certificate/length_geometry.hpp"

#include <string>

/// Why a certificate does not prove its bound for the geometry's linkage; empty if it does.
std::string find_flaw(const balance::LengthCertificate& certificate,
                      const balance::certificate::LengthGeometry& geometry);
