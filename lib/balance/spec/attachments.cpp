// What bodies carry: counterweights, payloads, discs.

#include "balance/base/nearest.hpp"
#include "balance/spec/inertia.hpp"
#include "balance/spec/passing_payloads.hpp"
#include "balance/spec/sections.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace balance::specification {

namespace {

/// The keys that everything carried has.
struct AttachedKeys {
  std::optional<BodyId> body;
  std::optional<SpecCursor> at, mass, inertia;
};

int read_carrier(const SpecCursor& at, const StudyBuilder& draft) {
  const BodyId body = read_body(at, draft);
  if (body == ground) at.fail({.expected = "a moving body", .found = "the ground"});
  return body;
}

std::vector<Field> attached_fields(AttachedKeys& carried, StudyBuilder& draft) {
  return {{"body", Presence::required, [&](const SpecCursor& c) { carried.body = read_carrier(c, draft); }, "on"},
          {"at", Presence::required, [&](const SpecCursor& c) { carried.at = c; }},
          {"mass", Presence::required, [&](const SpecCursor& c) { carried.mass = c; }},
          {"inertia", Presence::optional, [&](const SpecCursor& c) { carried.inertia = c; }}};
}

void read_attachment(const SpecCursor& at, StudyBuilder& draft, AttachmentOf<Expression>& attachment) {
  AttachedKeys carried;
  PresenceKeys presence;
  std::vector<Field> fields = attached_fields(carried, draft);
  for (Field& field : presence_fields(at, attachment.kind, presence)) fields.push_back(std::move(field));
  read_fields(at, "a mass {body, at, mass}", fields);
  read_presence(presence, draft, attachment);
  attachment.body = carried.body.value_or(ground);
  if (carried.at)
    draft.problems.collect([&] { attachment.position = read_position(*carried.at, draft, carried.body); });
  if (carried.mass)
    draft.problems.collect(
        [&] { attachment.mass = read_number(*carried.mass, draft, dimension::mass, SignConstraint::not_negative); });
  if (!carried.inertia) return;
  draft.problems.collect([&] {
    attachment.inertia = read_inertia_value(*carried.inertia, draft);
    check_inertia(*carried.inertia, attachment.inertia, draft, InertiaOwner::attachment);
  });
}

/// What a disc's mapping says, before its parts are put together.
struct DiscKeys {
  AttachedKeys carried;
  std::optional<CoordinateCombinationOf<Expression>> follows;
  std::optional<SpecCursor> ratio, axis;
};

/// The direction of the followed joint's axis in the carrier's axes; it must stand still in the carrier.
Vector3E followed_axis(const SpecCursor& at, const StudyBuilder& draft, const DiscKeys& text,
                       const DiscOf<Expression>& disc) {
  if (!text.carried.body || !text.follows) throw CascadingError();
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
  // Turning by the first coordinate leaves the first axis in the first body, by the second the second axis in the second body.
  const bool own_axis =
      joint.type != JointType::spherical && (!universal || (coordinate.index == 0 ? on_first : on_second));
  if ((!on_first && !on_second) || !own_axis)
    at.fail({.kind = "missing key",
             .expected = fmt::format("'axis', the direction about which the disc turns in {}, because the axis of {} "
                                     "does not stand still there",
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
  const Matrix3E along = axis * axis.transpose(), identity = Matrix3E::Identity();
  return transverse * identity + (axial - transverse) * along;
}

/// @param sum whether what is followed has ratios of its own
Expression read_disc_ratio(const SpecCursor& at, StudyBuilder& draft, const DiscOf<Expression>& disc, bool sum) {
  const auto followed = static_cast<std::size_t>(disc.follows.terms[0].coordinate);
  const Dimension own =
      sum ? dimension::dimensionless : dimension::angle / dimension_of(draft.mechanism().coordinates[followed].kind);
  const Expression ratio = read_number(at, draft, own);
  if (is_fixed_zero(at, ratio, draft))
    at.fail({.expected = "a ratio other than 0 (a disc that does not turn is a counterweight)", .found = "0"});
  return ratio;
}

void assemble_disc(const SpecCursor& at, const DiscKeys& text, StudyBuilder& draft, DiscOf<Expression>& disc) {
  const AttachedKeys& carried = text.carried;
  const auto guard = [&](auto&& read) { return draft.problems.collect(read); };
  disc.body = carried.body.value_or(ground);
  disc.follows = text.follows.value_or(0);
  if (carried.at) guard([&] { disc.position = read_position(*carried.at, draft, carried.body); });
  if (text.ratio)
    guard([&] {
      if (text.follows)
        disc.ratio = read_disc_ratio(*text.ratio, draft, disc, has_several_leaders(at));
      else
        read_number(*text.ratio, draft, dimension::dimensionless);
    });
  const bool axis_read = guard([&] {
    if (text.axis && draft.planar()) text.axis->fail({.expected = "no axis: a disc in the plane turns about z"});
    if (text.axis)
      disc.axis = read_direction(*text.axis, draft);
    else if (!draft.planar())
      disc.axis = followed_axis(at, draft, text, disc);
  });
  if (carried.mass)
    guard([&] { disc.mass = read_number(*carried.mass, draft, dimension::mass, SignConstraint::not_negative); });
  if (carried.inertia)
    guard([&] {
      disc.inertia = read_disc_inertia(*carried.inertia, draft, disc.axis);
      if (axis_read) check_inertia(*carried.inertia, disc.inertia, draft, InertiaOwner::attachment);
    });
}

void read_disc(const SpecCursor& at, StudyBuilder& draft, DiscOf<Expression>& disc) {
  DiscKeys text;
  auto fields = attached_fields(text.carried, draft);
  fields[0].read = [&](const SpecCursor& c) {
    text.carried.body = read_body(c, draft);
  };  // the base carries discs, too
  fields[2].need = Presence::optional;
  fields[3].need = Presence::required;
  fields.push_back({"follows", Presence::required,
                    [&](const SpecCursor& c) { text.follows = read_followed(c, draft, dimension::angle); }});
  fields.push_back({"ratio", Presence::optional, [&](const SpecCursor& c) { text.ratio = c; }});
  fields.push_back({"axis", Presence::optional, [&](const SpecCursor& c) { text.axis = c; }});
  read_fields(at, "a disc {body, at, follows, ratio, mass, inertia}", fields);
  if (at.is_map()) assemble_disc(at, text, draft, disc);
}

}  // namespace

void read_attachments(const SpecCursor& section, StudyBuilder& draft, AttachmentKind kind) {
  for (const Member& member : list_named_members(section, "a mapping of masses {body, at, mass}")) {
    AttachmentOf<Expression> attachment;
    attachment.name = member.name;
    attachment.kind = kind;
    draft.problems.collect([&] { read_attachment(member.value, draft, attachment); });
    draft.mechanism().attachments.push_back(std::move(attachment));
  }
}

void read_discs(const SpecCursor& section, StudyBuilder& draft) {
  for (const Member& member :
       list_named_members(section, "a mapping of discs {body, at, follows, ratio, mass, inertia}")) {
    DiscOf<Expression> disc;
    disc.name = member.name;
    draft.problems.collect([&] { read_disc(member.value, draft, disc); });
    draft.mechanism().discs.push_back(std::move(disc));
  }
}

}  // namespace balance::specification
