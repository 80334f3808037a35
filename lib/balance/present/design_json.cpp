#include "balance/present/design_json.hpp"

#include "balance/motion/names.hpp"
#include "balance/present/chosen.hpp"
#include "balance/present/conditions_parts.hpp"
#include "balance/present/load_cases_json.hpp"
#include "balance/present/names.hpp"

#include <cmath>

namespace balance {
namespace {

const char* name_of(FreeNumber::StartFrom from) {
  switch (from) {
    case FreeNumber::StartFrom::spec: return "start";
    case FreeNumber::StartFrom::none: return "none";
    case FreeNumber::StartFrom::middle: return "middle";
  }
  return "";
}

Json numbers_list(const DesignReport& report) {
  Json list = Json::array();
  for (std::size_t i = 0; i < report.numbers.size(); ++i) {
    const FreeNumber& number = report.numbers[i];
    const auto k = static_cast<Eigen::Index>(i);
    const double value = report.outcome.x[k];
    const int bound = at_bound(number, value);
    list.push_back({{"path", number.path},
                    {"lower", number.lower},
                    {"upper", number.upper},
                    {"before", report.before[k]},
                    {"before_from", name_of(number.start_from)},
                    {"value", value},
                    {"sizes", number.sizes.empty() ? Json(nullptr) : Json(number.sizes)},
                    {"at_bound", bound < 0 ? Json("lower") : (bound > 0 ? Json("upper") : Json(nullptr))}});
  }
  return list;
}

Json proof_json(const DesignView& view) {
  const auto& proof = view.report.outcome.proof;
  if (!proof) return nullptr;
  const char* kind = proof->kind == Impossibility::Kind::sign     ? "sign"
                     : proof->kind == Impossibility::Kind::cone   ? "cone"
                     : proof->kind == Impossibility::Kind::bounds ? "bounds"
                                                                  : "squares";
  return {{"kind", kind},
          {"sentence", proof->sentence},
          {"combination", numbers_json(proof->combination)},
          {"coefficients", numbers_json(proof->coefficients)}};
}

Json run_json(const Result& result) {
  Json json = {{"outcome", outcome_json(result.outcome)}, {"notes", result.outcome.notes}, {"metrics", Json::array()}};
  for (const Metric& metric : result.metrics) json["metrics"].push_back(metric_json(metric));
  if (result.outcome.status == MotionStatus::done) json["energy"] = result.energy;
  return json;
}

Json comparison_json(const TrajectoryComparison& comparison) {
  Json changes = Json::array();
  for (const Change& change : list_changes(comparison)) {
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
  const Freedom& freedom = report.outcome.freedom;
  const auto counted = [](int count) { return count < 0 ? Json(nullptr) : Json(count); };
  Json numbers = Json::array();
  for (const int i : freedom.numbers) numbers.push_back(report.numbers[static_cast<std::size_t>(i)].path);
  return {{"of_conditions", counted(freedom.of_conditions)},
          {"left", counted(freedom.left)},
          {"numbers", std::move(numbers)}};
}

Json effort_json(const SearchEffort& effort, bool interrupted) {
  static constexpr const char* ends[] = {"nothing-searched", "goal-met", "all-starts-used", "proof", "time"};
  const bool cut = interrupted && effort.end == SearchEffort::End::time;
  return {{"starts", effort.starts},
          {"local_searches", effort.local_searches},
          {"same_end", effort.same_end < 0 ? Json(nullptr) : Json(effort.same_end)},
          {"sets_of_lengths", effort.geometries},
          {"evaluations", effort.evaluations},
          {"ended_by", cut ? "interrupt" : ends[static_cast<int>(effort.end)]}};
}

Json limits_json(const DesignView& view) {
  const auto& limits = view.report.study_before.design.subject_to;
  const auto& found = view.report.outcome.limits;
  Json list = Json::array();
  for (std::size_t k = 0; k < found.size(); ++k)
    list.push_back({{"text", limits[k].text},
                    {"value", found[k].value},
                    {"relation", limits[k].at_least ? ">=" : "<="},
                    {"limit", limits[k].bound},
                    {"unit", limits[k].unit},
                    {"kept", found[k].violation <= kept},
                    {"active", found[k].active},
                    {"violation", found[k].violation}});
  return list;
}

Json robust_json(const DesignView& view) {
  Json list = Json::array();
  for (const RobustTerm& one : view.report.robust)
    list.push_back({{"name", objective_text({one.term})},
                    {"deviations", *one.term.plus},
                    {"value", one.figure.value},
                    {"mean", one.figure.mean},
                    {"deviation", one.figure.deviation},
                    {"nominal", one.figure.nominal}});
  return list;
}

void add_outcome(Json& json, const DesignView& view) {
  const DesignOutcome& outcome = view.report.outcome;
  json["status"] = name_of(outcome.status);
  json["optimality"] = name_of(outcome.optimality);
  json["tried"] = outcome.tried;
  json["search"] = effort_json(outcome.effort, view.interrupted.has_value());
  json["seconds"] = view.seconds;
  json["proved"] = outcome.status == DesignStatus::impossible ? Json(outcome.proved) : Json(nullptr);
  json["method"] = name_of(outcome.method);
  json["reason"] = outcome.reason;
  json["proof"] = proof_json(view);
  // of the conditions listed below; what holds no parameter is told by `staying`
  const auto listed = [&](const std::vector<int>& rows) {
    std::vector<int> result;
    for (const int row : rows)
      if (row < view.conditions.own_rows()) result.push_back(row);
    return result;
  };
  json["unmet_fixed"] = listed(outcome.unmet_fixed);
  json["open"] = listed(outcome.open);
  json["objective"] = {{"name", view.objective},
                       {"unit", view.objective_unit},
                       {"value", outcome.objective},
                       {"start", outcome.objective_start},
                       {"lower_bound", outcome.lower_bound},
                       {"gap", outcome.gap()},
                       {"global", outcome.optimality == Optimality::proved_best}};
  if (!view.report.robust.empty()) json["objective"]["robust"] = robust_json(view);
  json["freedom"] = freedom_json(view.report);
  json["chosen"] = chosen_json(view.report);
  json["constraints"] = limits_json(view);
  json["least_violation"] = outcome.least_violation;
}

void add_notes(Json& json, const DesignView& view) {
  for (const auto* notes : {&view.report.outcome.notes, &view.report.notes})
    for (const std::string& note : *notes) json["notes"].push_back(note);
}

}  // namespace

std::string design_json(const DesignView& view, const std::vector<std::string>& files) {
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
  return dump(json);
}

}  // namespace balance
