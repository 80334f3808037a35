#pragma once
/// Heights of counterweights and inertias with moments, as Bernstein coefficients: at one place, and at the highest.

#include "balance/synthesis/certificate/bernstein_form.hpp"
#include "balance/synthesis/certificate/virtual_linkage.hpp"

#include <array>
#include <vector>

namespace balance::certificate {

/// Bernstein coefficients of columns multiplied by 1 and by 2t − 1 of each affine length: all with the same degrees.
struct ExpandedColumns {
  BernsteinCoefficients plain;   ///< all columns, elevated
  std::vector<MatrixX> centred;  ///< per affine length: all columns times 2t − 1
};
ExpandedColumns expand(const BernsteinCoefficients& coefficients, const std::vector<int>& affine);

struct HighestPlaces {
  VectorX heights;              ///< per Bernstein coefficient
  std::vector<Vector3> places;  ///< where they are
};

/// Heights of a counterweight or an inertia at all places of its box and in all ratios.
struct PlacedRows {
  ExpandedColumns columns;  ///< scale, then the unknowns of each function
  Eigen::Index unknowns = 0;
  Vector3 lower = Vector3::Zero(), upper = Vector3::Zero();  ///< x, y, ratio; zero where not free
  std::array<int, 3> numbers{-1, -1, -1};
  bool has_square = false;

  std::vector<Vector3> list_corners() const;
  /// The rows at one place, as those of a corner.
  ExpandedColumns at(const Vector3& place) const;
  /// Per unknown: bound on absolute terms of the heights at all places.
  VectorX magnitudes() const;
  /// Coefficients × functions of the place, divided by the scale.
  /// @param w parts × unknowns
  MatrixX evaluate(const MatrixX& w) const;
  /// Where multipliers make the heights largest. A coordinate's part is at most quadratic, so that its largest value is
  /// at an end or at its vertex.
  /// @param w parts × unknowns
  HighestPlaces find_highest(const MatrixX& w) const;

 private:
  static constexpr auto place_functions = static_cast<Eigen::Index>(PlacedHeight::count);
  using FunctionValues = Eigen::Matrix<double, place_functions, 1>;

  static FunctionValues functions(const Vector3& place) {
    return {1, place[0], place[1], place.head<2>().squaredNorm(), place[2]};
  }
  VectorX magnitudes(const FunctionValues& values) const;
};

}  // namespace balance::certificate
