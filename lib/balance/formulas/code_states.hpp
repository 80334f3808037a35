#pragma once
/// States at which a program tests itself, and is tested before it is printed. Private to formulas.

#include "balance/formulas/printed_program.hpp"
#include "balance/formulas/symbolic_tree.hpp"

#include <string>
#include <vector>

namespace balance::formulas {

/// Random states, one a row, and the torques there by another route.
struct SelfTestStates {
  std::vector<std::vector<double>> q, dq, ddq, torque;
  std::string meaning;  ///< a sentence on the coordinates and where the torques of the test come from
};

/// @throws FormulaError
SelfTestStates make_self_test_states(const Mechanism& mechanism, const SymbolicTree& tree);

/// Compares the program with the engine, at these states and, with other parameters and free numbers, at one of them.
/// @throws FormulaError if they do not agree
void check_program(ProgramInterpreter program, Ring& ring, const SymbolicTree& tree, const SelfTestStates& states);

/// A name that ends no comment.
std::string comment_safe_title(const std::string& name);

}  // namespace balance::formulas
