// A summary for programs: CSV, JSON and JUnit XML.

#include "balance/batch/summary_table.hpp"
#include "balance/compare/metric_table.hpp"
#include "balance/present/junit.hpp"
#include "balance/write/csv_field.hpp"
#include "balance/write/json_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace balance {
namespace {

/// The shortest text that reads back to the same value; nothing for what is not a number.
std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string csv_ratio(double value, double base) { return base > 0 ? csv_number(value / base) : ""; }

void add_csv_lines(const CaseRecord& record, const std::string& spec, const MetricTable* base, std::string& text) {
  const std::string begin = fmt::format("{},{},{},{}", escape_csv_field(record.name), escape_csv_field(spec),
                                        escape_csv_field(record.trajectory), record.status);
  if (!record.has_result()) {
    text += begin + ",,,,,,,,,,\n";
    return;
  }
  for (const Metric& metric : record.metrics) {
    const Metric* other = base == nullptr ? nullptr : find_metric(*base, metric.quantity);
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{},,{},{}\n", begin,
                   escape_csv_field(metric.quantity), metric.unit, csv_number(metric.peak),
                   csv_number(metric.peak_time), csv_number(metric.rms), csv_number(metric.mean),
                   csv_number(metric.range), other == nullptr ? "" : csv_ratio(metric.peak, other->peak),
                   other == nullptr ? "" : csv_ratio(metric.rms, other->rms));
  }
  text += fmt::format("{},energy,J,,,,,,{},,\n", begin, csv_number(record.energy));
}

Json case_json(const CaseRecord& record, const std::string& spec) {
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
  json["metrics"] = Json::array();
  for (const Metric& metric : record.metrics) json["metrics"].push_back(metric_json(metric));
  json["energy"] = record.energy;
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

JunitCase test_of(const RequirementOutcome& one, const std::string& group) {
  JunitCase test{.group = group, .name = requirement_title(one), .message = one.message, .kind = "requirement"};
  switch (one.status) {
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
  const MetricTable base =
      record == nullptr ? MetricTable{} : MetricTable{record->name, record->metrics, record->energy};
  for (std::size_t i = 0; i < summary.cases.size(); ++i)
    add_csv_lines(summary.cases[i], summary.specs[i], record == nullptr ? nullptr : &base, text);
  return text;
}

std::string summary_json(const BatchSummary& summary) {
  Json json = {{"suite", summary.name}, {"exit_code", summary.exit_code()}};
  json["baseline"] = summary.baseline.empty() ? Json(nullptr) : Json(summary.baseline);
  json["requirements"] = Json::array();
  for (const RequirementOutcome& one : summary.requirements)
    json["requirements"].push_back({{"requirement", one.text},
                                    {"case", one.run.empty() ? Json(nullptr) : Json(one.run)},
                                    {"status", requirement_status_name(one.status)},
                                    {"verdict", one.message}});
  json["cases"] = Json::array();
  for (std::size_t i = 0; i < summary.cases.size(); ++i)
    json["cases"].push_back(case_json(summary.cases[i], summary.specs[i]));
  return format_json(json);
}

std::string summary_junit(const BatchSummary& summary) {
  JunitSuite cases{summary.name + ".cases", {}}, requirements{summary.name + ".requirements", {}};
  for (std::size_t i = 0; i < summary.cases.size(); ++i)
    cases.cases.push_back(test_of(summary.cases[i], summary.specs[i], cases.name));
  for (const RequirementOutcome& one : summary.requirements)
    requirements.cases.push_back(test_of(one, requirements.name));
  std::vector<JunitSuite> suites = {std::move(cases)};
  if (!requirements.cases.empty()) suites.push_back(std::move(requirements));
  return junit_xml(summary.name, suites);
}

}  // namespace balance
