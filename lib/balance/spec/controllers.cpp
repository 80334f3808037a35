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

namespace balance::read {

namespace {

/// A dimension per kind of coordinate.
using DimensionOf = std::function<Dimension(CoordinateKind)>;

Dimension effort_of(CoordinateKind kind) {
  return kind == CoordinateKind::angle ? dimension::moment : dimension::force;
}

constexpr Dimension per_second = dimension::none / dimension::time;

double read_fixed(const Cursor& at, Draft& draft, Dimension dimension, Sign sign) {
  if (at.is_map()) at.expected("a number or an expression");
  return read_number(at, draft, dimension, sign).value();
}

/// In 1/s whatever the spec's unit of time.
double read_hertz(const Cursor& at, Draft& draft) { return read_fixed(at, draft, dimension::none, Sign::positive); }

CoordinateKind kind_of(CoordinateId coordinate, const Draft& draft) {
  return draft.study.mechanism.coordinates[static_cast<std::size_t>(coordinate)].kind;
}

std::string names_of(const std::vector<CoordinateId>& actuators, const Draft& draft) {
  std::vector<std::string> names;
  for (const int c : actuators) names.push_back(draft.study.mechanism.coordinates[static_cast<std::size_t>(c)].name);
  return listed(names, "and");
}

/// Numbers of whatever actuators: only that they are numbers can be told.
void read_all_fixed(const Cursor& at, Draft& draft, Sign sign) {
  const auto one = [&](const Cursor& c) { read_fixed(c, draft, dimension::none, sign); };
  if (at.is_scalar()) return one(at);
  if (at.is_list()) return read_each(at.items("a list of numbers"), one);
  for (const Member& member : members(at, "a number, or one for each actuator"))
    draft.problems.guard([&] { one(member.value); });
}

/// One number for all actuators, a list in their order, or a mapping with one for each.
VectorX read_per_actuator(const Cursor& at, Draft& draft, const DimensionOf& dimension, Sign sign) {
  const std::vector<CoordinateId>& actuators = draft.mechanism().actuators;
  const auto count = static_cast<Eigen::Index>(actuators.size());
  VectorX values = VectorX::Zero(count);
  const auto read = [&](const Cursor& c, Eigen::Index a) {
    values[a] = read_fixed(c, draft, dimension(kind_of(actuators[static_cast<std::size_t>(a)], draft)), sign);
  };
  if (actuators.empty() ? draft.problems.doubtful("actuators") : draft.problems.spoilt("actuators")) {
    read_all_fixed(at, draft, sign);
    throw Consequence();
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
    read_each(at.items(wanted, static_cast<std::size_t>(count)), [&](const Cursor& item) { read(item, a++); });
    return values;
  }
  std::vector<Field> fields;
  for (Eigen::Index a = 0; a < count; ++a) {
    const auto c = static_cast<std::size_t>(actuators[static_cast<std::size_t>(a)]);
    fields.push_back(
        {draft.mechanism().coordinates[c].name, Need::required, [&read, a](const Cursor& entry) { read(entry, a); }});
  }
  read_fields(at, "a number, or one for each actuator", fields);
  return values;
}

/// One number, for laws that treat all coordinates alike.
VectorX read_single(const Cursor& at, Draft& draft, Dimension dimension) {
  if (!at.is_scalar()) at.expected("one number for all coordinates: this law treats them alike");
  return VectorX::Constant(1, read_fixed(at, draft, dimension, Sign::positive));
}

void read_measurement(const Cursor& at, Draft& draft, Measurement& measurement) {
  const auto position = [](CoordinateKind kind) { return dimension_of(kind); };
  const auto rate = [](CoordinateKind kind) { return dimension_of(kind) / dimension::time; };
  const auto values = [&](VectorX& target, const DimensionOf& dimension) {
    return [&target, &draft, dimension](const Cursor& c) {
      target = read_per_actuator(c, draft, dimension, Sign::not_negative);
    };
  };
  std::optional<Cursor> noise;
  read_fields(at, "what is measured {position_step, position_noise, velocity_noise, velocity, seed}",
              {{"position_step", Need::optional, values(measurement.position_step, position)},
               {"position_noise", Need::optional, values(measurement.position_noise, position)},
               {"velocity_noise", Need::optional,
                [&](const Cursor& c) {
                  noise = c;
                  values(measurement.velocity_noise, rate)(c);
                }},
               {"velocity", Need::optional,
                [&](const Cursor& c) {
                  measurement.velocity = c.choice("where velocities come from", {"measured", "difference"}) == 0
                                             ? VelocitySource::measured
                                             : VelocitySource::difference;
                }},
               {"seed", Need::optional, [&](const Cursor& c) {
                  measurement.seed = static_cast<std::uint64_t>(read_whole(c, draft, 0, max_seed));
                }}});
  if (noise && measurement.velocity == VelocitySource::difference)
    noise->fail(
        {.expected = "no 'velocity_noise' with 'velocity: difference', which has its noise from the positions"});
}

void read_efforts(const std::optional<Cursor>& torque, const std::optional<Cursor>& table,
                  const std::optional<Cursor>& file, Draft& draft, EffortTable& efforts) {
  const std::vector<CoordinateId>& actuators = draft.mechanism().actuators;
  if (torque) {
    efforts.time = {0};
    efforts.effort = {read_per_actuator(*torque, draft, effort_of, Sign::any)};
  }
  if (!table && !file) return;
  std::vector<Column> columns;
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

constexpr const char* common_keys[] = {"rate", "period", "torque_limit", "measurement", "model", "initial_error"};

class ControllerReader {
 public:
  ControllerReader(const Node& root, const Parameters::Overrides& overrides, Draft& draft)
      : root_(root), overrides_(overrides), draft_(draft) {}

  Controller read(const Member& member) {
    controller_.name = member.name;
    std::vector<Field> fields{{"type", Need::required, [&](const Cursor& c) {
                                 controller_.type = static_cast<ControllerType>(
                                     c.choice("a type of controller", controller_type_names()));
                               }}};
    for (const char* key :
         {"rate", "period", "bandwidth", "damping", "kp", "kd", "gravity", "lambda", "k", "switching", "projection",
          "torque", "table", "file", "interpolation", "torque_limit", "measurement", "model", "initial_error"})
      fields.push_back({key, Need::optional, [this, key](const Cursor& c) { found_.emplace(key, c); }});
    read_fields(member.value, "a controller {type, …}", fields);
    const bool typed = !draft_.problems.doubtful(member.value.path() + ".type");
    if (typed) check_keys();
    common();
    if (typed) gains();
    for (const char* key : {"kp", "kd", "lambda", "k"})
      if (!typed) on(key, [&](const Cursor& c) { read_all_fixed(c, draft_, Sign::any); });
    read_open_loop(member.value);
    return controller_;
  }

 private:
  void read_open_loop(const Cursor& at) {
    const auto given = [&](const char* key) {
      const auto one = found_.find(key);
      return one == found_.end() ? std::nullopt : std::optional(one->second);
    };
    if (found_.count("torque") + found_.count("table") + found_.count("file") > 1)
      at.fail({.expected = "one of 'torque' (constant), 'table' and 'file'", .found = "several"});
    if (!draft_.problems.spoilt("actuators"))
      read_efforts(given("torque"), given("table"), given("file"), draft_, controller_.efforts);
    controller_.efforts.held = found_.count("rate") + found_.count("period") > 0;
    on("interpolation", [&](const Cursor& c) {
      const bool curved = c.choice("how torques go on between rows", {"linear", "spline"}) == 1;
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
      allowed.insert(allowed.end(), std::begin(common_keys), std::end(common_keys));
    for (const auto& [key, cursor] : found_)
      draft_.problems.guard([&, &key = key, &cursor = cursor] {
        if (std::find(allowed.begin(), allowed.end(), key) == allowed.end())
          cursor.fail({.expected = fmt::format("no '{}' with 'type: {}', which has {}", key, name_of(controller_.type),
                                               listed(allowed, "and"))});
      });
  }

  template <class Read>
  void on(const char* key, Read&& read) {
    const auto at = found_.find(key);
    if (at != found_.end()) draft_.problems.guard([&] { read(at->second); });
  }

  void common() {
    on("rate", [&](const Cursor& c) {
      if (found_.count("period") > 0) c.fail({.expected = "'rate' or 'period'", .found = "both"});
    });
    on("rate", [&](const Cursor& c) { controller_.period = 1 / read_hertz(c, draft_); });
    on("period", [&](const Cursor& c) { controller_.period = read_fixed(c, draft_, dimension::time, Sign::positive); });
    on("bandwidth", [&](const Cursor& c) { controller_.bandwidth = read_hertz(c, draft_); });
    on("damping",
       [&](const Cursor& c) { controller_.damping = read_fixed(c, draft_, dimension::none, Sign::not_negative); });
    on("torque_limit", [&](const Cursor& c) {
      controller_.torque_limit = read_per_actuator(c, draft_, effort_of, Sign::not_negative);
    });
    on("measurement", [&](const Cursor& c) { read_measurement(c, draft_, controller_.measurement); });
    on("model", [&](const Cursor& c) { controller_.model = read_model(c, root_, overrides_, draft_); });
    on("initial_error", [&](const Cursor& c) { read_initial_error(c, draft_, controller_.initial_error); });
  }

  void gains() {
    const bool pd = controller_.type == ControllerType::pd;
    const bool extended = controller_.type == ControllerType::extended_sliding_mode;
    const auto gain = [&](const char* key, VectorX& target, const DimensionOf& dimension, Sign sign) {
      on(key, [&](const Cursor& c) { target = read_per_actuator(c, draft_, dimension, sign); });
    };
    gain(
        "kp", controller_.kp,
        [pd](CoordinateKind kind) { return pd ? effort_of(kind) / dimension_of(kind) : per_second * per_second; },
        Sign::not_negative);
    gain(
        "kd", controller_.kd,
        [pd](CoordinateKind kind) { return pd ? effort_of(kind) / dimension_of(kind) * dimension::time : per_second; },
        Sign::not_negative);
    const auto rate = [](CoordinateKind kind) { return dimension_of(kind) / dimension::time; };
    const auto acceleration = [](CoordinateKind kind) { return dimension_of(kind) * per_second * per_second; };
    const auto sliding = [&](const Cursor& c, const DimensionOf& dimension, VectorX& target) {
      target = extended ? read_single(c, draft_, dimension(CoordinateKind::angle))
                        : read_per_actuator(c, draft_, dimension, Sign::positive);
    };
    const auto inverse = [](CoordinateKind) { return per_second; };
    on("lambda", [&](const Cursor& c) { sliding(c, inverse, controller_.lambda); });
    on("k", [&](const Cursor& c) { sliding(c, acceleration, controller_.k); });
    on("switching", [&](const Cursor& c) {
      const std::string what = "how to switch, 'sign' or {boundary_layer: …}";
      if (!c.is_map() && c.word(what) == "sign") return;
      read_fields(c, what, {{"boundary_layer", Need::required, [&](const Cursor& layer) {
                               sliding(layer, rate, controller_.boundary_layer);
                             }}});
    });
    on("gravity", [&](const Cursor& c) {
      controller_.gravity = c.choice("whether weight is compensated", {"compensated", "ignored"}) == 0
                                ? Gravity::compensated
                                : Gravity::ignored;
    });
    on("projection", [&](const Cursor& c) {
      controller_.projection =
          c.choice("a projection", {"inertia", "identity"}) == 0 ? Projection::inertia : Projection::identity;
    });
  }

  const Node& root_;
  const Parameters::Overrides& overrides_;
  Draft& draft_;
  Controller controller_;
  std::map<std::string, Cursor> found_;
};

}  // namespace

void read_controllers(const Cursor* section, const Node& root, const Parameters::Overrides& overrides, Draft& draft) {
  std::vector<Controller>& controllers = draft.study.controllers;
  if (section != nullptr)
    draft.problems.guard([&] {
      for (const Member& member : named_members(*section, "a mapping of controllers {type, …}", Names::single))
        draft.problems.guard([&] { controllers.push_back(ControllerReader(root, overrides, draft).read(member)); });
    });
  for (Controller& built_in : built_in_controllers())
    if (std::none_of(controllers.begin(), controllers.end(),
                     [&](const Controller& known) { return known.name == built_in.name; }))
      controllers.push_back(std::move(built_in));
}

}  // namespace balance::read
