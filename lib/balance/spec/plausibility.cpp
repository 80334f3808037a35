#include "balance/spec/plausibility.hpp"

#include "balance/base/extrema.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace balance::specification {

namespace {

constexpr double max_plausible_size = 60;      // [m]: the largest cranes' booms are longer
constexpr double max_plausible_density = 2e4;  // [kg/m^3]: of gold
constexpr double max_plausible_turns = 2;      // of a joint at the start, which needs no more than one
constexpr double earth_gravity = 9.81;         // [m/s^2]
constexpr double max_plausible_gravity = 5 * earth_gravity;

void check_plausible_size(const Study& study, const Units& units, std::vector<std::string>& warnings) {
  const double size = characteristic_length(study.mechanism), mass = total_mass(study.mechanism);
  if (size > max_plausible_size)
    warnings.push_back(fmt::format("the mechanism's largest dimension is {:.4g} m: are its lengths in {}?", size,
                                   units.length == 1 ? "millimetres, which `units: {length: mm}` would say"
                                                     : "the unit of length that `units` names"));
  // A mechanism fits into a box of four times its largest dimension.
  if (const double edge = 4 * size; mass > max_plausible_density * edge * edge * edge)
    warnings.push_back(
        fmt::format("the mechanism's largest dimension is {:.4g} m, its mass {:.4g} kg: denser than any metal; are the "
                    "units right?",
                    size, mass));
}

/// No body turns with more than all of the mass at four times the mechanism's size.
void check_plausible_inertias(const Study& study, std::vector<std::string>& warnings) {
  const double edge = 4 * characteristic_length(study.mechanism), mass = total_mass(study.mechanism);
  for (const Body& body : study.mechanism.bodies) {
    const double largest = max_abs(body.inertia);
    if (body.mass == 0 || largest <= mass * edge * edge) continue;
    warnings.push_back(
        fmt::format("bodies.{}: an inertia of {:.4g} kg m^2 with a mass of {:.4g} kg is that of a body of more "
                    "than {:.3g} m: are the units right?",
                    body.name, largest, body.mass, edge));
    return;
  }
}

void check_plausible_gravity(const Study& study, const Units& units, std::vector<std::string>& warnings) {
  const double gravity = study.mechanism.gravity.norm(), unit = units.factor(dimension::acceleration);
  if (unit != 1 && std::abs(gravity / unit - earth_gravity) < 0.02)
    warnings.push_back("gravity: 9.81 in the spec's units is not the earth's gravity; in millimetres it would be 9810");
  else if (gravity > max_plausible_gravity)
    warnings.push_back(fmt::format("gravity: {:.4g} m/s^2 is {:.3g} times the earth's; are the units right?", gravity,
                                   gravity / earth_gravity));
}

void check_plausible_angles(const Study& study, const Units& units, std::vector<std::string>& warnings) {
  const double most = max_plausible_turns * 2 * std::numbers::pi;
  const auto judge = [&](const std::string& where, const std::vector<CoordinateValue>& values) {
    for (const CoordinateValue& one : values) {
      const Coordinate& coordinate = study.mechanism.coordinates[one.coordinate];
      if (coordinate.kind != CoordinateKind::angle || std::abs(one.value) <= most) continue;
      warnings.push_back(fmt::format("{}: {} is {:.4g} rad, {:.3g} turns: {}", where, coordinate.name, one.value,
                                     one.value / (2 * std::numbers::pi),
                                     units.angle == 1 ? "is it in degrees, which `units: {angle: deg}` would say?"
                                                      : "is the unit of angles right?"));
      return;
    }
  };
  judge("assembly", study.mechanism.assembly);
  for (const Trajectory& trajectory : study.trajectories) {
    const std::size_t before = warnings.size();
    judge(trajectory.name + ".from", trajectory.from.joints);
    if (warnings.size() > before) return;  // the others mostly start from there, too
  }
}

}  // namespace

std::vector<std::string> list_implausible_numbers(const Study& study, const Units& units) {
  std::vector<std::string> warnings;
  check_plausible_size(study, units, warnings);
  check_plausible_inertias(study, warnings);
  check_plausible_gravity(study, units, warnings);
  check_plausible_angles(study, units, warnings);
  return warnings;
}

}  // namespace balance::specification
