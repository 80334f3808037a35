// Loads, springs, friction.

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/interface/specification/read_catalogue.hpp"
#include "balance/interface/specification/spec_table.hpp"
#include "balance/interface/specification/study_builder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::specification {

namespace {

/// A number in the plane (about z), three in space.
Vector3E read_moment(const SpecCursor& at, StudyBuilder& draft) {
  if (!draft.planar()) return read_vector(at, draft, dimension::moment);
  return {Expression(0), Expression(0), read_number(at, draft, dimension::moment)};
}

/// Columns of a load's table and the slots of their values: 0–2 force, 3–5 moment.
struct LoadColumns {
  std::vector<TableColumn> columns;
  std::vector<int> slots;
};

LoadColumns load_columns(bool planar) {
  LoadColumns result;
  const std::vector<std::pair<const char*, int>> names =
      planar
          ? std::vector<std::pair<const char*, int>>{{"fx", 0}, {"fy", 1}, {"m", 5}}
          : std::vector<std::pair<const char*, int>>{{"fx", 0}, {"fy", 1}, {"fz", 2}, {"mx", 3}, {"my", 4}, {"mz", 5}};
  for (const auto& [name, slot] : names) {
    result.columns.push_back({name, slot < 3 ? dimension::force : dimension::moment});
    result.slots.push_back(slot);
  }
  return result;
}

void assign_load_table(const TimeTable& table, const LoadColumns& columns, model::LoadOf<Expression>& load) {
  load.arguments = table.time;
  for (const auto& row : table.values) {
    Vector3E wrench[2] = {Vector3E::Zero(), Vector3E::Zero()};
    for (std::size_t i = 0; i < row.size(); ++i) {
      const int slot = columns.slots[static_cast<std::size_t>(table.columns[i])];
      wrench[slot / 3][slot % 3] = row[i];
    }
    load.force.push_back(wrench[0]);
    load.moment.push_back(wrench[1]);
  }
}

/// `[[t, fx, fy], …]`, with the moment as further entries if the first row has them.
void read_rows(const SpecCursor& at, const TableColumn& argument, StudyBuilder& draft,
               model::LoadOf<Expression>& load) {
  LoadColumns columns = load_columns(draft.planar());
  const auto rows = at.items(fmt::format("a list of rows [{}, force …, moment …]", argument.name));
  const std::size_t forces = draft.planar() ? 2 : 3;
  if (!rows.empty() && rows[0].node().items.size() == forces + 1) columns.columns.resize(forces);
  assign_load_table(read_inline_table(at, draft, columns.columns, argument), columns, load);
}

/// `{time: […], force: [[…], …], moment: […]}`.
void read_lists(const SpecCursor& at, const TableColumn& argument, StudyBuilder& draft,
                model::LoadOf<Expression>& load) {
  std::optional<SpecCursor> force, moment;
  const bool is_time = argument.dimension == dimension::time;
  const std::string plural = is_time ? "times" : "values of " + argument.name;
  const bool read =
      read_fields(at, fmt::format("a table {{{}, force, moment}}", argument.name),
                  {{argument.name, Presence::required,
                    [&](const SpecCursor& c) {
                      load.arguments = read_numbers(c, draft, argument.dimension, "a list of " + plural);
                      if (load.arguments.empty())
                        c.fail_expected("at least one " + (is_time ? "time" : "value of " + argument.name));
                      check_increasing(c, load.arguments, argument);
                    }},
                   {"force", Presence::optional, [&](const SpecCursor& c) { force = c; }},
                   {"moment", Presence::optional, [&](const SpecCursor& c) { moment = c; }}});
  if (read && !force && !moment)
    at.fail({.kind = "missing key", .expected = "'force' or 'moment'", .found = "neither"});
  load.force.assign(load.arguments.size(), Vector3E::Zero());
  load.moment = load.force;
  const std::string what =
      fmt::format("{} entries, one for each {}", load.arguments.size(), is_time ? "time" : "value of " + argument.name);
  const auto read_entries = [&](const SpecCursor& entries, std::vector<Vector3E>& values, const auto& read_one) {
    std::vector<Vector3E> entry_values;
    // only the times determine the required number
    read_each(read ? entries.items(what, load.arguments.size())
                   : entries.items("a list of entries, one for each " + argument.name),
              [&](const SpecCursor& item) { entry_values.push_back(read_one(item)); });
    if (read) values = std::move(entry_values);
  };
  if (force)
    draft.problems.collect([&] {
      read_entries(*force, load.force, [&](const SpecCursor& c) { return read_vector(c, draft, dimension::force); });
    });
  if (moment)
    draft.problems.collect(
        [&] { read_entries(*moment, load.moment, [&](const SpecCursor& c) { return read_moment(c, draft); }); });
}

/// Keys of a load, before they are assembled.
struct LoadKeys {
  std::optional<BodyId> body;
  std::optional<SpecCursor> place, force, moment, table, file, over, period, interpolation;
};

void check_load_form(const SpecCursor& at, const LoadKeys& keys) {
  const bool constant = keys.force || keys.moment;
  const int form_count = (constant ? 1 : 0) + (keys.table ? 1 : 0) + (keys.file ? 1 : 0);
  if (form_count == 1) return;
  const std::string expected = "one of: 'force' and 'moment' (constant), 'table', 'file'";
  const std::string found = form_count > 1 ? "several" : "none";
  ErrorMessage error_message{
      .message = fmt::format("expected {}; found {}", expected, found), .expected = expected, .found = found};
  // A misspelt key may be one of them.
  if (form_count == 0)
    at.fail_unless_uncertain(at.path() + ".force", std::move(error_message));
  else
    at.fail(std::move(error_message));
}

/// What the load's table depends on: the time, or the coordinate under `over`.
TableColumn read_argument(const LoadKeys& keys, const StudyBuilder& draft, model::LoadOf<Expression>& load) {
  if (!keys.over) return time_column;
  load.coordinate = read_coordinate(*keys.over, draft);
  const Coordinate& coordinate = draft.mechanism().coordinates[static_cast<std::size_t>(load.coordinate)];
  return {coordinate.name, dimension_of(coordinate.kind)};
}

/// `turn`, or a number in the coordinate's unit.
Expression read_period(const SpecCursor& at, const TableColumn& argument, StudyBuilder& draft) {
  if (!at.is_scalar() || at.node().text != "turn")
    return read_number(at, draft, argument.dimension, SignConstraint::positive);
  if (argument.dimension == dimension::angle) return 2 * std::numbers::pi;
  at.fail({.expected = fmt::format("a number: {} is a displacement", argument.name), .found = "'turn'"});
}

/// Lets the table end as it starts, one period later: the last row may be given or not.
void close_table(const SpecCursor& at, const Expression& period, model::LoadOf<Expression>& load) {
  constexpr double end_tolerance = 1e-9;  // of a period: multiples of π are often rounded
  const double length = (load.arguments.back() - load.arguments.front()).value();
  const double excess = length / period.value() - 1;
  if (excess > end_tolerance)
    at.fail({.expected = fmt::format("rows over one period of {:.9g}", period.value()),
             .found = fmt::format("rows over {:.9g}", length)});
  if (excess >= -end_tolerance) {
    const auto differs = [](const Vector3E& a, const Vector3E& b) {
      return a.x().value() != b.x().value() || a.y().value() != b.y().value() || a.z().value() != b.z().value();
    };
    if (differs(load.force.front(), load.force.back()) || differs(load.moment.front(), load.moment.back()))
      at.fail({.expected = "a last row with the values of the first, because it is one period later",
               .found = "different values"});
    load.arguments.pop_back(), load.force.pop_back(), load.moment.pop_back();
  }
  load.arguments.push_back(load.arguments.front() + period);
  load.force.push_back(Vector3E(load.force.front()));
  load.moment.push_back(Vector3E(load.moment.front()));
  load.is_periodic = true;
}

void read_load_table(const LoadKeys& keys, StudyBuilder& draft, model::LoadOf<Expression>& load) {
  const TableColumn argument = read_argument(keys, draft, load);
  if (keys.file) {
    const LoadColumns columns = load_columns(draft.planar());
    assign_load_table(read_table_file(*keys.file, draft, columns.columns, argument), columns, load);
  } else if (keys.table->is_map()) {
    read_lists(*keys.table, argument, draft, load);
  } else {
    read_rows(*keys.table, argument, draft, load);
  }
  const SpecCursor& table = keys.file ? *keys.file : *keys.table;
  if (keys.interpolation)
    load.is_spline = keys.interpolation->read_choice("an interpolation", {"linear", "spline"}) == 1;
  if (keys.period) close_table(table, read_period(*keys.period, argument, draft), load);
  const std::size_t rows = load.arguments.size() - (load.is_periodic ? 1 : 0), min_rows = load.is_periodic ? 3 : 2;
  if (load.is_spline && rows < min_rows)
    table.fail({.expected = fmt::format("at least {} rows for a spline", min_rows), .found = fmt::format("{}", rows)});
}

/// A force or a moment as an expression of a coordinate.
Expression evaluate_over(const SpecCursor& at, const TableColumn& argument, const Expression& x, Dimension dimension,
                         StudyBuilder& draft) {
  const double unit = draft.units.factor(argument.dimension);
  const Expression value = draft.parameters.evaluate(
      at, {argument.name},
      [&](const std::string&, const Expression* parameter) { return parameter != nullptr ? *parameter : x / unit; });
  return value * draft.units.factor(dimension);
}

/// The largest distance of the closed spline through every second row from the row between, as a part of the largest value.
double find_spline_error(const model::LoadOf<Expression>& load) {
  const std::size_t rows = load.arguments.size();
  std::vector<double> knots;
  Samples values(static_cast<Eigen::Index>(rows / 2 + 1), 6);
  const auto value_of = [&](std::size_t row, Eigen::Index c) {
    return (c < 3 ? load.force : load.moment)[row % rows][c % 3].value();
  };
  const double period = 2 * load.arguments[rows / 2].value() - 2 * load.arguments[0].value();
  for (std::size_t row = 0; row <= rows; row += 2) {
    knots.push_back(row < rows ? load.arguments[row].value() : load.arguments[0].value() + period);
    for (Eigen::Index c = 0; c < 6; ++c) values(static_cast<Eigen::Index>(row / 2), c) = value_of(row, c);
  }
  const numerics::CubicSpline spline(knots, values, numerics::SplineEnd::periodic);
  VectorX value(6), first(6), second(6);
  double error = 0, largest = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    spline.at(load.arguments[row].value(), value, first, second);
    for (Eigen::Index c = 0; c < 6; ++c) {
      error = std::max(error, std::abs(value[c] - value_of(row, c)));
      largest = std::max(largest, std::abs(value_of(row, c)));
    }
  }
  return largest > 0 ? error / largest : 0;
}

