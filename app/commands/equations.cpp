#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/reports/equations_sections.hpp"
#include "balance/interface/reports/formulas_sections.hpp"
#include "balance/interface/specification/read_options.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/conditions/spec_symbols.hpp"
#include "balance/synthesis/formulas/closure_elimination.hpp"
#include "balance/synthesis/formulas/equations_report.hpp"
#include "balance/synthesis/formulas/formula_sheet.hpp"
#include "balance/synthesis/formulas/program_code.hpp"
#include "balance/synthesis/formulas/symbolic_conditions.hpp"
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
#include <limits>
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

void write(const EquationsOptions& options, const Study& study, const formulas::EquationsAlongRun& along) {
  if (along.outcome.status != MotionStatus::done) throw MotionFailure(along.outcome);
  files::WriteOptions write;
  write.existing = options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
  write.compression = options.compress ? files::Compression::gzip : files::Compression::none;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  reports::write_equations(options.output, along, actuator_names(study.mechanism), describe(options, study), write);
}

ExitCode run_along(const EquationsOptions& options, const Study& study, const Trajectory& trajectory) {
  if (options.output.empty())
    throw UsageError(fmt::format("--at {} is a whole trajectory, which needs -o FILE; --at start and end are poses",
                                 trajectory.name));
  const RunResult run =
      call_or_throw_usage_error(options, study, [&] { return simulate(study.mechanism, trajectory); });
  if (run.outcome.status != MotionStatus::done) throw MotionFailure(run.outcome);
  write(options, study, call_or_throw_usage_error(options, study, [&] {
          return formulas::compute_equations_along(study.mechanism, run, options.independent);
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
                           options.goal});
  choose_sections(options);
  const DesignSpace space = read_space(options.spec);
  const Study& study = space.start;
  check_outputs(options, study);
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  if (const Trajectory* trajectory = trajectory_at(options, study)) return run_along(options, study, *trajectory);
  const reports::EquationsReportData view = make_equations_data(options, space);
  if (options.spec.json)
    print(equations_json(view, study.warnings));
  else if (options.latex)
    print_text(equations_latex(view));
  if (!options.output.empty()) write(options, study, as_one_sample(view.at));
  if (!options.spec.json && !options.latex) print_text(equations_text(view, choose_text_options(options.spec, study)));
  return ExitCode::done;
}

}  // namespace

