#include "balance/interface/files/result_summary.hpp"

#include "balance/interface/files/json.hpp"
#include "balance/interface/files/optimised_law_summary.hpp"
#include "balance/interface/files/order_summary.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/result_group.hpp"
#include "balance/interface/files/text_table.hpp"
#include "balance/interface/files/torque_distribution_summary.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace balance::files {

using results::ColumnKind;

// The numbers of a single state (mechanics/dynamics/single_state.hpp), as text and as JSON.

/// One scalar or vector.
struct StateEntry {
  std::string quantity;  ///< as in RunResult::metrics: "torque[A1]", "joint_force[B1]"
  std::string unit;
  std::vector<double> value;  ///< 0 if within round-off; NaN if undefined
};

/// @param result with one row
std::vector<StateEntry> list_state_entries(const RunResult& result);

/// @param description whose `pose` is not empty
std::string format_state(const RunResult& result, const Provenance& description, const TextOptions& options);
std::string state_json(const RunResult& result, const Provenance& description, const std::vector<std::string>& files);

namespace {

/// What the columns of a quantity belong to, in their order; one empty name if they belong to the whole mechanism.
std::vector<std::string> list_quantity_owners(ColumnKind columns, const RunResult& r) {
  switch (columns) {
    case ColumnKind::coordinate: return r.coordinate_names;
    case ColumnKind::actuator: return r.actuator_names;
    case ColumnKind::joint:
    case ColumnKind::joint_axis: return r.joint_names;
    case ColumnKind::constraint: return r.constraint_names;
    case ColumnKind::sliding: return r.sliding_names;
    case ColumnKind::body:
    case ColumnKind::body_axis:
    case ColumnKind::body_quaternion: return r.body_names;
    case ColumnKind::single:
    case ColumnKind::axis:
    case ColumnKind::quaternion: break;
  }
  return {""};
}

std::string format_value(const std::vector<double>& value, const DisplayUnit& unit) {
  std::string text;
  for (const double x : value)
    text += (text.empty() ? "" : ", ") + (std::isnan(x) ? "none" : format_number(unit.convert(x)));
  return text;
}

}  // namespace

std::vector<StateEntry> list_state_entries(const RunResult& result) {
  std::vector<StateEntry> entries;
  for (const Quantity& quantity : list_sampled_quantities(result)) {
    const Samples samples = suppress_round_off(result, quantity.member);
    const std::vector<std::string> owners = list_quantity_owners(quantity.columns, result);
    const auto width = samples.cols() / static_cast<Eigen::Index>(owners.size());
    for (std::size_t i = 0; i < owners.size(); ++i) {
      const std::string& unit = quantity.unit_of(i, owners.size());
      const std::string owner = owners[i].empty() ? "" : "[" + owners[i] + "]";
      StateEntry entry{
          (owner.empty() ? quantity.name : results::effort_display_name(quantity.name, unit)) + owner, unit, {}};
      for (Eigen::Index k = 0; k < width; ++k)
        entry.value.push_back(samples(0, static_cast<Eigen::Index>(i) * width + k));
      entries.push_back(std::move(entry));
    }
  }
  return entries;
}

std::string format_state(const RunResult& result, const Provenance& description, const TextOptions& options) {
  const DisplayUnit time = find_display_unit("s", options.units), length = find_display_unit("m", options.units);
  std::string text = fmt::format("{}: at {}, {:.6g} {}; moments about", description.title, description.pose,
                                 time.convert(result.time[0]), time.name);
  for (int axis = 0; axis < result.axes; ++axis)
    text += fmt::format("{} {:.6g}", axis == 0 ? "" : ",", length.convert(result.moment_reference[axis]));
  if (length.name != "m") text += " " + length.name;
  TextTable table{{"quantity", "unit", "value"}, {Align::left, Align::left, Align::left}, {}};
  for (const StateEntry& entry : list_state_entries(result)) {
    const DisplayUnit unit = find_display_unit(entry.unit, options.units);
    table.rows.push_back({entry.quantity, unit_cell(unit), format_value(entry.value, unit)});
  }
  return wrap_lines(text, options.width) + "\n\n" + format_table(table, options.width);
}

