#include "balance/present/conditions_parts.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/extrema.hpp"
#include "balance/conditions/latex.hpp"

#include <cmath>

namespace balance {
namespace {

Json terms_json(const ConditionsReportData& view, int row) {
  const Conditions& c = view.conditions;
  const double max_abs_entry = max_abs(c.matrix.row(row));
  Json terms = Json::array();
  for (Eigen::Index p = 0; p < c.parameter_columns(); ++p) {
    const double coefficient = c.matrix(row, p);
    if (std::abs(coefficient) <= 1e-12 * max_abs_entry) continue;
    Json term = {{"parameter", c.parameters[static_cast<std::size_t>(p)].name}, {"coefficient", coefficient}};
    if (const CoefficientFormula* formula = view.names.find(row, static_cast<int>(p)))
      term["name"] = formula_text(*formula, view.names.symbols);
    terms.push_back(std::move(term));
  }
  return terms;
}

/// The right-hand side: known terms, with what they come to.
void add_right_hand_side(Json& json, const ConditionsReportData& view, int row) {
  const Conditions& c = view.conditions;
  const double max_abs_entry = max_abs(c.matrix.row(row));
  double sum = 0;
  Json terms = Json::array();
  for (Eigen::Index p = c.parameter_columns(); p < c.matrix.cols(); ++p) {
    const double coefficient = -c.matrix(row, p);
    if (std::abs(coefficient) <= 1e-12 * max_abs_entry) continue;
    const double value = c.known_term_values[p - c.parameter_columns()];
    terms.push_back(
        {{"term", c.parameters[static_cast<std::size_t>(p)].name}, {"coefficient", coefficient}, {"value", value}});
    sum += coefficient * value;
  }
  json["known"] = std::move(terms);
  json["right_hand_side"] = sum;
}

Json staying_json(const ConditionsReportData& view) {
  Json list = Json::array();
  for (const UnbalancedRemainder& staying : view.unbalanced_remainder) {
    const ParameterOwner bearer = staying.element.bearer;
    Json one = {{"kind", bearer == ParameterOwner::friction ? "friction"
                         : bearer == ParameterOwner::spring ? "spring"
                                                            : "load"},
                {"name", staying.element.name},
                {"text", staying.text},
                {"terms", Json::array()},
                {"efforts", Json::array()},
                {"unknown", Json::array()}};
    for (const auto& unknown : staying.failed_trajectories)
      one["unknown"].push_back({{"along", unknown.trajectory.empty() ? Json(nullptr) : Json(unknown.trajectory)},
                                {"reason", unknown.reason}});
    for (const int term : staying.element.terms)
      one["terms"].push_back(view.conditions.parameters[static_cast<std::size_t>(term)].name);
    for (const RemainderEffort& effort : staying.efforts)
      one["efforts"].push_back({{"along", effort.trajectory.empty() ? Json(nullptr) : Json(effort.trajectory)},
                                {"actuator", effort.actuator},
                                {"peak", effort.magnitude},
                                {"unit", effort.unit}});
    list.push_back(std::move(one));
  }
  return list;
}

Json free_json(const ConditionsReportData& view, int row) {
  Json free = Json::array();
  for (const int number : view.free_number_indices[static_cast<std::size_t>(row)])
    free.push_back(view.numbers[static_cast<std::size_t>(number)].key_path);
  return free;
}

}  // namespace

Json goals_json(const std::vector<Goal>& goals) {
  if (goals.size() == 1) return goal_name(goals.front());
  Json names = Json::array();
  for (const Goal& goal : goals) names.push_back(goal_name(goal));
  return names;
}

Json conditions_list_json(const ConditionsReportData& view) {
  Json list = Json::array();
  for (int row = 0; row < view.parameter_rows(); ++row) {
    list.push_back({{"text", condition_text(view.conditions, row, view.names)},
                    {"terms", terms_json(view, row)},
                    {"residual", view.residuals[row]},
                    {"met", view.is_met(row)},
                    {"by_definition", static_cast<bool>(view.holds_by_definition[static_cast<std::size_t>(row)])},
                    {"scale", view.conditions.row_scales[row]},
                    {"free", free_json(view, row)},
                    {"latex", condition_latex(view.conditions, row, view.names)}});
    add_right_hand_side(list.back(), view, row);
  }
  return list;
}

void add_conditions(Json& json, const ConditionsReportData& view) {
  const Conditions& c = view.conditions;
  json["rank"] = view.parameter_rows();
  json["gap"] = c.singular_value_gap;
  json["gap_decades"] = c.singular_value_gap > 0 ? Json(elementary::log10(c.singular_value_gap)) : Json(nullptr);
  json["singular_values"] = {{"smallest_kept", c.min_kept_singular_value},
                             {"largest_dropped", c.max_dropped_singular_value}};
  json["samples"] = c.samples;
  json["parameters"] = Json::array();
  for (Eigen::Index p = 0; p < c.parameter_columns(); ++p)
    json["parameters"].push_back(c.parameters[static_cast<std::size_t>(p)].name);
  json["symbols"] = Json::array();
  for (const GeometricSymbol& s : view.names.symbols)
    json["symbols"].push_back({{"name", s.label}, {"value", s.value}, {"unit", s.unit}});
  json["conditions"] = conditions_list_json(view);
  json["staying"] = staying_json(view);
  Json notes = c.notes;
  for (const std::string& note : view.names.notes) notes.push_back(note);
  json["notes"] = std::move(notes);
}

}  // namespace balance
