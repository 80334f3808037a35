// Controllers, which guide the mechanism along a trajectory.

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_document.hpp"
#include "balance/interface/specification/read_speeds.hpp"
#include "balance/interface/specification/spec_table.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/mechanics/model/speed_units.hpp"
#include "balance/motion/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <vector>

namespace balance::specification {

using study::ControllerType;

// Initial deviation of a controlled run from its trajectory.

/// `{joints: {A1: 0.05}}` or `{tool: [0.01, 0]}`, planar with `angle`.
void read_initial_error(const SpecCursor& at, StudyBuilder& draft, study::InitialError& error);

// A controller's model of the mechanism, if it differs from the true one.

/// `model: {without: [cargo], mass_scale: 0.9, set: {m1: 2, bodies.link2.mass: 1.5}}`.
/// @param root, overrides of the whole spec, which was read without a mistake
Mechanism read_controller_model(const SpecCursor& at, const YamlNode& root, const SpecParameters::Overrides& overrides,
                                StudyBuilder& draft);

namespace {

/// A dimension per kind of coordinate.
using DimensionOf = std::function<Dimension(CoordinateKind)>;

Dimension effort_of(CoordinateKind kind) {
  return kind == CoordinateKind::angle ? dimension::moment : dimension::force;
}

constexpr Dimension per_second = dimension::dimensionless / dimension::time;

double read_fixed(const SpecCursor& at, StudyBuilder& draft, Dimension dimension, SignConstraint sign) {
  if (at.is_map()) at.fail_expected("a number or an expression");
  return read_number(at, draft, dimension, sign).value();
}

/// Reads a number in 1/s, regardless of the spec's unit of time.
double read_hertz(const SpecCursor& at, StudyBuilder& draft) {
  return read_fixed(at, draft, dimension::dimensionless, SignConstraint::positive);
}

CoordinateKind kind_of(CoordinateId coordinate, const StudyBuilder& draft) {
  return draft.study.mechanism.coordinates[static_cast<std::size_t>(coordinate)].kind;
}

std::vector<std::string> names_of(const std::vector<CoordinateId>& actuators, const StudyBuilder& draft) {
  std::vector<std::string> names;
  for (const int c : actuators) names.push_back(draft.study.mechanism.coordinates[static_cast<std::size_t>(c)].name);
  return names;
}

/// Reads numbers for unknown actuators: checks only that they are numbers.
void read_all_fixed(const SpecCursor& at, StudyBuilder& draft, SignConstraint sign) {
  const auto check_number = [&](const SpecCursor& c) { read_fixed(c, draft, dimension::dimensionless, sign); };
  if (at.is_scalar()) return check_number(at);
  if (at.is_list()) return read_each(at.items("a list of numbers"), check_number);
  for (const Member& member : list_members(at, "a number, or one for each actuator"))
    draft.problems.collect([&] { check_number(member.value); });
}

/// One number for all actuators, a list in their order, or a mapping with one for each.
VectorX read_per_actuator(const SpecCursor& at, StudyBuilder& draft, const DimensionOf& dimension,
                          SignConstraint sign) {
  const std::vector<CoordinateId>& actuators = draft.mechanism().actuators;
  if (actuators.empty() ? draft.problems.is_uncertain("actuators") : draft.problems.is_invalid("actuators")) {
    read_all_fixed(at, draft, sign);
    throw CascadingError();
  }
  const std::vector<std::string> names = names_of(actuators, draft);
  const std::string expected_list = names.empty()
                                        ? "a number: the spec has no 'actuators'"
                                        : fmt::format("a number, or {} numbers, one for each of the actuators {}",
                                                      names.size(), join_with_conjunction(names, "and"));
  VectorX values = VectorX::Zero(static_cast<Eigen::Index>(names.size()));
  read_entry_per_name(at, names, Presence::required, expected_list, "a number, or one for each actuator",
                      [&](const SpecCursor& c, std::size_t a) {
                        values[static_cast<Eigen::Index>(a)] =
                            read_fixed(c, draft, dimension(kind_of(actuators[a], draft)), sign);
                      });
  return values;
}

/// One number, for laws that treat all coordinates alike.
VectorX read_single(const SpecCursor& at, StudyBuilder& draft, Dimension dimension) {
  if (!at.is_scalar()) at.fail_expected("one number for all coordinates: this law treats them alike");
  return VectorX::Constant(1, read_fixed(at, draft, dimension, SignConstraint::positive));
}

void read_measurement(const SpecCursor& at, StudyBuilder& draft, study::Measurement& measurement) {
  const auto position = [](CoordinateKind kind) { return dimension_of(kind); };
  const auto rate = [](CoordinateKind kind) { return dimension_of(kind) / dimension::time; };
  const auto values = [&](VectorX& target, const DimensionOf& dimension) {
    return [&target, &draft, dimension](const SpecCursor& c) {
      target = read_per_actuator(c, draft, dimension, SignConstraint::not_negative);
    };
  };
  std::optional<SpecCursor> noise;
  read_fields(at, "a measurement {position_step, position_noise, velocity_noise, velocity, seed}",
              {{"position_step", Presence::optional, values(measurement.position_step, position)},
               {"position_noise", Presence::optional, values(measurement.position_noise, position)},
               {"velocity_noise", Presence::optional,
                [&](const SpecCursor& c) {
                  noise = c;
                  values(measurement.velocity_noise, rate)(c);
                }},
               {"velocity", Presence::optional,
                [&](const SpecCursor& c) {
                  measurement.velocity = c.read_choice("a source of velocities", {"measured", "difference"}) == 0
                                             ? study::VelocitySource::measured
                                             : study::VelocitySource::difference;
                }},
               {"seed", Presence::optional, [&](const SpecCursor& c) {
                  measurement.seed = static_cast<std::uint64_t>(read_integer(c, draft, 0, study::max_seed));
                }}});
  if (noise && measurement.velocity == study::VelocitySource::difference)
    noise->fail(
        {.expected = "no 'velocity_noise' with 'velocity: difference', which takes its noise from the positions"});
}

void read_efforts(const std::optional<SpecCursor>& torque, const std::optional<SpecCursor>& table,
                  const std::optional<SpecCursor>& file, StudyBuilder& draft, study::EffortTable& efforts) {
  const std::vector<CoordinateId>& actuators = draft.mechanism().actuators;
  if (torque) {
    efforts.time = {0};
    efforts.effort = {read_per_actuator(*torque, draft, effort_of, SignConstraint::none)};
  }
  if (!table && !file) return;
  std::vector<TableColumn> columns;
  for (const int c : actuators)
    columns.push_back({draft.mechanism().coordinates[static_cast<std::size_t>(c)].name, effort_of(kind_of(c, draft))});
  const TimeTable rows = table ? read_inline_table(*table, draft, columns) : read_table_file(*file, draft, columns);
  for (const Expression& time : rows.time) efforts.time.push_back(time.value());
  for (const auto& row : rows.values) {
    VectorX effort = VectorX::Zero(static_cast<Eigen::Index>(actuators.size()));
    for (std::size_t i = 0; i < row.size(); ++i) effort[rows.columns[i]] = row[i].value();
    efforts.effort.push_back(effort);
  }
}

/// Keys of a type besides the common ones.
std::vector<std::string> keys_of(ControllerType type) {
  switch (type) {
    case ControllerType::none: return {"initial_error"};
    case ControllerType::open_loop: return {"torque", "table", "file", "interpolation"};
    case ControllerType::pd: return {"speeds", "kp", "kd", "bandwidth", "damping", "gravity"};
    case ControllerType::computed_torque: return {"speeds", "kp", "kd", "bandwidth", "damping"};
    case ControllerType::sliding_mode: return {"speeds", "lambda", "k", "bandwidth", "switching"};
    case ControllerType::extended_sliding_mode: return {"lambda", "k", "bandwidth", "switching", "projection"};
  }
  return {};
}

constexpr const char* common_controller_keys[] = {"rate",        "period", "torque_limit",
                                                  "measurement", "model",  "initial_error"};

class ControllerReader {
 public:
  ControllerReader(const YamlNode& root, const SpecParameters::Overrides& overrides, StudyBuilder& draft)
      : root_(root), overrides_(overrides), draft_(draft) {}

