#pragma once
/// Other numbers than the spec's, at which formulas and programs must be true as well.

#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <random>
#include <vector>

namespace balance::formulas {

/// Draws of all parameters and free numbers.
class ParameterSampler {
 public:
  static constexpr int max_draws = 20;

  ParameterSampler(const Ring& ring, const ParametricModel& model);

  /// Whether any symbol depends on what can be drawn.
  bool has_parameters() const { return has_parameters_; }
  /// Inputs of the model: each changed by up to 30 %, a zero to as much as 0.3 of the largest of its kind. Later draws of a series
  /// change less, since loops close at fewer and fewer numbers the farther away they are.
  std::vector<double> draw(std::mt19937_64& random, int draws_before) const;

 private:
  const ParametricModel& model_;
  std::vector<double> max_zero_changes_;  ///< per input: of one that is zero
  bool has_parameters_ = false;
};

/// Gives the ring's symbols and fixed angles the values that they have at other inputs, for as long as it lives.
class ScopedSymbolValues {
 public:
  /// @param nodes of the model at these inputs
  ScopedSymbolValues(Ring& ring, const std::vector<double>& nodes);
  ~ScopedSymbolValues();
  ScopedSymbolValues(const ScopedSymbolValues&) = delete;
  ScopedSymbolValues& operator=(const ScopedSymbolValues&) = delete;

 private:
  Ring& ring_;
  std::vector<double> saved_symbols_, saved_angles_;
};

}  // namespace balance::formulas
