#pragma once
/// Holds formulas in natural coordinates against the second formulation. Private to formulas.

#include "balance/formulas/sheet.hpp"

#include <map>
#include <string>

namespace balance::formulas {

/// Mass matrix and C_P by label, as printed, against those of the second formulation; the constraints at its points, where they
/// must vanish; their Jacobian against differences, which are exact for what is quadratic.
/// @param names values of all names there; those of points are put in
/// @param coordinates of all joints, with the loops closed
/// @return the largest error, as part of what is of its kind
double max_natural_error(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                         const Mechanism& mechanism, std::map<std::string, double> names, const VectorX& coordinates);

}  // namespace balance::formulas
