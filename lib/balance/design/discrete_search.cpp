#include "balance/design/discrete_search.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

/// Values that differ by less than this part are as good as each other.
constexpr double as_good = 1e-9;
/// One design of many.
constexpr int restarts = 6, evaluations = 2000;
/// Part of the time left that one design may take where lengths are searched for, too.
constexpr double for_one = 0.25;

/// All that masses can do is done.
bool meets_conditions(const DesignOutcome& outcome) {
  if (outcome.status == DesignStatus::balanced || outcome.status == DesignStatus::not_asked) return true;
  return std::all_of(outcome.open.begin(), outcome.open.end(), [&](int row) {
    return row >= outcome.conditions.own_rows() &&
           std::find(outcome.unmet_fixed.begin(), outcome.unmet_fixed.end(), row) != outcome.unmet_fixed.end();
  });
}

}  // namespace

std::optional<SizedDesign> DiscreteSearch::rated(DesignOutcome outcome) const {
  if (outcome.status == DesignStatus::unsolved || outcome.status == DesignStatus::not_found) return std::nullopt;
  SizedDesign design;
  const bool by_figure = problem_.objective && !problem_.objective->size;
  if (!meets_conditions(outcome)) {
    design.value = by_figure ? outcome.objective : outcome.after.norm();
  } else if (!outcome.within_limits) {
    design.rank = SizedDesign::Rank::beyond_limits;
    for (const LimitOutcome& limit : outcome.limits) design.value = std::max(design.value, limit.violation);
  } else {
    design.rank = SizedDesign::Rank::exact;
    design.value = problem_.objective ? outcome.objective : 0;
  }
  if (!std::isfinite(design.value)) return std::nullopt;
  design.outcome = std::move(outcome);
  return design;
}

/// Any exact design does, and one is known.
bool DiscreteSearch::done() const {
  return wanted_ == Wanted::exact && !problem_.objective && walk_.best && walk_.best->rank == SizedDesign::Rank::exact;
}

/// What no wanted design of a decided branch is below.
double DiscreteSearch::bound_of(const Branch& branch, double least, const std::optional<SizedDesign>& design,
                                const DesignOutcome& outcome) const {
  const double infinite = std::numeric_limits<double>::infinity();
  const bool single = branch.lower == branch.upper;
  const bool suits = design && (wanted_ != Wanted::exact || design->rank == SizedDesign::Rank::exact);
  if (!suits) return single || outcome.proved ? infinite : least;
  const bool proved =
      outcome.optimality == Optimality::proved_best || (wanted_ == Wanted::exact && !problem_.objective);
  if (single || proved) return design->value;
  return design->value <= least + bound_falls_short * std::abs(least) ? design->value : least;
}

void DiscreteSearch::try_design(const Branch& branch, double least, bool bounded) {
  DesignProblem part = within(problem_, branch, budget_.left());
  part.inner = true;
  part.search.restarts = std::min(part.search.restarts, restarts);
  part.search.evaluations = std::min(part.search.evaluations, evaluations);
  if (!bounded) part.search.seconds = std::max(1e-3, for_one * budget_.left());
  ++steps_.designs;
  DesignOutcome outcome = solve(part);
  std::optional<SizedDesign> design = rated(outcome);
  const double bound = bound_of(branch, least, design, outcome);
  walk_.bound = std::min(walk_.bound, bound);
  const bool found = design && design->rank == SizedDesign::Rank::exact;
  if (wanted_ == Wanted::exact && !found && bound < std::numeric_limits<double>::infinity()) walk_.closed = false;
  if (!design) return;
  const bool better = !walk_.best || design->rank < walk_.best->rank ||
                      (design->rank == walk_.best->rank && design->value < walk_.best->value);
  if (better) walk_.best = std::move(design);
}

void DiscreteSearch::look_at(const Branching& branching, Branch branch) {
  if (!branching.settle(branch)) return;
  ++steps_.branches;
  const DiscreteBounds::Answer bound = bounds_(branch, branching.narrowed(branch), wanted_);
  if (bound.known && !bound.possible) return;
  const double least = bound.known ? bound.least : -std::numeric_limits<double>::infinity();
  const bool exact = walk_.best && walk_.best->rank == SizedDesign::Rank::exact;
  const bool comparable = walk_.best && (wanted_ != Wanted::exact || exact);
  if (comparable && least >= walk_.best->value - as_good * std::abs(walk_.best->value)) {
    walk_.bound = std::min(walk_.bound, least);
    return;
  }
  if (branching.decided(branch)) return try_design(branch, least, bound.known);
  branch.least = least;
  const VectorX x = bound.x.size() > 0 ? bound.x : VectorX((branch.lower + branch.upper) / 2);
  for (Branch& part : branching.split(branch, x)) open_.push_back(std::move(part));
}

Walk DiscreteSearch::run(const Branching& branching, Wanted wanted) {
  wanted_ = wanted;
  walk_ = {};
  open_ = {branching.root()};
  while (!open_.empty() && !done() && !budget_.spent()) {
    const Branch next = std::move(open_.back());
    open_.pop_back();
    look_at(branching, next);
  }
  if (done()) return std::move(walk_);
  for (const Branch& rest : open_) {
    walk_.closed = false;
    walk_.bound = std::min(walk_.bound, rest.least);
  }
  return std::move(walk_);
}

}  // namespace balance::designing
