#include "balance/synthesis/design/branch_and_bound.hpp"

#include "balance/synthesis/design/solution_analysis.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Next to one of the sizes, in parts of the range.
constexpr double discrete_value_tolerance = 1e-9;

const DesignVariable& variable(const DesignProblem& problem, int i) {
  return problem.variables[static_cast<std::size_t>(i)];
}

}  // namespace

BranchingRule::BranchingRule(const DesignProblem& problem, int least) : problem_(problem) {
  std::optional<std::size_t> shared;
  for (const CardinalityConstraint& choice : problem.cardinality_constraints) {
    std::size_t group = groups_.size();
    if (choice.max_count < 0 && shared)
      group = *shared;
    else
      groups_.push_back(choice.max_count < 0 ? least : choice.max_count);
    if (choice.max_count < 0) shared = group;
    for (const OptionalElement& element : choice.elements) elements_.push_back({element.variables, group});
  }
}

int BranchingRule::count_unrestricted_elements(const DesignProblem& problem) {
  std::size_t count = 0;
  for (const CardinalityConstraint& choice : problem.cardinality_constraints)
    count += choice.max_count < 0 ? choice.elements.size() : 0;
  return static_cast<int>(count);
}

BranchNode BranchingRule::root() const {
  BranchNode branch;
  const auto n = static_cast<Eigen::Index>(problem_.variables.size());
  branch.lower.resize(n);
  branch.upper.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    branch.lower[i] = variable(problem_, static_cast<int>(i)).lower;
    branch.upper[i] = variable(problem_, static_cast<int>(i)).upper;
  }
  branch.element_states.assign(elements_.size(), BranchNode::ElementState::undecided);
  return branch;
}

bool BranchingRule::propagate_values(BranchNode& branch) const {
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    double &lower = branch.lower[static_cast<Eigen::Index>(i)], &upper = branch.upper[static_cast<Eigen::Index>(i)];
    const std::vector<double>& sizes = problem_.variables[i].discrete_values;
    if (!sizes.empty()) {
      const auto first = std::lower_bound(sizes.begin(), sizes.end(), lower);
      const auto last = std::upper_bound(sizes.begin(), sizes.end(), upper);
      if (first >= last) return false;
      lower = *first;
      upper = *std::prev(last);
    }
    if (!(lower <= upper)) return false;
  }
  return true;
}

/// An element is left out exactly if its numbers are zero.
bool BranchingRule::propagate_element(BranchNode& branch, std::size_t k) const {
  BranchNode::ElementState& fate = branch.element_states[k];
  bool zero = true, never = false;
  for (const int i : elements_[k].numbers) {
    zero = zero && branch.lower[i] == 0 && branch.upper[i] == 0;
    never = never || branch.lower[i] > 0 || branch.upper[i] < 0;
  }
  if (zero && fate != BranchNode::ElementState::excluded) {
    if (fate == BranchNode::ElementState::kept) return false;  // the same as one that is left out
    fate = BranchNode::ElementState::excluded;
  }
  if (never && fate == BranchNode::ElementState::excluded) return false;
  if (never) fate = BranchNode::ElementState::kept;
  if (fate == BranchNode::ElementState::excluded)
    for (const int i : elements_[k].numbers) branch.lower[i] = branch.upper[i] = 0;
  return true;
}

int BranchingRule::count(const BranchNode& branch, std::size_t group, BranchNode::ElementState fate) const {
  int found = 0;
  for (std::size_t k = 0; k < elements_.size(); ++k)
    found += elements_[k].group == group && branch.element_states[k] == fate ? 1 : 0;
  return found;
}

bool BranchingRule::propagate_counts(BranchNode& branch) const {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const int kept = count(branch, g, BranchNode::ElementState::kept);
    if (kept > groups_[g]) return false;
    if (kept < groups_[g]) continue;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      if (elements_[k].group == g && branch.element_states[k] == BranchNode::ElementState::undecided)
        branch.element_states[k] = BranchNode::ElementState::excluded;
  }
  return true;
}