  Controller read(const Member& member) {
    controller_.name = member.name;
    std::vector<Field> fields{{"type", Presence::required, [&](const SpecCursor& c) {
                                 controller_.type = static_cast<ControllerType>(
                                     c.read_choice("a type of controller", study::controller_type_names()));
                               }}};
    for (const char* key :
         {"rate",         "period",      "bandwidth", "damping",      "speeds", "kp",    "kd",   "gravity",
          "lambda",       "k",           "switching", "projection",   "torque", "table", "file", "interpolation",
          "torque_limit", "measurement", "model",     "initial_error"})
      fields.push_back({key, Presence::optional, [this, key](const SpecCursor& c) { entries_.emplace(key, c); }});
    read_fields(member.value, "a controller {type, …}", fields);
    const bool type_known = !draft_.problems.is_uncertain(member.value.path() + ".type");
    if (type_known) check_keys();
    read_common_keys();
    if (type_known) read_gains();
    for (const char* key : {"kp", "kd", "lambda", "k"})
      if (!type_known) read_key(key, [&](const SpecCursor& c) { read_all_fixed(c, draft_, SignConstraint::none); });
    read_open_loop(member.value);
    return controller_;
  }

 private:
  void read_open_loop(const SpecCursor& at) {
    const auto optional_entry = [&](const char* key) {
      const auto entry = entries_.find(key);
      return entry == entries_.end() ? std::nullopt : std::optional(entry->second);
    };
    if (entries_.count("torque") + entries_.count("table") + entries_.count("file") > 1)
      at.fail({.expected = "one of 'torque' (constant), 'table' and 'file'", .found = "several"});
    if (!draft_.problems.is_invalid("actuators"))
      read_efforts(optional_entry("torque"), optional_entry("table"), optional_entry("file"), draft_,
                   controller_.efforts);
    controller_.efforts.is_held = entries_.count("rate") + entries_.count("period") > 0;
    read_key("interpolation", [&](const SpecCursor& c) {
      const bool is_spline = c.read_choice("an interpolation between rows", {"linear", "spline"}) == 1;
      if (entries_.count("table") + entries_.count("file") == 0)
        c.fail({.expected = "no 'interpolation' without 'table' or 'file'"});
      if (!is_spline) return;
      controller_.efforts.interpolation = study::EffortTable::Interpolation::spline;
      const std::size_t rows = controller_.efforts.time.size();
      if (rows > 0 && rows < 4)
        c.fail({.expected = "'linear', or at least four rows for a spline", .found = fmt::format("{} rows", rows)});
    });
  }

