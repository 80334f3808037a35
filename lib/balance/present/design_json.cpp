#include "balance/present/design_json.hpp"

#include "balance/motion/names.hpp"
#include "balance/present/chosen.hpp"
#include "balance/present/conditions_parts.hpp"
#include "balance/present/load_cases_json.hpp"
#include "balance/present/names.hpp"

#include <cmath>

namespace balance {
namespace {

const char* name_of(FreeNumber::StartSource from) {
  switch (from) {
    case FreeNumber::StartSource::spec: return "start";
    case FreeNumber::StartSource::zero_of_added_element: return "none";
    case FreeNumber::StartSource::midpoint: return "middle";
  }
  return "";
}

Json numbers_list(const DesignReport& report) {
  Json list = Json::array();
  for (std::size_t i = 0; i < report.free_numbers.size(); ++i) {
    const FreeNumber& number = report.free_numbers[i];
    const auto k = static_cast<Eigen::Index>(i);
    const double value = report.outcome.x[k];
    const int bound = active_bound(number, value);
    list.push_back({{"path", number.key_path},
                    {"lower", number.lower},
                    {"upper", number.upper},
                    {"before", report.before[k]},
                    {"before_from", name_of(number.start_source)},
                    {"value", value},
                    {"sizes", number.discrete_values.empty() ? Json(nullptr) : Json(number.discrete_values)},
                    {"at_bound", bound < 0 ? Json("lower") : (bound > 0 ? Json("upper") : Json(nullptr))}});
  }
  return list;
}

Json proof_json(const DesignReportData& view) {
  const auto& proof = view.report.outcome.certificate;
  if (!proof) return nullptr;
  const char* kind = proof->kind == InfeasibilityCertificate::Kind::sign     ? "sign"
                     : proof->kind == InfeasibilityCertificate::Kind::cone   ? "cone"
                     : proof->kind == InfeasibilityCertificate::Kind::bounds ? "bounds"
                                                                             : "squares";
  return {{"kind", kind},
          {"sentence", proof->statement},
          {"combination", numbers_json(proof->combination)},
          {"coefficients", numbers_json(proof->coefficients)}};
}

Json run_json(const RunResult& result) {
  Json json = {{"outcome", outcome_json(result.outcome)}, {"notes", result.outcome.notes}, {"metrics", Json::array()}};
  for (const Metric& metric : result.metrics) json["metrics"].push_back(metric_json(metric));
  if (result.outcome.status == MotionStatus::done) json["energy"] = result.energy;
  return json;
}

Json comparison_json(const TrajectoryComparison& comparison) {
  Json changes = Json::array();
  for (const MetricChange& change : list_metric_changes(comparison)) {
    const bool known = change.before != 0 && !std::isnan(change.before) && !std::isnan(change.after);
    changes.push_back({{"quantity", change.quantity},
                       {"unit", change.unit},
                       {"figure", change.figure},
                       {"before", change.before},
                       {"after", change.after},
                       {"ratio", known ? Json(change.after / change.before) : Json(nullptr)}});
  }
  return {{"trajectory", comparison.trajectory},
          {"changes", std::move(changes)},
          {"before", run_json(comparison.before)},
          {"after", run_json(comparison.after)}};
}

Json freedom_json(const DesignReport& report) {
  const SolutionSet& freedom = report.outcome.solution_set;
  const auto counted = [](int count) { return count < 0 ? Json(nullptr) : Json(count); };
  Json numbers = Json::array();
  for (const int i : freedom.free_variables)
    numbers.push_back(report.free_numbers[static_cast<std::size_t>(i)].key_path);
  return {{"of_conditions", counted(freedom.dimension)},
          {"left", counted(freedom.optimal_dimension)},
          {"numbers", std::move(numbers)}};
}

Json effort_json(const SearchEffort& effort, bool interrupted) {
  static constexpr const char* ends[] = {"nothing-searched", "goal-met", "all-starts-used", "proof", "time"};
  const bool cut = interrupted && effort.termination == SearchEffort::Termination::time_limit;
  return {{"starts", effort.starts},
          {"local_searches", effort.local_searches},
          {"same_end", effort.repeated_optima < 0 ? Json(nullptr) : Json(effort.repeated_optima)},
          {"sets_of_lengths", effort.geometries},
          {"evaluations", effort.evaluations},
          {"ended_by", cut ? "interrupt" : ends[static_cast<int>(effort.termination)]}};
}

Json limits_json(const DesignReportData& view) {
  const auto& limits = view.report.study_before.design.subject_to;
  const auto& found = view.report.outcome.limits;
  Json list = Json::array();
  for (std::size_t k = 0; k < found.size(); ++k)
    list.push_back({{"text", limits[k].text},
                    {"value", found[k].value},
                    {"relation", limits[k].is_lower ? ">=" : "<="},
                    {"limit", limits[k].bound},
                    {"unit", limits[k].unit},
                    {"kept", found[k].violation <= limit_tolerance},
                    {"active", found[k].is_active},
                    {"violation", found[k].violation}});
  return list;
}

Json robust_json(const DesignReportData& view) {
  Json list = Json::array();
  for (const RobustTerm& one : view.report.robust)
    list.push_back({{"name", objective_text({one.term})},
                    {"deviations", *one.term.deviation_multiple},
                    {"value", one.figure.value},
                    {"mean", one.figure.mean},
                    {"deviation", one.figure.deviation},
                    {"nominal", one.figure.nominal}});
  return list;
}

void add_outcome(Json& json, const DesignReportData& view) {
  const DesignOutcome& outcome = view.report.outcome;
  json["status"] = name_of(outcome.status);
  json["optimality"] = name_of(outcome.optimality);
  json["tried"] = outcome.search_summary;
  json["search"] = effort_json(outcome.effort, view.interrupted.has_value());
  json["seconds"] = view.seconds;
  json["proved"] = outcome.status == DesignStatus::infeasible ? Json(outcome.is_proved_infeasible) : Json(nullptr);
  json["method"] = name_of(outcome.method);
  json["reason"] = outcome.reason;
  json["proof"] = proof_json(view);
  // of the conditions listed below; what holds no parameter is told by `staying`
  const auto listed = [&](const std::vector<int>& rows) {
    std::vector<int> result;
    for (const int row : rows)
      if (row < view.conditions.parameter_rows()) result.push_back(row);
    return result;
  };
  json["unmet_fixed"] = listed(outcome.unmet_fixed_conditions);
  json["open"] = listed(outcome.unmet_conditions);
  json["objective"] = {{"name", view.objective},
                       {"unit", view.objective_unit},
                       {"value", outcome.objective},
                       {"start", outcome.start_objective},
                       {"lower_bound", outcome.lower_bound},
                       {"gap", outcome.gap()},
                       {"global", outcome.optimality == Optimality::proved_global}};
  if (!view.report.robust.empty()) json["objective"]["robust"] = robust_json(view);
  json["freedom"] = freedom_json(view.report);
  json["chosen"] = optional_elements_json(view.report);
  json["constraints"] = limits_json(view);
  json["least_violation"] = outcome.min_violation_bound;
}

void add_notes(Json& json, const DesignReportData& view) {
  for (const auto* notes : {&view.report.outcome.notes, &view.report.notes})
    for (const std::string& note : *notes) json["notes"].push_back(note);
}

}  // namespace

std::string design_json(const DesignReportData& view, const std::vector<std::string>& files) {
  const DesignReport& report = view.report;
  Json json = {{"mechanism", view.conditions.title}, {"goal", goals_json(view.conditions.conditions.goals)}};
  json["strategy"] = view.conditions.strategy;
  add_outcome(json, view);
  json["free_numbers"] = numbers_list(report);
  add_conditions(json, view.conditions);
  // Conditions show the designed mechanism; here is what they were before.
  for (int row = 0; row < view.residuals_before.size(); ++row)
    json["conditions"][static_cast<std::size_t>(row)]["residual_before"] = view.residuals_before[row];
  json["mass"] = {{"before", report.mass_before}, {"after", report.mass_after}, {"added", report.added_mass}};
  json["inertia"] = {
      {"before", report.inertia_before}, {"after", report.inertia_after}, {"added", report.added_inertia}};
  json["trajectories"] = Json::array();
  for (const TrajectoryComparison& comparison : report.comparisons)
    json["trajectories"].push_back(comparison_json(comparison));
  add_load_cases(json, report);
  add_notes(json, view);
  json["warnings"] = view.warnings;
  json["files"] = files;
  return format_json(json);
}

}  // namespace balance
