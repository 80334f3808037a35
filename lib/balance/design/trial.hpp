#pragma once
/// Numbers at one geometry, and which of several are better. Private to design.

#include "balance/design/equations.hpp"
#include "balance/design/figure_of_merit.hpp"

#include <limits>

namespace balance::designing {

struct Trial {
  VectorX u;              ///< all numbers
  bool possible = false;  ///< no obstacle
  bool balanced = false;
  double figure = std::numeric_limits<double>::quiet_NaN();  ///< the objective
  double residual =
      std::numeric_limits<double>::quiet_NaN();  ///< norm of what is left of the goal at the equations' samples
};

class Trials {
 public:
  /// @param equations of the goal, or none
  /// @param merit null: none
  Trials(const Context& context, const Equations& equations, const FigureOfMerit* merit);

  /// The objective comes before the conditions where these cannot be met.
  bool wants_figure() const { return merit_ != nullptr && !context_.problem.objective->size; }
  /// Balanced before not, then by the objective, or by what is left.
  double cost(const Trial& trial) const;
  void improve(Trial& best, Trial trial) const;

  /// By the conditions of its own geometry, derived anew.
  bool is_balanced(const VectorX& u) const;
  /// All numbers as they stand.
  Trial as_it_is(const VectorX& u) const;
  /// At the lengths of u: the other numbers solved for by themselves.
  Trial at(const VectorX& u) const;

 private:
  void measure(Trial& trial) const;

  const Context& context_;
  const Equations& equations_;
  const FigureOfMerit* merit_;
  std::vector<int> others_;  ///< numbers that do not change the geometry
};

}  // namespace balance::designing