  void check_keys() const {
    std::vector<std::string> allowed = keys_of(controller_.type);
    if (controller_.type != ControllerType::none)
      allowed.insert(allowed.end(), std::begin(common_controller_keys), std::end(common_controller_keys));
    for (const auto& [key, cursor] : entries_)
      draft_.problems.collect([&, &key = key, &cursor = cursor] {
        const std::string reason = key == "speeds" ? study::why_no_speeds(controller_.type) : "";
        if (std::find(allowed.begin(), allowed.end(), key) == allowed.end())
          cursor.fail(
              {.expected = fmt::format("no '{}' with 'type: {}', which has {}", key,
                                       controller_type_name(controller_.type), join_with_conjunction(allowed, "and")),
               .hint = reason});
      });
  }

  template <class Read>
  void read_key(const char* key, Read&& read) {
    const auto at = entries_.find(key);
    if (at != entries_.end()) draft_.problems.collect([&] { read(at->second); });
  }

  void read_common_keys() {
    read_key("rate", [&](const SpecCursor& c) {
      if (entries_.count("period") > 0) c.fail({.expected = "'rate' or 'period'", .found = "both"});
    });
    read_key("rate", [&](const SpecCursor& c) { controller_.period = 1 / read_hertz(c, draft_); });
    read_key("period", [&](const SpecCursor& c) {
      controller_.period = read_fixed(c, draft_, dimension::time, SignConstraint::positive);
    });
    read_key("bandwidth", [&](const SpecCursor& c) { controller_.bandwidth = read_hertz(c, draft_); });
    read_key("damping", [&](const SpecCursor& c) {
      controller_.damping = read_fixed(c, draft_, dimension::dimensionless, SignConstraint::not_negative);
    });
    read_key("torque_limit", [&](const SpecCursor& c) {
      controller_.torque_limit = read_per_actuator(c, draft_, effort_of, SignConstraint::not_negative);
    });
    read_key("measurement", [&](const SpecCursor& c) { read_measurement(c, draft_, controller_.measurement); });
    read_key("model",
             [&](const SpecCursor& c) { controller_.model = read_controller_model(c, root_, overrides_, draft_); });
    read_key("initial_error", [&](const SpecCursor& c) { read_initial_error(c, draft_, controller_.initial_error); });
  }

