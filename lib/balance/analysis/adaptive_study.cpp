#include "balance/analysis/adaptive_study.hpp"

#include "balance/analysis/case_space.hpp"
#include "balance/analysis/load_case_study.hpp"
#include "balance/base/elementary.hpp"
#include "balance/base/error.hpp"
#include "balance/base/extrema.hpp"
#include "balance/motion/spline.hpp"
#include "balance/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace balance {

namespace {

constexpr int adapted_table_size = 17;
/// What leaves a bound by this part of its interval does so by round-off.
constexpr double adapted_bound_tolerance = 1e-9;

}  // namespace

AdaptiveStudy::AdaptiveStudy(const DesignSpace& space, const DesignStudyOptions& options,
                             const LoadCaseEvaluator& judge, const VectorX& x, const MatrixX& found)
    : space_(space),
      options_(options),
      judge_(judge),
      x_(x),
      found_(found),
      lower_(-row_maxima(-loads().values.transpose())),
      upper_(row_maxima(loads().values.transpose())) {
  find_law();
  x_ = variable_values(VectorX(nominal_load(space)));
}

VectorX AdaptiveStudy::insert_adapted(const VectorX& adapted) const {
  VectorX x = x_;
  x(loads().adapted) = adapted;
  return x;
}

bool AdaptiveStudy::is_within_bounds(const VectorX& adapted) const {
  for (Eigen::Index i = 0; i < adapted.size(); ++i) {
    const int which = loads().adapted[static_cast<std::size_t>(i)];
    const FreeNumber& number = space_.start.free_numbers[static_cast<std::size_t>(which)];
    const double room = adapted_bound_tolerance * (number.upper - number.lower);
    if (adapted[i] < number.lower - room || adapted[i] > number.upper + room) return false;
  }
  return true;
}

/// The loads that vary become numbers of the problem, behind the adapted ones.
void AdaptiveStudy::find_law() {
  const VectorX anchor = found_.colwise().mean();
  DesignSpace law = space_.fix_others(insert_adapted(anchor), loads().adapted);
  law.start.design.minimize.clear();
  std::vector<int> varied;
  for (std::size_t k = 0; k < loads().numbers.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const LoadParameter& number = loads().numbers[k];
    law.inputs[static_cast<std::size_t>(number.input)] = lower_[i];
    if (!(lower_[i] < upper_[i])) continue;
    varied.push_back(static_cast<int>(k));
    law.start.free_numbers.push_back(
        {.key_path = number.path, .lower = lower_[i], .upper = upper_[i], .start = (lower_[i] + upper_[i]) / 2});
    law.free_inputs.push_back(number.input);
  }
  law.start = law.study_at(law.start_values());
  DesignStudyOptions plain = options_;
  plain.minimize.clear();
  const auto goals = plain.goals.empty() ? space_.start.design.goals : plain.goals;
  if (goals.empty()) return;
  law_ = find_adaptive_law(make_design_problem(law, plain), anchor);
  if (!law_) return;
  for (AdaptiveLaw::Term& term : law_->terms) {
    std::vector<int> powers(loads().numbers.size(), 0);
    for (std::size_t k = 0; k < varied.size(); ++k) powers[static_cast<std::size_t>(varied[k])] = term.powers[k];
    term.powers = std::move(powers);
  }
}

VectorX AdaptiveStudy::adapted_values(const VectorX& loads_there, const VectorX& near) const {
  if (law_ && is_within_bounds(law_->evaluate(loads_there))) return law_->evaluate(loads_there);
  const DesignSpace part = at_load(space_, loads_there).fix_others(insert_adapted(near), loads().adapted);
  DesignProblem problem = make_design_problem(part, options_);
  const DesignOutcome outcome = solve_design(problem);
  return outcome.status == DesignStatus::unsolved ? near : outcome.x;
}

VectorX AdaptiveStudy::variable_values(const VectorX& loads_there) const {
  const VectorX width = (upper_ - lower_).cwiseMax(std::numeric_limits<double>::min());
  const Eigen::Index nearest =
      min_index(((loads().values.rowwise() - loads_there.transpose()).array().rowwise() / width.transpose().array())
                    .matrix()
                    .rowwise()
                    .norm());
  const VectorX near = found_.row(nearest);
  if (!law_ && loads().values.row(nearest).transpose() == loads_there) return insert_adapted(near);
  return insert_adapted(adapted_values(loads_there, near));
}

