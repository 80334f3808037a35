#pragma once
/// Numbers that differ from the spec's, with which formulas and programs must hold as well.

#include "balance/mechanics/model/validation.hpp"
#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <random>
#include <stdexcept>
#include <vector>

namespace balance::formulas {

/// Sets the ring's symbols and fixed angles to their values at other inputs; the destructor restores them.
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

/// Draws values of all parameters and free numbers.
class ParameterSampler {
 public:
  static constexpr int max_draws = 20;

  ParameterSampler(Ring& ring, const ParametricModel& model);

  /// Whether any symbol depends on a number that can be drawn.
  bool has_parameters() const { return has_parameters_; }
  /// Inputs of the model. Each one changes by up to 30 %, a zero to at most 0.3 times the largest symbol of its kind.
  /// Later draws of a series change less, since loops close more and more rarely the farther away the numbers are.
  std::vector<double> draw(std::mt19937_64& random, int draws_before) const;

  /// Makes mechanisms with other numbers, which the ring's symbols have meanwhile, until `count` of them were compared.
  /// @param compare takes a mechanism and returns whether it could be compared; std::invalid_argument: its loops do not
  /// close
  /// @return how many were compared
  template <class Compare>
  int compare_perturbed(int count, std::mt19937_64& random, const Compare& compare) const {
    int compared = 0;
    for (int draws = 0; has_parameters_ && compared < count && draws < max_draws; ++draws) {
      const std::vector<double> nodes = model_.evaluate_nodes(draw(random, draws));
      const Mechanism mechanism = model_.build_mechanism(nodes);
      if (!validate(mechanism).empty()) continue;
      const ScopedSymbolValues values(ring_, nodes);
      try {
        compared += compare(mechanism) ? 1 : 0;
      } catch (const std::invalid_argument&) {
      }
    }
    return compared;
  }

 private:
  Ring& ring_;
  const ParametricModel& model_;
  std::vector<double> max_zero_changes_;  ///< per input that is zero
  bool has_parameters_ = false;
};

}  // namespace balance::formulas