  void read_gains() {
    const bool pd = controller_.type == ControllerType::pd;
    const bool extended = controller_.type == ControllerType::extended_sliding_mode;
    const auto gain = [&](const char* key, VectorX& target, const DimensionOf& dimension, SignConstraint sign) {
      read_key(key, [&](const SpecCursor& c) { target = read_per_quantity(c, dimension, sign); });
    };
    read_key("speeds", [&](const SpecCursor& c) { read_speeds(c); });
    gain(
        "kp", controller_.kp,
        [pd](CoordinateKind kind) { return pd ? effort_of(kind) / dimension_of(kind) : per_second * per_second; },
        SignConstraint::not_negative);
    gain(
        "kd", controller_.kd,
        [pd](CoordinateKind kind) { return pd ? effort_of(kind) / dimension_of(kind) * dimension::time : per_second; },
        SignConstraint::not_negative);
    const auto rate = [](CoordinateKind kind) { return dimension_of(kind) / dimension::time; };
    const auto acceleration = [](CoordinateKind kind) { return dimension_of(kind) * per_second * per_second; };
    const auto sliding = [&](const SpecCursor& c, const DimensionOf& dimension, VectorX& target) {
      target = extended ? read_single(c, draft_, dimension(CoordinateKind::angle))
                        : read_per_quantity(c, dimension, SignConstraint::positive);
    };
    const auto inverse = [](CoordinateKind) { return per_second; };
    read_key("lambda", [&](const SpecCursor& c) { sliding(c, inverse, controller_.lambda); });
    read_key("k", [&](const SpecCursor& c) { sliding(c, acceleration, controller_.switching_gain); });
    read_key("switching", [&](const SpecCursor& c) {
      const std::string what = "a switching function, 'sign' or {boundary_layer: …}";
      if (!c.is_map() && c.read_word(what) == "sign") return;
      read_fields(c, what, {{"boundary_layer", Presence::required, [&](const SpecCursor& layer) {
                               sliding(layer, rate, controller_.boundary_layer);
                             }}});
    });
    read_key("gravity", [&](const SpecCursor& c) {
      controller_.gravity = c.read_choice("a treatment of gravity", {"compensated", "ignored"}) == 0
                                ? study::GravityCompensation::compensated
                                : study::GravityCompensation::ignored;
    });
    read_key("projection", [&](const SpecCursor& c) {
      controller_.projection = c.read_choice("a projection", {"inertia", "identity"}) == 0
                                   ? study::AccelerationProjection::inertia
                                   : study::AccelerationProjection::identity;
    });
  }