/// Forces and moments as expressions of a coordinate that repeats: rows that a closed spline joins, as many as make it
/// follow the expressions.
void read_load_expressions(const LoadKeys& keys, StudyBuilder& draft, model::LoadOf<Expression>& load) {
  constexpr std::size_t min_rows = 64, max_rows = 1024;
  constexpr double sought_error = 1e-9 * 16, accepted_error = 1e-6 * 16;  // half as many rows: 16 times the error
  const TableColumn argument = read_argument(keys, draft, load);
  if (!keys.period)
    keys.over->fail({.expected = "'period' (turn, or a number) with expressions of a coordinate", .found = "none"});
  if (keys.interpolation) keys.interpolation->fail({.expected = "no 'interpolation' of expressions, which are smooth"});
  const Expression period = read_period(*keys.period, argument, draft);
  load.is_periodic = load.is_spline = true;
  double error = 0;
  for (std::size_t rows = min_rows; rows <= max_rows; rows *= 2) {
    load.arguments.clear(), load.force.clear(), load.moment.clear();
    for (std::size_t row = 0; row < rows; ++row) {
      const Expression x = period * (static_cast<double>(row) / static_cast<double>(rows));
      Vector3E force = Vector3E::Zero(), moment = Vector3E::Zero();
      if (keys.force) {
        const auto entries = keys.force->items("a force [fx, fy …]", draft.planar() ? 2 : 3);
        for (std::size_t c = 0; c < entries.size(); ++c)
          force[static_cast<Eigen::Index>(c)] = evaluate_over(entries[c], argument, x, dimension::force, draft);
      }
      if (keys.moment && draft.planar()) {
        moment.z() = evaluate_over(*keys.moment, argument, x, dimension::moment, draft);
      } else if (keys.moment) {
        const auto entries = keys.moment->items("a moment [mx, my, mz]", 3);
        for (std::size_t c = 0; c < entries.size(); ++c)
          moment[static_cast<Eigen::Index>(c)] = evaluate_over(entries[c], argument, x, dimension::moment, draft);
      }
      for (const Vector3E* vector : {&force, &moment})
        for (const Expression& entry : *vector)
          if (!std::isfinite(entry.value()))
            (keys.moment ? *keys.moment : *keys.force)
                .fail({.expected = "a finite value everywhere",
                       .found = fmt::format("none at {} = {:.6g}", argument.name,
                                            x.value() / draft.units.factor(argument.dimension))});
      load.arguments.push_back(x), load.force.push_back(force), load.moment.push_back(moment);
    }
    error = find_spline_error(load);
    if (error <= sought_error) break;
  }
  if (error > accepted_error)
    (keys.moment ? *keys.moment : *keys.force)
        .fail({.expected = "a smooth expression that repeats after the period; what jumps or has a kink is a 'table'"});
  load.arguments.push_back(period);
  load.force.push_back(Vector3E(load.force.front()));
  load.moment.push_back(Vector3E(load.moment.front()));
}

