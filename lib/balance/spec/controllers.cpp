// What leads the mechanism along a trajectory.

#include "balance/base/nearest.hpp"
#include "balance/spec/initial_error.hpp"
#include "balance/spec/limits.hpp"
#include "balance/spec/model_override.hpp"
#include "balance/spec/sections.hpp"
#include "balance/spec/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace balance::specification {

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

/// In 1/s whatever the spec's unit of time.
double read_hertz(const SpecCursor& at, StudyBuilder& draft) {
  return read_fixed(at, draft, dimension::dimensionless, SignConstraint::positive);
}

CoordinateKind kind_of(CoordinateId coordinate, const StudyBuilder& draft) {
  return draft.study.mechanism.coordinates[static_cast<std::size_t>(coordinate)].kind;
}

std::string names_of(const std::vector<CoordinateId>& actuators, const StudyBuilder& draft) {
  std::vector<std::string> names;
  for (const int c : actuators) names.push_back(draft.study.mechanism.coordinates[static_cast<std::size_t>(c)].name);
  return join_with_conjunction(names, "and");
}

/// Numbers of whatever actuators: only that they are numbers can be told.
void read_all_fixed(const SpecCursor& at, StudyBuilder& draft, SignConstraint sign) {
  const auto one = [&](const SpecCursor& c) { read_fixed(c, draft, dimension::dimensionless, sign); };
  if (at.is_scalar()) return one(at);
  if (at.is_list()) return read_each(at.items("a list of numbers"), one);
  for (const Member& member : list_members(at, "a number, or one for each actuator"))
    draft.problems.collect([&] { one(member.value); });
}

/// One number for all actuators, a list in their order, or a mapping with one for each.
VectorX read_per_actuator(const SpecCursor& at, StudyBuilder& draft, const DimensionOf& dimension,
                          SignConstraint sign) {
  const std::vector<CoordinateId>& actuators = draft.mechanism().actuators;
  const auto count = static_cast<Eigen::Index>(actuators.size());
  VectorX values = VectorX::Zero(count);
  const auto read = [&](const SpecCursor& c, Eigen::Index a) {
    values[a] = read_fixed(c, draft, dimension(kind_of(actuators[static_cast<std::size_t>(a)], draft)), sign);
  };
  if (actuators.empty() ? draft.problems.is_uncertain("actuators") : draft.problems.is_invalid("actuators")) {
    read_all_fixed(at, draft, sign);
    throw CascadingError();
  }
  if (!at.is_map() && !at.is_list()) {
    for (Eigen::Index a = 0; a < count; ++a) read(at, a);
    return values;
  }
  if (at.is_list()) {
    std::string wanted = "a number: the spec names no 'actuators'";
    if (count > 0)
      wanted =
          fmt::format("a number, or {} numbers, one for each of the actuators {}", count, names_of(actuators, draft));
    Eigen::Index a = 0;
    read_each(at.items(wanted, static_cast<std::size_t>(count)), [&](const SpecCursor& item) { read(item, a++); });
    return values;
  }
  std::vector<Field> fields;
  for (Eigen::Index a = 0; a < count; ++a) {
    const auto c = static_cast<std::size_t>(actuators[static_cast<std::size_t>(a)]);
    fields.push_back({draft.mechanism().coordinates[c].name, Presence::required,
                      [&read, a](const SpecCursor& entry) { read(entry, a); }});
  }
  read_fields(at, "a number, or one for each actuator", fields);
  return values;
}

/// One number, for laws that treat all coordinates alike.
VectorX read_single(const SpecCursor& at, StudyBuilder& draft, Dimension dimension) {
  if (!at.is_scalar()) at.fail_expected("one number for all coordinates: this law treats them alike");
  return VectorX::Constant(1, read_fixed(at, draft, dimension, SignConstraint::positive));
}

void read_measurement(const SpecCursor& at, StudyBuilder& draft, Measurement& measurement) {
  const auto position = [](CoordinateKind kind) { return dimension_of(kind); };
  const auto rate = [](CoordinateKind kind) { return dimension_of(kind) / dimension::time; };
  const auto values = [&](VectorX& target, const DimensionOf& dimension) {
    return [&target, &draft, dimension](const SpecCursor& c) {
      target = read_per_actuator(c, draft, dimension, SignConstraint::not_negative);
    };
  };
  std::optional<SpecCursor> noise;
  read_fields(at, "what is measured {position_step, position_noise, velocity_noise, velocity, seed}",
              {{"position_step", Presence::optional, values(measurement.position_step, position)},
               {"position_noise", Presence::optional, values(measurement.position_noise, position)},
               {"velocity_noise", Presence::optional,
                [&](const SpecCursor& c) {
                  noise = c;
                  values(measurement.velocity_noise, rate)(c);
                }},
               {"velocity", Presence::optional,
                [&](const SpecCursor& c) {
                  measurement.velocity = c.read_choice("where velocities come from", {"measured", "difference"}) == 0
                                             ? VelocitySource::measured
                                             : VelocitySource::difference;
                }},
               {"seed", Presence::optional, [&](const SpecCursor& c) {
                  measurement.seed = static_cast<std::uint64_t>(read_integer(c, draft, 0, max_seed));
                }}});
  if (noise && measurement.velocity == VelocitySource::difference)
    noise->fail(
        {.expected = "no 'velocity_noise' with 'velocity: difference', which has its noise from the positions"});
}

