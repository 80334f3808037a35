#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/interface/reports/check_sections.hpp"
#include "balance/synthesis/verification/formulation_check.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"

#include <memory>
#include <optional>
#include <stdexcept>

namespace balance::app {
namespace {

struct CheckOptions {
  SpecOptions spec;
  bool verify = false;
};

std::optional<verification::VerifyReport> verify_or_throw(const Study& study) {
  try {
    return verify_formulations(study);
  } catch (const std::invalid_argument& error) {
    // The options are valid, so the error is in the spec.
    throw SpecError({.place = {.file = study.spec_file}, .message = error.what()});
  }
}

CheckReport check_with_progress(const Study& study) {
  ProgressLine line(false);
  return check_mechanism(study, [&](double fraction) { line.draw_fraction("assembly modes", fraction); });
}

ExitCode run(const CheckOptions& check_options) {
  const SpecOptions& options = check_options.spec;
  const Study study = read_study(options);
  if (check_options.verify && study.mechanism.space == SpaceKind::spatial)
    throw UsageError(study.spec_file +
                     " is spatial: --verify compares two formulations, but spatial mechanisms have only one");
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  const CheckReport report = check_with_progress(study);
  const bool done = report.outcome.status == MotionStatus::done;
  // With --json a failure prints only the error document. As text, the report so far is printed first.
  std::optional<verification::VerifyReport> verified;
  if (check_options.verify && done) verified = verify_or_throw(study);
  if (options.json && done)
    print(files::format_json(
        reports::check_json(report, study.mechanism, study.warnings, verified ? &*verified : nullptr)));
  if (!options.json) {
    const files::TextOptions text = choose_text_options(options, study);
    print_text(reports::check_text(report, study.mechanism, text));
    if (verified) print_text("\n" + reports::verify_text(*verified, text));
  }
  if (!done) throw MotionFailure(report.outcome);
  if (!verified) return ExitCode::done;
  if (!verified->is_consistent) return ExitCode::not_met;
  if (verified->failed_outcome.status != MotionStatus::done) {
    print_message("error: " + verified->failed_outcome.reason);
    return ExitCode::mechanism;
  }
  return ExitCode::done;
}

}  // namespace

Command setup_check(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("check", "Validate a spec and describe its mechanism");
  const auto options = std::make_shared<CheckOptions>();
  add_spec_options(*parser, options->spec);
  parser->add_flag("--verify", options->verify,
                   "run all trajectories with both formulations; exit code 1 if they differ");
  add_units_option(*parser, options->spec.units);
  add_verbose_flag(*parser, options->spec.verbose);
  parser->footer(
      "Prints degrees of freedom, loops, redundant constraints, passive freedoms, mass, centre of\n"
      "mass and the assembly modes found at the start pose, each with the line that selects it. Of a\n"
      "body whose only joint is a revolute one with the ground, it says the static and couple unbalance,\n"
      "the unbalances in two correction planes and, for trajectories that turn it at constant speed, the\n"
      "balance quality grade of ISO 21940-11.\n\n"
      "--verify computes every trajectory and the force-balance conditions of a planar mechanism a second\n"
      "time, by an independent method in natural coordinates. Relative differences up to 1e-9 are\n"
      "round-off.\n\n"
      "Examples:\n"
      "  balance check 3rrr.yaml\n"
      "  balance check 3rrr.yaml --verify\n"
      "  balance check 3rrr.yaml --set l=0.2 --json");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