void read_load_values(const LoadKeys& keys, StudyBuilder& draft, model::LoadOf<Expression>& load) {
  if (keys.period && !keys.over)
    keys.period->fail({.expected = "'over' with the coordinate that repeats", .found = "'period' alone"});
  if (keys.table || keys.file) return read_load_table(keys, draft, load);
  if (keys.over) return read_load_expressions(keys, draft, load);
  if (keys.interpolation)
    keys.interpolation->fail({.expected = "'table' or 'file' for a load that changes", .found = "'interpolation'"});
  Vector3E force = Vector3E::Zero(), moment = Vector3E::Zero();
  if (keys.force) draft.problems.collect([&] { force = read_vector(*keys.force, draft, dimension::force); });
  if (keys.moment) draft.problems.collect([&] { moment = read_moment(*keys.moment, draft); });
  load.force.push_back(force);
  load.moment.push_back(moment);
}

void read_load(const SpecCursor& at, StudyBuilder& draft, model::LoadOf<Expression>& load) {
  LoadKeys keys;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  const auto read_carrier = [&](const SpecCursor& c) {
    const BodyId body = read_body(c, draft);
    if (body == model::ground) c.fail({.expected = "a moving body", .found = "the ground"});
    keys.body = body;
  };
  read_fields(
      at, "a load {body, at, force, moment}",
      {{"body", Presence::required, read_carrier, "on"},
       {"at", Presence::optional, store_in(keys.place)},
       {"force", Presence::optional, store_in(keys.force)},
       {"moment", Presence::optional, store_in(keys.moment)},
       {"table", Presence::optional, store_in(keys.table)},
       {"file", Presence::optional, store_in(keys.file)},
       {"over", Presence::optional, store_in(keys.over)},
       {"period", Presence::optional, store_in(keys.period)},
       {"interpolation", Presence::optional, store_in(keys.interpolation)},
       {"frame", Presence::optional, [&](const SpecCursor& c) {
          load.frame = c.read_choice("a frame", {"world", "body"}) == 0 ? model::Frame::world : model::Frame::body;
        }}});
  if (!at.is_map()) return;
  load.body = keys.body.value_or(model::ground);
  if (!draft.problems.collect([&] { check_load_form(at, keys); })) return;
  if (keys.place) draft.problems.collect([&] { load.point = read_position(*keys.place, draft, keys.body); });
  read_load_values(keys, draft, load);
}

