#pragma once
/// The torques of a mechanism as a program that calls only sine, cosine and square root. Without loops of the mechanism,
/// the program has no branches either.

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

/// The shortest decimal text of a number.
std::string shortest_decimal(double value);

/// What a program of a mechanism with loops takes.
enum class ProgramCoordinates {
  independent,  ///< the independent coordinates; the program closes the loops
  all,          ///< all coordinates of the spanning tree, which close the loops
};

struct ProgramOptions {
  ProgramCoordinates coordinates = ProgramCoordinates::independent;
  std::vector<std::string> independent = {};  ///< names of coordinates; empty: a choice
  std::vector<CoordinateValue> start = {};    ///< near which the loops close; empty: the mechanism's assembly
};

/// A C99 or Python 3 program with
///   parameters: the mechanism's numbers [SI], initially the spec's,
///   prepare: computes what depends on these alone,
///   torques: of the motors, without loops M q̈ + D q̇ q̇ + z in the spanning tree's coordinates,
/// and a test when it is run: it compares torques at states stored in the program with those of the engine. With loops,
/// torques are Cᵀ (M ÿ + D ẏ ẏ + z) with ÿ = C q̈ + Ċ q̇ (P0 eq. 38), distributed to the motors as the engine does.
/// Constraints on speeds leave a program of the tree alone.
/// @throws FormulaError
std::string generate_program(const Mechanism& mechanism, const study::SpecNumberTexts& texts, Language language,
                             CodeSize* size = nullptr, const ProgramOptions& options = {});

}  // namespace balance::formulas
