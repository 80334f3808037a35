#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/signals.hpp"
#include "cli/validators.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/record_reader.hpp"
#include "balance/interface/reports/identification_sections.hpp"
#include "balance/interface/reports/identified_spec.hpp"
#include "balance/interface/specification/display_units.hpp"
#include "balance/synthesis/identification/identification.hpp"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <limits>
#include <memory>
#include <stdexcept>

namespace balance::app {
namespace {

struct IdentifyOptions {
  SpecOptions spec;
  std::vector<std::string> records, validation;
  std::vector<std::string> columns;  ///< NAME=COLUMN
  std::string rows, time;            ///< A:B
  double cutoff = 0, rest_rate = 0.02, prior_weight = 1, correlation_time = 1, hold_out = 0;
  std::vector<std::string> gains;     ///< NAME=NUMBER
  std::vector<std::string> loaded;    ///< PAYLOAD=FILE
  std::vector<std::string> payloads;  ///< to be found
  std::string passive_friction = "viscous";
  std::string output, h5;
  bool force = false;
};

std::pair<std::string, std::string> split_assignment(const std::string& text, const char* option, const char* form) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == text.size())
    throw UsageError(fmt::format("{}: expected {}, found {}", option, form, quote_for_message(text)));
  return {text.substr(0, equals), text.substr(equals + 1)};
}

double parse_number_option(const std::string& text, const char* option) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size())
    throw UsageError(fmt::format("{}: expected a number, found {}", option, quote_for_message(text)));
  return value;
}

/// "A:B", either of which may be empty.
std::optional<std::pair<double, double>> parse_range(const std::string& text, const char* option) {
  if (text.empty()) return {};
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos)
    throw UsageError(fmt::format("{}: expected FIRST:LAST, found {}", option, quote_for_message(text)));
  const std::string first = text.substr(0, colon), last = text.substr(colon + 1);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::pair<double, double> range{first.empty() ? -infinity : parse_number_option(first, option),
                                        last.empty() ? infinity : parse_number_option(last, option)};
  if (!(range.first < range.second))
    throw UsageError(fmt::format("{}: expected FIRST < LAST, found {}", option, quote_for_message(text)));
  return range;
}

files::RecordOptions make_record_options(const IdentifyOptions& options) {
  files::RecordOptions record;
  for (const std::string& text : options.columns)
    record.columns.push_back(split_assignment(text, "--columns", "NAME=COLUMN"));
  if (const auto rows = parse_range(options.rows, "--rows")) {
    constexpr double last = 9e15;
    record.rows = {static_cast<long>(std::max(rows->first, 1.0)), static_cast<long>(std::min(rows->second, last))};
  }
  record.time = parse_range(options.time, "--time");
  return record;
}

int find_actuator(const Mechanism& mechanism, const std::string& name, const char* option) {
  std::vector<std::string> names;
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a) {
    names.push_back(mechanism.coordinates[static_cast<std::size_t>(mechanism.actuators[a])].name);
    if (names.back() == name) return static_cast<int>(a);
  }
  throw UsageError(fmt::format("{}: no actuator {}; expected {}{}", option, quote_for_message(name),
                               join_alternatives(names), append_nearest_name(name, names)));
}

void check_payload(const Mechanism& mechanism, const std::string& name, const char* option) {
  std::vector<std::string> names;
  for (const Attachment& attachment : mechanism.attachments)
    if (attachment.kind == AttachmentKind::payload) names.push_back(attachment.name);
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw UsageError(names.empty() ? fmt::format("{}: the spec has no payloads", option)
                                   : fmt::format("{}: no payload {}; expected {}{}", option, quote_for_message(name),
                                                 join_alternatives(names), append_nearest_name(name, names)));
}

identification::IdentificationOptions make_options(const IdentifyOptions& options, const Mechanism& mechanism) {
  identification::IdentificationOptions identify;
  identify.signals = {options.cutoff, options.rest_rate};
  identify.prior_weight = options.prior_weight;
  identify.correlation_time = options.correlation_time;
  identify.hold_out = options.hold_out;
  using identification::PassiveFriction;
  identify.unknowns.passive_friction = options.passive_friction == "none"  ? PassiveFriction::none
                                       : options.passive_friction == "dry" ? PassiveFriction::dry
                                                                           : PassiveFriction::viscous;
  for (const std::string& text : options.gains) {
    const auto [name, number] = split_assignment(text, "--gain", "ACTUATOR=NUMBER");
    const double gain = parse_number_option(number, "--gain");
    if (!(gain > 0)) throw UsageError(fmt::format("--gain: expected a number > 0, found {}", number));
    identify.gains.emplace_back(find_actuator(mechanism, name, "--gain"), gain);
  }
  for (const std::string& name : options.payloads) {
    check_payload(mechanism, name, "--find-payload");
    identify.unknowns.payloads.push_back(name);
  }
  return identify;
}

