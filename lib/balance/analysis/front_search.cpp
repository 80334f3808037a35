#include "balance/analysis/front_search.hpp"

#include "balance/analysis/case_objective.hpp"
#include "balance/analysis/objective.hpp"
#include "balance/analysis/offered.hpp"
#include "balance/base/computing_time.hpp"
#include "balance/design/least_violation.hpp"
#include "balance/result/tracks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {

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
  ParetoPoint told = failure_;
  add_load_cases(told);
  return told.report;
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

}  // namespace balance
