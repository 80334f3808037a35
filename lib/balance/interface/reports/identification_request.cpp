#include "balance/interface/reports/identification_request.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/reports/identified_spec.hpp"
#include "balance/interface/specification/display_units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

namespace balance::reports {

using identification::IdentificationOptions;
using identification::PassiveFriction;

namespace {

constexpr double max_cutoff = 1e6, max_rest_rate = 1e6, max_prior_weight = 1e9, max_correlation_time = 1e6,
                 max_hold_out = 1e9;

/// @param smallest, largest of the numbers that are accepted
void check_number(const char* option, double value, double smallest, double largest) {
  if (!(value >= smallest && value <= largest))
    throw IdentificationRequestError(
        option, fmt::format("expected a number from {:g} to {:g}, found {:g}", smallest, largest, value));
}

int find_actuator(const Mechanism& mechanism, const std::string& name) {
  std::vector<std::string> names;
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a) {
    names.push_back(mechanism.coordinates[static_cast<std::size_t>(mechanism.actuators[a])].name);
    if (names.back() == name) return static_cast<int>(a);
  }
  throw IdentificationRequestError("gain", fmt::format("no actuator {}; expected {}{}", quote_for_message(name),
                                                       join_alternatives(names), append_nearest_name(name, names)));
}

void check_payload(const Mechanism& mechanism, const std::string& name, const char* option) {
  std::vector<std::string> names;
  for (const Attachment& attachment : mechanism.attachments)
    if (attachment.kind == AttachmentKind::payload) names.push_back(attachment.name);
  if (names.empty()) throw IdentificationRequestError(option, "the spec has no payloads");
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw IdentificationRequestError(option, fmt::format("no payload {}; expected {}{}", quote_for_message(name),
                                                         join_alternatives(names), append_nearest_name(name, names)));
}

void check_loaded(const IdentificationRequest& request, const Mechanism& mechanism) {
  for (const auto& [name, file] : request.loaded) {
    check_payload(mechanism, name, "loaded");
    const auto is_named = [&file = file](const std::vector<std::string>& files) {
      return std::find(files.begin(), files.end(), file) != files.end();
    };
    if (!is_named(request.records) && !is_named(request.validation))
      throw IdentificationRequestError("loaded", fmt::format("{} is not one of the records", quote_for_message(file)));
  }
}

PassiveFriction read_passive_friction(const std::string& word) {
  if (word == "none") return PassiveFriction::none;
  if (word == "viscous") return PassiveFriction::viscous;
  if (word == "dry") return PassiveFriction::dry;
  throw IdentificationRequestError("passive-friction",
                                   fmt::format("expected none, viscous or dry, found {}", quote_for_message(word)));
}

void check_numbers(const IdentificationRequest& request) {
  check_number("cutoff", request.cutoff, 0, max_cutoff);
  check_number("rest", request.rest_rate, 1e-9, max_rest_rate);
  check_number("prior-weight", request.prior_weight, 1e-9, max_prior_weight);
  check_number("correlation", request.correlation_time, 1e-6, max_correlation_time);
  if (request.hold_out == 0) return;
  check_number("hold-out", request.hold_out, 1e-6, max_hold_out);
  if (!request.validation.empty())
    throw IdentificationRequestError("hold-out", "excluded by records that are only predicted");
}

/// Those of the request, then those of the spec.
std::vector<std::pair<int, double>> choose_gains(const IdentificationRequest& request, const Study& study) {
  std::vector<std::pair<int, double>> gains;
  for (const auto& [name, gain] : request.gains) {
    if (!(gain > 0 && std::isfinite(gain)))
      throw IdentificationRequestError("gain", fmt::format("expected a number > 0, found {:g}", gain));
    gains.emplace_back(find_actuator(study.mechanism, name), gain);
  }
  for (const auto& [coordinate, gain] : study.current_gains) {
    const int actuator =
        find_actuator(study.mechanism, study.mechanism.coordinates[static_cast<std::size_t>(coordinate)].name);
    const auto is_same = [&](const auto& one) { return one.first == actuator; };
    if (std::none_of(gains.begin(), gains.end(), is_same) && !request.finds_gains) gains.emplace_back(actuator, gain);
  }
  return gains;
}

IdentificationOptions make_options(const IdentificationRequest& request, const Study& study) {
  const Mechanism& mechanism = study.mechanism;
  IdentificationOptions options;
  options.signals = {request.cutoff, request.rest_rate};
  options.prior_weight = request.prior_weight;
  options.correlation_time = request.correlation_time;
  options.hold_out = request.hold_out;
  options.unknowns.passive_friction = read_passive_friction(request.passive_friction);
  options.gains = choose_gains(request, study);
  for (const std::string& name : request.payloads) check_payload(mechanism, name, "find-payload");
  options.unknowns.payloads = request.payloads;
  return options;
}

/// Records carry the payloads that `loaded` does not restrict to other files.
std::vector<std::string> list_carried(const IdentificationRequest& request, const Mechanism& mechanism,
                                      const std::string& file) {
  std::vector<std::string> carried;
  for (const Attachment& attachment : mechanism.attachments) {
    if (attachment.kind != AttachmentKind::payload) continue;
    bool is_restricted = false, is_here = false;
    for (const auto& [name, loaded_file] : request.loaded) {
      if (name != attachment.name) continue;
      is_restricted = true;
      is_here = is_here || loaded_file == file;
    }
    if (!is_restricted || is_here) carried.push_back(attachment.name);
  }
  return carried;
}

std::vector<MeasurementRecord> read_records(const IdentificationRequest& request, const Study& study,
                                            const std::vector<std::string>& paths) {
  const specification::SpecUnits units = specification::read_display_units(study.spec_text);
  std::vector<MeasurementRecord> records;
  for (const std::string& path : paths) {
    records.push_back(files::read_record_file(path, study.mechanism, units, request.reading));
    records.back().payloads = list_carried(request, study.mechanism, path);
  }
  return records;
}

std::string number_text(double value) { return fmt::format("{}", value); }

/// "2:8", "2:", ":8".
std::string range_text(const std::pair<double, double>& range) {
  return fmt::format("{}:{}", std::isfinite(range.first) ? number_text(range.first) : "",
                     std::isfinite(range.second) ? number_text(range.second) : "");
}

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

}  // namespace

