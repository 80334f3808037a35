#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_catalogue.hpp"
#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/mechanics/model/couplings.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::specification {

/// Names of joint types in a spec.
struct NamedJointType {
  const char* name;
  JointType type;
  bool planar, spatial;
  bool is_rolling = false;  ///< in the plane: a pin-slot joint whose slide follows its angle
};

/// @throws ReadError if the word is no type of a planar or of a spatial mechanism; suggests the type for a synonym
NamedJointType read_joint_type(const SpecCursor& at, bool planar);

namespace {

constexpr NamedJointType joint_types[]{{"revolute", JointType::revolute, true, true},
                                       {"prismatic", JointType::prismatic, true, true},
                                       {"fixed", JointType::fixed, true, true},
                                       {"pin-slot", JointType::pin_slot, true, false},
                                       {"rolling", JointType::pin_slot, true, false, true},
                                       {"rolling", JointType::rolling_disc, false, true, true},
                                       {"cylindrical", JointType::cylindrical, false, true},
                                       {"universal", JointType::universal, false, true},
                                       {"spherical", JointType::spherical, false, true},
                                       {"planar", JointType::planar, true, true},
                                       {"free", JointType::planar, true, false},
                                       {"free", JointType::free, false, true}};

/// Synonyms of the types.
constexpr std::pair<const char*, const char*> joint_type_synonyms[]{
    {"hinge", "revolute"},
    {"pin", "revolute"},
    {"pivot", "revolute"},
    {"rotary", "revolute"},
    {"rotational", "revolute"},
    {"turning", "revolute"},
    {"continuous", "revolute"},
    {"slider", "prismatic"},
    {"slide", "prismatic"},
    {"sliding", "prismatic"},
    {"linear", "prismatic"},
    {"translational", "prismatic"},
    {"ball", "spherical"},
    {"ball-joint", "spherical"},
    {"ball-and-socket", "spherical"},
    {"spheric", "spherical"},
    {"weld", "fixed"},
    {"welded", "fixed"},
    {"rigid", "fixed"},
    {"clamp", "fixed"},
    {"cardan", "universal"},
    {"hooke", "universal"},
    {"u-joint", "universal"},
    {"gimbal", "universal"},
    {"cylinder", "cylindrical"},
    {"cylindric", "cylindrical"},
    {"plane", "planar"},
    {"floating", "free"},
    {"freejoint", "free"},
    {"6dof", "free"},
    {"pin-in-slot", "pin-slot"},
    {"slot", "pin-slot"},
    {"slotted", "pin-slot"},
    {"wheel", "rolling"},
    {"roll", "rolling"},
    {"rolling-contact", "rolling"},
};

/// The type that a word means in another vocabulary; empty: none.
std::string find_synonym(std::string word) {
  for (char& c : word) c = c == '_' || c == ' ' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* ending : {"-joint", "-pair"})
    if (word.ends_with(ending) && word != ending) word.erase(word.size() - std::string_view(ending).size());
  for (const auto& [synonym, type] : joint_type_synonyms)
    if (word == synonym || word == type) return type;
  return word == "u" ? "universal" : "";
}

}  // namespace

NamedJointType read_joint_type(const SpecCursor& at, bool planar) {
  std::vector<std::string> names;
  std::vector<NamedJointType> possible;
  for (const NamedJointType& t : joint_types) {
    if (!(planar ? t.planar : t.spatial)) continue;
    names.emplace_back(t.name);
    possible.push_back(t);
  }
  const std::string what = fmt::format("a joint type of a {} mechanism", planar ? "planar" : "spatial");
  const std::string synonym_type = at.is_scalar() ? find_synonym(at.node().text) : "";
  const bool is_known = at.is_scalar() && std::find(names.begin(), names.end(), at.node().text) != names.end();
  if (is_known || std::find(names.begin(), names.end(), synonym_type) == names.end())
    return possible[at.read_choice(what, names)];
  at.fail({.expected = fmt::format("{} ({})", what, join_alternatives(names)),
           .found = at.describe_found(),
           .hint = fmt::format("its name here is '{}'", synonym_type)});
}