bool BranchingRule::propagate(BranchNode& branch) const {
  for (;;) {
    const std::vector<BranchNode::ElementState> fates = branch.element_states;
    const VectorX lower = branch.lower, upper = branch.upper;
    if (!propagate_counts(branch) || !propagate_values(branch)) return false;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      if (!propagate_element(branch, k)) return false;
    if (fates == branch.element_states && lower == branch.lower && upper == branch.upper) return true;
  }
}

bool BranchingRule::is_leaf(const BranchNode& branch) const {
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!problem_.variables[i].discrete_values.empty() && branch.lower[k] != branch.upper[k]) return false;
  }
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (count(branch, g, BranchNode::ElementState::kept) + count(branch, g, BranchNode::ElementState::undecided) >
        groups_[g])
      return false;
  return true;
}

double BranchingRule::range_fraction(const Element& element, const VectorX& x) const {
  double most = 0;
  for (const int i : element.numbers) {
    const double reach = std::max(std::abs(variable(problem_, i).lower), std::abs(variable(problem_, i).upper));
    if (reach > 0) most = std::max(most, std::abs(x[i]) / reach);
  }
  return most;
}

std::vector<BranchNode> BranchingRule::branch(const BranchNode& branch, const VectorX& x) const {
  std::size_t chosen = elements_.size();
  double largest = -1;
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const std::size_t g = elements_[k].group;
    const bool matters =
        branch.element_states[k] == BranchNode::ElementState::undecided &&
        count(branch, g, BranchNode::ElementState::kept) + count(branch, g, BranchNode::ElementState::undecided) >
            groups_[g];
    if (!matters || !(range_fraction(elements_[k], x) > largest)) continue;
    largest = range_fraction(elements_[k], x);
    chosen = k;
  }
  if (chosen < elements_.size()) return branch_on_element(branch, chosen);
  int number = -1;
  double farthest = -1;
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    const std::vector<double>& sizes = problem_.variables[i].discrete_values;
    const auto k = static_cast<Eigen::Index>(i);
    if (sizes.empty() || branch.lower[k] == branch.upper[k]) continue;
    const auto above = std::lower_bound(sizes.begin(), sizes.end(), x[k]);
    double off = above != sizes.end() ? *above - x[k] : std::numeric_limits<double>::infinity();
    if (above != sizes.begin()) off = std::min(off, x[k] - *std::prev(above));
    off /= sizes.back() - sizes.front();
    if (!(off > farthest)) continue;
    farthest = off;
    number = static_cast<int>(i);
  }
  return branch_on_value(branch, number, x[number]);
}

std::vector<BranchNode> BranchingRule::branch_on_element(const BranchNode& branch, std::size_t k) const {
  std::vector<BranchNode> parts(2, branch);
  parts[0].element_states[k] = BranchNode::ElementState::excluded;
  parts[1].element_states[k] = BranchNode::ElementState::kept;
  return parts;
}

std::vector<BranchNode> BranchingRule::branch_on_value(const BranchNode& branch, int number, double at) const {
  const std::vector<double>& sizes = variable(problem_, number).discrete_values;
  const double range = sizes.back() - sizes.front(), value = std::clamp(at, branch.lower[number], branch.upper[number]);
  const auto above = std::lower_bound(sizes.begin(), sizes.end(), value - discrete_value_tolerance * range);
  std::vector<BranchNode> parts;
  const auto add = [&](double lower, double upper) {
    if (lower > upper || lower > branch.upper[number] || upper < branch.lower[number]) return;
    parts.push_back(branch);
    parts.back().lower[number] = std::max(lower, branch.lower[number]);
    parts.back().upper[number] = std::min(upper, branch.upper[number]);
  };
  const double infinite = std::numeric_limits<double>::infinity();
  if (above != sizes.end() && *above <= value + discrete_value_tolerance * range) {
    if (above != sizes.begin()) add(-infinite, *std::prev(above));
    if (std::next(above) != sizes.end()) add(*std::next(above), infinite);
    add(*above, *above);
    return parts;
  }
  const bool up = *above - value < value - *std::prev(above);
  if (up) add(-infinite, *std::prev(above));
  add(*above, infinite);
  if (!up) add(-infinite, *std::prev(above));
  return parts;
}

