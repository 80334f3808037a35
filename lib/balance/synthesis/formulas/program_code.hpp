#pragma once
/// The torques of a mechanism as a program without loops that calls only sine, cosine and square root.

#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <string>

namespace balance::formulas {

enum class Language { c, python };

struct CodeSize {
  int operations_per_state = 0;  ///< without functions and divisions
  int operations_once = 0;       ///< on the mechanism's numbers alone
};

/// A number's name in a C program: its symbol's name unless that is a keyword.
std::string c_member_name(const std::string& name);

/// A C99 or Python 3 program with
///   parameters: the mechanism's numbers [SI], initially the spec's,
///   prepare: computes what depends on these alone,
///   torques: M q̈ + D q̇ q̇ + z in the spanning tree's coordinates,
/// and a test when it is run: it compares torques at states stored in the program with those of the engine.
/// @throws FormulaError
std::string generate_program(const Mechanism& mechanism, const study::SpecNumberTexts& texts, Language language,
                             CodeSize* size = nullptr);

}  // namespace balance::formulas
