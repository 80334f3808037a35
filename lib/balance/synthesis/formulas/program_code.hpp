#pragma once
/// The torques of a mechanism as a program without loops or calls but sines and cosines.

#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <string>

namespace balance::formulas {

enum class Language { c, python };

struct CodeSize {
  int operations_per_state = 0;  ///< operations, sines and cosines left out
  int operations_once = 0;       ///< of the mechanism's numbers alone
};

/// What a program in C calls a number: its symbol's name unless that is one of the language's words.
std::string c_member_name(const std::string& name);

/// A program in C99 or Python 3 with
///   parameters: the mechanism's numbers, SI; the spec's to begin with,
///   prepare: what depends on these alone,
///   torques: M q̈ + D q̇ q̇ + z of the spanning tree's coordinates,
/// and, where it is run, a test: it prints torques at states that the program holds, with those that the engine has.
/// @throws FormulaError
std::string generate_program(const Mechanism& mechanism, const SpecNumberTexts& texts, Language language,
                             CodeSize* size = nullptr);

}  // namespace balance::formulas
