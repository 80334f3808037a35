#include "balance/design/discrete_bounds.hpp"

#include "balance/design/findings.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

DesignProblem restrict_to_node(const DesignProblem& problem, const BranchNode& branch, double seconds) {
  DesignProblem part = problem;
  part.cardinality_constraints.clear();
  for (std::size_t i = 0; i < part.variables.size(); ++i) {
    DesignVariable& variable = part.variables[i];
    const auto k = static_cast<Eigen::Index>(i);
    variable.discrete_values.clear();
    variable.lower = branch.lower[k];
    variable.upper = branch.upper[k];
    variable.start = std::clamp(variable.start, variable.lower, variable.upper);
  }
  part.search.max_time = seconds;
  return part;
}

NodeBounds::GeometryRelaxation::GeometryRelaxation(const DesignProblem& whole, const BranchNode& branch)
    : problem(restrict_to_node(whole, branch, whole.search.max_time)),
      budget(whole.search.max_time),
      context(problem, budget) {
  if (context.classification.has_geometric()) return;
  conditions = context.conditions_at(context.scaling.start());
  if (conditions.status != ConditionsStatus::done) return;
  std::vector<AffineFigure> figures;
  if (whole.objective && whole.all_convex_terms_at)
    if (auto found = whole.all_convex_terms_at(context.scaling.to_variables(context.scaling.start())))
      figures = std::move(*found);
  std::vector<ConvexLimit> limits;
  if (whole.convex_limits)
    if (auto found = whole.convex_limits(context.scaling.to_variables(context.scaling.start())))
      limits = std::move(*found);
  const ConditionResidual rows(context, conditions);
  const auto occurring = find_condition_variables(context, conditions, context.scaling.start());
  const VectorX at_start = rows.evaluate_from_mechanism(context.scaling.start());
  std::vector<int> changeable;
  for (int k = 0; k < rows.size(); ++k) {
    if (!occurring[static_cast<std::size_t>(k)].empty()) {
      changeable.push_back(k);
      continue;
    }
    fixed_residual = std::hypot(fixed_residual, at_start[k]);
    if (k < conditions.parameter_rows() && !(std::abs(at_start[k]) < 1e-10)) is_infeasible = true;
  }
  const auto terms = static_cast<Eigen::Index>(
      list_terms(context.classification.base_mechanism, context.options.loose_springs).size());
  relaxation.emplace(context, rows.matrix()(changeable, Eigen::all).leftCols(terms), figures, limits);
}

const NodeBounds::GeometryRelaxation* NodeBounds::relaxation_at(const BranchNode& branch) {
  const auto open = [&](int i) { return branch.lower[i] != branch.upper[i]; };
  if (std::any_of(outer_.begin(), outer_.end(), open)) return nullptr;
  const VectorX outer = branch.lower(outer_);
  if (!place_ || place_->outer != outer) {
    BranchNode wide = branch;
    for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (std::find(outer_.begin(), outer_.end(), static_cast<int>(i)) != outer_.end()) continue;
      wide.lower[k] = problem_.variables[i].lower;
      wide.upper[k] = problem_.variables[i].upper;
    }
    auto made = std::make_unique<GeometryRelaxation>(problem_, wide);
    made->outer = outer;
    place_ = std::move(made);
  }
  return place_->relaxation && place_->relaxation->is_complete() ? place_.get() : nullptr;
}

/// Numbers that are no unknowns of the convex problem must be decided before there is one.
void NodeBounds::find_outer(const BranchNode& root) {
  if (tried_) return;
  tried_ = true;
  if (relaxation_at(root) != nullptr) return;
  const SolverContext& context = place_->context;
  for (int i = 0; i < context.scaling.size(); ++i)
    if (context.classification.is_geometric[static_cast<std::size_t>(i)]) outer_.push_back(i);
  if (place_->relaxation)
    for (const int i : place_->relaxation->outer())
      if (std::find(outer_.begin(), outer_.end(), i) == outer_.end()) outer_.push_back(i);
  place_.reset();
}

const Conditions* NodeBounds::shared_conditions(const BranchNode& root) {
  find_outer(root);
  const bool known = outer_.empty() && place_ && place_->conditions.status == ConditionsStatus::done;
  return known && known_term_values(place_->context.classification.base_mechanism).size() == 0 ? &place_->conditions
                                                                                               : nullptr;
}

NodeBounds::Bound NodeBounds::operator()(const BranchNode& branch, const VariableDomain& part, BranchObjective wanted) {
  find_outer(branch);
  Bound answer;
  const GeometryRelaxation* here = relaxation_at(branch);
  if (here == nullptr) return answer;
  answer.has_relaxation = true;
  if (wanted == BranchObjective::constrained_figure && here->is_infeasible) {
    answer.is_feasible = false;
    return answer;
  }
  const RelaxationBound design = wanted == BranchObjective::constrained_figure
                                     ? here->relaxation->minimise_constrained_figure(part)
                                 : wanted == BranchObjective::figure ? here->relaxation->minimise_figure(part)
                                                                     : here->relaxation->minimise_residual(part);
  answer.x = design.x;
  answer.is_feasible = design.is_feasible &&
                       !(wanted == BranchObjective::constrained_figure && design.residual > relaxed_residual_tolerance);
  double least =
      wanted == BranchObjective::residual ? std::hypot(design.residual, here->fixed_residual) : design.figure;
  if (wanted != BranchObjective::residual && problem_.objective && !(least >= problem_.objective->lower_bound))
    least = problem_.objective->lower_bound;
  if (std::isfinite(least)) answer.lower_bound = least;
  return answer;
}

}  // namespace balance::design
