#pragma once
/// The offsets that stay within a corridor of width 1, as a set of controls. Private to timing.

#include "balance/base/piecewise_series.hpp"

#include <vector>

namespace balance {

/// Controls of a corridor's splines, `knots + 2` for each direction. The set is convex; it is known by the half-spaces that hold it.
class CorridorSet {
 public:
  CorridorSet(int knots, Eigen::Index directions);

  Eigen::Index size() const { return each_ * directions_; }
  /// How much the splines bend, and a little of how large they are: ∫ (o''² + o²) ds = xᵀ M x.
  MatrixX metric() const;
  /// The largest distance from the path anywhere.
  double gauge(const VectorX& controls) const;
  /// Normals n of half-spaces n·x ≤ 1 that touch the set where the distance is largest and above 1.
  std::vector<VectorX> cutting_planes(const VectorX& controls) const;

 private:
  struct OffsetMaximum {
    double place = 0, distance = 0;
    VectorX offset;
  };

  VectorX basis_values(std::size_t panel, double place) const;
  OffsetMaximum offset_at(const VectorX& controls, std::size_t panel, double place) const;
  /// Every local maximum of the distance.
  std::vector<OffsetMaximum> offset_maxima(const VectorX& controls) const;
  std::size_t panel_at(double place) const { return bases_.find_panel(place, 0, bases_.panels().size()); }

  Eigen::Index each_, directions_;
  PiecewiseChebyshevSeries bases_;  ///< B-splines
};

}  // namespace balance