/// Keys of a spring; the units of its numbers depend on where it is.
struct SpringKeys {
  std::optional<SpecCursor> between, joint, stiffness, free_length, rest, preload, damping;
  std::optional<SpecCursor> initial_tension, shortest_length, longest_length, cable;
  CatalogueKeys catalogue;
};

/// A spring is between points or in a joint; each kind has its own keys.
void check_spring_form(const SpecCursor& at, const SpringKeys& keys) {
  const auto fail_exclusive = [&](const std::string& expected, bool both) {
    const std::string found = both ? "both" : "neither";
    at.fail_unless_uncertain(
        at.path() + ".between",
        {.message = fmt::format("expected {}; found {}", expected, found), .expected = expected, .found = found});
  };
  if (keys.between.has_value() == keys.joint.has_value())
    fail_exclusive("one of: 'between' (two points), 'joint' (a coordinate)", keys.between.has_value());
  if (keys.rest && keys.preload) fail_exclusive("one of: 'rest' (a coordinate), 'preload' (at zero)", true);
  const std::string length = "'free_length' for a spring between points";
  for (const auto& [entry, name] :
       {std::pair(&keys.initial_tension, "'initial_tension'"), std::pair(&keys.shortest_length, "'shortest_length'"),
        std::pair(&keys.longest_length, "'longest_length'"), std::pair(&keys.cable, "'cable'")})
    if (keys.joint && *entry)
      (*entry)->fail(
          {.expected = fmt::format("{} only of a spring between points", name), .found = "a spring in a joint"});
  if (!keys.catalogue.catalogue) {
    if (!keys.stiffness) at.fail_missing({"stiffness"});
    if (keys.catalogue.columns)
      keys.catalogue.columns->fail({.expected = "'catalogue' (a file) as well", .found = "none"});
  }
  const std::string rest = "'rest' or 'preload' for a spring in a joint";
  if (keys.joint && keys.free_length) keys.free_length->fail({.expected = rest, .found = "'free_length'"});
  for (const auto& [entry, name] : {std::pair(&keys.rest, "'rest'"), std::pair(&keys.preload, "'preload'")})
    if (keys.between && *entry) (*entry)->fail({.expected = length, .found = name});
}

