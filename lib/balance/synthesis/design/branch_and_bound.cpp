#include "balance/synthesis/design/branch_and_bound.hpp"

#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/limit_relaxation.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Distance to a discrete value below which a variable counts as having it, relative to the range.
constexpr double discrete_value_tolerance = 1e-9;
/// Fraction of its range below which a variable of an element counts as zero in the solution of a relaxation.
constexpr double unused_element_threshold = 1e-6;

const DesignVariable& variable(const DesignProblem& problem, int i) {
  return problem.variables[static_cast<std::size_t>(i)];
}

}  // namespace

BranchingRule::BranchingRule(const DesignProblem& problem, int max_kept_elements)
    : problem_(problem), all_different_(problem) {
  std::optional<std::size_t> shared;
  for (const CardinalityConstraint& choice : problem.cardinality_constraints) {
    std::size_t group = groups_.size();
    if (choice.max_count < 0 && shared)
      group = *shared;
    else
      groups_.push_back(choice.max_count < 0 ? max_kept_elements : choice.max_count);
    if (choice.max_count < 0) shared = group;
    for (const OptionalElement& element : choice.elements)
      elements_.push_back({element.variables, element.own_variables, group, false});
  }
  for (Element& element : elements_)
    for (const auto* variables : {&element.numbers, &element.own_numbers})
      for (const int i : *variables) element.must_be_decided = element.must_be_decided || all_different_.contains(i);
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

BranchNode BranchingRule::node_of(const VectorX& x) const {
  BranchNode branch = root();
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!problem_.variables[i].discrete_values.empty()) branch.lower[k] = branch.upper[k] = x[k];
  }
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const std::vector<int>& numbers = elements_[k].numbers;
    const bool is_kept = std::any_of(numbers.begin(), numbers.end(), [&](int i) { return x[i] != 0; });
    branch.element_states[k] = is_kept ? BranchNode::ElementState::kept : BranchNode::ElementState::excluded;
    if (!is_kept) fix_excluded(branch, k);
  }
  return branch;
}

bool BranchingRule::exclude(BranchNode& branch, std::size_t k) const {
  if (branch.element_states[k] == BranchNode::ElementState::excluded) return false;
  branch.element_states[k] = BranchNode::ElementState::excluded;
  fix_excluded(branch, k);
  return true;
}

/// What has no effect without the element keeps its start value.
void BranchingRule::fix_excluded(BranchNode& branch, std::size_t k) const {
  for (const int i : elements_[k].numbers) branch.lower[i] = branch.upper[i] = 0;
  for (const int i : elements_[k].own_numbers) branch.lower[i] = branch.upper[i] = variable(problem_, i).start;
}

bool BranchingRule::propagate_values(BranchNode& branch) const {
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    double &lower = branch.lower[static_cast<Eigen::Index>(i)], &upper = branch.upper[static_cast<Eigen::Index>(i)];
    const std::vector<double>& values = problem_.variables[i].discrete_values;
    if (!values.empty()) {
      const auto first = std::lower_bound(values.begin(), values.end(), lower);
      const auto last = std::upper_bound(values.begin(), values.end(), upper);
      if (first >= last) return false;
      lower = *first;
      upper = *std::prev(last);
    }
    if (!(lower <= upper)) return false;
  }
  return true;
}

/// An element is excluded if and only if its variables are zero.
bool BranchingRule::propagate_element(BranchNode& branch, std::size_t k) const {
  BranchNode::ElementState& state = branch.element_states[k];
  bool is_zero = true, cannot_vanish = false;
  for (const int i : elements_[k].numbers) {
    is_zero = is_zero && branch.lower[i] == 0 && branch.upper[i] == 0;
    cannot_vanish = cannot_vanish || branch.lower[i] > 0 || branch.upper[i] < 0;
  }
  if (is_zero && state != BranchNode::ElementState::excluded) {
    if (state == BranchNode::ElementState::kept) return false;  // equivalent to excluding it
    state = BranchNode::ElementState::excluded;
  }
  if (cannot_vanish && state == BranchNode::ElementState::excluded) return false;
  if (cannot_vanish) state = BranchNode::ElementState::kept;
  if (state == BranchNode::ElementState::excluded) fix_excluded(branch, k);
  return true;
}

