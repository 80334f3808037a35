#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/latex_lines.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/reports/equations_sections.hpp"
#include "balance/interface/reports/formula_request.hpp"
#include "balance/interface/specification/read_options.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/conditions/spec_symbols.hpp"
#include "balance/synthesis/formulas/equations_report.hpp"
#include "balance_options.hpp"
#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/help.hpp"
#include "cli/signals.hpp"
#include "cli/validators.hpp"
#include "state_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace balance::app {

// Options of `balance equations` and their translation into queries of the study.

/// `at` may also be the name of a trajectory, or empty: closed-form formulas.
struct EquationsOptions : StateOptions {
  SpecOptions spec;
  std::string speeds, constraints;  ///< `v: tool.u, w: {A: 0.5}`; empty: none
  std::vector<std::string> only;
  std::string output;
  bool latex = false, force = false, compress = false;

  // of formulas only
  std::string code;         ///< `c` or `python`; empty: none
  std::string coordinates;  ///< of a program of a mechanism with loops: `independent` or `all`; empty: the first
  bool expand = false, numbers = false, all = false;
  std::vector<std::string> collect;  ///< symbols by whose powers sums are grouped
  std::vector<std::string> solve;    ///< numbers for which the conditions of `goal` are solved
  GoalOptions goal;
};

void add_equations_options(CLI::App& parser, EquationsOptions& options);

/// The sections named by --only. Without it, those that fit a page of text, or all with --json.
/// @throws UsageError
std::set<formulas::EquationSection> choose_sections(const EquationsOptions& options);

/// The trajectory whose name is given by --at; nullptr if --at is a pose.
const Trajectory* trajectory_at(const EquationsOptions& options, const Study& study);

/// Assembles the mechanism in the pose given by --at and sets the requested rates.
/// @throws UsageError, SpecError; MotionFailure if the mechanism cannot reach the pose
formulas::EquationsQuery make_query(const EquationsOptions& options, const Study& study);

/// Checks before the computation that the outputs can be written. @throws UsageError, SystemError
void check_outputs(const EquationsOptions& options, const Study& study);

/// Options of `balance equations` without a pose: closed-form formulas.
struct FormulaOptions {
  SpecOptions spec;
  std::vector<std::string> only;
  std::string code;  ///< `c` or `python`; empty: formulas
  std::string coordinates;
  std::vector<std::string> independent;
  bool latex = false, numbers = false, expand = false, all = false;
  std::vector<std::string> collect;
  std::vector<std::string> solve;
  GoalOptions goal;
  std::string speeds;  ///< empty: the spec's
};

/// @throws UsageError for unknown sections
ExitCode print_formulas(const FormulaOptions& options);

namespace {

std::vector<std::string> coordinate_names(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const Coordinate& coordinate : mechanism.coordinates) names.push_back(coordinate.name);
  return names;
}

/// Per coordinate: whether it is a length.
std::vector<bool> coordinate_lengths(const Mechanism& mechanism) {
  std::vector<bool> lengths;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    lengths.push_back(is_length_coordinate(mechanism, static_cast<int>(c)));
  return lengths;
}

std::vector<std::string> actuator_names(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (const int a : mechanism.actuators) names.push_back(mechanism.coordinates[static_cast<std::size_t>(a)].name);
  return names;
}

template <class Query>
auto call_or_throw_usage_error(const EquationsOptions& options, const Study& study, const Query& query) {
  const bool by_options = !options.rates.empty() || !options.accelerations.empty() || !options.independent.empty() ||
                          !options.speeds.empty();
  return call_library(by_options, study, query);
}

files::Provenance describe(const EquationsOptions& options, const Study& study) {
  std::vector<std::string> words = {"balance", "equations", study.spec_file, "--at", options.at};
  files::append_overrides(words, study);
  return files::make_provenance(study, files::join_command(std::move(words)));
}

void write(const EquationsOptions& options, const Study& study, const Mechanism& mechanism,
           const formulas::EquationsAlongRun& along) {
  if (along.outcome.status != MotionStatus::done) throw MotionFailure(along.outcome);
  files::WriteOptions write;
  write.existing = options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
  write.compression = options.compress ? files::Compression::gzip : files::Compression::none;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  reports::write_equations(options.output, along, actuator_names(mechanism), describe(options, study), write);
}

