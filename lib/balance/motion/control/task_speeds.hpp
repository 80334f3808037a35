#pragma once
/// Quantities that a controller follows instead of the actuated coordinates: sums of joint coordinates, positions of
/// points or the centre of mass along the world's axes and, in the plane, angles of bodies. Their rates are
/// quasi-velocities whose integrals have a meaning, so that errors are differences of positions.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/body_poses.hpp"

#include <vector>

namespace balance::control {

class TaskSpeeds {
 public:
  /// @param mechanism must outlive the object
  /// @throws std::invalid_argument if a speed is not the rate of such a quantity
  TaskSpeeds(const Mechanism& mechanism, std::vector<model::GeneralisedSpeed> speeds);

  Eigen::Index size() const { return static_cast<Eigen::Index>(speeds_.size()); }
  const std::string& name(Eigen::Index i) const { return speeds_[static_cast<std::size_t>(i)].name; }
  bool is_length(Eigen::Index i) const;  ///< otherwise an angle
  /// W: rates for each column of motions of all coordinates.
  MatrixX directions(const VectorX& position, const MatrixX& motions) const;
  /// Bound of the change of each quantity, or of its rate, for changes of all coordinates, or of theirs.
  VectorX bound_changes(const VectorX& changes) const;
  // Of all coordinates of the mechanism.
  VectorX rates(const VectorX& position, const VectorX& velocity) const;
  VectorX accelerations(const VectorX& position, const VectorX& velocity, const VectorX& acceleration) const;
  /// Desired minus actual quantities; differences of bodies' angles are within ±π.
  VectorX errors(const VectorX& desired_position, const VectorX& position) const;

 private:
  /// @param derivative 1: rates, 2: accelerations
  VectorX sum_terms(const std::vector<results::BodyMotion>& motions, const VectorX& coordinate_derivatives,
                    int derivative) const;
  Vector3 point_of(const model::GeneralisedSpeedTerm& term, const std::vector<results::BodyMotion>& motions,
                   int derivative) const;

  const Mechanism* mechanism_;
  std::vector<model::GeneralisedSpeed> speeds_;
};

}  // namespace balance::control
