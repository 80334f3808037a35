#include "balance/read/reading.hpp"

#include "balance/read/rewrites.hpp"
#include "balance/read/sections.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace balance::read {

namespace {

/// The sections of the document by name; null where the spec has none.
class Sections {
 public:
  Sections(const Cursor& root, Problems& problems) {
    std::vector<Field> fields;
    for (const char* name :
         {"name",           "space",     "gravity",   "parameters", "units",    "ground",   "bodies",
          "joints",         "couplings", "actuators", "tool",       "assembly", "motion",   "trajectories",
          "counterweights", "payloads",  "discs",     "loads",      "springs",  "friction", "design"}) {
      const std::string key = name;
      const bool required = key == "space" || key == "bodies" || key == "joints";
      fields.push_back(
          {key, required ? Need::required : Need::optional, [this, key](const Cursor& c) { found_.emplace(key, c); }});
    }
    // Without its frame the rest of a spec cannot be understood.
    if (!root.is_map()) root.expected("a spec: a mapping with 'space', 'bodies', 'joints', …");
    read_fields(root, "a spec", fields);
    if (found_.count("space") == 0 || found_.count("bodies") == 0 || found_.count("joints") == 0)
      problems.throw_first();
  }

  const Cursor* operator[](const std::string& name) const {
    const auto at = found_.find(name);
    return at == found_.end() ? nullptr : &at->second;
  }

 private:
  std::map<std::string, Cursor> found_;
};

/// What all numbers depend on.
void read_frame(const Sections& sections, const Parameters::Overrides& overrides, Draft& draft) {
  Mechanism& mechanism = draft.mechanism();
  draft.problems.guard([&] {
    const auto space = sections["space"]->choice("the kind of space", {"planar", "spatial"});
    mechanism.space = space == 0 ? SpaceKind::planar : SpaceKind::spatial;
  });
  if (const Cursor* units = sections["units"]) draft.units = read_units(*units);
  const Cursor* parameters = sections["parameters"];
  draft.parameters = Parameters(parameters != nullptr ? std::optional(*parameters) : std::nullopt, overrides,
                                draft.given, draft.problems);
  draft.problems.throw_first();
}

void read_mechanism(const Sections& sections, Draft& draft) {
  Mechanism& mechanism = draft.mechanism();
  const auto read = [&](const char* name, auto&& section_reader) {
    if (const Cursor* section = sections[name]) draft.problems.guard([&] { section_reader(*section); });
  };
  read("name", [&](const Cursor& c) { mechanism.name = c.word("a name"); });
  read("gravity", [&](const Cursor& c) { mechanism.gravity = read_vector(c, draft, dimension::acceleration); });
  mechanism.bodies.emplace_back().name = "ground";
  draft.body_places.push_back({});
  read("ground", [&](const Cursor& c) { read_ground(c, draft); });
  read_bodies(*sections["bodies"], draft);
  read_joints(*sections["joints"], draft);
  // Everything below refers to bodies and joints.
  draft.problems.throw_first();
  check_connected(draft);
  read("couplings", [&](const Cursor& c) { read_couplings(c, draft); });
  read("actuators", [&](const Cursor& c) { read_actuators(c, draft); });
  read("tool", [&](const Cursor& c) { read_tool(c, draft); });
  read("assembly", [&](const Cursor& c) { mechanism.assembly = read_coordinate_values(c, draft); });
  read("counterweights", [&](const Cursor& c) { read_attachments(c, draft, AttachmentKind::counterweight); });
  read("payloads", [&](const Cursor& c) { read_attachments(c, draft, AttachmentKind::payload); });
  read("discs", [&](const Cursor& c) { read_discs(c, draft); });
  read("loads", [&](const Cursor& c) { read_loads(c, draft); });
  read("springs", [&](const Cursor& c) { read_springs(c, draft); });
  read("friction", [&](const Cursor& c) { read_friction(c, draft); });
}

void add_warnings(Draft& draft) {
  const double weight = draft.mechanism().gravity.norm();
  if (draft.units.factor(dimension::acceleration) != 1 &&
      std::abs(weight / draft.units.factor(dimension::acceleration) - 9.81) < 0.02)
    draft.study.warnings.push_back(
        "gravity: 9.81 in the spec's units is not the earth's gravity; in millimetres it would be 9810");
}

/// Whether some number in here depends on a free one; it may say yes where none does.
bool is_open(const Node& node, const std::vector<std::string>& open_parameters) {
  if (node.kind == Node::Kind::scalar) {
    const auto names = names_in(node.text).values;
    return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      return std::find(open_parameters.begin(), open_parameters.end(), name) != open_parameters.end();
    });
  }
  return std::any_of(node.keys.begin(), node.keys.end(), [](const Node& key) { return key.text == "free"; }) ||
         std::any_of(node.items.begin(), node.items.end(),
                     [&](const Node& item) { return is_open(item, open_parameters); });
}

