#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
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

/// The words of a spec for the types of joints.
struct NamedJointType {
  const char* name;
  JointType type;
  bool planar, spatial;
  bool is_rolling = false;  ///< in the plane: a pin in a slot whose slide follows its angle
};

/// @throws ReadError if the word is no type of a planar or of a spatial mechanism; it names what others call so
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
                                       {"planar", JointType::planar, false, true}};

/// What others call the types.
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
  const std::string meant = at.is_scalar() ? find_synonym(at.node().text) : "";
  const bool known = at.is_scalar() && std::find(names.begin(), names.end(), at.node().text) != names.end();
  if (known || std::find(names.begin(), names.end(), meant) == names.end())
    return possible[at.read_choice(what, names)];
  at.fail({.expected = fmt::format("{} ({})", what, join_alternatives(names)),
           .found = at.describe_found(),
           .hint = fmt::format("that is '{}' here", meant)});
}

namespace {

bool has_axis(JointType type, bool planar) {
  if (planar) return type == JointType::prismatic || type == JointType::pin_slot;
  return type != JointType::fixed && type != JointType::spherical;
}

bool has_second_axis(JointType type) {
  return type == JointType::universal || type == JointType::planar || is_rolling(type);
}

/// What one joint's mapping says, before its parts are put together.
struct JointKeys {
  std::optional<SpecCursor> axis, axis2, rpy, quaternion, angle, radius, shape;
  bool rolls = false;
};

/// A direction at a right angle to `axis`: x if the axis is z, else the coordinate direction that is farthest from the axis,
/// made perpendicular: deterministic, never badly conditioned.
Vector3E perpendicular(const Vector3E& axis) {
  const auto square_to = [&](int i) {
    const Vector3E away = Vector3E::Unit(i);
    return normalized(away - axis[i] * axis);
  };
  const Expression x = abs(axis[0]), y = abs(axis[1]), z = abs(axis[2]);
  const Vector3E farthest = choose(logical_and(less_equal(x, y), less_equal(x, z)), square_to(0),
                                   choose(less_equal(y, z), square_to(1), square_to(2)));
  const Expression along_z = logical_and(logical_and(equal(axis[0], 0), equal(axis[1], 0)), equal(axis[2], 1));
  return choose(along_z, Vector3E(Vector3E::UnitX()), farthest);
}

void read_second_axis(const JointKeys& text, StudyBuilder& draft, JointOf<Expression>& joint, bool first_read) {
  if (joint.type == JointType::universal && text.axis.has_value() != text.axis2.has_value())
    (text.axis ? *text.axis : *text.axis2)
        .fail({.expected = "'axis' and 'axis2' of a universal joint together", .found = "only one of them"});
  if (!text.axis2) {
    const bool default_axes = joint.type == JointType::universal;
    joint.axis2 = default_axes ? Vector3E(Vector3E::UnitY()) : perpendicular(joint.axis);
    return;
  }
  joint.axis2 = read_direction(*text.axis2, draft);
  if (!first_read) throw CascadingError();
  const Expression cosine = joint.axis.dot(joint.axis2);
  // Directions typed with ten digits pass; anything less square is a different joint.
  if (std::abs(cosine.value()) > 1e-9)
    text.axis2->fail(
        {.expected = "a direction at a right angle to 'axis'",
         .found = fmt::format("the angle {:.9g} degrees",
                              elementary::acos(std::clamp(cosine.value(), -1.0, 1.0)) * 180 / std::numbers::pi)});
  // What is left of the tolerance is removed, so that every later step may rely on it.
  const Vector3E square = joint.axis2 - cosine * joint.axis;
  joint.axis2 = choose(less(0, square.squaredNorm()), normalized(square), perpendicular(joint.axis));
}

void read_axes(const JointKeys& text, StudyBuilder& draft, JointOf<Expression>& joint) {
  const bool planar = draft.planar();
  const bool default_x = (planar && has_axis(joint.type, planar)) || joint.type == JointType::universal;
  joint.axis = default_x ? Vector3E::UnitX() : Vector3E::UnitZ();
  joint.axis2 = Vector3E::UnitX();
  const bool first_read = draft.problems.collect([&] {
    if (!text.axis) return;
    if (!has_axis(joint.type, planar))
      text.axis->fail({.expected = fmt::format("no axis: this type of joint has none in a {} mechanism",
                                               planar ? "planar" : "spatial")});
    joint.axis = read_direction(*text.axis, draft);
  });
  if (has_second_axis(joint.type)) return read_second_axis(text, draft, joint, first_read);
  if (text.axis2) text.axis2->fail({.expected = "no 'axis2': only universal, planar and rolling joints have one"});
}

void read_rotation(const JointKeys& text, StudyBuilder& draft, JointOf<Expression>& joint) {
  if (text.rpy && text.quaternion) text.quaternion->fail({.expected = "'rpy' or 'quaternion'", .found = "both"});
  if (draft.planar()) {
    for (const auto& spatial : {text.rpy, text.quaternion})
      if (spatial) spatial->fail({.expected = "'angle' for a planar joint", .found = "a rotation in space"});
    if (text.angle) joint.rotation = rotation_about(2, read_number(*text.angle, draft, dimension::angle));
    return;
  }
  if (text.angle) text.angle->fail({.expected = "'rpy' or 'quaternion' for a joint in space", .found = "'angle'"});
  if (text.rpy) joint.rotation = read_rpy(*text.rpy, draft);
  if (text.quaternion) joint.rotation = read_quaternion(*text.quaternion, draft);
}

/// The wheel's centre lies its radius to the left of the line, and goes along it as the wheel turns.
/// @return the radius
Expression read_wheel(const SpecCursor& radius, StudyBuilder& draft, JointOf<Expression>& joint) {
  const Expression r = read_number(radius, draft, dimension::length, SignConstraint::positive);
  joint.point_first += r * Vector3E(-joint.axis.y(), joint.axis.x(), Expression(0));
  return r;
}

void read_shape(const SpecCursor& shape, const JointKeys& text, const StudyBuilder& draft, JointOf<Expression>& joint) {
  if (!text.rolls || draft.planar())
    shape.fail({.expected = text.rolls ? "no 'shape': in the plane, what rolls is a wheel"
                                       : "no 'shape': only rolling joints have one"});
  const bool sphere = shape.read_choice("the shape of what rolls", {"disc", "sphere"}) == 1;
  joint.type = sphere ? JointType::rolling_sphere : JointType::rolling_disc;
}

/// @param radius of a joint that rolls on a line
void read_joint(const SpecCursor& at, StudyBuilder& draft, JointOf<Expression>& joint,
                std::optional<Expression>& radius) {
  JointKeys text;
  const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  read_fields(at, "a joint",
              {{"type", Presence::required,
                [&](const SpecCursor& c) {
                  const NamedJointType type = read_joint_type(c, draft.planar());
                  joint.type = type.type;
                  text.rolls = type.is_rolling;
                }},
               {"connects", Presence::required, [&](const SpecCursor& c) { read_connection_points(c, draft, joint); }},
               {"axis", Presence::optional, keep(text.axis)},
               {"axis2", Presence::optional, keep(text.axis2)},
               {"rpy", Presence::optional, keep(text.rpy)},
               {"quaternion", Presence::optional, keep(text.quaternion)},
               {"angle", Presence::optional, keep(text.angle)},
               {"radius", Presence::optional, keep(text.radius)},
               {"shape", Presence::optional, keep(text.shape)}});
  if (text.shape && !draft.problems.is_uncertain(at.path() + ".type"))
    draft.problems.collect([&] { read_shape(*text.shape, text, draft, joint); });
  // Which axes there are is the type's to say; that they are directions, not.
  if (!draft.problems.is_uncertain(at.path() + ".type"))
    draft.problems.collect([&] { read_axes(text, draft, joint); });
  else
    for (const auto& axis : {text.axis, text.axis2})
      if (axis) draft.problems.collect([&] { read_direction(*axis, draft); });
  draft.problems.collect([&] { read_rotation(text, draft, joint); });
  if (draft.problems.is_uncertain(at.path() + ".type")) return;
  draft.problems.collect([&] {
    if (text.rolls && !text.radius)
      at.fail({.kind = "missing key", .expected = "'radius' of a rolling joint", .found = "none"});
    if (!text.rolls && text.radius) text.radius->fail({.expected = "no 'radius': only rolling joints have one"});
    if (text.rolls && draft.planar()) radius = read_wheel(*text.radius, draft, joint);
    if (text.rolls && !draft.planar())
      joint.radius = read_number(*text.radius, draft, dimension::length, SignConstraint::positive);
  });
}

/// Rolling without slip: what the contact point would slip by, d(slide) + r d(angle), is zero.
void couple_wheels(const std::map<int, Expression>& radii, StudyBuilder& draft) {
  const auto& coordinates = draft.mechanism().coordinates;
  for (std::size_t c = 0; c + 1 < coordinates.size(); ++c) {
    const auto wheel = radii.find(coordinates[c].joint);
    if (wheel == radii.end() || coordinates[c].index != 0) continue;
    CouplingOf<Expression> coupling;
    coupling.follower = static_cast<int>(c);
    coupling.leader = static_cast<int>(c) + 1;
    coupling.ratio = -wheel->second;
    draft.rolling_couplings.push_back(std::move(coupling));
  }
}

/// `J.slide` must be either a joint or a coordinate of one.
void check_coordinates(const std::vector<Member>& all, StudyBuilder& draft) {
  for (const Member& one : all) {
    const auto dot = one.name.rfind('.');
    if (dot == std::string::npos) continue;
    const std::string beginning = one.name.substr(0, dot);
    if (std::any_of(all.begin(), all.end(), [&](const Member& m) { return m.name == beginning; }))
      draft.problems.collect([&] {
        one.key.fail({.expected = "a name that does not begin with another joint's and a point",
                      .found = fmt::format("{} and {}", quote_for_message(one.name), quote_for_message(beginning))});
      });
  }
}

}  // namespace

