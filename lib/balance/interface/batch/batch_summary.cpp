// Summaries of a batch for programs and people.

#include "balance/interface/batch/batch_summary.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/requirement.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/report_fields.hpp"
#include "balance/interface/reports/junit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

namespace balance::batch {

using comparison::MetricTable;
using files::Align;
using reports::JunitCase;

// The cases of a summary as a table, for text and Markdown.

/// Status; peak and rms of torque, shaking force and shaking moment; if there is a baseline, the ratios of the peaks to
/// the baseline's; if there are designs, the mass that they add.
files::TextTable case_table(const BatchSummary& summary);

/// "3 cases: 2 done, 1 failed; 4 of 5 requirements hold"
std::string format_summary_line(const BatchSummary& summary);

const char* requirement_status_name(RequirementOutcome::Status status);  ///< "holds", "missed", …

/// "peak(shaking_force) <= base [cycloid]": the requirement and the case that it is judged for.
std::string requirement_title(const RequirementOutcome& outcome);

namespace {

using Status = RequirementOutcome::Status;

class RequirementEvaluator {
 public:
  RequirementEvaluator(const Suite& suite, const std::vector<CaseRecord>& records) : suite_(suite) {
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (!records[i].has_result()) continue;
      table_index_[records[i].name] = tables_.size();
      tables_.push_back(records[i].metric_table());
    }
  }

  std::vector<RequirementOutcome> evaluate() {
    for (const SuiteRequirement& suite_requirement : suite_.require) {
      if (!suite_requirement.requirement.applies_to_each_run()) {
        evaluate_requirement(suite_requirement, "");
        continue;
      }
      for (const SuiteCase& suite_case : suite_.cases)
        if (suite_case.name != suite_.baseline) evaluate_requirement(suite_requirement, suite_case.name);
    }
    for (const SuiteCase& suite_case : suite_.cases) {
      for (const SuiteRequirement& suite_requirement : suite_case.requirements)
        evaluate_requirement(suite_requirement,
                             suite_requirement.requirement.applies_to_each_run() ? suite_case.name : "");
      published_.push_back({suite_case.source, {}});
      for (const PublishedRow& row : suite_case.published) evaluate_row(suite_case, row);
    }
    return std::move(outcomes_);
  }

  /// After evaluate(): one per case.
  std::vector<PublishedCase> take_published() { return std::move(published_); }

 private:
  void evaluate_requirement(const SuiteRequirement& suite_requirement, const std::string& run) {
    RequirementOutcome outcome{.text = suite_requirement.requirement.text, .run = run};
    std::vector<std::string> run_names = suite_requirement.requirement.named_runs();
    if (!run.empty()) run_names.push_back(run);
    if (!lacks_result(run_names, outcome)) evaluate_with_results(suite_requirement, run, run_names, outcome);
    outcomes_.push_back(std::move(outcome));
  }

  /// Whether one of the runs has no result; the outcome then says so.
  bool lacks_result(const std::vector<std::string>& run_names, RequirementOutcome& outcome) const {
    const auto missing_run = std::find_if(run_names.begin(), run_names.end(),
                                          [&](const std::string& name) { return table_index_.count(name) == 0; });
    if (missing_run == run_names.end()) return false;
    outcome.status = Status::not_judged;
    outcome.message = fmt::format("not judged: {} has no result", *missing_run);
    return true;
  }

  std::vector<MetricTable> collect_tables(const std::vector<std::string>& run_names) const {
    std::vector<MetricTable> tables;
    for (const std::string& name : run_names) tables.push_back(tables_[table_index_.at(name)]);
    return tables;
  }