namespace {

bool has_axis(JointType type, bool planar) {
  if (planar) return type == JointType::prismatic || type == JointType::pin_slot || type == JointType::planar;
  return type != JointType::fixed && type != JointType::spherical && type != JointType::free;
}

bool has_second_axis(JointType type) {
  return type == JointType::universal || type == JointType::planar || is_rolling(type);
}

/// Keys of one joint, before they are assembled.
struct JointKeys {
  std::optional<SpecCursor> axis, axis2, rpy, quaternion, angle, radius, shape;
  bool rolls = false;
};

/// A direction perpendicular to `axis`: x if the axis is z, else the coordinate direction that is farthest from the
/// axis, made perpendicular. Deterministic and well conditioned.
Vector3E perpendicular(const Vector3E& axis) {
  const auto perpendicular_unit = [&](int i) {
    const Vector3E unit = Vector3E::Unit(i);
    return normalized(unit - axis[i] * axis);
  };
  const Expression x = abs(axis[0]), y = abs(axis[1]), z = abs(axis[2]);
  const Vector3E farthest = choose(logical_and(less_equal(x, y), less_equal(x, z)), perpendicular_unit(0),
                                   choose(less_equal(y, z), perpendicular_unit(1), perpendicular_unit(2)));
  const Expression along_z = logical_and(logical_and(equal(axis[0], 0), equal(axis[1], 0)), equal(axis[2], 1));
  return choose(along_z, Vector3E(Vector3E::UnitX()), farthest);
}

void read_second_axis(const JointKeys& keys, StudyBuilder& draft, model::JointOf<Expression>& joint, bool first_read) {
  if (joint.type == JointType::universal && keys.axis.has_value() != keys.axis2.has_value())
    (keys.axis ? *keys.axis : *keys.axis2)
        .fail({.expected = "both 'axis' and 'axis2' of a universal joint", .found = "only one of them"});
  if (!keys.axis2) {
    const bool default_axes = joint.type == JointType::universal;
    joint.axis2 = default_axes ? Vector3E(Vector3E::UnitY()) : perpendicular(joint.axis);
    return;
  }
  joint.axis2 = read_direction(*keys.axis2, draft);
  if (!first_read) throw CascadingError();
  const Expression cosine = joint.axis.dot(joint.axis2);
  // directions typed with ten digits pass; anything less perpendicular is a different joint
  if (std::abs(cosine.value()) > 1e-9)
    keys.axis2->fail(
        {.expected = "a direction perpendicular to 'axis'",
         .found = fmt::format("an angle of {:.9g} degrees",
                              elementary::acos(std::clamp(cosine.value(), -1.0, 1.0)) * 180 / std::numbers::pi)});
  // the remaining deviation is removed, so that later steps may rely on perpendicular axes
  const Vector3E orthogonal = joint.axis2 - cosine * joint.axis;
  joint.axis2 = choose(less(0, orthogonal.squaredNorm()), normalized(orthogonal), perpendicular(joint.axis));
}

void read_axes(const JointKeys& keys, StudyBuilder& draft, model::JointOf<Expression>& joint) {
  const bool planar = draft.planar();
  const bool default_x = (planar && has_axis(joint.type, planar)) || joint.type == JointType::universal;
  joint.axis = default_x ? Vector3E::UnitX() : Vector3E::UnitZ();
  joint.axis2 = Vector3E::UnitX();
  const bool first_read = draft.problems.collect([&] {
    if (!keys.axis) return;
    if (!has_axis(joint.type, planar))
      keys.axis->fail({.expected = fmt::format("no axis: this type of joint has none in a {} mechanism",
                                               planar ? "planar" : "spatial")});
    joint.axis = read_direction(*keys.axis, draft);
  });
  if (planar && joint.type == JointType::planar) {  // given is the direction of x; the normal is the plane's
    joint.axis2 = joint.axis;
    joint.axis = Vector3E::UnitZ();
  }
  if (has_second_axis(joint.type) && !planar) return read_second_axis(keys, draft, joint, first_read);
  if (keys.axis2)
    keys.axis2->fail({.expected = planar && joint.type == JointType::planar
                                      ? "no 'axis2': in the plane, 'axis' is the direction of x"
                                      : "no 'axis2': only universal, planar and rolling joints have one"});
}

void read_rotation(const JointKeys& keys, StudyBuilder& draft, model::JointOf<Expression>& joint) {
  if (keys.rpy && keys.quaternion) keys.quaternion->fail({.expected = "'rpy' or 'quaternion'", .found = "both"});
  if (draft.planar()) {
    for (const auto& spatial : {keys.rpy, keys.quaternion})
      if (spatial) spatial->fail({.expected = "'angle' for a planar joint", .found = "a rotation in space"});
    if (keys.angle) joint.rotation = rotation_about(2, read_number(*keys.angle, draft, dimension::angle));
    return;
  }
  if (keys.angle) keys.angle->fail({.expected = "'rpy' or 'quaternion' for a joint in space", .found = "'angle'"});
  if (keys.rpy) joint.rotation = read_rpy(*keys.rpy, draft);
  if (keys.quaternion) joint.rotation = read_quaternion(*keys.quaternion, draft);
}

/// The wheel's centre is its radius to the left of the line, and moves along it as the wheel turns.
/// @return the radius
Expression read_wheel(const SpecCursor& radius, StudyBuilder& draft, model::JointOf<Expression>& joint) {
  const Expression r = read_number(radius, draft, dimension::length, SignConstraint::positive);
  joint.point_first += r * Vector3E(-joint.axis.y(), joint.axis.x(), Expression(0));
  return r;
}

void read_shape(const SpecCursor& shape, const JointKeys& keys, const StudyBuilder& draft,
                model::JointOf<Expression>& joint) {
  if (!keys.rolls || draft.planar())
    shape.fail({.expected = keys.rolls ? "no 'shape': in the plane, what rolls is a wheel"
                                       : "no 'shape': only rolling joints have one"});
  const bool is_sphere = shape.read_choice("the shape of what rolls", {"disc", "sphere"}) == 1;
  joint.type = is_sphere ? JointType::rolling_sphere : JointType::rolling_disc;
}

/// @param radius set for a joint that rolls on a line
void read_joint(const SpecCursor& at, StudyBuilder& draft, model::JointOf<Expression>& joint,
                std::optional<Expression>& radius) {
  JointKeys keys;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  read_fields(at, "a joint",
              {{"type", Presence::required,
                [&](const SpecCursor& c) {
                  const NamedJointType type = read_joint_type(c, draft.planar());
                  joint.type = type.type;
                  keys.rolls = type.is_rolling;
                }},
               {"connects", Presence::required, [&](const SpecCursor& c) { read_connection_points(c, draft, joint); }},
               {"axis", Presence::optional, store_in(keys.axis)},
               {"axis2", Presence::optional, store_in(keys.axis2)},
               {"rpy", Presence::optional, store_in(keys.rpy)},
               {"quaternion", Presence::optional, store_in(keys.quaternion)},
               {"angle", Presence::optional, store_in(keys.angle)},
               {"radius", Presence::optional, store_in(keys.radius)},
               {"shape", Presence::optional, store_in(keys.shape)}});
  if (keys.shape && !draft.problems.is_uncertain(at.path() + ".type"))
    draft.problems.collect([&] { read_shape(*keys.shape, keys, draft, joint); });
  // the type determines which axes there are, but not whether they are directions
  if (!draft.problems.is_uncertain(at.path() + ".type"))
    draft.problems.collect([&] { read_axes(keys, draft, joint); });
  else
    for (const auto& axis : {keys.axis, keys.axis2})
      if (axis) draft.problems.collect([&] { read_direction(*axis, draft); });
  draft.problems.collect([&] { read_rotation(keys, draft, joint); });
  if (draft.problems.is_uncertain(at.path() + ".type")) return;
  draft.problems.collect([&] {
    if (keys.rolls && !keys.radius)
      at.fail({.kind = "missing key", .expected = "'radius' of a rolling joint", .found = "none"});
    if (!keys.rolls && keys.radius) keys.radius->fail({.expected = "no 'radius': only rolling joints have one"});
    if (keys.rolls && draft.planar()) radius = read_wheel(*keys.radius, draft, joint);
    if (keys.rolls && !draft.planar())
      joint.radius = read_number(*keys.radius, draft, dimension::length, SignConstraint::positive);
  });
}

/// Rolling without slip: the slip of the contact point, d(slide) + r d(angle), is zero.
void couple_wheels(const std::map<int, Expression>& radii, StudyBuilder& draft) {
  const auto& coordinates = draft.mechanism().coordinates;
  for (std::size_t c = 0; c + 1 < coordinates.size(); ++c) {
    const auto wheel = radii.find(coordinates[c].joint);
    if (wheel == radii.end() || coordinates[c].index != 0) continue;
    model::CouplingOf<Expression> coupling;
    coupling.follower = static_cast<int>(c);
    coupling.leader = static_cast<int>(c) + 1;
    coupling.ratio = -wheel->second;
    draft.rolling_couplings.push_back(std::move(coupling));
  }
}

/// `J.slide` must be either a joint or a coordinate of one.
void check_coordinates(const std::vector<Member>& joints, StudyBuilder& draft) {
  for (const Member& joint : joints) {
    const auto dot = joint.name.rfind('.');
    if (dot == std::string::npos) continue;
    const std::string prefix = joint.name.substr(0, dot);
    if (std::any_of(joints.begin(), joints.end(), [&](const Member& m) { return m.name == prefix; }))
      draft.problems.collect([&] {
        joint.key.fail({.expected = "a name that does not start with another joint's name and '.'",
                        .found = fmt::format("{} and {}", quote_for_message(joint.name), quote_for_message(prefix))});
      });
  }
}

}  // namespace

