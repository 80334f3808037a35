#pragma once
/// Peak, mean and range of a quantity over the samples, as functions of few coordinates. Private to cost.

#include "balance/cost/trajectory_cost.hpp"

#include <vector>

namespace balance {

class SampledFigures {
 public:
  /// @param components of the quantity: 1 for scalars, whose range is that of the signed value
  SampledFigures(Eigen::Index places, Eigen::Index components, Eigen::Index coordinates);

  /// @param matrix components × coordinates: the quantity at this place per unit of each
  /// @param weight share of the time average
  void set_sample(Eigen::Index place, const MatrixX& matrix, double weight);

  /// @param z coordinates
  /// @param gradient with respect to z, if not null; where the figure has a corner, that of one side
  double peak(const VectorX& z, VectorX* gradient) const;
  double mean(const VectorX& z, VectorX* gradient) const;
  double range(const VectorX& z, VectorX* gradient) const;

 private:
  MatrixX values(const VectorX& z) const;
  void add_gradient(Eigen::Index place, const MatrixX& values, double factor, VectorX& gradient) const;

  Eigen::Index places_, components_;
  MatrixX matrices_;  ///< component by component, the places one after another
  VectorX weights_;
};

}  // namespace balance