  /// Judges a published number, and the proof of an improvement.
  void evaluate_row(const SuiteCase& suite_case, const PublishedRow& row) {
    RequirementOutcome outcome{.text = row.what, .run = suite_case.name, .is_published = true};
    PublishedOutcome published{row, std::numeric_limits<double>::quiet_NaN(), false};
    std::vector<std::string> run_names;
    for (const comparison::FigureReference& figure : row.figure.figures)
      if (!figure.run.empty()) run_names.push_back(figure.run);
    run_names.push_back(suite_case.name);
    if (!lacks_result(run_names, outcome)) {
      try {
        const std::vector<MetricTable> tables = collect_tables(run_names);
        const comparison::ExpressionAnswer answer = evaluate_expression(row.figure, tables, tables.size() - 1);
        if (answer.is_plain_sum) check_unit(row, answer.unit);
        published.ours = answer.value / row.unit_value.value;
        // the default tolerance is a decimal number: both ends of it count
        constexpr double decimal_round_off = 1e-9;
        published.holds = std::abs(published.ours - row.exact) <=
                          row.tolerance * (1 + decimal_round_off) + 1e-15 * std::abs(row.exact);
        outcome.message =
            answer.missing.empty() ? describe_outcome(published) : fmt::format("{}", fmt::join(answer.missing, ", "));
        if (published.holds && row.verdict == PublishedVerdict::improved)
          check_proof(suite_case, row, published, outcome);
        outcome.status = published.holds ? Status::holds : Status::violated;
      } catch (const comparison::RequirementError& error) {
        outcome.status = Status::invalid;
        outcome.message = row.figure_location.text() + ": " + error.what();
      } catch (const SpecError& error) {
        outcome.status = Status::invalid;
        outcome.message = error.what();
      }
    }
    published_.back().rows.push_back(std::move(published));
    outcomes_.push_back(std::move(outcome));
  }

  /// Fails if a row's unit is one of another quantity than its figure's.
  static void check_unit(const PublishedRow& row, const std::string& figure_unit) {
    const std::optional<specification::UnitProduct> figure = specification::parse_unit_product(figure_unit);
    if (row.unit.empty() || !figure || figure->dimension == row.unit_value.dimension) return;
    const specification::ErrorMessage message{
        .expected = fmt::format("a unit of the figure, which is in {}", figure_unit),
        .found = quote_for_message(row.unit)};
    throw SpecError({row.unit_location, message.text(), message.expected, message.found});
  }

  /// An improvement without proof is none.
  void check_proof(const SuiteCase& suite_case, const PublishedRow& row, PublishedOutcome& published,
                   RequirementOutcome& outcome) const {
    std::vector<const SuiteRequirement*> proofs;
    if (row.proof) proofs.push_back(&*row.proof);
    for (const SuiteRequirement& one : suite_case.requirements)
      if (!row.proof && refers_to_verdict(one.requirement)) proofs.push_back(&one);
    for (const SuiteRequirement* proof : proofs) {
      std::vector<std::string> run_names = proof->requirement.named_runs();
      run_names.push_back(suite_case.name);
      RequirementOutcome ignored;
      if (lacks_result(run_names, ignored)) {
        published.holds = false;
        outcome.message = fmt::format("{}: the proof is not judged: {}", proof->location.text(), ignored.message);
        continue;
      }
      const std::vector<MetricTable> tables = collect_tables(run_names);
      const comparison::RequirementVerdict verdict = judge_requirement(proof->requirement, tables, tables.size() - 1);
      if (verdict.holds) continue;
      published.holds = false;
      outcome.message = fmt::format("the proof does not hold: {}: {}", verdict.requirement, describe_verdict(verdict));
    }
  }

  void evaluate_with_results(const SuiteRequirement& suite_requirement, const std::string& run,
                             const std::vector<std::string>& run_names, RequirementOutcome& outcome) const {
    try {
      check_figures(suite_requirement.requirement, tables_);
    } catch (const comparison::RequirementError& error) {
      outcome.status = Status::invalid;
      outcome.message = suite_requirement.location.text() + ": " + error.what();
      return;
    }
    // A requirement refers to only two or three of thousands of cases.
    const std::vector<MetricTable> tables = collect_tables(run_names);
    const comparison::RequirementVerdict verdict =
        comparison::judge_requirement(suite_requirement.requirement, tables, run.empty() ? 0 : tables.size() - 1);
    outcome.status = verdict.holds ? Status::holds : Status::violated;
    outcome.message = describe_verdict(verdict);
  }