  /// Rates of quantities, whose errors are differences of positions.
  void read_speeds(const SpecCursor& at) {
    for (const Member& member : list_named_members(at, "a mapping of speeds"))
      draft_.problems.collect([&] {
        controller_.speeds.push_back(to_numbers(read_speed(member, SpeedUse::quasi_velocity, draft_)));
        const std::string reason = study::why_not_a_rate(controller_.speeds.back(), draft_.mechanism().space);
        if (!reason.empty())
          member.value.fail({.expected =
                                 "the rate of a quantity: joint coordinates, x, y, z of points or of com and, in "
                                 "the plane, angles, with factors that are numbers",
                             .found = fmt::format("a speed of which the integral has no meaning: {}", reason)});
      });
    if (controller_.speeds.empty() && !draft_.problems.is_invalid(at.path()))
      at.fail({.expected = "at least one speed", .found = "none"});
  }

  /// One number for all actuators or speeds, a list in their order, or a mapping with one for each.
  VectorX read_per_quantity(const SpecCursor& at, const DimensionOf& dimension, SignConstraint sign) {
    return entries_.count("speeds") > 0 ? read_per_speed(at, dimension, sign)
                                        : read_per_actuator(at, draft_, dimension, sign);
  }

  VectorX read_per_speed(const SpecCursor& at, const DimensionOf& dimension, SignConstraint sign) {
    const std::vector<model::GeneralisedSpeed>& speeds = controller_.speeds;
    if (speeds.empty()) {
      read_all_fixed(at, draft_, sign);
      throw CascadingError();
    }
    std::vector<std::string> names;
    for (const model::GeneralisedSpeed& speed : speeds) names.push_back(speed.name);
    VectorX values = VectorX::Zero(static_cast<Eigen::Index>(names.size()));
    read_entry_per_name(at, names, Presence::required,
                        fmt::format("{} numbers, one for each of the speeds", names.size()),
                        "a number, or one for each speed", [&](const SpecCursor& c, std::size_t k) {
                          const bool is_length = model::is_length_speed(draft_.study.mechanism, speeds[k]);
                          const CoordinateKind kind = is_length ? CoordinateKind::length : CoordinateKind::angle;
                          values[static_cast<Eigen::Index>(k)] = read_fixed(c, draft_, dimension(kind), sign);
                        });
    return values;
  }

