#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/signals.hpp"
#include "cli/validators.hpp"
#include "run_operands.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/interface/reports/modes_request.hpp"

#include <memory>

namespace balance::app {
namespace {

constexpr int max_response_order = 100, max_exact_count = 100'000;

struct ModesOptions {
  SpecOptions spec;
  reports::ModesRequest request;
  std::string output;  ///< HDF5 file to write; empty: none
  bool force = false;
};

reports::VibrationReportData analyse_or_throw(const ModesOptions& options, const Study& study) {
  const files::DisplayUnit speed_unit =
      files::find_display_unit("rad/s", choose_text_options(options.spec, study).units);
  ProgressLine line(false);
  try {
    reports::VibrationReportData view = reports::analyse_modes(
        study, options.request, speed_unit, [&](double fraction) { line.draw_fraction("sweep", fraction); });
    if (view.modes.motion.outcome.status != MotionStatus::done)
      throw MotionFailure(view.modes.motion.outcome, study, view.modes.trajectory);
    return view;
  } catch (const reports::SweepError& error) {
    throw UsageError(error.what());
  }
}

std::vector<std::string> write_report(const ModesOptions& options, const Study& study,
                                      const reports::VibrationReportData& view) {
  if (options.output.empty()) return {};
  files::WriteOptions write;
  write.existing = options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  write_vibration_report(options.output, view,
                         reports::make_modes_provenance(study, view.modes.trajectory, options.request), write);
  return {options.output};
}

ExitCode run(const ModesOptions& options) {
  const Study study = read_study(options.spec);
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  check_standard_output({options.output}, options.spec.json, options.output == files::standard_output_path);
  check_output(options.output, "the result", FileFormat::hdf5, list_input_files(study), options.force);
  const reports::VibrationReportData view = analyse_or_throw(options, study);
  const std::vector<std::string> files = write_report(options, study, view);
  if (options.spec.json) {
    print(files::format_json(reports::vibration_report_json(view)));
  } else {
    std::string text = reports::vibration_report_text(view, choose_text_options(options.spec, study));
    for (const std::string& file : files) text += "\n" + format_written_message(file);
    print_status(files, text);
  }
  return ExitCode::done;
}

void add_modes_options(CLI::App& parser, ModesOptions& o) {
  add_spec_options(parser, o.spec);
  add_units_option(parser, o.spec.units);
  parser
      .add_option("-t,--trajectory", o.request.trajectory,
                  "trajectory of the spec (default: the first with free coordinates, else the first)")
      ->type_name("NAME");
  parser
      .add_option("--sweep", o.request.sweep,
                  "over a parameter of the spec, or over the speed of the joint that turns (default COUNT: 101)")
      ->type_name("NAME=FROM:TO:COUNT");
  parser.add_option("--orders", o.request.orders, "highest order of the response to a joint that turns")
      ->type_name("N")
      ->check(integer_range_validator(1, max_response_order))
      ->capture_default_str();
  parser
      .add_option("--exact", o.request.exact,
                  "values of a sweep at which the response is also computed exactly; 0: nowhere, linear figures alone")
      ->type_name("N")
      ->check(integer_range_validator(0, max_exact_count))
      ->capture_default_str();
  CLI::Option* output = parser.add_option("-o,--output", o.output, "write modes, response and sweep to this HDF5 file")
                            ->type_name("FILE");
  parser.add_flag("--force", o.force, "overwrite an existing file")->needs(output);
}

}  // namespace

Command setup_modes(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("modes", "Vibrations: frequencies, damping, shapes, response to orders");
  const auto options = std::make_shared<ModesOptions>();
  add_modes_options(*parser, *options);
  parser->footer(
      "Modes of the coordinates that the trajectory leaves `free`, linearised about the steady motion if\n"
      "the driven joints turn at constant speed, else about the equilibrium. Of a trajectory that leaves\n"
      "nothing free, or without a motion, all coordinates are free and no actuator exerts anything.\n\n"
      "Driven joints at constant speed excite vibrations: amplitudes of every order, linear and exact, and\n"
      "the force transmitted to the ground. --sweep adds the values at which stability changes and those\n"
      "at which an order is in resonance with a mode.\n\n"
      "Examples:\n"
      "  balance modes frame-on-mounts.yaml --trajectory run\n"
      "  balance modes frame-on-mounts.yaml:run --sweep A=1:100:200 -o sweep.h5\n"
      "  balance modes bicycle.yaml --sweep v=1:10:91");
  return {parser, [options] {
            split_trajectory_name(options->spec.spec, options->request.trajectory);
            return run(*options);
          }};
}

}  // namespace balance::app
