// Bodies and what they carry: counterweights, payloads, discs.

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_catalogue.hpp"
#include "balance/interface/specification/read_shape.hpp"
#include "balance/interface/specification/read_temporary_payloads.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/mechanics/model/mechanism_conversion.hpp"
#include "balance/mechanics/model/validation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace balance::specification {

// Inertias, and whether a body can have them.

/// A number (planar), three or six numbers [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] (spatial): the entries
/// of the matrix, Ixy = −∫xy dm.
Matrix3E read_inertia_value(const SpecCursor& at, StudyBuilder& draft);

/// Inertia of a body: the same, `{about: origin, value: …}`, or `{as_given: …}`, which keeps an inertia that no
/// body can have, with a warning.
/// @return about the CoM; checked with check_inertia
/// @param mass std::nullopt if mass or com could not be read: the inertia is then not shifted
Matrix3E read_inertia(const SpecCursor& at, StudyBuilder& draft, const std::optional<Expression>& mass,
                      const Vector3E& com);

/// Fails unless some distribution of positive mass has this inertia about its CoM.
void check_inertia(const SpecCursor& at, const Matrix3E& inertia, const StudyBuilder& draft, model::InertiaOwner owner);

namespace {

/// Keys of everything that a body carries.
struct AttachedKeys {
  std::optional<BodyId> body;
  std::optional<SpecCursor> at, mass, inertia, shape;
  CatalogueKeys catalogue;
};

int read_carrier(const SpecCursor& at, const StudyBuilder& draft) {
  const BodyId body = read_body(at, draft);
  if (body == model::ground) at.fail({.expected = "a moving body", .found = "the ground"});
  return body;
}

std::vector<Field> attached_fields(AttachedKeys& carried, StudyBuilder& draft) {
  return {{"body", Presence::required, [&](const SpecCursor& c) { carried.body = read_carrier(c, draft); }, "on"},
          {"at", Presence::required, [&](const SpecCursor& c) { carried.at = c; }},
          {"mass", Presence::required, [&](const SpecCursor& c) { carried.mass = c; }},
          {"inertia", Presence::optional, [&](const SpecCursor& c) { carried.inertia = c; }}};
}

/// What a catalogue may say of a counterweight: its mass and inertia, or sizes of its shape.
std::vector<CatalogueProperty> list_attachment_properties(bool has_shape) {
  if (!has_shape) return {{"mass", dimension::mass}, {"inertia", dimension::inertia}};
  return {{"diameter", dimension::length},
          {"inner_diameter", dimension::length},
          {"thickness", dimension::length},
          {"length", dimension::length},
          {"width", dimension::length}};
}

/// Parts side by side have the masses of all, about a common centre of mass; parts with a shape are stacked.
void read_stock_attachment(const SpecCursor& at, const AttachedKeys& carried, StudyBuilder& draft,
                           model::AttachmentOf<Expression>& attachment) {
  const CatalogueNumbers row =
      read_catalogue(at.path(), carried.catalogue, draft, list_attachment_properties(carried.shape.has_value()));
  if (carried.shape) {
    std::vector<std::pair<std::string, Expression>> sizes = row.all();
    for (auto& [name, value] : sizes)
      if (name == "thickness") value = row.count * value;
    const SolidE solid = read_shape(*carried.shape, draft, sizes);
    attachment.shape = solid.shape, attachment.mass = solid.mass, attachment.inertia = solid.inertia;
    attachment.position = attachment.position + solid.centre;
    return;
  }
  const auto key = [](const std::optional<SpecCursor>& c) { return c ? &*c : nullptr; };
  const std::optional<Expression> mass =
      choose_number(&row, "mass", key(carried.mass), draft, dimension::mass, SignConstraint::not_negative);
  if (!mass)
    carried.catalogue.catalogue->fail(
        {.expected = "a catalogue with a column of 'mass', or that key", .found = "none"});
  attachment.mass = row.count * *mass;
  if (const std::optional<Expression> inertia = row.find("inertia")) {
    if (carried.inertia)
      choose_number(&row, "inertia", &*carried.inertia, draft, dimension::inertia, SignConstraint::none);
    attachment.inertia(2, 2) = row.count * *inertia;
    if (!draft.planar()) attachment.inertia(0, 0) = attachment.inertia(1, 1) = row.count * *inertia;
  } else if (carried.inertia) {
    attachment.inertia = read_inertia_value(*carried.inertia, draft);
    check_inertia(*carried.inertia, attachment.inertia, draft, model::InertiaOwner::attachment);
  }
}

void read_attachment(const SpecCursor& at, StudyBuilder& draft, model::AttachmentOf<Expression>& attachment) {
  AttachedKeys carried;
  PresenceKeys presence;
  std::vector<Field> fields = attached_fields(carried, draft);
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  fields.push_back({"shape", Presence::optional, store_in(carried.shape)});
  for (Field& field : carried.catalogue.fields()) fields.push_back(std::move(field));
  if (at.has_entry("shape") || at.has_entry("catalogue")) fields[2].need = Presence::optional;
  for (Field& field : presence_fields(at, attachment.kind, presence)) fields.push_back(std::move(field));
  read_fields(at, "a mass {body, at, mass}", fields);
  read_presence(presence, draft, attachment);
  attachment.body = carried.body.value_or(model::ground);
  if (carried.at)
    draft.problems.collect([&] { attachment.position = read_position(*carried.at, draft, carried.body); });
  if (carried.shape)
    for (const auto& [key, name] : {std::pair(&carried.mass, "mass"), std::pair(&carried.inertia, "inertia")})
      if (*key)
        (*key)->fail({.expected = fmt::format("no '{}' with 'shape', which determines it", name), .found = "both"});
  if (carried.catalogue.catalogue) return read_stock_attachment(at, carried, draft, attachment);
  for (const std::optional<SpecCursor>* key : {&carried.catalogue.columns, &carried.catalogue.count})
    if (*key) (*key)->fail({.expected = "'catalogue' (a file) as well", .found = "none"});
  if (carried.shape) {
    const SolidE solid = read_shape(*carried.shape, draft);
    attachment.shape = solid.shape, attachment.mass = solid.mass, attachment.inertia = solid.inertia;
    attachment.position = attachment.position + solid.centre;
    return;
  }
  if (carried.mass)
    draft.problems.collect(
        [&] { attachment.mass = read_number(*carried.mass, draft, dimension::mass, SignConstraint::not_negative); });
  if (!carried.inertia) return;
  draft.problems.collect([&] {
    attachment.inertia = read_inertia_value(*carried.inertia, draft);
    check_inertia(*carried.inertia, attachment.inertia, draft, model::InertiaOwner::attachment);
  });
}

constexpr double parallel_tolerance = 1e-9;  ///< of the sine of the angle between two directions

/// Keys of a disc, before they are assembled.
struct DiscKeys {
  AttachedKeys carried;
  std::optional<model::CoordinateCombinationOf<Expression>> follows;
  std::optional<SpecCursor> ratio, axis;
};

/// Direction of the followed joint's axis in the axes of the disc's body, in which it must be fixed.
Vector3E followed_axis(const SpecCursor& at, const StudyBuilder& draft, const DiscKeys& keys,
                       const model::DiscOf<Expression>& disc) {
  if (!keys.carried.body || !keys.follows) throw CascadingError();
  const auto& mechanism = draft.mechanism();
  if (disc.follows.terms.size() > 1)
    at.fail({.kind = "missing key",
             .expected = "'axis', the direction about which the disc turns in its carrier, because it follows several "
                         "coordinates"});
  const Coordinate& coordinate = mechanism.coordinates[static_cast<std::size_t>(disc.follows.terms[0].coordinate)];
  const auto& joint = mechanism.joints[static_cast<std::size_t>(coordinate.joint)];
  if (draft.problems.is_invalid("joints." + joint.name)) throw CascadingError();
  const bool on_first = disc.body == joint.first;
  const bool on_second = disc.body == joint.second;
  const bool universal = joint.type == JointType::universal;
  // of a universal joint the first axis is fixed in the first body, the second axis in the second body
  const bool has_fixed_axis = joint.type != JointType::spherical && joint.type != JointType::free &&
                              (!universal || (coordinate.index == 0 ? on_first : on_second));
  if ((!on_first && !on_second) || !has_fixed_axis)
    at.fail({.kind = "missing key",
             .expected = fmt::format("'axis', the direction about which the disc turns in {}, because the axis of {} "
                                     "is not fixed there",
                                     quote_for_message(mechanism.bodies[static_cast<std::size_t>(disc.body)].name),
                                     quote_for_message(coordinate.name))});
  const Vector3E axis = universal && coordinate.index == 1 ? joint.axis2 : joint.axis;
  return on_first ? axis : Vector3E(joint.rotation.transpose() * axis);
}

/// A number (planar); {axial, transverse}, three or six numbers (spatial).
Matrix3E read_disc_inertia(const SpecCursor& at, StudyBuilder& draft, const Vector3E& axis) {
  if (draft.planar() || at.is_list()) return read_inertia_value(at, draft);
  Expression axial = 0, transverse = 0;
  const bool read = read_fields(
      at, "an inertia {axial, transverse}, [Ixx, Iyy, Izz] or six numbers",
      {{"axial", Presence::required, [&](const SpecCursor& c) { axial = read_number(c, draft, dimension::inertia); }},
       {"transverse", Presence::required,
        [&](const SpecCursor& c) { transverse = read_number(c, draft, dimension::inertia); }}});
  if (!read) return Matrix3E::Zero();
  const Matrix3E axis_projection = axis * axis.transpose(), identity = Matrix3E::Identity();
  return transverse * identity + (axial - transverse) * axis_projection;
}

/// @param sum whether it follows several coordinates, with ratios of their own
Expression read_disc_ratio(const SpecCursor& at, StudyBuilder& draft, const model::DiscOf<Expression>& disc, bool sum) {
  const auto followed = static_cast<std::size_t>(disc.follows.terms[0].coordinate);
  const Dimension ratio_dimension =
      sum ? dimension::dimensionless : dimension::angle / dimension_of(draft.mechanism().coordinates[followed].kind);
  const Expression ratio = read_number(at, draft, ratio_dimension);
  if (is_fixed_zero(at, ratio, draft))
    at.fail({.expected = "a ratio other than 0 (a disc that does not turn is a counterweight)", .found = "0"});
  return ratio;
}

void assemble_disc(const SpecCursor& at, const DiscKeys& keys, StudyBuilder& draft, model::DiscOf<Expression>& disc) {
  const AttachedKeys& carried = keys.carried;
  const auto guard = [&](auto&& read) { return draft.problems.collect(read); };
  disc.body = carried.body.value_or(model::ground);
  disc.follows = keys.follows.value_or(0);
  if (carried.at) guard([&] { disc.position = read_position(*carried.at, draft, carried.body); });
  if (keys.ratio)
    guard([&] {
      if (keys.follows)
        disc.ratio = read_disc_ratio(*keys.ratio, draft, disc, has_several_leaders(at));
      else
        read_number(*keys.ratio, draft, dimension::dimensionless);
    });
  const bool axis_read = guard([&] {
    if (keys.axis && draft.planar()) keys.axis->fail({.expected = "no axis: a disc in the plane turns about z"});
    if (keys.axis)
      disc.axis = read_direction(*keys.axis, draft);
    else if (!draft.planar())
      disc.axis = followed_axis(at, draft, keys, disc);
  });
  if (carried.mass)
    guard([&] { disc.mass = read_number(*carried.mass, draft, dimension::mass, SignConstraint::not_negative); });
  if (carried.inertia)
    guard([&] {
      disc.inertia = read_disc_inertia(*carried.inertia, draft, disc.axis);
      if (axis_read) check_inertia(*carried.inertia, disc.inertia, draft, model::InertiaOwner::attachment);
    });
}

std::vector<Field> disc_fields(DiscKeys& keys, StudyBuilder& draft) {
  auto fields = attached_fields(keys.carried, draft);
  fields[0].read = [&](const SpecCursor& c) {
    keys.carried.body = read_body(c, draft);
  };  // the ground carries discs, too
  fields[2].need = Presence::optional;
  fields[3].need = Presence::required;
  fields.push_back({"follows", Presence::required,
                    [&](const SpecCursor& c) { keys.follows = read_followed(c, draft, dimension::angle); }});
  fields.push_back({"ratio", Presence::optional, [&](const SpecCursor& c) { keys.ratio = c; }});
  fields.push_back({"axis", Presence::optional, [&](const SpecCursor& c) { keys.axis = c; }});
  return fields;
}

void read_disc(const SpecCursor& at, StudyBuilder& draft, model::DiscOf<Expression>& disc) {
  DiscKeys keys;
  read_fields(at, "a disc {body, at, follows, ratio, mass, inertia}", disc_fields(keys, draft));
  if (at.is_map()) assemble_disc(at, keys, draft, disc);
}

// Eccentric discs: balance shafts.

struct EccentricityKeys {
  std::optional<SpecCursor> eccentricity, phase, zero;
};

/// The centre of mass in the axes of the turning disc, which at coordinate zero are those of its carrier.
Vector3E read_eccentric_place(const EccentricityKeys& keys, const Vector3E& axis, StudyBuilder& draft) {
  const Expression distance = read_number(*keys.eccentricity, draft, dimension::length);
  const Expression phase = keys.phase ? read_number(*keys.phase, draft, dimension::angle) : Expression(0);
  if (draft.planar()) {
    if (keys.zero) keys.zero->fail({.expected = "no 'zero' in the plane, where phases count from the x axis"});
    return {distance * cos(phase), distance * sin(phase), Expression(0)};
  }
  if (!keys.zero)
    keys.eccentricity->fail(
        {.kind = "missing key", .expected = "'zero' beside it in space: the direction of phase zero in the carrier"});
  const Vector3E direction = read_direction(*keys.zero, draft);
  const Vector3E across = axis.cross(direction);
  const auto values = [](const Vector3E& v) { return Vector3(v[0].value(), v[1].value(), v[2].value()); };
  if (values(axis).cross(values(direction)).norm() < parallel_tolerance)
    keys.zero->fail({.expected = "a direction other than that of the disc's axis"});
  const Vector3E normal = normalized(across), radial = normal.cross(axis);
  return distance * (cos(phase) * radial + sin(phase) * normal);
}

void check_eccentric_name(const SpecCursor& at, const std::string& name, const StudyBuilder& draft) {
  const auto& mechanism = draft.mechanism();
  if (study::find_by_name(mechanism.bodies, name) || study::find_by_name(mechanism.joints, name) ||
      study::find_by_name(mechanism.attachments, name))
    at.fail({.expected = "an eccentric disc with a name of its own: its shaft has it, too",
             .found = fmt::format("{}, which is also a body, a joint, a counterweight or a payload",
                                  quote_for_message(name))});
}

/// An eccentric disc is a counterweight on a massless shaft, which is geared to what the disc follows.
void read_eccentric_disc(const Member& member, StudyBuilder& draft) {
  DiscKeys keys;
  EccentricityKeys eccentric;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  std::vector<Field> fields = disc_fields(keys, draft);
  fields[2].need = Presence::required;
  fields[3].need = Presence::optional;
  fields.push_back({"eccentricity", Presence::required, store_in(eccentric.eccentricity)});
  fields.push_back({"phase", Presence::optional, store_in(eccentric.phase)});
  fields.push_back({"zero", Presence::optional, store_in(eccentric.zero)});
  const SpecCursor& at = member.value;
  if (!read_fields(at, "a disc {body, at, follows, ratio, mass, eccentricity, phase, inertia}", fields))
    throw CascadingError();
  check_eccentric_name(member.key, member.name, draft);
  model::DiscOf<Expression> disc;
  assemble_disc(at, keys, draft, disc);

  auto& mechanism = draft.mechanism();
  model::AttachmentOf<Expression> mass;
  mass.name = member.name;
  mass.body = static_cast<int>(mechanism.bodies.size());
  mass.mass = disc.mass, mass.inertia = disc.inertia;
  mass.position = read_eccentric_place(eccentric, disc.axis, draft);
  model::JointOf<Expression> shaft;
  shaft.name = member.name;
  shaft.first = disc.body, shaft.second = mass.body;
  shaft.point_first = disc.position;
  shaft.axis = disc.axis;
  model::CouplingOf<Expression> gear;
  gear.follower = static_cast<int>(mechanism.coordinates.size());
  gear.leader = disc.follows, gear.ratio = disc.ratio;
  mechanism.bodies.emplace_back().name = member.name;
  draft.body_places.push_back(member.key.node().place);
  mechanism.coordinates.push_back({member.name, static_cast<int>(mechanism.joints.size()), 0, CoordinateKind::angle});
  mechanism.joints.push_back(std::move(shaft));
  mechanism.couplings.push_back(std::move(gear));
  mechanism.attachments.push_back(std::move(mass));
}

}  // namespace