void read_joints(const SpecCursor& section, StudyBuilder& draft) {
  draft.problems.collect([&] {
    const auto members = list_named_members(section, "a mapping of joints");
    if (members.empty()) section.fail_expected("at least one joint");
    std::map<int, Expression> radii;  // of joints that roll
    for (const Member& member : members) {
      model::JointOf<Expression> joint;
      joint.name = member.name;
      std::optional<Expression> radius;
      draft.problems.collect([&] { read_joint(member.value, draft, joint, radius); });
      if (radius) radii.emplace(static_cast<int>(draft.mechanism().joints.size()), *radius);
      draft.mechanism().joints.push_back(std::move(joint));
    }
    check_coordinates(members, draft);
    list_joint_coordinates(draft);
    couple_wheels(radii, draft);
  });
}

void check_connected(StudyBuilder& draft) {
  const auto& mechanism = draft.mechanism();
  std::vector<bool> used(mechanism.bodies.size()), reached(mechanism.bodies.size());
  reached[model::ground] = true;
  const auto index = [](BodyId body) { return static_cast<std::size_t>(body); };
  // A joint of the ground with itself is one whose ends could not be read.
  for (const auto& joint : mechanism.joints)
    if (joint.first == joint.second || draft.problems.is_uncertain("joints." + joint.name + ".connects")) return;
  if (draft.problems.is_section_invalid("joints.another")) return;
  for (const auto& joint : mechanism.joints) used[index(joint.first)] = used[index(joint.second)] = true;
  for (bool has_grown = true; has_grown;) {
    has_grown = false;
    for (const auto& joint : mechanism.joints) {
      if (reached[index(joint.first)] == reached[index(joint.second)]) continue;
      reached[index(joint.first)] = reached[index(joint.second)] = true;
      has_grown = true;
    }
  }
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) {
    const std::string path = "bodies." + mechanism.bodies[b].name;
    if (!used[b])
      draft.problems.add({draft.body_places[b],
                          path,
                          {.kind = "unused body", .expected = "a joint that connects it", .found = "none"}});
    if (used[b] && !reached[b])
      draft.problems.add(
          {draft.body_places[b],
           path,
           {.kind = "disconnected", .expected = "a chain of joints from the ground to this body", .found = "none"}});
  }
}

