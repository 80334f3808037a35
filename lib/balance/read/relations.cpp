// Couplings, actuators, the tool: what refers to joints and points that are already there.

#include "balance/read/nearest.hpp"
#include "balance/read/sections.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::read {

namespace {

/// Who leads whom: the leader of every coordinate, −1 for those that follow nobody.
using Leaders = std::vector<int>;

/// Whether the chain of leaders above `leader` comes back to `follower`.
bool is_circle(const Leaders& leaders, int follower, int leader) {
  while (leader >= 0 && leader != follower) leader = leaders[static_cast<std::size_t>(leader)];
  return leader == follower;
}

void read_coupling(const Cursor& at, Draft& draft, Leaders& leaders) {
  Mechanism& mechanism = draft.mechanism();
  Coupling coupling;
  std::optional<Cursor> joint, ratio, offset;
  const bool read =
      read_fields(at, "a coupling {joint, follows, ratio}",
                  {{"joint", Need::required,
                    [&](const Cursor& c) {
                      joint = c;
                      coupling.follower = read_coordinate(c, draft);
                    }},
                   {"follows", Need::required, [&](const Cursor& c) { coupling.leader = read_coordinate(c, draft); }},
                   {"ratio", Need::required, [&](const Cursor& c) { ratio = c; }},
                   {"offset", Need::optional, [&](const Cursor& c) { offset = c; }}});
  if (!read) return;
  const auto unit = [&](int c) { return dimension_of(mechanism.coordinates[static_cast<std::size_t>(c)].kind); };
  coupling.ratio = read_number(*ratio, draft, unit(coupling.follower) / unit(coupling.leader));
  if (draft.judging() && coupling.ratio == 0 && ratio->is_scalar())
    ratio->fail("expected a ratio other than 0 (a joint that does not move is 'fixed'), found 0");
  if (offset) coupling.offset = read_number(*offset, draft, unit(coupling.follower));
  const std::string name = mechanism.coordinates[static_cast<std::size_t>(coupling.follower)].name;
  int& led_by = leaders[static_cast<std::size_t>(coupling.follower)];
  if (led_by >= 0)
    joint->fail(
        fmt::format("expected a coordinate that follows one other, found {}, which is coupled twice", in_quotes(name)));
  if (is_circle(leaders, coupling.follower, coupling.leader))
    joint->fail(fmt::format(
        "circular coupling: expected a chain of couplings with an end, found that {} follows itself", in_quotes(name)));
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
    for (const Cursor& item : section.items("a list of joint coordinates")) {
      draft.problems.guard([&] {
        const int coordinate = read_coordinate(item, draft);
        if (std::find(actuators.begin(), actuators.end(), coordinate) != actuators.end())
          item.fail(fmt::format("expected every actuator once, found {} again", item.found()));
        actuators.push_back(coordinate);
      });
    }
  });
}

void read_tool(const Cursor& section, Draft& draft) {
  draft.problems.guard([&] {
    const PointReference point = read_reference(section, draft);
    if (point.body == ground) section.fail(fmt::format("expected a point of a moving body, found {}", section.found()));
    draft.mechanism().tool = Tool{point.body, point.name, point.position};
  });
}

}  // namespace balance::read