void read_attachments(const SpecCursor& section, StudyBuilder& draft, AttachmentKind kind) {
  for (const Member& member : list_named_members(section, "a mapping of masses {body, at, mass}")) {
    model::AttachmentOf<Expression> attachment;
    attachment.name = member.name;
    attachment.kind = kind;
    draft.problems.collect([&] { read_attachment(member.value, draft, attachment); });
    draft.mechanism().attachments.push_back(std::move(attachment));
  }
}

void read_discs(const SpecCursor& section, StudyBuilder& draft) {
  for (const Member& member :
       list_named_members(section, "a mapping of discs {body, at, follows, ratio, mass, inertia}")) {
    if (member.value.has_entry("eccentricity")) {
      draft.problems.collect([&] { read_eccentric_disc(member, draft); });
      continue;
    }
    model::DiscOf<Expression> disc;
    disc.name = member.name;
    draft.problems.collect([&] { read_disc(member.value, draft, disc); });
    draft.mechanism().discs.push_back(std::move(disc));
  }
}

namespace {

void read_points(const SpecCursor& section, StudyBuilder& draft, model::BodyOf<Expression>& body) {
  for (const Member& member : list_named_members(section, "a mapping of points"))
    draft.problems.collect([&] {
      body.points.push_back({member.name, read_vector(member.value, draft, dimension::length)});
    });
}

/// Names points that could not be read, so that references to them are not reported too.
void name_points(const SpecCursor& body_at, model::BodyOf<Expression>& body) {
  const YamlNode& node = body_at.node();
  for (std::size_t i = 0; node.kind == YamlNode::Kind::map && i < node.items.size(); ++i) {
    if (node.keys[i].text != "points" || node.items[i].kind != YamlNode::Kind::map) continue;
    for (const YamlNode& key : node.items[i].keys)
      if (std::none_of(body.points.begin(), body.points.end(), [&](const auto& p) { return p.name == key.text; }))
        body.points.push_back({key.text, Vector3E::Zero()});
  }
}

/// A body is massless if its mass is written as 0; com and inertia are then optional.
bool is_declared_massless(const SpecCursor& body_at) {
  if (!body_at.is_map()) return false;
  for (std::size_t i = 0; i < body_at.node().items.size(); ++i) {
    const YamlNode& value = body_at.node().items[i];
    if (body_at.node().keys[i].text == "mass" && value.kind == YamlNode::Kind::scalar)
      return value.text == "0" || value.text == "0.0";
  }
  return false;
}

bool has_as_given_inertia(const BodyKeys& body) { return body.inertia && body.inertia->has_entry("as_given"); }

void read_body_fields(const SpecCursor& at, StudyBuilder& draft, model::BodyOf<Expression>& body) {
  BodyKeys keys;
  const Presence presence = is_declared_massless(at) ? Presence::optional : Presence::required;
  const bool read =
      read_fields(at, "a body",
                  {{"mass", Presence::required,
                    [&](const SpecCursor& c) {
                      keys.mass = c;
                      body.mass = read_number(c, draft, dimension::mass, SignConstraint::positive_or_zero);
                    }},
                   {"com", presence, [&](const SpecCursor& c) { body.com = read_vector(c, draft, dimension::length); }},
                   {"inertia", presence, [&](const SpecCursor& c) { keys.inertia = c; }},
                   {"points", Presence::optional, [&](const SpecCursor& c) { read_points(c, draft, body); }}});
  // the inertia may be about the origin, so that mass and centre of mass come first
  if (keys.inertia)
    draft.problems.collect([&] {
      const bool reference_invalid =
          draft.problems.is_invalid(at.path() + ".mass") || draft.problems.is_invalid(at.path() + ".com");
      body.inertia_as_given = has_as_given_inertia(keys);
      body.inertia =
          read_inertia(*keys.inertia, draft, reference_invalid ? std::nullopt : std::optional(body.mass), body.com);
    });
  if (read) draft.body_texts.emplace(draft.mechanism().bodies.size(), std::move(keys));
  if (!read) name_points(at, body);
}

/// Whether anything besides the joint that carries it is attached to the body.
bool has_attached_elements(const MechanismOf<Expression>& mechanism, BodyId body) {
  const auto on = [body](const auto& element) { return element.body == body; };
  const auto ends = [body](const auto& element) { return element.first == body || element.second == body; };
  return std::count_if(mechanism.joints.begin(), mechanism.joints.end(), ends) > 1 ||
         std::any_of(mechanism.attachments.begin(), mechanism.attachments.end(), on) ||
         std::any_of(mechanism.discs.begin(), mechanism.discs.end(), on) ||
         std::any_of(mechanism.loads.begin(), mechanism.loads.end(), on) ||
         std::any_of(mechanism.springs.begin(), mechanism.springs.end(), ends) ||
         std::any_of(mechanism.force_elements.begin(), mechanism.force_elements.end(), ends) ||
         (mechanism.tool && mechanism.tool->body == body);
}

void check_positive_mass(const BodyKeys& keys, const model::BodyOf<Expression>& body) {
  if (keys.mass && !body.inertia_as_given && !model::is_valid_mass(body.mass.value(), values_of(body.inertia)))
    keys.mass->fail({.kind = "must be positive", .expected = "a number > 0", .found = "0"});
}

/// Mostly a mistake at the end of a chain.
void warn_of_zero_mass(const SpecCursor& mass, StudyBuilder& draft) {
  const NodeLocation place = mass.node().place;
  const SourceLocation location{draft.problems.file_of(place), place.line, place.column, mass.path()};
  draft.study.warnings.push_back(location.text() + ": the body has no mass and carries nothing");
}

/// `arm.hand` must be either a body or a point of one.
void check_name_prefix(const Member& body, const std::vector<Member>& bodies) {
  for (auto dot = body.name.find('.'); dot != std::string::npos; dot = body.name.find('.', dot + 1)) {
    const std::string prefix = body.name.substr(0, dot);
    if (prefix == "ground" ||
        std::any_of(bodies.begin(), bodies.end(), [&](const Member& m) { return m.name == prefix; }))
      body.key.fail({.expected = "a name that does not start with another body's name and '.'",
                     .found = fmt::format("{} and {}", quote_for_message(body.name), quote_for_message(prefix))});
  }
}

}  // namespace

