#pragma once
/// Units of the numbers in a spec. Internally all numbers are SI.

#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <optional>
#include <string>

namespace balance::specification {

/// Exponents of a quantity's dimension. Force is independent, because a spec may name its unit.
struct Dimension {
  int length = 0;
  int mass = 0;
  int time = 0;
  int angle = 0;
  int force = 0;

  friend constexpr Dimension operator*(Dimension a, Dimension b) {
    return {a.length + b.length, a.mass + b.mass, a.time + b.time, a.angle + b.angle, a.force + b.force};
  }
  friend constexpr Dimension operator/(Dimension a, Dimension b) {
    return {a.length - b.length, a.mass - b.mass, a.time - b.time, a.angle - b.angle, a.force - b.force};
  }
};

namespace dimension {
inline constexpr Dimension dimensionless{};
inline constexpr Dimension length{.length = 1};
inline constexpr Dimension mass{.mass = 1};
inline constexpr Dimension time{.time = 1};
inline constexpr Dimension angle{.angle = 1};
inline constexpr Dimension force{.force = 1};
inline constexpr Dimension moment = force * length;
inline constexpr Dimension inertia = mass * length * length;
inline constexpr Dimension acceleration = length / (time * time);
inline constexpr Dimension stiffness = force / length;
}  // namespace dimension

/// Dimension of a joint coordinate.
constexpr Dimension dimension_of(CoordinateKind kind) {
  return kind == CoordinateKind::angle ? dimension::angle : dimension::length;
}

/// Dimension of a quantity by its SI unit: "N m/s", "rad/s^2"; dimensionless if the unit is unknown.
Dimension dimension_of_unit(const std::string& unit);

/// SI values of the spec's units: those that the mechanism keeps, and the others.
struct Units : DisplayUnits {
  double mass = 1;
  double time = 1;
  std::optional<double> force;  ///< if not given: mass · length / time²

  /// SI value of the number one in this dimension.
  double factor(Dimension dimension) const;
};

/// Reads `units: {length: mm, mass: g, angle: deg, time: s, force: N}`.
Units read_units(const SpecCursor& section);

/// SI value of a product of units: "m/s", "N mm", "deg/s^2", "kg m^2", "%". What follows a slash divides, up to the next
/// slash. Fails with the nearest name of a unit.
double read_unit_product(const SpecCursor& unit);

}  // namespace balance::specification
