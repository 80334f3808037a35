#pragma once
/// The lower level of a design's search: the best masses for given lengths, and what other lengths would change of that.
/// Private to design.
///
/// Minimise figure + ρ |R w − r| over the unknowns w within their limits. The rows R are those of fixed configurations, so that
/// everything is smooth in the lengths, also where the rank of the conditions falls; as a norm and no square the penalty is
/// exact: with ρ large enough the residual vanishes wherever it can. So is what limits on figures are missed by. Rates of change
/// by lengths come from the multipliers (envelope theorem).

#include "balance/design/inner_program.hpp"

namespace balance::design {

struct InnerSolution {
  bool is_found = false;
  VectorX u;                                   ///< outer numbers; the others mean nothing
  VectorX unknowns;                            ///< w
  VectorX residual_vector;                     ///< R w − r
  double residual = 0, figure = 0, value = 0;  ///< |left|, weighted sum [SI], what was minimised
  ConeProgram program;
  ConeSolution cone;
  std::vector<FigureRows> pieces;    ///< of the figures
  Eigen::Index first_limit_row = 0;  ///< of the multipliers, where those of limits are
  VectorX residual_multipliers;      ///< multipliers of `left`
};

class InnerProblem {
 public:
  enum class Target { residual, figure, both };

  /// @param size of the figure: values are counted in it
  /// @param spare part of their bounds by which limits are to be kept
  InnerProblem(const SolverContext& context, const ConvexMassModel& model, Target aim, double size, double spare = 0);

  /// Conditions are asked of configurations of this mechanism from now on. @return false if there are none
  bool set_reference(const VectorX& u);
  InnerSolution solve_at(const VectorX& u) const;
  /// d value / d outer numbers, in the model's order; not finite next to where nothing can be assembled.
  VectorX gradient(const InnerSolution& solution) const;
  /// d left / d outer numbers, less what unknowns that no limit holds can undo. Not finite as above.
  MatrixX reduced_jacobian(const InnerSolution& solution) const;

 private:
  bool wants_figure() const { return aim_ != Target::residual; }
  bool wants_residual() const { return aim_ != Target::figure; }
  std::optional<InnerData> make_data(const VectorX& u) const;
  bool add_figures(const VectorX& u, InnerData& data) const;
  void evaluate_solution(const InnerData& data, InnerSolution& solution) const;
  double lagrangian(const InnerSolution& solution, const InnerData& data) const;
  MatrixX free_directions(const InnerSolution& solution) const;
  MatrixX differences(const VectorX& u, Eigen::Index rows, const std::function<VectorX(const InnerData&)>& of) const;

  const SolverContext& context_;
  const ConvexMassModel& model_;
  Target aim_;
  double figure_scale_, limit_margin_;
  std::optional<GoalResidual> goal_;
};

}  // namespace balance::design
