// Couplings, actuators, the tool: what refers to joints and points that are already there.

#include "balance/base/nearest.hpp"
#include "balance/spec/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace balance::read {

namespace {

/// Who leads whom: the leader of every coordinate, −1 for those that follow nobody.
using Leaders = std::vector<int>;

/// Whether the chain of leaders above `leader` comes back to `follower`.
bool is_circle(const Leaders& leaders, int follower, int leader) {
  while (leader >= 0 && leader != follower) leader = leaders[static_cast<std::size_t>(leader)];
  return leader == follower;
}

/// What a coupling's mapping says; what could not be read is nothing.
struct CouplingText {
  std::optional<Cursor> joint, ratio, offset;
  std::optional<int> follower, leader;
};

bool read_ratio(const CouplingText& text, Draft& draft, CouplingOf<Expression>& coupling) {
  const auto& coordinates = draft.mechanism().coordinates;
  const auto unit = [&](std::optional<int> c) {
    return c ? dimension_of(coordinates[static_cast<std::size_t>(*c)].kind) : dimension::none;
  };
  const bool ratio = !text.ratio || draft.problems.guard([&] {
    coupling.ratio = read_number(*text.ratio, draft, unit(text.follower) / unit(text.leader));
    if (coupling.ratio.value() == 0 && text.ratio->is_scalar())
      text.ratio->fail({.expected = "a ratio other than 0 (a joint that does not move is 'fixed')", .found = "0"});
  });
  const bool offset = !text.offset || draft.problems.guard([&] {
    coupling.offset = read_number(*text.offset, draft, unit(text.follower));
  });
  return ratio && offset;
}

void read_coupling(const Cursor& at, Draft& draft, Leaders& leaders) {
  auto& mechanism = draft.mechanism();
  CouplingText text;
  const bool read =
      read_fields(at, "a coupling {joint, follows, ratio}",
                  {{"joint", Need::required,
                    [&](const Cursor& c) {
                      text.joint = c;
                      text.follower = read_coordinate(c, draft);
                    }},
                   {"follows", Need::required, [&](const Cursor& c) { text.leader = read_coordinate(c, draft); }},
                   {"ratio", Need::required, [&](const Cursor& c) { text.ratio = c; }},
                   {"offset", Need::optional, [&](const Cursor& c) { text.offset = c; }}});
  CouplingOf<Expression> coupling;
  if (!read_ratio(text, draft, coupling) || !read) return;
  coupling.follower = *text.follower;
  coupling.leader = *text.leader;
  const std::string name = mechanism.coordinates[static_cast<std::size_t>(coupling.follower)].name;
  int& led_by = leaders[static_cast<std::size_t>(coupling.follower)];
  if (led_by >= 0)
    text.joint->fail({.expected = "a coordinate that follows one other",
                      .found = fmt::format("{}, which is coupled twice", in_quotes(name))});
  if (is_circle(leaders, coupling.follower, coupling.leader))
    text.joint->fail({.kind = "circular coupling",
                      .expected = "a chain of couplings with an end",
                      .found = fmt::format("that {} follows itself", in_quotes(name))});
  led_by = coupling.leader;
  mechanism.couplings.push_back(coupling);
}

}  // namespace

void read_couplings(const Cursor& section, Draft& draft) {
  Leaders leaders(draft.mechanism().coordinates.size(), -1);
  for (const Cursor& item : section.items("a list of couplings {joint, follows, ratio}"))
    draft.problems.guard([&] { read_coupling(item, draft, leaders); });
}

void read_actuators(const Cursor& section, Draft& draft) {
  draft.problems.guard([&] {
    auto& actuators = draft.mechanism().actuators;
    std::set<int> known(actuators.begin(), actuators.end());
    for (const Cursor& item : section.items("a list of joint coordinates")) {
      const bool read = draft.problems.guard([&] {
        const int coordinate = read_coordinate(item, draft);
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
