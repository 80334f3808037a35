// Couplings, actuators, the tool: what refers to joints and points that are already there.

#include "balance/base/nearest.hpp"
#include "balance/model/leaders.hpp"
#include "balance/spec/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace balance::specification {

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
