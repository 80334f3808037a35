#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_path.hpp"
#include "balance/interface/specification/read_pose.hpp"
#include "balance/interface/specification/read_secondary_tasks.hpp"
#include "balance/interface/specification/read_temporary_payloads.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/mechanics/results/limitable_quantities.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace balance::specification {

// How a trajectory runs through its way.

/// A law's name.
MotionLawKind read_law(const SpecCursor& at);
/// The ramps of a trapezoidal velocity: one number for both, or two. Fails for any other law.
void read_ramps(const SpecCursor& at, StudyBuilder& draft, MotionLawOf<Expression>& law);

// Limits of a motion, and what only laws that are searched for say: whose peak is to be least, speeds at both ends.

/// Where they stand in a trajectory.
struct OptimisedLawKeys {
  std::optional<SpecCursor> limits, of, speeds;
};

/// Into the trajectory, whose law and drive are known. Fails if the law needs what is missing or is none that may say it.
/// @param at the trajectory @param corridor its path is one: then any law may say whose peak is to be least
void read_optimised_law(const SpecCursor& at, const OptimisedLawKeys& text, bool corridor, StudyBuilder& draft,
                        TrajectoryOf<Expression>& trajectory);

namespace {

struct NamedLaw {
  const char* name;
  MotionLawKind kind;
};

constexpr NamedLaw named_laws[]{{"cycloidal", MotionLawKind::cycloidal},
                                {"cycloid", MotionLawKind::cycloidal},
                                {"bang-bang", MotionLawKind::bang_bang},
                                {"uniform", MotionLawKind::uniform},
                                {"cubic", MotionLawKind::cubic},
                                {"3-4-5", MotionLawKind::polynomial_345},
                                {"poly-345", MotionLawKind::polynomial_345},
                                {"4-5-6-7", MotionLawKind::polynomial_4567},
                                {"poly-4567", MotionLawKind::polynomial_4567},
                                {"harmonic", MotionLawKind::harmonic},
                                {"modified-sine", MotionLawKind::modified_sine},
                                {"modified-trapezoidal", MotionLawKind::modified_trapezoidal},
                                {"trapezoidal-velocity", MotionLawKind::trapezoidal_velocity},
                                {"fastest", MotionLawKind::time_optimal},
                                {"gentlest", MotionLawKind::min_peak},
                                {"steady-momentum", MotionLawKind::constant_momentum}};

}  // namespace

MotionLawKind read_law(const SpecCursor& at) {
  std::vector<std::string> names;
  for (const NamedLaw& law : named_laws) names.emplace_back(law.name);
  return named_laws[at.read_choice("a law of motion", names)].kind;
}

void read_ramps(const SpecCursor& at, StudyBuilder& draft, MotionLawOf<Expression>& law) {
  if (law.kind != MotionLawKind::trapezoidal_velocity)
    at.fail({.expected = "no ramps: only the law 'trapezoidal-velocity' has them"});
  if (at.is_list()) {
    at.items("[ramp up, ramp down]", 2);
    const auto both = read_numbers(at, draft, dimension::dimensionless, "[ramp up, ramp down]");
    law.ramp_up = both[0];
    law.ramp_down = both[1];
  } else {
    law.ramp_up = law.ramp_down = read_number(at, draft, dimension::dimensionless);
  }
  const double up = law.ramp_up.value(), down = law.ramp_down.value();
  if (!(up > 0 && down > 0 && up + down <= 1))
    at.fail({.expected = "ramps > 0 with a sum of at most 1", .found = fmt::format("{} and {}", up, down)});
}