  const Suite& suite_;
  std::vector<MetricTable> tables_;  ///< of cases with results
  std::map<std::string, std::size_t> table_index_;
  std::vector<RequirementOutcome> outcomes_;
  std::vector<PublishedCase> published_;
};

}  // namespace

const CaseRecord* BatchSummary::baseline_record() const {
  const auto at = std::find_if(cases.begin(), cases.end(), [&](const CaseRecord& c) { return c.name == baseline; });
  return at != cases.end() && at->has_result() ? &*at : nullptr;
}

int BatchSummary::exit_code() const {
  int code = 0;
  for (const CaseRecord& record : cases) code = std::max(code, record.exit_code());
  for (const RequirementOutcome& outcome : requirements) {
    if (outcome.status == Status::violated) code = std::max(code, 1);
    if (outcome.status == Status::invalid) code = std::max(code, 3);
  }
  return code;
}

BatchSummary summarise_batch(const Suite& suite, std::vector<CaseRecord> records) {
  BatchSummary summary;
  summary.name = suite.name;
  summary.baseline = suite.baseline;
  for (const SuiteCase& suite_case : suite.cases) summary.specs.push_back(suite_case.spec);
  RequirementEvaluator evaluator(suite, records);
  summary.requirements = evaluator.evaluate();
  summary.published = evaluator.take_published();
  summary.cases = std::move(records);
  return summary;
}

std::vector<std::string> write_summary(const std::string& folder, const BatchSummary& summary) {
  constexpr std::array<std::string (*)(const BatchSummary&), summary_file_names.size()> documents{
      summary_json, summary_csv, summary_markdown, summary_junit};
  std::vector<std::string> files;
  for (std::size_t i = 0; i < documents.size(); ++i) {
    files.push_back((std::filesystem::path(folder) / summary_file_names[i]).string());
    files::AtomicFile file(files.back(), files::OverwritePolicy::replace, temporary_tag);
    file.write(documents[i](summary));
    file.commit();
  }
  return files;
}

namespace {

/// The shortest text that reads back to the same value; empty if the value is not finite.
std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string csv_ratio(double value, double base) { return base > 0 ? csv_number(value / base) : ""; }

void add_csv_lines(const CaseRecord& record, const std::string& spec, const MetricTable* base, std::string& text) {
  const std::string begin =
      fmt::format("{},{},{},{}", files::escape_csv_field(record.name), files::escape_csv_field(spec),
                  files::escape_csv_field(record.trajectory), record.status);
  if (!record.has_result()) {
    text += begin + ",,,,,,,,,,\n";
    return;
  }
  for (const Metric& metric : record.metrics) {
    const Metric* other = base == nullptr ? nullptr : find_metric(*base, metric.quantity);
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{},,{},{}\n", begin,
                   files::escape_csv_field(metric.quantity), metric.unit, csv_number(metric.peak),
                   csv_number(metric.peak_time), csv_number(metric.rms), csv_number(metric.mean),
                   csv_number(metric.range), other == nullptr ? "" : csv_ratio(metric.peak, other->peak),
                   other == nullptr ? "" : csv_ratio(metric.rms, other->rms));
  }
  text += fmt::format("{},energy,J,,,,,,{},,\n", begin, csv_number(record.energy));
}

const ReportFields<RequirementOutcome>& requirement_fields() {
  using Row = RequirementOutcome;
  static const ReportFields<Row> fields{
      {&Row::text, JsonKey{"requirement"}, TextColumn{}},
      {[](const Row& outcome) { return files::text_or_null(outcome.run); }, JsonKey{"case"}, TextColumn{}},
      {[](const Row& outcome) { return requirement_status_name(outcome.status); }, JsonKey{"status"}, TextColumn{}},
      {&Row::message, JsonKey{"verdict"}, TextColumn{}}};
  return fields;
}