int BranchingRule::count(const BranchNode& branch, std::size_t group, BranchNode::ElementState state) const {
  int total = 0;
  for (std::size_t k = 0; k < elements_.size(); ++k)
    total += elements_[k].group == group && branch.element_states[k] == state ? 1 : 0;
  return total;
}

bool BranchingRule::propagate_counts(BranchNode& branch) const {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const int kept_count = count(branch, g, BranchNode::ElementState::kept);
    if (kept_count > groups_[g]) return false;
    if (kept_count < groups_[g]) continue;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      if (elements_[k].group == g && branch.element_states[k] == BranchNode::ElementState::undecided)
        branch.element_states[k] = BranchNode::ElementState::excluded;
  }
  return true;
}

bool BranchingRule::propagate(BranchNode& branch) const {
  for (;;) {
    const std::vector<BranchNode::ElementState> previous_states = branch.element_states;
    const VectorX lower = branch.lower, upper = branch.upper;
    if (!propagate_counts(branch) || !propagate_values(branch)) return false;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      if (!propagate_element(branch, k)) return false;
    if (!all_different_.is_empty() && !all_different_.propagate(branch.lower, branch.upper, list_present(branch)))
      return false;
    if (previous_states == branch.element_states && lower == branch.lower && upper == branch.upper) return true;
  }
}

/// For each variable, whether it certainly belongs to the mechanism: to no element that is, or may be, left out.
std::vector<bool> BranchingRule::list_present(const BranchNode& branch) const {
  std::vector<bool> is_present(problem_.variables.size(), true);
  for (std::size_t k = 0; k < elements_.size(); ++k)
    if (branch.element_states[k] != BranchNode::ElementState::kept)
      for (const auto* variables : {&elements_[k].numbers, &elements_[k].own_numbers})
        for (const int i : *variables) is_present[static_cast<std::size_t>(i)] = false;
  return is_present;
}

/// Whether an element may still be kept or left out, and this matters for the counts or for what must differ.
bool BranchingRule::is_open(const BranchNode& branch, std::size_t k) const {
  const std::size_t g = elements_[k].group;
  return branch.element_states[k] == BranchNode::ElementState::undecided &&
         (elements_[k].must_be_decided ||
          count(branch, g, BranchNode::ElementState::kept) + count(branch, g, BranchNode::ElementState::undecided) >
              groups_[g]);
}

bool BranchingRule::is_leaf(const BranchNode& branch) const {
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!problem_.variables[i].discrete_values.empty() && branch.lower[k] != branch.upper[k]) return false;
  }
  for (std::size_t k = 0; k < elements_.size(); ++k)
    if (is_open(branch, k)) return false;
  return true;
}

double BranchingRule::range_fraction(const Element& element, const VectorX& x) const {
  double max_fraction = 0;
  for (const int i : element.numbers) {
    const double max_abs_value = std::max(std::abs(variable(problem_, i).lower), std::abs(variable(problem_, i).upper));
    if (max_abs_value > 0) max_fraction = std::max(max_fraction, std::abs(x[i]) / max_abs_value);
  }
  return max_fraction;
}

std::vector<BranchNode> BranchingRule::branch(const BranchNode& branch, const VectorX& x) const {
  std::size_t chosen = elements_.size();
  double largest = -1;
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    if (!is_open(branch, k) || !(range_fraction(elements_[k], x) > largest)) continue;
    largest = range_fraction(elements_[k], x);
    chosen = k;
  }
  if (chosen < elements_.size()) return branch_on_element(branch, chosen);
  int number = -1;
  double max_distance = -1;
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    const std::vector<double>& values = problem_.variables[i].discrete_values;
    const auto k = static_cast<Eigen::Index>(i);
    if (values.empty() || branch.lower[k] == branch.upper[k]) continue;
    const auto above = std::lower_bound(values.begin(), values.end(), x[k]);
    double distance = above != values.end() ? *above - x[k] : std::numeric_limits<double>::infinity();
    if (above != values.begin()) distance = std::min(distance, x[k] - *std::prev(above));
    distance /= values.back() - values.front();
    if (!(distance > max_distance)) continue;
    max_distance = distance;
    number = static_cast<int>(i);
  }
  return branch_on_value(branch, number, x[number]);
}

