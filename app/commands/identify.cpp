#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/option_values.hpp"
#include "cli/signals.hpp"
#include "cli/validators.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/reports/identification_request.hpp"
#include "balance/interface/reports/identification_sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

namespace balance::app {
namespace {

struct IdentifyOptions {
  SpecOptions spec;
  reports::IdentificationRequest request;
  // What is parsed before it is a part of the request.
  std::vector<std::string> columns;  ///< NAME=COLUMN
  std::string rows, time;            ///< FIRST:LAST
  std::vector<std::string> gains;    ///< ACTUATOR=NUMBER
  std::vector<std::string> loaded;   ///< PAYLOAD=FILE
  std::string output, h5;
  bool force = false;
};

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

reports::IdentificationRequest make_request(const IdentifyOptions& options) {
  reports::IdentificationRequest request = options.request;
  for (const std::string& text : options.columns)
    request.reading.columns.push_back(split_assignment(text, "--columns", "NAME=COLUMN"));
  if (const auto rows = parse_range(options.rows, "--rows")) {
    constexpr double last = 9e15;
    request.reading.rows = {static_cast<long>(std::max(rows->first, 1.0)),
                            static_cast<long>(std::min(rows->second, last))};
  }
  request.reading.time = parse_range(options.time, "--time");
  for (const std::string& text : options.gains) {
    const auto [name, number] = split_assignment(text, "--gain", "ACTUATOR=NUMBER");
    request.gains.emplace_back(name, parse_number_option(number, "--gain"));
  }
  for (const std::string& text : options.loaded)
    request.loaded.push_back(split_assignment(text, "--loaded", "PAYLOAD=FILE"));
  return request;
}

identification::Identification identify_or_throw(const Study& study, const reports::IdentificationRequest& request) {
  try {
    reports::RequestedIdentification found = reports::identify_from_records(study, request);
    if (found.refusal) throw MechanismFailure(found.refusal.status, found.refusal.reason);
    return std::move(found.answer);
  } catch (const reports::IdentificationRequestError& error) {
    throw UsageError(error.what());
  }
}

std::vector<std::string> write_files(const IdentifyOptions& options, const Study& study,
                                     const reports::IdentificationRequest& request,
                                     const identification::Identification& found) {
  std::vector<std::string> written;
  const SignalDeferral deferred;
  files::WriteOptions write;
  write.existing = options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
  write.is_cancelled = [] { return pending_signal() != 0; };
  if (!options.output.empty()) {
    for (const std::string& note : reports::write_identified_spec(options.output, study, found, write.existing))
      print_message("note: " + note);
    written.push_back(options.output);
  }
  if (!options.h5.empty()) {
    reports::write_identification(options.h5, found, reports::make_identification_provenance(study, request), write);
    written.push_back(options.h5);
  }
  return written;
}

ExitCode run(const IdentifyOptions& options) {
  const Study study = read_study(options.spec);
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  const reports::IdentificationRequest request = make_request(options);
  std::vector<files::InputFile> inputs = list_input_files(study);
  for (files::InputFile& record : reports::list_record_files(request)) inputs.push_back(std::move(record));
  check_standard_output({options.output, options.h5}, options.spec.json, options.h5 == files::standard_output_path);
  check_output(options.output, "the spec", FileFormat::yaml, inputs, options.force);
  check_output(options.h5, "the identification", FileFormat::hdf5, inputs, options.force);
  const identification::Identification found = identify_or_throw(study, request);
  const std::vector<std::string> files = write_files(options, study, request, found);
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
  parser
      .add_option("records", o.request.records,
                  "measurements: CSV, or HDF5 of balance simulate; all with the same columns")
      ->required()
      ->type_name("FILE");
  CLI::Option* validate =
      parser.add_option("--validate", o.request.validation, "a record that is only predicted; may be repeated")
          ->type_name("FILE")
          ->allow_extra_args(false);
  parser
      .add_option("--hold-out", o.request.hold_out,
                  "predict the second of every two spans of S seconds instead of fitting it")
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
  parser.add_option("--cutoff", o.request.cutoff, "frequency of the low-pass filter in Hz (default: from the motion)")
      ->type_name("HZ")
      ->check(number_range_validator(0, 1e6));
  parser.add_option("--rest", o.request.rest_rate, "rate below which a joint counts as at rest [rad/s or m/s]")
      ->type_name("RATE")
      ->check(number_range_validator(1e-9, 1e6))
      ->capture_default_str();
  parser
      .add_option("--gain", o.gains,
                  "effort per ampere of an actuator whose current was measured; unknown ones are found")
      ->type_name("ACTUATOR=NUMBER")
      ->allow_extra_args(false);
  parser.add_flag("--find-gains", o.request.finds_gains, "find the gains of currents that the spec states");
  parser
      .add_option("--loaded", o.loaded,
                  "a payload of the spec is carried in this record, and in no other unless it is named too")
      ->type_name("PAYLOAD=FILE")
      ->allow_extra_args(false);
  parser
      .add_option("--find-payload", o.request.payloads,
                  "find mass, centre of mass and inertia of this payload of the spec")
      ->type_name("NAME")
      ->allow_extra_args(false);
  add_choice_validator(parser
                           .add_option("--passive-friction", o.request.passive_friction,
                                       "friction to be found in passive joints that have none in the spec")
                           ->type_name("WORD")
                           ->capture_default_str(),
                       {"none", "viscous", "dry"});
  parser.add_option("--prior-weight", o.request.prior_weight, "weight of the spec's bodies")
      ->type_name("W")
      ->check(number_range_validator(1e-9, 1e9))
      ->capture_default_str();
  parser
      .add_option("--correlation", o.request.correlation_time,
                  "time within which residuals are correlated, for deviations [s]")
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
