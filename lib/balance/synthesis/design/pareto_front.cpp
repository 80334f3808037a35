#include "balance/synthesis/design/pareto_front.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/elementary.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"
#include "balance/synthesis/design/assembly_continuation.hpp"
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

namespace balance::design {

// Searches for single designs of a front, sharing one budget.

/// Minimise figure `minimized` subject to `limits` on the others.
struct EpsilonConstraint {
  int minimized = 0;
  VectorX limits;  ///< of each figure; NaN: none
  VectorX start;   ///< free numbers; empty: the spec's
};

class EpsilonConstraintSearch {
 public:
  /// @param planned_searches number of searches that share the budget
  EpsilonConstraintSearch(const DesignSpace& space, const DesignStudyOptions& options, int planned_searches);

  int figure_count() const { return static_cast<int>(request_.figures.size()); }
  /// Solves one ε-constraint problem. @return std::nullopt if no design was found
  std::optional<ParetoPoint> solve(const EpsilonConstraint& constraint);
  /// The outcome of the last search that found no design.
  DesignReport failure() const;
  /// Completes the report of a point with the results of its design for all load cases.
  void add_load_cases(ParetoPoint& point) const;
  bool is_budget_exhausted() const { return is_budget_exhausted_; }
  int search_count() const { return searches_; }
  VectorX no_limits() const;
  /// A lower bound of figure j over all mechanisms: zero for masses and magnitudes.
  double known_lower_bound(int j) const { return objectives_[static_cast<std::size_t>(j)].lower_bound; }

 private:
  bool has_cases() const { return base_.start.design.cases.size() > 0; }
  DesignSpace make_constrained_space(const EpsilonConstraint& constraint) const;
  DesignStudyOptions make_search_options();
  void search(ParetoPoint& point, const DesignStudyOptions& options) const;
  VectorX values_at(const VectorX& x) const;