std::optional<BranchNode> BranchingRule::leaf_at(const BranchNode& branch, const VectorX& x) const {
  BranchNode leaf = branch;
  for (std::size_t k = 0; k < elements_.size(); ++k)
    if (leaf.element_states[k] == BranchNode::ElementState::undecided &&
        range_fraction(elements_[k], x) < unused_element_threshold)
      leaf.element_states[k] = BranchNode::ElementState::excluded;
  if (!propagate(leaf) || !is_leaf(leaf)) return std::nullopt;
  return leaf;
}

std::vector<BranchNode> BranchingRule::branch_on_element(const BranchNode& branch, std::size_t k) const {
  std::vector<BranchNode> children(2, branch);
  children[0].element_states[k] = BranchNode::ElementState::excluded;
  children[1].element_states[k] = BranchNode::ElementState::kept;
  return children;
}

std::vector<BranchNode> BranchingRule::branch_on_value(const BranchNode& branch, int number, double at) const {
  const std::vector<double>& values = variable(problem_, number).discrete_values;
  const double range = values.back() - values.front(),
               value = std::clamp(at, branch.lower[number], branch.upper[number]);
  const auto above = std::lower_bound(values.begin(), values.end(), value - discrete_value_tolerance * range);
  std::vector<BranchNode> children;
  const auto add = [&](double lower, double upper) {
    if (lower > upper || lower > branch.upper[number] || upper < branch.lower[number]) return;
    children.push_back(branch);
    children.back().lower[number] = std::max(lower, branch.lower[number]);
    children.back().upper[number] = std::min(upper, branch.upper[number]);
  };
  const double infinite = std::numeric_limits<double>::infinity();
  if (above != values.end() && *above <= value + discrete_value_tolerance * range) {
    if (above != values.begin()) add(-infinite, *std::prev(above));
    if (std::next(above) != values.end()) add(*std::next(above), infinite);
    add(*above, *above);
    return children;
  }
  const bool is_upper_nearer = *above - value < value - *std::prev(above);
  if (is_upper_nearer) add(-infinite, *std::prev(above));
  add(*above, infinite);
  if (!is_upper_nearer) add(-infinite, *std::prev(above));
  return children;
}

VariableDomain BranchingRule::node_domain(const BranchNode& branch) const {
  VariableDomain domain{branch.lower, branch.upper, {}};
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (count(branch, g, BranchNode::ElementState::undecided) == 0) continue;
    VectorX coefficients = VectorX::Zero(branch.lower.size());
    bool positive = true;
    for (std::size_t k = 0; k < elements_.size(); ++k) {
      if (elements_[k].group != g || branch.element_states[k] != BranchNode::ElementState::undecided) continue;
      const int i = elements_[k].numbers.front();  // at most the full range
      positive = positive && branch.lower[i] >= 0 && coefficients[i] == 0;
      coefficients[i] = 1 / variable(problem_, i).upper;
    }
    const int remaining = groups_[g] - count(branch, g, BranchNode::ElementState::kept);
    if (positive && coefficients.allFinite()) domain.linear_limits.emplace_back(coefficients, remaining);
  }
  if (all_different_.is_empty()) return domain;
  for (auto& limit : all_different_.sum_limits(branch.lower, branch.upper, list_present(branch)))
    domain.linear_limits.push_back(std::move(limit));
  return domain;
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
  DesignProblem restricted = problem;
  restricted.cardinality_constraints.clear();
  restricted.all_different.clear();
  for (std::size_t i = 0; i < restricted.variables.size(); ++i) {
    DesignVariable& variable = restricted.variables[i];
    const auto k = static_cast<Eigen::Index>(i);
    variable.discrete_values.clear();
    variable.lower = branch.lower[k];
    variable.upper = branch.upper[k];
    variable.start = std::clamp(variable.start, variable.lower, variable.upper);
  }
  restricted.search.max_time = seconds;
  restricted.is_single_pass = true;
  return restricted;
}

