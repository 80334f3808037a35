#include "console.hpp"
#include "equations_options.hpp"
#include "failure.hpp"
#include "formulas.hpp"
#include "signals.hpp"

#include "balance/base/error.hpp"
#include "balance/base/version.hpp"
#include "balance/conditions/symbols.hpp"
#include "balance/present/equations_view.hpp"
#include "balance/simulation/simulate.hpp"
#include "balance/study/passing_payloads.hpp"
#include "balance/write/json_parts.hpp"
#include "balance/write/run_description.hpp"

#include <fmt/format.h>

#include <memory>
#include <stdexcept>

namespace balance::app {
namespace {

std::vector<std::string> coordinate_names(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const Coordinate& coordinate : mechanism.coordinates) names.push_back(coordinate.name);
  return names;
}

std::vector<std::string> actuator_names(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const int a : mechanism.actuators) names.push_back(mechanism.coordinates[static_cast<std::size_t>(a)].name);
  return names;
}

template <class Question>
auto call_or_throw_usage_error(const EquationsOptions& options, const Study& study, const Question& question) {
  const bool by_options = !options.rates.empty() || !options.accelerations.empty() || !options.independent.empty() ||
                          !options.speeds.empty();
  return call_library(by_options, study, question);
}

Provenance describe(const EquationsOptions& options, const Study& study) {
  Provenance description;
  description.title = study.mechanism.name;
  description.version = version();
  description.spec_text = study.spec_text;
  description.command_line =
      fmt::format("balance equations {} --at {}", quote_for_shell(study.spec_file), quote_for_shell(options.at));
  for (const std::string& set : options.spec.overrides) description.command_line += " --set " + quote_for_shell(set);
  return description;
}

void write(const EquationsOptions& options, const Study& study, const EquationsAlongRun& along) {
  if (along.outcome.status != MotionStatus::done) throw MotionFailure(along.outcome);
  WriteOptions write;
  write.existing = options.force ? OverwritePolicy::replace : OverwritePolicy::forbid;
  write.compression = options.compress ? Compression::gzip : Compression::none;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  write_equations(options.output, along, actuator_names(study.mechanism), describe(options, study), write);
}

ExitCode run_along(const EquationsOptions& options, const Study& study, const Trajectory& trajectory) {
  reject_temporary_payloads(study, "equations of motion along a trajectory");
  if (options.output.empty())
    throw UsageError(fmt::format("--at {} is a whole trajectory, which needs -o FILE; --at start and end are poses",
                                 trajectory.name));
  const RunResult run =
      call_or_throw_usage_error(options, study, [&] { return simulate(study.mechanism, trajectory); });
  if (run.outcome.status != MotionStatus::done) throw MotionFailure(run.outcome);
  write(options, study, call_or_throw_usage_error(options, study, [&] {
          return compute_equations_along(study.mechanism, run, options.independent);
        }));
  if (options.spec.json)
    print(format_json({{"mechanism", study.mechanism.name},
                       {"trajectory", trajectory.name},
                       {"samples", run.time.size()},
                       {"warnings", study.warnings},
                       {"files", {options.output}}}));
  else
    print_status({options.output}, format_written_message(options.output));
  return ExitCode::done;
}

EquationsReportData make_equations_data(const EquationsOptions& options, const DesignSpace& space) {
  const Study& study = space.start;
  const EquationsQuery query = make_query(options, study);
  std::vector<GeometricSymbol> symbols;
  if (query.sections.count(EquationSection::parameters) > 0) symbols = list_symbols(space);
  EquationsReport report =
      call_or_throw_usage_error(options, study, [&] { return compute_equations_at(study.mechanism, query, symbols); });
  if (report.outcome.status != MotionStatus::done) throw MotionFailure(report.outcome);
  return {study.mechanism.name, coordinate_names(study.mechanism), std::move(report.at), choose_sections(options)};
}

ExitCode run(const EquationsOptions& options) {
  if (options.at.empty())
    return print_formulas(
        {options.spec, options.only, options.code, options.latex, options.numbers, options.expand, options.all});
  choose_sections(options);
  const DesignSpace space = read_space(options.spec);
  const Study& study = space.start;
  check_outputs(options, study);
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  if (const Trajectory* trajectory = trajectory_at(options, study)) return run_along(options, study, *trajectory);
  const EquationsReportData view = make_equations_data(options, space);
  if (options.spec.json)
    print(equations_json(view, study.warnings));
  else if (options.latex)
    print_text(equations_latex(view));
  if (!options.output.empty()) write(options, study, as_one_sample(view.at));
  if (!options.spec.json && !options.latex) print_text(equations_text(view));
  return ExitCode::done;
}

}  // namespace

Command setup_equations(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("equations", "Print a mechanism's equation of motion");
  const auto options = std::make_shared<EquationsOptions>();
  add_equations_options(*parser, *options);
  parser->footer(
      "Without --at, prints the equations of motion as formulas: --only inertia,velocity,gravity,\n"
      "closures,solved,conditions,regressor,natural picks some, --code c makes a program of\n"
      "them. What is printed has been read back and compared with the engine.\n\n"
      "With --at, prints the equation where the mechanism has a pose, as matrices in its independent\n"
      "coordinates: inertia M', velocity terms D'_krs and B', weight, springs and loads z'; what\n"
      "every torque adds up from; and the base parameters: the combinations of inertial parameters\n"
      "that the equation depends on.\n"
      "--speeds prints the equation in speeds of your choice, and --constraints what keeps it from\n"
      "slipping: sums of rates that are zero. A coordinate's name stands for its rate; the tool has\n"
      "x y z along the world's and u v w along its body's axes, and turns by angle in the plane, by\n"
      "rx ry rz or p q r in space. Factors are in SI units.\n"
      "Files hold the matrices at a pose or, where --at names a trajectory, at all its samples.\n\n"
      "Examples:\n"
      "  balance equations spatial-rrr.yaml --only inertia,conditions\n"
      "  balance equations 5r.yaml --code c\n"
      "  balance equations planar-rrr.yaml --at start\n"
      "  balance equations 5r.yaml --at \"tool: [0.1, 0.3]\" --rates A1=2,A2=-1\n"
      "  balance equations rr.yaml --at start --speeds \"vx: tool.x, vy: tool.y\"\n"
      "  balance equations 3rrr.yaml --at end --only natural --latex\n"
      "  balance equations 3rrr.yaml --at cycloid -o equations.h5");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
