#include "balance/report/page_mechanism.hpp"

#include "balance/model/joint_names.hpp"

#include <array>

namespace balance {

template <class Kind>
void to_json(Json& json, const TypedIndex<Kind>& id) {
  json = static_cast<int>(id);
}

namespace {

Json place(const Vector3& p) { return vector_json(p, 3); }

Json inertia_json(const Matrix3& inertia, SpaceKind space) {
  if (space == SpaceKind::planar) return std::array{inertia(2, 2)};
  const double xy = inertia(0, 1), xz = inertia(0, 2), yz = inertia(1, 2);
  if (xy == 0 && xz == 0 && yz == 0) return std::array{inertia(0, 0), inertia(1, 1), inertia(2, 2)};
  return std::array{inertia(0, 0), inertia(1, 1), inertia(2, 2), xy, xz, yz};
}

Json bodies_json(const Mechanism& mechanism) {
  Json list = Json::array();
  for (const Body& body : mechanism.bodies) {
    Json points = Json::array();
    for (const NamedPoint& point : body.points)
      points.push_back({{"name", point.name}, {"position", place(point.position)}});
    list.push_back({{"name", body.name},
                    {"mass", body.mass},
                    {"com", place(body.com)},
                    {"inertia", inertia_json(body.inertia, mechanism.space)},
                    {"points", std::move(points)}});
  }
  return list;
}

Json joints_json(const Mechanism& mechanism) {
  Json list = Json::array();
  for (const Joint& joint : mechanism.joints) {
    list.push_back({{"name", joint.name},
                    {"type", name_of(joint.type)},
                    {"first", joint.first},
                    {"second", joint.second},
                    {"point_first", place(joint.point_first)},
                    {"point_second", place(joint.point_second)},
                    {"axis", place(joint.axis)}});
    if (!is_rolling(joint.type)) continue;
    list.back()["radius"] = joint.radius;
    if (joint.type == JointType::rolling_disc)  // its own axis, on the disc
      list.back()["spin"] = place(joint.rotation.transpose() * joint.axis.cross(joint.axis2));
  }
  return list;
}

Json attachments_json(const Mechanism& mechanism) {
  Json list = Json::array();
  for (const Attachment& a : mechanism.attachments)
    list.push_back({{"name", a.name},
                    {"kind", a.kind == AttachmentKind::counterweight ? "counterweight" : "payload"},
                    {"body", a.body},
                    {"position", place(a.position)},
                    {"mass", a.mass}});
  return list;
}

Json followed_json(const CoordinateCombination& followed) {
  Json list = Json::array();
  for (const CoordinateTerm& term : followed.terms)
    list.push_back({{"coordinate", term.coordinate}, {"ratio", term.ratio}});
  return list;
}

Json discs_json(const Mechanism& mechanism) {
  Json list = Json::array();
  for (const Disc& disc : mechanism.discs)
    list.push_back({{"name", disc.name},
                    {"body", disc.body},
                    {"position", place(disc.position)},
                    {"axis", place(disc.axis)},
                    {"follows", followed_json(disc.follows)},
                    {"ratio", disc.ratio},
                    {"mass", disc.mass},
                    {"axial", disc.axis.dot(disc.inertia * disc.axis)}});
  return list;
}

Json springs_json(const Mechanism& mechanism) {
  Json list = Json::array();
  for (const Spring& spring : mechanism.springs)
    list.push_back({{"name", spring.name},
                    {"first", spring.first},
                    {"second", spring.second},
                    {"point_first", place(spring.point_first)},
                    {"point_second", place(spring.point_second)},
                    {"stiffness", spring.stiffness},
                    {"free_length", spring.free_length},
                    {"preload", spring.preload},
                    {"coordinate", spring.coordinate}});
  return list;
}

Json coordinates_json(const Mechanism& mechanism) {
  Json list = Json::array();
  for (const Coordinate& coordinate : mechanism.coordinates)
    list.push_back({{"name", coordinate.name},
                    {"joint", coordinate.joint},
                    {"unit", coordinate.kind == CoordinateKind::angle ? "rad" : "m"}});
  return list;
}

Json couplings_json(const Mechanism& mechanism) {
  Json list = Json::array();
  for (const Coupling& coupling : mechanism.couplings)
    list.push_back({{"follower", coupling.follower},
                    {"leaders", followed_json(coupling.leader)},
                    {"ratio", coupling.ratio},
                    {"offset", coupling.offset}});
  return list;
}

Json loads_json(const Mechanism& mechanism) {
  Json list = Json::array();
  for (const Load& load : mechanism.loads) {
    Json forces = Json::array(), moments = Json::array();
    for (const Vector3& force : load.force) forces.push_back(place(force));
    for (const Vector3& moment : load.moment) moments.push_back(place(moment));
    list.push_back({{"name", load.name},
                    {"body", load.body},
                    {"point", place(load.point)},
                    {"frame", load.frame == Frame::world ? "world" : "body"},
                    {"time", load.time},
                    {"force", std::move(forces)},
                    {"moment", std::move(moments)}});
  }
  return list;
}

Json friction_json(const Mechanism& mechanism) {
  Json list = Json::array();
  for (const Friction& friction : mechanism.friction)
    list.push_back({{"coordinate", friction.coordinate},
                    {"viscous", friction.viscous},
                    {"coulomb", friction.dry_friction(1)},
                    {"coulomb_backward", friction.dry_friction(-1)}});
  return list;
}

}  // namespace

Json mechanism_json(const Mechanism& mechanism) {
  Json json = {{"length", characteristic_length(mechanism)},
               {"bodies", bodies_json(mechanism)},
               {"joints", joints_json(mechanism)},
               {"attachments", attachments_json(mechanism)},
               {"discs", discs_json(mechanism)},
               {"springs", springs_json(mechanism)},
               {"coordinates", coordinates_json(mechanism)},
               {"couplings", couplings_json(mechanism)},
               {"loads", loads_json(mechanism)},
               {"friction", friction_json(mechanism)}};
  json["actuated"] = Json::array();
  for (const int actuator : mechanism.actuators)
    json["actuated"].push_back(mechanism.coordinates[static_cast<std::size_t>(actuator)].joint);
  json["tool"] = nullptr;
  if (mechanism.tool) json["tool"] = {{"body", mechanism.tool->body}, {"position", place(mechanism.tool->position)}};
  return json;
}

}  // namespace balance
