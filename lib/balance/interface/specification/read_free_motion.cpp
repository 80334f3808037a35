#include "balance/interface/specification/read_free_motion.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

namespace balance::specification {

namespace {

bool contains(const std::vector<CoordinateId>& list, CoordinateId coordinate) {
  return std::find(list.begin(), list.end(), coordinate) != list.end();
}

std::string quote_name(CoordinateId coordinate, const StudyBuilder& draft) {
  return quote_for_message(draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].name);
}

/// A list of coordinates that the trajectory does not drive.
std::vector<CoordinateId> read_undriven(const SpecCursor& at, const char* key, StudyBuilder& draft,
                                        const TrajectoryOf<Expression>& trajectory) {
  std::vector<CoordinateId> coordinates;
  read_each(at.items("a list of joint coordinates"), [&](const SpecCursor& item) {
    const CoordinateId coordinate = read_coordinate(item, draft);
    const bool is_driven = std::any_of(trajectory.from.joints.begin(), trajectory.from.joints.end(),
                                       [&](const auto& value) { return value.coordinate == coordinate; });
    if (is_driven)
      item.fail({.expected = fmt::format("under '{}' a coordinate that the trajectory does not drive; where it starts "
                                         "stands under 'initial'",
                                         key),
                 .found = fmt::format("{}, a joint of 'from'", item.describe_found())});
    if (contains(coordinates, coordinate))
      item.fail({.expected = "each coordinate only once", .found = fmt::format("{} again", item.describe_found())});
    coordinates.push_back(coordinate);
  });
  return coordinates;
}

void read_rates(const SpecCursor& at, StudyBuilder& draft, trajectory::FreeMotionOf<Expression>& motion) {
  for (const Member& member : list_members(at, "a mapping of joint coordinates to rates"))
    at.problems().collect([&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].kind;
      if (!contains(motion.free, coordinate))
        member.key.fail({.expected = "a free coordinate", .found = quote_for_message(member.name)});
      motion.rate.push_back({coordinate, read_number(member.value, draft, dimension_of(kind) / dimension::time)});
    });
}

/// Values of undriven coordinates; the others start as in `assembly`, or at zero.
void add_start_values(const std::vector<model::CoordinateValueOf<Expression>>& stated, const StudyBuilder& draft,
                      const trajectory::FreeMotionOf<Expression>& motion, TrajectoryOf<Expression>& trajectory) {
  for (const auto* list : {&motion.held, &motion.free})
    for (const CoordinateId coordinate : *list) {
      model::CoordinateValueOf<Expression> start{coordinate, 0};
      for (const auto* values : {&draft.mechanism().assembly, &stated})
        for (const auto& value : *values)
          if (value.coordinate == coordinate) start = value;
      trajectory.from.joints.push_back(start);
    }
}

/// @return stated values
std::vector<model::CoordinateValueOf<Expression>> read_initial(const SpecCursor& at, StudyBuilder& draft,
                                                               trajectory::FreeMotionOf<Expression>& motion) {
  using enum trajectory::FreeStart;
  const auto read_start = [&](const SpecCursor& c) {
    constexpr trajectory::FreeStart starts[]{given, equilibrium, periodic};
    motion.start = starts[c.read_choice("a start", {"rest", "equilibrium", "steady"})];
  };
  std::vector<model::CoordinateValueOf<Expression>> values;
  if (at.is_scalar()) {
    read_start(at);
    return values;
  }
  std::optional<SpecCursor> rates, joints;
  read_fields(at, "a start: rest, equilibrium, steady or {joints, rates}",
              {{"start", Presence::optional, read_start},
               {"joints", Presence::optional, [&](const SpecCursor& c) { joints = c; }},
               {"rates", Presence::optional, [&](const SpecCursor& c) { rates = c; }}});
  if (rates && motion.start == equilibrium)
    rates->fail({.expected = "no 'rates' with an equilibrium, which is at rest"});
  if (rates) read_rates(*rates, draft, motion);
  if (!joints) return values;
  values = read_coordinate_values(*joints, draft);
  for (const auto& value : values)
    if (!contains(motion.free, value.coordinate) && !contains(motion.held, value.coordinate))
      joints->fail({.expected = "values of free or held coordinates", .found = quote_name(value.coordinate, draft)});
  return values;
}

}  // namespace

void read_free_motion(const FreeMotionKeys& keys, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  if (!keys.free && !keys.hold && !keys.initial) return;
  if (!keys.free)
    (keys.hold ? *keys.hold : *keys.initial)
        .fail({.expected = "'free', the coordinates that move by the dynamics, beside it", .found = "none"});
  if (trajectory.drive != DriveKind::joints) keys.free->fail({.expected = "'free' only with 'drive: joints'"});
  if (is_mechanism_dependent(trajectory))
    keys.free->fail({.expected = "no 'free' with a law, a corridor or a momentum for which the motion is searched"});
  trajectory::FreeMotionOf<Expression> motion;
  motion.free = read_undriven(*keys.free, "free", draft, trajectory);
  if (motion.free.empty()) keys.free->fail_expected("at least one free coordinate");
  if (keys.hold) motion.held = read_undriven(*keys.hold, "hold", draft, trajectory);
  for (const CoordinateId coordinate : motion.held)
    if (contains(motion.free, coordinate))
      keys.hold->fail({.expected = "coordinates that are not free", .found = quote_name(coordinate, draft)});
  std::vector<model::CoordinateValueOf<Expression>> stated;
  if (keys.initial) stated = read_initial(*keys.initial, draft, motion);
  add_start_values(stated, draft, motion, trajectory);
  trajectory.free_motion = std::move(motion);
}

}  // namespace balance::specification
