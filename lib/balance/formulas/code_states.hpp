#pragma once
/// States at which a program tests itself. Private to formulas.

#include "balance/formulas/symbolic_tree.hpp"

#include <string>
#include <vector>

namespace balance::formulas {

/// Random states, one a row, and the torques there by another route.
struct CodeStates {
  std::vector<std::vector<double>> q, dq, ddq, torque;
  std::string meaning;  ///< a sentence on the coordinates and where the torques of the test come from
};

/// @throws FormulaError
CodeStates code_states(const Mechanism& mechanism, Ring& ring, const SymbolicTree& tree);

/// A name that ends no comment.
std::string plain_title(const std::string& name);

}  // namespace balance::formulas