/// Force at an end of the straight line of a spring's law, and the lengths for which it holds. `count` equal springs
/// side by side are one of their stiffness together; an inextensible cable in series adds to all lengths.
void read_spring_travel(const SpringKeys& keys, const CatalogueNumbers* catalogue, StudyBuilder& draft,
                        model::SpringOf<Expression>& spring) {
  const auto read = [&](const char* name, const std::optional<SpecCursor>& key, Dimension number_dimension) {
    std::optional<Expression> number;
    draft.problems.collect([&] {
      number =
          choose_number(catalogue, name, key ? &*key : nullptr, draft, number_dimension, SignConstraint::not_negative);
    });
    return number;
  };
  const Expression cable = read("cable", keys.cable, dimension::length).value_or(0);
  const Expression closed = read("free_length", keys.free_length, dimension::length).value_or(0);
  const std::optional<Expression> tension = read("initial_tension", keys.initial_tension, dimension::force);
  spring.shortest_length = read("shortest_length", keys.shortest_length, dimension::length);
  spring.longest_length = read("longest_length", keys.longest_length, dimension::length);
  if (spring.shortest_length && spring.longest_length &&
      spring.shortest_length->value() > spring.longest_length->value())
    (keys.longest_length ? *keys.longest_length : *keys.catalogue.catalogue)
        .fail({.expected = "a 'longest_length' of at least the 'shortest_length'",
               .found = fmt::format("{:.6g} m and {:.6g} m", spring.longest_length->value(),
                                    spring.shortest_length->value())});
  spring.free_length = closed;
  if (tension) {
    // the length at which the tension would vanish; a spring without stiffness is absent
    const Expression line = closed - *tension / spring.stiffness;
    constexpr double round_off = 1e-14;
    const Expression is_zero = expression::less_equal(expression::abs(line), round_off * closed);
    const Expression is_absent = expression::equal(spring.stiffness, 0);
    spring.free_length = expression::select(is_absent, closed, expression::select(is_zero, 0, line));
    spring.slack_length = closed + cable;
  }
  spring.free_length = spring.free_length + cable;
  for (std::optional<Expression>* end : {&spring.shortest_length, &spring.longest_length})
    if (*end) *end = **end + cable;
}

/// What a catalogue may say of a spring.
std::vector<CatalogueProperty> list_spring_properties(bool is_joint_spring, Dimension force, Dimension displacement) {
  if (is_joint_spring)
    return {{"stiffness", force / displacement},
            {"rest", displacement, SignConstraint::none},
            {"preload", force, SignConstraint::none}};
  return {{"stiffness", force / displacement},
          {"free_length", displacement},
          {"initial_tension", force},
          {"shortest_length", displacement},
          {"longest_length", displacement}};
}

