#pragma once
/// Which efforts more actuators than degrees of freedom exert. The equations of motion leave the internal efforts open,
/// those in the null space of the map from efforts to generalised forces. In scaled efforts û = unit · u, with the
/// characteristic length as unit of a force and the root of the weight (least norm) or the weight (least peak) as
/// factor, every method is the smallest solution of the equations of motion in a norm, within bounds.
/// Sources: Kock and Schumacher, Proc. IEEE ICRA 2000 (internal torques against backlash); Nokleby et al., Mechanism and
/// Machine Theory 40 (2005) (least peak as a linear program).

#include "balance/foundation/base/dual.hpp"
#include "balance/foundation/numerics/underdetermined_system.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace balance::model {

/// A distribution in scaled efforts.
template <class T>
struct ScaledDistribution {
  numerics::SolutionNorm norm = numerics::SolutionNorm::euclidean;
  bool is_linear = true;
  std::vector<T> unit;                         ///< per actuator: scaled effort per effort
  std::vector<T> factor;                       ///< per actuator: scaled effort per moment
  std::vector<std::optional<T>> lower, upper;  ///< of the scaled efforts
};

/// @pre the mechanism has a torque distribution @param length characteristic length [m]
template <class T>
ScaledDistribution<T> scale_distribution(const MechanismOf<T>& mechanism, double length) {
  using std::sqrt;
  const TorqueDistributionOf<T>& distribution = *mechanism.torque_distribution;
  const bool is_peak = distribution.method == DistributionMethod::min_peak;
  ScaledDistribution<T> scaled;
  scaled.norm = is_peak ? numerics::SolutionNorm::maximum : numerics::SolutionNorm::euclidean;
  scaled.is_linear = distribution.is_linear();
  double max_weight = 0;  // only ratios of weights matter
  for (const EffortShareOf<T>& share : distribution.shares) max_weight = std::max(max_weight, value_of(share.weight));
  for (std::size_t a = 0; a < distribution.shares.size(); ++a) {
    const EffortShareOf<T>& share = distribution.shares[a];
    const bool is_force = mechanism.coordinates[mechanism.actuators[a]].kind == CoordinateKind::length;
    const T weight = share.weight / max_weight;
    scaled.factor.push_back(is_peak ? weight : T(sqrt(weight)));
    scaled.unit.push_back(scaled.factor.back() * (is_force ? length : 1));
    const auto scale_bound = [&](const std::optional<T>& bound) {
      return bound ? std::optional<T>(*bound * scaled.unit.back()) : std::nullopt;
    };
    scaled.lower.push_back(scale_bound(share.lower_bound()));
    scaled.upper.push_back(scale_bound(share.upper_bound()));
  }
  return scaled;
}

/// The scaled efforts û with matrix · û = rhs. @param matrix full row rank
template <class T>
numerics::BoundedSolution distribute_efforts(const ScaledDistribution<T>& distribution, const MatrixX& matrix,
                                             const VectorX& rhs) {
  const Eigen::Index n = matrix.cols();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  numerics::UnderdeterminedSystem system{matrix, rhs, VectorX::Constant(n, -infinity), VectorX::Constant(n, infinity),
                                         VectorX::Ones(n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto a = static_cast<std::size_t>(i);
    if (distribution.lower[a]) system.lower[i] = value_of(*distribution.lower[a]);
    if (distribution.upper[a]) system.upper[i] = value_of(*distribution.upper[a]);
    system.excess_scale[i] = value_of(distribution.factor[a]);
  }
  return numerics::solve_bounded(system, distribution.norm);
}

/// The efforts u with matrix · u = rhs. @param matrix full row rank
inline VectorX solve_distribution(const ScaledDistribution<double>& distribution, const MatrixX& matrix,
                                  const VectorX& rhs) {
  const Eigen::Map<const VectorX> unit(distribution.unit.data(), matrix.cols());
  const MatrixX scaled = matrix * unit.cwiseInverse().asDiagonal();
  return distribute_efforts(distribution, scaled, rhs).x.cwiseQuotient(unit);
}

}  // namespace balance::model