ExitCode run_along(const EquationsOptions& options, const Study& study, const Trajectory& trajectory) {
  if (options.output.empty())
    throw UsageError(fmt::format("--at {} is a whole trajectory, which needs -o FILE; --at start and end are poses",
                                 trajectory.name));
  const RunResult run =
      call_or_throw_usage_error(options, study, [&] { return simulate(study.mechanism, trajectory); });
  if (run.outcome.status != MotionStatus::done) throw MotionFailure(run.outcome, study, trajectory.name);
  const Mechanism mechanism = mechanism_along(study, trajectory.name);
  write(options, study, mechanism, call_or_throw_usage_error(options, study, [&] {
          return formulas::compute_equations_along(mechanism, run, options.independent);
        }));
  if (options.spec.json)
    print(files::format_json({{"mechanism", study.mechanism.name},
                              {"trajectory", trajectory.name},
                              {"samples", run.time.size()},
                              {"warnings", study.warnings},
                              {"files", {options.output}}}));
  else
    print_status({options.output}, format_written_message(options.output));
  return ExitCode::done;
}

reports::EquationsReportData make_equations_data(const EquationsOptions& options, const DesignSpace& space) {
  const Study& study = space.start;
  const formulas::EquationsQuery query = make_query(options, study);
  std::vector<conditions::GeometricSymbol> symbols;
  if (query.sections.count(formulas::EquationSection::parameters) > 0) symbols = conditions::list_symbols(space);
  formulas::EquationsReport report =
      call_or_throw_usage_error(options, study, [&] { return compute_equations_at(study.mechanism, query, symbols); });
  if (report.outcome.status != MotionStatus::done) throw MotionFailure(report.outcome);
  return {study.mechanism.name, coordinate_names(study.mechanism), std::move(report.at), choose_sections(options),
          coordinate_lengths(study.mechanism)};
}

ExitCode run(const EquationsOptions& options) {
  if (options.at.empty())
    return print_formulas({options.spec, options.only, options.code, options.coordinates, options.independent,
                           options.latex, options.numbers, options.expand, options.all, options.collect, options.solve,
                           options.goal, options.speeds});
  choose_sections(options);
  if (options.latex && !options.speeds.empty()) throw UsageError("--speeds and --latex cannot be combined with --at");
  const DesignSpace space = read_space(options.spec);
  const Study& study = space.start;
  check_outputs(options, study);
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  if (const Trajectory* trajectory = trajectory_at(options, study)) return run_along(options, study, *trajectory);
  const reports::EquationsReportData view = make_equations_data(options, space);
  if (options.spec.json)
    print(equations_json(view, study.warnings));
  else if (options.latex)
    print_text(with_page_breaks(equations_latex(view)));
  if (!options.output.empty()) write(options, study, study.mechanism, as_one_sample(view.at));
  if (!options.spec.json && !options.latex) print_text(equations_text(view, choose_text_options(options.spec, study)));
  return ExitCode::done;
}

}  // namespace

Command setup_equations(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("equations", "Print a mechanism's equation of motion");
  const auto options = std::make_shared<EquationsOptions>();
  add_equations_options(*parser, *options);
  parser->footer(
      "Without --at, prints the equations of motion as formulas: --only inertia, velocity, gravity,\n"
      "closures, solved, conditions, regressor, natural, efforts, reduced, speeds selects sections, --code c\n"
      "prints a program, which closes the loops. All of it has been read back and compared with numbers.\n\n"
      "--solve solves the conditions of --goal for parameters, symbols or paths of the spec, one after\n"
      "the other, and prints the equations with these numbers.\n\n"
      "With --at, prints the equation at a pose, as matrices: inertia M', velocity terms D'_krs and B',\n"
      "weight, springs and loads z'; the parts of every torque; and the base parameters. In --speeds, a\n"
      "coordinate's name stands for its rate, tool.x y z for the tool's velocity along the world's axes,\n"
      "u v w along its body's; angle in the plane, rx ry rz or p q r in space for its angular velocity.\n\n"
      "Examples:\n"
      "  balance equations spatial-rrr.yaml --solve lg2,Jy2,Jy3,beta --goal decoupled\n"
      "  balance equations 5r.yaml --at \"tool: [0.1, 0.3]\" --rates A1=2,A2=-1\n"
      "  balance equations rr.yaml --at start --speeds \"vx: tool.x, vy: tool.y\"\n"
      "  balance equations 3rrr.yaml --at cycloid -o equations.h5");
  return {parser, [options] { return run(*options); }};
}

