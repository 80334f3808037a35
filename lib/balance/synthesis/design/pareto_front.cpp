#include "balance/synthesis/design/pareto_front.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/elementary.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"
#include "balance/synthesis/design/case_objective.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/load_case_study.hpp"
#include "balance/synthesis/design/objective_builder.hpp"
#include "balance/synthesis/design/optional_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace balance {

// Single designs of a front, out of one budget.

/// min figure `minimized`, the others within `limits`.
struct EpsilonConstraint {
  int minimized = 0;
  VectorX limits;  ///< per figure; NaN: none
  VectorX start;   ///< free numbers; empty: the spec's
};

class EpsilonConstraintSearch {
 public:
  /// @param planned searches that the budget is shared among
  EpsilonConstraintSearch(const DesignSpace& space, const DesignStudyOptions& options, int planned);

  int figure_count() const { return static_cast<int>(request_.figures.size()); }
  /// Without limits. @return none was found
  std::optional<ParetoPoint> solve(const EpsilonConstraint& wish);
  /// What the last search found, if it was no design.
  DesignReport failure() const;
  /// Completes a point with what its design does with the loads of all cases.
  void add_load_cases(ParetoPoint& point) const;
  bool is_budget_exhausted() const { return stopped_; }
  int search_count() const { return searches_; }
  VectorX no_limits() const;

 private:
  bool has_cases() const { return base_.start.design.cases.size() > 0; }
  DesignSpace space_for(const EpsilonConstraint& wish) const;
  DesignStudyOptions options_for_one();
  void search(ParetoPoint& point, const DesignStudyOptions& options) const;
  VectorX values_at(const VectorX& x) const;

  ParetoRequest request_;
  DesignSpace base_;  ///< asks for the first figure alone
  DesignStudyOptions options_;
  std::optional<LoadCaseStudy> cases_;
  DesignProblem problem_;
  std::vector<Objective> merits_;
  ParetoPoint failure_;
  double begin_, before_ = 0;  ///< [s] of computing: at the start, spent in searches that are over
  int planned_, searches_ = 0;
  bool stopped_ = false;
};

// What single points of a front are to each other, and as designs of their own.

namespace {

/// The springs whose ends' products are parameters of the conditions.
FreeSprings springs_with_products(const Conditions& conditions, const DesignReport& report) {
  FreeSprings loose(report.study_before.mechanism.springs.size(), false);
  for (const Parameter& p : conditions.parameters)
    if (p.owner_kind == ParameterOwner::spring && p.slot > 0) loose[static_cast<std::size_t>(p.index)] = true;
  return loose;
}

}  // namespace

bool dominates(const VectorX& a, const VectorX& b, const VectorX& slack) {
  return (a.array() <= b.array()).all() && (a.array() < (b - slack).array()).any();
}