  const YamlNode& root_;
  const SpecParameters::Overrides& overrides_;
  StudyBuilder& draft_;
  Controller controller_;
  std::map<std::string, SpecCursor> entries_;
};

}  // namespace

void read_controllers(const SpecCursor* section, const YamlNode& root, const SpecParameters::Overrides& overrides,
                      StudyBuilder& draft) {
  std::vector<Controller>& controllers = draft.study.controllers;
  if (section != nullptr)
    draft.problems.collect([&] {
      for (const Member& member : list_named_members(*section, "a mapping of controllers {type, …}", NameForm::simple))
        draft.problems.collect([&] { controllers.push_back(ControllerReader(root, overrides, draft).read(member)); });
    });
  for (Controller& built_in : study::built_in_controllers())
    if (std::none_of(controllers.begin(), controllers.end(),
                     [&](const Controller& controller) { return controller.name == built_in.name; }))
      controllers.push_back(std::move(built_in));
}

void read_initial_error(const SpecCursor& at, StudyBuilder& draft, study::InitialError& error) {
  std::optional<SpecCursor> joints_entry, tool_entry, angle_entry;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  std::vector<Field> fields{{"joints", Presence::optional, store_in(joints_entry)},
                            {"tool", Presence::optional, store_in(tool_entry)}};
  if (draft.planar()) fields.push_back({"angle", Presence::optional, store_in(angle_entry)});
  if (!read_fields(at, "an initial error {joints: …} or {tool: …}", fields)) return;
  if (joints_entry.has_value() == tool_entry.has_value())
    at.fail_expected("an initial error with either 'joints' or 'tool'");
  if (angle_entry && !tool_entry)
    angle_entry->fail({.expected = "'angle' only with 'tool'", .found = "'angle' with 'joints'"});
  if (tool_entry && !draft.mechanism().tool)
    tool_entry->fail_unless_uncertain("tool", {.expected = "a spec with a tool ('tool: body.point')",
                                               .found = "none",
                                               .hint = "this key refers to the tool's pose"});
  if (tool_entry) error.tool = values_of(read_vector(*tool_entry, draft, dimension::length));
  if (angle_entry && angle_entry->is_map()) angle_entry->fail_expected("a number or an expression");
  if (angle_entry) error.angle = read_number(*angle_entry, draft, dimension::angle).value();
  if (!joints_entry) return;
  for (const auto& [coordinate, value] : read_coordinate_values(*joints_entry, draft))
    error.joints.push_back({coordinate, value.value()});
  for (const Member& member : list_members(*joints_entry, "joint coordinates")) {
    const auto& actuators = draft.mechanism().actuators;
    draft.problems.collect([&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      if (!draft.problems.is_invalid("actuators") && !actuators.empty() &&
          std::find(actuators.begin(), actuators.end(), coordinate) == actuators.end())
        member.key.fail(
            {.expected = "an actuated coordinate (the others follow)", .found = quote_for_message(member.name)});
    });
  }
}

namespace {

/// Sections in which a model may have other numbers.
constexpr std::array overridable_sections{"gravity",     "ground",         "bodies",   "joints", "couplings",
                                          "constraints", "counterweights", "payloads", "discs",  "loads",
                                          "springs",     "dampers",        "friction"};

/// "bodies.link1.com[0]" → bodies, link1, com, 0.
std::vector<std::string> split_key_path(const std::string& path) {
  std::vector<std::string> steps(1);
  for (const char c : path) {
    if (c == '.' || c == '[')
      steps.emplace_back();
    else if (c != ']')
      steps.back() += c;
  }
  return steps;
}

/// The entry of a mapping or a list that a step of a path names.
YamlNode& find_path_entry(YamlNode& node, const std::string& step, const SpecCursor& named, const std::string& path) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    names.push_back(node.kind == YamlNode::Kind::map ? node.keys[i].text : std::to_string(i));
    if (names.back() == step) return node.items[i];
  }
  // a coordinate's own name may have a dot: `friction.J.slide.coulomb`
  named.fail({.expected = "a parameter or a number of this spec",
              .found = fmt::format("{}: there is no {} in {}", quote_for_message(path), quote_for_message(step),
                                   quote_for_message(path.substr(0, path.rfind(step) - 1))),
              .hint = format_nearest_name(step, names)});
}

YamlNode& number_at(YamlNode& root, const Member& member, const SpecParameters& parameters) {
  const std::vector<std::string> steps = split_key_path(member.name);
  if (steps.size() < 2 ||
      std::find(overridable_sections.begin(), overridable_sections.end(), steps[0]) == overridable_sections.end()) {
    std::vector<std::string> names = parameters.names();
    names.insert(names.end(), overridable_sections.begin(), overridable_sections.end());
    member.key.fail(
        {.expected = fmt::format("a parameter ({}) or the path of a number such as bodies.link1.mass",
                                 parameters.names().empty() ? "there are none" : join_alternatives(parameters.names())),
         .found = quote_for_message(member.name),
         .hint = format_nearest_name(steps[0], names)});
  }
  YamlNode* node = &root;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    // names of coordinates and of elements of parts have dots of their own
    std::string step = steps[i];
    const auto is_key = [&](const std::string& name) {
      return node->kind == YamlNode::Kind::map &&
             std::any_of(node->keys.begin(), node->keys.end(), [&](const YamlNode& key) { return key.text == name; });
    };
    std::string extended_step = step;
    for (std::size_t k = i + 1; !is_key(step) && k < steps.size(); ++k)
      if (extended_step += "." + steps[k]; is_key(extended_step)) {
        step = extended_step;
        i = k;
      }
    node = &find_path_entry(*node, step, member.key, member.name);
  }
  const bool is_free =
      node->kind == YamlNode::Kind::map &&
      std::any_of(node->keys.begin(), node->keys.end(), [](const YamlNode& key) { return key.text == "free"; });
  if (node->kind != YamlNode::Kind::scalar && !is_free)
    member.key.fail({.expected = "the path of a single number",
                     .found = fmt::format("{}, which is {}", quote_for_message(member.name),
                                          node->kind == YamlNode::Kind::list ? "a list" : "a mapping")});
  return *node;
}