VariableDomain BranchingRule::node_domain(const BranchNode& branch) const {
  VariableDomain part{branch.lower, branch.upper, {}};
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (count(branch, g, BranchNode::ElementState::undecided) == 0) continue;
    VectorX coefficients = VectorX::Zero(branch.lower.size());
    bool positive = true;
    for (std::size_t k = 0; k < elements_.size(); ++k) {
      if (elements_[k].group != g || branch.element_states[k] != BranchNode::ElementState::undecided) continue;
      const int i = elements_[k].numbers.front();  // its share of the range is at most one
      positive = positive && branch.lower[i] >= 0 && coefficients[i] == 0;
      coefficients[i] = 1 / variable(problem_, i).upper;
    }
    const int left = groups_[g] - count(branch, g, BranchNode::ElementState::kept);
    if (positive && coefficients.allFinite()) part.linear_limits.emplace_back(coefficients, left);
  }
  return part;
}

std::vector<std::vector<bool>> BranchingRule::kept_elements(const VectorX& x) const {
  std::vector<std::vector<bool>> all;
  for (const CardinalityConstraint& choice : problem_.cardinality_constraints) {
    all.emplace_back();
    for (const OptionalElement& element : choice.elements)
      all.back().push_back(
          std::any_of(element.variables.begin(), element.variables.end(), [&](int i) { return x[i] != 0; }));
  }
  return all;
}

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

namespace {

/// Values that differ by less than this part are as good as each other.
constexpr double pruning_tolerance = 1e-9;
/// One design of many.
constexpr int max_leaf_restarts = 6, max_leaf_evaluations = 2000;
/// Part of the time left that one design may take where lengths are searched for, too.
constexpr double leaf_time_fraction = 0.25;

/// All that masses can do is done.
bool has_met_conditions(const DesignOutcome& outcome) {
  if (outcome.status == DesignStatus::balanced || outcome.status == DesignStatus::no_goal) return true;
  return std::all_of(outcome.unmet_conditions.begin(), outcome.unmet_conditions.end(), [&](int row) {
    return row >= outcome.conditions.parameter_rows() &&
           std::find(outcome.unmet_fixed_conditions.begin(), outcome.unmet_fixed_conditions.end(), row) !=
               outcome.unmet_fixed_conditions.end();
  });
}

}  // namespace

std::optional<DiscreteCandidate> BranchAndBound::rate(DesignOutcome outcome) const {
  if (outcome.status == DesignStatus::unsolved || outcome.status == DesignStatus::no_feasible_start)
    return std::nullopt;
  DiscreteCandidate design;
  const bool by_figure = problem_.objective && !problem_.objective->is_secondary;
  if (!has_met_conditions(outcome)) {
    design.value = by_figure ? outcome.objective : outcome.residuals_after.norm();
  } else if (!outcome.within_limits) {
    design.rank = DiscreteCandidate::Rank::limits_violated;
    for (const LimitOutcome& limit : outcome.limits) design.value = std::max(design.value, limit.violation);
  } else {
    design.rank = DiscreteCandidate::Rank::exact;
    design.value = problem_.objective ? outcome.objective : 0;
  }
  if (!std::isfinite(design.value)) return std::nullopt;
  design.outcome = std::move(outcome);
  return design;
}

/// Any exact design does, and one is known.
bool BranchAndBound::is_done() const {
  return wanted_ == BranchObjective::constrained_figure && !problem_.objective && walk_.incumbent &&
         walk_.incumbent->rank == DiscreteCandidate::Rank::exact;
}

