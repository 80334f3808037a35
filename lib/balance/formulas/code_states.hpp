#pragma once
/// States at which a program tests itself, and is tested before it is printed. Private to formulas.

#include "balance/formulas/printed_program.hpp"
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
CodeStates code_states(const Mechanism& mechanism, const SymbolicTree& tree);

/// Compares the program with the engine, at these states and, with other parameters and free numbers, at one of them.
/// @throws FormulaError if they do not agree
void check_program(PrintedProgram program, Ring& ring, const SymbolicTree& tree, const CodeStates& states);

/// A name that ends no comment.
std::string plain_title(const std::string& name);

}  // namespace balance::formulas
