#include "balance_options.hpp"
#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/validators.hpp"

#include "balance/foundation/base/latex_lines.hpp"
#include "balance/interface/reports/conditions_sections.hpp"
#include "balance/interface/specification/read_options.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace balance::app {
namespace {

struct ConditionsOptions {
  SpecOptions spec;
  GoalOptions goal;
  bool latex = false;
  bool numbers = false;
  std::string speeds;  ///< as of `balance equations`; empty: none
};

void add_options(CLI::App& parser, ConditionsOptions& o) {
  add_spec_options(parser, o.spec);
  add_goal_options(parser, o.goal);
  CLI::Option* latex = parser.add_flag("--latex", o.latex, "print only LaTeX (amsmath)");
  latex->excludes(parser.get_option("--json"));
  add_units_option(parser, o.spec.units);
  parser.add_flag("--numbers", o.numbers, "print coefficients as numbers instead of in terms of lengths");
  parser
      .add_option("--speeds", o.speeds,
                  "state velocity terms and inertia in the derivatives of these speeds, as in balance equations:\n"
                  "\"vx: tool.x, vy: tool.y\"")
      ->type_name("NAME: TERMS,...")
      ->check(not_blank_validator("speeds"));
}

ExitCode run(const ConditionsOptions& options) {
  const DesignSpace space = read_space(options.spec);
  std::vector<model::GeneralisedSpeed> speeds;
  if (!options.speeds.empty()) {
    if (is_modular(options.goal)) throw UsageError("--speeds cannot be combined with --strategy modular");
    speeds =
        specification::read_speeds(options.speeds, "--speeds", specification::SpeedUse::quasi_velocity, space.start);
  }
  const reports::ConditionsReportData view =
      derive_conditions_or_throw(options.goal, space, !options.numbers, std::move(speeds));
  for (const std::string& warning : space.start.warnings) print_message("warning: " + warning);
  if (options.spec.json)
    print(files::format_json(conditions_json(view, space.start.warnings)));
  else
    print_text(options.latex ? with_page_breaks(conditions_latex(view.conditions, view.names))
                             : conditions_text(view, choose_text_options(options.spec, space.start)));
  return view.unbalanced_remainder.empty() ? ExitCode::done : ExitCode::not_met;
}

}  // namespace

Command setup_conditions(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("conditions", "Derive the complete balancing conditions");
  const auto options = std::make_shared<ConditionsOptions>();
  add_options(*parser, *options);
  parser->footer(
      "Prints the linear conditions on masses, centres of mass, inertias and stiffnesses that are\n"
      "necessary and sufficient for the goal, which of them are met and which free numbers of the\n"
      "spec each of them depends on. The default goal is the spec's `design: goal`.\n"
      "Goals of force and moment may name a component, coordinates at constant speed and a point of\n"
      "the ground, in this order: constant-speed-moment[x] of A and B about ground.M.\n"
      "Inertial parameters are about the origin of the body's frame, those of discs about their\n"
      "centre of mass. Loads are known terms on the right-hand side. What masses and springs cannot\n"
      "balance (friction, loads that vary or do not act like weight) is listed with the largest\n"
      "effort that it leaves to the actuators, and the exit code is 1 unless --without excludes it.\n"
      "Exit code 4: the loops cannot be closed, the number of conditions cannot be determined, or\n"
      "the goal needs actuators or a tool that the mechanism does not have.\n\n"
      "Examples:\n"
      "  balance conditions 5r.yaml --goal static\n"
      "  balance conditions 3rrr.yaml --goal force --goal gyroscopic --json\n"
      "  balance conditions rr.yaml --goal decoupled --latex\n"
      "  balance conditions rotor.yaml --goal \"constant-speed-moment[x]\"\n"
      "  balance conditions arm.yaml --goal gyroscopic --without friction\n"
      "  balance conditions rr.yaml --goal decoupled --speeds \"vx: tool.x, vy: tool.y\"");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