namespace {

/// A number that is never free: the law is no part of a design.
Expression read_bound(const SpecCursor& at, StudyBuilder& draft, Dimension dimension, SignConstraint sign) {
  if (!at.is_scalar()) at.fail_expected("a number or an expression");
  return read_number(at, draft, dimension, sign);
}

bool can_lack_quantities(const SpecErrorCollector& problems) {
  return problems.is_uncertain("joints") || problems.is_uncertain("actuators") || problems.is_uncertain("tool");
}

/// The quantities that a name stands for.
std::vector<LimitableQuantity> find_quantities(const SpecCursor& at, const std::string& name,
                                               const StudyBuilder& draft) {
  std::vector<LimitableQuantity> found = find_limitable_quantities(draft.study.mechanism, name);
  if (!found.empty()) return found;
  if (can_lack_quantities(at.problems())) throw CascadingError();
  if (name == "power" || name.starts_with("power["))
    at.fail({.expected = "a quantity that is affine in the path's acceleration and squared rate",
             .found = fmt::format("{}, a product with the rate", quote_for_message(name))});
  fail_expected_one_of(at, "a quantity that a law can limit", list_limitable_names(draft.study.mechanism));
}

/// `[least, most]` of a scalar.
MotionLimitOf<Expression> read_interval(const SpecCursor& at, const std::string& name,
                                        const std::vector<LimitableQuantity>& quantities, StudyBuilder& draft,
                                        Dimension dimension) {
  if (std::any_of(quantities.begin(), quantities.end(), [](const LimitableQuantity& one) { return one.count > 1; }))
    at.fail({.expected = "one positive number for the magnitude of a vector; a component, such as " + name +
                         "[x], can have [least, most]"});
  const auto both = at.items("a number, or [least, most]", 2);
  MotionLimitOf<Expression> limit{name, read_bound(both[1], draft, dimension, SignConstraint::none),
                                  read_bound(both[0], draft, dimension, SignConstraint::none)};
  if (!(limit.lower_bound->value() < limit.upper_bound.value()))
    at.fail({.expected = "a least value below the largest one",
             .found = fmt::format("{} and {}", both[0].node().text, both[1].node().text)});
  return limit;
}

void read_limits(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  for (const Member& member : list_members(at, "a mapping of quantities to limits"))
    at.problems().collect([&] {
      const auto quantities = find_quantities(member.key, member.name, draft);
      const Dimension dimension = dimension_of_unit(quantities.front().unit);
      if (member.value.is_list())
        trajectory.limits.push_back(read_interval(member.value, member.name, quantities, draft, dimension));
      else
        trajectory.limits.push_back(
            {member.name, read_bound(member.value, draft, dimension, SignConstraint::positive), {}});
    });
  if (at.node().items.empty()) at.fail_expected("at least one limit");
}

/// Of the point along the path; where coordinates are driven the root of the sum of their squared rates.
Dimension speed_dimension(const SpecCursor& at, const TrajectoryOf<Expression>& trajectory, const StudyBuilder& draft) {
  if (trajectory.drive != DriveKind::joints) return dimension::length / dimension::time;
  bool turns = false, slides = false;
  for (const auto& value : trajectory.from.joints) {
    const auto c = static_cast<std::size_t>(value.coordinate);
    (draft.study.mechanism.coordinates[c].kind == CoordinateKind::angle ? turns : slides) = true;
  }
  if (turns && slides)
    at.fail({.expected = "no 'speeds' with a drive of turning and sliding joints, whose rates add up to nothing"});
  return (slides ? dimension::length : dimension::angle) / dimension::time;
}

void read_speeds(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  const Dimension dimension = speed_dimension(at, trajectory, draft);
  const auto both = at.items("[speed at the start, speed at the end]", 2);
  trajectory.start_speed = read_bound(both[0], draft, dimension, SignConstraint::not_negative);
  trajectory.end_speed = read_bound(both[1], draft, dimension, SignConstraint::not_negative);
}

void read_peak_quantities(const SpecCursor& at, const StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  trajectory.min_peak_quantity = at.read_word("a quantity's name");
  find_quantities(at, trajectory.min_peak_quantity, draft);
}

}  // namespace

void read_optimised_law(const SpecCursor& at, const OptimisedLawKeys& text, bool corridor, StudyBuilder& draft,
                        TrajectoryOf<Expression>& trajectory) {
  const MotionLawKind law = trajectory.law.kind;
  SpecErrorCollector& problems = draft.problems;
  if (!is_mechanism_dependent(law) || law == MotionLawKind::constant_momentum) {
    if (text.speeds) text.speeds->fail({.expected = "no such key: only the laws 'fastest' and 'gentlest' have it"});
    if (text.of && !corridor)
      text.of->fail({.expected = "no such key: only the laws 'fastest' and 'gentlest' have it"});
    if (text.limits) problems.collect([&] { read_limits(*text.limits, draft, trajectory); });
    if (!corridor || law == MotionLawKind::constant_momentum) return;
    if (!text.of) at.fail_missing({"of"});
    return read_peak_quantities(*text.of, draft, trajectory);
  }
  if (text.limits) problems.collect([&] { read_limits(*text.limits, draft, trajectory); });
  if (text.speeds) problems.collect([&] { read_speeds(*text.speeds, draft, trajectory); });
  if (law == MotionLawKind::time_optimal) {
    if (text.of) text.of->fail({.expected = "no 'of' with the law 'fastest', which has limits"});
    if (!text.limits) at.fail_missing({"limits"});
    return;
  }
  if (!text.of) at.fail_missing({"of"});
  read_peak_quantities(*text.of, draft, trajectory);
}

