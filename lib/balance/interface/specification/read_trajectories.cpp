#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_adaptations.hpp"
#include "balance/interface/specification/read_free_motion.hpp"
#include "balance/interface/specification/read_law.hpp"
#include "balance/interface/specification/read_measured.hpp"
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

// Limits of a motion, and keys of optimised laws only: the quantity with minimum peak, speeds at both ends.

/// Their values in a trajectory.
struct OptimisedLawKeys {
  std::optional<SpecCursor> limits, quantity, speeds;
};

/// Reads them into the trajectory, whose law and drive are known. Fails if the law lacks a key that it needs, or has
/// one that it does not allow.
/// @param at the trajectory @param corridor whether its path is one: any law may then name a quantity with minimum peak
void read_optimised_law(const SpecCursor& at, const OptimisedLawKeys& keys, bool corridor, StudyBuilder& draft,
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

void read_ramps(const SpecCursor& at, StudyBuilder& draft, trajectory::MotionLawOf<Expression>& law) {
  if (law.kind != MotionLawKind::trapezoidal_velocity)
    at.fail({.expected = "no ramps: only the law 'trapezoidal-velocity' has them"});
  if (at.is_list()) {
    at.items("[ramp up, ramp down]", 2);
    const auto ramps = read_numbers(at, draft, dimension::dimensionless, "[ramp up, ramp down]");
    law.ramp_up = ramps[0];
    law.ramp_down = ramps[1];
  } else {
    law.ramp_up = law.ramp_down = read_number(at, draft, dimension::dimensionless);
  }
  const double up = law.ramp_up.value(), down = law.ramp_down.value();
  if (!(up > 0 && down > 0 && up + down <= 1))
    at.fail({.expected = "ramps > 0 with a sum of at most 1", .found = fmt::format("{} and {}", up, down)});
}

namespace {

/// A number that cannot be free: the law is not part of a design.
Expression read_bound(const SpecCursor& at, StudyBuilder& draft, Dimension dimension, SignConstraint sign) {
  if (!at.is_scalar()) at.fail_expected("a number or an expression");
  return read_number(at, draft, dimension, sign);
}

bool can_lack_quantities(const SpecErrorCollector& problems) {
  return problems.is_uncertain("joints") || problems.is_uncertain("actuators") || problems.is_uncertain("tool");
}

/// The quantities that a name stands for.
std::vector<results::LimitableQuantity> find_quantities(const SpecCursor& at, const std::string& name,
                                                        const StudyBuilder& draft) {
  std::vector<results::LimitableQuantity> quantities = results::find_limitable_quantities(draft.study.mechanism, name);
  if (!quantities.empty()) return quantities;
  if (can_lack_quantities(at.problems())) throw CascadingError();
  if (name == "power" || name.starts_with("power["))
    at.fail({.expected = "a quantity that is affine in the path's acceleration and squared rate",
             .found = fmt::format("{}, a product with the rate", quote_for_message(name))});
  fail_expected_one_of(at, "a quantity that a law can limit", results::list_limitable_names(draft.study.mechanism));
}

/// `[minimum, maximum]` of a scalar.
trajectory::MotionLimitOf<Expression> read_interval(const SpecCursor& at, const std::string& name,
                                                    const std::vector<results::LimitableQuantity>& quantities,
                                                    StudyBuilder& draft, Dimension dimension) {
  if (std::any_of(quantities.begin(), quantities.end(),
                  [](const results::LimitableQuantity& one) { return one.count > 1; }))
    at.fail({.expected = "one positive number for the magnitude of a vector; a component, such as " + name +
                         "[x], can have [least, most]"});
  const auto bounds = at.items("a number, or [least, most]", 2);
  trajectory::MotionLimitOf<Expression> limit{name, read_bound(bounds[1], draft, dimension, SignConstraint::none),
                                              read_bound(bounds[0], draft, dimension, SignConstraint::none)};
  if (!(limit.lower_bound->value() < limit.upper_bound.value()))
    at.fail({.expected = "a lower limit below the upper limit",
             .found = fmt::format("{} and {}", bounds[0].node().text, bounds[1].node().text)});
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

/// Dimension of the speed of the point along the path; if coordinates are driven, of the root of the
/// sum of their squared rates.
Dimension speed_dimension(const SpecCursor& at, const TrajectoryOf<Expression>& trajectory, const StudyBuilder& draft) {
  if (trajectory.drive != DriveKind::joints) return dimension::length / dimension::time;
  bool turns = false, slides = false;
  for (const auto& value : trajectory.from.joints) {
    const auto c = static_cast<std::size_t>(value.coordinate);
    (draft.study.mechanism.coordinates[c].kind == CoordinateKind::angle ? turns : slides) = true;
  }
  if (turns && slides)
    at.fail({.expected = "no 'speeds' with a drive of both turning and sliding joints, whose rates cannot be added"});
  return (slides ? dimension::length : dimension::angle) / dimension::time;
}

void read_speeds(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  const Dimension dimension = speed_dimension(at, trajectory, draft);
  const auto end_speeds = at.items("[speed at the start, speed at the end]", 2);
  trajectory.start_speed = read_bound(end_speeds[0], draft, dimension, SignConstraint::not_negative);
  trajectory.end_speed = read_bound(end_speeds[1], draft, dimension, SignConstraint::not_negative);
}

void read_peak_quantities(const SpecCursor& at, const StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  trajectory.min_peak_quantity = at.read_word("a quantity's name");
  find_quantities(at, trajectory.min_peak_quantity, draft);
}

}  // namespace

void read_optimised_law(const SpecCursor& at, const OptimisedLawKeys& keys, bool corridor, StudyBuilder& draft,
                        TrajectoryOf<Expression>& trajectory) {
  const MotionLawKind law = trajectory.law.kind;
  SpecErrorCollector& problems = draft.problems;
  if (!is_mechanism_dependent(law) || law == MotionLawKind::constant_momentum) {
    if (keys.speeds) keys.speeds->fail({.expected = "no such key: only the laws 'fastest' and 'gentlest' have it"});
    if (keys.quantity && !corridor)
      keys.quantity->fail({.expected = "no such key: only the laws 'fastest' and 'gentlest' have it"});
    if (keys.limits) problems.collect([&] { read_limits(*keys.limits, draft, trajectory); });
    if (!corridor || law == MotionLawKind::constant_momentum) return;
    if (!keys.quantity) at.fail_missing({"of"});
    return read_peak_quantities(*keys.quantity, draft, trajectory);
  }
  if (keys.limits) problems.collect([&] { read_limits(*keys.limits, draft, trajectory); });
  if (keys.speeds) problems.collect([&] { read_speeds(*keys.speeds, draft, trajectory); });
  if (law == MotionLawKind::time_optimal) {
    if (keys.quantity) keys.quantity->fail({.expected = "no 'of' with the law 'fastest', which has limits"});
    if (!keys.limits) at.fail_missing({"limits"});
    return;
  }
  if (!keys.quantity) at.fail_missing({"of"});
  read_peak_quantities(*keys.quantity, draft, trajectory);
}

namespace {

/// Keys that both `motion` and a trajectory may have.
struct MotionDefaults {
  bool duration_given = false;  ///< correctly or not
  std::optional<Expression> duration;
  std::optional<long> samples;
  std::optional<trajectory::PoseTargetOf<Expression>> from, to;
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
           [&](const SpecCursor& c) {
             timing.samples = read_integer(c, draft, trajectory::min_samples, trajectory::max_samples);
           }},
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

std::vector<trajectory::Component> read_components(const SpecCursor& at, const StudyBuilder& draft, DriveKind drive) {
  const bool planar = draft.planar();
  using enum trajectory::Component;
  if (drive == DriveKind::joints)
    at.fail({.expected = "no 'components' with 'drive: joints', which names its coordinates itself"});
  std::vector<std::string> names =
      planar ? std::vector<std::string>{"x", "y", "angle"} : std::vector<std::string>{"x", "y", "z", "rx", "ry", "rz"};
  if (drive == DriveKind::com) names.resize(planar ? 2 : 3);
  const std::vector<trajectory::Component> values =
      planar ? std::vector<trajectory::Component>{x, y, rz} : std::vector<trajectory::Component>{x, y, z, rx, ry, rz};
  std::vector<trajectory::Component> components;
  read_each(at.items("a list of components"), [&](const SpecCursor& item) {
    const trajectory::Component component = values[item.read_choice("a component", names)];
    if (std::find(components.begin(), components.end(), component) != components.end())
      item.fail({.expected = "each component only once", .found = fmt::format("{} again", item.describe_found())});
    components.push_back(component);
  });
  if (components.empty()) at.fail_expected("at least one component");
  return components;
}

constexpr const char* nothing_driven = "none";

/// Keys that only a trajectory has, before they are assembled.
struct TrajectoryKeys {
  std::optional<SpecCursor> law, drive, path, ramp, ramps, components, remaining, turns, speed, adapt;
  OptimisedLawKeys optimised_law;
  FreeMotionKeys free_motion;
};

/// Where to report a pose that comes from a trajectory itself, from `motion` or from neither.
SpecCursor place_of(const std::optional<SpecCursor>& own_entry, const std::optional<SpecCursor>& default_entry,
                    const SpecCursor& fallback) {
  return own_entry ? *own_entry : default_entry ? *default_entry : fallback;
}

/// A trajectory being read: its own keys, the defaults of `motion`, and the result.
struct TrajectoryAssembly {
  const SpecCursor& at;
  const TrajectoryKeys& keys;
  const MotionDefaults& timing;
  const MotionDefaults& defaults;
  StudyBuilder& draft;
  TrajectoryOf<Expression>& trajectory;

  const SpecCursor* path() const { return keys.path ? &*keys.path : nullptr; }
  bool has_table() const { return keys.path && is_table(*keys.path); }
  /// Whether everything that moves is free.
  bool drives_nothing() const { return keys.drive && keys.drive->node().text == nothing_driven; }

  /// Whether a key that both may have is missing, or wrong, because of a mistake that is already reported.
  bool is_unread(const char* key, bool is_given, bool is_default_given) const {
    const SpecErrorCollector& problems = draft.problems;
    const std::string own_path = at.path() + "." + key, default_path = std::string("motion.") + key;
    if (problems.is_invalid(own_path)) return true;
    return !is_given &&
           (is_default_given ? problems.is_invalid(default_path)
                             : problems.is_section_invalid(own_path) || problems.is_section_invalid(default_path));
  }
};

/// Constant rates of joints, for a number of turns of the first one. Joints without a rate stay where they start.
void read_constant_speed(const TrajectoryAssembly& assembly) {
  auto& trajectory = assembly.trajectory;
  const SpecCursor& at = *assembly.keys.speed;
  if (trajectory.drive != DriveKind::joints || assembly.keys.path)
    at.fail({.expected = "'speed' only with 'drive: joints' and without 'path'"});
  const auto speeds = list_members(at, "a mapping of joint coordinates to speeds");
  if (speeds.empty()) at.fail_expected("at least one speed");
  const double turn = 2 * std::numbers::pi;
  const Expression turns =
      assembly.keys.turns ? read_number(*assembly.keys.turns, assembly.draft, dimension::dimensionless) : Expression(1);
  if (!(turns.value() > 0))
    assembly.keys.turns->fail({.expected = "a positive number of turns", .found = fmt::format("{}", turns.value())});
  trajectory.to = trajectory.from;
  for (const Member& member : speeds) {
    const CoordinateId coordinate = find_coordinate(member.key, member.name, assembly.draft);
    const auto start = std::find_if(trajectory.to.joints.begin(), trajectory.to.joints.end(),
                                    [&](const auto& joint) { return joint.coordinate == coordinate; });
    if (assembly.draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].kind != CoordinateKind::angle)
      member.key.fail({.expected = "a joint that turns: a slide cannot go on at constant speed",
                       .found = quote_for_message(member.name)});
    if (start == trajectory.to.joints.end())
      member.key.fail({.expected = "a joint of the start pose (from)", .found = quote_for_message(member.name)});
    const Expression speed = read_number(member.value, assembly.draft, dimension::angle / dimension::time);
    if (speed.value() == 0)
      member.value.fail({.expected = "a speed other than zero: a joint without a speed stays where it starts"});
    if (&member == &speeds.front()) trajectory.duration = turns * turn / (speed.value() < 0 ? -speed : speed);
    start->value = start->value + speed * trajectory.duration;
  }
}

/// Turns of the one joint that is driven, whole or not, from its start.
void read_turns(const TrajectoryAssembly& assembly) {
  auto& trajectory = assembly.trajectory;
  const SpecCursor& at = *assembly.keys.turns;
  if (trajectory.drive != DriveKind::joints || assembly.keys.path)
    at.fail({.expected = "'turns' only with 'drive: joints' and without 'path'; a circle has its own turns"});
  const auto& joints = trajectory.from.joints;
  const auto& coordinates = assembly.draft.mechanism().coordinates;
  if (joints.size() != 1 ||
      coordinates[static_cast<std::size_t>(joints.front().coordinate)].kind != CoordinateKind::angle)
    at.fail({.expected = "a start pose (from) of one joint that turns",
             .found = fmt::format("one of {}", joints.size() == 1 ? "a joint that slides" : "several joints")});
  const Expression turns = read_number(at, assembly.draft, dimension::dimensionless);
  trajectory.to = trajectory.from;
  trajectory.to.joints.front().value = joints.front().value + turns * (2 * std::numbers::pi);
}

/// A motion that is left to the dynamics begins where its free coordinates do.
void require_nothing_driven(const TrajectoryAssembly& assembly) {
  const TrajectoryKeys& keys = assembly.keys;
  if (!keys.free_motion.free)
    keys.drive->fail({.expected = "with 'drive: none' 'free', the coordinates that move", .found = "none"});
  for (const auto& [key, name] : {std::pair{&keys.path, "path"},
                                  {&keys.speed, "speed"},
                                  {&keys.turns, "turns"},
                                  {&keys.components, "components"},
                                  {&keys.remaining, "remaining"},
                                  {&keys.adapt, "adapt"},
                                  {&assembly.timing.from_at, "from"},
                                  {&assembly.timing.to_at, "to"}})
    if (*key)
      (*key)->fail({.expected = fmt::format("no '{}' with 'drive: none', where nothing is driven; where free and held "
                                            "coordinates start stands under 'initial'",
                                            name)});
}

void read_poses(const TrajectoryAssembly& assembly) {
  if (assembly.drives_nothing()) return require_nothing_driven(assembly);
  const MotionDefaults &timing = assembly.timing, &defaults = assembly.defaults;
  TrajectoryOf<Expression>& trajectory = assembly.trajectory;
  const SpecCursor* path = assembly.path();
  const bool is_end_implied =
      assembly.keys.turns || assembly.keys.speed || !has_end_pose(path);  // which determines its end
  if (assembly.is_unread("from", timing.from_at.has_value(), defaults.from_at.has_value())) throw CascadingError();
  if (assembly.is_unread("to", timing.to_at.has_value(), defaults.to_at.has_value()) && !is_end_implied)
    throw CascadingError();
  const auto from = timing.from ? timing.from : defaults.from;
  const auto to = timing.to ? timing.to : defaults.to;
  if (from) trajectory.from = *from;
  if (to) trajectory.to = *to;
  if (has_momentum_task(trajectory)) trajectory.to.angle = trajectory.from.angle;  // its end is found
  if (assembly.has_table()) return;
  const DriveRequirements requirements{trajectory.drive, trajectory.components};
  if (!from)
    assembly.at.fail({.kind = "missing key",
                      .expected = assembly.keys.free_motion.free
                                      ? "'from' here or in 'motion', or 'drive: none' if nothing is driven"
                                      : "'from' here or in 'motion'",
                      .found = "none"});
  const bool is_from_derived = overrides_pose(trajectory.from, trajectory.drive);
  if (!is_from_derived || path != nullptr)
    check_pose(place_of(timing.from_at, defaults.from_at, assembly.at), trajectory.from, requirements, assembly.draft);
  if (assembly.keys.speed) return read_constant_speed(assembly);
  if (assembly.keys.turns) return read_turns(assembly);
  if (is_end_implied) {
    trajectory.to = trajectory.from;
    return;
  }
  if (!to) assembly.at.fail({.kind = "missing key", .expected = "'to' here or in 'motion'", .found = "none"});
  const SpecCursor to_at = place_of(timing.to_at, defaults.to_at, assembly.at);
  const bool is_to_derived = overrides_pose(trajectory.to, trajectory.drive);
  if (!is_to_derived || path != nullptr) check_pose(to_at, trajectory.to, requirements, assembly.draft);
  if ((!is_from_derived && !is_to_derived) || path != nullptr)
    match_pose(to_at, trajectory.to, trajectory.from, trajectory.drive, assembly.draft);
}

void read_drive(const TrajectoryAssembly& assembly) {
  if (!assembly.keys.drive) throw CascadingError();
  const std::size_t choice = assembly.keys.drive->read_choice("a drive", {"joints", "tool", "com", nothing_driven});
  assembly.trajectory.drive = assembly.drives_nothing() ? DriveKind::joints : static_cast<DriveKind>(choice);
  if (assembly.trajectory.drive == DriveKind::tool && !assembly.draft.mechanism().tool)
    assembly.keys.drive->fail_unless_uncertain(
        "tool", {.expected = "a spec with a tool ('tool: body.point') for 'drive: tool'", .found = "none"});
}

void read_trajectory_law(const TrajectoryAssembly& assembly) {
  if (assembly.keys.speed || assembly.drives_nothing()) assembly.trajectory.law.kind = MotionLawKind::uniform;
  if (assembly.drives_nothing()) {
    for (const auto& key : {assembly.keys.law, assembly.keys.ramp, assembly.keys.ramps})
      if (key) key->fail({.expected = "no law with 'drive: none', where nothing is driven"});
    return;
  }
  if (assembly.keys.law) {
    assembly.trajectory.law.kind = read_law(*assembly.keys.law);
    if (assembly.keys.speed && assembly.trajectory.law.kind != MotionLawKind::uniform)
      assembly.keys.law->fail({.expected = "'uniform' or no law with 'speed', which is constant",
                               .found = assembly.keys.law->describe_found()});
  } else if (assembly.keys.speed)
    return;
  else if (assembly.draft.problems.is_uncertain(assembly.at.path() + ".law"))
    throw CascadingError();
  else if (!assembly.has_table())
    assembly.at.fail_missing({"law"});
  if (assembly.keys.ramp && assembly.keys.ramps)
    assembly.keys.ramps->fail({.expected = "'ramp' or 'ramps'", .found = "both"});
  for (const auto& ramps : {assembly.keys.ramp, assembly.keys.ramps})
    if (ramps) read_ramps(*ramps, assembly.draft, assembly.trajectory.law);
}

void read_timing(const TrajectoryAssembly& assembly) {
  const MotionLawKind law = assembly.trajectory.law.kind;
  if (law == MotionLawKind::time_optimal && assembly.timing.duration_given)
    assembly.at.fail({.expected = "no 'duration' with the law 'fastest', which determines it"});
  if (assembly.keys.speed && assembly.timing.duration_given)
    assembly.at.fail({.expected = "no 'duration' with 'speed', which determines it together with 'turns'"});
  const auto duration = assembly.timing.duration ? assembly.timing.duration : assembly.defaults.duration;
  const bool is_duration_unread =
      assembly.is_unread("duration", assembly.timing.duration_given, assembly.defaults.duration_given);
  assembly.trajectory.duration = duration.value_or(is_duration_unread ? std::numeric_limits<double>::infinity() : 1.0);
  assembly.trajectory.samples =
      assembly.timing.samples.value_or(assembly.defaults.samples.value_or(assembly.trajectory.samples));
  assembly.trajectory.about = assembly.timing.about.value_or(assembly.defaults.about.value_or(Vector3E::Zero()));
  if (is_duration_unread || duration || assembly.keys.speed || law == MotionLawKind::time_optimal ||
      (assembly.has_table() && !is_mechanism_dependent(law)))
    return;
  assembly.trajectory.duration = std::numeric_limits<double>::infinity();
  assembly.at.fail({.kind = "missing key", .expected = "'duration' here or in 'motion'", .found = "none"});
}

/// Continues after a mistake with what does not depend on it.
void assemble_trajectory(const TrajectoryAssembly& assembly) {
  SpecErrorCollector& problems = assembly.draft.problems;
  const bool is_drive_read = problems.collect([&] { read_drive(assembly); });
  problems.collect([&] { read_trajectory_law(assembly); });
  problems.collect([&] { read_timing(assembly); });
  if (!is_drive_read) return;
  const bool are_components_read = problems.collect([&] {
    if (assembly.keys.components)
      assembly.trajectory.components =
          read_components(*assembly.keys.components, assembly.draft, assembly.trajectory.drive);
  });
  problems.collect([&] {
    if (assembly.keys.remaining) read_secondary_tasks(*assembly.keys.remaining, assembly.draft, assembly.trajectory);
  });
  const bool are_poses_read = are_components_read && problems.collect([&] { read_poses(assembly); });
  const bool corridor = assembly.keys.path && is_corridor(*assembly.keys.path);
  problems.collect([&] {
    read_optimised_law(assembly.at, assembly.keys.optimised_law, corridor, assembly.draft, assembly.trajectory);
  });
  if (are_components_read && assembly.keys.path &&
      (are_poses_read || (is_circle(*assembly.keys.path) && assembly.trajectory.drive != DriveKind::joints)))
    problems.collect([&] { read_path(*assembly.keys.path, assembly.draft, assembly.trajectory); });
  problems.collect([&] {
    if (assembly.keys.adapt) read_adaptations(*assembly.keys.adapt, assembly.draft, assembly.trajectory);
  });
  problems.collect([&] { read_free_motion(assembly.keys.free_motion, assembly.draft, assembly.trajectory); });
  const SpecCursor from = place_of(assembly.timing.from_at, assembly.defaults.from_at, assembly.at),
                   to = place_of(assembly.timing.to_at, assembly.defaults.to_at, assembly.at);
  problems.collect([&] {
    check_temporary_payloads(
        {assembly.at, assembly.keys.drive, assembly.keys.law, assembly.keys.optimised_law.limits, from, to},
        assembly.draft, assembly.trajectory);
  });
}

/// A trajectory that follows a record has no other keys than these.
void read_measured_trajectory(const SpecCursor& at, const MotionDefaults& defaults, StudyBuilder& draft,
                              TrajectoryOf<Expression>& trajectory) {
  std::optional<SpecCursor> measured;
  std::optional<long> samples;
  trajectory.about = defaults.about.value_or(Vector3E::Zero());
  const bool is_read =
      read_fields(at, "a trajectory {measured: {file: log.csv}}",
                  {{"measured", Presence::required, [&](const SpecCursor& c) { measured = c; }},
                   {"samples", Presence::optional,
                    [&](const SpecCursor& c) {
                      samples = read_integer(c, draft, trajectory::min_samples, trajectory::max_samples);
                    }},
                   {"about", Presence::optional,
                    [&](const SpecCursor& c) { trajectory.about = read_vector(c, draft, dimension::length); }}});
  if (!is_read) return;
  draft.problems.collect([&] { read_measured(*measured, draft, trajectory); });
  if (samples) trajectory.samples = *samples;
}

void read_trajectory(const Member& member, const MotionDefaults& defaults, StudyBuilder& draft) {
  TrajectoryOf<Expression> trajectory;
  trajectory.name = member.name;
  if (member.value.has_entry("measured")) {
    read_measured_trajectory(member.value, defaults, draft, trajectory);
    draft.trajectories().push_back(std::move(trajectory));
    return;
  }
  TrajectoryKeys keys;
  MotionDefaults timing;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  auto fields = timing_fields(timing, draft);
  for (auto& [name, slot] : {std::pair{"law", &keys.law},
                             {"path", &keys.path},
                             {"ramp", &keys.ramp},
                             {"ramps", &keys.ramps},
                             {"components", &keys.components},
                             {"remaining", &keys.remaining},
                             {"turns", &keys.turns},
                             {"speed", &keys.speed},
                             {"adapt", &keys.adapt},
                             {"limits", &keys.optimised_law.limits},
                             {"of", &keys.optimised_law.quantity},
                             {"speeds", &keys.optimised_law.speeds},
                             {"free", &keys.free_motion.free},
                             {"hold", &keys.free_motion.hold},
                             {"initial", &keys.free_motion.initial}})
    fields.push_back({name, Presence::optional, store_in(*slot)});
  fields.push_back({"measured", Presence::optional, [](const SpecCursor&) {}});  // read_measured_trajectory
  fields.push_back({"drive", Presence::required, store_in(keys.drive)});
  read_fields(member.value, "a trajectory {law, drive}", fields);
  if (member.value.is_map()) assemble_trajectory({member.value, keys, timing, defaults, draft, trajectory});
  // even if it is wrong, its name is known
  draft.trajectories().push_back(std::move(trajectory));
}

/// `cycloid` and `bang-bang` exist whenever `motion` has both end poses, which determine what they drive.
void add_built_in(const SpecCursor& motion, const MotionDefaults& timing, const char* name, MotionLawKind law,
                  StudyBuilder& draft) {
  const auto& trajectories = draft.trajectories();
  if (std::any_of(trajectories.begin(), trajectories.end(),
                  [&](const TrajectoryOf<Expression>& t) { return t.name == name; }))
    return;
  const trajectory::PoseTargetOf<Expression>& from = *timing.from;
  trajectory::PoseTargetOf<Expression> to = *timing.to;
  TrajectoryOf<Expression> trajectory;
  trajectory.name = name;
  trajectory.law.kind = law;
  const bool has_tool_poses = from.tool && to.tool;
  const bool has_joint_poses = !from.joints.empty() && !to.joints.empty();
  if (!has_tool_poses && !has_joint_poses && !(from.com && to.com))
    timing.to_at->fail(
        {.expected = "the same key ('tool', 'joints' or 'com') in 'from' and 'to'", .found = "different ones"});
  const DriveKind drive_kind = has_tool_poses ? DriveKind::tool : has_joint_poses ? DriveKind::joints : DriveKind::com;
  trajectory.drive = law == MotionLawKind::bang_bang && has_tool_poses ? DriveKind::com : drive_kind;
  if (drive_kind == DriveKind::com) require_permanent_payloads(*timing.from_at, "a pose by 'joints' or 'tool'", draft);
  // the centre of mass would jump, and nobody asked for this trajectory by name
  if (trajectory.drive == DriveKind::com && !draft.study.temporary_payloads.empty()) return;
  match_pose(*timing.to_at, to, from, drive_kind, draft);
  if (!timing.duration) motion.fail_missing({"duration"});
  trajectory.from = from;
  trajectory.to = to;
  trajectory.duration = *timing.duration;
  trajectory.samples = timing.samples.value_or(trajectory.samples);
  trajectory.about = timing.about.value_or(Vector3E::Zero());
  draft.trajectories().push_back(std::move(trajectory));
}

/// Without declared trajectories a motion must have both end poses.
void require_end_poses(const SpecCursor& motion, const MotionDefaults& timing) {
  if (motion.problems().is_section_invalid("trajectories")) throw CascadingError();
  for (const auto& [pose, name] : {std::pair{&timing.from, "from"}, {&timing.to, "to"}})
    motion.problems().collect([&, &pose = pose, &name = name] {
      if (!*pose) motion.fail_missing({name});
    });
}

}  // namespace

void read_trajectories(const SpecCursor* motion, const SpecCursor* trajectories, StudyBuilder& draft) {
  MotionDefaults defaults;
  SpecErrorCollector& problems = draft.problems;
  bool read =
      motion == nullptr || read_fields(*motion, "a motion {duration, from, to}", timing_fields(defaults, draft));
  if (trajectories != nullptr) {
    const bool are_trajectories_valid = problems.collect([&] {
      for (const Member& member : list_named_members(*trajectories, "a mapping of trajectories", NameForm::simple))
        read_trajectory(member, defaults, draft);
    });
    read = read && are_trajectories_valid;
  }
  if (motion == nullptr) return;
  const bool is_motion_valid = read && problems.collect([&] {
    const bool declared = !draft.trajectories().empty();
    if (!declared) require_end_poses(*motion, defaults);
    if (!defaults.from || !defaults.to) return;
    // a motion with defaults for declared trajectories does not imply the built-in ones
    if (declared && !defaults.duration) return;
    add_built_in(*motion, defaults, "cycloid", MotionLawKind::cycloidal, draft);
    add_built_in(*motion, defaults, "bang-bang", MotionLawKind::bang_bang, draft);
  });
  if (!is_motion_valid) problems.mark_invalid("motion");
}

}  // namespace balance::specification
