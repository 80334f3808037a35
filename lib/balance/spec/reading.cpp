#include "balance/spec/reading.hpp"

#include "balance/base/plain_text.hpp"
#include "balance/spec/rewrites.hpp"
#include "balance/spec/sections.hpp"

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
    for (const char* name : {"name",    "space",        "gravity",        "parameters", "units", "ground",
                             "bodies",  "joints",       "couplings",      "actuators",  "tool",  "assembly",
                             "motion",  "trajectories", "counterweights", "payloads",   "discs", "loads",
                             "springs", "friction",     "controllers",    "design"}) {
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
void read_frame(const Sections& sections, const Parameters::Overrides& overrides, Draft& draft) {
  Mechanism& mechanism = draft.mechanism();
  draft.problems.guard([&] {
    mechanism.space = likely_space(sections["bodies"]);  // for what comes below, should the next lines fail
    if (sections["space"] == nullptr) return;
    const auto space = sections["space"]->choice("the kind of space", {"planar", "spatial"});
    mechanism.space = space == 0 ? SpaceKind::planar : SpaceKind::spatial;
  });
  if (const Cursor* units = sections["units"]) draft.units = read_units(*units);
  draft.study.units = {draft.units.length, draft.units.angle};
  const Cursor* parameters = sections["parameters"];
  draft.parameters = Parameters(parameters != nullptr ? std::optional(*parameters) : std::nullopt, overrides,
                                draft.given, draft.problems);
}

void read_mechanism(const Sections& sections, Draft& draft) {
  Mechanism& mechanism = draft.mechanism();
  const auto read = [&](const char* name, auto&& section_reader) {
    const Cursor* section = sections[name];
    if (section == nullptr || !draft.is_read(name)) return;
    draft.problems.guard([&] { section_reader(*section); });
  };
  read("name", [&](const Cursor& c) { mechanism.name = visible(c.word("a name")); });
  read("gravity", [&](const Cursor& c) { mechanism.gravity = read_vector(c, draft, dimension::acceleration); });
  if (draft.is_read("bodies")) {
    mechanism.bodies.emplace_back().name = "ground";
    draft.body_places.push_back({});
  }
  read("ground", [&](const Cursor& c) { read_ground(c, draft); });
  read("bodies", [&](const Cursor& c) { read_bodies(c, draft); });
  read("joints", [&](const Cursor& c) { read_joints(c, draft); });
  // Everything below refers to bodies and joints.
  if (mechanism.bodies.size() < 2 || mechanism.joints.empty()) draft.problems.throw_all();
  if (draft.judging()) check_connected(draft);
  read("couplings", [&](const Cursor& c) { read_couplings(c, draft); });
  read("actuators", [&](const Cursor& c) { read_actuators(c, draft); });
  read("tool", [&](const Cursor& c) { read_tool(c, draft); });
  if (sections["tool"] != nullptr && !mechanism.tool) draft.problems.spoil("tool");
  read("assembly", [&](const Cursor& c) { mechanism.assembly = read_coordinate_values(c, draft); });
  read("counterweights", [&](const Cursor& c) { read_attachments(c, draft, AttachmentKind::counterweight); });
  read("payloads", [&](const Cursor& c) { read_attachments(c, draft, AttachmentKind::payload); });
  read("discs", [&](const Cursor& c) { read_discs(c, draft); });
  read("loads", [&](const Cursor& c) { read_loads(c, draft); });
  read("springs", [&](const Cursor& c) { read_springs(c, draft); });
  read("friction", [&](const Cursor& c) { read_friction(c, draft); });
  if (draft.judging()) check_light_bodies(draft);
}

void add_warnings(Draft& draft) {
  const double weight = draft.mechanism().gravity.norm();
  if (draft.units.factor(dimension::acceleration) != 1 &&
      std::abs(weight / draft.units.factor(dimension::acceleration) - 9.81) < 0.02)
    draft.study.warnings.push_back(
        "gravity: 9.81 in the spec's units is not the earth's gravity; in millimetres it would be 9810");
}

/// Takes out what is going to be read again; single values are replaced anyway.
void clear_open_parts(const std::set<std::string>& open, Study& study) {
  Mechanism& mechanism = study.mechanism;
  const auto clear = [&](const char* name, auto& part) {
    if (open.count(name) > 0) part.clear();
  };
  clear("bodies", mechanism.bodies);
  clear("joints", mechanism.joints);
  clear("couplings", mechanism.couplings);
  clear("actuators", mechanism.actuators);
  clear("counterweights", mechanism.attachments);
  clear("discs", mechanism.discs);
  clear("loads", mechanism.loads);
  clear("springs", mechanism.springs);
  clear("friction", mechanism.friction);
  clear("motion", study.trajectories);
}

}  // namespace

