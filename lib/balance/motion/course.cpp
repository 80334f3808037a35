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

constexpr int order = 4;              ///< of a cubic spline: its terms, and how often its ends count as knots
constexpr double same_place = 1e-12;  ///< parameters nearer than this to a jump are the jump
constexpr std::size_t functions = 3;  ///< value, first and second derivative

/// Ends fourfold, inner knots evenly spaced, the middle one twice if the second derivative may jump there.
std::vector<double> knots_of(std::size_t coefficients, bool jump) {
  const std::size_t inner = jump ? coefficients - 1 : coefficients;
  std::vector<double> knots(order, 0.0);
  for (std::size_t k = 1; k <= inner; ++k) {
    knots.push_back(static_cast<double>(k) / static_cast<double>(inner + 1));
    if (jump && 2 * k == inner + 1) knots.push_back(knots.back());
  }
  knots.insert(knots.end(), order, 1.0);
  return knots;
}

/// De Boor's algorithm on the stretch between knots j and j + 1.
double spline_value(const std::vector<double>& knots, const std::vector<double>& controls, std::size_t j, double x) {
  std::array<double, order> d;
  for (std::size_t i = 0; i < order; ++i) d[i] = controls[j - (order - 1) + i];
  for (std::size_t r = 1; r < order; ++r)
    for (std::size_t i = order - 1; i >= r; --i) {
      const double left = knots[j - (order - 1) + i], right = knots[j + 1 + i - r];
      const double part = (x - left) / (right - left);
      d[i] = (1 - part) * d[i - 1] + part * d[i];
    }
  return d[order - 1];
}

/// A cubic's Chebyshev terms from its values at Chebyshev's points.
Panel cubic_panel(const std::vector<double>& knots, const std::vector<double>& controls, std::size_t j) {
  Panel panel{knots[j], knots[j + 1], Samples::Zero(PiecewiseSeries::terms, 1)};
  const double middle = (panel.begin + panel.end) / 2, half = (panel.end - panel.begin) / 2;
  for (int k = 0; k < order; ++k) {
    const double angle = std::numbers::pi * (2 * k + 1) / (2 * order);
    const double value = spline_value(knots, controls, j, middle + half * elementary::cos(angle));
    for (int i = 0; i < order; ++i)
      panel.terms(i, 0) += (i == 0 ? 1.0 : 2.0) / order * value * elementary::cos(i * angle);
  }
  return panel;
}

PiecewiseSeries spline_on(const std::vector<double>& knots, const std::vector<double>& controls) {
  std::vector<Panel> panels;
  for (std::size_t j = order - 1; j + order < knots.size(); ++j)
    if (knots[j] < knots[j + 1]) panels.push_back(cubic_panel(knots, controls, j));
  return PiecewiseSeries(std::move(panels));
}

/// Where the drive's values hold a coordinate (−1: the tool's angle).
std::size_t component_of(const DriveQuantities& quantities, CoordinateId coordinate) {
  const std::size_t first = quantities.point.size() + quantities.com.size();
  if (coordinate < 0 && quantities.tool_angle) return first;
  const auto& all = quantities.coordinates;
  const auto found = std::find(all.begin(), all.end(), coordinate);
  if (found == all.end()) throw std::invalid_argument("the drive does not prescribe what has a course of its own");
  return first + (quantities.tool_angle ? 1 : 0) + static_cast<std::size_t>(found - all.begin());
}

/// A quantity whose end follows from its course goes nowhere by itself.
void stay(Schedule::Request& request, Eigen::Index component) {
  const double start = request.from.value[component];
  if (request.to.value.size() > 0) request.to.value[component] = start;
  for (DriveValue& point : request.via) point.value[component] = start;
}

}  // namespace

CourseValue evaluate(const PiecewiseSeries& course, double parameter, Side side) {
  const double beside = parameter + (side == Side::after ? same_place : -same_place);
  std::array<double, functions> out{};
  course.at(course.panel_at(beside, 0, course.panels().size()), parameter, out.data());
  return {out[0], out[1], out[2]};
}

PiecewiseSeries with_derivatives(const PiecewiseSeries& function) {
  const PiecewiseSeries first = function.derivative(), second = first.derivative();
  std::vector<Panel> panels = function.panels();
  for (std::size_t p = 0; p < panels.size(); ++p) {
    panels[p].terms.resize(PiecewiseSeries::terms, functions);
    panels[p].terms << function.panels()[p].terms, first.panels()[p].terms, second.panels()[p].terms;
  }
  return PiecewiseSeries(std::move(panels));
}

PiecewiseSeries cubic_spline(const std::vector<double>& controls) {
  if (controls.size() < order) throw std::invalid_argument("a cubic spline needs four controls");
  return spline_on(knots_of(controls.size() - order, false), controls);
}

PiecewiseSeries clamped_spline(const std::vector<double>& coefficients, bool jump) {
  if (coefficients.empty()) throw std::invalid_argument("a spline needs a coefficient");
  if (jump && coefficients.size() % 2 != 0)
    throw std::invalid_argument("a spline with a jump in its middle has an even number of coefficients");
  const std::vector<double> knots = knots_of(coefficients.size(), jump);
  std::vector<double> controls(2, 0.0);  // the two at each end are the value and the rate there
  controls.insert(controls.end(), coefficients.begin(), coefficients.end());
  controls.insert(controls.end(), 2, 0.0);
  return with_derivatives(spline_on(knots, controls));
}

void add_courses(const Trajectory& trajectory, const DriveQuantities& quantities, Schedule::Request& request) {
  if (!trajectory.courses.empty() && std::holds_alternative<TablePath>(trajectory.path))
    throw std::invalid_argument("a table says how every quantity goes; none has a course of its own beside it");
  for (const Course& course : trajectory.courses) {
    const auto component = static_cast<Eigen::Index>(component_of(quantities, course.coordinate));
    if (const auto* spline = std::get_if<AddedSpline>(&course.kind)) {
      request.courses.push_back({component, clamped_spline(spline->coefficients, spline->jump), spline->over_time});
      continue;
    }
    const auto& kept = std::get<KeptMomentum>(course.kind);
    if (kept.course.panels().empty())
      throw std::invalid_argument("the course that keeps the angular momentum has not been found yet");
    stay(request, component);
    request.courses.push_back({component, kept.course, kept.over_time});
  }
  add_corridor(trajectory.corridor, quantities, request);
}

}  // namespace balance