std::string state_json(const RunResult& result, const Provenance& description, const std::vector<std::string>& files) {
  Json json = {{"mechanism", description.title},
               {"balance_version", description.version},
               {"at", description.pose},
               {"time", result.time[0]},
               {"outcome", outcome_json(result.outcome)},
               {"about", vector_json(result.moment_reference, result.axes)},
               {"values", Json::array()}};
  for (const StateEntry& entry : list_state_entries(result))
    json["values"].push_back({{"quantity", entry.quantity},
                              {"unit", entry.unit},
                              {"value", entry.value.size() == 1 ? Json(entry.value[0]) : Json(entry.value)}});
  if (result.torque_distribution) json["torque_distribution"] = torque_distribution_json(result);
  json["notes"] = result.outcome.notes;
  json["files"] = files;
  return format_json(json);
}

std::string format_result_json(const RunResult& result, const Provenance& description,
                               const std::vector<std::string>& files) {
  if (!description.pose.empty()) return state_json(result, description, files);
  Json json = {{"mechanism", description.title},       {"balance_version", description.version},
               {"trajectory", description.trajectory}, {"law", description.law},
               {"drive", description.drive},           {"formulation", description.formulation}};
  if (!description.controller.empty()) {
    json["controller"] = description.controller;
    json["controller_type"] = description.controller_type;
  }
  json["outcome"] = outcome_json(result.outcome);
  json["samples"] = result.time.size();
  json["duration"] = result.time.size() == 0 ? 0 : result.time[result.time.size() - 1] - result.time[0];
  if (result.corridor_result) json["found_corridor"] = corridor_result_json(*result.corridor_result);
  if (result.optimised_law) json["found_law"] = optimised_law_json(*result.optimised_law);
  if (!result.payload_events.empty()) json["payload_changes"] = payload_events_json(result);
  if (!result.adaptation_moves.empty()) json["adaptation"] = adaptation_json(result);
  if (result.orders) json["orders"] = orders_json(*result.orders);
  json["about"] = vector_json(result.moment_reference, result.axes);
  json["metrics"] = metrics_json(result.metrics);
  json["energy"] = result.energy;
  if (result.torque_distribution) json["torque_distribution"] = torque_distribution_json(result);
  json["notes"] = result.outcome.notes;
  json["files"] = files;
  return format_json(json);
}

std::string format_error_json(const std::string& kind, const std::string& message) {
  return format_json({{"error", {{"kind", kind}, {"message", message}}}});
}

std::string format_error_json(const std::string& kind, const std::string& message, const std::string& status) {
  return format_json({{"error", {{"kind", kind}, {"message", message}, {"status", status}}}});
}

std::string format_error_json(const std::string& kind, const SpecError& error) {
  const auto count_or_null = [](int count) { return count > 0 ? Json(count) : Json(nullptr); };
  Json mistakes = Json::array();
  for (const Diagnostic& mistake : error.diagnostics())
    mistakes.push_back({{"file", text_or_null(mistake.place.file)},
                        {"line", count_or_null(mistake.place.line)},
                        {"column", count_or_null(mistake.place.column)},
                        {"key", text_or_null(mistake.place.key)},
                        {"message", mistake.message},
                        {"expected", text_or_null(mistake.expected)},
                        {"found", text_or_null(mistake.found)},
                        {"hint", text_or_null(mistake.hint)}});
  return format_json({{"error",
                       {{"kind", kind},
                        {"message", error.what()},
                        {"mistakes", std::move(mistakes)},
                        {"more", error.unlisted_count()}}}});
}

std::string format_error_json(const std::string& kind, const MotionOutcome& outcome) {
  return format_json(
      {{"error",
        {{"kind", kind}, {"message", outcome.reason}, {"status", name_of(outcome.status)}, {"time", outcome.time}}}});
}

