#include "balance/write/state_text.hpp"

#include "balance/result/effort_names.hpp"
#include "balance/result/quantities.hpp"
#include "balance/result/round_off.hpp"
#include "balance/write/json_parts.hpp"
#include "balance/write/table.hpp"

#include <fmt/format.h>

#include <cmath>

namespace balance {
namespace {

/// What the columns of a quantity belong to, in their order; one empty name where they are those of the whole mechanism.
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

std::string format_value(const std::vector<double>& value) {
  std::string text;
  for (const double x : value) text += (text.empty() ? "" : ", ") + (std::isnan(x) ? "none" : format_number(x));
  return text;
}

}  // namespace

std::vector<StateEntry> list_state_entries(const RunResult& result) {
  std::vector<StateEntry> all;
  for (const Quantity& quantity : list_sampled_quantities(result)) {
    const Samples samples = suppress_round_off(result, quantity.member);
    const std::vector<std::string> owners = list_quantity_owners(quantity.columns, result);
    const auto width = samples.cols() / static_cast<Eigen::Index>(owners.size());
    for (std::size_t i = 0; i < owners.size(); ++i) {
      const std::string& unit = quantity.unit_of(i, owners.size());
      const std::string owner = owners[i].empty() ? "" : "[" + owners[i] + "]";
      StateEntry one{(owner.empty() ? quantity.name : effort_display_name(quantity.name, unit)) + owner, unit, {}};
      for (Eigen::Index k = 0; k < width; ++k)
        one.value.push_back(samples(0, static_cast<Eigen::Index>(i) * width + k));
      all.push_back(std::move(one));
    }
  }
  return all;
}

std::string format_state(const RunResult& result, const Provenance& description) {
  std::string text =
      fmt::format("{}: at {}, {:.6g} s; moments about {:.6g}, {:.6g}", description.title, description.pose,
                  result.time[0], result.moment_reference.x(), result.moment_reference.y());
  if (result.axes == 3) text += fmt::format(", {:.6g}", result.moment_reference.z());
  TextTable table{{"quantity", "unit", "value"}, {Align::left, Align::left, Align::left}, {}};
  for (const StateEntry& one : list_state_entries(result))
    table.rows.push_back({one.quantity, one.unit, format_value(one.value)});
  return text + "\n\n" + format_table(table);
}

std::string state_json(const RunResult& result, const Provenance& description, const std::vector<std::string>& files) {
  Json json = {{"mechanism", description.title},
               {"balance_version", description.version},
               {"at", description.pose},
               {"time", result.time[0]},
               {"outcome", outcome_json(result.outcome)},
               {"about", vector_json(result.moment_reference, result.axes)},
               {"values", Json::array()}};
  for (const StateEntry& one : list_state_entries(result))
    json["values"].push_back({{"quantity", one.quantity},
                              {"unit", one.unit},
                              {"value", one.value.size() == 1 ? Json(one.value[0]) : Json(one.value)}});
  json["notes"] = result.outcome.notes;
  json["files"] = files;
  return format_json(json);
}

}  // namespace balance
