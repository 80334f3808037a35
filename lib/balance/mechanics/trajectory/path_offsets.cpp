#include "balance/mechanics/trajectory/path_offsets.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

namespace balance::trajectory {

using numerics::Panel;
using numerics::PiecewiseChebyshevSeries;

namespace {

constexpr int bspline_order = 4;  ///< of a cubic spline: number of terms, and multiplicity of the end knots
constexpr double jump_parameter_tolerance = 1e-12;  ///< parameters closer than this to a jump count as the jump
constexpr std::size_t derivative_columns = 3;       ///< value, first and second derivative

/// Fourfold end knots and evenly spaced inner knots, the middle one double if the second derivative may jump there.
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

/// De Boor's algorithm between knots j and j + 1.
double evaluate_de_boor(const std::vector<double>& knots, const std::vector<double>& controls, std::size_t j,
                        double x) {
  std::array<double, bspline_order> d;
  for (std::size_t i = 0; i < bspline_order; ++i) d[i] = controls[j - (bspline_order - 1) + i];
  for (std::size_t r = 1; r < bspline_order; ++r)
    for (std::size_t i = bspline_order - 1; i >= r; --i) {
      const double left = knots[j - (bspline_order - 1) + i], right = knots[j + 1 + i - r];
      const double fraction = (x - left) / (right - left);
      d[i] = (1 - fraction) * d[i - 1] + fraction * d[i];
    }
  return d[bspline_order - 1];
}

/// Chebyshev coefficients of a cubic from its values at the Chebyshev points.
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

/// Index of a coordinate in the drive's values (−1: the tool's angle).
std::size_t find_component(const DriveQuantities& quantities, CoordinateId coordinate) {
  const std::size_t first = quantities.point.size() + quantities.com.size();
  if (coordinate < 0 && quantities.tool_angle) return first;
  const auto& coordinates = quantities.coordinates;
  const auto entry = std::find(coordinates.begin(), coordinates.end(), coordinate);
  if (entry == coordinates.end())
    throw std::invalid_argument("the drive does not prescribe the coordinate that has a course of its own");
  return first + (quantities.tool_angle ? 1 : 0) + static_cast<std::size_t>(entry - coordinates.begin());
}

/// Removes the straight motion of a quantity whose end value follows from its task.
void hold_component(PrescribedMotion::Request& request, Eigen::Index component) {
  const double start = request.from.value[component];
  if (request.to.value.size() > 0) request.to.value[component] = start;
  for (DriveValue& point : request.via) point.value[component] = start;
}

}  // namespace

ValueWithDerivatives evaluate_with_derivatives(const PiecewiseChebyshevSeries& series, double parameter, Side side) {
  const double one_sided = parameter + (side == Side::after ? jump_parameter_tolerance : -jump_parameter_tolerance);
  std::array<double, derivative_columns> out{};
  series.evaluate(series.find_panel(one_sided, 0, series.panels().size()), parameter, out.data());
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
  std::vector<double> controls(2, 0.0);  // two controls at each end determine value and rate there
  controls.insert(controls.end(), coefficients.begin(), coefficients.end());
  controls.insert(controls.end(), 2, 0.0);
  return append_derivatives(make_spline_series(knots, controls));
}

void add_secondary_tasks(const Trajectory& trajectory, const DriveQuantities& quantities,
                         PrescribedMotion::Request& request) {
  if (!trajectory.secondary_tasks.empty() && std::holds_alternative<TablePath>(trajectory.path))
    throw std::invalid_argument("a table prescribes every quantity; none can have a course of its own");
  for (const SecondaryTask& task : trajectory.secondary_tasks) {
    const auto component = static_cast<Eigen::Index>(find_component(quantities, task.coordinate));
    if (const auto* spline = std::get_if<SplineTask>(&task.kind)) {
      request.component_offsets.push_back(
          {component, make_clamped_bspline(spline->coefficients, spline->has_middle_jump), spline->over_time});
      continue;
    }
    const auto& momentum_task = std::get<MomentumTask>(task.kind);
    if (momentum_task.solution.panels().empty())
      throw std::invalid_argument("the course that keeps the angular momentum has not been found yet");
    hold_component(request, component);
    request.component_offsets.push_back({component, momentum_task.solution, momentum_task.over_time});
  }
  add_corridor_offset(trajectory.corridor, quantities, request);
}

namespace {

constexpr double course_time_tolerance = 1e-9;  ///< of the duration: moves may be outside by this much
constexpr int panels_per_course_piece = 4;      ///< between jumps of a law: 16 terms are then exact

std::string format_time(double time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g s", time);
  return text;
}

/// A function of the fraction of the duration that stays what it is.
void add_rest(double begin, double end, double value, std::vector<Panel>& panels) {
  if (!(end > begin)) return;
  Panel panel{begin, end, Samples::Zero(PiecewiseChebyshevSeries::coefficient_count, derivative_columns)};
  panel.coefficients(0, 0) = value;
  panels.push_back(std::move(panel));
}

/// Interpolates a vector function on a panel from its values at the Chebyshev points.
template <class Function>
Panel interpolate_panel(double begin, double end, Eigen::Index components, const Function& function) {
  Samples values(PiecewiseChebyshevSeries::coefficient_count, components);
  for (int k = 0; k < PiecewiseChebyshevSeries::coefficient_count; ++k)
    values.row(k) =
        function((begin + end) / 2 + (end - begin) / 2 * PiecewiseChebyshevSeries::chebyshev_point(k)).transpose();
  return {begin, end, PiecewiseChebyshevSeries::values_to_coefficients() * values};
}

/// One move, from `value` on, with its derivatives with respect to the fraction of the duration.
void add_move(const CoordinateMove& move, double begin, double end, double value, std::vector<Panel>& panels) {
  const double length = end - begin;
  const auto course = [&](double time) {  // inside of a panel, away from jumps
    const MotionLawValue law = evaluate(move.law, (time - begin) / length);
    return Vector3(value + move.distance * law.s, move.distance * law.ds / length,
                   move.distance * law.dds / (length * length));
  };
  std::vector<double> piece_ends = find_acceleration_jumps(move.law);
  piece_ends.push_back(1);
  double piece_begin = 0;
  for (const double piece_end : piece_ends) {
    for (int k = 0; k < panels_per_course_piece; ++k) {
      const double step = (piece_end - piece_begin) / panels_per_course_piece;
      const bool is_last = k + 1 == panels_per_course_piece;
      panels.push_back(interpolate_panel(begin + length * (piece_begin + k * step),
                                         is_last ? (piece_end == 1 ? end : begin + length * piece_end)
                                                 : begin + length * (piece_begin + (k + 1) * step),
                                         derivative_columns, course));
    }
    piece_begin = piece_end;
  }
}

/// The course relative to its start, over the fraction of the duration.
PiecewiseChebyshevSeries make_course_series(const CoordinateCourse& course, double duration) {
  std::vector<Panel> panels;
  double time = 0, value = 0;
  for (const CoordinateMove& move : course.moves) {
    const double begin = std::clamp(move.start / duration, time, 1.0),
                 end = std::min((move.start + move.duration) / duration, 1.0);
    add_rest(time, begin, value, panels);
    add_move(move, begin, end, value, panels);
    time = end, value += move.distance;
  }
  add_rest(time, 1, value, panels);
  return PiecewiseChebyshevSeries(std::move(panels));
}

void check_course(const CoordinateCourse& course, double duration) {
  for (const CoordinateMove& move : course.moves) {
    validate(move.law);
    if (move.law.kind == MotionLawKind::uniform || is_mechanism_dependent(move.law.kind))
      throw std::invalid_argument(
          "a coordinate moves from rest to rest, by a law that does not depend on the mechanism");
  }
  if (const std::string issue = find_course_issue(course, duration); !issue.empty())
    throw std::invalid_argument("a coordinate cannot move: " + issue);
}

}  // namespace

std::string find_course_issue(const CoordinateCourse& course, double duration) {
  double time = 0;
  for (const CoordinateMove& move : course.moves) {
    const double end = move.start + move.duration;
    if (!(move.duration > 0)) return "one of its moves takes no time";
    if (end > (1 + course_time_tolerance) * duration)
      return "it would arrive at " + format_time(end) + ", but the motion ends at " + format_time(duration);
    if (move.start < time - course_time_tolerance * duration)
      return "one of its moves starts at " + format_time(move.start) + ", before " + format_time(time) +
             (time > 0 ? ", when the one before it ends" : "");
    time = end;
  }
  return "";
}

void add_courses(const Trajectory& trajectory, const DriveQuantities& quantities, PrescribedMotion::Request& request) {
  for (const CoordinateCourse& course : trajectory.courses) {
    const auto component = static_cast<Eigen::Index>(find_component(quantities, course.coordinate));
    check_course(course, request.duration);
    if (auto* table = std::get_if<TablePath>(&request.path))
      for (std::vector<double>& row : table->values)
        row.insert(row.begin() + static_cast<std::ptrdiff_t>(component), request.from.value[component]);
    hold_component(request, component);
    request.component_offsets.push_back(
        {component, course.is_free() ? course.solution : make_course_series(course, request.duration), true});
  }
  request.switch_times = list_move_times(trajectory.courses);
}

namespace {

constexpr double max_panel_rotation = 0.5;     // rotation of the directions per panel [rad]: 16 terms are then exact
constexpr double coefficient_epsilon = 4e-16;  // of a panel's largest coefficient: smaller ones are round-off
constexpr double path_length_epsilon = 1e-9;   // of the magnitude of the coordinates

StraightCurve extract_straight_part(const PrescribedMotion::Request& request) {
  const bool keeps_start = request.to.value.size() == 0;
  return {request.from.value, keeps_start ? VectorX(VectorX::Zero(request.from.value.size()))
                                          : VectorX(request.to.value - request.from.value)};
}

/// Columns that complete a unit vector to an orthonormal basis.
MatrixX complete_orthonormal_basis(const VectorX& direction) {
  if (direction.size() == 2) return VectorX(Vector2(-direction[1], direction[0]));
  const MatrixX column = direction;
  const MatrixX basis = Eigen::HouseholderQR<MatrixX>(column).householderQ();
  return basis.rightCols(direction.size() - 1);
}

/// As interpolate_panel(), without terms that are round-off.
template <class Function>
Panel fit_panel(double begin, double end, Eigen::Index components, const Function& function) {
  Panel panel = interpolate_panel(begin, end, components, function);
  const double threshold = coefficient_epsilon * numerics::max_abs(panel.coefficients);
  panel.coefficients = (panel.coefficients.cwiseAbs().array() > threshold).select(panel.coefficients, 0.0);
  return panel;
}

/// Components of the offset.
PiecewiseChebyshevSeries make_offset_series(const PiecewiseChebyshevSeries& splines, const PathNormals& normals) {
  std::vector<Panel> panels;
  for (std::size_t p = 0; p < splines.panels().size(); ++p) {
    const Panel& spline_panel = splines.panels()[p];
    if (normals.sweep() == 0) {
      panels.push_back({spline_panel.begin, spline_panel.end, spline_panel.coefficients * normals.at(0).transpose()});
      continue;
    }
    const double length = spline_panel.end - spline_panel.begin;
    const int subpanel_count =
        std::max(1, static_cast<int>(std::ceil(std::abs(normals.sweep()) * length / max_panel_rotation)));
    VectorX values(splines.function_count());
    for (int k = 0; k < subpanel_count; ++k)
      panels.push_back(
          fit_panel(spline_panel.begin + length * k / subpanel_count,
                    k + 1 == subpanel_count ? spline_panel.end : spline_panel.begin + length * (k + 1) / subpanel_count,
                    normals.count() + 1, [&](double s) {
                      splines.evaluate(p, s, values.data());
                      return VectorX(normals.at(s) * values);
                    }));
  }
  return PiecewiseChebyshevSeries(std::move(panels));
}

}  // namespace

int count_corridor_components(const DriveQuantities& quantities) {
  const std::size_t point = quantities.point.size() + quantities.com.size();
  const bool joints = point == 0 && !quantities.tool_angle && quantities.rotation.empty();
  const std::size_t components = joints ? quantities.coordinates.size() : point;
  if (components < 2)
    throw std::invalid_argument("a corridor needs a drive of at least two coordinates of a point, or of two joints");
  return static_cast<int>(components);
}

PathNormals::PathNormals(const PrescribedMotion::Request& request, int components, double width)
    : components_(components) {
  const StraightCurve straight = extract_straight_part(request);
  if (const auto* path = std::get_if<CirclePath>(&request.path))
    circle_ = make_circle(straight, components, *path);
  else if (const auto* arc_path = std::get_if<ArcPath>(&request.path))
    circle_ = make_circular_arc(straight, components, *arc_path);
  else if (!std::holds_alternative<LinePath>(request.path))
    throw std::invalid_argument("a corridor goes along a line, a circle or an arc: other paths have corners or bends");
  if (circle_) {
    if (!(width < circle_->u.norm()))
      throw std::invalid_argument(
          "the corridor is as wide as the radius of its path, or wider: its inner side would fold");
    return;
  }
  const VectorX displacement = straight.delta.head(components);
  if (!(displacement.norm() > path_length_epsilon * straight.start.head(components).norm()))
    throw std::invalid_argument("the path of a corridor has no length: no direction is across it");
  straight_ = complete_orthonormal_basis(displacement.normalized());
}

MatrixX PathNormals::at(double s) const {
  if (!circle_) return straight_;
  const double angle = circle_->sweep * s;
  const Vector3 outward =
      elementary::cos(angle) * circle_->u.normalized() + elementary::sin(angle) * circle_->v.normalized();
  MatrixX columns(components_, components_ - 1);
  columns.col(0) = outward.head(components_);
  if (components_ == 3) columns.col(1) = circle_->u.cross(circle_->v).normalized();
  return columns;
}

PiecewiseChebyshevSeries make_corridor_splines(const std::vector<double>& controls, int knots) {
  const auto controls_per_spline = static_cast<std::size_t>(knots) + 2;
  if (knots < 1 || controls.empty() || controls.size() % controls_per_spline != 0)
    throw std::invalid_argument("the splines of a corridor must have two more controls than knots");
  std::vector<Panel> panels;
  for (std::size_t first = 0; first < controls.size(); first += controls_per_spline) {
    std::vector<double> padded_controls(1, 0.0);
    padded_controls.insert(padded_controls.end(), controls.begin() + static_cast<std::ptrdiff_t>(first),
                           controls.begin() + static_cast<std::ptrdiff_t>(first + controls_per_spline));
    padded_controls.push_back(0);
    const PiecewiseChebyshevSeries spline = make_bspline(padded_controls);
    if (panels.empty())
      for (const Panel& panel : spline.panels())
        panels.push_back({panel.begin, panel.end,
                          Samples::Zero(PiecewiseChebyshevSeries::coefficient_count,
                                        static_cast<Eigen::Index>(controls.size() / controls_per_spline))});
    for (std::size_t p = 0; p < panels.size(); ++p)
      panels[p].coefficients.col(static_cast<Eigen::Index>(first / controls_per_spline)) =
          spline.panels()[p].coefficients;
  }
  return PiecewiseChebyshevSeries(std::move(panels));
}

void add_corridor_offset(const std::optional<Corridor>& corridor, const DriveQuantities& quantities,
                         PrescribedMotion::Request& request) {
  if (!corridor) return;
  if (corridor->control_points.empty())
    throw std::invalid_argument("the path within the corridor has not been found yet");
  const PathNormals normals(request, count_corridor_components(quantities), corridor->width);
  const PiecewiseChebyshevSeries splines = make_corridor_splines(corridor->control_points, corridor->inner_knots);
  if (splines.function_count() != normals.count())
    throw std::invalid_argument("the path within the corridor was found for another drive");
  const PiecewiseChebyshevSeries offset_series = make_offset_series(splines, normals);
  for (Eigen::Index i = 0; i <= normals.count(); ++i) {
    std::vector<Panel> component_panels = offset_series.panels();
    for (Panel& panel : component_panels) panel.coefficients = Samples(panel.coefficients.col(i));
    request.component_offsets.push_back(
        {i, append_derivatives(PiecewiseChebyshevSeries(std::move(component_panels))), false});
  }
}

}  // namespace balance::trajectory
