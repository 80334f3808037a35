#include "balance/present/load_cases_json.hpp"

#include "balance/present/load_cases_text.hpp"

#include <cmath>

namespace balance {

namespace {

Json loads_json(const LoadCases& cases, const VectorX& values) {
  Json json = Json::object();
  for (std::size_t k = 0; k < cases.numbers.size(); ++k)
    json[cases.numbers[k].name] = values[static_cast<Eigen::Index>(k)];
  return json;
}

Json resting_json(const LoadCaseReport& one, const Mechanism& mechanism) {
  Json json = Json::object();
  for (const int actuator : mechanism.actuators) {
    double most = 0;
    for (const PeakEffort& effort : one.static_efforts)
      if (effort.actuator == actuator) most = effort.magnitude;
    json[mechanism.coordinates[static_cast<std::size_t>(actuator)].name] = most;
  }
  return json;
}

Json case_json(const LoadCaseReport& one, const DesignReport& report) {
  Json json = {{"loads", loads_json(report.study_after.design.cases, one.loads)},
               {"largest_residual", one.residual},
               {"met", one.residual <= condition_tolerance},
               {"at_rest", resting_json(one, report.study_after.mechanism)}};
  json["free_numbers"] = Json::object();
  for (std::size_t i = 0; i < report.free_numbers.size(); ++i)
    json["free_numbers"][report.free_numbers[i].key_path] = one.x[static_cast<Eigen::Index>(i)];
  json["trajectories"] = Json::array();
  for (const LoadCaseRun& run : one.runs) {
    Json metrics = Json::array();
    for (const Metric& metric : run.metrics) metrics.push_back(metric_json(metric));
    json["trajectories"].push_back(
        {{"trajectory", run.trajectory}, {"outcome", outcome_json(run.outcome)}, {"metrics", std::move(metrics)}});
  }
  return json;
}

Json cases_json(const std::vector<LoadCaseReport>& all, const DesignReport& report) {
  Json list = Json::array();
  for (const LoadCaseReport& one : all) list.push_back(case_json(one, report));
  return list;
}

Json law_json(const AdaptiveLaw& law, Eigen::Index which, const LoadCases& cases) {
  Json terms = Json::array();
  for (const AdaptiveLaw::Term& term : law.terms) {
    if (term.coefficients[which] == 0) continue;
    Json powers = Json::object();
    for (std::size_t k = 0; k < term.powers.size(); ++k)
      if (term.powers[k] > 0) powers[cases.numbers[k].name] = term.powers[k];
    terms.push_back({{"coefficient", term.coefficients[which]}, {"powers", std::move(powers)}});
  }
  return terms;
}

Json table_json(const AdaptedTable& table, const DesignReport& report) {
  if (table.loads.empty()) return nullptr;
  Json rows = Json::array();
  for (std::size_t row = 0; row < table.loads.size(); ++row)
    rows.push_back({{"loads", loads_json(report.study_after.design.cases, table.loads[row])},
                    {"values", numbers_json(table.values[row])},
                    {"largest_residual", table.residuals[row]}});
  const bool one = table.loads.front().size() == 1;
  return {{"rows", std::move(rows)}, {"residual_between", one ? Json(table.midpoint_residual) : Json(nullptr)}};
}

Json adaptive_json(const DesignReport& report) {
  if (!report.adaptive) return nullptr;
  const AdaptiveReport& adaptive = *report.adaptive;
  const LoadCases& cases = report.study_after.design.cases;
  std::vector<std::string> names;
  VectorX own(static_cast<Eigen::Index>(cases.numbers.size()));
  for (std::size_t k = 0; k < cases.numbers.size(); ++k) {
    names.push_back(cases.numbers[k].name);
    own[static_cast<Eigen::Index>(k)] = cases.numbers[k].nominal;
  }
  Json numbers = Json::array();
  for (std::size_t i = 0; i < adaptive.numbers.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    Json number = {{"path", report.free_numbers[static_cast<std::size_t>(adaptive.numbers[i])].key_path},
                   {"least", adaptive.min_values[k]},
                   {"most", adaptive.max_values[k]},
                   {"law", nullptr}};
    if (adaptive.law) {
      number["law"] = {{"text", law_text(*adaptive.law, k, names)},
                       {"affine", adaptive.law->is_affine(k)},
                       {"terms", law_json(*adaptive.law, k, cases)}};
      number["slope"] = loads_json(cases, adaptive.law->jacobian(own).row(k));
    }
    numbers.push_back(std::move(number));
  }
  return {{"numbers", std::move(numbers)},
          {"within_bounds", adaptive.is_within_bounds},
          {"table", table_json(adaptive.table, report)},
          {"work", adaptive.adjustment_work ? Json(*adaptive.adjustment_work) : Json(nullptr)},
          {"own_load", loads_json(cases, own)},
          {"not_adapted", cases_json(adaptive.fixed_design_cases, report)}};
}

}  // namespace

void add_load_cases(Json& json, const DesignReport& report) {
  json["load_cases"] = cases_json(report.load_cases, report);
  json["adaptive"] = adaptive_json(report);
}

}  // namespace balance
