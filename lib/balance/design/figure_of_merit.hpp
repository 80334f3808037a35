#pragma once
/// The objective as a function of unit coordinates. Private to design.

#include "balance/design/context.hpp"

namespace balance::design {

/// Of a figure, in parts of the largest of its values at hand.
inline constexpr double relative_figure_round_off = 1e-12;

class ScaledObjective {
 public:
  /// @param objective must outlive it, as the context must
  ScaledObjective(const SolverContext& context, const Objective& objective);

  /// @param gradient written if not null (by differences where the objective has none)
  /// @return not finite where it cannot be computed
  double operator()(const VectorX& u, VectorX* gradient) const;
  /// Why there is no value at u; may be empty.
  std::string failure_reason(const VectorX& u) const;
  /// The same as a sum of maxima, with slopes; nothing where it cannot be computed. Only where they are known.
  std::optional<std::vector<MaxTerm>> max_terms(const VectorX& u) const;
  bool has_max_terms() const { return is_simulated() && context_.problem.max_terms; }
  /// Every value takes a simulation.
  bool is_simulated() const { return static_cast<bool>(objective_.of_variables); }
  /// Convex in the free numbers: convex in parameters that are affine in the numbers wherever it depends on them.
  bool is_convex() const { return convex_; }
  /// Values no larger are round-off: they are measured by those at the start, in the middle and at the ends of the bounds.
  double round_off() const;
  /// No value is below it.
  double lower_bound() const { return objective_.lower_bound; }

 private:
  bool is_affine_in_variables() const;
  double evaluate_by_simulation(const VectorX& u) const;
  VectorX gradient_by_simulation(const VectorX& u) const;

  const SolverContext& context_;
  const Objective& objective_;
  std::vector<int> parameters_;  ///< the features that are its arguments
  bool convex_ = false;
};

}  // namespace balance::design