/// Relative to the printed number; NaN: unknown.
double relative_deviation(const PublishedOutcome& outcome) {
  const bool has_ratio = outcome.row.printed != 0 && std::isfinite(outcome.ours);
  return has_ratio ? outcome.ours / outcome.row.printed - 1 : std::numeric_limits<double>::quiet_NaN();
}

Json published_json(const PublishedOutcome& outcome) {
  const PublishedRow& row = outcome.row;
  return {{"what", row.what},
          {"unit", files::text_or_null(row.unit)},
          {"printed", row.printed},
          {"exact", row.exact},
          {"tolerance", row.tolerance},
          {"ours", outcome.ours},
          {"deviation", relative_deviation(outcome)},
          {"verdict", name_of(row.verdict)},
          {"note", files::text_or_null(row.note)},
          {"holds", outcome.holds}};
}

/// Adds where a case is from, if the suite says so.
void add_source(const PublishedCase& published, Json& json) {
  if (published.is_empty()) return;
  json["source"] = files::text_or_null(published.source.source);
  json["page"] = files::text_or_null(published.source.page);
  json["published"] = files::list_json(published.rows, published_json);
  json["waits"] = Json::array();
  for (const WaitingRow& row : published.source.waits)
    json["waits"].push_back({{"what", row.what},
                             {"unit", files::text_or_null(row.unit)},
                             {"printed", files::text_or_null(row.printed)},
                             {"reason", row.reason}});
}

Json case_json(const CaseRecord& record, const std::string& spec, const PublishedCase& published) {
  Json json = {{"name", record.name}, {"spec", spec}, {"status", record.status}};
  if (!record.message.empty()) json["message"] = record.message;
  json["mechanism"] = record.title;
  json["trajectory"] = record.trajectory;
  json["samples"] = record.samples;
  if (record.failure) json["cause"] = record.failure->cause;
  if (record.design)
    json["design"] = {{"status", record.design->status},
                      {"mass_before", record.design->mass_before},
                      {"mass_after", record.design->mass_after},
                      {"added_mass", record.design->added_mass}};
  json["metrics"] = files::metrics_json(record.metrics);
  json["energy"] = record.energy;
  for (const auto& [name, value] : record.solved) json["solved"][name] = value;
  add_source(published, json);
  json["warnings"] = record.warnings;
  json["notes"] = record.notes;
  json["files"] = Json::array();
  for (const RecordedFile& file : record.files) json["files"].push_back({{"name", file.name}, {"sha256", file.sha256}});
  return json;
}

JunitCase test_of(const CaseRecord& record, const std::string& spec, const std::string& group) {
  JunitCase test{
      .group = group, .name = record.name, .message = record.message, .kind = record.status, .seconds = record.seconds};
  if (record.status == "compromise") test.status = JunitCase::Status::failed;
  if (!record.has_result()) test.status = JunitCase::Status::error;
  if (test.status != JunitCase::Status::passed)
    test.details = fmt::format("spec: {}\ntrajectory: {}\n", spec, record.trajectory);
  return test;
}

JunitCase test_of(const RequirementOutcome& outcome, const std::string& group) {
  JunitCase test{.group = group, .name = requirement_title(outcome), .message = outcome.message, .kind = "requirement"};
  switch (outcome.status) {
    case RequirementOutcome::Status::holds: test.message.clear(); break;
    case RequirementOutcome::Status::violated: test.status = JunitCase::Status::failed; break;
    case RequirementOutcome::Status::not_judged: test.status = JunitCase::Status::skipped; break;
    case RequirementOutcome::Status::invalid: test.status = JunitCase::Status::error; break;
  }
  return test;
}

}  // namespace

