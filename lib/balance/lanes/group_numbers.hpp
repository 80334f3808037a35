#pragma once
/// The numbers of a GroupJob as lanes. Private to lanes.

#include "balance/kinematics/drive.hpp"
#include "balance/lanes/kernels.hpp"

#include <vector>

namespace balance {

/// What is prescribed at the moments from `first` on.
template <class L>
void load_prescribed_values(const GroupJob& job, int first, const Drive<Constants<L>>& drive,
                            DriveSampleOf<typename L::Scalar>& sample) {
  using T = typename L::Scalar;
  for (int k = 0; k < drive.value_count(); ++k) {
    const int at = k * group_size + first;
    sample.value[k] = T::load(&job.value[at]);
    sample.rate[k] = T::load(&job.rate[at]);
    sample.acceleration[k] = T::load(&job.acceleration[at]);
  }
  if (drive.rotation.empty()) return;
  for (int k = 0; k < 9; ++k) sample.rotation(k % 3, k / 3) = T::load(&job.rotation[k * group_size + first]);
  for (int k = 0; k < 3; ++k) {
    sample.angular_velocity[k] = T::load(&job.angular_velocity[k * group_size + first]);
    sample.angular_acceleration[k] = T::load(&job.angular_acceleration[k * group_size + first]);
  }
}

/// Where the moments from `first` on should be: as Stepper::predict, from the same places of the groups before.
template <class T>
void predict_group(const GroupJob& job, int first, std::vector<T>& y_next) {
  const double h = job.step * group_size, hh = h * h;
  const auto of = [&](int group, std::vector<double> GroupCoordinates::*numbers, int c) {
    return T::load(&(job.history[group]->*numbers)[c * group_size + first]);
  };
  for (int c = 0; c < static_cast<int>(y_next.size()); ++c) {
    const T y = of(0, &GroupCoordinates::y, c), v = h * of(0, &GroupCoordinates::dy, c),
            a = hh * of(0, &GroupCoordinates::ddy, c);
    if (job.history_count < 2) {
      y_next[c] = y + v + 0.5 * a;
      continue;
    }
    const T y1 = of(1, &GroupCoordinates::y, c), v1 = h * of(1, &GroupCoordinates::dy, c),
            a1 = hh * of(1, &GroupCoordinates::ddy, c);
    if (job.history_count < 3) {
      y_next[c] = 32.0 * y - 31.0 * y1 - 16.0 * v - 14.0 * v1 + 4.0 * a - 2.0 * a1;
      continue;
    }
    const T y2 = of(2, &GroupCoordinates::y, c), v2 = h * of(2, &GroupCoordinates::dy, c),
            a2 = hh * of(2, &GroupCoordinates::ddy, c);
    y_next[c] =
        229.5 * y - 351.0 * y1 + 122.5 * y2 - 94.5 * v - 54.0 * v1 + 43.5 * v2 + 13.5 * a - 54.0 * a1 + 4.5 * a2;
  }
}

}  // namespace balance
