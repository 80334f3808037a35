#pragma once
/// Which points describe which body. Revolute and fixed joints share a point between their bodies (P3 section 2); a body that has
/// too few of them, or only such as lie close together, gets auxiliary ones. Private to natural and formulas.

#include "balance/model/mechanism.hpp"
#include "balance/natural/form.hpp"

#include <string>
#include <vector>

namespace balance::natural {

/// A basic point as one body sees it.
struct BodyPoint {
  int point = 0;
  Complex position;  ///< in the body's axes
};

struct BodyPoints {
  /// The first two are the base: their difference is the body's direction. Empty for the ground.
  std::vector<BodyPoint> points;
  /// The first three are a triangle that is good enough to carry the mass; the third is tied by distances, all others linearly.
  bool has_mass_triangle = false;
};

struct BasicPoints {
  double length = 1;               ///< unit of all places [m]
  int moving = 0;                  ///< points 0 … moving − 1; behind them those of the ground
  std::vector<std::string> names;  ///< per point: "crank1.B", a joint's point of the first body that has it
  std::vector<Complex> fixed;      ///< places of the ground's points, in order
  std::vector<BodyPoints> bodies;
  int count() const { return static_cast<int>(names.size()); }
};

BasicPoints choose_basic_points(const Mechanism& mechanism);

/// A vector of the model in the plane, in units of length.
inline Complex to_complex(const Vector3& v, double length) { return Complex(v.x(), v.y()) / length; }

}  // namespace balance::natural
