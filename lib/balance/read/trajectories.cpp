#include "balance/read/limits.hpp"
#include "balance/read/nearest.hpp"
#include "balance/read/path.hpp"
#include "balance/read/pose.hpp"
#include "balance/read/sections.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::read {

namespace {

/// What both `motion` and a trajectory may say.
struct Timing {
  std::optional<double> duration;
  std::optional<long> samples;
  std::optional<PoseTarget> from, to;
  std::optional<Cursor> from_at, to_at;
  std::optional<Vector3> about;
};

std::vector<Field> timing_fields(Timing& timing, Draft& draft) {
  return {{"duration", Need::optional,
           [&](const Cursor& c) { timing.duration = read_number(c, draft, dimension::time, Sign::positive); }},
          {"samples", Need::optional, [&](const Cursor& c) { timing.samples = read_whole(c, draft, 2, most_samples); }},
          {"from", Need::optional,
           [&](const Cursor& c) {
             timing.from_at = c;
             timing.from = read_pose(c, draft);
           }},
          {"to", Need::optional,
           [&](const Cursor& c) {
             timing.to_at = c;
             timing.to = read_pose(c, draft);
           }},
          {"about", Need::optional, [&](const Cursor& c) { timing.about = read_vector(c, draft, dimension::length); }}};
}

struct NamedLaw {
  const char* name;
  LawKind kind;
};

constexpr NamedLaw laws[]{{"cycloidal", LawKind::cycloidal},
                          {"cycloid", LawKind::cycloidal},
                          {"bang-bang", LawKind::bang_bang},
                          {"uniform", LawKind::uniform},
                          {"cubic", LawKind::cubic},
                          {"3-4-5", LawKind::polynomial_345},
                          {"poly-345", LawKind::polynomial_345},
                          {"4-5-6-7", LawKind::polynomial_4567},
                          {"poly-4567", LawKind::polynomial_4567},
                          {"harmonic", LawKind::harmonic},
                          {"modified-sine", LawKind::modified_sine},
                          {"modified-trapezoidal", LawKind::modified_trapezoidal},
                          {"trapezoidal-velocity", LawKind::trapezoidal_velocity}};

LawKind read_law(const Cursor& at) {
  std::vector<std::string> names;
  for (const NamedLaw& law : laws) names.emplace_back(law.name);
  return laws[at.choice("a law of motion", names)].kind;
}

void read_ramps(const Cursor& at, Draft& draft, Law& law) {
  if (law.kind != LawKind::trapezoidal_velocity)
    at.fail("expected no ramps: only the law 'trapezoidal-velocity' has them");
  if (at.is_list()) {
    const auto both = at.items("[ramp up, ramp down]", 2);
    law.ramp_up = read_number(both[0], draft, dimension::none);
    law.ramp_down = read_number(both[1], draft, dimension::none);
  } else {
    law.ramp_up = law.ramp_down = read_number(at, draft, dimension::none);
  }
  if (!draft.judging()) return;
  if (!(law.ramp_up > 0 && law.ramp_down > 0 && law.ramp_up + law.ramp_down <= 1))
    at.fail(fmt::format("expected ramps > 0 with a sum of at most 1, found {} and {}", law.ramp_up, law.ramp_down));
}

std::vector<Component> read_components(const Cursor& at, const Draft& draft, DriveKind drive) {
  const bool planar = draft.study.mechanism.space == SpaceKind::planar;
  using enum Component;
  if (drive == DriveKind::joints)
    at.fail("expected no 'components' with 'drive: joints', which names its coordinates itself");
  std::vector<std::string> names =
      planar ? std::vector<std::string>{"x", "y", "angle"} : std::vector<std::string>{"x", "y", "z", "rx", "ry", "rz"};
  if (drive == DriveKind::com) names.resize(planar ? 2 : 3);
  const std::vector<Component> values =
      planar ? std::vector<Component>{x, y, rz} : std::vector<Component>{x, y, z, rx, ry, rz};
  std::vector<Component> components;
  for (const Cursor& item : at.items("a list of components")) {
    const Component component = values[item.choice("a component", names)];
    if (std::find(components.begin(), components.end(), component) != components.end())
      item.fail(fmt::format("expected every component once, found {} again", item.found()));
    components.push_back(component);
  }
  if (components.empty()) at.expected("at least one component");
  return components;
}

/// What only a trajectory says, before its parts are put together.
struct TrajectoryText {
  std::optional<Cursor> law, drive, path, ramp, ramps, components, remaining;
};

void read_remaining(const Cursor& at, Draft& draft, Trajectory& trajectory) {
  if (trajectory.drive == DriveKind::joints)
    at.fail("expected no 'remaining' with 'drive: joints', which names its coordinates itself");
  for (const Cursor& item : at.items("a list of joint coordinates")) {
    const int coordinate = read_coordinate(item, draft);
    if (std::find(trajectory.remaining.begin(), trajectory.remaining.end(), coordinate) != trajectory.remaining.end())
      item.fail(fmt::format("expected every coordinate once, found {} again", item.found()));
    trajectory.remaining.push_back(coordinate);
  }
}

/// Where to complain about a pose that a trajectory has from itself, from `motion` or not at all.
Cursor place_of(const std::optional<Cursor>& own, const std::optional<Cursor>& shared, const Cursor& otherwise) {
  return own ? *own : shared ? *shared : otherwise;
}

/// A pose may be told in other quantities than the drive's: it is found, and the drive's are measured there.
bool told_otherwise(const PoseTarget& pose, DriveKind drive) {
  const bool by_joints = !pose.joints.empty(), by_place = pose.tool || pose.com;
  return drive == DriveKind::joints ? !by_joints && by_place
                                    : drive == DriveKind::tool && !pose.tool && (by_joints || pose.com);
}

void read_poses(const Cursor& at, const Timing& own, const Timing& shared, const Cursor* path, Draft& draft,
                Trajectory& trajectory) {
  const auto from = own.from ? own.from : shared.from;
  const auto to = own.to ? own.to : shared.to;
  if (from) trajectory.from = *from;
  if (to) trajectory.to = *to;
  if (path != nullptr && is_table(*path)) return;
  const DriveNeeds needs{trajectory.drive, trajectory.components};
  if (!from) at.fail("missing key: expected 'from' here or in 'motion', found none");
  const bool from_elsewhere = told_otherwise(trajectory.from, trajectory.drive);
  if (!from_elsewhere || path != nullptr)
    check_pose(place_of(own.from_at, shared.from_at, at), trajectory.from, needs, draft);
  if (!needs_end(path)) {
    trajectory.to = trajectory.from;
    return;
  }
  if (!to) at.fail("missing key: expected 'to' here or in 'motion', found none");
  const Cursor to_at = place_of(own.to_at, shared.to_at, at);
  const bool to_elsewhere = told_otherwise(trajectory.to, trajectory.drive);
  if (!to_elsewhere || path != nullptr) check_pose(to_at, trajectory.to, needs, draft);
  if ((!from_elsewhere && !to_elsewhere) || path != nullptr)
    match_pose(to_at, trajectory.to, trajectory.from, trajectory.drive, draft);
}

void put_together(const Cursor& at, const TrajectoryText& text, const Timing& own, const Timing& shared, Draft& draft,
                  Trajectory& trajectory) {
  const Cursor* path = text.path ? &*text.path : nullptr;
  trajectory.drive = static_cast<DriveKind>(text.drive->choice("a drive", {"joints", "tool", "com"}));
  if (trajectory.drive == DriveKind::tool && !draft.mechanism().tool)
    text.drive->fail("expected a spec with a tool ('tool: body.point') for 'drive: tool', found none");
  if (text.law)
    trajectory.law.kind = read_law(*text.law);
  else if (path == nullptr || !is_table(*path))
    at.missing("'law'");
  if (text.ramp && text.ramps) text.ramps->fail("expected 'ramp' or 'ramps', found both");
  for (const auto& ramps : {text.ramp, text.ramps})
    if (ramps) read_ramps(*ramps, draft, trajectory.law);
  if (text.components) {
    trajectory.components = read_components(*text.components, draft, trajectory.drive);
  }
  if (text.remaining) read_remaining(*text.remaining, draft, trajectory);
  read_poses(at, own, shared, path, draft, trajectory);
  const auto duration = own.duration ? own.duration : shared.duration;
  if (!duration && (path == nullptr || !is_table(*path)))
    at.fail("missing key: expected 'duration' here or in 'motion', found none");
  trajectory.duration = duration.value_or(1);
  trajectory.samples = own.samples.value_or(shared.samples.value_or(trajectory.samples));
  trajectory.about = own.about.value_or(shared.about.value_or(Vector3::Zero()));
  if (path != nullptr) read_path(*path, draft, trajectory);
}

void read_trajectory(const Member& member, const Timing& shared, Draft& draft) {
  Trajectory trajectory;
  trajectory.name = member.name;
  TrajectoryText text;
  Timing own;
  const auto keep = [](std::optional<Cursor>& slot) { return [&slot](const Cursor& c) { slot = c; }; };
  auto fields = timing_fields(own, draft);
  for (auto& [name, slot] : {std::pair{"law", &text.law},
                             {"path", &text.path},
                             {"ramp", &text.ramp},
                             {"ramps", &text.ramps},
                             {"components", &text.components},
                             {"remaining", &text.remaining}})
    fields.push_back({name, Need::optional, keep(*slot)});
  fields.push_back({"drive", Need::required, keep(text.drive)});
  if (!read_fields(member.value, "a trajectory {law, drive}", fields)) return;
  draft.problems.guard([&] {
    put_together(member.value, text, own, shared, draft, trajectory);
    draft.study.trajectories.push_back(std::move(trajectory));
  });
}

/// `cycloid` and `bang-bang` exist whenever `motion` says from where to where. What they drive is what it says.
void add_built_in(const Cursor& motion, const Timing& timing, const char* name, LawKind law, Draft& draft) {
  const auto& known = draft.study.trajectories;
  if (std::any_of(known.begin(), known.end(), [&](const Trajectory& t) { return t.name == name; })) return;
  const PoseTarget& from = *timing.from;
  PoseTarget to = *timing.to;
  Trajectory trajectory;
  trajectory.name = name;
  trajectory.law.kind = law;
  const bool by_tool = from.tool && to.tool;
  const bool by_joints = !from.joints.empty() && !to.joints.empty();
  if (!by_tool && !by_joints && !(from.com && to.com))
    timing.to_at->fail("expected the same of 'tool', 'joints' or 'com' in 'from' and 'to', found different ones");
  const DriveKind moved = by_tool ? DriveKind::tool : by_joints ? DriveKind::joints : DriveKind::com;
  trajectory.drive = law == LawKind::bang_bang && by_tool ? DriveKind::com : moved;
  match_pose(*timing.to_at, to, from, moved, draft);
  if (!timing.duration) motion.missing("'duration'");
  trajectory.from = from;
  trajectory.to = to;
  trajectory.duration = *timing.duration;
  trajectory.samples = timing.samples.value_or(trajectory.samples);
  trajectory.about = timing.about.value_or(Vector3::Zero());
  draft.study.trajectories.push_back(std::move(trajectory));
}

}  // namespace

void read_trajectories(const Cursor* motion, const Cursor* trajectories, Draft& draft) {
  Timing shared;
  bool read = true;
  if (motion != nullptr) read = read_fields(*motion, "a motion {duration, from, to}", timing_fields(shared, draft));
  if (trajectories != nullptr && read)
    draft.problems.guard([&] {
      for (const Member& member : named_members(*trajectories, "a mapping of trajectories"))
        read_trajectory(member, shared, draft);
    });
  if (motion == nullptr || !draft.problems.none()) return;
  draft.problems.guard([&] {
    const bool declared = !draft.study.trajectories.empty();
    if (!declared)
      for (const auto& [pose, name] : {std::pair{&shared.from, "from"}, {&shared.to, "to"}})
        if (!*pose) motion->missing(in_quotes(name));
    if (!shared.from || !shared.to) return;
    // A motion that only serves declared trajectories need not carry the built-in ones.
    if (declared && !shared.duration) return;
    add_built_in(*motion, shared, "cycloid", LawKind::cycloidal, draft);
    add_built_in(*motion, shared, "bang-bang", LawKind::bang_bang, draft);
  });
}

}  // namespace balance::read