void read_ground(const SpecCursor& section, StudyBuilder& draft) {
  model::BodyOf<Expression>& body = draft.mechanism().bodies[model::ground];
  if (!read_fields(section, "the ground",
                   {{"points", Presence::optional, [&](const SpecCursor& c) { read_points(c, draft, body); }}}))
    name_points(section, body);
}

void read_bodies(const SpecCursor& section, StudyBuilder& draft) {
  draft.problems.collect([&] {
    const auto members = list_named_members(section, "a mapping of bodies");
    if (members.empty()) section.fail_expected("at least one body");
    for (const Member& member : members) {
      model::BodyOf<Expression> body;
      body.name = member.name;
      draft.problems.collect([&] {
        if (member.name == "ground")
          member.key.fail({.expected = "a name other than 'ground', which is the body that does not move",
                           .hint = "define its points under 'ground:'"});
        check_name_prefix(member, members);
        read_body_fields(member.value, draft, body);
      });
      draft.mechanism().bodies.push_back(std::move(body));
      draft.body_places.push_back(member.key.node().place);
    }
  });
}

void check_massless_bodies(StudyBuilder& draft) {
  const auto& mechanism = draft.mechanism();
  const bool is_massless =
      !has_mass(model::convert_mechanism<double>(mechanism, [](const Expression& number) { return number.value(); }));
  if (is_massless && draft.problems.is_empty())
    draft.study.warnings.push_back("bodies: no body has mass, so forces, efforts and balance cannot be determined");
  for (const auto& [index, keys] : draft.body_texts) {
    const auto& body = mechanism.bodies[index];
    if (draft.problems.is_invalid("bodies." + body.name) || draft.problems.is_section_invalid("joints.another"))
      continue;
    draft.problems.collect([&, &keys = keys] { check_positive_mass(keys, body); });
    const bool carries_nothing = body.mass.value() == 0 && !has_attached_elements(mechanism, static_cast<int>(index));
    if (keys.mass && carries_nothing && !is_massless) warn_of_zero_mass(*keys.mass, draft);
  }
}