  study::ParetoRequest request_;
  DesignSpace base_;  ///< minimises the first figure only
  DesignStudyOptions options_;
  std::optional<LoadCaseStudy> cases_;
  DesignProblem problem_;
  std::vector<Objective> objectives_;
  ParetoPoint failure_;
  double start_time_, used_time_ = 0;  ///< CPU time [s]: at the start; used by previous searches
  int planned_searches_, searches_ = 0;
  bool is_budget_exhausted_ = false;
};

// Relations between the points of a front, and their designs.

namespace {

/// The springs whose products with end points are parameters of the conditions.
dynamics::FreeSprings springs_with_products(const Conditions& conditions, const DesignReport& report) {
  dynamics::FreeSprings loose(report.study_before.mechanism.springs.size(), false);
  for (const dynamics::Parameter& p : conditions.parameters)
    if (p.owner_kind == dynamics::ParameterOwner::spring && p.slot > 0) loose[static_cast<std::size_t>(p.index)] = true;
  return loose;
}

}  // namespace

bool dominates(const VectorX& a, const VectorX& b, const VectorX& slack) {
  return (a.array() <= b.array()).all() && (a.array() < (b - slack).array()).any();
}

int find_compromise_point(const ParetoFront& front) {
  if (front.points.empty()) throw std::invalid_argument("the front has no points");
  VectorX min_values = front.points.front().values, max_values = min_values;
  for (const ParetoPoint& point : front.points) {
    min_values = min_values.cwiseMin(point.values);
    max_values = max_values.cwiseMax(point.values);
  }
  const auto distance = [&](const ParetoPoint& point) {
    double sum = 0;
    for (Eigen::Index j = 0; j < min_values.size(); ++j)
      if (max_values[j] > min_values[j])
        sum += elementary::pow((point.values[j] - min_values[j]) / (max_values[j] - min_values[j]), 2);
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
  DesignSpace point_space = point.space;
  point_space.start.free_numbers = report.free_numbers;
  measure_design(point_space, report);
  const Conditions& conditions = report.outcome.conditions;
  if (report.outcome.residuals_before.size() > 0)
    report.outcome.residuals_before = scaled_residuals(
        conditions, conditions::term_values(report.study_before.mechanism, springs_with_products(conditions, report)));
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

DesignSpace without_front(DesignSpace space) {
  if (!space.start.design.front) throw std::invalid_argument("the spec has no front");
  space.start.design.minimize = space.start.design.front.figures.front();
  space.start.design.front = {};
  return space;
}

DesignStudyOptions own_terms(DesignStudyOptions options) {
  options.minimize.clear();
  options.compare_trajectories = false;
  options.motions = std::make_shared<MotionCache>();
  return options;
}

}  // namespace

EpsilonConstraintSearch::EpsilonConstraintSearch(const DesignSpace& space, const DesignStudyOptions& options,
                                                 int planned_searches)
    : request_(space.start.design.front),
      base_(follow_assembly_mode(without_front(space), keeps_assembly_mode(space.start.design, {}))),
      options_(own_terms(options)),
      start_time_(thread_cpu_time()),
      planned_searches_(planned_searches) {
  if (has_cases()) cases_.emplace(base_, options_);
  problem_ = has_cases() ? cases_->problem() : make_design_problem(base_, options_);
  const dynamics::FreeSprings& loose = problem_.options.loose_springs;
  const study::CaseAggregation across = base_.start.design.cases.aggregation;
  for (const std::vector<ObjectiveTerm>& terms : request_.figures)
    objectives_.push_back(has_cases() ? build_case_objective(cases_->cases(), terms, across, loose, *options_.motions)
                                      : build_objective(base_, terms, base_.start_values(), loose, *options_.motions));
}

VectorX EpsilonConstraintSearch::no_limits() const {
  return VectorX::Constant(figure_count(), std::numeric_limits<double>::quiet_NaN());
}

DesignSpace EpsilonConstraintSearch::make_constrained_space(const EpsilonConstraint& constraint) const {
  DesignSpace constrained_space = base_;
  study::DesignRequest& design = constrained_space.start.design;
  design.minimize = request_.figures[static_cast<std::size_t>(constraint.minimized)];
  for (int j = 0; j < figure_count(); ++j) {
    if (std::isnan(constraint.limits[j])) continue;
    const auto& terms = request_.figures[static_cast<std::size_t>(j)];
    const std::string unit = simulation::objective_unit(terms, base_.start.mechanism);
    design.subject_to.push_back(
        {fmt::format("{} <= {:g}{}{}", sum_text(terms), constraint.limits[j], unit.empty() ? "" : " ", unit), terms,
         false, constraint.limits[j], unit, base_.start.design.cases.aggregation});
  }
  for (Eigen::Index i = 0; i < constraint.start.size(); ++i) {
    FreeNumber& number = constrained_space.start.free_numbers[static_cast<std::size_t>(i)];
    number.start = std::clamp(constraint.start[i], number.lower, number.upper);
  }
  return constrained_space;
}

/// Options with an equal share of the remaining time; unused time is left to later searches.
DesignStudyOptions EpsilonConstraintSearch::make_search_options() {
  DesignStudyOptions search_options = options_;
  search_options.is_single_pass = true;
  search_options.settled_values = design::start_values(problem_);
  const double remaining_time = options_.search.max_time - (thread_cpu_time() - start_time_);
  search_options.search.max_time =
      std::max(min_search_time, remaining_time / std::max(1, planned_searches_ - searches_));
  if (!options_.on_progress) return search_options;
  search_options.on_progress = [this](const SearchProgress& progress) {
    SearchProgress total_progress = progress;
    total_progress.seconds += used_time_;
    total_progress.max_time = options_.search.max_time;
    is_budget_exhausted_ = is_budget_exhausted_ || !options_.on_progress(total_progress);
    return !is_budget_exhausted_;
  };
  return search_options;
}

VectorX EpsilonConstraintSearch::values_at(const VectorX& x) const {
  VectorX values(figure_count());
  for (int j = 0; j < figure_count(); ++j)
    values[j] = evaluate_figure(problem_, objectives_[static_cast<std::size_t>(j)], x);
  return values;
}

/// With load cases, the full report takes as long as the search itself, so it is postponed until the front is known.
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
  DesignProblem problem = study.problem();
  problem.settled_values = options.settled_values;
  report.outcome = solve_design(problem);
  if (report.outcome.x.size() == 0) return;
  point.all_cases = report.outcome.x;
  report.outcome.x = study.cases().values(0, point.all_cases);
}

void EpsilonConstraintSearch::add_load_cases(ParetoPoint& point) const {
  if (!has_cases() || point.all_cases.size() == 0) return;
  DesignStudyOptions full_options = options_;
  full_options.compare_trajectories = true;
  full_options.on_progress = {};  // an interrupted front is reported, too
  point.report.outcome.x = point.all_cases;
  LoadCaseStudy(point.space, full_options).describe(point.report);
  measure_design(point.space, point.report);
}

DesignReport EpsilonConstraintSearch::failure() const {
  ParetoPoint point = failure_;
  add_load_cases(point);
  return point.report;
}

std::optional<ParetoPoint> EpsilonConstraintSearch::solve(const EpsilonConstraint& constraint) {
  used_time_ = thread_cpu_time() - start_time_;
  is_budget_exhausted_ = is_budget_exhausted_ || (searches_ > 0 && used_time_ >= options_.search.max_time);
  if (is_budget_exhausted_) return std::nullopt;
  ParetoPoint point;
  point.space = make_constrained_space(constraint);
  try {
    search(point, make_search_options());
  } catch (const DeadlineExceeded&) {
    if (!options_.on_progress || options_.on_progress({used_time_, options_.search.max_time})) throw;
    is_budget_exhausted_ = true;
    return std::nullopt;
  }
  ++searches_;
  const DesignOutcome& outcome = point.report.outcome;
  if (is_design(outcome)) point.values = values_at(has_cases() ? point.all_cases : outcome.x);
  if (point.values.size() == 0 || !point.values.allFinite()) {
    failure_ = std::move(point);
    return std::nullopt;
  }
  point.minimized = constraint.minimized;
  point.limits = constraint.limits;
  point.lower_bound = outcome.lower_bound;
  return point;
}

namespace {

/// Relative to the extent of the front: excess over the minimum of a figure allowed at an anchor, and minimum
/// separation of points.
constexpr double anchor_tolerance = 1e-5, min_point_separation = 1e-4;
/// Gap, relative to the extent, below which a point counts as optimal.
constexpr double front_gap_tolerance = 1e-5;
/// Number of searches per requested point, since some find nothing new.
constexpr int max_searches_per_point = 3;
constexpr int max_anchor_rounds = 4;

class ParetoFrontBuilder {
 public:
  ParetoFrontBuilder(const DesignSpace& space, const DesignStudyOptions& options)
      : max_points_(space.start.design.front.max_points),
        figure_count_(static_cast<int>(space.start.design.front.figures.size())),
        search_(space, options, max_points_ + figure_count_ * figure_count_) {}

