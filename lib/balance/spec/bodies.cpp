#include "balance/base/nearest.hpp"
#include "balance/model/conversion.hpp"
#include "balance/model/validate.hpp"
#include "balance/spec/directions.hpp"
#include "balance/spec/inertia.hpp"
#include "balance/spec/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace balance::specification {

namespace {

void read_points(const SpecCursor& section, StudyBuilder& draft, BodyOf<Expression>& body) {
  for (const Member& member : list_named_members(section, "a mapping of points"))
    draft.problems.collect([&] {
      body.points.push_back({member.name, read_vector(member.value, draft, dimension::length)});
    });
}

/// A point that cannot be read still has a name, so that references to it are not reported too.
void name_points(const SpecCursor& body_at, BodyOf<Expression>& body) {
  const YamlNode& node = body_at.node();
  for (std::size_t i = 0; node.kind == YamlNode::Kind::map && i < node.items.size(); ++i) {
    if (node.keys[i].text != "points" || node.items[i].kind != YamlNode::Kind::map) continue;
    for (const YamlNode& key : node.items[i].keys)
      if (std::none_of(body.points.begin(), body.points.end(), [&](const auto& p) { return p.name == key.text; }))
        body.points.push_back({key.text, Vector3E::Zero()});
  }
}

/// A body is massless where its mass says 0; then com and inertia may be left out.
bool is_declared_massless(const SpecCursor& body_at) {
  if (!body_at.is_map()) return false;
  for (std::size_t i = 0; i < body_at.node().items.size(); ++i) {
    const YamlNode& value = body_at.node().items[i];
    if (body_at.node().keys[i].text == "mass" && value.kind == YamlNode::Kind::scalar)
      return value.text == "0" || value.text == "0.0";
  }
  return false;
}

bool has_as_given_inertia(const BodyKeys& text) {
  if (!text.inertia || !text.inertia->is_map()) return false;
  const auto& keys = text.inertia->node().keys;
  return std::any_of(keys.begin(), keys.end(), [](const YamlNode& key) { return key.text == "as_given"; });
}

void read_body_fields(const SpecCursor& at, StudyBuilder& draft, BodyOf<Expression>& body) {
  BodyKeys text;
  const Presence need = is_declared_massless(at) ? Presence::optional : Presence::required;
  const bool read =
      read_fields(at, "a body",
                  {{"mass", Presence::required,
                    [&](const SpecCursor& c) {
                      text.mass = c;
                      body.mass = read_number(c, draft, dimension::mass, SignConstraint::positive_or_zero);
                    }},
                   {"com", need, [&](const SpecCursor& c) { body.com = read_vector(c, draft, dimension::length); }},
                   {"inertia", need, [&](const SpecCursor& c) { text.inertia = c; }},
                   {"points", Presence::optional, [&](const SpecCursor& c) { read_points(c, draft, body); }}});
  // The inertia may be about the origin: mass and centre of mass come first.
  if (text.inertia)
    draft.problems.collect([&] {
      const bool moved =
          draft.problems.is_invalid(at.path() + ".mass") || draft.problems.is_invalid(at.path() + ".com");
      body.inertia_as_given = has_as_given_inertia(text);
      body.inertia = read_inertia(*text.inertia, draft, moved ? std::nullopt : std::optional(body.mass), body.com);
    });
  if (read) draft.body_texts.emplace(draft.mechanism().bodies.size(), std::move(text));
  if (!read) name_points(at, body);
}

/// Something besides the joint that it hangs on needs the body.
bool has_attached_elements(const MechanismOf<Expression>& mechanism, BodyId body) {
  const auto on = [body](const auto& part) { return part.body == body; };
  const auto ends = [body](const auto& part) { return part.first == body || part.second == body; };
  return std::count_if(mechanism.joints.begin(), mechanism.joints.end(), ends) > 1 ||
         std::any_of(mechanism.attachments.begin(), mechanism.attachments.end(), on) ||
         std::any_of(mechanism.discs.begin(), mechanism.discs.end(), on) ||
         std::any_of(mechanism.loads.begin(), mechanism.loads.end(), on) ||
         std::any_of(mechanism.springs.begin(), mechanism.springs.end(), ends) ||
         (mechanism.tool && mechanism.tool->body == body);
}

void check_positive_mass(const BodyKeys& text, const BodyOf<Expression>& body) {
  if (text.mass && !body.inertia_as_given && !is_valid_mass(body.mass.value(), values_of(body.inertia)))
    text.mass->fail({.kind = "must be positive", .expected = "a number > 0", .found = "0"});
}

/// Not what anybody meant at the end of a chain, mostly.
void warn_of_zero_mass(const SpecCursor& mass, StudyBuilder& draft) {
  const NodeLocation place = mass.node().place;
  const SourceLocation said{draft.problems.file_of(place), place.line, place.column, mass.path()};
  draft.study.warnings.push_back(said.text() + ": the body has no mass, and it carries nothing");
}

/// `arm.hand` must be either a body or a point of one.
void check_name_prefix(const Member& body, const std::vector<Member>& all) {
  for (auto dot = body.name.find('.'); dot != std::string::npos; dot = body.name.find('.', dot + 1)) {
    const std::string beginning = body.name.substr(0, dot);
    if (beginning == "ground" ||
        std::any_of(all.begin(), all.end(), [&](const Member& m) { return m.name == beginning; }))
      body.key.fail({.expected = "a name that does not begin with another body's and a point",
                     .found = fmt::format("{} and {}", quote_for_message(body.name), quote_for_message(beginning))});
  }
}

}  // namespace

void read_ground(const SpecCursor& section, StudyBuilder& draft) {
  BodyOf<Expression>& body = draft.mechanism().bodies[ground];
  if (!read_fields(section, "the ground",
                   {{"points", Presence::optional, [&](const SpecCursor& c) { read_points(c, draft, body); }}}))
    name_points(section, body);
}

void read_bodies(const SpecCursor& section, StudyBuilder& draft) {
  draft.problems.collect([&] {
    const auto all = list_named_members(section, "a mapping of bodies");
    if (all.empty()) section.fail_expected("at least one body");
    for (const Member& member : all) {
      BodyOf<Expression> body;
      body.name = member.name;
      draft.problems.collect([&] {
        if (member.name == "ground")
          member.key.fail({.expected = "a name other than 'ground', which is the body that does not move",
                           .hint = "its points go into 'ground:'"});
        check_name_prefix(member, all);
        read_body_fields(member.value, draft, body);
      });
      draft.mechanism().bodies.push_back(std::move(body));
      draft.body_places.push_back(member.key.node().place);
    }
  });
}

void check_massless_bodies(StudyBuilder& draft) {
  const auto& mechanism = draft.mechanism();
  const bool weightless =
      !has_mass(convert_mechanism<double>(mechanism, [](const Expression& number) { return number.value(); }));
  if (weightless && draft.problems.is_empty())
    draft.study.warnings.push_back("bodies: no body has mass, so nothing can be said of forces, efforts and balance");
  for (const auto& [index, text] : draft.body_texts) {
    const auto& body = mechanism.bodies[index];
    if (draft.problems.is_invalid("bodies." + body.name) || draft.problems.is_section_invalid("joints.another"))
      continue;
    draft.problems.collect([&, &where = text] { check_positive_mass(where, body); });
    const bool nothing = body.mass.value() == 0 && !has_attached_elements(mechanism, static_cast<int>(index));
    if (text.mass && nothing && !weightless) warn_of_zero_mass(*text.mass, draft);
  }
}

}  // namespace balance::specification
