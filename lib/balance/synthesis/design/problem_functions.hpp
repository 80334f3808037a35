#pragma once
/// The objective as a function of unit coordinates.

#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

/// Round-off of a figure, relative to its largest known value.
inline constexpr double relative_figure_round_off = 1e-12;

class ScaledObjective {
 public:
  /// @param context, objective must outlive this object
  ScaledObjective(const SolverContext& context, const Objective& objective);

  /// @param gradient set unless null (by differences if the objective has no gradient)
  /// @return not finite if it cannot be computed
  double operator()(const VectorX& u, VectorX* gradient) const;
  /// Why there is no value at u; may be empty.
  std::string failure_reason(const VectorX& u) const;
  /// The objective as a sum of maxima, with derivatives. std::nullopt if these are unknown or cannot be computed.
  std::optional<std::vector<MaxTerm>> max_terms(const VectorX& u) const;
  bool has_max_terms() const { return is_simulated() && objective_.function->has_max_terms(); }
  /// Whether every evaluation requires a simulation.
  bool is_simulated() const { return !objective_.is_of_parameters(); }
  /// Whether the objective is convex in the variables: convex in parameters that depend on the variables affinely where
  /// they matter.
  bool is_convex() const { return convex_; }
  bool is_concave() const { return concave_; }
  /// Values up to this are round-off, judged by the values at the start, the centre and the ends of the bounds.
  double round_off() const;
  /// A lower bound of all values.
  double lower_bound() const { return objective_.lower_bound; }

 private:
  bool is_affine_in_variables() const;
  double evaluate_by_simulation(const VectorX& u) const;
  std::optional<VectorX> known_gradient(const VectorX& u) const;
  VectorX gradient_by_simulation(const VectorX& u) const;

  const SolverContext& context_;
  const Objective& objective_;
  std::vector<int> parameters_;  ///< the features that the objective depends on
  bool convex_ = false, concave_ = false;
};

// Limits on figures as inequalities in unit coordinates.

/// Violation of a limit relative to its bound (or to 1, if the bound is zero); negative if the limit is satisfied.
double relative_violation(const DesignLimit& limit, double value);

/// Its derivative by the value.
double violation_slope(const DesignLimit& limit);

class DesignLimits {
 public:
  explicit DesignLimits(const SolverContext& context);

  int size() const { return static_cast<int>(figures_.size()); }
  /// Whether the limits define a convex set.
  bool is_convex() const;
  /// g = −violation, and its derivatives unless null. Not finite if a figure has no value.
  void evaluate(const VectorX& u, VectorX& g, MatrixX* jacobian) const;
  /// Whether all limits are satisfied up to round-off.
  bool is_satisfied(const VectorX& u) const;
  /// The same of one limit.
  bool is_satisfied(const VectorX& u, int limit) const;
  /// The figure that is limited.
  double value(const VectorX& u, int limit) const { return figures_[static_cast<std::size_t>(limit)](u, nullptr); }

 private:
  const std::vector<DesignLimit>& limits_;
  std::vector<ScaledObjective> figures_;
};

}  // namespace balance::design