NodeBounds::GeometryRelaxation::GeometryRelaxation(const DesignProblem& full_problem, const BranchNode& branch)
    : problem(restrict_to_node(full_problem, branch, full_problem.search.max_time)),
      budget(full_problem.search.max_time),
      context(problem, budget) {
  if (context.classification.has_geometric()) return;
  conditions = context.conditions_at(context.scaling.start());
  if (conditions.status != ConditionsStatus::done) return;
  std::vector<AffineFigure> figures;
  const DesignModel::Capabilities capabilities = full_problem.model->capabilities();
  if (full_problem.objective && capabilities.has_convex_terms)
    if (auto convex_terms = context.convex_terms(context.scaling.start(), FigureSampling::full))
      figures = std::move(*convex_terms);
  std::vector<ConvexLimit> limits;
  if (capabilities.has_convex_limits)
    if (auto convex_limits = context.convex_limits(context.scaling.start())) limits = std::move(*convex_limits);
  const ConditionResidual rows(context, conditions);
  const auto condition_variables = find_condition_variables(context, conditions, context.scaling.start());
  const VectorX at_start = rows.evaluate_from_mechanism(context.scaling.start());
  std::vector<int> variable_rows;
  for (int k = 0; k < rows.size(); ++k) {
    if (!condition_variables[static_cast<std::size_t>(k)].empty()) {
      variable_rows.push_back(k);
      continue;
    }
    fixed_residual = std::hypot(fixed_residual, at_start[k]);
    if (k < conditions.parameter_rows() && !(std::abs(at_start[k]) < 1e-10)) is_infeasible = true;
  }
  const auto terms = static_cast<Eigen::Index>(
      conditions::list_terms(context.classification.base_mechanism, context.options.loose_springs).size());
  relaxation.emplace(context, rows.matrix()(variable_rows, Eigen::all).leftCols(terms), figures, limits);
}

const NodeBounds::GeometryRelaxation* NodeBounds::relaxation_at(const BranchNode& branch) {
  const auto is_free = [&](int i) { return branch.lower[i] != branch.upper[i]; };
  if (std::any_of(outer_.begin(), outer_.end(), is_free)) return nullptr;
  const VectorX outer = branch.lower(outer_);
  if (!geometry_relaxation_ || geometry_relaxation_->outer != outer) {
    BranchNode geometry_node = branch;
    for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (std::find(outer_.begin(), outer_.end(), static_cast<int>(i)) != outer_.end()) continue;
      geometry_node.lower[k] = problem_.variables[i].lower;
      geometry_node.upper[k] = problem_.variables[i].upper;
    }
    auto new_relaxation = std::make_unique<GeometryRelaxation>(problem_, geometry_node);
    new_relaxation->outer = outer;
    geometry_relaxation_ = std::move(new_relaxation);
  }
  return geometry_relaxation_->relaxation && geometry_relaxation_->relaxation->is_complete()
             ? geometry_relaxation_.get()
             : nullptr;
}

/// Variables that are not unknowns of the convex relaxation must be fixed before it exists.
void NodeBounds::find_outer(const BranchNode& root) {
  if (is_outer_known_) return;
  is_outer_known_ = true;
  if (relaxation_at(root) != nullptr) return;
  const SolverContext& context = geometry_relaxation_->context;
  for (int i = 0; i < context.scaling.size(); ++i)
    if (context.classification.is_geometric[static_cast<std::size_t>(i)]) outer_.push_back(i);
  if (geometry_relaxation_->relaxation)
    for (const int i : geometry_relaxation_->relaxation->outer())
      if (std::find(outer_.begin(), outer_.end(), i) == outer_.end()) outer_.push_back(i);
  geometry_relaxation_.reset();
}

const Conditions* NodeBounds::shared_conditions(const BranchNode& root) {
  find_outer(root);
  const bool is_shared =
      outer_.empty() && geometry_relaxation_ && geometry_relaxation_->conditions.status == ConditionsStatus::done;
  return is_shared &&
                 conditions::known_term_values(geometry_relaxation_->context.classification.base_mechanism).size() == 0
             ? &geometry_relaxation_->conditions
             : nullptr;
}

NodeBounds::Bound NodeBounds::operator()(const BranchNode& branch, const VariableDomain& domain,
                                         BranchObjective target) {
  find_outer(branch);
  Bound bound;
  const GeometryRelaxation* geometry_relaxation = relaxation_at(branch);
  if (geometry_relaxation == nullptr) return bound;
  bound.has_relaxation = true;
  if (target == BranchObjective::constrained_figure && geometry_relaxation->is_infeasible) {
    bound.is_feasible = false;
    return bound;
  }
  const RelaxationBound relaxation_bound = target == BranchObjective::constrained_figure
                                               ? geometry_relaxation->relaxation->minimise_constrained_figure(domain)
                                           : target == BranchObjective::figure
                                               ? geometry_relaxation->relaxation->minimise_figure(domain)
                                               : geometry_relaxation->relaxation->minimise_residual(domain);
  bound.x = relaxation_bound.x;
  bound.is_feasible = relaxation_bound.is_feasible && !(target == BranchObjective::constrained_figure &&
                                                        relaxation_bound.residual > relaxed_residual_tolerance);
  double lower_bound = target == BranchObjective::residual
                           ? std::hypot(relaxation_bound.residual, geometry_relaxation->fixed_residual)
                           : relaxation_bound.figure;
  if (target != BranchObjective::residual && problem_.objective && !(lower_bound >= problem_.objective->lower_bound))
    lower_bound = problem_.objective->lower_bound;
  if (std::isfinite(lower_bound)) bound.lower_bound = lower_bound;
  return bound;
}

