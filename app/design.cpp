#include "console.hpp"
#include "design_options.hpp"
#include "failure.hpp"
#include "signals.hpp"

#include "balance/base/error.hpp"
#include "balance/read/symbols.hpp"
#include "balance/study/start_pose.hpp"
#include "balance/write/balanced_spec.hpp"
#include "balance/write/design_hdf5.hpp"
#include "balance/write/design_json.hpp"
#include "balance/write/design_text.hpp"
#include "balance/write/names.hpp"

#include <limits>
#include <memory>
#include <stdexcept>

namespace balance::app {
namespace {

DesignReport design_or_throw(const DesignSpace& space, const DesignStudyOptions& options) {
  try {
    DesignReport report = design_study(space, options);
    const Conditions& conditions = report.outcome.conditions;
    if (report.outcome.status != DesignStatus::unsolved) return report;
    throw MechanismFailure(name_of(conditions.status),
                           report.outcome.reason.empty() ? conditions.reason : report.outcome.reason);
  } catch (const std::invalid_argument& error) {
    // The library was asked something that the spec should not have asked.
    throw SpecError(space.start.spec_file + ": design: " + error.what());
  }
}

/// The design as its own spec: how a reader of the file that -o writes would know its lengths.
std::vector<Symbol> symbols_of_design(const Study& study, const std::string& balanced, const Mechanism& mechanism,
                                      std::vector<std::string>& notes) {
  try {
    return list_symbols(read_spec(balanced, study.spec_file));
  } catch (const SpecError& error) {
    notes.push_back(std::string("the designed spec needs a change before it can be read: ") + error.what());
    return own_symbols(mechanism);
  }
}

ConditionsView view_conditions(const DesignCommandOptions& options, const DesignSpace& space,
                               const std::string& balanced, DesignReport& report) {
  const DesignOutcome& outcome = report.outcome;
  const Mechanism& mechanism = report.study_after.mechanism;
  ConditionsView view;
  view.title = space.start.mechanism.name;
  view.strategy = options.goal.strategy;
  view.conditions = outcome.conditions;
  view.numbers = report.numbers;
  const LooseSprings loose = loose_springs_of(view.conditions, mechanism);
  ConditionOptions condition_options;
  condition_options.loose_springs = loose;
  if (!space.start.trajectories.empty()) condition_options.about = space.start.trajectories.front().about;
  const auto symbols = symbols_of_design(space.start, balanced, mechanism, report.notes);
  view.names = name_coefficients(
      mechanism, view.conditions, symbols,
      make_derive(view.conditions.goals, is_modular(options.goal), condition_options, start_coordinates(space.start)));
  view.occurring = outcome.occurring;
  view.occurring.resize(static_cast<std::size_t>(view.conditions.matrix.rows()));
  judge(view, mechanism, loose);
  return view;
}

DesignView make_view(const DesignCommandOptions& options, const DesignStudyOptions& study_options,
                     const DesignSpace& space, const std::string& balanced, DesignReport report) {
  DesignView view;
  const auto& terms = study_options.minimize.empty() ? space.start.design.minimize : study_options.minimize;
  view.objective = objective_text(terms);
  view.objective_unit = objective_unit(terms, space.start.mechanism);
  view.conditions = view_conditions(options, space, balanced, report);
  const Eigen::Index rows = view.conditions.conditions.matrix.rows();
  view.residuals_before = report.outcome.before.size() == rows
                              ? report.outcome.before
                              : VectorX::Constant(rows, std::numeric_limits<double>::quiet_NaN());
  view.warnings = space.start.warnings;
  view.report = std::move(report);
  return view;
}

std::vector<std::string> write_files(const DesignCommandOptions& options, const DesignSpace& space,
                                     const std::string& balanced, const DesignView& view) {
  WriteOptions write;
  write.existing = options.force ? Existing::replace : Existing::keep;
  write.cancelled = [] { return pending_signal() != 0; };
  const DeferSignals deferred;
  std::vector<std::string> files;
  if (!options.output.empty()) {
    PendingFile file(options.output, write.existing);
    file.write(balanced);
    stop_if_cancelled(write);
    file.commit();
    files.push_back(options.output);
  }
  if (!options.h5.empty()) {
    write_design(options.h5, view, describe(options, space.start), write);
    files.push_back(options.h5);
  }
  return files;
}

ExitCode run(const DesignCommandOptions& options) {
  const DesignSpace space = read_space(options.spec);
  const DesignStudyOptions wanted = study_options(options, space.start);
  check_outputs(options);
  if (!options.quiet)
    for (const std::string& warning : space.start.warnings) tell("warning: " + warning);
  DesignReport report = design_or_throw(space, wanted);
  const bool balanced = report.outcome.status == DesignStatus::balanced;
  const std::string spec = balanced_spec(space.start, report.outcome.x);
  const DesignView view = make_view(options, wanted, space, spec, std::move(report));
  const std::vector<std::string> files = write_files(options, space, spec, view);
  if (options.spec.json) {
    print(design_json(view, files));
  } else if (!options.quiet) {
    std::string text = design_text(view);
    for (const std::string& file : files)
      text += (&file == &files.front() ? "\nwritten" : "written") + std::string(balanced ? ": " : ", not balanced: ") +
              file + "\n";
    print(text);
  }
  return balanced ? ExitCode::done : ExitCode::not_met;
}

}  // namespace

Command setup_design(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("design", "Find numbers that balance a mechanism");
  const auto options = std::make_shared<DesignCommandOptions>();
  add_design_options(*parser, *options);
  parser->footer(
      "Finds values for the spec's free numbers that meet all conditions of its goal, the best of them\n"
      "if something is to be minimized; otherwise the best compromise and the reason why there is no\n"
      "solution. Prints the numbers, the conditions, what they cost and what every trajectory gains.\n"
      "Exit code 0: balanced; 1: a compromise, or balancing is impossible; files are written all the\n"
      "same.\n\n"
      "Examples:\n"
      "  balance design 5r.yaml -o balanced.yaml\n"
      "  balance design 5r.yaml --goal static --minimize '{rms: torque, along: cycloid}' --h5 design.h5\n"
      "  balance design 5r.yaml --strategy modular --json");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