/// What no wanted design of a decided branch is below.
double BranchAndBound::leaf_bound(const BranchNode& branch, double least,
                                  const std::optional<DiscreteCandidate>& design, const DesignOutcome& outcome) const {
  const double infinite = std::numeric_limits<double>::infinity();
  const bool single = branch.lower == branch.upper;
  const bool suits =
      design && (wanted_ != BranchObjective::constrained_figure || design->rank == DiscreteCandidate::Rank::exact);
  if (!suits) return single || outcome.is_proved_infeasible ? infinite : least;
  const bool proved = outcome.optimality == Optimality::proved_global ||
                      (wanted_ == BranchObjective::constrained_figure && !problem_.objective);
  if (single || proved) return design->value;
  return design->value <= least + relative_gap_tolerance * std::abs(least) ? design->value : least;
}

void BranchAndBound::solve_leaf(const BranchNode& branch, double least, bool bounded) {
  DesignProblem part = restrict_to_node(problem_, branch, budget_.remaining_time());
  part.is_subproblem = true;
  part.search.max_restarts = std::min(part.search.max_restarts, max_leaf_restarts);
  part.search.max_evaluations = std::min(part.search.max_evaluations, max_leaf_evaluations);
  if (!bounded) part.search.max_time = std::max(1e-3, leaf_time_fraction * budget_.remaining_time());
  ++steps_.designs;
  DesignOutcome outcome = solve_design(part);
  std::optional<DiscreteCandidate> design = rate(outcome);
  const double bound = leaf_bound(branch, least, design, outcome);
  walk_.lower_bound = std::min(walk_.lower_bound, bound);
  const bool found = design && design->rank == DiscreteCandidate::Rank::exact;
  if (wanted_ == BranchObjective::constrained_figure && !found && bound < std::numeric_limits<double>::infinity())
    walk_.is_exhausted = false;
  if (!design) return;
  const bool better = !walk_.incumbent || design->rank < walk_.incumbent->rank ||
                      (design->rank == walk_.incumbent->rank && design->value < walk_.incumbent->value);
  if (better) walk_.incumbent = std::move(design);
}

void BranchAndBound::process_node(const BranchingRule& branching, BranchNode branch) {
  if (!branching.propagate(branch)) return;
  ++steps_.branches;
  const NodeBounds::Bound bound = bounds_(branch, branching.node_domain(branch), wanted_);
  if (bound.has_relaxation && !bound.is_feasible) return;
  const double least = bound.has_relaxation ? bound.lower_bound : -std::numeric_limits<double>::infinity();
  const bool exact = walk_.incumbent && walk_.incumbent->rank == DiscreteCandidate::Rank::exact;
  const bool comparable = walk_.incumbent && (wanted_ != BranchObjective::constrained_figure || exact);
  if (comparable && least >= walk_.incumbent->value - pruning_tolerance * std::abs(walk_.incumbent->value)) {
    walk_.lower_bound = std::min(walk_.lower_bound, least);
    return;
  }
  if (branching.is_leaf(branch)) return solve_leaf(branch, least, bound.has_relaxation);
  branch.lower_bound = least;
  const VectorX x = bound.x.size() > 0 ? bound.x : VectorX((branch.lower + branch.upper) / 2);
  for (BranchNode& part : branching.branch(branch, x)) open_.push_back(std::move(part));
}

BranchAndBoundResult BranchAndBound::run(const BranchingRule& branching, BranchObjective wanted) {
  wanted_ = wanted;
  walk_ = {};
  open_ = {branching.root()};
  while (!open_.empty() && !is_done() && !budget_.is_spent()) {
    const BranchNode next = std::move(open_.back());
    open_.pop_back();
    process_node(branching, next);
  }
  if (is_done()) return std::move(walk_);
  for (const BranchNode& rest : open_) {
    walk_.is_exhausted = false;
    walk_.lower_bound = std::min(walk_.lower_bound, rest.lower_bound);
  }
  return std::move(walk_);
}

}  // namespace balance::design