  ParetoFront run() {
    if (find_anchors()) figure_count_ == 2 ? fill_curve() : fill_grid();
    drop_dominated();
    if (!front_.points.empty()) update_extents();
    for (ParetoPoint& point : front_.points) {
      raise_to_anchor(point);
      point.optimality = assess_point(point);
      search_.add_load_cases(point);
    }
    front_.searches = search_.search_count();
    front_.is_budget_exhausted = search_.is_budget_exhausted();
    return std::move(front_);
  }

 private:
  using Points = std::vector<ParetoPoint>;

  /// Minimises each figure alone, then the others subject to that. @return whether there is a trade-off
  bool find_anchors() {
    for (int i = 0; i < figure_count_; ++i) {
      auto anchor = search_.solve({i, search_.no_limits(), {}});
      if (!anchor && front_.points.empty()) front_.failure = search_.failure();
      if (!anchor) return false;
      const DesignOutcome& outcome = anchor->report.outcome;
      front_.anchors.push_back(
          {anchor->values[i], outcome.lower_bound, outcome.optimality, anchor->report.length_bound});
      front_.points.push_back(std::move(*anchor));
    }
    update_extents();
    for (int i = 0; i < figure_count_; ++i) improve_anchor(front_.points[static_cast<std::size_t>(i)], i);
    update_extents();
    if ((extent_.array() > 0).any()) return true;
    front_.notes.emplace_back("there is no trade-off: one design is the best in all figures");
    front_.points.erase(front_.points.begin() + 1, front_.points.end());
    return false;
  }

