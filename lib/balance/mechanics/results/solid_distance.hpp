#pragma once
/// Distances of solids, line segments and points.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"

namespace balance::results {

/// A convex set of points: a solid, the segment between two points, or a point.
struct ConvexSet {
  const model::Shape* shape = nullptr;                     ///< null: the segment from `begin` to `end`
  bool is_planar = true;                                   ///< a solid in the plane has no extent along z
  Matrix3 rotation = Matrix3::Identity();                  ///< of a solid: from its own axes to the world
  Vector3 centre = Vector3::Zero();                        ///< of a solid: its centre of mass in the world [m]
  Vector3 begin = Vector3::Zero(), end = Vector3::Zero();  ///< [m]

  /// The nearest point of the set. A ring is filled; a sector is too, and of more than half a turn the whole cylinder.
  Vector3 project(const Vector3& point) const;
};

/// Least distance of two sets; 0 if they meet [m]. By alternating projections (Cheney and Goldstein 1959).
double distance_of(const ConvexSet& a, const ConvexSet& b);

}  // namespace balance::results
