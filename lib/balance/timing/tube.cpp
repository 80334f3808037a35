#include "balance/timing/tube.hpp"

#include "balance/motion/offset.hpp"

#include <cmath>

namespace balance {
namespace {

constexpr int intervals_per_panel = 24;  // between them a cubic's distance has at most one maximum
constexpr int max_ternary_steps = 40;
constexpr double gauge_tolerance = 1e-9;  // of the width

PiecewiseChebyshevSeries make_basis_series(int knots) {
  const auto each = static_cast<std::size_t>(knots) + 2;
  std::vector<double> controls(each * each, 0.0);
  for (std::size_t k = 0; k < each; ++k) controls[k * each + k] = 1;
  return make_corridor_splines(controls, knots);
}

}  // namespace

CorridorSet::CorridorSet(int knots, Eigen::Index directions)
    : each_(knots + 2), directions_(directions), bases_(make_basis_series(knots)) {}

VectorX CorridorSet::basis_values(std::size_t panel, double place) const {
  VectorX values(each_);
  bases_.evaluate(panel, place, values.data());
  return values;
}

MatrixX CorridorSet::metric() const {
  const PiecewiseChebyshevSeries bends = bases_.derivative().derivative();
  MatrixX one = MatrixX::Zero(each_, each_);
  VectorX bend(each_);
  for (std::size_t p = 0; p < bases_.panels().size(); ++p)
    for (const double place :
         {0.2113248654051871, 0.7886751345948129}) {  // Gauss's, exact for the product of two lines
      const Panel& panel = bases_.panels()[p];
      const double s = panel.begin + (panel.end - panel.begin) * place;
      bends.evaluate(p, s, bend.data());
      const VectorX value = basis_values(p, s);
      one += (panel.end - panel.begin) / 2 * (bend * bend.transpose() + value * value.transpose());
    }
  MatrixX whole = MatrixX::Zero(size(), size());
  for (Eigen::Index m = 0; m < directions_; ++m) whole.block(m * each_, m * each_, each_, each_) = one;
  return whole;
}

CorridorSet::OffsetMaximum CorridorSet::offset_at(const VectorX& controls, std::size_t panel, double place) const {
  const VectorX here = basis_values(panel, place);
  VectorX offset(directions_);
  for (Eigen::Index m = 0; m < directions_; ++m) offset[m] = here.dot(controls.segment(m * each_, each_));
  return {place, offset.norm(), offset};
}

std::vector<CorridorSet::OffsetMaximum> CorridorSet::offset_maxima(const VectorX& controls) const {
  std::vector<OffsetMaximum> found;
  for (std::size_t p = 0; p < bases_.panels().size(); ++p) {
    const double begin = bases_.panels()[p].begin, part = (bases_.panels()[p].end - begin) / intervals_per_panel;
    for (int k = 0; k < intervals_per_panel; ++k) {
      // The distance rises into the part and falls out of it: its maximum is inside.
      double low = begin + k * part, high = low + part;
      const double step = 1e-4 * part;
      const auto rises = [&](double place) {
        return offset_at(controls, p, place + step).distance > offset_at(controls, p, place).distance;
      };
      if (!rises(low) || rises(high - step)) continue;
      for (int halving = 0; halving < max_ternary_steps; ++halving) {
        const double left = low + (high - low) / 3, right = high - (high - low) / 3;
        const bool up = offset_at(controls, p, left).distance < offset_at(controls, p, right).distance;
        (up ? low : high) = up ? left : right;
      }
      found.push_back(offset_at(controls, p, (low + high) / 2));
    }
    found.push_back(offset_at(controls, p, begin));
  }
  return found;
}

double CorridorSet::gauge(const VectorX& controls) const {
  double most = 0;
  for (const OffsetMaximum& summit : offset_maxima(controls)) most = std::max(most, summit.distance);
  return most;
}

std::vector<VectorX> CorridorSet::cutting_planes(const VectorX& controls) const {
  std::vector<VectorX> normals;
  for (const OffsetMaximum& summit : offset_maxima(controls)) {
    if (!(summit.distance > 1 + gauge_tolerance)) continue;
    const VectorX here = basis_values(panel_at(summit.place), summit.place);
    VectorX normal(size());
    for (Eigen::Index m = 0; m < directions_; ++m)
      normal.segment(m * each_, each_) = summit.offset[m] / summit.distance * here;
    normals.push_back(normal);
  }
  return normals;
}

}  // namespace balance