namespace {

using Change = results::PayloadEvent;

/// An effort with five significant digits; 0 if it is within round-off.
std::string effort_text(const RunResult& result, const VectorX& efforts, std::size_t actuator,
                        const DisplayUnit& unit) {
  const auto a = static_cast<Eigen::Index>(actuator);
  const VectorX& round_offs = result.round_off.effort;
  const double round_off = a < round_offs.size() ? round_offs[a] : 0;
  return fmt::format("{:.5g}", std::abs(efforts[a]) <= round_off ? 0 : unit.convert(efforts[a]));
}

}  // namespace

std::string format_payload_events(const RunResult& result, const specification::SpecUnits& units) {
  const DisplayUnit time = find_display_unit("s", units);
  std::string text;
  for (const Change& change : result.payload_events) {
    text += fmt::format("{} {} at {:.6g} {}", change.payload, describe_payload_event(change), time.convert(change.time),
                        time.name);
    for (std::size_t a = 0; a < result.actuator_names.size(); ++a) {
      const DisplayUnit unit = find_display_unit(result.actuator_units[a], units);
      text += fmt::format("{} {} from {} to {} {}", a == 0 ? ":" : ",", result.actuator_names[a],
                          effort_text(result, change.effort_before, a, unit),
                          effort_text(result, change.effort_after, a, unit), unit.name);
    }
    text += "\n";
  }
  return text;
}

namespace {

ReportFields<Change> payload_event_fields(const RunResult& result) {
  const auto torques = [&result](const Change& change) {
    Json list = Json::array();
    for (std::size_t a = 0; a < result.actuator_names.size(); ++a) {
      const auto i = static_cast<Eigen::Index>(a);
      list.push_back({{"actuator", result.actuator_names[a]},
                      {"unit", result.actuator_units[a]},
                      {"before", change.effort_before[i]},
                      {"after", change.effort_after[i]}});
    }
    return list;
  };
  ReportFields<Change> fields{
      {[](const Change& change) { return change.payload + " " + describe_payload_event(change); },
       Hdf5Dataset{"payload taken up or set down", "change"}},
      {&Change::payload, JsonKey{"payload"}},
      {results::describe_payload_event, JsonKey{"change"}},
      {&Change::time, JsonKey{"time"}, Hdf5Dataset{"time of the change", "switch_time"}, SiUnit{"s"}},
      {&Change::speed, JsonKey{"speed"}, Hdf5Dataset{"speed of the payload's place at that time"}, SiUnit{"m/s"}},
      {&Change::angular_speed, JsonKey{"turning"}, SiUnit{"rad/s"},
       Hdf5Dataset{"angular velocity of its body at that time, if it has a moment of inertia"}},
      {torques, JsonKey{"torque"}}};
  if (!result.payload_events.empty() && result.payload_events.front().impact_loss)
    fields.push_back({[](const Change& change) { return change.impact_loss.value(); }, JsonKey{"impact_loss"},
                      Hdf5Dataset{"energy that the impact takes from everything that is taken up then"}, SiUnit{"J"}});
  if (result.actuator_names.empty()) return fields;
  fields.push_back({[](const Change& change) { return numbers_json(change.effort_before); },
                    Hdf5Dataset{"torque or force of the actuator just before", "torque_before"}});
  fields.push_back({[](const Change& change) { return numbers_json(change.effort_after); },
                    Hdf5Dataset{"torque or force of the actuator just after", "torque_after"}});
  return fields;
}

}  // namespace

Json payload_events_json(const RunResult& result) {
  return rows_json(result.payload_events, payload_event_fields(result));
}

void write_payload_events(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group parent, const RunResult& result) {
  if (result.payload_events.empty()) return;
  const hdf5::Hdf5Writer::Group group = file.add_group(parent, "payload_changes");
  std::optional<hdf5::Hdf5Writer::Dimension> actuator;
  if (!result.actuator_names.empty())
    actuator = file.add_dimension(group, {"actuator", "actuated joint coordinate", "1", {}, {}}, result.actuator_names);
  write_rows(file, group, result.payload_events, payload_event_fields(result),
             results::common_unit(result.actuator_units), actuator);
}

namespace {

using Move = results::AdaptationMove;

/// All moves together.
struct WholeAdaptation {
  double start = INFINITY, end = -INFINITY, work = 0, energy = 0;