const Node* find_section(const Node& root, const char* name) {
  for (std::size_t i = 0; i < root.keys.size(); ++i)
    if (root.keys[i].text == name) return &root.items[i];
  return nullptr;
}

/// Parameters that free numbers change.
std::vector<std::string> open_parameters(const Node& root, const Parameters::Overrides& overrides) {
  std::vector<std::string> open;
  if (find_section(root, "parameters") == nullptr) return open;
  Node section = *find_section(root, "parameters");
  for (const auto& [name, text] : overrides)
    for (std::size_t i = 0; i < section.items.size(); ++i)
      if (section.keys[i].text == name) {
        section.items[i].kind = Node::Kind::scalar;
        section.items[i].text = text;
      }
  // Each round finds those that depend on the ones found before.
  for (std::size_t before = 1; before != open.size();) {
    before = open.size();
    for (std::size_t i = 0; i < section.items.size(); ++i)
      if (std::find(open.begin(), open.end(), section.keys[i].text) == open.end() && is_open(section.items[i], open))
        open.push_back(section.keys[i].text);
  }
  return open;
}

bool is_motion_open(const Node& root, const Parameters::Overrides& overrides) {
  const auto parameters = open_parameters(root, overrides);
  for (const char* name : {"motion", "trajectories"})
    if (const Node* section = find_section(root, name); section != nullptr && is_open(*section, parameters))
      return true;
  return false;
}

/// Everything up to the mechanism.
Sections read_structure(const Node& root, const Parameters::Overrides& overrides, Draft& draft) {
  Sections sections(Cursor(root, "", draft.problems), draft.problems);
  read_frame(sections, overrides, draft);
  draft.mechanism().name = std::filesystem::path(draft.study.spec_file).stem().string();
  read_mechanism(sections, draft);
  return sections;
}

}  // namespace

Reading read_first(const std::string& text, const std::string& file_name, const Parameters::Overrides& overrides) {
  Draft draft(file_name);
  draft.study.spec_text = text;
  Reading reading;
  reading.overrides = overrides;
  try {
    reading.root = parse_yaml(text, draft.problems);
    const Sections sections = read_structure(reading.root, overrides, draft);
    // Without the tool, the poses would all be complained about.
    if (draft.problems.none()) read_trajectories(sections["motion"], sections["trajectories"], draft);
    if (const Cursor* design = sections["design"]) read_design(*design, draft);
  } catch (const Problem& problem) {
    draft.problems.add(problem);
  }
  draft.problems.throw_first();
  list_rewrites(reading.root, draft);
  add_warnings(draft);
  reading.tables = std::move(draft.tables);
  reading.start = std::move(draft.study);
  for (std::size_t i = 0; i < reading.start.free_numbers.size(); ++i)
    reading.free_index[reading.start.free_numbers[i].path] = static_cast<Eigen::Index>(i);
  reading.motion_open = is_motion_open(reading.root, overrides);
  return reading;
}

Study read_again(const Reading& reading, const VectorX& x) {
  Draft draft(reading.start.spec_file);
  const FreeValues values(reading.free_index, x);
  draft.given = &values;
  draft.known_tables = &reading.tables;
  const Sections sections = read_structure(reading.root, reading.overrides, draft);
  draft.study.trajectories = reading.start.trajectories;
  if (reading.motion_open) {
    draft.study.trajectories.clear();
    read_trajectories(sections["motion"], sections["trajectories"], draft);
  }
  draft.problems.throw_first();
  draft.study.free_numbers = reading.start.free_numbers;
  draft.study.rewrites = reading.start.rewrites;
  draft.study.design = reading.start.design;
  draft.study.spec_text = reading.start.spec_text;
  draft.study.warnings = reading.start.warnings;
  return std::move(draft.study);
}

}  // namespace balance::read