namespace {

/// Steiner's theorem from the origin to the centre of mass.
Matrix3E shift_to_com(const Matrix3E& about_origin, const Expression& mass, const Vector3E& com, bool planar) {
  const auto moment = [&](int i, int j) { return mass * com[i] * com[j]; };
  Matrix3E inertia = about_origin;
  for (int i = planar ? 2 : 0; i < 3; ++i)
    inertia(i, i) -= moment((i + 1) % 3, (i + 1) % 3) + moment((i + 2) % 3, (i + 2) % 3);
  for (int i = 0; i < 3 && !planar; ++i)
    for (int j = 0; j < 3; ++j)
      if (i != j) inertia(i, j) += moment(j, i);
  return inertia;
}

}  // namespace

Matrix3E read_inertia_value(const SpecCursor& at, StudyBuilder& draft) {
  Matrix3E inertia = Matrix3E::Zero();
  if (draft.planar()) {
    inertia(2, 2) = read_number(at, draft, dimension::inertia);
    return inertia;
  }
  const std::string what = "[Ixx, Iyy, Izz] or [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]";
  if (at.is_list() && at.node().items.size() != 3 && at.node().items.size() != 6) at.fail_expected(what);
  const auto v = read_numbers(at, draft, dimension::inertia, what);
  for (int i = 0; i < 3; ++i) inertia(i, i) = v[static_cast<std::size_t>(i)];
  if (v.size() == 6) {
    inertia(0, 1) = inertia(1, 0) = v[3];
    inertia(0, 2) = inertia(2, 0) = v[4];
    inertia(1, 2) = inertia(2, 1) = v[5];
  }
  return inertia;
}

