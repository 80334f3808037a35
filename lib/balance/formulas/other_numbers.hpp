#pragma once
/// Other numbers than the spec's, at which formulas and programs must be true as well. Private to formulas.

#include "balance/formulas/symbolic_tree.hpp"

#include <random>
#include <vector>

namespace balance::formulas {

/// Draws of all parameters and free numbers.
class OtherNumbers {
 public:
  static constexpr int max_draws = 20;

  OtherNumbers(const Ring& ring, const NumberModel& model);

  /// Whether any symbol depends on what can be drawn.
  bool exist() const { return exist_; }
  /// Inputs of the model: each changed by up to 30 %, a zero to as much as 0.3 of the largest of its kind. Later draws of a series
  /// change less, since loops close at fewer and fewer numbers the farther away they are.
  std::vector<double> draw(std::mt19937_64& random, int draws_before) const;

 private:
  const NumberModel& model_;
  std::vector<double> zero_reach_;  ///< per input: of one that is zero
  bool exist_ = false;
};

/// Gives the ring's symbols and fixed angles the values that they have at other inputs, for as long as it lives.
class ValuesElsewhere {
 public:
  /// @param nodes of the model at these inputs
  ValuesElsewhere(Ring& ring, const std::vector<double>& nodes);
  ~ValuesElsewhere();
  ValuesElsewhere(const ValuesElsewhere&) = delete;
  ValuesElsewhere& operator=(const ValuesElsewhere&) = delete;

 private:
  Ring& ring_;
  std::vector<double> symbols_, angles_;
};

}  // namespace balance::formulas
