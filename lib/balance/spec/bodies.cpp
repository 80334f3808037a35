#include "balance/base/nearest.hpp"
#include "balance/spec/inertia.hpp"
#include "balance/spec/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace balance::read {

namespace {

void read_points(const Cursor& section, Draft& draft, Body& body) {
  for (const Member& member : named_members(section, "a mapping of points"))
    draft.problems.guard([&] {
      body.points.push_back({member.name, read_vector(member.value, draft, dimension::length)});
    });
}

/// A point that cannot be read still has a name, so that references to it are not reported too.
void name_points(const Cursor& body_at, Body& body) {
  const Node& node = body_at.node();
  for (std::size_t i = 0; node.kind == Node::Kind::map && i < node.items.size(); ++i) {
    if (node.keys[i].text != "points" || node.items[i].kind != Node::Kind::map) continue;
    for (const Node& key : node.items[i].keys)
      if (std::none_of(body.points.begin(), body.points.end(), [&](const NamedPoint& p) { return p.name == key.text; }))
        body.points.push_back({key.text, Vector3::Zero()});
  }
}

void read_body_fields(const Cursor& at, Draft& draft, Body& body) {
  std::optional<Cursor> inertia;
  const bool read = read_fields(
      at, "a body",
      {{"mass", Need::required,
        [&](const Cursor& c) { body.mass = read_number(c, draft, dimension::mass, Sign::positive); }},
       {"com", Need::required, [&](const Cursor& c) { body.com = read_vector(c, draft, dimension::length); }},
       {"inertia", Need::required, [&](const Cursor& c) { inertia = c; }},
       {"points", Need::optional, [&](const Cursor& c) { read_points(c, draft, body); }}});
  // The inertia may be about the origin: mass and centre of mass come first.
  if (inertia)
    draft.problems.guard([&] {
      const bool moved = draft.problems.spoilt(at.path() + ".mass") || draft.problems.spoilt(at.path() + ".com");
      body.inertia =
          read_inertia(*inertia, draft, Bearer::body, moved ? std::nullopt : std::optional(body.mass), body.com);
    });
  if (!read) name_points(at, body);
}

}  // namespace

void read_ground(const Cursor& section, Draft& draft) {
  Body& body = draft.mechanism().bodies[ground];
  if (!read_fields(section, "the ground",
                   {{"points", Need::optional, [&](const Cursor& c) { read_points(c, draft, body); }}}))
    name_points(section, body);
}

void read_bodies(const Cursor& section, Draft& draft) {
  draft.problems.guard([&] {
    const auto all = named_members(section, "a mapping of bodies");
    if (all.empty()) section.expected("at least one body");
    for (const Member& member : all) {
      Body body;
      body.name = member.name;
      draft.problems.guard([&] {
        if (member.name == "ground")
          member.key.fail({.expected = "a name other than 'ground', which is the body that does not move",
                           .hint = "its points go into 'ground:'"});
        read_body_fields(member.value, draft, body);
      });
      draft.mechanism().bodies.push_back(std::move(body));
      draft.body_places.push_back(member.key.node().place);
    }
  });
}

}  // namespace balance::read
