#include "balance/design/discrete_search.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

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
