// What single points of a front are to each other, and as designs of their own.

#include "balance/analysis/front_study.hpp"
#include "balance/analysis/load_case_study.hpp"
#include "balance/analysis/offered.hpp"
#include "balance/base/elementary.hpp"
#include "balance/conditions/known_terms.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {

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

}  // namespace balance