std::string summary_csv(const BatchSummary& summary) {
  std::string text =
      "case,spec,trajectory,status,quantity,unit,peak,peak_time,rms,mean,range,total,peak_ratio,rms_ratio\n";
  const CaseRecord* record = summary.baseline_record();
  const MetricTable base = record == nullptr ? MetricTable{} : record->metric_table();
  for (std::size_t i = 0; i < summary.cases.size(); ++i)
    add_csv_lines(summary.cases[i], summary.specs[i], record == nullptr ? nullptr : &base, text);
  return text;
}

std::string summary_json(const BatchSummary& summary) {
  Json json = {{"suite", summary.name}, {"exit_code", summary.exit_code()}};
  json["baseline"] = files::text_or_null(summary.baseline);
  json["requirements"] = rows_json(summary.requirements, requirement_fields());
  json["cases"] = Json::array();
  for (std::size_t i = 0; i < summary.cases.size(); ++i)
    json["cases"].push_back(case_json(summary.cases[i], summary.specs[i], summary.published[i]));
  return files::format_json(json);
}

std::string summary_junit(const BatchSummary& summary) {
  reports::JunitSuite cases{summary.name + ".cases", {}}, requirements{summary.name + ".requirements", {}};
  for (std::size_t i = 0; i < summary.cases.size(); ++i)
    cases.cases.push_back(test_of(summary.cases[i], summary.specs[i], cases.name));
  for (const RequirementOutcome& outcome : summary.requirements)
    requirements.cases.push_back(test_of(outcome, requirements.name));
  std::vector<reports::JunitSuite> suites = {std::move(cases)};
  if (!requirements.cases.empty()) suites.push_back(std::move(requirements));
  return junit_xml(summary.name, suites);
}

namespace {

constexpr std::array<const char*, 3> shown_quantities{"torque", "shaking_force", "shaking_moment"};

const Metric* find(const CaseRecord& record, const std::string& quantity) {
  const auto at = std::find_if(record.metrics.begin(), record.metrics.end(),
                               [&](const Metric& metric) { return metric.quantity == quantity; });
  return at == record.metrics.end() ? nullptr : &*at;
}

struct SummaryColumns {
  std::vector<std::pair<std::string, std::string>> quantities;  ///< of at least one case, with units
  bool has_designs = false;
};

/// Shows a unit only if all cases agree on it.
SummaryColumns choose_columns(const BatchSummary& summary) {
  SummaryColumns columns;
  for (const char* quantity : shown_quantities) {
    std::vector<std::string> units;
    for (const CaseRecord& record : summary.cases)
      if (const Metric* metric = find(record, quantity)) units.push_back(metric->unit);
    if (units.empty()) continue;
    const bool same_unit = std::all_of(units.begin(), units.end(), [&](const std::string& u) { return u == units[0]; });
    columns.quantities.emplace_back(quantity, same_unit ? " [" + units[0] + "]" : "");
  }
  columns.has_designs = std::any_of(summary.cases.begin(), summary.cases.end(),
                                    [](const CaseRecord& record) { return record.design.has_value(); });
  return columns;
}

std::string ratio(const Metric& metric, const CaseRecord& base) {
  const Metric* other = find(base, metric.quantity);
  return other == nullptr || !(other->peak > 0) ? "-" : fmt::format("{:.4f}", metric.peak / other->peak);
}

void add_quantity(const CaseRecord& record, const std::string& quantity, const CaseRecord* base,
                  std::vector<std::string>& row) {
  const Metric* metric = find(record, quantity);
  row.push_back(metric == nullptr ? "-" : files::format_number(metric->peak));
  row.push_back(metric == nullptr ? "-" : files::format_number(metric->rms));
  if (base != nullptr) row.push_back(metric == nullptr ? "-" : ratio(*metric, *base));
}

}  // namespace