namespace {

/// Section names of poses and of formulas, without duplicates.
std::vector<std::string> all_section_names() {
  std::vector<std::string> names = formulas::equation_section_names();
  for (const std::string& name : formulas::sheet_section_names())
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  return names;
}

/// Adds the options that only formulas have, and makes the pose options above require --at.
void add_formula_options(CLI::App& parser, EquationsOptions& o) {
  CLI::Option* at = parser.get_option("--at");
  add_choice_validator(parser.add_option("--code", o.code, "print the torques as a program in c or python")
                           ->type_name("LANGUAGE")
                           ->excludes(at)
                           ->excludes(parser.get_option("--json"))
                           ->excludes(parser.get_option("--latex")),
                       {"c", "python"});
  parser.get_option("--independent")->remove_needs(at);
  add_choice_validator(parser.add_option("--coordinates", o.coordinates, "with loops: independent (default) or all")
                           ->type_name("WHICH")
                           ->needs(parser.get_option("--code")),
                       {"independent", "all"});
  parser.add_flag("--expand", o.expand, "substitute the expressions of parameters")->excludes(at);
  CLI::Option* collect = parser.add_option("--collect", o.collect, "group sums by powers of these symbols");
  collect->type_name("NAMES")->delimiter(',')->allow_extra_args(false)->excludes(at);
  collect->excludes(parser.get_option("--code"));
  parser.add_flag("--numbers", o.numbers, "print numbers in place of symbols")->excludes(at);
  parser.add_flag("--all", o.all, "print formulas of any length")->excludes(at);
  CLI::Option* solve = parser.add_option("--solve", o.solve, "solve the balancing conditions for these numbers");
  solve->type_name("NAMES")->delimiter(',')->allow_extra_args(false)->excludes(at);
  solve->excludes(parser.get_option("--code"));
  suggest_words(parser.add_option("-g,--goal", o.goal.goals, "the goal of --solve (default: the spec's)")
                    ->type_name("GOAL")
                    ->allow_extra_args(false)
                    ->needs(solve),
                study::goal_names());
  parser.add_option("--strategy", o.goal.strategy, "of the conditions: complete (default) or modular")
      ->type_name("NAME")
      ->needs(solve);
  parser.add_option("--without", o.goal.without, "what the goal ignores: friction, loads, ...")
      ->type_name("NAMES")
      ->allow_extra_args(false)
      ->needs(solve);
  for (const char* name : {"--constraints", "--trajectory", "--output"}) parser.get_option(name)->needs(at);
  parser.get_option("--speeds")->excludes(solve)->excludes(parser.get_option("--code"));
}

}  // namespace

namespace {

void add_speed_options(CLI::App& parser, EquationsOptions& o) {
  CLI::Option* speeds =
      parser
          .add_option(
              "--speeds", o.speeds,
              "also print the equation in these speeds: sums of rates of coordinates, of the tool and of com, such as\n"
              "\"v: tool.u, w: {A: 0.5, B: -0.5}\"")
          ->type_name("NAME: TERMS,...")
          ->check(not_blank_validator("speeds"));
  parser.add_option("--constraints", o.constraints, "speeds that are zero, as for rolling wheels: \"slip: tool.v\"")
      ->type_name("NAME: TERMS,...")
      ->check(not_blank_validator("speeds"))
      ->needs(speeds);
  speeds->excludes(parser.get_option("--output"));
}

}  // namespace

void add_equations_options(CLI::App& parser, EquationsOptions& o) {
  add_spec_options(parser, o.spec);
  add_units_option(parser, o.spec.units);
  add_state_options(parser, o,
                    "a pose (A1=0.3,A2=0.5 or tool: [0.1, 0.2], in the spec's units), start, end or a trajectory");
  parser.add_option("-t,--trajectory", o.trajectory, "trajectory of start and end (default: the first)")
      ->type_name("NAME");
  suggest_words(parser.add_option("--only", o.only, "sections to print, comma-separated")
                    ->type_name("NAMES")
                    ->delimiter(',')
                    ->allow_extra_args(false),
                all_section_names());
  CLI::Option* latex = parser.add_flag("--latex", o.latex, "print only LaTeX (amsmath)");
  latex->excludes(parser.get_option("--json"));
  CLI::Option* output = parser.add_option("-o,--output", o.output, "write the matrices to this HDF5 file");
  output->type_name("FILE");
  parser.add_flag("--force", o.force, "overwrite an existing file");
  parser.add_flag("--compress", o.compress, "compress the HDF5 file (slow)")->needs(output);
  add_speed_options(parser, o);
  add_formula_options(parser, o);
}