void read_efforts(const std::optional<SpecCursor>& torque, const std::optional<SpecCursor>& table,
                  const std::optional<SpecCursor>& file, StudyBuilder& draft, EffortTable& efforts) {
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

/// Which keys a type has beside the common ones.
std::vector<std::string> keys_of(ControllerType type) {
  switch (type) {
    case ControllerType::none: return {"initial_error"};
    case ControllerType::open_loop: return {"torque", "table", "file", "interpolation"};
    case ControllerType::pd: return {"kp", "kd", "bandwidth", "damping", "gravity"};
    case ControllerType::computed_torque: return {"kp", "kd", "bandwidth", "damping"};
    case ControllerType::sliding_mode: return {"lambda", "k", "bandwidth", "switching"};
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
                                     c.read_choice("a type of controller", controller_type_names()));
                               }}};
    for (const char* key :
         {"rate", "period", "bandwidth", "damping", "kp", "kd", "gravity", "lambda", "k", "switching", "projection",
          "torque", "table", "file", "interpolation", "torque_limit", "measurement", "model", "initial_error"})
      fields.push_back({key, Presence::optional, [this, key](const SpecCursor& c) { found_.emplace(key, c); }});
    read_fields(member.value, "a controller {type, …}", fields);
    const bool typed = !draft_.problems.is_uncertain(member.value.path() + ".type");
    if (typed) check_keys();
    read_common_keys();
    if (typed) read_gains();
    for (const char* key : {"kp", "kd", "lambda", "k"})
      if (!typed) read_key(key, [&](const SpecCursor& c) { read_all_fixed(c, draft_, SignConstraint::none); });
    read_open_loop(member.value);
    return controller_;
  }

 private:
  void read_open_loop(const SpecCursor& at) {
    const auto given = [&](const char* key) {
      const auto one = found_.find(key);
      return one == found_.end() ? std::nullopt : std::optional(one->second);
    };
    if (found_.count("torque") + found_.count("table") + found_.count("file") > 1)
      at.fail({.expected = "one of 'torque' (constant), 'table' and 'file'", .found = "several"});
    if (!draft_.problems.is_invalid("actuators"))
      read_efforts(given("torque"), given("table"), given("file"), draft_, controller_.efforts);
    controller_.efforts.is_held = found_.count("rate") + found_.count("period") > 0;
    read_key("interpolation", [&](const SpecCursor& c) {
      const bool curved = c.read_choice("how torques go on between rows", {"linear", "spline"}) == 1;
      if (found_.count("table") + found_.count("file") == 0)
        c.fail({.expected = "no 'interpolation' without 'table' or 'file'"});
      if (!curved) return;
      controller_.efforts.interpolation = EffortTable::Interpolation::spline;
      const std::size_t rows = controller_.efforts.time.size();
      if (rows > 0 && rows < 4)
        c.fail({.expected = "'linear', or at least four rows for a spline", .found = fmt::format("{} rows", rows)});
    });
  }

  void check_keys() const {
    std::vector<std::string> allowed = keys_of(controller_.type);
    if (controller_.type != ControllerType::none)
      allowed.insert(allowed.end(), std::begin(common_controller_keys), std::end(common_controller_keys));
    for (const auto& [key, cursor] : found_)
      draft_.problems.collect([&, &key = key, &cursor = cursor] {
        if (std::find(allowed.begin(), allowed.end(), key) == allowed.end())
          cursor.fail(
              {.expected = fmt::format("no '{}' with 'type: {}', which has {}", key,
                                       controller_type_name(controller_.type), join_with_conjunction(allowed, "and"))});
      });
  }

  template <class Read>
  void read_key(const char* key, Read&& read) {
    const auto at = found_.find(key);
    if (at != found_.end()) draft_.problems.collect([&] { read(at->second); });
  }

  void read_common_keys() {
    read_key("rate", [&](const SpecCursor& c) {
      if (found_.count("period") > 0) c.fail({.expected = "'rate' or 'period'", .found = "both"});
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
      read_key(key, [&](const SpecCursor& c) { target = read_per_actuator(c, draft_, dimension, sign); });
    };
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
                        : read_per_actuator(c, draft_, dimension, SignConstraint::positive);
    };
    const auto inverse = [](CoordinateKind) { return per_second; };
    read_key("lambda", [&](const SpecCursor& c) { sliding(c, inverse, controller_.lambda); });
    read_key("k", [&](const SpecCursor& c) { sliding(c, acceleration, controller_.switching_gain); });
    read_key("switching", [&](const SpecCursor& c) {
      const std::string what = "how to switch, 'sign' or {boundary_layer: …}";
      if (!c.is_map() && c.read_word(what) == "sign") return;
      read_fields(c, what, {{"boundary_layer", Presence::required, [&](const SpecCursor& layer) {
                               sliding(layer, rate, controller_.boundary_layer);
                             }}});
    });
    read_key("gravity", [&](const SpecCursor& c) {
      controller_.gravity = c.read_choice("whether weight is compensated", {"compensated", "ignored"}) == 0
                                ? GravityCompensation::compensated
                                : GravityCompensation::ignored;
    });
    read_key("projection", [&](const SpecCursor& c) {
      controller_.projection = c.read_choice("a projection", {"inertia", "identity"}) == 0
                                   ? AccelerationProjection::inertia
                                   : AccelerationProjection::identity;
    });
  }

  const YamlNode& root_;
  const SpecParameters::Overrides& overrides_;
  StudyBuilder& draft_;
  Controller controller_;
  std::map<std::string, SpecCursor> found_;
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
  for (Controller& built_in : built_in_controllers())
    if (std::none_of(controllers.begin(), controllers.end(),
                     [&](const Controller& known) { return known.name == built_in.name; }))
      controllers.push_back(std::move(built_in));
}

}  // namespace balance::specification
