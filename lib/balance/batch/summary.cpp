#include "balance/batch/summary.hpp"

#include "balance/compare/metric_table.hpp"
#include "balance/read/requirement.hpp"
#include "balance/write/pending_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

namespace balance {
namespace {

using Status = RequirementOutcome::Status;

class RequirementEvaluator {
 public:
  RequirementEvaluator(const Suite& suite, const std::vector<CaseRecord>& records) : suite_(suite) {
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (!records[i].has_result()) continue;
      table_of_[records[i].name] = tables_.size();
      tables_.push_back({records[i].name, records[i].metrics, records[i].energy});
    }
    quantities_ = list_quantity_names(tables_);
  }

  std::vector<RequirementOutcome> judge() {
    for (const SuiteRequirement& one : suite_.require) {
      if (!one.requirement.applies_to_each_run()) {
        judge_one(one, "");
        continue;
      }
      for (const SuiteCase& each : suite_.cases)
        if (each.name != suite_.baseline) judge_one(one, each.name);
    }
    for (const SuiteCase& each : suite_.cases)
      for (const SuiteRequirement& one : each.requirements)
        judge_one(one, one.requirement.applies_to_each_run() ? each.name : "");
    return std::move(outcomes_);
  }

 private:
  void judge_one(const SuiteRequirement& one, const std::string& run) {
    RequirementOutcome outcome{.text = one.requirement.text, .run = run};
    std::vector<std::string> needed = one.requirement.named_runs();
    if (!run.empty()) needed.push_back(run);
    const auto absent =
        std::find_if(needed.begin(), needed.end(), [&](const std::string& name) { return table_of_.count(name) == 0; });
    if (absent != needed.end()) {
      outcome.status = Status::not_judged;
      outcome.message = fmt::format("not judged: {} has no result", *absent);
    } else {
      judge_complete(one, run, needed, outcome);
    }
    outcomes_.push_back(std::move(outcome));
  }

  void judge_complete(const SuiteRequirement& one, const std::string& run, const std::vector<std::string>& needed,
                      RequirementOutcome& outcome) const {
    try {
      check_quantities(one.requirement, quantities_);
    } catch (const RequirementError& error) {
      outcome.status = Status::invalid;
      outcome.message = one.location.text() + ": " + error.what();
      return;
    }
    // Of thousands of cases a requirement is about two or three.
    std::vector<MetricTable> tables;
    for (const std::string& name : needed) tables.push_back(tables_[table_of_.at(name)]);
    const RequirementVerdict verdict =
        balance::judge_requirement(one.requirement, tables, run.empty() ? 0 : tables.size() - 1);
    outcome.status = verdict.holds ? Status::holds : Status::violated;
    outcome.message = describe_verdict(verdict);
  }

  const Suite& suite_;
  std::vector<MetricTable> tables_;  ///< of the cases with results
  std::map<std::string, std::size_t> table_of_;
  std::vector<std::string> quantities_;
  std::vector<RequirementOutcome> outcomes_;
};

}  // namespace

const CaseRecord* BatchSummary::baseline_record() const {
  const auto at = std::find_if(cases.begin(), cases.end(), [&](const CaseRecord& c) { return c.name == baseline; });
  return at != cases.end() && at->has_result() ? &*at : nullptr;
}

int BatchSummary::exit_code() const {
  int code = 0;
  for (const CaseRecord& one : cases) code = std::max(code, one.exit_code());
  for (const RequirementOutcome& one : requirements) {
    if (one.status == Status::violated) code = std::max(code, 1);
    if (one.status == Status::invalid) code = std::max(code, 3);
  }
  return code;
}

BatchSummary summarise_batch(const Suite& suite, std::vector<CaseRecord> records) {
  BatchSummary summary;
  summary.name = suite.name;
  summary.baseline = suite.baseline;
  for (const SuiteCase& one : suite.cases) summary.specs.push_back(one.spec);
  summary.requirements = RequirementEvaluator(suite, records).judge();
  summary.cases = std::move(records);
  return summary;
}

std::vector<std::string> write_summary(const std::string& folder, const BatchSummary& summary) {
  constexpr std::array<std::string (*)(const BatchSummary&), summary_file_names.size()> documents{
      summary_json, summary_csv, summary_markdown, summary_junit};
  std::vector<std::string> files;
  for (std::size_t i = 0; i < documents.size(); ++i) {
    files.push_back((std::filesystem::path(folder) / summary_file_names[i]).string());
    AtomicFile file(files.back(), OverwritePolicy::replace, temporary_tag);
    file.write(documents[i](summary));
    file.commit();
  }
  return files;
}

}  // namespace balance
