#include "balance/base/nearest.hpp"
#include "balance/model/conversion.hpp"
#include "balance/model/validate.hpp"
#include "balance/spec/directions.hpp"
#include "balance/spec/inertia.hpp"
#include "balance/spec/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace balance::read {

namespace {

void read_points(const Cursor& section, Draft& draft, BodyOf<Expression>& body) {
  for (const Member& member : named_members(section, "a mapping of points"))
    draft.problems.guard([&] {
      body.points.push_back({member.name, read_vector(member.value, draft, dimension::length)});
    });
}

/// A point that cannot be read still has a name, so that references to it are not reported too.
void name_points(const Cursor& body_at, BodyOf<Expression>& body) {
  const Node& node = body_at.node();
  for (std::size_t i = 0; node.kind == Node::Kind::map && i < node.items.size(); ++i) {
    if (node.keys[i].text != "points" || node.items[i].kind != Node::Kind::map) continue;
    for (const Node& key : node.items[i].keys)
      if (std::none_of(body.points.begin(), body.points.end(), [&](const auto& p) { return p.name == key.text; }))
        body.points.push_back({key.text, Vector3E::Zero()});
  }
}

/// A body is massless where its mass says 0; then com and inertia may be left out.
bool says_massless(const Cursor& body_at) {
  if (!body_at.is_map()) return false;
  for (std::size_t i = 0; i < body_at.node().items.size(); ++i) {
    const Node& value = body_at.node().items[i];
    if (body_at.node().keys[i].text == "mass" && value.kind == Node::Kind::scalar)
      return value.text == "0" || value.text == "0.0";
  }
  return false;
}

bool says_as_given(const BodyText& text) {
  if (!text.inertia || !text.inertia->is_map()) return false;
  const auto& keys = text.inertia->node().keys;
  return std::any_of(keys.begin(), keys.end(), [](const Node& key) { return key.text == "as_given"; });
}

void read_body_fields(const Cursor& at, Draft& draft, BodyOf<Expression>& body) {
  BodyText text;
  const Need need = says_massless(at) ? Need::optional : Need::required;
  const bool read =
      read_fields(at, "a body",
                  {{"mass", Need::required,
                    [&](const Cursor& c) {
                      text.mass = c;
                      body.mass = read_number(c, draft, dimension::mass, Sign::positive_or_zero);
                    }},
                   {"com", need, [&](const Cursor& c) { body.com = read_vector(c, draft, dimension::length); }},
                   {"inertia", need, [&](const Cursor& c) { text.inertia = c; }},
                   {"points", Need::optional, [&](const Cursor& c) { read_points(c, draft, body); }}});
  // The inertia may be about the origin: mass and centre of mass come first.
  if (text.inertia)
    draft.problems.guard([&] {
      const bool moved = draft.problems.spoilt(at.path() + ".mass") || draft.problems.spoilt(at.path() + ".com");
      body.inertia_as_given = says_as_given(text);
      body.inertia = read_inertia(*text.inertia, draft, moved ? std::nullopt : std::optional(body.mass), body.com);
    });
  if (read) draft.body_texts.emplace(draft.mechanism().bodies.size(), std::move(text));
  if (!read) name_points(at, body);
}

/// Something besides the joint that it hangs on needs the body.
bool carries_something(const MechanismOf<Expression>& mechanism, BodyId body) {
  const auto on = [body](const auto& part) { return part.body == body; };
  const auto ends = [body](const auto& part) { return part.first == body || part.second == body; };
  return std::count_if(mechanism.joints.begin(), mechanism.joints.end(), ends) > 1 ||
         std::any_of(mechanism.attachments.begin(), mechanism.attachments.end(), on) ||
         std::any_of(mechanism.discs.begin(), mechanism.discs.end(), on) ||
         std::any_of(mechanism.loads.begin(), mechanism.loads.end(), on) ||
         std::any_of(mechanism.springs.begin(), mechanism.springs.end(), ends) ||
         (mechanism.tool && mechanism.tool->body == body);
}

void check_mass(const BodyText& text, const BodyOf<Expression>& body) {
  if (text.mass && !body.inertia_as_given && !can_weigh(body.mass.value(), values_of(body.inertia)))
    text.mass->fail({.kind = "must be positive", .expected = "a number > 0", .found = "0"});
}

/// Not what anybody meant at the end of a chain, mostly.
void warn_of_nothing(const Cursor& mass, Draft& draft) {
  const Place place = mass.node().place;
  const SpecPlace said{draft.problems.file_of(place), place.line, place.column, mass.path()};
  draft.study.warnings.push_back(said.text() + ": the body has no mass, and it carries nothing");
}

/// `arm.hand` must be either a body or a point of one.
void check_beginning(const Member& body, const std::vector<Member>& all) {
  for (auto dot = body.name.find('.'); dot != std::string::npos; dot = body.name.find('.', dot + 1)) {
    const std::string beginning = body.name.substr(0, dot);
    if (beginning == "ground" ||
        std::any_of(all.begin(), all.end(), [&](const Member& m) { return m.name == beginning; }))
      body.key.fail({.expected = "a name that does not begin with another body's and a point",
                     .found = fmt::format("{} and {}", in_quotes(body.name), in_quotes(beginning))});
  }
}

}  // namespace

void read_ground(const Cursor& section, Draft& draft) {
  BodyOf<Expression>& body = draft.mechanism().bodies[ground];
  if (!read_fields(section, "the ground",
                   {{"points", Need::optional, [&](const Cursor& c) { read_points(c, draft, body); }}}))
    name_points(section, body);
}

void read_bodies(const Cursor& section, Draft& draft) {
  draft.problems.guard([&] {
    const auto all = named_members(section, "a mapping of bodies");
    if (all.empty()) section.expected("at least one body");
    for (const Member& member : all) {
      BodyOf<Expression> body;
      body.name = member.name;
      draft.problems.guard([&] {
        if (member.name == "ground")
          member.key.fail({.expected = "a name other than 'ground', which is the body that does not move",
                           .hint = "its points go into 'ground:'"});
        check_beginning(member, all);
        read_body_fields(member.value, draft, body);
      });
      draft.mechanism().bodies.push_back(std::move(body));
      draft.body_places.push_back(member.key.node().place);
    }
  });
}

void check_light_bodies(Draft& draft) {
  const auto& mechanism = draft.mechanism();
  const bool weightless =
      !has_mass(converted<double>(mechanism, [](const Expression& number) { return number.value(); }));
  if (weightless && draft.problems.none())
    draft.study.warnings.push_back("bodies: no body has mass, so nothing can be said of forces, efforts and balance");
  for (const auto& [index, text] : draft.body_texts) {
    const auto& body = mechanism.bodies[index];
    if (draft.problems.spoilt("bodies." + body.name) || draft.problems.lost("joints.another")) continue;
    draft.problems.guard([&, &where = text] { check_mass(where, body); });
    const bool nothing = body.mass.value() == 0 && !carries_something(mechanism, static_cast<int>(index));
    if (text.mass && nothing && !weightless) warn_of_nothing(*text.mass, draft);
  }
}

}  // namespace balance::read