namespace {

/// Relative difference below which values count as equal.
constexpr double pruning_tolerance = 1e-9;
/// Effort limits of a single leaf.
constexpr int max_leaf_restarts = 6, max_leaf_evaluations = 2000;
/// Fraction of the remaining time for a leaf without a convex relaxation, where lengths are searched, too.
constexpr double leaf_time_fraction = 0.25;

/// Whether all conditions are met that masses can meet.
bool has_met_conditions(const DesignOutcome& outcome) {
  if (is_success(outcome)) return true;
  return std::all_of(outcome.unmet_conditions.begin(), outcome.unmet_conditions.end(), [&](int row) {
    return row >= outcome.conditions.parameter_rows() &&
           std::find(outcome.unmet_fixed_conditions.begin(), outcome.unmet_fixed_conditions.end(), row) !=
               outcome.unmet_fixed_conditions.end();
  });
}

}  // namespace

std::optional<DiscreteCandidate> BranchAndBound::make_candidate(DesignOutcome outcome) const {
  if (outcome.status == DesignStatus::unsolved || outcome.status == DesignStatus::no_feasible_start)
    return std::nullopt;
  DiscreteCandidate candidate;
  const bool is_figure_first = problem_.objective && !problem_.objective->is_secondary;
  if (!has_met_conditions(outcome)) {
    candidate.value = is_figure_first ? outcome.objective : outcome.residuals_after.norm();
  } else if (!outcome.within_limits) {
    candidate.rank = DiscreteCandidate::Rank::limits_violated;
    candidate.value = max_limit_violation(outcome);
  } else {
    candidate.rank = DiscreteCandidate::Rank::exact;
    candidate.value = problem_.objective ? outcome.objective : 0;
  }
  if (!std::isfinite(candidate.value)) return std::nullopt;
  candidate.outcome = std::move(outcome);
  return candidate;
}

/// Whether any exact design suffices and one is known.
bool BranchAndBound::is_done() const {
  return target_ == BranchObjective::constrained_figure && !problem_.objective && result_.incumbent &&
         result_.incumbent->rank == DiscreteCandidate::Rank::exact;
}

bool BranchAndBound::is_comparable(const std::optional<DiscreteCandidate>& candidate) const {
  return candidate &&
         (target_ != BranchObjective::constrained_figure || candidate->rank == DiscreteCandidate::Rank::exact);
}

bool BranchAndBound::has_closed_gap(const DiscreteCandidate& candidate, double lower_bound) {
  return lower_bound >= candidate.value - relative_gap_tolerance * std::abs(candidate.value);
}

/// Lower bound of all wanted designs in a leaf.
double BranchAndBound::leaf_bound(const BranchNode& branch, const std::optional<DiscreteCandidate>& candidate,
                                  const DesignOutcome& outcome) const {
  const double infinite = std::numeric_limits<double>::infinity();
  const bool is_single_design = branch.lower == branch.upper;
  if (!is_comparable(candidate))
    return is_single_design || outcome.is_proved_infeasible ? infinite : branch.lower_bound;
  if (is_single_design || (target_ == BranchObjective::constrained_figure && !problem_.objective))
    return candidate->value;
  if (outcome.optimality != Optimality::proved_global) return branch.lower_bound;
  return target_ != BranchObjective::residual && has_closed_gap(*candidate, outcome.lower_bound)
             ? std::max(branch.lower_bound, outcome.lower_bound)
             : candidate->value;
}

