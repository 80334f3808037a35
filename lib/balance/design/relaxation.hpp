#pragma once
/// What no design of one geometry is better than, whatever its numbers between their bounds. Private to design.
///
/// The cone program of the masses (inner_problem) at a fixed geometry. Where a number that moves a CoM stands in products with a mass,
/// mass and first moment are the unknowns, and the place is within its box if and only if the first moment is within mass times
/// the box: nothing is lost by it (McCormick's inequalities are exact for a product whose one factor occurs nowhere else).

#include "balance/design/inertial_model.hpp"
#include "balance/design/inner_program.hpp"

namespace balance::designing {

/// Rows that are left with less than this, in their scale, can be met.
inline constexpr double can_be_met = 1e-8;

/// Some of all designs: numbers [SI] between narrower bounds, or equal to them.
struct Narrowed {
  VectorX lower, upper;
  std::vector<std::pair<VectorX, double>> sums;  ///< coefficients · numbers ≤ limit; coefficients and numbers ≥ 0
};

struct RelaxedDesign {
  bool possible = false;  ///< false: there are none
  /// No design's is below them: the norm of what is left of the rows; the figure of those that meet the rows, or of all.
  double residual = std::numeric_limits<double>::quiet_NaN(), figure = std::numeric_limits<double>::quiet_NaN();
  VectorX x;  ///< numbers that come near it
};

class Relaxation {
 public:
  /// @param rows scaled conditions × terms (list_terms) at the context's only geometry
  /// @param figures of the objective, at all samples; empty: none
  /// @param limits that all designs keep
  Relaxation(const Context& context, const MatrixX& rows, const std::vector<LinearFigure>& figures,
             const std::vector<BoundedFigures>& limits);

  /// Numbers that are no unknowns.
  const std::vector<int>& outer() const { return model_.outer(); }
  /// No number but those that are fixed in the context is left out of the program.
  bool complete() const;
  RelaxedDesign least_residual(const Narrowed& part) const;
  /// @return no figure where rows cannot be met
  RelaxedDesign least_figure(const Narrowed& part) const;
  /// Whether the rows are met or not.
  RelaxedDesign least_figure_regardless(const Narrowed& part) const;

 private:
  /// Unknowns that stand still, with their values.
  using Held = std::vector<std::pair<Eigen::Index, double>>;
  struct Answer {
    ConeStatus status = ConeStatus::unsolved;
    double bound = 0;  ///< of the program's cost
    VectorX unknowns;
  };
  Answer solve(const Narrowed& part, bool figures, bool rows, double weight) const;
  RelaxedDesign weighed(const Narrowed& part, bool rows) const;
  double missed(const VectorX& unknowns, bool rows) const;
  InnerData narrowed(const Narrowed& part, Held& held) const;
  RelaxedDesign read(const Answer& answer, const Narrowed& part) const;

  const Context& context_;
  InertialModel model_;
  bool has_figure_;     ///< there is something to minimise
  bool known_ = false;  ///< what the terms are of the unknowns
  InnerData data_;
  double size_ = 1;  ///< of the figure
};

}  // namespace balance::designing