  explicit WholeAdaptation(const std::vector<Move>& moves) {
    for (const Move& move : moves) {
      start = std::min(start, move.start), end = std::max(end, move.end);
      work += move.work, energy += move.energy;
    }
  }
};

ReportFields<Move> adaptation_fields(const RunResult& result) {
  const auto torques = [&result](const Move& move) {
    Json list = Json::array();
    for (std::size_t a = 0; a < result.actuator_names.size(); ++a)
      list.push_back({{"actuator", result.actuator_names[a]},
                      {"unit", result.actuator_units[a]},
                      {"peak", move.peak_effort[static_cast<Eigen::Index>(a)]}});
    return list;
  };
  return {{[](const Move& move) { return fmt::format("{} at {:.6g} s", move.counterweight, move.start); },
           Hdf5Dataset{"counterweight and start of its move", "move"}},
          {&Move::counterweight, JsonKey{"counterweight"}, Hdf5Dataset{"counterweight that moved"}},
          {&Move::start, JsonKey{"start"}, Hdf5Dataset{"start of the move", "start"}, SiUnit{"s"}},
          {&Move::end, JsonKey{"end"}, Hdf5Dataset{"end of the move", "end"}, SiUnit{"s"}},
          {&Move::from, JsonKey{"from"}, SiUnit{"m"},
           Hdf5Dataset{"distance from its place in the mechanism at the start", "from"}},
          {&Move::to, JsonKey{"to"}, SiUnit{"m"}, Hdf5Dataset{"distance from that place at the end", "to"}},
          {&Move::work, JsonKey{"work"}, Hdf5Dataset{"work of its actuator", "work"}, SiUnit{"J"}},
          {&Move::energy, JsonKey{"energy"}, SiUnit{"J"},
           Hdf5Dataset{"energy moved by its actuator, back and forth", "energy"}},
          {torques, JsonKey{"torque"}},
          {[](const Move& move) { return numbers_json(move.peak_effort); },
           Hdf5Dataset{"largest torque or force of every actuator during the move", "peak_torque"}}};
}

}  // namespace

std::string format_adaptation(const RunResult& result, const specification::SpecUnits& units) {
  const DisplayUnit time = find_display_unit("s", units), length = find_display_unit("m", units),
                    energy = find_display_unit("J", units);
  std::string text;
  for (const Move& move : result.adaptation_moves) {
    text +=
        fmt::format("{} moved from {:.6g} to {:.6g} {}, {:.6g} to {:.6g} {}: work {}, energy {} {}", move.counterweight,
                    length.convert(move.from), length.convert(move.to), length.name, time.convert(move.start),
                    time.convert(move.end), time.name, format_number(energy.convert(move.work)),
                    format_number(energy.convert(move.energy)), energy.name);
    for (std::size_t a = 0; a < result.actuator_names.size(); ++a) {
      const DisplayUnit unit = find_display_unit(result.actuator_units[a], units);
      text += fmt::format("{} {} {} {}", a == 0 ? "; peak" : ",", result.actuator_names[a],
                          effort_text(result, move.peak_effort, a, unit), unit.name);
    }
    text += "\n";
  }
  const WholeAdaptation whole(result.adaptation_moves);
  return text + fmt::format("adaptation: {:.6g} {}, work {}, energy {} {}\n", time.convert(whole.end - whole.start),
                            time.name, format_number(energy.convert(whole.work)),
                            format_number(energy.convert(whole.energy)), energy.name);
}

Json adaptation_json(const RunResult& result) {
  const WholeAdaptation whole(result.adaptation_moves);
  return {{"start", whole.start},
          {"end", whole.end},
          {"work", whole.work},
          {"energy", whole.energy},
          {"moves", rows_json(result.adaptation_moves, adaptation_fields(result))}};
}

void write_adaptation(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group parent, const RunResult& result) {
  if (result.adaptation_moves.empty()) return;
  const hdf5::Hdf5Writer::Group group = file.add_group(parent, "adaptation");
  const auto actuator =
      file.add_dimension(group, {"actuator", "actuated joint coordinate", "1", {}, {}}, result.actuator_names);
  write_rows(file, group, result.adaptation_moves, adaptation_fields(result),
             results::common_unit(result.actuator_units), std::optional(actuator));
}