Command setup_equations(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("equations", "Print a mechanism's equation of motion");
  const auto options = std::make_shared<EquationsOptions>();
  add_equations_options(*parser, *options);
  parser->footer(
      "Without --at, prints the equations of motion as formulas: --only inertia,velocity,gravity,\n"
      "closures,solved,conditions,regressor,natural,efforts,reduced selects sections, --code c prints\n"
      "a program, which closes the loops. Everything printed has been read back and compared with numerical "
      "results.\n\n"
      "--solve solves the conditions of --goal for parameters, symbols or paths of the spec, one after\n"
      "the other, and prints the equations with these numbers.\n\n"
      "With --at, prints the equation at a pose, as matrices in the independent coordinates: inertia\n"
      "M', velocity terms D'_krs and B', weight, springs and loads z'; the contributions to every\n"
      "torque; and the base parameters, on which the equation depends. In --speeds, a coordinate's\n"
      "name stands for its rate, tool.x y z for the tool's velocity along the world's axes, u v w along\n"
      "its body's; angle in the plane, rx ry rz or p q r in space for its angular velocity; SI.\n\n"
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
  add_choice_validator(
      parser
          .add_option("--coordinates", o.coordinates,
                      "what the program of a mechanism with loops takes: independent coordinates (default) or all")
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
  for (const char* name : {"--speeds", "--trajectory", "--output"}) parser.get_option(name)->needs(at);
}

}  // namespace

namespace {

bool is_blank(const std::string& text) { return text.find_first_not_of(" \t\r\n") == std::string::npos; }

void add_speed_options(CLI::App& parser, EquationsOptions& o) {
  const auto not_blank = [](const std::string& text) {
    return is_blank(text) ? "expected speeds, found an empty text" : "";
  };
  CLI::Option* speeds =
      parser
          .add_option("--speeds", o.speeds,
                      "also print the equation in these speeds: sums of rates of coordinates and of the tool, such as\n"
                      "\"v: tool.u, w: {A: 0.5, B: -0.5}\"")
          ->type_name("NAME: TERMS,...")
          ->check(not_blank);
  parser.add_option("--constraints", o.constraints, "speeds that are zero, as for rolling wheels: \"slip: tool.v\"")
      ->type_name("NAME: TERMS,...")
      ->check(not_blank)
      ->needs(speeds);
  for (const char* name : {"--latex", "--output"}) speeds->excludes(parser.get_option(name));
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
  model::SpeedChoice choice;
  if (!options.speeds.empty()) choice.speeds = specification::read_speeds(options.speeds, "--speeds", study);
  if (options.speeds.empty() && !options.latex && options.output.empty()) choice.speeds = study.speeds;
  if (!options.constraints.empty())
    choice.constrained = specification::read_speeds(options.constraints, "--constraints", study);
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

std::vector<formulas::SheetSectionKind> sections_of(const FormulaOptions& options) {
  const std::vector<std::string>& names = formulas::sheet_section_names();
  std::vector<formulas::SheetSectionKind> sections;
  for (const std::string& name : options.only) {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end())
      throw UsageError(fmt::format("--only without --at needs {}, not {}{}", fmt::join(names, ", "),
                                   quote_for_message(name), append_nearest_name(name, names)));
    sections.push_back(static_cast<formulas::SheetSectionKind>(at - names.begin()));
    using enum formulas::SheetSectionKind;
    if ((sections.back() == solutions || sections.back() == balanced) && options.solve.empty())
      throw UsageError(fmt::format("--only {} needs --solve NAMES", name));
  }
  return sections;
}

std::string title_of(const Study& study) {
  return study.mechanism.name.empty() ? study.spec_file : study.mechanism.name;
}

/// What is read to print formulas.
struct FormulaSource {
  DesignSpace space;
  study::SpecNumberTexts texts;
  std::optional<formulas::SolveRequest> solve;
};

FormulaSource read_source(const FormulaOptions& options, const std::string& text, const ReadOptions& read) {
  FormulaSource source;
  source.space = read_design_space(text, specification::display_name(options.spec.spec), read);
  Mechanism& mechanism = source.space.start.mechanism;
  mechanism = model::mechanism_in_interval(mechanism, {}, 0);  // symbols stand for all payloads
  source.texts = read_spec_number_texts(source.space, read);
  return source;
}

/// Reads the spec again, such that the numbers to solve for can have any value: parameters without their expressions,
/// numbers of the mechanism as inputs.
FormulaSource read_solvable_source(const FormulaOptions& options, const std::string& text,
                                   const FormulaSource& source) {
  formulas::SolveRequest request;
  try {
    request.unknowns = formulas::find_unknown_numbers(source.space.start.mechanism, source.texts, options.solve);
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--solve: ") + error.what());
  }
  ReadOptions read = read_options(options.spec);
  for (const formulas::UnknownNumber& unknown : request.unknowns) {
    if (unknown.parameter.empty()) read.inputs.insert(unknown.path);
    for (const study::NamedExpression& parameter : source.texts.recording->parameters)
      if (parameter.name == unknown.parameter && !parameter.is_plain)
        read.set.emplace_back(parameter.name, fmt::format("{:.17g}", parameter.value.value()));
  }
  for (std::string& path : formulas::list_inertial_paths(source.space.start.mechanism, source.texts))
    read.inputs.insert(std::move(path));
  FormulaSource solvable = read_source(options, text, read);
  const Study& study = solvable.space.start;
  const reports::BalanceRequest balance = make_balance_query(options.goal, study);
  request.goals = balance.goals;
  ConditionOptions condition_options;
  condition_options.seed = balance.seed.value_or(condition_options.seed);
  condition_options.excluded = balance.excluded;
  if (!study.trajectories.empty()) condition_options.about = study.trajectories.front().about;
  request.derive = reports::make_conditions_deriver(balance.goals, balance.is_modular, condition_options,
                                                    simulation::start_coordinates(study));
  if (balance.is_modular || !balance.excluded.empty() ||
      !formulas::has_symbolic_conditions(study.mechanism, balance.goals)) {
    reports::ConditionsReportData conditions = derive_conditions_or_throw(options.goal, solvable.space);
    request.conditions = std::move(conditions.conditions);
    request.names = std::move(conditions.names);
  }
  solvable.solve = std::move(request);
  return solvable;
}

/// The conditions of a mechanism with loops or constraints on speeds, as `balance conditions` derives them.
std::vector<formulas::GoalConditions> derive_goal_conditions(const FormulaOptions& options, const DesignSpace& space) {
  const auto sections = sections_of(options);
  if (std::find(sections.begin(), sections.end(), formulas::SheetSectionKind::conditions) == sections.end() ||
      formulas::is_open_chain(space.start.mechanism))
    return {};
  std::vector<formulas::GoalConditions> list;
  using enum GoalKind;
  for (const GoalKind kind : {statics, force, gyroscopic, decoupled}) {
    formulas::GoalConditions one{{kind, false}, {}, {}, ""};
    GoalOptions goal = options.goal;
    goal.goals = {study::goal_name(one.goal)};
    try {
      reports::ConditionsReportData view = derive_conditions_or_throw(goal, space);
      one.conditions = std::move(view.conditions);
      one.names = std::move(view.names);
    } catch (const MechanismFailure& failure) {
      one.reason = failure.what();
    }
    list.push_back(std::move(one));
  }
  return list;
}

formulas::FormulaSheet make_sheet(const FormulaOptions& options, const FormulaSource& source,
                                  std::vector<formulas::SheetSectionKind> sections) {
  const auto expressions =
      options.expand ? formulas::ParameterExpressions::inlined : formulas::ParameterExpressions::symbols;
  const Study& study = source.space.start;
  formulas::FormulaSheet sheet =
      formulas::make_sheet(study.mechanism, source.texts,
                           {std::move(sections), expressions, source.solve, options.independent,
                            derive_goal_conditions(options, source.space)});
  for (const study::TemporaryPayload& payload : study.temporary_payloads)
    sheet.notes.push_back(
        fmt::format("payload '{}' is not always there: without it, its mass and inertia are 0", payload.name));
  return sheet;
}

/// @throws UsageError for a name that no symbol has
std::vector<int> find_symbols(const formulas::Ring& ring, const std::vector<std::string>& names) {
  std::vector<int> found;
  std::vector<std::string> known;
  for (const formulas::Symbol& symbol : ring.symbols()) known.push_back(symbol.name);
  for (const std::string& name : names) {
    const auto at = std::find(known.begin(), known.end(), name);
    if (at == known.end())
      throw UsageError(fmt::format("--collect: {} is no symbol of these formulas{}", quote_for_message(name),
                                   append_nearest_name(name, known)));
    found.push_back(static_cast<int>(at - known.begin()));
  }
  return found;
}

void print_view(const FormulaOptions& options, const FormulaSource& source) {
  const Study& study = source.space.start;
  formulas::FormulaSheet sheet = make_sheet(options, source, sections_of(options));
  formulas::PrintOptions print_options;
  print_options.with_values = options.numbers;
  print_options.collected = find_symbols(*sheet.ring, options.collect);
  if (options.all) print_options.max_terms = std::numeric_limits<std::size_t>::max();
  reports::FormulasReportData view{title_of(study), &sheet, print_sheet(sheet, print_options), {}, study.warnings};
  const auto check = [&] {
    view.check = formulas::check_against_engine(sheet, texts_by_label(view.sections), study.mechanism,
                                                {.with_perturbed_parameters = !options.numbers});
  };
  check();
  if (!view.check.is_consistent && options.only.empty() && !sheet.pivots.empty()) {
    // the steps of an elimination can be checked at fewer poses than what they are made of
    using enum formulas::SheetSectionKind;
    const std::string reason = "solved and reduced are left out: " + view.check.reason;
    sheet = make_sheet(options, source, {inertia, velocity, gravity, closures});
    sheet.notes.push_back(reason);
    print_options.collected = find_symbols(*sheet.ring, options.collect);
    view.sections = print_sheet(sheet, print_options);
    check();
  }
  if (!view.check.is_consistent)
    throw MechanismFailure("no-formulas", fmt::format("no formulas: {} (checked at {} states: {:.0e})",
                                                      view.check.reason, view.check.states, view.check.error));
  if (options.latex) {
    print_options.style = formulas::PrintStyle::latex;
    view.sections = print_sheet(sheet, print_options);
  }
  if (options.spec.json)
    print(formulas_json(view));
  else
    print_text(options.latex ? formulas_latex(view) : formulas_text(view, text_width()));
}

}  // namespace

ExitCode print_formulas(const FormulaOptions& options) {
  sections_of(options);
  const std::string text = specification::read_text_file(options.spec.spec, "spec");
  FormulaSource source = read_source(options, text, read_options(options.spec));
  if (!options.solve.empty()) source = read_solvable_source(options, text, source);
  const Study& study = source.space.start;
  if (study.mechanism.coordinates.empty())
    throw MechanismFailure("mismatch", "the mechanism has no degrees of freedom: there is no equation of motion");
  for (const std::string& name : options.independent)
    if (const auto names = coordinate_names(study.mechanism);
        std::find(names.begin(), names.end(), name) == names.end())
      throw UsageError(fmt::format("--independent: there is no coordinate {}{}", quote_for_message(name),
                                   append_nearest_name(name, names)));
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  try {
    if (options.code.empty()) {
      print_view(options, source);
    } else {
      const auto language = options.code == "python" ? formulas::Language::python : formulas::Language::c;
      if (options.coordinates == "independent" && has_velocity_constraints(study.mechanism))
        throw formulas::FormulaError(
            "speeds are constrained, so rates of coordinates are not independent; --coordinates all prints a program "
            "of "
            "all coordinates");
      const auto coordinates =
          options.coordinates == "all" ? formulas::ProgramCoordinates::all : formulas::ProgramCoordinates::independent;
      print(formulas::generate_program(study.mechanism, source.texts, language, nullptr,
                                       {coordinates, options.independent, simulation::start_coordinates(study)}));
    }
  } catch (const formulas::IndependentCoordinatesError& error) {
    throw UsageError(std::string("--independent: ") + error.what());
  } catch (const formulas::FormulaError& error) {
    throw MechanismFailure("no-formulas", std::string("no formulas: ") + error.what());
  }
  return ExitCode::done;
}

}  // namespace balance::app