namespace {

/// What both `motion` and a trajectory may say.
struct MotionDefaults {
  bool duration_given = false;  ///< rightly or wrongly
  std::optional<Expression> duration;
  std::optional<long> samples;
  std::optional<PoseTargetOf<Expression>> from, to;
  std::optional<SpecCursor> from_at, to_at;
  std::optional<Vector3E> about;
};

std::vector<Field> timing_fields(MotionDefaults& timing, StudyBuilder& draft) {
  return {{"duration", Presence::optional,
           [&](const SpecCursor& c) {
             timing.duration_given = true;
             timing.duration = read_duration(c, draft);
           }},
          {"samples", Presence::optional,
           [&](const SpecCursor& c) { timing.samples = read_integer(c, draft, min_samples, max_samples); }},
          {"from", Presence::optional,
           [&](const SpecCursor& c) {
             timing.from_at = c;
             timing.from = read_pose(c, draft);
           }},
          {"to", Presence::optional,
           [&](const SpecCursor& c) {
             timing.to_at = c;
             timing.to = read_pose(c, draft);
           }},
          {"about", Presence::optional,
           [&](const SpecCursor& c) { timing.about = read_vector(c, draft, dimension::length); }}};
}

std::vector<Component> read_components(const SpecCursor& at, const StudyBuilder& draft, DriveKind drive) {
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
  read_each(at.items("a list of components"), [&](const SpecCursor& item) {
    const Component component = values[item.read_choice("a component", names)];
    if (std::find(components.begin(), components.end(), component) != components.end())
      item.fail({.expected = "every component once", .found = fmt::format("{} again", item.describe_found())});
    components.push_back(component);
  });
  if (components.empty()) at.fail_expected("at least one component");
  return components;
}

/// What only a trajectory says, before its parts are put together.
struct TrajectoryKeys {
  std::optional<SpecCursor> law, drive, path, ramp, ramps, components, remaining, turns;
  OptimisedLawKeys searched;
};

/// Where to complain about a pose that a trajectory has from itself, from `motion` or not at all.
SpecCursor place_of(const std::optional<SpecCursor>& own, const std::optional<SpecCursor>& shared,
                    const SpecCursor& otherwise) {
  return own ? *own : shared ? *shared : otherwise;
}

/// A trajectory being read: what it says, what `motion` says for all, and where it goes.
struct TrajectoryAssembly {
  const SpecCursor& at;
  const TrajectoryKeys& text;
  const MotionDefaults& own;
  const MotionDefaults& shared;
  StudyBuilder& draft;
  TrajectoryOf<Expression>& trajectory;

  const SpecCursor* path() const { return text.path ? &*text.path : nullptr; }
  bool by_table() const { return text.path && is_table(*text.path); }

