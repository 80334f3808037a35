#pragma once
/// Which power of one number expressions follow. Private to conditions.

#include "balance/expression/evaluation.hpp"

namespace balance {

/// A number that is c · pᵉ, c without p; or does not follow a power of p at all.
struct PowerLaw {
  bool is_valid = true;
  double exponent = 0;
  double value = 0;  ///< at present: what is zero adds nothing to a sum
};

/// The algebra (expression/evaluation.hpp) of power laws in one node of a graph, taken for a number of its own whatever it is made
/// of.
class PowerLawAlgebra {
 public:
  using Value = PowerLaw;

  /// @param base the node; not an input
  explicit PowerLawAlgebra(const ExpressionNode* base) : base_(base) {}

  PowerLaw constant(double value) const { return {true, 0, value}; }
  PowerLaw apply(const ExpressionNode& node, const PowerLaw& a, const PowerLaw& b, const PowerLaw& c) const;

 private:
  const ExpressionNode* base_;
};

}  // namespace balance