  /// Computes minimum and extent of each figure over all points; extents within round-off become zero.
  void update_extents() {
    min_values_ = front_.points.front().values;
    VectorX max_values = min_values_;
    for (const ParetoPoint& point : front_.points) {
      min_values_ = min_values_.cwiseMin(point.values);
      max_values = max_values.cwiseMax(point.values);
    }
    extent_ = max_values - min_values_;
    for (Eigen::Index j = 0; j < extent_.size(); ++j)
      if (!(extent_[j] > 1e-7 * std::abs(max_values[j]))) extent_[j] = 0;
  }

  Optimality assess_point(const ParetoPoint& point) const {
    const bool proved = point.report.outcome.optimality == Optimality::proved_global;
    if (proved || point.gap() <= front_gap_tolerance * extent_[point.minimized]) return Optimality::proved_global;
    return point.report.outcome.optimality == Optimality::budget_exhausted ? Optimality::budget_exhausted
                                                                           : Optimality::local_optimum;
  }

  /// What holds for all designs holds within the limits, unless these need more elements than are enough without them.
  void raise_to_anchor(ParetoPoint& point) const {
    const auto& choices = point.report.cardinality_constraints;
    if (std::any_of(choices.begin(), choices.end(), [](const auto& choice) { return choice.max_count < 0; })) return;
    const auto j = static_cast<std::size_t>(point.minimized);
    if (j < front_.anchors.size() && !(point.lower_bound >= front_.anchors[j].lower_bound))
      point.lower_bound = front_.anchors[j].lower_bound;
  }

  VectorX separation() const { return min_point_separation * extent_; }

  /// Repeats the search from this design and from that of another anchor while this helps and optimality is not proved.
  void improve_anchor(ParetoPoint& anchor, int i) {
    const double max_value = anchor.values[i];
    for (int round = 0; round < max_anchor_rounds; ++round) {
      const VectorX before = anchor.values;
      const ParetoPoint& other = front_.points[static_cast<std::size_t>((i + 1) % figure_count_)];
      refine_anchor(anchor, i, max_value, (round % 2 == 0 ? anchor : other).report.outcome.x);
      const bool better = ((before - anchor.values).array() > separation().array()).any();
      if (anchor.report.outcome.optimality == Optimality::proved_global || search_.is_budget_exhausted()) return;
      if (round > 0 && !better) return;
    }
  }

  /// @param max_value value of figure i
  void refine_anchor(ParetoPoint& anchor, int i, double max_value, const VectorX& start) {
    VectorX limits = search_.no_limits();
    limits[i] = attainable_limit(i, max_value);
    for (int k = 1; k < figure_count_; ++k) {
      const int j = (i + k) % figure_count_;
      if (extent_[i] == 0 && extent_[j] == 0) continue;
      VectorX relaxed_limits = limits;
      relaxed_limits[j] = std::numeric_limits<double>::quiet_NaN();
      auto better = search_.solve({j, relaxed_limits, k == 1 ? start : anchor.report.outcome.x});
      if (!better) return;
      if (better->values[j] <= anchor.values[j]) anchor = std::move(*better);
      limits[j] = attainable_limit(j, anchor.values[j]);
    }
  }

