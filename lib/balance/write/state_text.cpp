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
std::vector<std::string> owners_of(Columns columns, const Result& r) {
  switch (columns) {
    case Columns::coordinate: return r.coordinate_names;
    case Columns::actuator: return r.actuator_names;
    case Columns::joint:
    case Columns::joint_axis: return r.joint_names;
    case Columns::constraint: return r.constraint_names;
    case Columns::sliding: return r.sliding_names;
    case Columns::body:
    case Columns::body_axis:
    case Columns::body_quaternion: return r.body_names;
    case Columns::single:
    case Columns::axis:
    case Columns::quaternion: break;
  }
  return {""};
}

std::string value_text(const std::vector<double>& value) {
  std::string text;
  for (const double x : value) text += (text.empty() ? "" : ", ") + (std::isnan(x) ? "none" : format_number(x));
  return text;
}

}  // namespace

std::vector<StateNumber> list_state(const Result& result) {
  std::vector<StateNumber> all;
  for (const Quantity& quantity : list_quantities(result)) {
    const Samples samples = above_round_off(result, quantity.member);
    const std::vector<std::string> owners = owners_of(quantity.columns, result);
    const auto width = samples.cols() / static_cast<Eigen::Index>(owners.size());
    for (std::size_t i = 0; i < owners.size(); ++i) {
      const std::string& unit = quantity.unit_of(i, owners.size());
      const std::string owner = owners[i].empty() ? "" : "[" + owners[i] + "]";
      StateNumber one{(owner.empty() ? quantity.name : effort_name(quantity.name, unit)) + owner, unit, {}};
      for (Eigen::Index k = 0; k < width; ++k)
        one.value.push_back(samples(0, static_cast<Eigen::Index>(i) * width + k));
      all.push_back(std::move(one));
    }
  }
  return all;
}

std::string state_text(const Result& result, const FileDescription& description) {
  std::string text = fmt::format("{}: at {}, {:.6g} s; moments about {:.6g}, {:.6g}", description.title, description.at,
                                 result.time[0], result.about.x(), result.about.y());
  if (result.axes == 3) text += fmt::format(", {:.6g}", result.about.z());
  Table table{{"quantity", "unit", "value"}, {Align::left, Align::left, Align::left}, {}};
  for (const StateNumber& one : list_state(result))
    table.rows.push_back({one.quantity, one.unit, value_text(one.value)});
  return text + "\n\n" + format_table(table);
}

std::string state_json(const Result& result, const FileDescription& description,
                       const std::vector<std::string>& files) {
  Json json = {{"mechanism", description.title},
               {"balance_version", description.version},
               {"at", description.at},
               {"time", result.time[0]},
               {"outcome", outcome_json(result.outcome)},
               {"about", vector_json(result.about, result.axes)},
               {"values", Json::array()}};
  for (const StateNumber& one : list_state(result))
    json["values"].push_back({{"quantity", one.quantity},
                              {"unit", one.unit},
                              {"value", one.value.size() == 1 ? Json(one.value[0]) : Json(one.value)}});
  json["notes"] = result.outcome.notes;
  json["files"] = files;
  return dump(json);
}

}  // namespace balance
