#pragma once
/// The objective as a function of unit coordinates. Private to design.

#include "balance/design/context.hpp"

namespace balance::designing {

/// Of a figure, in parts of the largest of its values at hand.
inline constexpr double figure_round_off = 1e-12;

class FigureOfMerit {
 public:
  /// @param objective must outlive it, as the context must
  FigureOfMerit(const Context& context, const Objective& objective);

  /// @param gradient written if not null (by differences where the objective has none)
  /// @return not finite where it cannot be computed
  double operator()(const VectorX& u, VectorX* gradient) const;
  /// Why there is no value at u; may be empty.
  std::string trouble(const VectorX& u) const;
  /// The same as a sum of maxima, with slopes; nothing where it cannot be computed. Only where they are known.
  std::optional<std::vector<MaximumTerm>> pieces(const VectorX& u) const;
  bool has_pieces() const { return simulated() && context_.problem.pieces_at; }
  /// Every value takes a simulation.
  bool simulated() const { return static_cast<bool>(objective_.of_variables); }
  /// Convex in the free numbers: convex in parameters that are affine in the numbers wherever it depends on them.
  bool convex() const { return convex_; }
  /// Values no larger are round-off: they are measured by those at the start, in the middle and at the ends of the bounds.
  double round_off() const;
  /// No value is below it.
  double lower_bound() const { return objective_.lower_bound; }

 private:
  bool depends_affinely() const;
  double by_simulation(const VectorX& u) const;
  VectorX simulated_slope(const VectorX& u) const;

  const Context& context_;
  const Objective& objective_;
  std::vector<int> parameters_;  ///< the features that are its arguments
  bool convex_ = false;
};

}  // namespace balance::designing