// Couplings, actuators and the tool, which refer to existing joints and points.

namespace {

/// Keys of a coupling; std::nullopt if they could not be read.
struct CouplingKeys {
  std::optional<SpecCursor> joint, combination, ratio, offset;
  std::optional<CoordinateId> follower, leader;
  CatalogueKeys catalogue;
};

/// The ratio of a row: as such, or as that of teeth of two wheels, which turn in opposite directions unless one of them
/// has teeth inside.
Expression read_stock_ratio(const SpecCursor& at, const CouplingKeys& keys, StudyBuilder& draft,
                            Dimension ratio_dimension) {
  const CatalogueNumbers row = read_catalogue(at.path(), keys.catalogue, draft,
                                              {{"ratio", ratio_dimension, SignConstraint::none},
                                               {"teeth", dimension::dimensionless, SignConstraint::positive},
                                               {"teeth_of_leader", dimension::dimensionless, SignConstraint::positive},
                                               {"internal", dimension::dimensionless}});
  if (keys.ratio) keys.ratio->fail({.expected = "no 'ratio' with 'catalogue', whose rows have it", .found = "both"});
  if (keys.catalogue.count) keys.catalogue.count->fail({.expected = "no 'count' for a coupling", .found = "it"});
  if (const std::optional<Expression> ratio = row.find("ratio")) return *ratio;
  const std::optional<Expression> teeth = row.find("teeth"), of_leader = row.find("teeth_of_leader");
  if (!teeth || !of_leader)
    keys.catalogue.catalogue->fail(
        {.expected = "a catalogue with a column of 'ratio', or columns of 'teeth' and 'teeth_of_leader'",
         .found = "none"});
  const Expression outside = -(*of_leader / *teeth);
  const std::optional<Expression> internal = row.find("internal");
  return internal ? expression::select(expression::equal(*internal, 0), outside, -outside) : outside;
}

bool read_ratio(const SpecCursor& at, const CouplingKeys& keys, StudyBuilder& draft,
                model::CouplingOf<Expression>& coupling) {
  const auto& coordinates = draft.mechanism().coordinates;
  const auto unit = [&](std::optional<CoordinateId> c) {
    return c ? dimension_of(coordinates[static_cast<std::size_t>(*c)].kind) : dimension::dimensionless;
  };
  const bool is_leader_read = !keys.combination || draft.problems.collect([&] {
    if (!keys.follower) throw CascadingError();
    coupling.leader = read_followed(*keys.combination, draft, unit(keys.follower));
  });
  const bool is_ratio_read = (!keys.ratio && !keys.catalogue.catalogue) || draft.problems.collect([&] {
    const Dimension ratio_dimension =
        keys.combination ? dimension::dimensionless : unit(keys.follower) / unit(keys.leader);
    if (keys.catalogue.catalogue) {
      coupling.ratio = read_stock_ratio(at, keys, draft, ratio_dimension);
      return;
    }
    coupling.ratio = read_number(*keys.ratio, draft, ratio_dimension);
    if (is_fixed_zero(*keys.ratio, coupling.ratio, draft))
      keys.ratio->fail({.expected = "a ratio other than 0 (a joint that does not move is 'fixed')", .found = "0"});
  });
  const bool is_offset_read = !keys.offset || draft.problems.collect([&] {
    coupling.offset = read_number(*keys.offset, draft, unit(keys.follower));
  });
  return is_leader_read && is_ratio_read && is_offset_read;
}

bool is_rolling(const StudyBuilder& draft, CoordinateId coordinate) {
  return std::any_of(draft.rolling_couplings.begin(), draft.rolling_couplings.end(),
                     [&](const auto& wheel) { return wheel.follower == coordinate; });
}

void read_coupling(const SpecCursor& at, StudyBuilder& draft, model::CouplingGraph& leaders) {
  auto& mechanism = draft.mechanism();
  CouplingKeys keys;
  std::vector<Field> fields{
      {"joint", Presence::required,
       [&](const SpecCursor& c) {
         keys.joint = c;
         keys.follower = read_coordinate(c, draft);
       }},
      {"follows", Presence::required,
       [&](const SpecCursor& c) {
         if (c.is_map())
           keys.combination = c;
         else
           keys.leader = read_coordinate(c, draft);
       }},
      {"ratio", has_several_leaders(at) || at.has_entry("catalogue") ? Presence::optional : Presence::required,
       [&](const SpecCursor& c) { keys.ratio = c; }},
      {"offset", Presence::optional, [&](const SpecCursor& c) { keys.offset = c; }}};
  for (Field& field : keys.catalogue.fields()) fields.push_back(std::move(field));
  const bool read = read_fields(at, "a coupling {joint, follows, ratio}", fields);
  model::CouplingOf<Expression> coupling;
  if (!read_ratio(at, keys, draft, coupling) || !read) return;
  coupling.follower = *keys.follower;
  if (keys.leader) coupling.leader = *keys.leader;
  const std::string name = mechanism.coordinates[static_cast<std::size_t>(coupling.follower)].name;
  std::vector<CoordinateId>& follower_leaders = leaders[static_cast<std::size_t>(coupling.follower)];
  if (!follower_leaders.empty())
    keys.joint->fail({.expected = "a coordinate that follows only one other",
                      .found = fmt::format(
                          "{}, which {}", quote_for_message(name),
                          is_rolling(draft, coupling.follower) ? "follows the wheel that rolls" : "is coupled twice")});
  if (creates_coupling_cycle(leaders, coupling.follower, coordinates_of(coupling.leader)))
    keys.joint->fail({.kind = "circular coupling",
                      .expected = "couplings without a cycle",
                      .found = fmt::format("that {} follows itself", quote_for_message(name))});
  follower_leaders = coordinates_of(coupling.leader);
  mechanism.couplings.push_back(coupling);
}

}  // namespace