void read_spring(const SpecCursor& at, StudyBuilder& draft, model::SpringOf<Expression>& spring) {
  SpringKeys keys;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  std::vector<Field> fields{{"between", Presence::optional, store_in(keys.between)},
                            {"joint", Presence::optional, store_in(keys.joint)},
                            {"stiffness", Presence::optional, store_in(keys.stiffness)},
                            {"table", Presence::optional, [](const SpecCursor&) {}},  // read_tabulated_spring()
                            {"free_length", Presence::optional, store_in(keys.free_length)},
                            {"initial_tension", Presence::optional, store_in(keys.initial_tension)},
                            {"shortest_length", Presence::optional, store_in(keys.shortest_length)},
                            {"longest_length", Presence::optional, store_in(keys.longest_length)},
                            {"cable", Presence::optional, store_in(keys.cable)},
                            {"rest", Presence::optional, store_in(keys.rest)},
                            {"preload", Presence::optional, store_in(keys.preload)},
                            {"damping", Presence::optional, store_in(keys.damping)}};
  for (Field& field : keys.catalogue.fields()) fields.push_back(std::move(field));
  read_fields(at, "a spring {between or joint, stiffness}", fields);
  if (!at.is_map() || !draft.problems.collect([&] { check_spring_form(at, keys); })) return;
  Dimension displacement = dimension::length, force = dimension::force;
  const auto read_joint = [&] {
    spring.coordinate = read_coordinate(*keys.joint, draft);
    const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(spring.coordinate)].kind;
    displacement = dimension_of(kind);
    if (kind == CoordinateKind::angle) force = dimension::moment;
  };
  if (keys.between) draft.problems.collect([&] { read_connection_points(*keys.between, draft, spring); });
  if (keys.joint && !draft.problems.collect(read_joint)) return;
  Expression rest;
  const auto read = [&](const std::optional<SpecCursor>& c, Expression& number, const Dimension& number_dimension,
                        SignConstraint sign) {
    if (c) draft.problems.collect([&] { number = read_number(*c, draft, number_dimension, sign); });
  };
  std::optional<CatalogueNumbers> catalogue;
  Expression count = 1;
  if (keys.catalogue.catalogue) {
    catalogue = read_catalogue(at.path(), keys.catalogue, draft,
                               list_spring_properties(keys.joint.has_value(), force, displacement));
    count = catalogue->count;
  } else if (keys.catalogue.count) {
    count = static_cast<double>(read_integer(*keys.catalogue.count, draft, 1, 1000));
  }
  const CatalogueNumbers* row = catalogue ? &*catalogue : nullptr;
  const auto read_either = [&](const char* name, const std::optional<SpecCursor>& key, Expression& number,
                               Dimension number_dimension, SignConstraint sign) {
    std::optional<Expression> found;
    draft.problems.collect(
        [&] { found = choose_number(row, name, key ? &*key : nullptr, draft, number_dimension, sign); });
    if (found) number = *found;
    return found.has_value();
  };
  const bool has_stiffness =
      read_either("stiffness", keys.stiffness, spring.stiffness, force / displacement, SignConstraint::not_negative);
  if (row != nullptr && !has_stiffness && !keys.stiffness)
    keys.catalogue.catalogue->fail(
        {.expected = "a catalogue with a column of 'stiffness', or that key", .found = "none"});
  if (keys.between) read_spring_travel(keys, row, draft, spring);
  const bool has_preload = read_either("preload", keys.preload, spring.preload, force, SignConstraint::none);
  const bool has_rest = read_either("rest", keys.rest, rest, displacement, SignConstraint::none);
  if (has_preload && has_rest) at.fail({.expected = "'rest' or 'preload'", .found = "both"});
  if (has_rest) spring.preload = spring.stiffness * rest;
  spring.stiffness = count * spring.stiffness;
  spring.preload = count * spring.preload;
  if (!keys.damping) return;
  if (keys.between) return add_spring_damper(*keys.damping, spring, draft);
  model::FrictionOf<Expression> damper;
  damper.coordinate = spring.coordinate;
  read(keys.damping, damper.viscous, force / displacement * dimension::time, SignConstraint::not_negative);
  draft.dampers.push_back(damper);
}

