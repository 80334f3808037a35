#include "balance/write/json_parts.hpp"

#include "balance/base/plain_text.hpp"
#include "balance/conditions/latex.hpp"
#include "balance/write/names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

namespace balance {
namespace {

Json terms_json(const ConditionsView& view, int row) {
  const Conditions& c = view.conditions;
  const double largest = c.matrix.row(row).cwiseAbs().maxCoeff();
  Json terms = Json::array();
  for (std::size_t p = 0; p < c.parameters.size(); ++p) {
    const double coefficient = c.matrix(row, static_cast<Eigen::Index>(p));
    if (std::abs(coefficient) <= 1e-12 * largest) continue;
    Json term = {{"parameter", c.parameters[p].name}, {"coefficient", coefficient}};
    if (const Formula* formula = view.names.find(row, static_cast<int>(p)))
      term["name"] = formula_text(*formula, view.names.symbols);
    terms.push_back(std::move(term));
  }
  return terms;
}

Json free_json(const ConditionsView& view, int row) {
  Json free = Json::array();
  for (const int number : view.occurring[static_cast<std::size_t>(row)])
    free.push_back(view.numbers[static_cast<std::size_t>(number)].path);
  return free;
}

/// Characters that are not seen stand in strings alone, where they may be written as escapes.
std::string seen_json(std::string_view json) {
  std::string text;
  text.reserve(json.size());
  while (!json.empty()) {
    const Utf8Character one = first_character(json);
    const std::size_t bytes = std::max<std::size_t>(one.bytes, 1);
    if (one.code < 0x7f || !is_unseen(one.code))
      text += json.substr(0, bytes);
    else if (one.code < 0x10000)
      text += fmt::format("\\u{:04x}", one.code);
    else
      text += fmt::format("\\u{:04x}\\u{:04x}", 0xD7C0 + (one.code >> 10), 0xDC00 + (one.code & 0x3FF));
    json.remove_prefix(bytes);
  }
  return text;
}

}  // namespace

std::string dump(const Json& value) {
  // Names that are not UTF-8 must not cost the user the answer.
  return seen_json(value.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n";
}

Json vector_json(const Vector3& vector, int axes) { return std::vector<double>(vector.data(), vector.data() + axes); }

Json numbers_json(const VectorX& numbers) { return std::vector<double>(numbers.begin(), numbers.end()); }

Json metric_json(const Metric& metric) {
  return {{"quantity", metric.quantity}, {"unit", metric.unit}, {"peak", metric.peak},  {"peak_time", metric.peak_time},
          {"rms", metric.rms},           {"mean", metric.mean}, {"range", metric.range}};
}

Json outcome_json(const MotionOutcome& outcome) {
  Json json = {{"status", name_of(outcome.status)}};
  if (outcome.status == MotionStatus::done) return json;
  json["time"] = outcome.time;
  json["reason"] = outcome.reason;
  return json;
}

Json goals_json(const std::vector<Goal>& goals) {
  if (goals.size() == 1) return name_of(goals.front());
  Json names = Json::array();
  for (const Goal& goal : goals) names.push_back(name_of(goal));
  return names;
}

Json conditions_list_json(const ConditionsView& view) {
  Json list = Json::array();
  for (int row = 0; row < static_cast<int>(view.conditions.matrix.rows()); ++row) {
    list.push_back({{"text", condition_text(view.conditions, row, view.names)},
                    {"terms", terms_json(view, row)},
                    {"residual", view.residuals[row]},
                    {"met", view.is_met(row)},
                    {"by_definition", static_cast<bool>(view.by_definition[static_cast<std::size_t>(row)])},
                    {"scale", view.conditions.scale[row]},
                    {"free", free_json(view, row)},
                    {"latex", condition_latex(view.conditions, row, view.names)}});
  }
  return list;
}

void add_conditions(Json& json, const ConditionsView& view) {
  const Conditions& c = view.conditions;
  json["rank"] = c.rank;
  json["gap"] = c.gap;
  json["gap_decades"] = c.gap > 0 ? Json(std::log10(c.gap)) : Json(nullptr);
  json["singular_values"] = {{"smallest_kept", c.smallest_kept}, {"largest_dropped", c.largest_dropped}};
  json["samples"] = c.samples;
  json["parameters"] = Json::array();
  for (const Parameter& p : c.parameters) json["parameters"].push_back(p.name);
  json["symbols"] = Json::array();
  for (const Symbol& s : view.names.symbols)
    json["symbols"].push_back({{"name", s.label}, {"value", s.value}, {"unit", s.unit}});
  json["conditions"] = conditions_list_json(view);
  Json notes = c.notes;
  for (const std::string& note : view.names.notes) notes.push_back(note);
  json["notes"] = std::move(notes);
}

}  // namespace balance
