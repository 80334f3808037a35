// What bodies carry: counterweights, payloads, discs.

#include "balance/base/nearest.hpp"
#include "balance/spec/inertia.hpp"
#include "balance/spec/passing_payloads.hpp"
#include "balance/spec/sections.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace balance::read {

namespace {

/// The keys that everything carried has.
struct Carried {
  std::optional<BodyId> body;
  std::optional<Cursor> at, mass, inertia;
};

int read_carrier(const Cursor& at, const Draft& draft) {
  const BodyId body = read_body(at, draft);
  if (body == ground) at.fail({.expected = "a moving body", .found = "the ground"});
  return body;
}

std::vector<Field> carried_fields(Carried& carried, Draft& draft) {
  return {{"body", Need::required, [&](const Cursor& c) { carried.body = read_carrier(c, draft); }, "on"},
          {"at", Need::required, [&](const Cursor& c) { carried.at = c; }},
          {"mass", Need::required, [&](const Cursor& c) { carried.mass = c; }},
          {"inertia", Need::optional, [&](const Cursor& c) { carried.inertia = c; }}};
}

void read_attachment(const Cursor& at, Draft& draft, AttachmentOf<Expression>& attachment) {
  Carried carried;
  PresenceText presence;
  std::vector<Field> fields = carried_fields(carried, draft);
  for (Field& field : presence_fields(at, attachment.kind, presence)) fields.push_back(std::move(field));
  read_fields(at, "a mass {body, at, mass}", fields);
  read_presence(presence, draft, attachment);
  attachment.body = carried.body.value_or(ground);
  if (carried.at) draft.problems.guard([&] { attachment.position = read_place(*carried.at, draft, carried.body); });
  if (carried.mass)
    draft.problems.guard(
        [&] { attachment.mass = read_number(*carried.mass, draft, dimension::mass, Sign::not_negative); });
  if (!carried.inertia) return;
  draft.problems.guard([&] {
    attachment.inertia = read_inertia_value(*carried.inertia, draft);
    check_inertia(*carried.inertia, attachment.inertia, draft, InertiaOf::attachment);
  });
}

/// What a disc's mapping says, before its parts are put together.
struct DiscText {
  Carried carried;
  std::optional<FollowedOf<Expression>> follows;
  std::optional<Cursor> ratio, axis;
};

/// The direction of the followed joint's axis in the carrier's axes; it must stand still in the carrier.
Vector3E followed_axis(const Cursor& at, const Draft& draft, const DiscText& text, const DiscOf<Expression>& disc) {
  if (!text.carried.body || !text.follows) throw Consequence();
  const auto& mechanism = draft.mechanism();
  if (disc.follows.terms.size() > 1)
    at.fail({.kind = "missing key",
             .expected = "'axis', the direction about which the disc turns in its carrier, because it follows several "
                         "coordinates"});
  const Coordinate& coordinate = mechanism.coordinates[static_cast<std::size_t>(disc.follows.terms[0].coordinate)];
  const auto& joint = mechanism.joints[static_cast<std::size_t>(coordinate.joint)];
  if (draft.problems.spoilt("joints." + joint.name)) throw Consequence();
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
                                     in_quotes(mechanism.bodies[static_cast<std::size_t>(disc.body)].name),
                                     in_quotes(coordinate.name))});
  const Vector3E axis = universal && coordinate.index == 1 ? joint.axis2 : joint.axis;
  return on_first ? axis : Vector3E(joint.rotation.transpose() * axis);
}

/// A number (planar); {axial, transverse}, three or six numbers (spatial).
Matrix3E read_disc_inertia(const Cursor& at, Draft& draft, const Vector3E& axis) {
  if (draft.planar() || at.is_list()) return read_inertia_value(at, draft);
  Expression axial = 0, transverse = 0;
  const bool read = read_fields(
      at, "an inertia {axial, transverse}, [Ixx, Iyy, Izz] or six numbers",
      {{"axial", Need::required, [&](const Cursor& c) { axial = read_number(c, draft, dimension::inertia); }},
       {"transverse", Need::required,
        [&](const Cursor& c) { transverse = read_number(c, draft, dimension::inertia); }}});
  if (!read) return Matrix3E::Zero();
  const Matrix3E along = axis * axis.transpose(), identity = Matrix3E::Identity();
  return transverse * identity + (axial - transverse) * along;
}

