#include "balance/interface/specification/read_document.hpp"

#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/specification/free_number.hpp"
#include "balance/interface/specification/include_expansion.hpp"
#include "balance/interface/specification/read_bushings.hpp"
#include "balance/interface/specification/read_design.hpp"
#include "balance/interface/specification/read_load_cases.hpp"
#include "balance/interface/specification/read_shape.hpp"
#include "balance/interface/specification/read_temporary_payloads.hpp"
#include "balance/interface/specification/read_tolerance_section.hpp"
#include "balance/interface/specification/read_workspace.hpp"
#include "balance/interface/specification/spec_rewrites.hpp"
#include "balance/interface/specification/spec_units.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/motion/study/different_numbers.hpp"
#include "balance/motion/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

namespace balance::specification {

// Numbers that are valid but implausible, mostly because of a missing unit.

/// One sentence for each kind of number that exceeds those of usual mechanisms.
/// @param units in which the study was written
std::vector<std::string> list_implausible_numbers(const Study& study, const Units& units);

namespace {

constexpr double max_plausible_size = 60;      // [m]: only the booms of the largest cranes are longer
constexpr double max_plausible_density = 2e4;  // [kg/m^3]: gold
constexpr double max_plausible_turns = 2;      // of a joint at the start, for which one is enough
constexpr double earth_gravity = 9.81;         // [m/s^2]
constexpr double max_plausible_gravity = 5 * earth_gravity;

void check_plausible_size(const Study& study, const Units& units, std::vector<std::string>& warnings) {
  const double size = characteristic_length(study.mechanism), mass = total_mass(study.mechanism);
  if (size > max_plausible_size)
    warnings.push_back(fmt::format(
        "the mechanism's largest dimension is {:.4g} m: are its lengths in {}?", size,
        units.length == 1 ? "millimetres (`units: {length: mm}`)" : "the unit of length that `units` names"));
  // A mechanism fits into a box of four times its largest dimension.
  if (const double edge = 4 * size; mass > max_plausible_density * edge * edge * edge)
    warnings.push_back(
        fmt::format("the mechanism's largest dimension is {:.4g} m, its mass {:.4g} kg: denser than any metal; are the "
                    "units right?",
                    size, mass));
}

/// No body's inertia exceeds that of the total mass at a distance of four times the mechanism's size.
void check_plausible_inertias(const Study& study, std::vector<std::string>& warnings) {
  const double edge = 4 * characteristic_length(study.mechanism), mass = total_mass(study.mechanism);
  for (const Body& body : study.mechanism.bodies) {
    const double largest = numerics::max_abs(body.inertia);
    if (body.mass == 0 || largest <= mass * edge * edge) continue;
    warnings.push_back(
        fmt::format("bodies.{}: an inertia of {:.4g} kg m^2 with a mass of {:.4g} kg is that of a body of more "
                    "than {:.3g} m: are the units right?",
                    body.name, largest, body.mass, edge));
    return;
  }
}

void check_plausible_gravity(const Study& study, const Units& units, std::vector<std::string>& warnings) {
  const double gravity = study.mechanism.gravity.norm(), unit = units.factor(dimension::acceleration);
  if (unit != 1 && std::abs(gravity / unit - earth_gravity) < 0.02)
    warnings.push_back("gravity: 9.81 in the spec's units is not the earth's gravity; in millimetres it would be 9810");
  else if (gravity > max_plausible_gravity)
    warnings.push_back(fmt::format("gravity: {:.4g} m/s^2 is {:.3g} times the earth's; are the units right?", gravity,
                                   gravity / earth_gravity));
}

void check_plausible_angles(const Study& study, const Units& units, std::vector<std::string>& warnings) {
  const double max_angle = max_plausible_turns * 2 * std::numbers::pi;
  const auto check_angles = [&](const std::string& path, const std::vector<CoordinateValue>& values) {
    for (const CoordinateValue& value : values) {
      const Coordinate& coordinate = study.mechanism.coordinates[value.coordinate];
      if (coordinate.kind != CoordinateKind::angle || std::abs(value.value) <= max_angle) continue;
      warnings.push_back(
          fmt::format("{}: {} is {:.4g} rad, {:.3g} turns: {}", path, coordinate.name, value.value,
                      value.value / (2 * std::numbers::pi),
                      units.angle == 1 ? "is it in degrees (`units: {angle: deg}`)?" : "is the unit of angles right?"));
      return;
    }
  };
  check_angles("assembly", study.mechanism.assembly);
  for (const Trajectory& trajectory : study.trajectories) {
    const std::size_t old_count = warnings.size();
    check_angles(trajectory.name + ".from", trajectory.from.joints);
    if (warnings.size() > old_count) return;  // the others mostly start there, too
  }
}

}  // namespace

std::vector<std::string> list_implausible_numbers(const Study& study, const Units& units) {
  std::vector<std::string> warnings;
  check_plausible_size(study, units, warnings);
  check_plausible_inertias(study, warnings);
  check_plausible_gravity(study, units, warnings);
  check_plausible_angles(study, units, warnings);
  return warnings;
}

namespace {

/// The sections of the document by name; null if the spec does not have one.
class SectionIndex {
 public:
  explicit SectionIndex(const SpecCursor& root) {
    std::vector<Field> fields;
    for (const char* name :
         {"name",      "space",        "gravity",  "parameters", "units",        "include",
          "ground",    "bodies",       "joints",   "couplings",  "constraints",  "speeds",
          "actuators", "tool",         "assembly", "motion",     "trajectories", "counterweights",
          "payloads",  "discs",        "loads",    "springs",    "dampers",      "bushings",
          "friction",  "controllers",  "design",   "tolerances", "workspace",    "torque_distribution",
          "materials", "current_gains"}) {
      const std::string key = name;
      const bool required = key == "space" || key == "bodies" || key == "joints";
      fields.push_back({key, required ? Presence::required : Presence::optional,
                        [this, key](const SpecCursor& c) { sections_.emplace(key, c); }});
    }
    if (!root.is_map()) root.fail_expected("a spec: a mapping with 'space', 'bodies', 'joints', …");
    read_fields(root, "a spec", fields);
  }

