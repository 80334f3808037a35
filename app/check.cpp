#include "command.hpp"
#include "console.hpp"
#include "failure.hpp"

#include "balance/study/check.hpp"
#include "balance/write/json.hpp"
#include "balance/write/text.hpp"

#include <memory>

namespace balance::app {
namespace {

ExitCode run(const SpecOptions& options) {
  const Study study = read_study(options);
  for (const std::string& warning : study.warnings) tell("warning: " + warning);
  const CheckReport report = check(study);
  const bool done = report.outcome.status == MotionStatus::done;
  // In JSON a failure is one document, the error's; as text what is known is worth reading first.
  if (options.json && done) print(check_json(report, study.mechanism, study.warnings));
  if (!options.json) print(check_text(report, study.mechanism));
  if (!done) throw MotionFailure(report.outcome);
  return ExitCode::done;
}

}  // namespace

Command setup_check(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("check", "Validate a spec and say what the mechanism is");
  const auto options = std::make_shared<SpecOptions>();
  add_spec_options(*parser, *options);
  parser->footer(
      "Prints degrees of freedom, loops, redundant constraints, idle freedoms, mass, centre of\n"
      "mass and the assembly modes found at the start pose, each with the line that picks it.\n\n"
      "Examples:\n"
      "  balance check 3rrr.yaml\n"
      "  balance check 3rrr.yaml --set l=0.2 --json");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
