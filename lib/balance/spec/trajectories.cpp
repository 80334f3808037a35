#include "balance/base/nearest.hpp"
#include "balance/motion/timing_bounds.hpp"
#include "balance/spec/law.hpp"
#include "balance/spec/passing_payloads.hpp"
#include "balance/spec/path.hpp"
#include "balance/spec/pose.hpp"
#include "balance/spec/remaining.hpp"
#include "balance/spec/searched_law.hpp"
#include "balance/spec/sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>

namespace balance::read {

namespace {

/// What both `motion` and a trajectory may say.
struct Timing {
  bool duration_given = false;  ///< rightly or wrongly
  std::optional<Expression> duration;
  std::optional<long> samples;
  std::optional<PoseTargetOf<Expression>> from, to;
  std::optional<Cursor> from_at, to_at;
  std::optional<Vector3E> about;
};

std::vector<Field> timing_fields(Timing& timing, Draft& draft) {
  return {{"duration", Need::optional,
           [&](const Cursor& c) {
             timing.duration_given = true;
             timing.duration = read_duration(c, draft);
           }},
          {"samples", Need::optional,
           [&](const Cursor& c) { timing.samples = read_whole(c, draft, min_samples, max_samples); }},
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

std::vector<Component> read_components(const Cursor& at, const Draft& draft, DriveKind drive) {
  const bool planar = draft.planar();
  using enum Component;
  if (drive == DriveKind::joints)
    at.fail({.expected = "no 'components' with 'drive: joints', which names its coordinates itself"});
  std::vector<std::string> names =
      planar ? std::vector<std::string>{"x", "y", "angle"} : std::vector<std::string>{"x", "y", "z", "rx", "ry", "rz"};
  if (drive == DriveKind::com) names.resize(planar ? 2 : 3);
  const std::vector<Component> values =
      planar ? std::vector<Component>{x, y, rz} : std::vector<Component>{x, y, z, rx, ry, rz};
  std::vector<Component> components;
  read_each(at.items("a list of components"), [&](const Cursor& item) {
    const Component component = values[item.choice("a component", names)];
    if (std::find(components.begin(), components.end(), component) != components.end())
      item.fail({.expected = "every component once", .found = fmt::format("{} again", item.found())});
    components.push_back(component);
  });
  if (components.empty()) at.expected("at least one component");
  return components;
}

/// What only a trajectory says, before its parts are put together.
struct TrajectoryText {
  std::optional<Cursor> law, drive, path, ramp, ramps, components, remaining, turns;
  SearchedLawText searched;
};

/// Where to complain about a pose that a trajectory has from itself, from `motion` or not at all.
Cursor place_of(const std::optional<Cursor>& own, const std::optional<Cursor>& shared, const Cursor& otherwise) {
  return own ? *own : shared ? *shared : otherwise;
}

/// A trajectory being read: what it says, what `motion` says for all, and where it goes.
struct Assembly {
  const Cursor& at;
  const TrajectoryText& text;
  const Timing& own;
  const Timing& shared;
  Draft& draft;
  TrajectoryOf<Expression>& trajectory;

  const Cursor* path() const { return text.path ? &*text.path : nullptr; }
  bool by_table() const { return text.path && is_table(*text.path); }

  /// Whether a key that both may have is missing, or wrong, because of a mistake that is told already.
  bool unread(const char* key, bool own_given, bool shared_given) const {
    const Problems& problems = draft.problems;
    const std::string here = at.path() + "." + key, there = std::string("motion.") + key;
    if (problems.spoilt(here)) return true;
    return !own_given && (shared_given ? problems.spoilt(there) : problems.lost(here) || problems.lost(there));
  }
};

/// Whole or broken turns of the one joint that is driven, from its start on.
void read_turns(const Assembly& a) {
  auto& trajectory = a.trajectory;
  const Cursor& at = *a.text.turns;
  if (trajectory.drive != DriveKind::joints || a.text.path)
    at.fail({.expected = "'turns' with 'drive: joints' and no 'path'; a circle has turns of its own"});
  const auto& joints = trajectory.from.joints;
  const auto& coordinates = a.draft.mechanism().coordinates;
  if (joints.size() != 1 ||
      coordinates[static_cast<std::size_t>(joints.front().coordinate)].kind != CoordinateKind::angle)
    at.fail({.expected = "a start pose (from) of one joint that turns",
             .found = fmt::format("one of {}", joints.size() == 1 ? "a joint that slides" : "several joints")});
  const Expression turns = read_number(at, a.draft, dimension::none);
  trajectory.to = trajectory.from;
  trajectory.to.joints.front().value = joints.front().value + turns * (2 * std::numbers::pi);
}

void read_poses(const Assembly& a) {
  const Timing &own = a.own, &shared = a.shared;
  TrajectoryOf<Expression>& trajectory = a.trajectory;
  const Cursor* path = a.path();
  const bool goes_on = a.text.turns || !needs_end(path);  // and so says where it ends
  if (a.unread("from", own.from_at.has_value(), shared.from_at.has_value())) throw Consequence();
  if (a.unread("to", own.to_at.has_value(), shared.to_at.has_value()) && !goes_on) throw Consequence();
  const auto from = own.from ? own.from : shared.from;
  const auto to = own.to ? own.to : shared.to;
  if (from) trajectory.from = *from;
  if (to) trajectory.to = *to;
  if (keeps_momentum(trajectory)) trajectory.to.angle = trajectory.from.angle;  // where it ends is found
  if (a.by_table()) return;
  const DriveNeeds needs{trajectory.drive, trajectory.components};
  if (!from) a.at.fail({.kind = "missing key", .expected = "'from' here or in 'motion'", .found = "none"});
  const bool from_elsewhere = told_otherwise(trajectory.from, trajectory.drive);
  if (!from_elsewhere || path != nullptr)
    check_pose(place_of(own.from_at, shared.from_at, a.at), trajectory.from, needs, a.draft);
  if (a.text.turns) return read_turns(a);
  if (goes_on) {
    trajectory.to = trajectory.from;
    return;
  }
  if (!to) a.at.fail({.kind = "missing key", .expected = "'to' here or in 'motion'", .found = "none"});
  const Cursor to_at = place_of(own.to_at, shared.to_at, a.at);
  const bool to_elsewhere = told_otherwise(trajectory.to, trajectory.drive);
  if (!to_elsewhere || path != nullptr) check_pose(to_at, trajectory.to, needs, a.draft);
  if ((!from_elsewhere && !to_elsewhere) || path != nullptr)
    match_pose(to_at, trajectory.to, trajectory.from, trajectory.drive, a.draft);
}

void read_drive(const Assembly& a) {
  if (!a.text.drive) throw Consequence();
  a.trajectory.drive = static_cast<DriveKind>(a.text.drive->choice("a drive", {"joints", "tool", "com"}));
  if (a.trajectory.drive == DriveKind::tool && !a.draft.mechanism().tool)
    a.text.drive->fail_unless_doubtful(
        "tool", {.expected = "a spec with a tool ('tool: body.point') for 'drive: tool'", .found = "none"});
}

void read_whole_law(const Assembly& a) {
  if (a.text.law)
    a.trajectory.law.kind = read_law(*a.text.law);
  else if (a.draft.problems.doubtful(a.at.path() + ".law"))
    throw Consequence();
  else if (!a.by_table())
    a.at.missing({"law"});
  if (a.text.ramp && a.text.ramps) a.text.ramps->fail({.expected = "'ramp' or 'ramps'", .found = "both"});
  for (const auto& ramps : {a.text.ramp, a.text.ramps})
    if (ramps) read_ramps(*ramps, a.draft, a.trajectory.law);
}

void read_timing(const Assembly& a) {
  const LawKind law = a.trajectory.law.kind;
  if (law == LawKind::fastest && a.own.duration_given)
    a.at.fail({.expected = "no 'duration' with the law 'fastest', which finds it"});
  const auto duration = a.own.duration ? a.own.duration : a.shared.duration;
  const bool unread = a.unread("duration", a.own.duration_given, a.shared.duration_given);
  a.trajectory.duration = duration.value_or(unread ? std::numeric_limits<double>::infinity() : 1.0);
  a.trajectory.samples = a.own.samples.value_or(a.shared.samples.value_or(a.trajectory.samples));
  a.trajectory.about = a.own.about.value_or(a.shared.about.value_or(Vector3E::Zero()));
  if (unread || duration || law == LawKind::fastest || (a.by_table() && !is_searched(law))) return;
  a.trajectory.duration = std::numeric_limits<double>::infinity();
  a.at.fail({.kind = "missing key", .expected = "'duration' here or in 'motion'", .found = "none"});
}

/// Reads on after a mistake with what does not depend on it.
void put_together(const Assembly& a) {
  Problems& problems = a.draft.problems;
  const bool driven = problems.guard([&] { read_drive(a); });
  problems.guard([&] { read_whole_law(a); });
  problems.guard([&] { read_timing(a); });
  if (!driven) return;
  const bool chosen = problems.guard([&] {
    if (a.text.components) a.trajectory.components = read_components(*a.text.components, a.draft, a.trajectory.drive);
  });
  problems.guard([&] {
    if (a.text.remaining) read_remaining(*a.text.remaining, a.draft, a.trajectory);
  });
  const bool posed = chosen && problems.guard([&] { read_poses(a); });
  const bool corridor = a.text.path && is_corridor(*a.text.path);
  problems.guard([&] { read_searched_law(a.at, a.text.searched, corridor, a.draft, a.trajectory); });
  if (chosen && a.text.path && (posed || (is_circle(*a.text.path) && a.trajectory.drive != DriveKind::joints)))
    problems.guard([&] { read_path(*a.text.path, a.draft, a.trajectory); });
  const Cursor from = place_of(a.own.from_at, a.shared.from_at, a.at), to = place_of(a.own.to_at, a.shared.to_at, a.at);
  problems.guard([&] {
    check_passing({a.at, a.text.drive, a.text.law, a.text.searched.limits, from, to}, a.draft, a.trajectory);
  });
}

void read_trajectory(const Member& member, const Timing& shared, Draft& draft) {
  TrajectoryOf<Expression> trajectory;
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
                             {"remaining", &text.remaining},
                             {"turns", &text.turns},
                             {"limits", &text.searched.limits},
                             {"of", &text.searched.of},
                             {"speeds", &text.searched.speeds}})
    fields.push_back({name, Need::optional, keep(*slot)});
  fields.push_back({"drive", Need::required, keep(text.drive)});
  read_fields(member.value, "a trajectory {law, drive}", fields);
  if (member.value.is_map()) put_together({member.value, text, own, shared, draft, trajectory});
  // Even if it is wrong its name is known.
  draft.trajectories().push_back(std::move(trajectory));
}

/// `cycloid` and `bang-bang` exist whenever `motion` says from where to where. What they drive is what it says.
void add_built_in(const Cursor& motion, const Timing& timing, const char* name, LawKind law, Draft& draft) {
  const auto& known = draft.trajectories();
  if (std::any_of(known.begin(), known.end(), [&](const TrajectoryOf<Expression>& t) { return t.name == name; }))
    return;
  const PoseTargetOf<Expression>& from = *timing.from;
  PoseTargetOf<Expression> to = *timing.to;
  TrajectoryOf<Expression> trajectory;
  trajectory.name = name;
  trajectory.law.kind = law;
  const bool by_tool = from.tool && to.tool;
  const bool by_joints = !from.joints.empty() && !to.joints.empty();
  if (!by_tool && !by_joints && !(from.com && to.com))
    timing.to_at->fail(
        {.expected = "the same of 'tool', 'joints' or 'com' in 'from' and 'to'", .found = "different ones"});
  const DriveKind moved = by_tool ? DriveKind::tool : by_joints ? DriveKind::joints : DriveKind::com;
  trajectory.drive = law == LawKind::bang_bang && by_tool ? DriveKind::com : moved;
  if (moved == DriveKind::com) expect_lasting_payloads(*timing.from_at, "a pose by 'joints' or 'tool'", draft);
  // the centre of mass would jump: nobody asked for this trajectory by name
  if (trajectory.drive == DriveKind::com && !draft.study.passing_payloads.empty()) return;
  match_pose(*timing.to_at, to, from, moved, draft);
  if (!timing.duration) motion.missing({"duration"});
  trajectory.from = from;
  trajectory.to = to;
  trajectory.duration = *timing.duration;
  trajectory.samples = timing.samples.value_or(trajectory.samples);
  trajectory.about = timing.about.value_or(Vector3E::Zero());
  draft.trajectories().push_back(std::move(trajectory));
}

/// Without declared trajectories a motion must say from where to where.
void need_ends(const Cursor& motion, const Timing& timing) {
  if (motion.problems().lost("trajectories")) throw Consequence();
  for (const auto& [pose, name] : {std::pair{&timing.from, "from"}, {&timing.to, "to"}})
    motion.problems().guard([&, &pose = pose, &name = name] {
      if (!*pose) motion.missing({name});
    });
}

}  // namespace

void read_trajectories(const Cursor* motion, const Cursor* trajectories, Draft& draft) {
  Timing shared;
  Problems& problems = draft.problems;
  bool read = motion == nullptr || read_fields(*motion, "a motion {duration, from, to}", timing_fields(shared, draft));
  if (trajectories != nullptr) {
    const bool known = problems.guard([&] {
      for (const Member& member : named_members(*trajectories, "a mapping of trajectories", Names::single))
        read_trajectory(member, shared, draft);
    });
    read = read && known;
  }
  if (motion == nullptr) return;
  const bool known = read && problems.guard([&] {
    const bool declared = !draft.trajectories().empty();
    if (!declared) need_ends(*motion, shared);
    if (!shared.from || !shared.to) return;
    // A motion that only serves declared trajectories need not carry the built-in ones.
    if (declared && !shared.duration) return;
    add_built_in(*motion, shared, "cycloid", LawKind::cycloidal, draft);
    add_built_in(*motion, shared, "bang-bang", LawKind::bang_bang, draft);
  });
  if (!known) problems.spoil("motion");
}

}  // namespace balance::read
