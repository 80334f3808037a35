#include "balance/spec/reading.hpp"

#include "balance/base/plain_text.hpp"
#include "balance/spec/added_amounts.hpp"
#include "balance/spec/choose.hpp"
#include "balance/spec/include.hpp"
#include "balance/spec/load_cases.hpp"
#include "balance/spec/passing_payloads.hpp"
#include "balance/spec/plausibility.hpp"
#include "balance/spec/rewrites.hpp"
#include "balance/spec/sections.hpp"
#include "balance/spec/tolerances.hpp"
#include "balance/spec/workspace.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace balance::read {

namespace {

/// The sections of the document by name; null where the spec has none.
class Sections {
 public:
  explicit Sections(const Cursor& root) {
    std::vector<Field> fields;
    for (const char* name :
         {"name",     "space",    "gravity",      "parameters",     "units",      "include",   "ground",
          "bodies",   "joints",   "couplings",    "constraints",    "speeds",     "actuators", "tool",
          "assembly", "motion",   "trajectories", "counterweights", "payloads",   "discs",     "loads",
          "springs",  "friction", "controllers",  "design",         "tolerances", "workspace"}) {
      const std::string key = name;
      const bool required = key == "space" || key == "bodies" || key == "joints";
      fields.push_back(
          {key, required ? Need::required : Need::optional, [this, key](const Cursor& c) { found_.emplace(key, c); }});
    }
    if (!root.is_map()) root.expected("a spec: a mapping with 'space', 'bodies', 'joints', …");
    read_fields(root, "a spec", fields);
  }

  const Cursor* operator[](const std::string& name) const {
    const auto at = found_.find(name);
    return at == found_.end() ? nullptr : &at->second;
  }

