#pragma once
/// One design for several loads: the spec once for every load case, with numbers that all cases share and numbers of each case's own.

#include "balance/study/design_space.hpp"

#include <string>
#include <vector>

namespace balance {

struct CaseSpace {
  std::vector<DesignSpace> cases;   ///< at the loads of the cases; all with the same free numbers
  std::vector<FreeNumber> numbers;  ///< of the whole: those that all share, then case by case the adapted ones
  std::vector<std::vector<int>> variable_index;  ///< per case and free number of the spec: its place among `numbers`

  /// Values of a case's free numbers. @param x of `numbers`
  VectorX values(std::size_t which, const VectorX& x) const;
  VectorX start_values() const;
  /// The space where only the numbers `kept` are free and the others stay at x.
  CaseSpace fix_others(const VectorX& x, const std::vector<int>& kept) const;
};

/// @param space its study has load cases
CaseSpace make_case_space(const DesignSpace& space);

/// The space at another load. @param loads values of design.cases.numbers [SI, parameters as written]
DesignSpace at_load(const DesignSpace& space, const VectorX& loads);

/// What the spec itself says of design.cases.numbers.
VectorX nominal_load(const DesignSpace& space);

/// "cargo.mass = 0.5", in the spec's units.
std::string load_text(const std::vector<LoadParameter>& numbers, const VectorX& loads);

}  // namespace balance
