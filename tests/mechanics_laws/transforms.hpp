#pragma once
/// A mechanism with its trajectory put elsewhere, or made larger, heavier, slower.

#include "balance/foundation/expression/expression.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

namespace laws {

template <class T>
struct ExperimentOf {
  balance::MechanismOf<T> mechanism;
  balance::TrajectoryOf<T> trajectory;
};
using Experiment = ExperimentOf<double>;

/// The ground with everything on it, gravity, loads and targets displaced by x ↦ R x + d.
/// @param R planar mechanisms: about z
Experiment displaced(const Experiment& from, const balance::Matrix3& R, const balance::Vector3& d);
/// False where the displaced experiment cannot be stated: a drive on single directions, a spherical joint on the ground (its angles are about the
/// ground's axes).
bool can_be_displaced(const Experiment& from);

struct Units {
  double length = 1, mass = 1, time = 1;
  double force() const { return mass * length / (time * time); }
  double moment() const { return force() * length; }
};

/// The same experiment with every length, mass and duration multiplied.
Experiment scaled(const Experiment& from, const Units& by);
ExperimentOf<balance::Expression> scaled(const ExperimentOf<balance::Expression>& from, const Units& by);

}  // namespace laws