DesignProblem BranchAndBound::make_leaf_problem(const UnprovedLeaf& leaf) const {
  DesignProblem leaf_problem = restrict_to_node(problem_, leaf.branch, budget_.remaining_time());
  if (leaf.relaxed_x.size() > 0) set_start(leaf_problem, leaf.relaxed_x);
  if (leaf.has_relaxation && target_ != BranchObjective::residual)
    leaf_problem.proved_lower_bound = leaf.branch.lower_bound;
  return leaf_problem;
}

void BranchAndBound::consider(const DiscreteCandidate& candidate) {
  const bool better = !result_.incumbent || candidate.rank < result_.incumbent->rank ||
                      (candidate.rank == result_.incumbent->rank && candidate.value < result_.incumbent->value);
  if (better) result_.incumbent = candidate;
}

/// Solves a leaf and raises its lower bound to what the result proves.
std::optional<DiscreteCandidate> BranchAndBound::search_leaf(const DesignProblem& leaf_problem, UnprovedLeaf& leaf) {
  ++node_counts_.designs;
  const DesignOutcome outcome = solve_design(leaf_problem);
  std::optional<DiscreteCandidate> candidate = make_candidate(outcome);
  leaf.branch.lower_bound = leaf_bound(leaf.branch, candidate, outcome);
  if (candidate) consider(*candidate);
  return candidate;
}

DesignProblem BranchAndBound::make_quick_leaf_problem(const UnprovedLeaf& leaf) const {
  DesignProblem leaf_problem = make_leaf_problem(leaf);
  leaf_problem.is_subproblem = true;
  leaf_problem.search.max_restarts = std::min(leaf_problem.search.max_restarts, max_leaf_restarts);
  leaf_problem.search.max_evaluations = std::min(leaf_problem.search.max_evaluations, max_leaf_evaluations);
  if (!leaf.has_relaxation)
    leaf_problem.search.max_time = std::max(1e-3, leaf_time_fraction * budget_.remaining_time());
  return leaf_problem;
}

/// If the solution of the relaxation uses few enough elements, it may be the best design of the whole node.
/// @return whether it is
bool BranchAndBound::solve_at_relaxed_solution(const BranchingRule& branching, const BranchNode& branch,
                                               const NodeBounds::Bound& bound) {
  if (!bound.has_relaxation || bound.x.size() == 0 || target_ != BranchObjective::constrained_figure) return false;
  std::optional<BranchNode> part = branching.leaf_at(branch, bound.x);
  if (!part) return false;
  UnprovedLeaf leaf{std::move(*part), true, {}, bound.x};
  DesignProblem leaf_problem = make_quick_leaf_problem(leaf);
  leaf_problem.search.max_restarts = 1;
  const std::optional<DiscreteCandidate> candidate = search_leaf(leaf_problem, leaf);
  if (!is_comparable(candidate) || !has_closed_gap(*candidate, branch.lower_bound)) return false;
  result_.lower_bound = std::min(result_.lower_bound, branch.lower_bound);
  return true;
}

std::optional<DiscreteCandidate> BranchAndBound::solve_node(BranchNode node, double max_figure) {
  result_ = {};
  const NodeBounds::Bound bound = bounds_(node, {node.lower, node.upper, {}}, BranchObjective::constrained_figure);
  if (!bound.has_relaxation || !bound.is_feasible || bound.lower_bound > max_figure) return std::nullopt;
  target_ = BranchObjective::constrained_figure;
  node.lower_bound = bound.lower_bound;
  UnprovedLeaf leaf{std::move(node), true, {}, bound.x};
  return search_leaf(make_quick_leaf_problem(leaf), leaf);
}

std::optional<DiscreteCandidate> BranchAndBound::solve_first_leaf(const BranchingRule& branching,
                                                                  BranchObjective target, double seconds) {
  target_ = target;
  result_ = {};
  const VectorX start = start_values(problem_);
  BranchNode node = branching.root();
  bool is_possible = branching.propagate(node);
  while (is_possible && !branching.is_leaf(node)) {
    std::vector<BranchNode> children = branching.branch(node, start);
    const auto next =
        std::find_if(children.begin(), children.end(), [&](BranchNode& child) { return branching.propagate(child); });
    is_possible = next != children.end();
    if (is_possible) node = std::move(*next);
  }
  if (!is_possible) return std::nullopt;
  UnprovedLeaf leaf{std::move(node), false, {}, start};
  DesignProblem leaf_problem = make_quick_leaf_problem(leaf);
  leaf_problem.search.max_time = seconds;
  return search_leaf(leaf_problem, leaf);
}

