#pragma once
/// Requests and comparisons that the tests of schedules share.

#include "balance/mechanics/trajectory/prescribed_motion.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <stdexcept>
#include <string>

namespace balance {

inline VectorX values(std::initializer_list<double> entries) {
  VectorX vector(static_cast<Eigen::Index>(entries.size()));
  std::copy(entries.begin(), entries.end(), vector.data());
  return vector;
}

inline trajectory::DriveSample sample_at(const trajectory::PrescribedMotion& schedule, double time,
                                         trajectory::Side side = trajectory::Side::after) {
  trajectory::DriveSample sample;
  schedule.at(time, side, sample);
  return sample;
}

/// The vector of a skew matrix, from a matrix that is skew but for truncation.
inline Vector3 unskew(const Matrix3& m) {
  return {(m(2, 1) - m(1, 2)) / 2, (m(0, 2) - m(2, 0)) / 2, (m(1, 0) - m(0, 1)) / 2};
}

/// Every derivative against central differences on 499 times that keep clear of the jumps.
/// @param scale of the third and fourth time derivatives: the truncation is h²/6 times them, with h = 1e-5 of the duration
inline void check_derivatives(const trajectory::PrescribedMotion& schedule, double scale) {
  const double h = 1e-5 * schedule.duration(), tolerance = h * h * scale + 1e-8;
  for (int i = 1; i < 500; ++i) {
    const double time = schedule.duration() * i / 500.3;
    const bool near = std::any_of(schedule.jump_times().begin(), schedule.jump_times().end(),
                                  [&](double jump) { return std::abs(jump - time) < 2 * h; });
    if (near) continue;
    CAPTURE(time);
    const trajectory::DriveSample left = sample_at(schedule, time - h), here = sample_at(schedule, time);
    const trajectory::DriveSample right = sample_at(schedule, time + h);
    CHECK(((right.value - left.value) / (2 * h) - here.rate).norm() < tolerance);
    CHECK(((right.rate - left.rate) / (2 * h) - here.acceleration).norm() < tolerance);
    const Matrix3 spin = (right.rotation - left.rotation) / (2 * h) * here.rotation.transpose();
    CHECK((unskew(spin) - here.angular_velocity).norm() < tolerance);
    CHECK((spin + spin.transpose()).norm() < tolerance);
    CHECK(((right.angular_velocity - left.angular_velocity) / (2 * h) - here.angular_acceleration).norm() < tolerance);
    CHECK((here.rotation.transpose() * here.rotation - Matrix3::Identity()).norm() < 1e-14);  // round-off
  }
}

/// What a refused request says; empty if it is accepted.
inline std::string refusal(const trajectory::PrescribedMotion::Request& request) {
  try {
    const trajectory::PrescribedMotion schedule(request);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

inline bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace balance