files::TextTable case_table(const BatchSummary& summary) {
  const SummaryColumns columns = choose_columns(summary);
  const CaseRecord* base = summary.baseline_record();
  files::TextTable table{{"case", "status"}, {Align::left, Align::left}, {}, 2};
  const auto add_column = [&](const std::string& heading) {
    table.heading.push_back(heading);
    table.align.push_back(Align::right);
  };
  for (const auto& [quantity, unit] : columns.quantities) {
    table.blocks.push_back(table.heading.size());
    add_column("peak " + quantity + unit);
    add_column("rms" + unit);
    if (base != nullptr) add_column("peak/base");
  }
  if (columns.has_designs) {
    table.blocks.push_back(table.heading.size());
    add_column("added mass [kg]");
  }
  for (const CaseRecord& record : summary.cases) {
    std::vector<std::string> row = {record.name, record.status};
    for (const auto& [quantity, unit] : columns.quantities) add_quantity(record, quantity, base, row);
    if (columns.has_designs) row.push_back(record.design ? files::format_number(record.design->added_mass) : "-");
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string format_summary_line(const BatchSummary& summary) {
  const auto count = [&](const char* status) {
    return std::count_if(summary.cases.begin(), summary.cases.end(),
                         [&](const CaseRecord& record) { return record.status == status; });
  };
  const auto done = count("done"), compromises = count("compromise"), missing = count("missing");
  const auto failed = static_cast<long>(summary.cases.size()) - done - compromises - missing;
  std::string text =
      fmt::format("{} case{}: {} done", summary.cases.size(), summary.cases.size() == 1 ? "" : "s", done);
  if (compromises > 0) text += fmt::format(", {} only a compromise", compromises);
  if (failed > 0) text += fmt::format(", {} failed", failed);
  if (missing > 0) text += fmt::format(", {} missing", missing);
  if (summary.requirements.empty()) return text;
  const auto held_count =
      std::count_if(summary.requirements.begin(), summary.requirements.end(),
                    [](const auto& outcome) { return outcome.status == RequirementOutcome::Status::holds; });
  return text + fmt::format("; {} of {} requirements hold", held_count, summary.requirements.size());
}

const char* requirement_status_name(RequirementOutcome::Status status) {
  switch (status) {
    case RequirementOutcome::Status::holds: return "holds";
    case RequirementOutcome::Status::violated: return "missed";
    case RequirementOutcome::Status::not_judged: return "not-judged";
    case RequirementOutcome::Status::invalid: return "wrong";
  }
  return "";
}

std::string requirement_title(const RequirementOutcome& outcome) {
  if (outcome.is_published) return fmt::format("{}: {}", outcome.run, outcome.text);
  return outcome.run.empty() ? outcome.text : fmt::format("{} [{}]", outcome.text, outcome.run);
}

// Summaries for people: on a terminal and as Markdown.
std::string format_batch_text(const BatchSummary& summary) {
  std::string text = summary.name + "\n\n" + format_table(case_table(summary));
  ReportFields<RequirementOutcome> fields = requirement_fields();
  std::erase_if(fields, [](const auto& field) { return field.key == "status"; });
  if (!summary.requirements.empty()) text += "\n" + format_table(rows_table(summary.requirements, fields));
  bool first = true;
  for (const CaseRecord& record : summary.cases) {
    if (record.message.empty()) continue;
    text += fmt::format("{}{}: {}\n", first ? "\n" : "", escape_for_terminal(record.name),
                        escape_for_terminal(record.message));
    first = false;
  }
  return text + "\n" + format_summary_line(summary) + "\n";
}

std::string format_failures(const BatchSummary& summary) {
  std::string text;
  for (const CaseRecord& record : summary.cases)
    if (record.status != "done")
      text += fmt::format("FAILED {}: {}\n", escape_for_terminal(record.name), escape_for_terminal(record.message));
  for (const RequirementOutcome& outcome : summary.requirements)
    if (outcome.status == RequirementOutcome::Status::violated || outcome.status == RequirementOutcome::Status::invalid)
      text += fmt::format("FAILED {}: {}\n", escape_for_terminal(requirement_title(outcome)),
                          escape_for_terminal(outcome.message));
  return text;
}

namespace {

/// Cases without a result, compromises, and requirements that are missed or wrong: what a reviewer reads first.
std::string list_markdown_failures(const BatchSummary& summary) {
  std::string text;
  for (const CaseRecord& record : summary.cases)
    if (!record.message.empty())
      text += fmt::format("- {} ({}): {}\n", files::escape_markdown(record.name), record.status,
                          files::escape_markdown(record.message));
  for (const RequirementOutcome& outcome : summary.requirements)
    if (outcome.status == RequirementOutcome::Status::violated || outcome.status == RequirementOutcome::Status::invalid)
      text += fmt::format("- {} ({}): {}\n", files::escape_markdown(requirement_title(outcome)),
                          requirement_status_name(outcome.status), files::escape_markdown(outcome.message));
  return text.empty() ? "" : "## What went wrong\n\n" + text + "\n";
}

std::string published_markdown(const BatchSummary& summary) {
  files::TextTable table{{"case", "number", "printed", "exact", "ours", "deviation", "verdict", "holds", "note"},
                         {Align::left, Align::left, Align::right, Align::right, Align::right, Align::right, Align::left,
                          Align::left, Align::left},
                         {}};
  std::string waiting, sources;
  for (std::size_t i = 0; i < summary.cases.size(); ++i) {
    const PublishedCase& published = summary.published[i];
    const std::string& name = summary.cases[i].name;
    if (!published.source.source.empty())
      sources +=
          fmt::format("- {}: {}{}\n", files::escape_markdown(name), files::escape_markdown(published.source.source),
                      published.source.page.empty() ? "" : ", p. " + files::escape_markdown(published.source.page));
    for (const PublishedOutcome& outcome : published.rows) {
      const PublishedRow& row = outcome.row;
      const double deviation = relative_deviation(outcome);
      table.rows.push_back({name, row.what + (row.unit.empty() ? "" : " [" + row.unit + "]"),
                            fmt::format("{}", row.printed), fmt::format("{}", row.exact),
                            std::isfinite(outcome.ours) ? fmt::format("{:.9g}", outcome.ours) : "-",
                            std::isnan(deviation) ? "-" : fmt::format("{:+.2g} %", 100 * deviation),
                            name_of(row.verdict), outcome.holds ? "yes" : "no", row.note});
    }
    for (const WaitingRow& row : published.source.waits)
      waiting += fmt::format("- {}: {}{}: {}\n", files::escape_markdown(name), files::escape_markdown(row.what),
                             row.printed.empty() ? ""
                                                 : files::escape_markdown(", printed " + row.printed +
                                                                          (row.unit.empty() ? "" : " " + row.unit)),
                             files::escape_markdown(row.reason));
  }
  std::string text;
  if (!table.rows.empty()) text += "\n## Published numbers\n\n" + format_markdown_table(table);
  if (!sources.empty()) text += "\n### Sources\n\n" + sources;
  if (!waiting.empty()) text += "\n### Numbers without a figure\n\n" + waiting;
  return text;
}

}  // namespace

std::string summary_markdown(const BatchSummary& summary) {
  std::string text =
      fmt::format("# {}\n\n{}.\n\n", files::escape_markdown(summary.name), format_summary_line(summary)) +
      list_markdown_failures(summary) + "## Cases\n\n";
  text += format_markdown_table(case_table(summary));
  if (!summary.baseline.empty())
    text += fmt::format("\nThe baseline is {}.\n", files::escape_markdown(summary.baseline));
  if (!summary.requirements.empty())
    text +=
        "\n## Requirements\n\n" + format_markdown_table(rows_table(summary.requirements, requirement_fields()), {0});
  return text + published_markdown(summary);
}

}  // namespace balance::batch
