#include "balance/motion/offset.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/motion/course.hpp"

#include <cmath>
#include <stdexcept>

namespace balance {
namespace {

constexpr double max_panel_rotation = 0.5;     // of the directions on one panel [rad]: 16 terms are then exact
constexpr double coefficient_epsilon = 4e-16;  // of a panel's largest: smaller ones are round-off
constexpr double path_length_epsilon = 1e-9;   // of the coordinates' size

StraightCurve extract_straight_part(const PrescribedMotion::Request& request) {
  const bool stays = request.to.value.size() == 0;
  return {request.from.value,
          stays ? VectorX(VectorX::Zero(request.from.value.size())) : VectorX(request.to.value - request.from.value)};
}

/// Columns that complete a unit vector to an orthonormal basis.
MatrixX complete_orthonormal_basis(const VectorX& along) {
  if (along.size() == 2) return VectorX(Vector2(-along[1], along[0]));
  const MatrixX one = along;
  const MatrixX basis = Eigen::HouseholderQR<MatrixX>(one).householderQ();
  return basis.rightCols(along.size() - 1);
}

/// A vector function on a panel from its values at Chebyshev's points.
template <class Function>
Panel fit_panel(double begin, double end, Eigen::Index components, const Function& function) {
  Samples values(PiecewiseChebyshevSeries::coefficient_count, components);
  for (int k = 0; k < PiecewiseChebyshevSeries::coefficient_count; ++k)
    values.row(k) =
        function((begin + end) / 2 + (end - begin) / 2 * PiecewiseChebyshevSeries::chebyshev_point(k)).transpose();
  Panel panel{begin, end, PiecewiseChebyshevSeries::values_to_coefficients() * values};
  const double least = coefficient_epsilon * max_abs(panel.coefficients);
  panel.coefficients = (panel.coefficients.cwiseAbs().array() > least).select(panel.coefficients, 0.0);
  return panel;
}

/// The offset's components.
PiecewiseChebyshevSeries make_offset_series(const PiecewiseChebyshevSeries& splines, const PathNormals& normals) {
  std::vector<Panel> panels;
  for (std::size_t p = 0; p < splines.panels().size(); ++p) {
    const Panel& whole = splines.panels()[p];
    if (normals.sweep() == 0) {
      panels.push_back({whole.begin, whole.end, whole.coefficients * normals.at(0).transpose()});
      continue;
    }
    const double length = whole.end - whole.begin;
    const int parts = std::max(1, static_cast<int>(std::ceil(std::abs(normals.sweep()) * length / max_panel_rotation)));
    VectorX values(splines.function_count());
    for (int k = 0; k < parts; ++k)
      panels.push_back(fit_panel(whole.begin + length * k / parts,
                                 k + 1 == parts ? whole.end : whole.begin + length * (k + 1) / parts,
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
  const StraightCurve rest = extract_straight_part(request);
  if (const auto* path = std::get_if<CirclePath>(&request.path))
    circle_ = make_circle(rest, components, *path);
  else if (const auto* through = std::get_if<ArcPath>(&request.path))
    circle_ = make_circular_arc(rest, components, *through);
  else if (!std::holds_alternative<LinePath>(request.path))
    throw std::invalid_argument("a corridor goes along a line, a circle or an arc: other paths have corners or bends");
  if (circle_) {
    if (!(width < circle_->u.norm()))
      throw std::invalid_argument(
          "the corridor is as wide as the radius of its path, or wider: its inner side would fold");
    return;
  }
  const VectorX way = rest.delta.head(components);
  if (!(way.norm() > path_length_epsilon * rest.start.head(components).norm()))
    throw std::invalid_argument("the path of a corridor goes nowhere: it has no direction to leave it by");
  straight_ = complete_orthonormal_basis(way.normalized());
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
  const auto each = static_cast<std::size_t>(knots) + 2;
  if (knots < 1 || controls.empty() || controls.size() % each != 0)
    throw std::invalid_argument("the splines of a corridor have two controls more than knots");
  std::vector<Panel> panels;
  for (std::size_t first = 0; first < controls.size(); first += each) {
    std::vector<double> whole(1, 0.0);
    whole.insert(whole.end(), controls.begin() + static_cast<std::ptrdiff_t>(first),
                 controls.begin() + static_cast<std::ptrdiff_t>(first + each));
    whole.push_back(0);
    const PiecewiseChebyshevSeries one = make_bspline(whole);
    if (panels.empty())
      for (const Panel& panel : one.panels())
        panels.push_back({panel.begin, panel.end,
                          Samples::Zero(PiecewiseChebyshevSeries::coefficient_count,
                                        static_cast<Eigen::Index>(controls.size() / each))});
    for (std::size_t p = 0; p < panels.size(); ++p)
      panels[p].coefficients.col(static_cast<Eigen::Index>(first / each)) = one.panels()[p].coefficients;
  }
  return PiecewiseChebyshevSeries(std::move(panels));
}

void add_corridor_offset(const std::optional<Corridor>& corridor, const DriveQuantities& quantities,
                         PrescribedMotion::Request& request) {
  if (!corridor) return;
  if (corridor->control_points.empty())
    throw std::invalid_argument("the way within the corridor has not been found yet");
  const PathNormals normals(request, count_corridor_components(quantities), corridor->width);
  const PiecewiseChebyshevSeries splines = make_corridor_splines(corridor->control_points, corridor->inner_knots);
  if (splines.function_count() != normals.count())
    throw std::invalid_argument("the way within the corridor was found for another drive");
  const PiecewiseChebyshevSeries all = make_offset_series(splines, normals);
  for (Eigen::Index i = 0; i <= normals.count(); ++i) {
    std::vector<Panel> own = all.panels();
    for (Panel& panel : own) panel.coefficients = Samples(panel.coefficients.col(i));
    request.component_offsets.push_back({i, append_derivatives(PiecewiseChebyshevSeries(std::move(own))), false});
  }
}

}  // namespace balance