namespace {

/// Everything, with what is wrong thrown.
void read_all(const Node& root, const Parameters::Overrides& overrides, Draft& draft) {
  const Sections sections(Cursor(root, "", draft.problems));
  read_frame(sections, overrides, draft);
  draft.mechanism().name = visible(std::filesystem::path(draft.study.spec_file).stem().string());
  read_mechanism(sections, draft);
  draft.mechanism_is_right = draft.problems.none();
  read_trajectories(sections["motion"], sections["trajectories"], draft);
  read_controllers(sections["controllers"], root, overrides, draft);
  if (const Cursor* design = sections["design"]) read_design(*design, draft);
}

/// @param root parsed here if it is not there yet
void read_document(const std::string& text, const Node* root, Node& parsed, const Parameters::Overrides& overrides,
                   Draft& draft) {
  draft.study.spec_text = text;
  try {
    if (root == nullptr) parsed = parse_yaml(text, draft.problems);
    read_all(root == nullptr ? parsed : *root, overrides, draft);
  } catch (const Problem& problem) {
    draft.problems.add(problem);
  }
  draft.problems.throw_all();
  list_rewrites(root == nullptr ? parsed : *root, draft);
  add_warnings(draft);
}

}  // namespace

Study read_start(const std::string& text, const Node* root, const std::string& file_name,
                 const Parameters::Overrides& overrides) {
  Draft draft(file_name);
  Node parsed;
  read_document(text, root, parsed, overrides, draft);
  return std::move(draft.study);
}

Reading read_first(const std::string& text, const std::string& file_name, const Parameters::Overrides& overrides) {
  Draft draft(file_name);
  Reading reading;
  reading.overrides = overrides;
  read_document(text, nullptr, reading.root, overrides, draft);
  reading.tables = std::move(draft.tables);
  reading.start = std::move(draft.study);
  for (std::size_t i = 0; i < reading.start.free_numbers.size(); ++i)
    reading.free_index[reading.start.free_numbers[i].path] = static_cast<Eigen::Index>(i);
  reading.open = find_open_parts(reading.root, overrides);
  for (const auto& [expression, value] : draft.parameters.calculated()) {
    const auto names = names_in(expression).values;
    if (std::none_of(names.begin(), names.end(),
                     [&](const std::string& name) { return reading.open.parameters.count(name) > 0; }))
      reading.constants[expression] = value;
  }
  return reading;
}

Mechanism read_mechanism_alone(const Node& root, const std::string& file_name, const Parameters::Overrides& overrides) {
  Draft draft(file_name);
  const Sections sections(Cursor(root, "", draft.problems));
  read_frame(sections, overrides, draft);
  draft.mechanism().name = visible(std::filesystem::path(file_name).stem().string());
  read_mechanism(sections, draft);
  draft.problems.throw_all();
  return std::move(draft.study.mechanism);
}

Study read_again(const Reading& reading, const VectorX& x) {
  Draft draft(reading.start.spec_file);
  draft.study = reading.start;
  if (reading.open.sections.empty()) return std::move(draft.study);
  const FreeValues values(reading.free_index, x, reading.constants);
  draft.given = &values;
  draft.known_tables = &reading.tables;
  draft.open = &reading.open.sections;
  const Sections sections(Cursor(reading.root, "", draft.problems));
  read_frame(sections, reading.overrides, draft);
  clear_open_parts(reading.open.sections, draft.study);
  read_mechanism(sections, draft);
  if (draft.is_read("motion")) read_trajectories(sections["motion"], sections["trajectories"], draft);
  draft.problems.throw_all();
  return std::move(draft.study);
}

}  // namespace balance::read