namespace {

/// Keys of `{about: …, value: …}`; `as_given` instead of `value`.
struct InertiaKeys {
  bool about_origin = false;
  bool as_given = false;
  Matrix3E value = Matrix3E::Zero();
};

InertiaKeys read_inertia_text(const SpecCursor& at, StudyBuilder& draft) {
  // A mapping with `free` is a free number, not a choice of the reference point.
  const bool is_free =
      at.is_map() && !at.node().keys.empty() && (at.node().keys[0].text == "free" || at.node().keys[0].text == "start");
  InertiaKeys inertia;
  if (!at.is_map() || is_free) {
    inertia.value = read_inertia_value(at, draft);
    return inertia;
  }
  inertia.as_given = at.has_entry("as_given");
  const char* name = inertia.as_given ? "as_given" : "value";
  const bool read = read_fields(
      at, "an inertia",
      {{"about", inertia.as_given ? Presence::optional : Presence::required,
        [&](const SpecCursor& c) {
          inertia.about_origin = c.read_choice("the point that the inertia is about", {"com", "origin"}) == 1;
        }},
       {name, Presence::required, [&](const SpecCursor& c) { inertia.value = read_inertia_value(c, draft); }}});
  if (!read) throw CascadingError();
  return inertia;
}

/// Warns of what would be a mistake without `as_given`.
void warn_of_inertia(const SpecCursor& at, const Matrix3E& inertia, StudyBuilder& draft) {
  try {
    check_inertia(at, inertia, draft, model::InertiaOwner::body);
  } catch (const ReadError& error) {
    const SourceLocation place{draft.problems.file_of(error.place), error.place.line, error.place.column, error.path};
    draft.study.warnings.push_back(place.text() + ": kept as given: " + error.message.text());
  }
}

}  // namespace

