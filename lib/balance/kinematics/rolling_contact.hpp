#pragma once
/// Where a disc or a sphere touches the plane that it rolls on. Private to kinematics, motion and dynamics.

#include "balance/kinematics/tree.hpp"

#include <cmath>

namespace balance {

/// From the centre of what rolls to where it touches the plane, in space, and how that changes where the angular velocity against the plane
/// is w. World axes; the change is what an observer on the plane sees.
template <class T>
struct ContactVector {
  Vector3Of<T> arm, rate;

  ContactVector(const RollingContact<ModelScalarOf<T>>& contact, const Vector3Of<T>& normal,
                const Vector3Of<T>& spin_axis, const Vector3Of<T>& w) {
    if (!contact.disc) {
      arm = -contact.radius * normal;
      rate.setZero();
      return;
    }
    using std::sqrt;
    const Vector3Of<T> turned = w.cross(spin_axis);
    const T lean = normal.dot(spin_axis);
    const Vector3Of<T> up = normal - lean * spin_axis;  // in the disc, away from where it touches
    const Vector3Of<T> up_rate = -normal.dot(turned) * spin_axis - lean * turned;
    const T size = sqrt(up.squaredNorm());
    arm = -contact.radius / size * up;
    rate = -contact.radius / size * (up_rate - up.dot(up_rate) / (size * size) * up);
  }
};

}  // namespace balance
