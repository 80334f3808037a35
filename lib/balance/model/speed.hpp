#pragma once
/// Speeds that need not be rates of coordinates: sums of rates of joint coordinates and of components of bodies' motion.

#include "balance/base/types.hpp"
#include "balance/model/ids.hpp"

#include <string>
#include <vector>

namespace balance {

/// factor · (what it is of). Own: in the axes of the body, which move.
template <class T>
struct GeneralisedSpeedTermOf {
  enum class Kind { coordinate, velocity, velocity_body, angular_velocity, angular_velocity_body };
  Kind kind = Kind::coordinate;
  int index = 0;    ///< coordinate of the mechanism, or component 0 to 2; what turns in the plane has component 2
  T factor = 1;     ///< SI
  BodyId body = 0;  ///< of a component
  Vector3Of<T> position = Vector3Of<T>::Zero();  ///< of the point whose velocity is meant, in the body's axes [m]
};

/// φ or ψ of P0 eq. 1 with constant factors.
template <class T>
struct GeneralisedSpeedOf {
  std::string name;
  std::vector<GeneralisedSpeedTermOf<T>> terms;
};

using GeneralisedSpeedTerm = GeneralisedSpeedTermOf<double>;
using GeneralisedSpeed = GeneralisedSpeedOf<double>;

}  // namespace balance
