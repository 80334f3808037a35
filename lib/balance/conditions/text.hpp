#pragma once
/// Linear combinations of parameters as a designer reads them.

#include "balance/dynamics/parameter.hpp"

#include <string>
#include <vector>

namespace balance {

/// "link1.mx + 0.5 link2.m - 2 link3.J"; coefficients below round-off are left out; "0" if none is left.
/// @param coefficients one per parameter
std::string linear_combination_text(const std::vector<Parameter>& parameters, const VectorX& coefficients);

}  // namespace balance