/// @param overrides get the values of parameters, `root` all others
void replace_number(const Member& member, YamlNode& root, SpecParameters::Overrides& overrides,
                    const StudyBuilder& draft) {
  const std::string& text = member.value.read_word("a number or an expression");
  const auto& names = draft.parameters.names();
  if (std::find(names.begin(), names.end(), member.name) != names.end()) {
    std::erase_if(overrides, [&](const auto& pair) { return pair.first == member.name; });
    overrides.emplace_back(member.name, text);
    return;
  }
  YamlNode& number = number_at(root, member, draft.parameters);
  number.kind = YamlNode::Kind::scalar;
  number.text = text;
  number.keys.clear();
  number.items.clear();
}

/// The mechanism of the spec with other numbers.
Mechanism read_overridden_mechanism(const SpecCursor& at, const YamlNode& root,
                                    const SpecParameters::Overrides& overrides, StudyBuilder& draft) {
  YamlNode changed_root = root;
  SpecParameters::Overrides changed_overrides = overrides;
  bool is_valid = true;
  for (const Member& member : list_members(at, "numbers {name or path: value}"))
    is_valid =
        draft.problems.collect([&] { replace_number(member, changed_root, changed_overrides, draft); }) && is_valid;
  if (!is_valid) throw CascadingError();
  try {
    return read_mechanism_alone(changed_root, draft.study.spec_file, draft.problems, changed_overrides);
  } catch (const SpecError& error) {
    const Diagnostic& first = error.diagnostics().front();
    at.fail({.message = "expected numbers that give a valid mechanism, but these lead to: " + first.text(),
             .expected = "numbers that give a valid mechanism",
             .found = first.text()});
  }
}

/// @param is_mechanism_valid whether no mistake can be the reason why something is missing in the mechanism
void remove_mechanism_elements(const SpecCursor& at, Mechanism& mechanism, bool is_mechanism_valid) {
  std::vector<std::string> names;
  bool is_known = false;
  const std::string& name = at.read_word("the name of something unknown to the controller");
  const auto erase = [&](auto& list) {
    for (const auto& one : list) names.push_back(one.name);
    is_known = std::erase_if(list, [&](const auto& one) { return one.name == name; }) > 0 || is_known;
  };
  erase(mechanism.attachments);
  erase(mechanism.discs);
  erase(mechanism.loads);
  erase(mechanism.springs);
  erase(mechanism.force_elements);
  if (is_known) return;
  const auto erase_all = [&](const char* section, auto& list, auto&& predicate) {
    if (!list.empty()) names.emplace_back(section);
    if (name != section) return;
    is_known = true;
    std::erase_if(list, predicate);
  };
  const auto is_of_kind = [](AttachmentKind kind) {
    return [kind](const Attachment& one) { return one.kind == kind; };
  };
  const auto any_element = [](const auto&) { return true; };
  erase_all("payloads", mechanism.attachments, is_of_kind(AttachmentKind::payload));
  erase_all("counterweights", mechanism.attachments, is_of_kind(AttachmentKind::counterweight));
  erase_all("discs", mechanism.discs, any_element);
  erase_all("loads", mechanism.loads, any_element);
  erase_all("springs", mechanism.springs, any_element);
  const auto is_damper = [](const ForceElement& one) { return one.is_damper(); };
  if (std::any_of(mechanism.force_elements.begin(), mechanism.force_elements.end(), is_damper) || name == "dampers")
    erase_all("dampers", mechanism.force_elements, is_damper);
  if (name == "springs") std::erase_if(mechanism.force_elements, std::not_fn(is_damper));
  erase_all("friction", mechanism.friction, any_element);
  if (!is_known && !is_mechanism_valid) throw CascadingError();
  if (!is_known) fail_expected_one_of(at, "something that can be left out", names);
}

