#pragma once
/// Figures that a design must keep to, as inequalities in unit coordinates. Private to design.

#include "balance/design/figure_of_merit.hpp"

namespace balance::designing {

/// How far a value is beyond a limit, in parts of its bound (of one, if the bound is zero); negative: what is left of it.
double violation(const DesignLimit& limit, double value);

class Limits {
 public:
  explicit Limits(const Context& context);

  int size() const { return static_cast<int>(merits_.size()); }
  /// The numbers that keep all limits form a convex set.
  bool convex() const;
  /// g = −violation, and its derivatives unless null. Not finite where a figure has no value.
  void evaluate(const VectorX& u, VectorX& g, MatrixX* jacobian) const;
  /// All are kept, to round-off.
  bool hold(const VectorX& u) const;

 private:
  const std::vector<DesignLimit>& limits_;
  std::vector<FigureOfMerit> merits_;
};

}  // namespace balance::designing