std::set<formulas::EquationSection> choose_sections(const EquationsOptions& options) {
  using enum formulas::EquationSection;
  const std::vector<std::string>& names = formulas::equation_section_names();
  std::set<formulas::EquationSection> sections;
  for (const std::string& name : options.only) {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end())
      throw UsageError(fmt::format("--only needs {}, not {}{}", fmt::join(names, ", "), quote_for_message(name),
                                   append_nearest_name(name, names)));
    sections.insert(static_cast<formulas::EquationSection>(at - names.begin()));
  }
  if (!sections.empty()) return sections;
  sections = {inertia, velocity, gravity, torques, parameters};
  if (options.spec.json) sections.insert({redundant, natural, regressor});
  return sections;
}

const Trajectory* trajectory_at(const EquationsOptions& options, const Study& study) {
  return options.at == "start" || options.at == "end" ? nullptr : study::find_by_name(study.trajectories, options.at);
}

namespace {

model::SpeedChoice read_choice(const EquationsOptions& options, const Study& study) {
  using specification::SpeedUse;
  model::SpeedChoice choice;
  if (!options.speeds.empty())
    choice.speeds = specification::read_speeds(options.speeds, "--speeds", SpeedUse::quasi_velocity, study);
  if (options.speeds.empty() && !options.latex && options.output.empty()) choice.speeds = study.speeds;
  if (!options.constraints.empty())
    choice.constrained = specification::read_speeds(options.constraints, "--constraints", SpeedUse::constraint, study);
  for (const model::GeneralisedSpeed& speed : choice.speeds)
    for (const model::GeneralisedSpeed& zero : choice.constrained)
      if (speed.name == zero.name)
        throw UsageError(
            fmt::format("--constraints: the name {} is already used by --speeds", quote_for_message(zero.name)));
  return choice;
}

}  // namespace

formulas::EquationsQuery make_query(const EquationsOptions& options, const Study& study) {
  formulas::EquationsQuery query;
  query.speeds = read_choice(options, study);
  dynamics::SingleState state = read_state(options, study);
  query.configuration = std::move(state.configuration);
  query.rates = std::move(state.rates);
  query.accelerations = std::move(state.accelerations);
  query.time = state.time;
  query.independent = options.independent;
  query.sections = choose_sections(options);
  if (!options.output.empty()) query.sections.insert(formulas::EquationSection::redundant);
  return query;
}

void check_outputs(const EquationsOptions& options, const Study& study) {
  check_standard_output({options.output}, options.spec.json || options.latex,
                        options.output == files::standard_output_path);
  check_output(options.output, "the result", FileFormat::hdf5, list_input_files(study), options.force);
}

namespace {

reports::FormulaRequest make_formula_request(const FormulaOptions& options) {
  reports::FormulaRequest request;
  request.only = options.only;
  request.expand = options.expand;
  request.with_values = options.numbers;
  request.all = options.all;
  request.latex = options.latex;
  request.independent = options.independent;
  request.solve = options.solve;
  request.collect = options.collect;
  request.speeds = options.speeds;
  request.balance = [goal = options.goal](const Study& study) { return make_balance_query(goal, study); };
  return request;
}

}  // namespace

ExitCode print_formulas(const FormulaOptions& options) {
  const std::string text = specification::read_text_file(options.spec.spec, "spec");
  const std::string file = specification::display_name(options.spec.spec);
  const reports::FormulaRequest request = make_formula_request(options);
  const auto announce = [](const std::vector<std::string>& warnings, const reports::RequestFailure& refusal) {
    for (const std::string& warning : warnings) print_message("warning: " + warning);
    if (refusal) throw MechanismFailure(refusal.status, refusal.reason);
  };
  try {
    if (!options.code.empty()) {
      using enum formulas::ProgramCoordinates;
      const auto language = options.code == "python" ? formulas::Language::python : formulas::Language::c;
      const reports::GeneratedProgram program = generate_program_of(
          request, language, options.coordinates == "all" ? all : independent, text, file, read_options(options.spec));
      announce(program.warnings, program.refusal);
      print(program.code);
      return ExitCode::done;
    }
    const reports::DerivedFormulas found = derive_formulas(request, text, file, read_options(options.spec));
    announce(found.view.warnings, found.refusal);
    if (options.spec.json)
      print(formulas_json(found.view));
    else
      print_text(options.latex ? with_page_breaks(formulas_latex(found.latex))
                               : formulas_text(found.view, text_width()));
  } catch (const reports::FormulaRequestError& error) {
    throw UsageError(error.what());
  }
  return ExitCode::done;
}

}  // namespace balance::app