RequestedIdentification identify_from_records(const Study& study, const IdentificationRequest& request) {
  if (request.records.empty()) throw std::invalid_argument("records: expected at least one file");
  check_numbers(request);
  check_loaded(request, study.mechanism);
  const IdentificationOptions options = make_options(request, study);
  const std::vector<MeasurementRecord> training = read_records(request, study, request.records),
                                       validation = read_records(request, study, request.validation);
  try {
    return {{}, identification::identify(study.mechanism, training, validation, options)};
  } catch (const identification::RecordError& error) {
    return {{"record", error.what()}, {}};
  } catch (const identification::IdentificationError& error) {
    return {{"not-identifiable", error.what()}, {}};
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = {.file = study.spec_file}, .message = error.what()});
  }
}

std::vector<files::InputFile> list_record_files(const IdentificationRequest& request) {
  std::vector<files::InputFile> inputs;
  for (const auto* paths : {&request.records, &request.validation})
    for (const std::string& path : *paths) inputs.push_back({path, "a record"});
  return inputs;
}

files::Provenance make_identification_provenance(const Study& study, const IdentificationRequest& request) {
  const IdentificationRequest defaults;
  std::vector<std::string> words{"balance", "identify", file_name(study.spec_file)};
  const auto add = [&](const char* option, const std::string& value) { words.insert(words.end(), {option, value}); };
  const auto add_number = [&](const char* option, double value, double its_default) {
    if (value != its_default) add(option, number_text(value));
  };
  for (const std::string& path : request.records) words.push_back(file_name(path));
  for (const std::string& path : request.validation) add("--validate", file_name(path));
  for (const auto& [name, column] : request.reading.columns) add("--columns", name + "=" + column);
  if (const auto& rows = request.reading.rows) add("--rows", fmt::format("{}:{}", rows->first, rows->second));
  if (request.reading.time) add("--time", range_text(*request.reading.time));
  add_number("--cutoff", request.cutoff, defaults.cutoff);
  add_number("--rest", request.rest_rate, defaults.rest_rate);
  for (const auto& [name, gain] : request.gains) add("--gain", name + "=" + number_text(gain));
  if (request.finds_gains) words.emplace_back("--find-gains");
  for (const auto& [name, file] : request.loaded) add("--loaded", name + "=" + file_name(file));
  for (const std::string& name : request.payloads) add("--find-payload", name);
  if (request.passive_friction != defaults.passive_friction) add("--passive-friction", request.passive_friction);
  add_number("--prior-weight", request.prior_weight, defaults.prior_weight);
  add_number("--correlation", request.correlation_time, defaults.correlation_time);
  add_number("--hold-out", request.hold_out, defaults.hold_out);
  files::append_overrides(words, study);
  return files::make_provenance(study, files::join_command(std::move(words)));
}

std::vector<std::string> write_identified_spec(const std::string& path, const Study& study,
                                               const identification::Identification& found,
                                               files::OverwritePolicy existing) {
  IdentifiedSpec spec = format_identified_spec(study, found);
  files::AtomicFile file(path, existing);
  file.write(spec.text);
  file.commit();
  return std::move(spec.notes);
}

}  // namespace balance::reports
