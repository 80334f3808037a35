#pragma once
/// Conversion of mechanisms to another scalar type.

#include "balance/foundation/base/dual.hpp"
#include "balance/mechanics/model/mechanism.hpp"

namespace balance::model {

template <class To, class From, class Function>
std::optional<To> convert_optional(const std::optional<From>& from, const Function& number) {
  return from ? std::optional<To>(number(*from)) : std::nullopt;
}

template <class To, class From, class Function>
TorqueDistributionOf<To> convert_distribution(const TorqueDistributionOf<From>& from, const Function& number) {
  TorqueDistributionOf<To> to;
  to.method = from.method;
  for (const auto& share : from.shares)
    to.shares.push_back({number(share.weight), convert_optional<To>(share.lower, number),
                         convert_optional<To>(share.upper, number), convert_optional<To>(share.preload, number)});
  return to;
}

template <class To, class From, class Function>
ShapeOf<To> convert_shape(const ShapeOf<From>& from, const Function& number) {
  ShapeOf<To> to{from.kind,
                 number(from.diameter),
                 number(from.inner_diameter),
                 number(from.length),
                 number(from.width),
                 number(from.thickness),
                 number(from.opening),
                 number(from.axis_distance),
                 {}};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) to.rotation(row, column) = number(from.rotation(row, column));
  return to;
}

template <class To, class From, class Function>
FrictionOf<To> convert_friction(const FrictionOf<From>& from, const Function& number) {
  FrictionOf<To> to{from.coordinate, number(from.viscous), number(from.coulomb), {}, {}, {}};
  to.breakaway = convert_optional<To>(from.breakaway, number);
  to.coulomb_backward = convert_optional<To>(from.coulomb_backward, number);
  to.at_rest_backward = convert_optional<To>(from.at_rest_backward, number);
  return to;
}

/// Applies `number` (From → To) to every number of `from` and copies everything else.
template <class To, class From, class Function>
MechanismOf<To> convert_mechanism(const MechanismOf<From>& from, const Function& number) {
  const auto vector = [&](const Vector3Of<From>& v) { return Vector3Of<To>(number(v[0]), number(v[1]), number(v[2])); };
  const auto matrix = [&](const Matrix3Of<From>& m) {
    Matrix3Of<To> out;
    for (int column = 0; column < 3; ++column) out.col(column) = vector(m.col(column));
    return out;
  };
  const auto numbers = [&](const std::vector<From>& list) {
    std::vector<To> out;
    for (const From& x : list) out.push_back(number(x));
    return out;
  };
  const auto vectors = [&](const std::vector<Vector3Of<From>>& list) {
    std::vector<Vector3Of<To>> out;
    for (const auto& v : list) out.push_back(vector(v));
    return out;
  };
  const auto followed = [&](const CoordinateCombinationOf<From>& sum) {
    std::vector<CoordinateTermOf<To>> terms;
    for (const CoordinateTermOf<From>& term : sum.terms) terms.push_back({term.coordinate, number(term.ratio)});
    return CoordinateCombinationOf<To>(std::move(terms));
  };
  MechanismOf<To> to;
  to.name = from.name, to.space = from.space, to.units = from.units, to.gravity = vector(from.gravity);
  for (const auto& body : from.bodies) {
    to.bodies.push_back(
        {body.name, number(body.mass), vector(body.com), matrix(body.inertia), {}, body.inertia_as_given});
    for (const auto& point : body.points) to.bodies.back().points.push_back({point.name, vector(point.position)});
  }
  for (const auto& joint : from.joints)
    to.joints.push_back({joint.name, joint.type, joint.first, joint.second, vector(joint.point_first),
                         vector(joint.point_second), vector(joint.axis), vector(joint.axis2), matrix(joint.rotation),
                         number(joint.radius), joint.slips});
  to.coordinates = from.coordinates;
  for (const auto& coupling : from.couplings)
    to.couplings.push_back(
        {coupling.follower, followed(coupling.leader), number(coupling.ratio), number(coupling.offset)});
  for (const auto& constraint : from.constraints) {
    to.constraints.push_back({constraint.name, {}, constraint.value.template convert<To>(number)});
    for (const auto& term : constraint.terms)
      to.constraints.back().terms.push_back({static_cast<typename GeneralisedSpeedTermOf<To>::Kind>(term.kind),
                                             term.index, number(term.factor), term.body, vector(term.position),
                                             term.pose_factor.template convert<To>(number), term.pose_variables});
  }
  for (const auto& attachment : from.attachments) {
    to.attachments.push_back({attachment.name,
                              attachment.kind,
                              attachment.body,
                              vector(attachment.position),
                              number(attachment.mass),
                              matrix(attachment.inertia),
                              attachment.from,
                              attachment.until,
                              {}});
    if (attachment.shape) to.attachments.back().shape = convert_shape<To>(*attachment.shape, number);
  }
  for (const auto& disc : from.discs)
    to.discs.push_back({disc.name, disc.body, vector(disc.position), vector(disc.axis), followed(disc.follows),
                        number(disc.ratio), number(disc.mass), matrix(disc.inertia)});
  for (const auto& load : from.loads)
    to.loads.push_back({load.name, load.body, vector(load.point), load.frame, numbers(load.arguments),
                        vectors(load.force), vectors(load.moment), load.coordinate, load.is_periodic, load.is_spline});
  for (const auto& spring : from.springs)
    to.springs.push_back({spring.name, spring.first, spring.second, vector(spring.point_first),
                          vector(spring.point_second), number(spring.stiffness), number(spring.free_length),
                          number(spring.preload), spring.coordinate, convert_optional<To>(spring.slack_length, number),
                          convert_optional<To>(spring.shortest_length, number),
                          convert_optional<To>(spring.longest_length, number)});
  for (const auto& element : from.force_elements)
    to.force_elements.push_back({element.name, element.first, element.second, vector(element.point_first),
                                 vector(element.point_second), element.coordinate,
                                 element.table.template convert<To>(number), number(element.damping)});
  for (const auto& friction : from.friction) to.friction.push_back(convert_friction<To>(friction, number));
  to.actuators = from.actuators;
  if (from.torque_distribution) to.torque_distribution = convert_distribution<To>(*from.torque_distribution, number);
  if (from.tool) to.tool = {from.tool->body, from.tool->point, vector(from.tool->position)};
  for (const auto& rough : from.assembly) to.assembly.push_back({rough.coordinate, number(rough.value)});
  return to;
}

/// The mechanism without derivatives.
inline const Mechanism& values_of(const Mechanism& mechanism) { return mechanism; }
template <class T>
Mechanism values_of(const MechanismOf<T>& mechanism) {
  return convert_mechanism<double>(mechanism, [](const T& x) { return value_of(x); });
}

}  // namespace balance::model