/// Records carry the payloads that no --loaded restricts to other files.
std::vector<std::string> list_carried(const IdentifyOptions& options, const Mechanism& mechanism,
                                      const std::string& file) {
  std::vector<std::string> carried;
  for (const Attachment& attachment : mechanism.attachments) {
    if (attachment.kind != AttachmentKind::payload) continue;
    bool is_restricted = false, is_here = false;
    for (const std::string& text : options.loaded) {
      const auto [name, loaded_file] = split_assignment(text, "--loaded", "PAYLOAD=FILE");
      if (name != attachment.name) continue;
      is_restricted = true;
      is_here = is_here || loaded_file == file;
    }
    if (!is_restricted || is_here) carried.push_back(attachment.name);
  }
  return carried;
}

void check_loaded(const IdentifyOptions& options, const Mechanism& mechanism) {
  for (const std::string& text : options.loaded) {
    const auto [name, file] = split_assignment(text, "--loaded", "PAYLOAD=FILE");
    check_payload(mechanism, name, "--loaded");
    const auto is_named = [&file = file](const std::vector<std::string>& files) {
      return std::find(files.begin(), files.end(), file) != files.end();
    };
    if (!is_named(options.records) && !is_named(options.validation))
      throw UsageError(fmt::format("--loaded: {} is not one of the records", quote_for_message(file)));
  }
}

std::vector<identification::MeasurementRecord> read_records(const IdentifyOptions& options, const Study& study,
                                                            const std::vector<std::string>& paths) {
  const files::RecordOptions record_options = make_record_options(options);
  const specification::SpecUnits units = specification::read_display_units(study.spec_text);
  std::vector<identification::MeasurementRecord> records;
  for (const std::string& path : paths) {
    records.push_back(files::read_record_file(path, study.mechanism, units, record_options));
    records.back().payloads = list_carried(options, study.mechanism, path);
  }
  return records;
}

std::vector<files::InputFile> list_inputs(const IdentifyOptions& options, const Study& study) {
  std::vector<files::InputFile> inputs = list_input_files(study);
  for (const auto* paths : {&options.records, &options.validation})
    for (const std::string& path : *paths) inputs.push_back({path, "a record"});
  return inputs;
}

std::string command_line(const IdentifyOptions& options, const Study& study) {
  const auto file_name = [](const std::string& path) { return std::filesystem::path(path).filename().string(); };
  std::vector<std::string> words{"balance", "identify", file_name(study.spec_file)};
  for (const std::string& path : options.records) words.push_back(file_name(path));
  for (const std::string& path : options.validation) words.insert(words.end(), {"--validate", file_name(path)});
  for (const std::string& text : options.columns) words.insert(words.end(), {"--columns", text});
  files::append_overrides(words, study);
  return files::join_command(std::move(words));
}

std::vector<std::string> write_files(const IdentifyOptions& options, const Study& study,
                                     const identification::Identification& found) {
  std::vector<std::string> written;
  const SignalDeferral deferred;
  if (!options.output.empty()) {
    const reports::IdentifiedSpec spec = reports::format_identified_spec(study, found);
    for (const std::string& note : spec.notes) print_message("note: " + note);
    files::AtomicFile file(options.output,
                           options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid);
    file.write(spec.text);
    file.commit();
    written.push_back(options.output);
  }
  if (!options.h5.empty()) {
    files::WriteOptions write;
    write.existing = options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
    write.is_cancelled = [] { return pending_signal() != 0; };
    reports::write_identification(options.h5, found, files::make_provenance(study, command_line(options, study)),
                                  write);
    written.push_back(options.h5);
  }
  return written;
}

ExitCode run(const IdentifyOptions& options) {
  const Study study = read_study(options.spec);
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  const std::vector<files::InputFile> inputs = list_inputs(options, study);
  check_standard_output({options.output, options.h5}, options.spec.json, options.h5 == files::standard_output_path);
  check_output(options.output, "the spec", FileFormat::yaml, inputs, options.force);
  check_output(options.h5, "the identification", FileFormat::hdf5, inputs, options.force);
  check_loaded(options, study.mechanism);
  const identification::IdentificationOptions identify_options = make_options(options, study.mechanism);
  const auto training = read_records(options, study, options.records),
             validation = read_records(options, study, options.validation);
  identification::Identification found;
  try {
    found = identification::identify(study.mechanism, training, validation, identify_options);
  } catch (const identification::RecordError& error) {
    throw MechanismFailure("record", error.what());
  } catch (const identification::IdentificationError& error) {
    throw MechanismFailure("not-identifiable", error.what());
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = {.file = study.spec_file}, .message = error.what()});
  }
  const std::vector<std::string> files = write_files(options, study, found);
  if (options.spec.json) {
    print(files::format_json(reports::identification_json(found, study.mechanism.name, files)));
    return ExitCode::done;
  }
  std::string text =
      reports::identification_text(found, study.mechanism.name, choose_text_options(options.spec, study));
  for (const std::string& file : files) text += format_written_message(file);
  print_status(files, text);
  return ExitCode::done;
}

