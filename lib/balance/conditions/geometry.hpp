#pragma once
/// The numbers that place a mechanism's joints, discs and springs: what the coefficients of its conditions are made of.

#include "balance/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance {

/// Where one such number stands in a Mechanism.
struct GeometricPlace {
  enum class Kind {
    joint_first,
    joint_second,
    body_point,
    tool,
    disc,
    disc_ratio,
    coupling_ratio,
    spring_first,
    spring_second,
    free_length,
    gravity,
  };
  Kind kind = Kind::joint_first;
  int index = 0;  ///< of the joint, disc, coupling or spring; body_point: of the body
  int item = 0;   ///< body_point: which point
  int axis = 0;
};

/// A number with all its places, which hold the same value (gravity: the components of one vector).
struct GeometricNumber {
  std::string label;  ///< "link1.B.x", "d5.ratio", "g"
  std::string unit;   ///< "m", "m/s^2", "1"
  double value = 0;   ///< SI; zero is listed too
  std::vector<GeometricPlace> places;
};

/// Coordinates of points at which joints, springs and the tool are, places and ratios of discs, ratios of couplings, free
/// lengths and the size of gravity. Points that have a name stand once, however many use them.
std::vector<GeometricNumber> list_geometry(const Mechanism& mechanism);

/// The value that a number has in another mechanism of the same structure.
double value_in(const Mechanism& mechanism, const GeometricNumber& number);

/// The mechanism with one number multiplied by a factor, at all its places.
Mechanism scaled(const Mechanism& mechanism, const GeometricNumber& number, double factor);

}  // namespace balance
