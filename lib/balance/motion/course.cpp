#include "balance/motion/course.hpp"

#include "balance/base/elementary.hpp"
#include "balance/motion/offset.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance {
namespace {

constexpr int bspline_order = 4;  ///< of a cubic spline: its terms, and how often its ends count as knots
constexpr double jump_parameter_tolerance = 1e-12;  ///< parameters nearer than this to a jump are the jump
constexpr std::size_t derivative_columns = 3;       ///< value, first and second derivative

/// Ends fourfold, inner knots evenly spaced, the middle one twice if the second derivative may jump there.
std::vector<double> make_knot_vector(std::size_t coefficients, bool jump) {
  const std::size_t inner = jump ? coefficients - 1 : coefficients;
  std::vector<double> knots(bspline_order, 0.0);
  for (std::size_t k = 1; k <= inner; ++k) {
    knots.push_back(static_cast<double>(k) / static_cast<double>(inner + 1));
    if (jump && 2 * k == inner + 1) knots.push_back(knots.back());
  }
  knots.insert(knots.end(), bspline_order, 1.0);
  return knots;
}

/// De Boor's algorithm on the stretch between knots j and j + 1.
double evaluate_de_boor(const std::vector<double>& knots, const std::vector<double>& controls, std::size_t j,
                        double x) {
  std::array<double, bspline_order> d;
  for (std::size_t i = 0; i < bspline_order; ++i) d[i] = controls[j - (bspline_order - 1) + i];
  for (std::size_t r = 1; r < bspline_order; ++r)
    for (std::size_t i = bspline_order - 1; i >= r; --i) {
      const double left = knots[j - (bspline_order - 1) + i], right = knots[j + 1 + i - r];
      const double part = (x - left) / (right - left);
      d[i] = (1 - part) * d[i - 1] + part * d[i];
    }
  return d[bspline_order - 1];
}

/// A cubic's Chebyshev terms from its values at Chebyshev's points.
Panel fit_cubic_panel(const std::vector<double>& knots, const std::vector<double>& controls, std::size_t j) {
  Panel panel{knots[j], knots[j + 1], Samples::Zero(PiecewiseChebyshevSeries::coefficient_count, 1)};
  const double middle = (panel.begin + panel.end) / 2, half = (panel.end - panel.begin) / 2;
  for (int k = 0; k < bspline_order; ++k) {
    const double angle = std::numbers::pi * (2 * k + 1) / (2 * bspline_order);
    const double value = evaluate_de_boor(knots, controls, j, middle + half * elementary::cos(angle));
    for (int i = 0; i < bspline_order; ++i)
      panel.coefficients(i, 0) += (i == 0 ? 1.0 : 2.0) / bspline_order * value * elementary::cos(i * angle);
  }
  return panel;
}

PiecewiseChebyshevSeries make_spline_series(const std::vector<double>& knots, const std::vector<double>& controls) {
  std::vector<Panel> panels;
  for (std::size_t j = bspline_order - 1; j + bspline_order < knots.size(); ++j)
    if (knots[j] < knots[j + 1]) panels.push_back(fit_cubic_panel(knots, controls, j));
  return PiecewiseChebyshevSeries(std::move(panels));
}

/// Where the drive's values hold a coordinate (−1: the tool's angle).
std::size_t find_component(const DriveQuantities& quantities, CoordinateId coordinate) {
  const std::size_t first = quantities.point.size() + quantities.com.size();
  if (coordinate < 0 && quantities.tool_angle) return first;
  const auto& all = quantities.coordinates;
  const auto found = std::find(all.begin(), all.end(), coordinate);
  if (found == all.end()) throw std::invalid_argument("the drive does not prescribe what has a course of its own");
  return first + (quantities.tool_angle ? 1 : 0) + static_cast<std::size_t>(found - all.begin());
}

/// A quantity whose end follows from its course goes nowhere by itself.
void hold_component(PrescribedMotion::Request& request, Eigen::Index component) {
  const double start = request.from.value[component];
  if (request.to.value.size() > 0) request.to.value[component] = start;
  for (DriveValue& point : request.via) point.value[component] = start;
}

}  // namespace

ValueWithDerivatives evaluate_with_derivatives(const PiecewiseChebyshevSeries& course, double parameter, Side side) {
  const double beside = parameter + (side == Side::after ? jump_parameter_tolerance : -jump_parameter_tolerance);
  std::array<double, derivative_columns> out{};
  course.evaluate(course.find_panel(beside, 0, course.panels().size()), parameter, out.data());
  return {out[0], out[1], out[2]};
}

PiecewiseChebyshevSeries append_derivatives(const PiecewiseChebyshevSeries& function) {
  const PiecewiseChebyshevSeries first = function.derivative(), second = first.derivative();
  std::vector<Panel> panels = function.panels();
  for (std::size_t p = 0; p < panels.size(); ++p) {
    panels[p].coefficients.resize(PiecewiseChebyshevSeries::coefficient_count, derivative_columns);
    panels[p].coefficients << function.panels()[p].coefficients, first.panels()[p].coefficients,
        second.panels()[p].coefficients;
  }
  return PiecewiseChebyshevSeries(std::move(panels));
}

PiecewiseChebyshevSeries make_bspline(const std::vector<double>& controls) {
  if (controls.size() < bspline_order) throw std::invalid_argument("a cubic spline needs four controls");
  return make_spline_series(make_knot_vector(controls.size() - bspline_order, false), controls);
}

PiecewiseChebyshevSeries make_clamped_bspline(const std::vector<double>& coefficients, bool jump) {
  if (coefficients.empty()) throw std::invalid_argument("a spline needs a coefficient");
  if (jump && coefficients.size() % 2 != 0)
    throw std::invalid_argument("a spline with a jump in its middle has an even number of coefficients");
  const std::vector<double> knots = make_knot_vector(coefficients.size(), jump);
  std::vector<double> controls(2, 0.0);  // the two at each end are the value and the rate there
  controls.insert(controls.end(), coefficients.begin(), coefficients.end());
  controls.insert(controls.end(), 2, 0.0);
  return append_derivatives(make_spline_series(knots, controls));
}

void add_secondary_tasks(const Trajectory& trajectory, const DriveQuantities& quantities,
                         PrescribedMotion::Request& request) {
  if (!trajectory.secondary_tasks.empty() && std::holds_alternative<TablePath>(trajectory.path))
    throw std::invalid_argument("a table says how every quantity goes; none has a course of its own beside it");
  for (const SecondaryTask& course : trajectory.secondary_tasks) {
    const auto component = static_cast<Eigen::Index>(find_component(quantities, course.coordinate));
    if (const auto* spline = std::get_if<SplineTask>(&course.kind)) {
      request.component_offsets.push_back(
          {component, make_clamped_bspline(spline->coefficients, spline->has_middle_jump), spline->over_time});
      continue;
    }
    const auto& kept = std::get<MomentumTask>(course.kind);
    if (kept.solution.panels().empty())
      throw std::invalid_argument("the course that keeps the angular momentum has not been found yet");
    hold_component(request, component);
    request.component_offsets.push_back({component, kept.solution, kept.over_time});
  }
  add_corridor_offset(trajectory.corridor, quantities, request);
}

}  // namespace balance