const ReportFields<Metric>& metric_fields() {
  static const ReportFields<Metric> fields{
      {&Metric::quantity, JsonKey{"quantity"}, TextColumn{}, Hdf5Dataset{"quantity"}},
      {&Metric::unit, JsonKey{"unit"}, TextColumn{}, unit_name_or_1, Hdf5Dataset{"unit of the quantity"}},
      {&Metric::peak, JsonKey{"peak"}, TextColumn{"peak", six_digits}, Hdf5Dataset{"largest magnitude"}},
      {&Metric::peak_time, JsonKey{"peak_time"}, TextColumn{"at time", six_digits}, SiUnit{"s"},
       Hdf5Dataset{"time of the largest magnitude"}},
      {&Metric::rms, JsonKey{"rms"}, TextColumn{"rms", six_digits},
       Hdf5Dataset{"root of the time average of the squared magnitude"}},
      {&Metric::mean, JsonKey{"mean"}, TextColumn{"mean", six_digits}, Hdf5Dataset{"time average of the magnitude"}},
      {&Metric::range, JsonKey{"range"}, Hdf5Dataset{"largest minus smallest value (vectors: magnitude)"}},
      {&Metric::round_off, Hdf5Dataset{"values up to this count as 0 in the figures", "round_off"}}};
  return fields;
}

namespace {

/// Whether a row of the metrics says nothing: zeros of a single joint, actuator or constraint. Efforts and powers of
/// the actuators, and zeros of the whole mechanism, are answers.
bool is_trivial(const Metric& metric) {
  const std::string effort = results::effort_array_name(metric.quantity);
  const bool is_answer = effort.starts_with("torque") || effort.starts_with("power");
  const bool is_member = metric.quantity.find('[') != std::string::npos;
  const double largest = std::max({std::abs(metric.peak), std::abs(metric.rms), std::abs(metric.mean)});
  return is_member && !is_answer && largest <= metric.round_off;
}

std::string metrics_table(const RunResult& result, const TextOptions& options) {
  std::vector<Metric> shown;
  for (const Metric& metric : result.metrics)
    if (options.verbose || !is_trivial(metric)) shown.push_back(metric);
  TextTable table = rows_table(shown, metric_fields(), options.units);
  table.key_columns = 2;
  return format_table(table, options.width);
}

}  // namespace

std::string format_result_summary(const RunResult& result, const Provenance& description, const TextOptions& options) {
  if (!description.pose.empty()) return format_state(result, description, options);
  const DisplayUnit time = find_display_unit("s", options.units), energy = find_display_unit("J", options.units);
  const double duration = result.time.size() == 0 ? 0 : result.time[result.time.size() - 1] - result.time[0];
  const std::string controller =
      description.controller.empty()
          ? ""
          : fmt::format(", controller {} ({})", description.controller, description.controller_type);
  std::string text = fmt::format("{}: trajectory {} ({}, drive {}){}, {:.6g} {}, {} samples\n\n", description.title,
                                 description.trajectory, description.law, description.drive, controller,
                                 time.convert(duration), time.name, result.time.size());
  if (result.torque_distribution) text += format_torque_distribution(result, options.units) + "\n";
  if (result.corridor_result) text += format_corridor_result(*result.corridor_result, options.units) + "\n";
  if (result.optimised_law) text += format_optimised_law(*result.optimised_law, options) + "\n";
  if (!result.payload_events.empty()) text += format_payload_events(result, options.units) + "\n";
  if (!result.adaptation_moves.empty()) text += format_adaptation(result, options.units) + "\n";
  return wrap_lines(text, options.width) + metrics_table(result, options) +
         fmt::format("\nenergy moved by the actuators: {} {}\n", format_number(energy.convert(result.energy)),
                     energy.name) +
         (result.orders ? "\n" + format_orders(*result.orders, options) : "");
}

}  // namespace balance::files