void read_couplings(const SpecCursor& section, StudyBuilder& draft) {
  model::CouplingGraph leaders(draft.mechanism().coordinates.size());
  for (const auto& wheel : draft.rolling_couplings)
    leaders[static_cast<std::size_t>(wheel.follower)] = coordinates_of(wheel.leader);
  for (const SpecCursor& item : section.items("a list of couplings {joint, follows, ratio}"))
    draft.problems.collect([&] { read_coupling(item, draft, leaders); });
}

void read_actuators(const SpecCursor& section, StudyBuilder& draft) {
  draft.problems.collect([&] {
    auto& actuators = draft.mechanism().actuators;
    std::set<int> actuated(actuators.begin(), actuators.end());
    for (const SpecCursor& item : section.items("a list of joint coordinates")) {
      const bool read = draft.problems.collect([&] {
        const CoordinateId coordinate = read_coordinate(item, draft);
        if (!actuated.insert(coordinate).second)
          item.fail({.expected = "each actuator only once", .found = fmt::format("{} again", item.describe_found())});
        actuators.push_back(coordinate);
      });
      if (!read) draft.problems.mark_invalid(item.path());
    }
  });
}

void read_tool(const SpecCursor& section, StudyBuilder& draft) {
  draft.problems.collect([&] {
    const PointReference point = read_reference(section, draft);
    if (point.body == model::ground)
      section.fail({.expected = "a point of a moving body", .found = section.describe_found()});
    draft.mechanism().tool = model::ToolOf<Expression>{point.body, point.name, point.position};
  });
}

}  // namespace balance::specification