 private:
  std::map<std::string, Cursor> found_;
};

/// What the first centre of mass is a vector of.
SpaceKind likely_space(const Cursor* bodies) {
  if (bodies == nullptr) return SpaceKind::planar;
  for (const Node& body : bodies->node().items)
    for (std::size_t i = 0; i < body.keys.size(); ++i)
      if (body.keys[i].text == "com" && body.items[i].kind == Node::Kind::list)
        return body.items[i].items.size() == 3 ? SpaceKind::spatial : SpaceKind::planar;
  return SpaceKind::planar;
}

/// What all numbers depend on.
void read_frame(const Node& root, const Sections& sections, const Parameters::Overrides& overrides, Draft& draft) {
  auto& mechanism = draft.mechanism();
  draft.problems.guard([&] {
    mechanism.space = likely_space(sections["bodies"]);  // for what comes below, should the next lines fail
    if (sections["space"] == nullptr) return;
    const auto space = sections["space"]->choice("the kind of space", {"planar", "spatial"});
    mechanism.space = space == 0 ? SpaceKind::planar : SpaceKind::spatial;
  });
  if (const Cursor* units = sections["units"]) draft.units = read_units(*units);
  draft.mechanism().units = static_cast<const SpecUnits&>(draft.units);
  const Cursor* parameters = sections["parameters"];
  draft.parameters = Parameters(parameters != nullptr ? std::optional(*parameters) : std::nullopt, overrides,
                                parameters_of_added_amounts(root), *draft.recording, draft.problems);
}

void read_mechanism(const Sections& sections, Draft& draft) {
  auto& mechanism = draft.mechanism();
  const auto read = [&](const char* name, auto&& section_reader) {
    const Cursor* section = sections[name];
    if (section == nullptr) return;
    draft.problems.guard([&] { section_reader(*section); });
  };
  read("name", [&](const Cursor& c) { mechanism.name = visible(c.word("a name")); });
  read("gravity", [&](const Cursor& c) { mechanism.gravity = read_vector(c, draft, dimension::acceleration); });
  mechanism.bodies.emplace_back().name = "ground";
  draft.body_places.push_back({});
  read("ground", [&](const Cursor& c) { read_ground(c, draft); });
  read("bodies", [&](const Cursor& c) { read_bodies(c, draft); });
  read("joints", [&](const Cursor& c) { read_joints(c, draft); });
  // Everything below refers to bodies and joints.
  if (mechanism.bodies.size() < 2 || mechanism.joints.empty()) draft.problems.throw_all();
  check_connected(draft);
  read("couplings", [&](const Cursor& c) { read_couplings(c, draft); });
  // after the stated ones, whose numbers are their places in the spec
  for (const auto& wheel : draft.wheels) mechanism.couplings.push_back(wheel);
  read("actuators", [&](const Cursor& c) { read_actuators(c, draft); });
  read("tool", [&](const Cursor& c) { read_tool(c, draft); });
  if (sections["tool"] != nullptr && !mechanism.tool) draft.problems.spoil("tool");
  read("constraints", [&](const Cursor& c) { read_constraints(c, draft); });
  read("assembly", [&](const Cursor& c) { mechanism.assembly = read_coordinate_values(c, draft); });
  read("counterweights", [&](const Cursor& c) { read_attachments(c, draft, AttachmentKind::counterweight); });
  read("payloads", [&](const Cursor& c) { read_attachments(c, draft, AttachmentKind::payload); });
  read("discs", [&](const Cursor& c) { read_discs(c, draft); });
  read("loads", [&](const Cursor& c) { read_loads(c, draft); });
  read("springs", [&](const Cursor& c) { read_springs(c, draft); });
  read("friction", [&](const Cursor& c) { read_friction(c, draft); });
  check_light_bodies(draft);
}

/// Expressions at the values that they were read with.
double value_of(const Expression& expression) { return expression.value(); }

/// Everything, with what is wrong thrown.
void read_all(const Node& root, const Parameters::Overrides& overrides, Draft& draft) {
  const Sections sections(Cursor(root, "", draft.problems));
  draft.load_names = list_load_names(sections["design"]);
  draft.tolerance_names = list_tolerance_names(sections["tolerances"]);
  read_frame(root, sections, overrides, draft);
  draft.mechanism().name = visible(std::filesystem::path(draft.study.spec_file).stem().string());
  read_mechanism(sections, draft);
  draft.study.mechanism = converted<double>(draft.mechanism(), value_of);
  draft.mechanism_is_right = draft.problems.none();
  read_trajectories(sections["motion"], sections["trajectories"], draft);
  check_presence(draft);
  if (const Cursor* box = sections["workspace"])
    if (!draft.problems.guard([&] { read_workspace(*box, draft); })) draft.problems.spoil(workspace_name);
  for (const auto& trajectory : draft.trajectories())
    draft.study.trajectories.push_back(converted<double>(trajectory, value_of));
  if (const Cursor* speeds = sections["speeds"])
    draft.problems.guard([&] { draft.study.speeds = read_speeds(*speeds, draft); });
  read_controllers(sections["controllers"], root, overrides, draft);
  if (const Cursor* tolerances = sections["tolerances"])
    draft.problems.guard([&] { draft.study.tolerances = read_tolerances(*tolerances, draft); });
  if (const Cursor* design = sections["design"]) read_design(*design, draft);
}

/// @param root parsed here if it is not there yet
void read_document(const std::string& text, const Node* root, const Parameters::Overrides& overrides, Draft& draft) {
  draft.study.spec_text = text;
  Node parsed;
  FlatDocument flat;
  try {
    if (root == nullptr) parsed = parse_yaml(text, draft.problems);
    if (root == nullptr) root = &parsed;
    if (includes_parts(*root)) {
      flat = flatten(*root, draft.study.spec_file, draft.problems);
      draft.study.spec_text = flat.text;
      root = &flat.root;
    }
    read_all(*root, overrides, draft);
  } catch (const Problem& problem) {
    draft.problems.add(problem);
  }
  draft.problems.throw_all();
  list_rewrites(*root, draft);
  list_offered_texts(*root, draft.study);
  const auto& free = draft.study.free_numbers;
  for (std::size_t i = 0; i < free.size(); ++i)
    if (draft.adapted.contains(free[i].path)) draft.study.design.cases.adapted.push_back(static_cast<int>(i));
  for (std::string& warning : implausible_numbers(draft.study, draft.units))
    draft.study.warnings.push_back(std::move(warning));
}

}  // namespace

Study read_start(const std::string& text, const Node* root, const std::string& file_name,
                 const Parameters::Overrides& overrides) {
  Draft draft(file_name);
  read_document(text, root, overrides, draft);
  return std::move(draft.study);
}

Reading read_study(const std::string& text, const std::string& file_name, const Parameters::Overrides& overrides) {
  Draft draft(file_name);
  read_document(text, nullptr, overrides, draft);
  return {std::move(draft.study), std::move(draft.recording)};
}

Mechanism read_mechanism_alone(const Node& root, const std::string& file_name, const Problems& known,
                               const Parameters::Overrides& overrides) {
  Draft draft(file_name);
  draft.problems.take_files(known);
  const Sections sections(Cursor(root, "", draft.problems));
  read_frame(root, sections, overrides, draft);
  draft.mechanism().name = visible(std::filesystem::path(file_name).stem().string());
  read_mechanism(sections, draft);
  draft.problems.throw_all();
  return converted<double>(draft.mechanism(), value_of);
}

}  // namespace balance::read