void add_identify_options(CLI::App& parser, IdentifyOptions& o) {
  add_spec_options(parser, o.spec);
  parser.add_option("records", o.records, "measurements: CSV, or HDF5 of balance simulate; all with the same columns")
      ->required()
      ->type_name("FILE");
  CLI::Option* validate =
      parser.add_option("--validate", o.validation, "a record that is only predicted; may be repeated")
          ->type_name("FILE")
          ->allow_extra_args(false);
  parser
      .add_option("--hold-out", o.hold_out, "predict the second of every two spans of S seconds instead of fitting it")
      ->type_name("S")
      ->check(number_range_validator(1e-6, 1e9))
      ->excludes(validate);
  parser
      .add_option("--columns", o.columns,
                  "what columns with other names are, by name or number: time=t,A1=q1,A1.effort=7")
      ->delimiter(',')
      ->type_name("NAME=COLUMN,...")
      ->allow_extra_args(false);
  parser.add_option("--rows", o.rows, "rows of numbers to use, FIRST:LAST, from 1")->type_name("RANGE");
  parser.add_option("--time", o.time, "times to use, FIRST:LAST")->type_name("RANGE");
  parser.add_option("--cutoff", o.cutoff, "frequency of the low-pass filter in Hz (default: from the motion)")
      ->type_name("HZ")
      ->check(number_range_validator(0, 1e6));
  parser.add_option("--rest", o.rest_rate, "rate below which a joint counts as at rest [rad/s or m/s]")
      ->type_name("RATE")
      ->check(number_range_validator(1e-9, 1e6))
      ->capture_default_str();
  parser
      .add_option("--gain", o.gains,
                  "effort per ampere of an actuator whose current was measured; unknown ones are found")
      ->type_name("ACTUATOR=NUMBER")
      ->allow_extra_args(false);
  parser
      .add_option("--loaded", o.loaded,
                  "a payload of the spec is carried in this record, and in no other unless it is named too")
      ->type_name("PAYLOAD=FILE")
      ->allow_extra_args(false);
  parser.add_option("--find-payload", o.payloads, "find mass, centre of mass and inertia of this payload of the spec")
      ->type_name("NAME")
      ->allow_extra_args(false);
  add_choice_validator(parser
                           .add_option("--passive-friction", o.passive_friction,
                                       "friction to be found in passive joints that have none in the spec")
                           ->type_name("WORD")
                           ->capture_default_str(),
                       {"none", "viscous", "dry"});
  parser.add_option("--prior-weight", o.prior_weight, "weight of the spec's bodies")
      ->type_name("W")
      ->check(number_range_validator(1e-9, 1e9))
      ->capture_default_str();
  parser
      .add_option("--correlation", o.correlation_time, "time within which residuals are correlated, for deviations [s]")
      ->type_name("S")
      ->check(number_range_validator(1e-6, 1e6))
      ->capture_default_str();
  parser.add_option("-o,--output", o.output, "write the spec with the numbers that were found")->type_name("FILE");
  parser.add_option("--h5", o.h5, "write parameters, covariance and measured and predicted efforts to this HDF5 file")
      ->type_name("FILE");
  parser.add_flag("--force", o.force, "overwrite existing files");
  add_units_option(parser, o.spec.units);
}

}  // namespace

Command setup_identify(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("identify", "Find masses, inertia and friction from measurements");
  const auto options = std::make_shared<IdentifyOptions>();
  add_identify_options(*parser, *options);
  parser->footer(
      "Columns of a record are time, a coordinate by its name (A1), A1.rate, A1.effort or A1.current, and\n"
      "force and moment on the frame (fx, fy, m). Positions are differentiated, everything is low-passed\n"
      "alike without delay, and rows of joints at rest are left out.\n\n"
      "The answer has the combinations that the motion determines, with deviations that hold for correlated\n"
      "residuals; physically possible bodies that are as near to the spec as the measurements allow; and\n"
      "what the records cannot say.\n\n"
      "Examples:\n"
      "  balance identify 5r.yaml log.csv --validate other.csv -o found.yaml\n"
      "  balance identify arm.yaml log.csv --columns A1=q1,A1.effort=tau1 --json\n"
      "  balance identify arm.yaml a.csv b.csv --loaded tool=b.csv --find-payload tool");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
