#pragma once
/// Sets of equal designs where only values of a figure and its first derivatives are known.

#include "balance/synthesis/design/problem_functions.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace balance::design {

/// Finds directions in which a simulated figure stays the same: those in which it does not change to first order, each
/// followed for a short step in which the conditions, the active limits and the maxima that form the figure are restored.
class TieFollower {
 public:
  /// The objective as a sum of maxima with derivatives by unit coordinates; std::nullopt if there are none.
  using Terms = std::function<std::optional<std::vector<MaxTerm>>(const VectorX& u)>;

  /// @param context, objective, conditions must outlive this object
  /// @param conditions at u
  TieFollower(const SolverContext& context, const ScaledObjective& objective, Terms terms, const Conditions& conditions,
              const VectorX& u);

  /// @param free directions in which no condition changes
  /// @param known directions in which the figure is known to stay the same
  /// @param limits normals of the active constraints
  /// @return `known`, followed by others; std::nullopt if they cannot be determined: no derivatives, no stationary
  /// point, or too many directions
  std::optional<MatrixX> find_directions(const MatrixX& free, const MatrixX& known, const MatrixX& limits) const;

 private:
  enum class Change { none, rise, fall, unknown };

  bool is_stationary(const MatrixX& free, const MatrixX& limits) const;
  MatrixX span_first_order_ties(const MatrixX& free, const MatrixX& limits) const;
  std::optional<MatrixX> test_by_values(const MatrixX& directions, const MatrixX& limits) const;
  MatrixX find_principal_directions(const MatrixX& basis) const;
  Change change_along(const VectorX& step) const;
  double value_difference(const VectorX& step) const;
  VectorX restore(const VectorX& from) const;

  const SolverContext& context_;
  const ScaledObjective& objective_;
  const Terms terms_at_;
  const Conditions& conditions_;
  VectorX u_;
  std::optional<std::vector<MaxTerm>> terms_;
  double value_ = 0, scale_ = 0;
};

}  // namespace balance::design
