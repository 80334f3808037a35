#pragma once
/// Holds a printed regressor against the engine's. Private to formulas.

#include "balance/formulas/sheet.hpp"
#include "balance/inverse/inverse_dynamics.hpp"

#include <map>
#include <string>

namespace balance::formulas {

/// One state of the tree and of the engine.
struct RegressorState {
  std::vector<double> y;  ///< per column, at which the loops are closed
  VectorX dy, ddy;        ///< per column
  MatrixX B;  ///< rates of the columns by those of the engine's independent coordinates, all of them actuated
  VectorX q, rate, acceleration;  ///< the engine's state
};

/// @param texts by label, as printed; labels that are missing count as what they stand for
/// @return the largest difference of BᵀY from the engine's regressor, as a part of what is added up; NaN if the engine has none
double max_regressor_error(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                           InverseDynamics& engine, const RegressorState& state);

}  // namespace balance::formulas