  const SpecCursor* operator[](const std::string& name) const {
    const auto entry = sections_.find(name);
    return entry == sections_.end() ? nullptr : &entry->second;
  }

 private:
  std::map<std::string, SpecCursor> sections_;
};

/// Guesses the space from the number of components of the first centre of mass.
SpaceKind guess_space(const SpecCursor* bodies) {
  if (bodies == nullptr) return SpaceKind::planar;
  for (const YamlNode& body : bodies->node().items)
    for (std::size_t i = 0; i < body.keys.size(); ++i)
      if (body.keys[i].text == "com" && body.items[i].kind == YamlNode::Kind::list)
        return body.items[i].items.size() == 3 ? SpaceKind::spatial : SpaceKind::planar;
  return SpaceKind::planar;
}

/// Reads what all numbers depend on: space, units, parameters.
void read_global_settings(const YamlNode& root, const SectionIndex& sections,
                          const SpecParameters::Overrides& overrides, StudyBuilder& draft) {
  auto& mechanism = draft.mechanism();
  draft.problems.collect([&] {
    mechanism.space = guess_space(sections["bodies"]);  // for the sections below, should the next lines fail
    if (sections["space"] == nullptr) return;
    const auto space = sections["space"]->read_choice("the kind of space", {"planar", "spatial"});
    mechanism.space = space == 0 ? SpaceKind::planar : SpaceKind::spatial;
  });
  if (const SpecCursor* units = sections["units"]) draft.units = read_units(*units);
  draft.mechanism().units = static_cast<const model::DisplayUnits&>(draft.units);
  const SpecCursor* parameters = sections["parameters"];
  draft.parameters = SpecParameters(parameters != nullptr ? std::optional(*parameters) : std::nullopt, overrides,
                                    list_added_element_parameters(root), *draft.recording, draft.problems);
}

void read_mechanism(const SectionIndex& sections, StudyBuilder& draft) {
  auto& mechanism = draft.mechanism();
  const auto read_section = [&](const char* name, auto&& section_reader) {
    const SpecCursor* section = sections[name];
    if (section == nullptr) return;
    draft.problems.collect([&] { section_reader(*section); });
  };
  read_section("name", [&](const SpecCursor& c) { mechanism.name = escape_for_terminal(c.read_word("a name")); });
  read_section("gravity",
               [&](const SpecCursor& c) { mechanism.gravity = read_vector(c, draft, dimension::acceleration); });
  mechanism.bodies.emplace_back().name = "ground";
  draft.body_places.push_back({});
  read_section("ground", [&](const SpecCursor& c) { read_ground(c, draft); });
  read_section("bodies", [&](const SpecCursor& c) { read_bodies(c, draft); });
  read_section("joints", [&](const SpecCursor& c) { read_joints(c, draft); });
  read_section("bushings", [&](const SpecCursor& c) { read_bushings(c, draft); });
  // Everything below refers to bodies and joints.
  if (mechanism.bodies.size() < 2 || mechanism.joints.empty()) draft.problems.throw_if_any();
  check_connected(draft);
  read_section("couplings", [&](const SpecCursor& c) { read_couplings(c, draft); });
  // after the stated ones, whose indices are their positions in the spec
  for (const auto& wheel : draft.rolling_couplings) mechanism.couplings.push_back(wheel);
  read_section("actuators", [&](const SpecCursor& c) { read_actuators(c, draft); });
  read_section("torque_distribution", [&](const SpecCursor& c) { read_torque_distribution(c, draft); });
  read_section("current_gains", [&](const SpecCursor& c) { read_current_gains(c, draft); });
  read_section("tool", [&](const SpecCursor& c) { read_tool(c, draft); });
  if (sections["tool"] != nullptr && !mechanism.tool) draft.problems.mark_invalid("tool");
  read_section("constraints", [&](const SpecCursor& c) { read_constraints(c, draft); });
  read_section("assembly", [&](const SpecCursor& c) { mechanism.assembly = read_coordinate_values(c, draft); });
  read_section("materials", [&](const SpecCursor& c) { read_materials(c, draft); });
  read_section("counterweights",
               [&](const SpecCursor& c) { read_attachments(c, draft, AttachmentKind::counterweight); });
  read_section("payloads", [&](const SpecCursor& c) { read_attachments(c, draft, AttachmentKind::payload); });
  read_section("discs", [&](const SpecCursor& c) { read_discs(c, draft); });
  read_section("loads", [&](const SpecCursor& c) { read_loads(c, draft); });
  read_section("springs", [&](const SpecCursor& c) { read_springs(c, draft); });
  read_section("dampers", [&](const SpecCursor& c) { read_dampers(c, draft); });
  read_section("friction", [&](const SpecCursor& c) { read_friction(c, draft); });
  add_dampers(draft);
  check_massless_bodies(draft);
}

/// Value of an expression at the inputs with which it was read.
double value_of(const Expression& expression) { return expression.value(); }

/// Reads all sections; collects what is wrong.
void read_all(const YamlNode& root, const SpecParameters::Overrides& overrides, StudyBuilder& draft) {
  const SectionIndex sections(SpecCursor(root, "", draft.problems));
  draft.load_names = list_load_names(sections["design"]);
  draft.tolerance_names = list_tolerance_names(sections["tolerances"]);
  read_global_settings(root, sections, overrides, draft);
  draft.mechanism().name = escape_for_terminal(std::filesystem::path(draft.study.spec_file).stem().string());
  read_mechanism(sections, draft);
  draft.study.mechanism = model::convert_mechanism<double>(draft.mechanism(), value_of);
  draft.is_mechanism_valid = draft.problems.is_empty();
  read_trajectories(sections["motion"], sections["trajectories"], draft);
  check_presence(draft);
  if (const SpecCursor* workspace = sections["workspace"])
    if (!draft.problems.collect([&] { read_workspace(*workspace, draft); }))
      draft.problems.mark_invalid(workspace_name);
  for (const auto& trajectory : draft.trajectories())
    draft.study.trajectories.push_back(trajectory::cast_scalar<double>(trajectory, value_of));
  if (const SpecCursor* speeds = sections["speeds"])
    draft.problems.collect([&] { draft.study.speeds = read_speeds(*speeds, draft); });
  read_controllers(sections["controllers"], root, overrides, draft);
  if (const SpecCursor* tolerances = sections["tolerances"])
    draft.problems.collect([&] { draft.study.tolerances = read_tolerances(*tolerances, draft); });
  if (const SpecCursor* design = sections["design"]) read_design(*design, draft);
  limit_spring_travel(draft.study);
}

/// @param root null: it is parsed here
void read_document(const std::string& text, const YamlNode* root, const SpecParameters::Overrides& overrides,
                   StudyBuilder& draft) {
  draft.study.spec_text = text;
  draft.study.overrides = overrides;
  YamlNode parsed;
  ExpandedDocument flat;
  try {
    if (root == nullptr) parsed = parse_yaml(text, draft.problems);
    if (root == nullptr) root = &parsed;
    if (has_includes(*root)) {
      flat = expand_includes(*root, draft.study.spec_file, draft.problems);
      draft.study.spec_text = flat.text;
      root = &flat.root;
    }
    read_all(*root, overrides, draft);
  } catch (const ReadError& error) {
    draft.problems.add(error);
  }
  draft.problems.throw_if_any();
  list_text_replacements(*root, draft);
  find_optional_element_texts(*root, draft.study);
  const auto& free = draft.study.free_numbers;
  for (std::size_t i = 0; i < free.size(); ++i)
    if (draft.adapted.contains(free[i].key_path)) draft.study.design.cases.adapted.push_back(static_cast<int>(i));
  for (const DifferentPaths& different : draft.all_different)
    draft.study.design.all_different.push_back({find_free_numbers(different.paths, free), different.taken});
  for (std::string& warning : list_implausible_numbers(draft.study, draft.units))
    draft.study.warnings.push_back(std::move(warning));
}

}  // namespace

Study read_start_study(const std::string& text, const YamlNode* root, const std::string& file_name,
                       const SpecParameters::Overrides& overrides) {
  StudyBuilder draft(file_name);
  read_document(text, root, overrides, draft);
  return std::move(draft.study);
}

ReadResult read_study(const std::string& text, const std::string& file_name, const SpecParameters::Overrides& overrides,
                      const std::set<std::string>& inputs) {
  StudyBuilder draft(file_name);
  draft.requested_inputs = inputs;
  read_document(text, nullptr, overrides, draft);
  return {std::move(draft.study), std::move(draft.recording)};
}

std::map<std::string, Dimension> read_number_dimensions(const std::string& text, const std::string& file_name,
                                                        const SpecParameters::Overrides& overrides) {
  StudyBuilder draft(file_name);
  read_document(text, nullptr, overrides, draft);
  return std::move(draft.number_dimensions);
}

Mechanism read_mechanism_alone(const YamlNode& root, const std::string& file_name,
                               const SpecErrorCollector& known_problems, const SpecParameters::Overrides& overrides) {
  StudyBuilder draft(file_name);
  draft.problems.adopt_files(known_problems);
  const SectionIndex sections(SpecCursor(root, "", draft.problems));
  read_global_settings(root, sections, overrides, draft);
  draft.mechanism().name = escape_for_terminal(std::filesystem::path(file_name).stem().string());
  read_mechanism(sections, draft);
  draft.problems.throw_if_any();
  return model::convert_mechanism<double>(draft.mechanism(), value_of);
}

}  // namespace balance::specification
