#include "balance/interface/batch/case_record.hpp"

#include "balance/interface/comparison/figure_evaluation.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/sha256.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <utility>

namespace balance::batch {

using comparison::EvaluatedFigure;

namespace {

std::string path_in(const std::string& folder, const std::string& file) {
  return (std::filesystem::path(folder) / file).string();
}

/// Far more than the thousands of metrics of the largest mechanism need.
constexpr std::uintmax_t max_record_bytes = std::uintmax_t{64} << 20;

/// Neither a link nor a device.
bool is_plain_file(const std::string& path) {
  std::error_code error;
  return std::filesystem::symlink_status(path, error).type() == std::filesystem::file_type::regular;
}

double read_number(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Metric metric_of(const Json& json) {
  Metric metric;
  metric.quantity = json.at("quantity");
  metric.unit = json.at("unit");
  metric.peak = read_number(json.at("peak"));
  metric.peak_time = read_number(json.at("peak_time"));
  metric.rms = read_number(json.at("rms"));
  metric.mean = read_number(json.at("mean"));
  metric.range = read_number(json.at("range"));
  return metric;
}

/// Optional keys of a figure.
constexpr std::array<std::pair<const char*, std::string EvaluatedFigure::*>, 5> figure_text_keys{
    {{"unit", &EvaluatedFigure::unit},
     {"word", &EvaluatedFigure::word},
     {"reason", &EvaluatedFigure::reason},
     {"mistake", &EvaluatedFigure::mistake},
     {"name", &EvaluatedFigure::mistaken_name}}};

EvaluatedFigure figure_of(const Json& json) {
  EvaluatedFigure figure;
  figure.text = json.at("figure");
  figure.value = read_number(json.at("value"));
  for (const auto& [key, text] : figure_text_keys)
    if (json.contains(key)) figure.*text = json.at(key);
  return figure;
}

Json figure_json(const EvaluatedFigure& figure) {
  Json json = {{"figure", figure.text}, {"value", figure.value}};
  for (const auto& [key, text] : figure_text_keys)
    if (!(figure.*text).empty()) json[key] = figure.*text;
  return json;
}

constexpr const char* digest_key = "sha256";

/// Whether records with this status are stored.
bool is_stored_status(const std::string& status) {
  constexpr std::array stored_statuses{"done", "compromise", "spec", "mechanism", "failed"};
  return std::find(stored_statuses.begin(), stored_statuses.end(), status) != stored_statuses.end();
}

CaseRecord record_of(const Json& json) {
  CaseRecord record;
  record.name = json.at("name");
  record.cache_key = json.at("key");
  record.status = json.at("status");
  record.message = json.at("message");
  record.title = json.at("title");
  record.trajectory = json.at("trajectory");
  record.samples = json.at("samples");
  record.seconds = json.at("seconds");
  if (json.contains("failure"))
    record.failure = {json.at("failure").at("cause"), read_number(json.at("failure").at("limit"))};
  if (json.contains("design")) {
    const Json& design = json.at("design");
    record.design = {design.at("status"), design.at("reason"), read_number(design.at("mass_before")),
                     read_number(design.at("mass_after")), read_number(design.at("added_mass"))};
  }
  for (const Json& metric : json.at("metrics")) record.metrics.push_back(metric_of(metric));
  record.energy = read_number(json.at("energy"));
  if (json.contains("figures"))
    for (const Json& figure : json.at("figures")) record.figures.push_back(figure_of(figure));
  if (json.contains("solved"))
    for (const auto& [name, value] : json.at("solved").items()) record.solved.emplace_back(name, read_number(value));
  record.warnings = json.at("warnings").get<std::vector<std::string>>();
  record.notes = json.at("notes").get<std::vector<std::string>>();
  for (const Json& file : json.at("files")) record.files.push_back({file.at("name"), file.at("sha256")});
  return record;
}

}  // namespace

bool CaseRecord::has_samples() const {
  return std::any_of(files.begin(), files.end(),
                     [&](const RecordedFile& file) { return file.name == result_file_name(name); });
}

bool CaseRecord::answers(const std::vector<comparison::FigureReference>& asked) const {
  const comparison::MetricTable table = metric_table();
  return std::all_of(asked.begin(), asked.end(), [&](const comparison::FigureReference& figure) {
    return has_figure(table, figure) || find_evaluated_figure(table, figure.text()) != nullptr;
  });
}

CaseRecord accept_verdict(CaseRecord record, bool is_design_only) {
  const bool is_accepted =
      record.design && (record.status == "compromise" || (record.status == "mechanism" && is_design_only));
  if (!is_accepted) return record;
  record.status = "done";
  record.message.clear();
  return record;
}

int CaseRecord::exit_code() const {
  if (status == "done") return 0;
  if (status == "compromise") return 1;
  if (status == "spec") return 3;
  if (status == "mechanism") return 4;
  return 5;
}

std::string encode_record(const CaseRecord& record) {
  Json json = {{"name", record.name},       {"key", record.cache_key},  {"status", record.status},
               {"message", record.message}, {"title", record.title},    {"trajectory", record.trajectory},
               {"samples", record.samples}, {"seconds", record.seconds}};
  if (record.failure) json["failure"] = {{"cause", record.failure->cause}, {"limit", record.failure->limit}};
  if (record.design)
    json["design"] = {{"status", record.design->status},
                      {"reason", record.design->reason},
                      {"mass_before", record.design->mass_before},
                      {"mass_after", record.design->mass_after},
                      {"added_mass", record.design->added_mass}};
  json["metrics"] = files::metrics_json(record.metrics);
  json["energy"] = record.energy;
  for (const EvaluatedFigure& figure : record.figures) json["figures"].push_back(figure_json(figure));
  for (const auto& [name, value] : record.solved) json["solved"][name] = value;
  json["warnings"] = record.warnings;
  json["notes"] = record.notes;
  json["files"] = Json::array();
  for (const RecordedFile& file : record.files) json["files"].push_back({{"name", file.name}, {"sha256", file.sha256}});
  // the last key, appended as text: serialising all numbers again takes long
  std::string text = files::format_json(json);
  const std::string digest = files::sha256(text);
  constexpr std::string_view end = "\n}\n";
  text.resize(text.size() - end.size());
  return text.append(",\n  \"").append(digest_key).append("\": \"").append(digest).append("\"").append(end);
}

std::optional<CaseRecord> decode_record(const std::string& text) {
  try {
    CaseRecord record = record_of(Json::parse(text));
    return encode_record(record) == text ? std::optional(std::move(record)) : std::nullopt;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::string record_file_name(const std::string& case_name) { return case_name + ".case.json"; }
std::string result_file_name(const std::string& case_name) { return case_name + ".h5"; }
std::string balanced_spec_file_name(const std::string& case_name) { return case_name + ".yaml"; }

void store_record(const std::string& folder, const CaseRecord& record, const std::string& text) {
  files::AtomicFile file(path_in(folder, record_file_name(record.name)), files::OverwritePolicy::replace,
                         temporary_tag);
  file.write(text);
  file.commit(files::Durability::deferred);
}

std::optional<CaseRecord> load_valid_record(const std::string& folder, const std::string& case_name,
                                            const std::string& key) {
  const std::string path = path_in(folder, record_file_name(case_name));
  std::error_code error;
  if (!is_plain_file(path) || std::filesystem::file_size(path, error) > max_record_bytes) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  std::optional<CaseRecord> record = decode_record(text.str());
  if (!record || record->name != case_name || record->cache_key != key || !is_stored_status(record->status))
    return std::nullopt;
  const bool intact = std::all_of(record->files.begin(), record->files.end(), [&](const RecordedFile& recorded_file) {
    if (recorded_file.name != result_file_name(case_name) && recorded_file.name != balanced_spec_file_name(case_name))
      return false;
    const std::string name = path_in(folder, recorded_file.name);
    return is_plain_file(name) && files::sha256_of_file(name) == recorded_file.sha256;
  });
  return intact ? record : std::nullopt;
}

}  // namespace balance::batch
