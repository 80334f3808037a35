#include "balance/present/comparison_json.hpp"

#include "balance/present/verdict_json.hpp"
#include "balance/write/json_parts.hpp"

#include <fmt/format.h>

namespace balance {
namespace {

Json run_json(const ComparedRuns::Run& run) {
  return {{"name", run.name},    {"file", run.file},   {"mechanism", run.title},   {"trajectory", run.trajectory},
          {"law", run.law},      {"drive", run.drive}, {"duration", run.duration}, {"samples", run.samples},
          {"energy", run.energy}};
}

Json difference_json(const std::optional<Difference>& difference) {
  if (!difference) return nullptr;
  return {{"largest", difference->largest}, {"time", difference->time}, {"rms", difference->rms}};
}

Json metric_of_run_json(const ComparedQuantity& quantity, std::size_t run) {
  const auto& metric = quantity.metrics[run];
  if (!metric) return nullptr;
  Json json = {{"peak", metric->peak},
               {"peak_time", metric->peak_time},
               {"rms", metric->rms},
               {"mean", metric->mean},
               {"range", metric->range}};
  if (run == 0) return json;
  json["ratio"] = {{"peak", ratio_to_base(quantity, run, Statistic::peak)},
                   {"rms", ratio_to_base(quantity, run, Statistic::rms)},
                   {"mean", ratio_to_base(quantity, run, Statistic::mean)},
                   {"range", ratio_to_base(quantity, run, Statistic::range)}};
  json["difference"] = difference_json(quantity.differences[run]);
  return json;
}

Json quantity_json(const ComparedQuantity& quantity, const ComparedRuns& compared) {
  Json json = {{"quantity", quantity.quantity}, {"unit", quantity.unit}, {"runs", Json::object()}};
  for (std::size_t run = 0; run < compared.runs.size(); ++run)
    json["runs"][compared.runs[run].name] = metric_of_run_json(quantity, run);
  return json;
}

}  // namespace

Json verdict_json(const RequirementVerdict& verdict) {
  Json json = {{"requirement", verdict.requirement},
               {"run", verdict.run.empty() ? Json(nullptr) : Json(verdict.run)},
               {"holds", verdict.holds},
               {"outcome", describe_verdict(verdict)},
               {"comparisons", Json::array()},
               {"missing", verdict.missing}};
  for (const JudgedComparison& judged : verdict.compared) {
    json["comparisons"].push_back({{"left_text", judged.left_text},
                                   {"relation", relation_symbol(judged.relation)},
                                   {"right_text", judged.right_text},
                                   {"left", judged.left},
                                   {"right", judged.right},
                                   {"unit", judged.unit},
                                   {"holds", judged.holds()},
                                   {"margin", judged.margin()},
                                   {"margin_percent", judged.margin_percent()}});
  }
  return json;
}

std::string comparison_json(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts) {
  Json json = {{"base", compared.runs.front().name}};
  json["runs"] = Json::array();
  for (const ComparedRuns::Run& run : compared.runs) json["runs"].push_back(run_json(run));
  json["quantities"] = Json::array();
  for (const ComparedQuantity& quantity : compared.quantities)
    json["quantities"].push_back(quantity_json(quantity, compared));
  json["notes"] = compared.notes;
  json["requirements"] = Json::array();
  for (const RequirementVerdict& verdict : verdicts) json["requirements"].push_back(verdict_json(verdict));
  json["all_hold"] = do_all_hold(verdicts);
  return format_json(json);
}

JunitSuite make_verdict_suite(const std::string& name, const std::vector<RequirementVerdict>& verdicts) {
  JunitSuite suite{name, {}};
  for (const RequirementVerdict& verdict : verdicts) {
    JunitCase one;
    one.group = verdict.run.empty() ? name : verdict.run;
    one.name = verdict.requirement;
    if (verdict.holds) {
      one.output = describe_verdict(verdict);
    } else {
      one.status = JunitCase::Status::failed;
      one.kind = "requirement";
      one.message = describe_verdict(verdict);
      for (const JudgedComparison& judged : verdict.compared) {
        one.details +=
            fmt::format("{} = {:.17g}\n{} = {:.17g}\n", judged.left_text, judged.left, judged.right_text, judged.right);
      }
    }
    suite.cases.push_back(std::move(one));
  }
  return suite;
}

}  // namespace balance