void read_joints(const SpecCursor& section, StudyBuilder& draft) {
  draft.problems.collect([&] {
    const auto all = list_named_members(section, "a mapping of joints");
    if (all.empty()) section.fail_expected("at least one joint");
    std::map<int, Expression> radii;  // of joints that roll
    for (const Member& member : all) {
      JointOf<Expression> joint;
      joint.name = member.name;
      std::optional<Expression> radius;
      draft.problems.collect([&] { read_joint(member.value, draft, joint, radius); });
      if (radius) radii.emplace(static_cast<int>(draft.mechanism().joints.size()), *radius);
      draft.mechanism().joints.push_back(std::move(joint));
    }
    check_coordinates(all, draft);
    std::vector<Joint> types;
    for (const auto& joint : draft.mechanism().joints) types.push_back({.name = joint.name, .type = joint.type});
    draft.mechanism().coordinates = list_coordinates(draft.mechanism().space, types);
    couple_wheels(radii, draft);
  });
}

void check_connected(StudyBuilder& draft) {
  const auto& mechanism = draft.mechanism();
  std::vector<bool> used(mechanism.bodies.size()), reached(mechanism.bodies.size());
  reached[ground] = true;
  const auto at = [](BodyId body) { return static_cast<std::size_t>(body); };
  // A joint of the ground with itself is one whose ends could not be read.
  for (const auto& joint : mechanism.joints)
    if (joint.first == joint.second || draft.problems.is_uncertain("joints." + joint.name + ".connects")) return;
  if (draft.problems.is_section_invalid("joints.another")) return;
  for (const auto& joint : mechanism.joints) used[at(joint.first)] = used[at(joint.second)] = true;
  for (bool growing = true; growing;) {
    growing = false;
    for (const auto& joint : mechanism.joints) {
      if (reached[at(joint.first)] == reached[at(joint.second)]) continue;
      reached[at(joint.first)] = reached[at(joint.second)] = true;
      growing = true;
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

// Couplings, actuators, the tool: what refers to joints and points that are already there.

namespace {

/// What a coupling's mapping says; what could not be read is nothing.
struct CouplingKeys {
  std::optional<SpecCursor> joint, several, ratio, offset;
  std::optional<CoordinateId> follower, leader;
};

bool read_ratio(const CouplingKeys& text, StudyBuilder& draft, CouplingOf<Expression>& coupling) {
  const auto& coordinates = draft.mechanism().coordinates;
  const auto unit = [&](std::optional<CoordinateId> c) {
    return c ? dimension_of(coordinates[static_cast<std::size_t>(*c)].kind) : dimension::dimensionless;
  };
  const bool leader = !text.several || draft.problems.collect([&] {
    if (!text.follower) throw CascadingError();
    coupling.leader = read_followed(*text.several, draft, unit(text.follower));
  });
  const bool ratio = !text.ratio || draft.problems.collect([&] {
    const Dimension own = text.several ? dimension::dimensionless : unit(text.follower) / unit(text.leader);
    coupling.ratio = read_number(*text.ratio, draft, own);
    if (is_fixed_zero(*text.ratio, coupling.ratio, draft))
      text.ratio->fail({.expected = "a ratio other than 0 (a joint that does not move is 'fixed')", .found = "0"});
  });
  const bool offset = !text.offset || draft.problems.collect([&] {
    coupling.offset = read_number(*text.offset, draft, unit(text.follower));
  });
  return leader && ratio && offset;
}

bool is_rolling(const StudyBuilder& draft, CoordinateId coordinate) {
  return std::any_of(draft.rolling_couplings.begin(), draft.rolling_couplings.end(),
                     [&](const auto& wheel) { return wheel.follower == coordinate; });
}

void read_coupling(const SpecCursor& at, StudyBuilder& draft, CouplingGraph& leaders) {
  auto& mechanism = draft.mechanism();
  CouplingKeys text;
  const bool read = read_fields(at, "a coupling {joint, follows, ratio}",
                                {{"joint", Presence::required,
                                  [&](const SpecCursor& c) {
                                    text.joint = c;
                                    text.follower = read_coordinate(c, draft);
                                  }},
                                 {"follows", Presence::required,
                                  [&](const SpecCursor& c) {
                                    if (c.is_map())
                                      text.several = c;
                                    else
                                      text.leader = read_coordinate(c, draft);
                                  }},
                                 {"ratio", has_several_leaders(at) ? Presence::optional : Presence::required,
                                  [&](const SpecCursor& c) { text.ratio = c; }},
                                 {"offset", Presence::optional, [&](const SpecCursor& c) { text.offset = c; }}});
  CouplingOf<Expression> coupling;
  if (!read_ratio(text, draft, coupling) || !read) return;
  coupling.follower = *text.follower;
  if (text.leader) coupling.leader = *text.leader;
  const std::string name = mechanism.coordinates[static_cast<std::size_t>(coupling.follower)].name;
  std::vector<CoordinateId>& led_by = leaders[static_cast<std::size_t>(coupling.follower)];
  if (!led_by.empty())
    text.joint->fail({.expected = "a coordinate that follows one other",
                      .found = fmt::format(
                          "{}, which {}", quote_for_message(name),
                          is_rolling(draft, coupling.follower) ? "follows the wheel that rolls" : "is coupled twice")});
  if (creates_coupling_cycle(leaders, coupling.follower, coordinates_of(coupling.leader)))
    text.joint->fail({.kind = "circular coupling",
                      .expected = "a chain of couplings with an end",
                      .found = fmt::format("that {} follows itself", quote_for_message(name))});
  led_by = coordinates_of(coupling.leader);
  mechanism.couplings.push_back(coupling);
}

}  // namespace

void read_couplings(const SpecCursor& section, StudyBuilder& draft) {
  CouplingGraph leaders(draft.mechanism().coordinates.size());
  for (const auto& wheel : draft.rolling_couplings)
    leaders[static_cast<std::size_t>(wheel.follower)] = coordinates_of(wheel.leader);
  for (const SpecCursor& item : section.items("a list of couplings {joint, follows, ratio}"))
    draft.problems.collect([&] { read_coupling(item, draft, leaders); });
}

void read_actuators(const SpecCursor& section, StudyBuilder& draft) {
  draft.problems.collect([&] {
    auto& actuators = draft.mechanism().actuators;
    std::set<int> known(actuators.begin(), actuators.end());
    for (const SpecCursor& item : section.items("a list of joint coordinates")) {
      const bool read = draft.problems.collect([&] {
        const CoordinateId coordinate = read_coordinate(item, draft);
        if (!known.insert(coordinate).second)
          item.fail({.expected = "every actuator once", .found = fmt::format("{} again", item.describe_found())});
        actuators.push_back(coordinate);
      });
      if (!read) draft.problems.mark_invalid(item.path());
    }
  });
}

void read_tool(const SpecCursor& section, StudyBuilder& draft) {
  draft.problems.collect([&] {
    const PointReference point = read_reference(section, draft);
    if (point.body == ground) section.fail({.expected = "a point of a moving body", .found = section.describe_found()});
    draft.mechanism().tool = ToolOf<Expression>{point.body, point.name, point.position};
  });
}

}  // namespace balance::specification