void BranchAndBound::solve_leaf(BranchNode branch, const NodeBounds::Bound& bound) {
  UnprovedLeaf leaf{std::move(branch), bound.has_relaxation, {}, bound.x};
  leaf.candidate = search_leaf(make_quick_leaf_problem(leaf), leaf);
  if (is_comparable(leaf.candidate) && has_closed_gap(*leaf.candidate, leaf.branch.lower_bound))
    result_.lower_bound = std::min(result_.lower_bound, leaf.branch.lower_bound);
  else if (leaf.branch.lower_bound < std::numeric_limits<double>::infinity())
    unproved_leaves_.push_back(std::move(leaf));
}

/// Searches the leaves again that may contain better designs, as problems of their own from the spec's start values:
/// first those with the best designs so far.
void BranchAndBound::search_unproved_leaves() {
  const auto is_better = [](const UnprovedLeaf& a, const UnprovedLeaf& b) {
    if (!a.candidate || !b.candidate) return a.candidate.has_value() && !b.candidate;
    if (a.candidate->rank != b.candidate->rank) return a.candidate->rank < b.candidate->rank;
    return a.candidate->value < b.candidate->value;
  };
  std::stable_sort(unproved_leaves_.begin(), unproved_leaves_.end(), is_better);
  const bool has_choices = !problem_.cardinality_constraints.empty();  // combinations of sizes are too many
  for (std::size_t k = 0; has_choices && k < unproved_leaves_.size() && !is_done() && !budget_.is_spent(); ++k) {
    UnprovedLeaf& leaf = unproved_leaves_[k];
    if (is_pruned(leaf.branch.lower_bound)) continue;
    DesignProblem leaf_problem = restrict_to_node(
        problem_, leaf.branch, budget_.remaining_time() / static_cast<double>(unproved_leaves_.size() - k + 1));
    search_leaf(leaf_problem, leaf);
  }
  for (const UnprovedLeaf& leaf : unproved_leaves_) {
    result_.lower_bound = std::min(result_.lower_bound, leaf.branch.lower_bound);
    if (target_ == BranchObjective::constrained_figure && !is_comparable(result_.incumbent) &&
        leaf.branch.lower_bound < std::numeric_limits<double>::infinity())
      result_.is_exhausted = false;
  }
}

/// Whether nothing above the bound is wanted, because a design as good is known.
bool BranchAndBound::is_pruned(double lower_bound) const {
  return is_comparable(result_.incumbent) &&
         lower_bound >= result_.incumbent->value - pruning_tolerance * std::abs(result_.incumbent->value);
}

void BranchAndBound::process_node(const BranchingRule& branching, BranchNode branch) {
  if (!branching.propagate(branch)) return;
  ++node_counts_.branches;
  const NodeBounds::Bound bound = bounds_(branch, branching.node_domain(branch), target_);
  if (bound.has_relaxation && !bound.is_feasible) return;
  if (bound.has_relaxation) branch.lower_bound = std::max(branch.lower_bound, bound.lower_bound);
  if (is_pruned(branch.lower_bound)) {
    result_.lower_bound = std::min(result_.lower_bound, branch.lower_bound);
    return;
  }
  if (branching.is_leaf(branch)) return solve_leaf(std::move(branch), bound);
  if (solve_at_relaxed_solution(branching, branch, bound)) return;
  const VectorX x = bound.x.size() > 0 ? bound.x : VectorX((branch.lower + branch.upper) / 2);
  for (BranchNode& child : branching.branch(branch, x)) open_.push_back(std::move(child));
}

BranchAndBoundResult BranchAndBound::run(const BranchingRule& branching, BranchObjective target) {
  target_ = target;
  result_ = {};
  unproved_leaves_.clear();
  open_ = {branching.root()};
  while (!open_.empty() && !is_done() && !budget_.is_spent()) {
    const BranchNode next = std::move(open_.back());
    open_.pop_back();
    process_node(branching, next);
  }
  search_unproved_leaves();
  if (is_done()) return std::move(result_);
  for (const BranchNode& node : open_) {
    result_.is_exhausted = false;
    result_.lower_bound = std::min(result_.lower_bound, node.lower_bound);
  }
  return std::move(result_);
}

}  // namespace balance::design