/// One number of the load: evenly over its range; several: the cases.
AdaptedTable AdaptiveStudy::table() const {
  AdaptedTable table;
  const auto add = [&](const VectorX& there, const VectorX& near) {
    table.loads.push_back(there);
    table.values.push_back(adapted_values(there, near));
    table.residuals.push_back(
        judge_.max_residual(at_load(space_, there).study_at(insert_adapted(table.values.back()))));
  };
  if (lower_.size() > 1) {
    for (Eigen::Index k = 0; k < loads().size(); ++k) add(loads().values.row(k), found_.row(k));
    return table;
  }
  VectorX near = found_.row(min_index(loads().values.col(0)));
  std::vector<double> knots;
  for (int k = 0; k < adapted_table_size; ++k) {
    knots.push_back(lower_[0] + (upper_[0] - lower_[0]) * k / (adapted_table_size - 1));
    add(VectorX::Constant(1, knots.back()), near);
    near = table.values.back();
  }
  Samples rows(adapted_table_size, near.size());
  for (int k = 0; k < adapted_table_size; ++k) rows.row(k) = table.values[static_cast<std::size_t>(k)].transpose();
  const CubicSpline spline(knots, rows, SplineEnd::not_a_knot);
  VectorX value = near, first_slope = near, second = near;
  for (int k = 0; k + 1 < adapted_table_size; ++k) {
    const double middle = (knots[static_cast<std::size_t>(k)] + knots[static_cast<std::size_t>(k) + 1]) / 2;
    spline.at(middle, value, first_slope, second);
    const Study there = at_load(space_, VectorX::Constant(1, middle)).study_at(insert_adapted(value));
    table.midpoint_residual = std::max(table.midpoint_residual, judge_.max_residual(there));
  }
  return table;
}

/// Over a grid of the loads, which has the corners in it: exact for laws without powers of one load.
void AdaptiveStudy::find_value_ranges(AdaptiveReport& report) const {
  const auto count = static_cast<Eigen::Index>(loads().adapted.size());
  report.min_values = VectorX::Constant(count, std::numeric_limits<double>::infinity());
  report.max_values = -report.min_values;
  const auto add = [&](const VectorX& a) {
    report.min_values = report.min_values.cwiseMin(a);
    report.max_values = report.max_values.cwiseMax(a);
  };
  if (!law_)
    for (const VectorX& a : report.table.values) add(a);
  constexpr int max_load_grid_points = 20'000;
  const auto n = static_cast<int>(lower_.size());
  const int steps = std::clamp(static_cast<int>(elementary::pow(max_load_grid_points, 1.0 / n)) - 1, 1, 200);
  long points = 1;
  for (int k = 0; k < n; ++k) points *= steps + 1;
  for (long p = 0; law_ && p < points; ++p) {
    VectorX load = lower_;
    long rest = p;
    for (int k = 0; k < n; ++k, rest /= steps + 1)
      load[k] += (upper_[k] - lower_[k]) * static_cast<double>(rest % (steps + 1)) / steps;
    add(law_->evaluate(load));
  }
  report.is_within_bounds = is_within_bounds(report.min_values) && is_within_bounds(report.max_values);
}

/// The load stays the spec's own meanwhile: what it gains is not what moving costs.
std::optional<double> AdaptiveStudy::adjustment_work() const {
  const Study from = space_.study_at(variable_values(lower_)), to = space_.study_at(variable_values(upper_));
  if (from.trajectories.empty()) return std::nullopt;
  const auto masses = [](const Mechanism& mechanism) {
    VectorX all(
        static_cast<Eigen::Index>(mechanism.attachments.size() + mechanism.discs.size() + mechanism.bodies.size()));
    Eigen::Index k = 0;
    for (const auto& one : mechanism.attachments) all[k++] = one.mass;
    for (const auto& one : mechanism.discs) all[k++] = one.mass;
    for (const auto& one : mechanism.bodies) all[k++] = one.mass;
    return all;
  };
  const VectorX before = masses(from.mechanism), after = masses(to.mechanism);
  if ((before - after).norm() > 1e-12 * before.norm()) return std::nullopt;
  double energy[2];
  for (const Study* study : {&from, &to}) {
    Trajectory trajectory = study->trajectories.front();
    trajectory.samples = 2;
    try {
      const RunResult result = simulate(study->mechanism, trajectory);
      if (result.potential_energy.rows() == 0) return std::nullopt;
      energy[study == &to] = result.potential_energy(0, 0);
    } catch (const std::invalid_argument&) {
      return std::nullopt;  // there is no such motion
    }
  }
  return energy[1] - energy[0];
}

AdaptiveReport AdaptiveStudy::report() const {
  AdaptiveReport report;
  report.numbers = loads().adapted;
  report.law = law_;
  if (!law_) report.table = table();
  find_value_ranges(report);
  report.adjustment_work = adjustment_work();
  return report;
}

}  // namespace balance
