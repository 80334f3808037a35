#pragma once
/// The engine over numbers with derivatives: its spaces, and values turned into constants of them.

#include "balance/base/number.hpp"
#include "balance/kinematics/space.hpp"
#include "balance/model/conversion.hpp"
#include "balance/model/drive_sample.hpp"
#include "balance/motion/sample.hpp"
#include "balance/motion/trajectory_conversion.hpp"

namespace balance {

using DualNumber = Dual<dual_width>;

template <class S>
struct DualSpaceOf;
template <>
struct DualSpaceOf<Planar> {
  using Type = PlanarOf<DualNumber>;
};
template <>
struct DualSpaceOf<Spatial> {
  using Type = SpatialOf<DualNumber>;
};
template <class S>
using DualSpace = typename DualSpaceOf<S>::Type;

/// The mechanism with derivatives of zero; set those of the numbers wanted: `m.bodies[1].mass.d[0] = 1`.
inline MechanismOf<DualNumber> to_dual(const Mechanism& mechanism) {
  return convert_mechanism<DualNumber>(mechanism, [](double x) { return DualNumber(x); });
}

inline TrajectoryOf<DualNumber> to_dual(const Trajectory& trajectory) {
  return cast_scalar<DualNumber>(trajectory, [](double x) { return DualNumber(x); });
}

/// How much of a sample.
enum class DerivativeDetail {
  forces,   ///< time, efforts, powers, shaking and ground forces and moments, acceleration of the centre of mass
  figures,  ///< everything else, too, that has figures
  all,
};

/// Derivatives with respect to number k, each where the sample has the value. Counts and what only runs under control know are left
/// alone. Keeps the memory that `out` has.
void write_derivative(const SampleOf<DualNumber>& sample, std::size_t k, DerivativeDetail extent, Sample& out);
Sample derivative_of(const SampleOf<DualNumber>& sample, std::size_t k);

}  // namespace balance
