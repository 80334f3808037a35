#pragma once
/// Units of the numbers in a spec. Internally all numbers are SI.

#include "balance/interface/specification/display_units.hpp"
#include "balance/interface/specification/spec_cursor.hpp"

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
  friend constexpr bool operator==(Dimension a, Dimension b) = default;
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

/// SI unit of a dimension: "N m", "kg m^2", "N s/m"; "1" without one. dimension_of_unit() reads back those of results.
std::string unit_of_dimension(Dimension dimension);

/// SI values of the spec's units. A force that is displayed may have another unit than one that is read.
struct Units : SpecUnits {
  std::optional<double> stated_force;  ///< unit of forces in the spec; if not given: mass · length / time²

  /// SI value of the number one in this dimension.
  double factor(Dimension dimension) const;
};

/// Reads `units: {length: mm, mass: g, angle: deg, time: s, force: N}`.
Units read_units(const SpecCursor& section);

/// A product of units.
struct UnitProduct {
  double value = 1;     ///< [SI]
  Dimension dimension;  ///< without force, which is mass · length / time²
};

/// Reads "m/s", "N mm", "deg/s^2", "kg m^2", "%". What follows a slash divides, up to the next slash. Fails with the
/// nearest name of a unit.
UnitProduct read_unit_product(const SpecCursor& unit);

/// The product of units in a text, such as a figure's SI unit; nothing if it is not one.
std::optional<UnitProduct> parse_unit_product(const std::string& text);

}  // namespace balance::specification
