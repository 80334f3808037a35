#include "balance/read/read_spec.hpp"

#include "balance/base/error.hpp"
#include "balance/read/sections.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <tuple>

namespace balance {

namespace {

using namespace read;

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
void read_frame(const Sections& sections, const ReadOptions& options, Draft& draft) {
  Mechanism& mechanism = draft.mechanism();
  draft.problems.guard([&] {
    const auto space = sections["space"]->choice("the kind of space", {"planar", "spatial"});
    mechanism.space = space == 0 ? SpaceKind::planar : SpaceKind::spatial;
  });
  if (const Cursor* units = sections["units"]) draft.units = read_units(*units);
  const Cursor* parameters = sections["parameters"];
  draft.parameters =
      Parameters(parameters != nullptr ? std::optional(*parameters) : std::nullopt, options.set, draft.problems);
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

/// Free numbers in the order of the document; those of parameters stand where the parameter does.
void list_free_numbers(Draft& draft) {
  auto& all = draft.free_numbers;
  std::stable_sort(all.begin(), all.end(), [](const PlacedFreeNumber& a, const PlacedFreeNumber& b) {
    return std::tuple(a.place.line, a.place.column) < std::tuple(b.place.line, b.place.column);
  });
  draft.study.free_numbers = draft.parameters.free_numbers();
  for (const PlacedFreeNumber& placed : all) draft.study.free_numbers.push_back(placed.number);
}

void add_warnings(Draft& draft) {
  const double weight = draft.mechanism().gravity.norm();
  if (draft.units.factor(dimension::acceleration) != 1 &&
      std::abs(weight / draft.units.factor(dimension::acceleration) - 9.81) < 0.02)
    draft.study.warnings.push_back(
        "gravity: 9.81 in the spec's units is not the earth's gravity; in millimetres it would be 9810");
}

}  // namespace

Study read_spec(const std::string& text, const std::string& file_name, const ReadOptions& options) {
  Draft draft(file_name);
  draft.study.spec_text = text;
  try {
    const Node root = parse_yaml(text, draft.problems);
    const Sections sections(Cursor(root, "", draft.problems), draft.problems);
    read_frame(sections, options, draft);
    draft.mechanism().name = std::filesystem::path(file_name).stem().string();
    read_mechanism(sections, draft);
    // Without the tool, the poses would all be complained about.
    if (draft.problems.none()) read_trajectories(sections["motion"], sections["trajectories"], draft);
    if (const Cursor* design = sections["design"]) read_design(*design, draft);
  } catch (const Problem& problem) {
    draft.problems.add(problem);
  }
  draft.problems.throw_first();
  list_free_numbers(draft);
  add_warnings(draft);
  return std::move(draft.study);
}

Study read_spec_file(const std::string& path, const ReadOptions& options) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw SystemError(path + ": expected a spec file, found a directory");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw SystemError(path + ": cannot read the spec: " + (errno != 0 ? std::strerror(errno) : "it does not open"));
  // One byte more than a spec may have: a device without an end is refused like a file that is too large.
  std::string text((std::size_t{4} << 20) + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw SystemError(path + ": cannot read the spec: " + std::strerror(errno));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return read_spec(text, path, options);
}

}  // namespace balance