int find_compromise_point(const ParetoFront& front) {
  if (front.points.empty()) throw std::invalid_argument("the front has no points");
  VectorX least = front.points.front().values, most = least;
  for (const ParetoPoint& point : front.points) {
    least = least.cwiseMin(point.values);
    most = most.cwiseMax(point.values);
  }
  const auto distance = [&](const ParetoPoint& point) {
    double sum = 0;
    for (Eigen::Index j = 0; j < least.size(); ++j)
      if (most[j] > least[j]) sum += elementary::pow((point.values[j] - least[j]) / (most[j] - least[j]), 2);
    return sum;
  };
  const auto nearest = std::min_element(front.points.begin(), front.points.end(),
                                        [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return static_cast<int>(nearest - front.points.begin());
}

DesignReport make_pareto_design(const DesignSpace& space, const ParetoPoint& point, bool trajectories) {
  DesignReport report = point.report;
  report.free_numbers = space.start.free_numbers;
  report.before = space.start_values();
  report.cardinality_constraints = list_optional_elements(space);
  DesignSpace own = point.space;
  own.start.free_numbers = report.free_numbers;
  measure_design(own, report);
  const Conditions& conditions = report.outcome.conditions;
  if (report.outcome.residuals_before.size() > 0)
    report.outcome.residuals_before = scaled_residuals(
        conditions, term_values(report.study_before.mechanism, springs_with_products(conditions, report)));
  if (trajectories) {
    compare_trajectories(report);
    return report;
  }
  for (LoadCaseReport& one : report.load_cases) one.runs.clear();
  if (report.adaptive)
    for (LoadCaseReport& one : report.adaptive->fixed_design_cases) one.runs.clear();
  return report;
}

namespace {

constexpr double min_search_time = 1e-3;

std::string sum_text(const std::vector<ObjectiveTerm>& terms) {
  std::string text;
  for (const ObjectiveTerm& term : terms)
    text += (text.empty() ? "" : " + ") + (term.weight == 1 ? "" : fmt::format("{:g} ", term.weight)) +
            objective_term_name(term);
  return text;
}

/// Of a single figure; a sum has none.
std::string sum_unit(const std::vector<ObjectiveTerm>& terms, const Mechanism& mechanism) {
  const ObjectiveTerm& term = terms.front();
  if (terms.size() != 1 || term.weight != 1) return "";
  if (term.size == ObjectiveTerm::Size::added_inertia) return "kg m^2";
  if (term.size != ObjectiveTerm::Size::none) return "kg";
  return term.run == ObjectiveTerm::RunMeasure::duration ? "s" : find_metric_unit(mechanism, term.quantity);
}

DesignSpace without_front(DesignSpace space) {
  if (!space.start.design.front) throw std::invalid_argument("the spec asks for no front");
  space.start.design.minimize = space.start.design.front.figures.front();
  space.start.design.front = {};
  return space;
}

DesignStudyOptions own_terms(DesignStudyOptions options) {
  options.minimize.clear();
  options.compare_trajectories = false;
  return options;
}

bool is_design(const DesignOutcome& outcome) {
  return (outcome.status == DesignStatus::balanced || outcome.status == DesignStatus::no_goal) && outcome.within_limits;
}

}  // namespace

EpsilonConstraintSearch::EpsilonConstraintSearch(const DesignSpace& space, const DesignStudyOptions& options,
                                                 int planned)
    : request_(space.start.design.front),
      base_(without_front(space)),
      options_(own_terms(options)),
      begin_(thread_cpu_time()),
      planned_(planned) {
  if (has_cases()) cases_.emplace(base_, options_);
  problem_ = has_cases() ? cases_->problem() : make_design_problem(base_, options_);
  const FreeSprings& loose = problem_.options.loose_springs;
  const CaseAggregation across = base_.start.design.cases.aggregation;
  for (const std::vector<ObjectiveTerm>& terms : request_.figures)
    merits_.push_back(has_cases() ? build_case_objective(cases_->cases(), terms, across, loose)
                                  : build_objective(base_, terms, base_.start_values(), loose));
}

VectorX EpsilonConstraintSearch::no_limits() const {
  return VectorX::Constant(figure_count(), std::numeric_limits<double>::quiet_NaN());
}

DesignSpace EpsilonConstraintSearch::space_for(const EpsilonConstraint& wish) const {
  DesignSpace own = base_;
  DesignRequest& design = own.start.design;
  design.minimize = request_.figures[static_cast<std::size_t>(wish.minimized)];
  for (int j = 0; j < figure_count(); ++j) {
    if (std::isnan(wish.limits[j])) continue;
    const auto& terms = request_.figures[static_cast<std::size_t>(j)];
    const std::string unit = sum_unit(terms, base_.start.mechanism);
    design.subject_to.push_back(
        {fmt::format("{} <= {:g}{}{}", sum_text(terms), wish.limits[j], unit.empty() ? "" : " ", unit), terms, false,
         wish.limits[j], unit, base_.start.design.cases.aggregation});
  }
  for (Eigen::Index i = 0; i < wish.start.size(); ++i) {
    FreeNumber& number = own.start.free_numbers[static_cast<std::size_t>(i)];
    number.start = std::clamp(wish.start[i], number.lower, number.upper);
  }
  return own;
}

/// Its share of what is left; the first ones leave to the others what they do not need.
DesignStudyOptions EpsilonConstraintSearch::options_for_one() {
  DesignStudyOptions one = options_;
  const double left = options_.search.max_time - (thread_cpu_time() - begin_);
  one.search.max_time = std::max(min_search_time, left / std::max(1, planned_ - searches_));
  if (!options_.on_progress) return one;
  one.on_progress = [this](const SearchProgress& progress) {
    SearchProgress all = progress;
    all.seconds += before_;
    all.max_time = options_.search.max_time;
    stopped_ = stopped_ || !options_.on_progress(all);
    return !stopped_;
  };
  return one;
}

VectorX EpsilonConstraintSearch::values_at(const VectorX& x) const {
  VectorX values(figure_count());
  for (int j = 0; j < figure_count(); ++j)
    values[j] = design::evaluate_figure(problem_, merits_[static_cast<std::size_t>(j)], x);
  return values;
}

/// With load cases what else is told of a design takes as long as finding it, and waits until the front is known.
void EpsilonConstraintSearch::search(ParetoPoint& point, const DesignStudyOptions& options) const {
  if (!has_cases()) {
    point.report = run_design_study(point.space, options);
    return;
  }
  const LoadCaseStudy study(point.space, options);
  DesignReport& report = point.report;
  report.free_numbers = point.space.start.free_numbers;
  report.before = point.space.start_values();
  report.cardinality_constraints = list_optional_elements(point.space);
  report.outcome = solve_design(study.problem());
  if (report.outcome.x.size() == 0) return;
  point.all_cases = report.outcome.x;
  report.outcome.x = study.cases().values(0, point.all_cases);
}

void EpsilonConstraintSearch::add_load_cases(ParetoPoint& point) const {
  if (!has_cases() || point.all_cases.size() == 0) return;
  DesignStudyOptions whole = options_;
  whole.compare_trajectories = true;
  point.report.outcome.x = point.all_cases;
  LoadCaseStudy(point.space, whole).describe(point.report);
  measure_design(point.space, point.report);
}

DesignReport EpsilonConstraintSearch::failure() const {
  ParetoPoint point = failure_;
  add_load_cases(point);
  return point.report;
}

std::optional<ParetoPoint> EpsilonConstraintSearch::solve(const EpsilonConstraint& wish) {
  before_ = thread_cpu_time() - begin_;
  stopped_ = stopped_ || (searches_ > 0 && before_ >= options_.search.max_time);
  if (stopped_) return std::nullopt;
  ParetoPoint point;
  point.space = space_for(wish);
  search(point, options_for_one());
  ++searches_;
  const DesignOutcome& outcome = point.report.outcome;
  if (is_design(outcome)) point.values = values_at(has_cases() ? point.all_cases : outcome.x);
  if (point.values.size() == 0 || !point.values.allFinite()) {
    failure_ = std::move(point);
    return std::nullopt;
  }
  point.minimized = wish.minimized;
  point.limits = wish.limits;
  point.lower_bound = outcome.lower_bound;
  return point;
}

namespace {

/// Parts of the front's extent: by which a figure may be above its least one at an end, and by which designs differ.
constexpr double anchor_tolerance = 1e-5, min_point_separation = 1e-4;
/// A gap of this part of the extent is none.
constexpr double front_gap_tolerance = 1e-5;
/// Searches per point wanted, where some find nothing new.
constexpr int max_searches_per_point = 3;
constexpr int max_anchor_rounds = 4;

class ParetoFrontBuilder {
 public:
  ParetoFrontBuilder(const DesignSpace& space, const DesignStudyOptions& options)
      : wanted_(space.start.design.front.max_points),
        figures_(static_cast<int>(space.start.design.front.figures.size())),
        search_(space, options, wanted_ + figures_ * figures_) {}

  ParetoFront run() {
    if (find_anchors()) figures_ == 2 ? fill_curve() : fill_grid();
    drop_dominated();
    if (!front_.points.empty()) update_extents();
    for (ParetoPoint& point : front_.points) point.optimality = assess_point(point), search_.add_load_cases(point);
    front_.searches = search_.search_count();
    front_.is_budget_exhausted = search_.is_budget_exhausted();
    return std::move(front_);
  }

 private:
  using Places = std::vector<ParetoPoint>;

  /// Every figure alone, then the others as small as that allows. @return there is something between the ends
  bool find_anchors() {
    for (int i = 0; i < figures_; ++i) {
      auto alone = search_.solve({i, search_.no_limits(), {}});
      if (!alone && front_.points.empty()) front_.failure = search_.failure();
      if (!alone) return false;
      const DesignOutcome& outcome = alone->report.outcome;
      front_.anchors.push_back({alone->values[i], outcome.lower_bound, outcome.optimality});
      front_.points.push_back(std::move(*alone));
    }
    update_extents();
    for (int i = 0; i < figures_; ++i) improve_anchor(front_.points[static_cast<std::size_t>(i)], i);
    update_extents();
    if ((extent_.array() > 0).any()) return true;
    front_.notes.emplace_back("the figures are no trade-off: one design is the best in all of them");
    front_.points.erase(front_.points.begin() + 1, front_.points.end());
    return false;
  }

  /// Least and extent of each figure over all points; an extent within round-off is none.
  void update_extents() {
    least_ = front_.points.front().values;
    VectorX most = least_;
    for (const ParetoPoint& point : front_.points) {
      least_ = least_.cwiseMin(point.values);
      most = most.cwiseMax(point.values);
    }
    extent_ = most - least_;
    for (Eigen::Index j = 0; j < extent_.size(); ++j)
      if (!(extent_[j] > 1e-7 * std::abs(most[j]))) extent_[j] = 0;
  }

  Optimality assess_point(const ParetoPoint& point) const {
    const bool proved = point.report.outcome.optimality == Optimality::proved_global;
    if (proved || point.gap() <= front_gap_tolerance * extent_[point.minimized]) return Optimality::proved_global;
    return point.report.outcome.optimality == Optimality::budget_exhausted ? Optimality::budget_exhausted
                                                                           : Optimality::local_optimum;
  }

  VectorX separation() const { return min_point_separation * extent_; }

  /// Again, from there and from another end's design, while that helps and nothing is proved.
  void improve_anchor(ParetoPoint& end, int i) {
    const double allowed = end.values[i];
    for (int round = 0; round < max_anchor_rounds; ++round) {
      const VectorX before = end.values;
      const ParetoPoint& other = front_.points[static_cast<std::size_t>((i + 1) % figures_)];
      refine_anchor(end, i, allowed, (round % 2 == 0 ? end : other).report.outcome.x);
      const bool better = ((before - end.values).array() > separation().array()).any();
      if (end.report.outcome.optimality == Optimality::proved_global || search_.is_budget_exhausted()) return;
      if (round > 0 && !better) return;
    }
  }

  /// @param allowed of figure i
  void refine_anchor(ParetoPoint& end, int i, double allowed, const VectorX& start) {
    VectorX limits = search_.no_limits();
    limits[i] = allowed + std::max(anchor_tolerance * extent_[i], 1e-9 * std::abs(allowed));
    for (int k = 1; k < figures_; ++k) {
      const int j = (i + k) % figures_;
      if (extent_[i] == 0 && extent_[j] == 0) continue;
      VectorX others = limits;
      others[j] = std::numeric_limits<double>::quiet_NaN();
      auto better = search_.solve({j, others, k == 1 ? start : end.report.outcome.x});
      if (!better) return;
      if (better->values[j] <= end.values[j]) end = std::move(*better);
      limits[j] = end.values[j] + std::max(anchor_tolerance * extent_[j], 1e-9 * std::abs(end.values[j]));
    }
  }

  void sort() {
    std::stable_sort(front_.points.begin(), front_.points.end(),
                     [](const ParetoPoint& a, const ParetoPoint& b) { return a.values[0] < b.values[0]; });
  }

  bool is_new(const ParetoPoint& point) const {
    return std::none_of(front_.points.begin(), front_.points.end(), [&](const ParetoPoint& other) {
      return ((point.values - other.values).cwiseAbs().array() <= separation().array()).all();
    });
  }

  /// Of designs that do not differ the first stays.
  void drop_dominated() {
    if (front_.points.empty()) return;
    update_extents();
    sort();
    const Places all = std::exchange(front_.points, {});
    for (const ParetoPoint& one : all) {
      const bool worse = std::any_of(all.begin(), all.end(), [&](const ParetoPoint& other) {
        return dominates(other.values, one.values, VectorX::Zero(figures_));
      });
      if (!worse && is_new(one)) front_.points.push_back(one);
    }
  }

  /// Halves the longest open stretch between neighbours until there are enough points. What a better design makes dominated goes,
  /// and its stretch is searched again from the designs beside it.
  void fill_curve() {
    const int most = search_.search_count() + max_searches_per_point * wanted_;
    for (drop_dominated(); static_cast<int>(front_.points.size()) < wanted_ && search_.search_count() < most;) {
      const int k = find_longest_segment();
      if (k < 0) return;
      bisect_segment(static_cast<std::size_t>(k));
      if (search_.is_budget_exhausted()) return;
    }
  }

  double length(std::size_t k) const {
    return ((front_.points[k + 1].values - front_.points[k].values).array() / extent_.array()).matrix().norm();
  }

  std::pair<double, double> segment(std::size_t k) const {
    return {front_.points[k].values[0], front_.points[k + 1].values[0]};
  }

  int find_longest_segment() const {
    int longest = -1;
    for (std::size_t k = 0; k + 1 < front_.points.size(); ++k)
      if (closed_.count(segment(k)) == 0 && (longest < 0 || length(k) > length(static_cast<std::size_t>(longest))))
        longest = static_cast<int>(k);
    return longest;
  }

  void bisect_segment(std::size_t k) {
    const ParetoPoint &a = front_.points[k], &b = front_.points[k + 1];
    const VectorX change = ((b.values - a.values).array() / extent_.array()).abs();
    const int limited = change[1] >= change[0] ? 1 : 0;
    const ParetoPoint& within = limited == 1 ? b : a;
    EpsilonConstraint wish{1 - limited, search_.no_limits(), within.report.outcome.x};
    wish.limits[limited] = (a.values[limited] + b.values[limited]) / 2;
    const VectorX here = within.report.outcome.x, there = (limited == 1 ? a : b).report.outcome.x;
    auto found = search_.solve(wish);
    for (const VectorX& start : {VectorX((here + there) / 2), there}) {  // a search may stay where it starts
      if (found && is_new(*found)) break;
      wish.start = start;
      found = search_.solve(wish);
    }
    if (!found || !is_new(*found)) return void(closed_.insert(segment(k)));
    front_.points.push_back(std::move(*found));
    drop_dominated();
    update_extents();  // an end may have been dominated
  }

  /// Rows of points: the second figure is limited at places spread over its extent, and each row is spread over what that leaves to the
  /// third.
  void fill_grid() {
    const int side = std::max(2, static_cast<int>(std::sqrt(static_cast<double>(wanted_))));
    for (int row = 0; row < side && !search_.is_budget_exhausted(); ++row) fill_row(row / (side - 1.0), side);
  }

  void fill_row(double part, int side) {
    VectorX limits = search_.no_limits();
    limits[1] = least_[1] + std::max(std::max(part, anchor_tolerance) * extent_[1], 1e-9 * std::abs(least_[1]));
    const auto first = find_point_within(0, limits), last = find_point_within(2, limits);
    if (!first || !last) return;
    for (int column = 1; column + 1 < side; ++column) {
      limits[2] = last->values[2] + column / (side - 1.0) * (first->values[2] - last->values[2]);
      if (first->values[2] - last->values[2] > separation()[2]) find_point_within(0, limits);
    }
  }

  /// Kept if it is new. Where a limit is not reached, its figure may still become smaller for nothing; so may one without a limit.
  std::optional<ParetoPoint> find_point_within(int i, const VectorX& limits) {
    auto found = search_.solve({i, limits, min_violation_point(limits)});
    if (!found || !is_new(*found)) {  // a search may stay where it starts
      auto other = search_.solve({i, limits, {}});
      if (other && (!found || other->values[i] < found->values[i] || is_new(*other))) found = std::move(other);
    }
    if (!found) return found;
    for (int j = 0; j < figures_; ++j)
      if (j != i && !(found->values[j] >= limits[j] - separation()[j])) refine(*found, j);
    if (is_new(*found)) front_.points.push_back(*found);
    return found;
  }

  void refine(ParetoPoint& point, int j) {
    EpsilonConstraint wish{j, point.values, point.report.outcome.x};
    for (int i = 0; i < figures_; ++i)
      wish.limits[i] += std::max(anchor_tolerance * extent_[i], 1e-9 * std::abs(point.values[i]));
    wish.limits[j] = std::numeric_limits<double>::quiet_NaN();
    auto better = search_.solve(wish);
    if (better && better->values[j] <= point.values[j]) point = std::move(*better);
  }

  /// The known design that is least beyond the limits.
  VectorX min_violation_point(const VectorX& limits) const {
    const auto beyond = [&](const ParetoPoint& point) {
      double worst = -std::numeric_limits<double>::infinity();
      for (int j = 0; j < figures_; ++j)
        if (!std::isnan(limits[j]))
          worst = std::max(worst, (point.values[j] - limits[j]) / std::max(extent_[j], 1e-300));
      return worst;
    };
    const auto best =
        std::min_element(front_.points.begin(), front_.points.end(),
                         [&](const ParetoPoint& a, const ParetoPoint& b) { return beyond(a) < beyond(b); });
    return best->report.outcome.x;
  }

  int wanted_, figures_;
  EpsilonConstraintSearch search_;
  ParetoFront front_;
  VectorX least_, extent_;
  std::set<std::pair<double, double>>
      closed_;  ///< stretches, by the first figure's values, between which nothing was found
};

}  // namespace

ParetoFront compute_pareto_front(const DesignSpace& space, const DesignStudyOptions& options) {
  if (!space.start.design.front) throw std::invalid_argument("the spec asks for no front");
  return ParetoFrontBuilder(space, options).run();
}

}  // namespace balance