/// @param sum whether what is followed has ratios of its own
Expression read_disc_ratio(const Cursor& at, Draft& draft, const DiscOf<Expression>& disc, bool sum) {
  const auto followed = static_cast<std::size_t>(disc.follows.terms[0].coordinate);
  const Dimension own =
      sum ? dimension::none : dimension::angle / dimension_of(draft.mechanism().coordinates[followed].kind);
  const Expression ratio = read_number(at, draft, own);
  if (is_stuck_at_zero(at, ratio, draft))
    at.fail({.expected = "a ratio other than 0 (a disc that does not turn is a counterweight)", .found = "0"});
  return ratio;
}

void put_disc_together(const Cursor& at, const DiscText& text, Draft& draft, DiscOf<Expression>& disc) {
  const Carried& carried = text.carried;
  const auto guard = [&](auto&& read) { return draft.problems.guard(read); };
  disc.body = carried.body.value_or(ground);
  disc.follows = text.follows.value_or(0);
  if (carried.at) guard([&] { disc.position = read_place(*carried.at, draft, carried.body); });
  if (text.ratio)
    guard([&] {
      if (text.follows)
        disc.ratio = read_disc_ratio(*text.ratio, draft, disc, follows_several(at));
      else
        read_number(*text.ratio, draft, dimension::none);
    });
  const bool axis_read = guard([&] {
    if (text.axis && draft.planar()) text.axis->fail({.expected = "no axis: a disc in the plane turns about z"});
    if (text.axis)
      disc.axis = read_direction(*text.axis, draft);
    else if (!draft.planar())
      disc.axis = followed_axis(at, draft, text, disc);
  });
  if (carried.mass) guard([&] { disc.mass = read_number(*carried.mass, draft, dimension::mass, Sign::not_negative); });
  if (carried.inertia)
    guard([&] {
      disc.inertia = read_disc_inertia(*carried.inertia, draft, disc.axis);
      if (axis_read) check_inertia(*carried.inertia, disc.inertia, draft, InertiaOf::attachment);
    });
}

void read_disc(const Cursor& at, Draft& draft, DiscOf<Expression>& disc) {
  DiscText text;
  auto fields = carried_fields(text.carried, draft);
  fields[0].read = [&](const Cursor& c) { text.carried.body = read_body(c, draft); };  // the base carries discs, too
  fields[2].need = Need::optional;
  fields[3].need = Need::required;
  fields.push_back(
      {"follows", Need::required, [&](const Cursor& c) { text.follows = read_followed(c, draft, dimension::angle); }});
  fields.push_back({"ratio", Need::optional, [&](const Cursor& c) { text.ratio = c; }});
  fields.push_back({"axis", Need::optional, [&](const Cursor& c) { text.axis = c; }});
  read_fields(at, "a disc {body, at, follows, ratio, mass, inertia}", fields);
  if (at.is_map()) put_disc_together(at, text, draft, disc);
}

}  // namespace

void read_attachments(const Cursor& section, Draft& draft, AttachmentKind kind) {
  for (const Member& member : named_members(section, "a mapping of masses {body, at, mass}")) {
    AttachmentOf<Expression> attachment;
    attachment.name = member.name;
    attachment.kind = kind;
    draft.problems.guard([&] { read_attachment(member.value, draft, attachment); });
    draft.mechanism().attachments.push_back(std::move(attachment));
  }
}

void read_discs(const Cursor& section, Draft& draft) {
  for (const Member& member : named_members(section, "a mapping of discs {body, at, follows, ratio, mass, inertia}")) {
    DiscOf<Expression> disc;
    disc.name = member.name;
    draft.problems.guard([&] { read_disc(member.value, draft, disc); });
    draft.mechanism().discs.push_back(std::move(disc));
  }
}

}  // namespace balance::read
