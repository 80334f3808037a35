#pragma once
/// The numbers that place a mechanism's joints, discs and springs. Coefficients of conditions are functions of them.

#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance::conditions {

/// Location of one such number in a Mechanism.
struct GeometricParameterLocation {
  enum class Kind {
    joint_first,
    joint_second,
    joint_radius,
    constraint_factor,
    constraint_point,
    body_point,
    tool,
    disc,
    disc_ratio,
    disc_term_ratio,
    coupling_ratio,
    coupling_term_ratio,
    spring_first,
    spring_second,
    load,
    free_length,
    gravity,
  };
  Kind kind = Kind::joint_first;
  int index = 0;  ///< of the joint, constraint, disc, coupling, spring or load; body_point: of the body
  int item = 0;   ///< body_point: which point; …_term_ratio: which followed coordinate; of a constraint: which term
  int axis = 0;
};

/// A number with all its locations, which hold the same value (gravity: the components of one vector).
struct GeometricParameter {
  std::string label;  ///< "link1.B.x", "d5.ratio", "g"
  std::string unit;   ///< "m", "m/s^2", "1"
  double value = 0;   ///< SI; may be zero
  std::vector<GeometricParameterLocation> locations;
};

/// Lists the coordinates of points of joints, springs, loads and the tool, positions and ratios of discs, ratios of
/// couplings, free lengths, radii of rolling bodies, factors of constraints and the magnitude of gravity. A named point
/// is listed once, however many elements use it.
std::vector<GeometricParameter> list_geometric_parameters(const Mechanism& mechanism);

/// Points in polar coordinates, if neither Cartesian coordinate is zero ("link1.B.r", "link1.B.angle" [rad]). The
/// locations of both numbers are, for each use, the first and then the second coordinate.
struct PolarPoint {
  GeometricParameter distance, angle;
  std::string first, second;  ///< labels of the two coordinates
};
/// For planar mechanisms, and for spatial ones in which everything moves in parallel planes normal to the same axis of
/// all bodies. The angle counts from the next of the axes x, y, z (after z comes x) to the one after it.
std::vector<PolarPoint> list_polar_points(const Mechanism& mechanism);

/// Rotates the direction of a point by an angle [rad], at all its locations.
Mechanism rotate_point_direction(const Mechanism& mechanism, const GeometricParameter& angle, double rotation);

/// The value of a number in another mechanism of the same structure.
double geometric_value(const Mechanism& mechanism, const GeometricParameter& number);

/// Multiplies one number by a factor, at all its locations.
Mechanism scale_geometric_parameter(const Mechanism& mechanism, const GeometricParameter& number, double factor);

// Access to geometric numbers of a mechanism over any scalar.

/// The number itself, mutable if the mechanism is.
template <class AMechanism>
auto& geometric_value_at(AMechanism& m, const GeometricParameterLocation& p) {
  using Kind = GeometricParameterLocation::Kind;
  const auto at = [](int index) { return static_cast<std::size_t>(index); };
  switch (p.kind) {
    case Kind::joint_first: return m.joints[at(p.index)].point_first[p.axis];
    case Kind::joint_second: return m.joints[at(p.index)].point_second[p.axis];
    case Kind::joint_radius: return m.joints[at(p.index)].radius;
    case Kind::constraint_factor: return m.constraints[at(p.index)].terms[at(p.item)].factor;
    case Kind::constraint_point: return m.constraints[at(p.index)].terms[at(p.item)].position[p.axis];
    case Kind::body_point: return m.bodies[at(p.index)].points[at(p.item)].position[p.axis];
    case Kind::tool: return m.tool.value().position[p.axis];
    case Kind::disc: return m.discs[at(p.index)].position[p.axis];
    case Kind::disc_ratio: return m.discs[at(p.index)].ratio;
    case Kind::disc_term_ratio: return m.discs[at(p.index)].follows.terms[at(p.item)].ratio;
    case Kind::coupling_term_ratio: return m.couplings[at(p.index)].leader.terms[at(p.item)].ratio;
    case Kind::coupling_ratio: return m.couplings[at(p.index)].ratio;
    case Kind::spring_first: return m.springs[at(p.index)].point_first[p.axis];
    case Kind::spring_second: return m.springs[at(p.index)].point_second[p.axis];
    case Kind::load: return m.loads[at(p.index)].point[p.axis];
    case Kind::free_length: return m.springs[at(p.index)].free_length;
    case Kind::gravity: break;
  }
  return m.gravity[p.axis];
}

}  // namespace balance::conditions
