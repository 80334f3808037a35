// Couplings, actuators, the tool: what refers to joints and points that are already there.

#include "balance/base/nearest.hpp"
#include "balance/model/leaders.hpp"
#include "balance/spec/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace balance::read {

namespace {

/// What a coupling's mapping says; what could not be read is nothing.
struct CouplingText {
  std::optional<Cursor> joint, several, ratio, offset;
  std::optional<CoordinateId> follower, leader;
};

bool read_ratio(const CouplingText& text, Draft& draft, CouplingOf<Expression>& coupling) {
  const auto& coordinates = draft.mechanism().coordinates;
  const auto unit = [&](std::optional<CoordinateId> c) {
    return c ? dimension_of(coordinates[static_cast<std::size_t>(*c)].kind) : dimension::none;
  };
  const bool leader = !text.several || draft.problems.guard([&] {
    if (!text.follower) throw Consequence();
    coupling.leader = read_followed(*text.several, draft, unit(text.follower));
  });
  const bool ratio = !text.ratio || draft.problems.guard([&] {
    const Dimension own = text.several ? dimension::none : unit(text.follower) / unit(text.leader);
    coupling.ratio = read_number(*text.ratio, draft, own);
    if (is_stuck_at_zero(*text.ratio, coupling.ratio, draft))
      text.ratio->fail({.expected = "a ratio other than 0 (a joint that does not move is 'fixed')", .found = "0"});
  });
  const bool offset = !text.offset || draft.problems.guard([&] {
    coupling.offset = read_number(*text.offset, draft, unit(text.follower));
  });
  return leader && ratio && offset;
}

bool rolls(const Draft& draft, CoordinateId coordinate) {
  return std::any_of(draft.wheels.begin(), draft.wheels.end(),
                     [&](const auto& wheel) { return wheel.follower == coordinate; });
}

void read_coupling(const Cursor& at, Draft& draft, Leaders& leaders) {
  auto& mechanism = draft.mechanism();
  CouplingText text;
  const bool read = read_fields(
      at, "a coupling {joint, follows, ratio}",
      {{"joint", Need::required,
        [&](const Cursor& c) {
          text.joint = c;
          text.follower = read_coordinate(c, draft);
        }},
       {"follows", Need::required,
        [&](const Cursor& c) {
          if (c.is_map())
            text.several = c;
          else
            text.leader = read_coordinate(c, draft);
        }},
       {"ratio", follows_several(at) ? Need::optional : Need::required, [&](const Cursor& c) { text.ratio = c; }},
       {"offset", Need::optional, [&](const Cursor& c) { text.offset = c; }}});
  CouplingOf<Expression> coupling;
  if (!read_ratio(text, draft, coupling) || !read) return;
  coupling.follower = *text.follower;
  if (text.leader) coupling.leader = *text.leader;
  const std::string name = mechanism.coordinates[static_cast<std::size_t>(coupling.follower)].name;
  std::vector<CoordinateId>& led_by = leaders[static_cast<std::size_t>(coupling.follower)];
  if (!led_by.empty())
    text.joint->fail(
        {.expected = "a coordinate that follows one other",
         .found = fmt::format("{}, which {}", in_quotes(name),
                              rolls(draft, coupling.follower) ? "follows the wheel that rolls" : "is coupled twice")});
  if (follows_itself(leaders, coupling.follower, coordinates_of(coupling.leader)))
    text.joint->fail({.kind = "circular coupling",
                      .expected = "a chain of couplings with an end",
                      .found = fmt::format("that {} follows itself", in_quotes(name))});
  led_by = coordinates_of(coupling.leader);
  mechanism.couplings.push_back(coupling);
}

}  // namespace

void read_couplings(const Cursor& section, Draft& draft) {
  Leaders leaders(draft.mechanism().coordinates.size());
  for (const auto& wheel : draft.wheels)
    leaders[static_cast<std::size_t>(wheel.follower)] = coordinates_of(wheel.leader);
  for (const Cursor& item : section.items("a list of couplings {joint, follows, ratio}"))
    draft.problems.guard([&] { read_coupling(item, draft, leaders); });
}

void read_actuators(const Cursor& section, Draft& draft) {
  draft.problems.guard([&] {
    auto& actuators = draft.mechanism().actuators;
    std::set<int> known(actuators.begin(), actuators.end());
    for (const Cursor& item : section.items("a list of joint coordinates")) {
      const bool read = draft.problems.guard([&] {
        const CoordinateId coordinate = read_coordinate(item, draft);
        if (!known.insert(coordinate).second)
          item.fail({.expected = "every actuator once", .found = fmt::format("{} again", item.found())});
        actuators.push_back(coordinate);
      });
      if (!read) draft.problems.spoil(item.path());
    }
  });
}

void read_tool(const Cursor& section, Draft& draft) {
  draft.problems.guard([&] {
    const PointReference point = read_reference(section, draft);
    if (point.body == ground) section.fail({.expected = "a point of a moving body", .found = section.found()});
    draft.mechanism().tool = ToolOf<Expression>{point.body, point.name, point.position};
  });
}

}  // namespace balance::read
