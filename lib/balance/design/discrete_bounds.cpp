#include "balance/design/discrete_bounds.hpp"

#include "balance/design/findings.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

DesignProblem within(const DesignProblem& problem, const Branch& branch, double seconds) {
  DesignProblem part = problem;
  part.choices.clear();
  for (std::size_t i = 0; i < part.variables.size(); ++i) {
    Variable& variable = part.variables[i];
    const auto k = static_cast<Eigen::Index>(i);
    variable.sizes.clear();
    variable.lower = branch.lower[k];
    variable.upper = branch.upper[k];
    variable.start = std::clamp(variable.start, variable.lower, variable.upper);
  }
  part.search.seconds = seconds;
  return part;
}

DiscreteBounds::Place::Place(const DesignProblem& whole, const Branch& branch)
    : problem(within(whole, branch, whole.search.seconds)), budget(whole.search.seconds), context(problem, budget) {
  if (context.survey.any_geometric()) return;
  conditions = context.conditions_at(context.box.start());
  if (conditions.status != ConditionsStatus::done) return;
  std::vector<LinearFigure> figures;
  if (whole.objective && whole.whole_figures_at)
    if (auto found = whole.whole_figures_at(context.box.numbers(context.box.start()))) figures = std::move(*found);
  std::vector<BoundedFigures> limits;
  if (whole.bounded_at)
    if (auto found = whole.bounded_at(context.box.numbers(context.box.start()))) limits = std::move(*found);
  const FixedRows rows(context, conditions);
  const auto occurring = find_occurring(context, conditions, context.box.start());
  const VectorX at_start = rows.exact(context.box.start());
  std::vector<int> changeable;
  for (int k = 0; k < rows.size(); ++k) {
    if (!occurring[static_cast<std::size_t>(k)].empty()) {
      changeable.push_back(k);
      continue;
    }
    fixed_left = std::hypot(fixed_left, at_start[k]);
    if (k < conditions.own_rows() && !(std::abs(at_start[k]) < 1e-10)) impossible = true;
  }
  const auto terms =
      static_cast<Eigen::Index>(list_terms(context.survey.at_base, context.options.loose_springs).size());
  relaxation.emplace(context, rows.matrix()(changeable, Eigen::all).leftCols(terms), figures, limits);
}

const DiscreteBounds::Place* DiscreteBounds::place(const Branch& branch) {
  const auto open = [&](int i) { return branch.lower[i] != branch.upper[i]; };
  if (std::any_of(outer_.begin(), outer_.end(), open)) return nullptr;
  const VectorX outer = branch.lower(outer_);
  if (!place_ || place_->outer != outer) {
    Branch wide = branch;
    for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (std::find(outer_.begin(), outer_.end(), static_cast<int>(i)) != outer_.end()) continue;
      wide.lower[k] = problem_.variables[i].lower;
      wide.upper[k] = problem_.variables[i].upper;
    }
    auto made = std::make_unique<Place>(problem_, wide);
    made->outer = outer;
    place_ = std::move(made);
  }
  return place_->relaxation && place_->relaxation->complete() ? place_.get() : nullptr;
}

/// Numbers that are no unknowns of the convex problem must be decided before there is one.
void DiscreteBounds::find_outer(const Branch& root) {
  if (tried_) return;
  tried_ = true;
  if (place(root) != nullptr) return;
  const Context& context = place_->context;
  for (int i = 0; i < context.box.size(); ++i)
    if (context.survey.geometric[static_cast<std::size_t>(i)]) outer_.push_back(i);
  if (place_->relaxation)
    for (const int i : place_->relaxation->outer())
      if (std::find(outer_.begin(), outer_.end(), i) == outer_.end()) outer_.push_back(i);
  place_.reset();
}

const Conditions* DiscreteBounds::shared_conditions(const Branch& root) {
  find_outer(root);
  const bool known = outer_.empty() && place_ && place_->conditions.status == ConditionsStatus::done;
  return known && known_values(place_->context.survey.at_base).size() == 0 ? &place_->conditions : nullptr;
}

DiscreteBounds::Answer DiscreteBounds::operator()(const Branch& branch, const Narrowed& part, Wanted wanted) {
  find_outer(branch);
  Answer answer;
  const Place* here = place(branch);
  if (here == nullptr) return answer;
  answer.known = true;
  if (wanted == Wanted::exact && here->impossible) {
    answer.possible = false;
    return answer;
  }
  const RelaxedDesign design = wanted == Wanted::exact    ? here->relaxation->least_figure(part)
                               : wanted == Wanted::figure ? here->relaxation->least_figure_regardless(part)
                                                          : here->relaxation->least_residual(part);
  answer.x = design.x;
  answer.possible = design.possible && !(wanted == Wanted::exact && design.residual > can_be_met);
  double least = wanted == Wanted::residual ? std::hypot(design.residual, here->fixed_left) : design.figure;
  if (wanted != Wanted::residual && problem_.objective && !(least >= problem_.objective->lower_bound))
    least = problem_.objective->lower_bound;
  if (std::isfinite(least)) answer.least = least;
  return answer;
}

}  // namespace balance::designing