Matrix3E read_inertia(const SpecCursor& at, StudyBuilder& draft, const std::optional<Expression>& mass,
                      const Vector3E& com) {
  const InertiaKeys keys = read_inertia_text(at, draft);
  if (keys.about_origin && !mass) return keys.value;
  const Matrix3E inertia = keys.about_origin ? shift_to_com(keys.value, *mass, com, draft.planar()) : keys.value;
  if (keys.as_given)
    warn_of_inertia(at, inertia, draft);
  else
    check_inertia(at, inertia, draft, model::InertiaOwner::body);
  return inertia;
}

void check_inertia(const SpecCursor& at, const Matrix3E& inertia, const StudyBuilder& draft,
                   model::InertiaOwner owner) {
  const bool planar = draft.planar();
  const model::InertiaCheck check = find_inertia_issue(values_of(inertia), planar, owner);
  if (check.issue == model::InertiaIssue::none) return;
  const Vector3& principal = check.principal_moments;
  const char* expected = check.issue == model::InertiaIssue::triangle_violated
                             ? "no principal moment above the sum of the other two"
                         : !planar                            ? "a positive definite matrix"
                         : owner == model::InertiaOwner::body ? "a positive one about its CoM"
                                                              : "one that is not negative about its CoM";
  at.fail({.kind = "no body can have this inertia",
           .expected = expected,
           .found = planar ? fmt::format("{:.6g} kg m^2", principal[2])
                           : fmt::format("the principal moments {:.6g}, {:.6g}, {:.6g} kg m^2 about its CoM",
                                         principal[0], principal[1], principal[2])});
}

}  // namespace balance::specification