  /// A limit on figure j that a design with this value keeps with some room for a search, unless no design is below.
  double attainable_limit(int j, double value) const {
    if (value <= search_.known_lower_bound(j)) return value;
    return value + std::max(anchor_tolerance * extent_[j], 1e-9 * std::abs(value));
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

  /// Leaves out designs that are dominated to the accuracy of the front. Of designs that do not differ, the first is
  /// kept.
  void drop_dominated() {
    if (front_.points.empty()) return;
    update_extents();
    sort();
    const VectorX slack = front_gap_tolerance * extent_;
    Points all = std::exchange(front_.points, {});
    // one after the other: with a slack, each of three designs may be dominated by another
    for (std::size_t k = 0; k < all.size();) {
      const bool worse = std::any_of(all.begin(), all.end(), [&](const ParetoPoint& other) {
        return dominates(other.values, all[k].values, VectorX::Zero(figure_count_)) ||
               dominates(other.values - slack, all[k].values, 2 * slack);
      });
      if (worse)
        all.erase(all.begin() + static_cast<std::ptrdiff_t>(k));
      else
        ++k;
    }
    for (ParetoPoint& one : all)
      if (is_new(one)) front_.points.push_back(std::move(one));
  }

  /// Bisects the longest open segment between neighbours until there are enough points. Points dominated by a better
  /// design are dropped, and their segments are searched again from the neighbouring designs.
  void fill_curve() {
    const int max_searches = search_.search_count() + max_searches_per_point * max_points_;
    for (drop_dominated();
         static_cast<int>(front_.points.size()) < max_points_ && search_.search_count() < max_searches;) {
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
      if (exhausted_segments_.count(segment(k)) == 0 &&
          (longest < 0 || length(k) > length(static_cast<std::size_t>(longest))))
        longest = static_cast<int>(k);
    return longest;
  }

  void bisect_segment(std::size_t k) {
    const ParetoPoint &a = front_.points[k], &b = front_.points[k + 1];
    const VectorX change = ((b.values - a.values).array() / extent_.array()).abs();
    const int limited = change[1] >= change[0] ? 1 : 0;
    const ParetoPoint& within = limited == 1 ? b : a;
    EpsilonConstraint constraint{1 - limited, search_.no_limits(), within.report.outcome.x};
    constraint.limits[limited] = (a.values[limited] + b.values[limited]) / 2;
    const VectorX within_x = within.report.outcome.x, beyond_x = (limited == 1 ? a : b).report.outcome.x;
    auto new_point = search_.solve(constraint);
    for (const VectorX& start :
         {VectorX((within_x + beyond_x) / 2), beyond_x}) {  // a search may get stuck at its start
      if (new_point && is_new(*new_point)) break;
      constraint.start = start;
      new_point = search_.solve(constraint);
    }
    if (!new_point || !is_new(*new_point)) return void(exhausted_segments_.insert(segment(k)));
    front_.points.push_back(std::move(*new_point));
    drop_dominated();
    update_extents();  // an anchor may have been dominated
  }

  /// Rows of points: limits the second figure at values spread over its extent, and spreads each row over the remaining
  /// extent of the third.
  void fill_grid() {
    const int grid_size = std::max(2, static_cast<int>(std::sqrt(static_cast<double>(max_points_))));
    for (int row = 0; row < grid_size && !search_.is_budget_exhausted(); ++row)
      fill_row(row / (grid_size - 1.0), grid_size);
    drop_dominated();
    while (static_cast<int>(front_.points.size()) < max_points_ && !search_.is_budget_exhausted())
      if (!fill_widest_gap()) return;
  }

  /// Limits the second figure in the middle of its widest gap between points: rows of the grid collapse where the other
  /// two figures do not conflict. @return whether there are new points
  bool fill_widest_gap() {
    std::vector<double> values;
    for (const ParetoPoint& point : front_.points) values.push_back(point.values[1]);
    std::sort(values.begin(), values.end());
    std::size_t widest = 0;
    for (std::size_t k = 0; k + 1 < values.size(); ++k)
      if (values[k + 1] - values[k] > values[widest + 1] - values[widest]) widest = k;
    if (values.size() < 2 || !(values[widest + 1] - values[widest] > separation()[1])) return false;
    VectorX limits = search_.no_limits();
    limits[1] = (values[widest] + values[widest + 1]) / 2;
    const std::size_t count = front_.points.size();
    for (const int i : {0, 2})
      if (static_cast<int>(front_.points.size()) < max_points_) find_point_within(i, limits);
    const bool has_new_points = front_.points.size() > count;
    drop_dominated();
    return has_new_points && front_.points.size() > count;
  }

  void fill_row(double fraction, int grid_size) {
    VectorX limits = search_.no_limits();
    limits[1] = fraction > 0 ? min_values_[1] + std::max(fraction * extent_[1], 1e-9 * std::abs(min_values_[1]))
                             : attainable_limit(1, min_values_[1]);
    const auto first = find_point_within(0, limits), last = find_point_within(2, limits);
    if (!first || !last) return;
    for (int column = 1; column + 1 < grid_size; ++column) {
      limits[2] = last->values[2] + column / (grid_size - 1.0) * (first->values[2] - last->values[2]);
      if (first->values[2] - last->values[2] > separation()[2]) find_point_within(0, limits);
    }
  }

  /// Adds the point if it is new. Figures whose limit is not active, or that have none, may still be reduced at no
  /// cost.
  std::optional<ParetoPoint> find_point_within(int i, const VectorX& limits) {
    auto new_point = search_.solve({i, limits, min_violation_point(limits)});
    if (!new_point || !is_new(*new_point)) {  // a search may get stuck at its start
      auto restarted = search_.solve({i, limits, {}});
      if (restarted && (!new_point || restarted->values[i] < new_point->values[i] || is_new(*restarted)))
        new_point = std::move(restarted);
    }
    if (!new_point) return new_point;
    for (int j = 0; j < figure_count_; ++j)
      if (j != i && !(new_point->values[j] >= limits[j] - separation()[j])) refine(*new_point, j);
    if (is_new(*new_point)) front_.points.push_back(*new_point);
    return new_point;
  }

  void refine(ParetoPoint& point, int j) {
    EpsilonConstraint constraint{j, point.values, point.report.outcome.x};
    for (int i = 0; i < figure_count_; ++i) constraint.limits[i] = attainable_limit(i, point.values[i]);
    constraint.limits[j] = std::numeric_limits<double>::quiet_NaN();
    auto better = search_.solve(constraint);
    if (better && better->values[j] <= point.values[j]) point = std::move(*better);
  }

  /// The known design with the minimum violation of the limits.
  VectorX min_violation_point(const VectorX& limits) const {
    const auto violation = [&](const ParetoPoint& point) {
      double worst = -std::numeric_limits<double>::infinity();
      for (int j = 0; j < figure_count_; ++j)
        if (!std::isnan(limits[j]))
          worst = std::max(worst, (point.values[j] - limits[j]) / std::max(extent_[j], 1e-300));
      return worst;
    };
    const auto best =
        std::min_element(front_.points.begin(), front_.points.end(),
                         [&](const ParetoPoint& a, const ParetoPoint& b) { return violation(a) < violation(b); });
    return best->report.outcome.x;
  }

  int max_points_, figure_count_;
  EpsilonConstraintSearch search_;
  ParetoFront front_;
  VectorX min_values_, extent_;
  std::set<std::pair<double, double>>
      exhausted_segments_;  ///< segments, by values of the first figure, without new points
};

}  // namespace

ParetoFront compute_pareto_front(const DesignSpace& space, const DesignStudyOptions& options) {
  if (!space.start.design.front) throw std::invalid_argument("the spec has no front");
  return ParetoFrontBuilder(space, options).run();
}

}  // namespace balance::design