  /// Whether a key that both may have is missing, or wrong, because of a mistake that is told already.
  bool unread(const char* key, bool own_given, bool shared_given) const {
    const SpecErrorCollector& problems = draft.problems;
    const std::string here = at.path() + "." + key, there = std::string("motion.") + key;
    if (problems.is_invalid(here)) return true;
    return !own_given && (shared_given ? problems.is_invalid(there)
                                       : problems.is_section_invalid(here) || problems.is_section_invalid(there));
  }
};

/// Whole or broken turns of the one joint that is driven, from its start on.
void read_turns(const TrajectoryAssembly& a) {
  auto& trajectory = a.trajectory;
  const SpecCursor& at = *a.text.turns;
  if (trajectory.drive != DriveKind::joints || a.text.path)
    at.fail({.expected = "'turns' with 'drive: joints' and no 'path'; a circle has turns of its own"});
  const auto& joints = trajectory.from.joints;
  const auto& coordinates = a.draft.mechanism().coordinates;
  if (joints.size() != 1 ||
      coordinates[static_cast<std::size_t>(joints.front().coordinate)].kind != CoordinateKind::angle)
    at.fail({.expected = "a start pose (from) of one joint that turns",
             .found = fmt::format("one of {}", joints.size() == 1 ? "a joint that slides" : "several joints")});
  const Expression turns = read_number(at, a.draft, dimension::dimensionless);
  trajectory.to = trajectory.from;
  trajectory.to.joints.front().value = joints.front().value + turns * (2 * std::numbers::pi);
}

void read_poses(const TrajectoryAssembly& a) {
  const MotionDefaults &own = a.own, &shared = a.shared;
  TrajectoryOf<Expression>& trajectory = a.trajectory;
  const SpecCursor* path = a.path();
  const bool goes_on = a.text.turns || !has_end_pose(path);  // and so says where it ends
  if (a.unread("from", own.from_at.has_value(), shared.from_at.has_value())) throw CascadingError();
  if (a.unread("to", own.to_at.has_value(), shared.to_at.has_value()) && !goes_on) throw CascadingError();
  const auto from = own.from ? own.from : shared.from;
  const auto to = own.to ? own.to : shared.to;
  if (from) trajectory.from = *from;
  if (to) trajectory.to = *to;
  if (has_momentum_task(trajectory)) trajectory.to.angle = trajectory.from.angle;  // where it ends is found
  if (a.by_table()) return;
  const DriveRequirements needs{trajectory.drive, trajectory.components};
  if (!from) a.at.fail({.kind = "missing key", .expected = "'from' here or in 'motion'", .found = "none"});
  const bool from_elsewhere = overrides_pose(trajectory.from, trajectory.drive);
  if (!from_elsewhere || path != nullptr)
    check_pose(place_of(own.from_at, shared.from_at, a.at), trajectory.from, needs, a.draft);
  if (a.text.turns) return read_turns(a);
  if (goes_on) {
    trajectory.to = trajectory.from;
    return;
  }
  if (!to) a.at.fail({.kind = "missing key", .expected = "'to' here or in 'motion'", .found = "none"});
  const SpecCursor to_at = place_of(own.to_at, shared.to_at, a.at);
  const bool to_elsewhere = overrides_pose(trajectory.to, trajectory.drive);
  if (!to_elsewhere || path != nullptr) check_pose(to_at, trajectory.to, needs, a.draft);
  if ((!from_elsewhere && !to_elsewhere) || path != nullptr)
    match_pose(to_at, trajectory.to, trajectory.from, trajectory.drive, a.draft);
}

void read_drive(const TrajectoryAssembly& a) {
  if (!a.text.drive) throw CascadingError();
  a.trajectory.drive = static_cast<DriveKind>(a.text.drive->read_choice("a drive", {"joints", "tool", "com"}));
  if (a.trajectory.drive == DriveKind::tool && !a.draft.mechanism().tool)
    a.text.drive->fail_unless_uncertain(
        "tool", {.expected = "a spec with a tool ('tool: body.point') for 'drive: tool'", .found = "none"});
}

void read_trajectory_law(const TrajectoryAssembly& a) {
  if (a.text.law)
    a.trajectory.law.kind = read_law(*a.text.law);
  else if (a.draft.problems.is_uncertain(a.at.path() + ".law"))
    throw CascadingError();
  else if (!a.by_table())
    a.at.fail_missing({"law"});
  if (a.text.ramp && a.text.ramps) a.text.ramps->fail({.expected = "'ramp' or 'ramps'", .found = "both"});
  for (const auto& ramps : {a.text.ramp, a.text.ramps})
    if (ramps) read_ramps(*ramps, a.draft, a.trajectory.law);
}

void read_timing(const TrajectoryAssembly& a) {
  const MotionLawKind law = a.trajectory.law.kind;
  if (law == MotionLawKind::time_optimal && a.own.duration_given)
    a.at.fail({.expected = "no 'duration' with the law 'fastest', which finds it"});
  const auto duration = a.own.duration ? a.own.duration : a.shared.duration;
  const bool unread = a.unread("duration", a.own.duration_given, a.shared.duration_given);
  a.trajectory.duration = duration.value_or(unread ? std::numeric_limits<double>::infinity() : 1.0);
  a.trajectory.samples = a.own.samples.value_or(a.shared.samples.value_or(a.trajectory.samples));
  a.trajectory.about = a.own.about.value_or(a.shared.about.value_or(Vector3E::Zero()));
  if (unread || duration || law == MotionLawKind::time_optimal || (a.by_table() && !is_mechanism_dependent(law)))
    return;
  a.trajectory.duration = std::numeric_limits<double>::infinity();
  a.at.fail({.kind = "missing key", .expected = "'duration' here or in 'motion'", .found = "none"});
}

/// Reads on after a mistake with what does not depend on it.
void assemble_trajectory(const TrajectoryAssembly& a) {
  SpecErrorCollector& problems = a.draft.problems;
  const bool driven = problems.collect([&] { read_drive(a); });
  problems.collect([&] { read_trajectory_law(a); });
  problems.collect([&] { read_timing(a); });
  if (!driven) return;
  const bool chosen = problems.collect([&] {
    if (a.text.components) a.trajectory.components = read_components(*a.text.components, a.draft, a.trajectory.drive);
  });
  problems.collect([&] {
    if (a.text.remaining) read_secondary_tasks(*a.text.remaining, a.draft, a.trajectory);
  });
  const bool posed = chosen && problems.collect([&] { read_poses(a); });
  const bool corridor = a.text.path && is_corridor(*a.text.path);
  problems.collect([&] { read_optimised_law(a.at, a.text.searched, corridor, a.draft, a.trajectory); });
  if (chosen && a.text.path && (posed || (is_circle(*a.text.path) && a.trajectory.drive != DriveKind::joints)))
    problems.collect([&] { read_path(*a.text.path, a.draft, a.trajectory); });
  const SpecCursor from = place_of(a.own.from_at, a.shared.from_at, a.at),
                   to = place_of(a.own.to_at, a.shared.to_at, a.at);
  problems.collect([&] {
    check_temporary_payloads({a.at, a.text.drive, a.text.law, a.text.searched.limits, from, to}, a.draft, a.trajectory);
  });
}

void read_trajectory(const Member& member, const MotionDefaults& shared, StudyBuilder& draft) {
  TrajectoryOf<Expression> trajectory;
  trajectory.name = member.name;
  TrajectoryKeys text;
  MotionDefaults own;
  const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
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
    fields.push_back({name, Presence::optional, keep(*slot)});
  fields.push_back({"drive", Presence::required, keep(text.drive)});
  read_fields(member.value, "a trajectory {law, drive}", fields);
  if (member.value.is_map()) assemble_trajectory({member.value, text, own, shared, draft, trajectory});
  // Even if it is wrong its name is known.
  draft.trajectories().push_back(std::move(trajectory));
}

/// `cycloid` and `bang-bang` exist whenever `motion` says from where to where. What they drive is what it says.
void add_built_in(const SpecCursor& motion, const MotionDefaults& timing, const char* name, MotionLawKind law,
                  StudyBuilder& draft) {
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
  trajectory.drive = law == MotionLawKind::bang_bang && by_tool ? DriveKind::com : moved;
  if (moved == DriveKind::com) require_permanent_payloads(*timing.from_at, "a pose by 'joints' or 'tool'", draft);
  // the centre of mass would jump: nobody asked for this trajectory by name
  if (trajectory.drive == DriveKind::com && !draft.study.temporary_payloads.empty()) return;
  match_pose(*timing.to_at, to, from, moved, draft);
  if (!timing.duration) motion.fail_missing({"duration"});
  trajectory.from = from;
  trajectory.to = to;
  trajectory.duration = *timing.duration;
  trajectory.samples = timing.samples.value_or(trajectory.samples);
  trajectory.about = timing.about.value_or(Vector3E::Zero());
  draft.trajectories().push_back(std::move(trajectory));
}

/// Without declared trajectories a motion must say from where to where.
void require_end_poses(const SpecCursor& motion, const MotionDefaults& timing) {
  if (motion.problems().is_section_invalid("trajectories")) throw CascadingError();
  for (const auto& [pose, name] : {std::pair{&timing.from, "from"}, {&timing.to, "to"}})
    motion.problems().collect([&, &pose = pose, &name = name] {
      if (!*pose) motion.fail_missing({name});
    });
}

}  // namespace

void read_trajectories(const SpecCursor* motion, const SpecCursor* trajectories, StudyBuilder& draft) {
  MotionDefaults shared;
  SpecErrorCollector& problems = draft.problems;
  bool read = motion == nullptr || read_fields(*motion, "a motion {duration, from, to}", timing_fields(shared, draft));
  if (trajectories != nullptr) {
    const bool known = problems.collect([&] {
      for (const Member& member : list_named_members(*trajectories, "a mapping of trajectories", NameForm::simple))
        read_trajectory(member, shared, draft);
    });
    read = read && known;
  }
  if (motion == nullptr) return;
  const bool known = read && problems.collect([&] {
    const bool declared = !draft.trajectories().empty();
    if (!declared) require_end_poses(*motion, shared);
    if (!shared.from || !shared.to) return;
    // A motion that only serves declared trajectories need not carry the built-in ones.
    if (declared && !shared.duration) return;
    add_built_in(*motion, shared, "cycloid", MotionLawKind::cycloidal, draft);
    add_built_in(*motion, shared, "bang-bang", MotionLawKind::bang_bang, draft);
  });
  if (!known) problems.mark_invalid("motion");
}

}  // namespace balance::specification