/// Scales mass and inertia alike, as if the density were different.
void scale_masses(const SpecCursor& at, StudyBuilder& draft, Mechanism& mechanism) {
  const auto factor_of = [&](const SpecCursor& c) {
    if (c.is_map()) c.fail_expected("a factor > 0");
    return read_number(c, draft, dimension::dimensionless, SignConstraint::positive).value();
  };
  const auto scale = [](auto& one, double factor) {
    one.mass *= factor;
    one.inertia *= factor;
  };
  if (!at.is_map()) {
    const double factor = factor_of(at);
    for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) scale(mechanism.bodies[b], factor);
    for (Attachment& one : mechanism.attachments) scale(one, factor);
    for (Disc& one : mechanism.discs) scale(one, factor);
    return;
  }
  for (const Member& member : list_members(at, "a factor, or factors {name: factor}")) {
    draft.problems.collect([&] {
      const double factor = factor_of(member.value);
      std::vector<std::string> names;
      bool is_known = false;
      const auto scale_named = [&](auto begin, auto end) {
        for (auto one = begin; one != end; ++one) {
          names.push_back(one->name);
          if (one->name != member.name) continue;
          scale(*one, factor);
          is_known = true;
        }
      };
      scale_named(mechanism.bodies.begin() + 1, mechanism.bodies.end());
      scale_named(mechanism.attachments.begin(), mechanism.attachments.end());
      scale_named(mechanism.discs.begin(), mechanism.discs.end());
      if (!is_known && !draft.is_mechanism_valid) throw CascadingError();
      if (!is_known)
        member.key.fail({.expected = fmt::format("something with a mass ({})", join_alternatives(names)),
                         .found = quote_for_message(member.name),
                         .hint = format_nearest_name(member.name, names)});
    });
  }
}

}  // namespace

Mechanism read_controller_model(const SpecCursor& at, const YamlNode& root, const SpecParameters::Overrides& overrides,
                                StudyBuilder& draft) {
  std::optional<SpecCursor> without_entry, mass_scale_entry, set_entry;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  Mechanism model = draft.study.mechanism;
  read_fields(at, "a controller model {without, mass_scale, set}",
              {{"without", Presence::optional, store_in(without_entry)},
               {"mass_scale", Presence::optional, store_in(mass_scale_entry)},
               {"set", Presence::optional, store_in(set_entry)}});
  // with other numbers the whole spec is read again, so it must be valid
  const bool is_mechanism_valid = draft.is_mechanism_valid;
  if (set_entry)
    draft.problems.collect([&] {
      if (!is_mechanism_valid) throw CascadingError();
      model = read_overridden_mechanism(*set_entry, root, overrides, draft);
    });
  // scaled first: elements that are removed must still be found by name
  if (mass_scale_entry) draft.problems.collect([&] { scale_masses(*mass_scale_entry, draft, model); });
  if (without_entry && !without_entry->is_list()) remove_mechanism_elements(*without_entry, model, is_mechanism_valid);
  if (without_entry && without_entry->is_list())
    for (const SpecCursor& item : without_entry->items("a list of names"))
      draft.problems.collect([&] { remove_mechanism_elements(item, model, is_mechanism_valid); });
  return model;
}

}  // namespace balance::specification