/// Dry friction: one number for both directions, or {forward, backward}.
void read_dry_friction(const SpecCursor& at, StudyBuilder& draft, Dimension effort, Expression& forward,
                       std::optional<Expression>& backward) {
  const auto is_direction = [](const YamlNode& key) { return key.text == "forward" || key.text == "backward"; };
  if (!at.is_map() || std::none_of(at.node().keys.begin(), at.node().keys.end(), is_direction)) {
    forward = read_number(at, draft, effort, SignConstraint::not_negative);
    return;
  }
  read_fields(at, "a number, or dry friction {forward, backward}",
              {{"forward", Presence::required,
                [&](const SpecCursor& c) { forward = read_number(c, draft, effort, SignConstraint::not_negative); }},
               {"backward", Presence::required,
                [&](const SpecCursor& c) { backward = read_number(c, draft, effort, SignConstraint::not_negative); }}});
}

void read_one_friction(const Member& member, StudyBuilder& draft) {
  model::FrictionOf<Expression> friction;
  friction.coordinate = find_coordinate(member.key, member.name, draft);
  const bool is_angle =
      draft.mechanism().coordinates[static_cast<std::size_t>(friction.coordinate)].kind == CoordinateKind::angle;
  const Dimension effort = is_angle ? dimension::moment : dimension::force;
  std::optional<SpecCursor> static_entry;
  std::optional<Expression> offset;
  const Dimension rate = (is_angle ? dimension::angle : dimension::length) / dimension::time;
  if (!read_fields(member.value, "friction {viscous, coulomb, static, offset}",
                   {{"viscous", Presence::optional,
                     [&](const SpecCursor& c) {
                       friction.viscous = read_number(c, draft, effort / rate, SignConstraint::not_negative);
                     }},
                    {"coulomb", Presence::optional,
                     [&](const SpecCursor& c) {
                       read_dry_friction(c, draft, effort, friction.coulomb, friction.coulomb_backward);
                     }},
                    {"static", Presence::optional,
                     [&](const SpecCursor& c) {
                       Expression forward;
                       read_dry_friction(c, draft, effort, forward, friction.at_rest_backward);
                       friction.breakaway = forward;
                       static_entry = c;
                     }},
                    {"offset", Presence::optional,
                     [&](const SpecCursor& c) { offset = read_number(c, draft, effort, SignConstraint::none); }}}))
    return;
  if (member.value.node().items.empty()) member.value.fail_expected("'viscous', 'coulomb', 'static' or 'offset'");
  for (const int sign : {1, -1})
    if (friction.static_limit(sign).value() < friction.dry_friction(sign).value())
      static_entry->fail_expected("at least as much as 'coulomb'");
  draft.mechanism().friction.push_back(friction);
  if (!offset) return;
  model::SpringOf<Expression> constant;  // a spring in the joint whose effort does not depend on the coordinate
  constant.name = member.name + ".offset";
  constant.coordinate = friction.coordinate;
  constant.preload = -*offset;
  draft.mechanism().springs.push_back(std::move(constant));
}

}  // namespace

void read_loads(const SpecCursor& section, StudyBuilder& draft) {
  for (const Member& member : list_named_members(section, "a mapping of loads {body, at, force}")) {
    model::LoadOf<Expression> load;
    load.name = member.name;
    draft.problems.collect([&] { read_load(member.value, draft, load); });
    draft.mechanism().loads.push_back(std::move(load));
  }
}

void read_springs(const SpecCursor& section, StudyBuilder& draft) {
  for (const Member& member : list_named_members(section, "a mapping of springs {between or joint, stiffness}")) {
    if (member.value.has_entry("table")) {
      draft.problems.collect([&] { read_tabulated_spring(member.value, member.name, draft); });
      continue;
    }
    model::SpringOf<Expression> spring;
    spring.name = member.name;
    draft.problems.collect([&] { read_spring(member.value, draft, spring); });
    draft.mechanism().springs.push_back(std::move(spring));
  }
}

void read_friction(const SpecCursor& section, StudyBuilder& draft) {
  for (const Member& member :
       list_members(section, "a mapping of joint coordinates to friction {viscous, coulomb, static, offset}"))
    draft.problems.collect([&] { read_one_friction(member, draft); });
}

}  // namespace balance::specification
