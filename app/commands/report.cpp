#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/base/version.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/reports/check_sections.hpp"
#include "balance/interface/reports/conditions_sections.hpp"
#include "balance/interface/reports/design_sections.hpp"
#include "balance/interface/reports/front_sections.hpp"
#include "balance/interface/reports/html_report.hpp"
#include "balance/interface/reports/html_report_data.hpp"
#include "balance/interface/reports/modes_request.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/motion/control/closed_loop_run.hpp"
#include "balance/motion/simulation/prediction.hpp"
#include "balance/motion/vibration/mode_shape_run.hpp"
#include "balance/synthesis/design/catalogue_search.hpp"
#include "balance/synthesis/design/status_names.hpp"
#include "balance/synthesis/tolerance/robust_figure.hpp"
#include "balance/synthesis/tolerance/tolerance_analysis.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"
#include "balance_options.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/signals.hpp"
#include "cli/validators.hpp"
#include "design_options.hpp"
#include "run_operands.hpp"
#include "run_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::app {

using reports::HtmlReport;

/// Options of `balance report`.
struct ReportOptions {
  SpecOptions spec;
  GoalOptions goal;
  std::vector<std::string> trajectories;  ///< names; empty: all trajectories of the spec
  std::string controller;                 ///< used in every run; empty: none
  std::optional<long> samples;            ///< of every trajectory; default: as in the spec
  double seconds = 0;                     ///< of computing for the search of a design; 0: as in the spec
  std::string output;                     ///< empty: the spec's name with .html, in the current folder
  bool force = false;
  bool quiet = false;
};

void add_report_options(CLI::App& parser, ReportOptions& options);

/// The chosen trajectories in the order of the spec. By default all: those listed in the spec, or else the built-in
/// ones.
/// @throws UsageError for an unknown name
std::vector<std::string> choose_trajectories(const ReportOptions& options, const Study& study);

/// The output file of the page. @throws UsageError for a spec from standard input without --output, or for conflicting
/// uses of standard output
std::string choose_output(const ReportOptions& options);

/// Command line that reproduces the page, without the folder of the spec.
std::string command_line(const ReportOptions& options);

namespace {

/// Runs the trajectory of this name. If it cannot be run, the outcome of the result says why, and the page shows it.
RunResult run_named(const Study& study, const std::string& name, const ReportOptions& options) {
  const Trajectory* found = study::find_by_name(study.trajectories, name);
  RunResult result;
  if (found == nullptr) {
    result.outcome = {MotionStatus::mismatch, 0, "the designed spec has no such trajectory", {}};
    return result;
  }
  Trajectory trajectory = *found;
  if (options.samples) trajectory.samples = *options.samples;
  try {
    result = options.controller.empty()
                 ? simulate(study, trajectory)
                 : simulate_closed_loop(study.mechanism, trajectory, choose_controller(study, options.controller));
  } catch (const std::invalid_argument& error) {
    result.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
  }
  return result;
}

bool is_done(const std::optional<RunResult>& result) { return result && result->outcome.status == MotionStatus::done; }

reports::ReportedTrajectory describe(const Study& study, const std::string& name) {
  reports::ReportedTrajectory reported;
  reported.name = name;
  if (const Trajectory* trajectory = study::find_by_name(study.trajectories, name)) {
    reported.law = law_name(*trajectory);
    reported.drive = drive_name(*trajectory);
  }
  return reported;
}

/// Compares a run with a simulation of its spec. The duration or moment reference point of a stored run may differ from
/// the spec.
bool is_same_run(const RunResult& a, const RunResult& b) {
  const auto is_close = [](const auto& one, const auto& other) {
    return one.size() == other.size() && (one - other).norm() <= 1e-6 * (1 + one.norm());
  };
  return is_close(a.time, b.time) && is_close(a.shaking_moment, b.shaking_moment);
}

/// Deviation of a run along a trajectory due to tolerances. std::nullopt without tolerances or if it cannot be
/// computed; in the latter case the notes of the page give the reason.
/// @param space whose start is the mechanism of the run
std::optional<RunResult> deviation_of(const DesignSpace& space, const RunResult& run, const std::string& name,
                                      HtmlReport& page) {
  if (space.start.tolerances.empty() || run.outcome.status != MotionStatus::done || !page.controller.empty()) return {};
  for (Trajectory trajectory : space.start.trajectories) {
    if (trajectory.name != name || is_mechanism_dependent(trajectory)) continue;
    trajectory.samples = run.time.size();
    try {
      tolerance::ToleranceReport tolerance = tolerance::analyse_tolerance(
          space, tolerance::evaluate_tolerances(space), trajectory, {"torque", "shaking_force", "shaking_moment"});
      if (tolerance.outcome.status != MotionStatus::done) continue;
      if (is_same_run(tolerance.run, run)) {
        for (const tolerance::IncompatibleParameter& one : tolerance.incompatible_parameters)
          page.notes.push_back(name + ": " + format_incompatibility_note(one));
        return std::move(tolerance.deviation);
      }
      page.notes.push_back("no tolerance band along " + name + ": the run was made with different options");
    } catch (const std::invalid_argument& error) {
      page.notes.push_back("no tolerance band along " + name + ": " + error.what());
    }
  }
  return {};
}

/// Runs the chosen trajectories with the given mechanism and, if there is a design, with the designed one.
/// @throws MotionFailure if none of them can be run
void run_trajectories(const ReportOptions& options, const DesignSpace& before, const DesignSpace* after,
                      HtmlReport& page) {
  for (const std::string& name : choose_trajectories(options, before.start)) {
    reports::ReportedTrajectory reported = describe(before.start, name);
    reported.before = run_named(before.start, name, options);
    reported.deviation_before = deviation_of(before, *reported.before, name, page);
    if (after != nullptr) {
      reported.after = run_named(after->start, name, options);
      reported.deviation_after = deviation_of(*after, *reported.after, name, page);
    }
    page.trajectories.push_back(std::move(reported));
    if (pending_signal() != 0) throw files::Cancelled(nothing_written_message);
  }
  const auto works = [](const reports::ReportedTrajectory& t) { return is_done(t.before) || is_done(t.after); };
  if (!page.trajectories.empty() && std::none_of(page.trajectories.begin(), page.trajectories.end(), works))
    throw MotionFailure(page.trajectories.front().before->outcome);
}

constexpr int sweep_values = 81;
constexpr double min_swept_share = 0.05, max_swept_share = 2;  // of the stated speed

/// Modes of a trajectory with free coordinates, their response over a range of speeds, and a run for every mode.
void add_vibrations(const Study& study, const Trajectory& trajectory, HtmlReport& page) {
  const files::DisplayUnit speed = files::find_display_unit("rad/s", page.units);
  reports::ModesRequest request{.trajectory = trajectory.name};
  reports::VibrationReportData view = reports::analyse_modes(study, request, speed);
  const vibration::VibrationModes& modes = view.modes;
  if (modes.motion.outcome.status != MotionStatus::done) {
    page.notes.push_back("no vibration modes of " + trajectory.name + ": " + modes.motion.outcome.reason);
    return;
  }
  if (view.response) {
    const double stated = std::abs(speed.convert(view.response->turning.speed));
    request.sweep = fmt::format("{}={:.6g}:{:.6g}:{}", view.response->turning.coordinate, min_swept_share * stated,
                                max_swept_share * stated, sweep_values);
    reports::add_sweep(study, request, speed, view);
  }
  page.answers->vibrations.push_back(vibration_page_json(view));
  for (std::size_t k = 0; k < modes.modes.size(); ++k) {
    const std::string title = reports::mode_title(modes, k);
    reports::ReportedTrajectory shown = describe(study, trajectory.name);
    shown.name = trajectory.name + ", " + title;
    shown.mode = "shape of a vibration mode, exaggerated; efforts are those of a guide";
    shown.before = vibration::run_mode_shape(study.mechanism, trajectory, modes, modes.modes[k]);
    page.trajectories.push_back(std::move(shown));
  }
}

/// Those of the chosen trajectories that leave coordinates free.
void add_all_vibrations(const ReportOptions& options, const Study& study, HtmlReport& page) {
  if (!options.controller.empty()) return;
  for (const std::string& name : choose_trajectories(options, study)) {
    const Trajectory* trajectory = study::find_by_name(study.trajectories, name);
    if (trajectory == nullptr || !trajectory->free_motion) continue;
    try {
      add_vibrations(study, *trajectory, page);
    } catch (const SpecError& error) {
      page.notes.push_back("no vibration modes of " + name + ": " + error.what());
    }
    if (pending_signal() != 0) throw files::Cancelled(nothing_written_message);
  }
}

/// The page draws one mechanism for all trajectories.
Mechanism shown_mechanism(const Study& study) {
  return call_library(false, study, [&] { return mechanism_with_slides(study); });
}

HtmlReport begin_page(const ReportOptions& options, const Study& study) {
  HtmlReport page;
  page.version = version();
  page.command = command_line(options);
  page.spec_file = std::filesystem::path(study.spec_file).filename().string();
  page.spec_text = study.spec_text;
  page.before = shown_mechanism(study);
  page.answers = std::make_shared<reports::ReportedAnswers>();
  page.answers->check = reports::check_json(check_mechanism(study), study.mechanism, study.warnings);
  page.notes = study.warnings;
  if (has_spec_units(options.spec.units)) page.units = specification::read_display_units(study.spec_text);
  page.number_units = specification::list_number_units(study);
  for (const study::LoadParameter& load : study.design.cases.numbers)
    if (page.number_units.contains(load.path)) page.number_units[load.name] = page.number_units[load.path];
  page.controller = options.controller;
  if (!options.controller.empty())
    page.controller_type = controller_type_name(choose_controller(study, options.controller).type);
  return page;
}

/// The page of a run stored in a result file, together with its spec.
HtmlReport file_page(const ReportOptions& options, const files::StoredRun& run, const DesignSpace& space) {
  const Study& study = space.start;
  check_run_matches_mechanism(run, mechanism_along(study, run.trajectory));
  HtmlReport page = begin_page(options, study);
  page.controller = run.controller;
  page.controller_type = run.controller_type;
  if (!run.ended_early.empty()) page.notes.push_back("the run ended early: " + run.ended_early);
  reports::ReportedTrajectory reported{run.trajectory, run.law, run.drive, run.result, std::nullopt};
  reported.deviation_before = deviation_of(space, run.result, run.trajectory, page);
  page.trajectories.push_back(std::move(reported));
  return page;
}

DesignStudyOptions design_options(const ReportOptions& options, const Study& study) {
  DesignCommandOptions as_design;
  as_design.spec = options.spec;
  as_design.goal = options.goal;
  as_design.seconds = options.seconds;
  DesignStudyOptions study_options = make_study_options(as_design, study);
  study_options.compare_trajectories = false;  // they run here instead, with the requested samples
  return study_options;
}

/// The design of the page is the compromise point of the front.
reports::DesignReportData make_middle_design_data(const DesignStudyOptions& study_options, const DesignSpace& space,
                                                  HtmlReport& page) {
  design::ParetoFront front = find_front_or_throw(space, study_options);
  if (front.points.empty()) throw MechanismFailure("no-front", front.failure.outcome.reason);
  const design::ParetoPoint point = front.points[static_cast<std::size_t>(find_compromise_point(front))];
  DesignReport report = make_pareto_design(space, point, false);
  page.answers->front =
      reports::front_json(reports::make_front_report_data(study_options, space, std::move(front)), {});
  const std::string balanced = designed_spec_or_throw(space, report);
  return reports::make_design_data(study_options, point.space, balanced, std::move(report));
}

reports::DesignReportData only_design(const DesignStudyOptions& study_options, const DesignSpace& space) {
  DesignReport report = design_or_throw(space, study_options);
  const std::string balanced = designed_spec_or_throw(space, report);
  return reports::make_design_data(study_options, space, balanced, std::move(report));
}

void add_design(const ReportOptions& options, const DesignSpace& space, HtmlReport& page) {
  const DesignStudyOptions study_options = design_options(options, space.start);
  reports::DesignReportData view = space.start.design.front ? make_middle_design_data(study_options, space, page)
                                                            : only_design(study_options, space);
  view.conditions = convert_coefficients(std::move(view.conditions), page.units);
  page.before = shown_mechanism(view.report.study_before);
  page.after = shown_mechanism(view.report.study_after);
  page.answers->design = reports::design_json(view, {});
  std::vector<int> rows;
  if (view.report.catalogue)
    for (const study::CatalogueChoice& choice : view.report.catalogue->choices) rows.push_back(choice.row);
  DesignSpace before = space.fix_others(view.report.before, {}),
              after = space.with_rows(rows).fix_others(view.report.outcome.x, {});
  before.start = view.report.study_before;
  after.start = view.report.study_after;
  run_trajectories(options, before, &after, page);
}

HtmlReport make_page(const ReportOptions& options, const DesignSpace& space) {
  const Study& study = space.start;
  HtmlReport page = begin_page(options, study);
  const bool has_goal = !options.goal.goals.empty() || !study.design.goals.empty();
  if (has_goal)
    for (const Goal& goal : choose_goals(options.goal, study)) page.goal_descriptions.push_back(describe_goal(goal));
  const bool asks_for_design =
      has_goal || study.design.front || !study.design.minimize.empty() || !study.design.subject_to.empty();
  if (asks_for_design && (!study.free_numbers.empty() || design::has_free_rows(study))) {
    add_design(options, space, page);
    return page;
  }
  if (has_goal)
    page.answers->conditions =
        reports::conditions_json(convert_coefficients(derive_conditions_or_throw(options.goal, space), page.units), {});
  run_trajectories(options, space, nullptr, page);
  add_all_vibrations(options, study, page);
  return page;
}

std::string summary_json(const HtmlReport& page, const std::string& file, std::size_t bytes) {
  Json json = {{"mechanism", page.before.name}, {"trajectories", Json::array()}};
  for (const reports::ReportedTrajectory& t : page.trajectories) {
    Json entry = {{"trajectory", t.name}, {"before", name_of(t.before->outcome.status)}};
    if (t.after) entry["after"] = name_of(t.after->outcome.status);
    json["trajectories"].push_back(std::move(entry));
  }
  const bool has_design = !page.answers->design.is_null();
  json["conditions"] = has_design || !page.answers->conditions.is_null();
  json["design"] = has_design;
  json["bytes"] = bytes;
  json["files"] = {file};
  return files::format_json(json);
}

void write_page(const ReportOptions& options, const std::string& file, const std::string& html) {
  const SignalDeferral deferred;
  files::AtomicFile pending(file, options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid);
  pending.write(html);
  if (pending_signal() != 0) throw files::Cancelled(nothing_written_message);
  pending.commit();
}

/// @throws UsageError for options that do not apply to a stored run
void check_file_options(const ReportOptions& o) {
  if (!o.trajectories.empty() || !o.controller.empty() || !o.goal.goals.empty() || o.samples ||
      !o.spec.overrides.empty())
    throw UsageError(
        "a result file is shown as it is: --trajectory, --controller, --goal, --samples and --set are for specs");
}

ExitCode run(const ReportOptions& options) {
  std::optional<files::StoredRun> stored_run;
  if (files::names_result_file(options.spec.spec)) {
    check_file_options(options);
    stored_run = files::read_motion_file(options.spec.spec);
  }
  const DesignSpace space =
      stored_run ? read_design_space(stored_run->spec_text, options.spec.spec, {.set = stored_run->overrides})
                 : read_space(options.spec);
  choose_trajectories(options, space.start);  // report misspelt names before the computation
  if (!options.controller.empty()) choose_controller(space.start, options.controller);
  const std::string file = choose_output(options);
  std::vector<files::InputFile> inputs = list_input_files(space.start);
  if (stored_run) inputs.insert(inputs.begin(), {stored_run->path, "the result"});
  check_output(file, "the page", FileFormat::html, inputs, options.force);
  if (!reports::has_report_scripts()) reports::format_html_report({});  // throws an error that says what is missing
  if (!options.quiet)
    for (const std::string& warning : space.start.warnings) print_message("warning: " + warning);
  const HtmlReport page = stored_run ? file_page(options, *stored_run, space) : make_page(options, space);
  const std::string html = format_html_report(page);
  write_page(options, file, html);
  if (options.spec.json)
    print(summary_json(page, file, html.size()));
  else if (!options.quiet && file != files::standard_output_path)
    print_text(fmt::format("written: {} ({:.0f} kB)\n", escape_for_terminal(file),
                           std::max(1.0, static_cast<double>(html.size()) / 1000)));
  return ExitCode::done;
}

}  // namespace

Command setup_report(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("report", "Write one HTML page: mechanism, conditions, design, runs");
  const auto options = std::make_shared<ReportOptions>();
  add_report_options(*parser, *options);
  parser->footer(
      "The page works offline and shows the mechanism, the conditions of its goal, its design if it has\n"
      "free numbers, figures of every run before and after, charts, and an animation. The default goal is\n"
      "the spec's `design: goal`; without any goal, there are only runs.\n"
      "docs/report.md describes the page.\n\n"
      "Examples:\n"
      "  balance report 3rrr.yaml\n"
      "  balance report 5r-design.yaml -o 5r.html --force\n"
      "  balance report delta.yaml -t cycloid --goal static --samples 301\n"
      "  balance report 5r.yaml -t cycloid --controller computed-torque\n"
      "  balance report out.h5 -o run.html");
  return {parser, [options] {
            std::string trajectory;
            split_trajectory_name(options->spec.spec, trajectory);
            if (!trajectory.empty()) options->trajectories.push_back(trajectory);
            return run(*options);
          }};
}

namespace {

constexpr long max_report_samples = 20'000;  // pages with more open slowly, and no chart has that many columns

}  // namespace

void add_report_options(CLI::App& parser, ReportOptions& o) {
  add_spec_options(parser, o.spec);
  add_units_option(parser, o.spec.units);
  parser.add_option("-o,--output", o.output, "the page (default: the spec's name with .html)")->type_name("FILE");
  parser.add_option("-t,--trajectory", o.trajectories, "trajectory to show; may be repeated (default: all)")
      ->type_name("NAME")
      ->allow_extra_args(false);
  parser.add_option("-c,--controller", o.controller, "run every trajectory with this controller")->type_name("NAME");
  add_goal_options(parser, o.goal);
  parser.add_option("--samples", o.samples, "samples of every trajectory, both ends included")
      ->type_name("N")
      ->check(integer_range_validator(2, max_report_samples));
  add_seconds_option(parser, o.seconds);
  parser.add_flag("--force", o.force, "overwrite an existing file");
  parser.add_flag("-q,--quiet", o.quiet, "print only errors (and JSON with --json)");
}

std::vector<std::string> choose_trajectories(const ReportOptions& options, const Study& study) {
  for (const std::string& trajectory_name : options.trajectories) choose_trajectory(study, trajectory_name);
  std::vector<std::string> chosen;
  for (const Trajectory& trajectory : study.trajectories) {
    const auto& names = options.trajectories;
    if (names.empty() || std::find(names.begin(), names.end(), trajectory.name) != names.end())
      chosen.push_back(trajectory.name);
  }
  return chosen;
}

std::string choose_output(const ReportOptions& options) {
  if (options.output.empty() && options.spec.spec == "-")
    throw UsageError("--output is needed for a spec from standard input");
  check_standard_output({options.output}, options.spec.json, false);
  const std::string file =
      options.output.empty() ? std::filesystem::path(options.spec.spec).stem().string() + ".html" : options.output;
  return file;
}

std::string command_line(const ReportOptions& o) {
  std::vector<std::string> words = {"balance", "report", std::filesystem::path(o.spec.spec).filename().string()};
  for (const std::string& name : o.trajectories) words.insert(words.end(), {"--trajectory", name});
  if (!o.controller.empty()) words.insert(words.end(), {"--controller", o.controller});
  for (const std::string& goal : o.goal.goals) words.insert(words.end(), {"--goal", goal});
  if (o.goal.strategy != "complete") words.insert(words.end(), {"--strategy", o.goal.strategy});
  for (const std::string& names : o.goal.without) words.insert(words.end(), {"--without", names});
  if (o.goal.seed) words.insert(words.end(), {"--seed", std::to_string(*o.goal.seed)});
  if (o.samples) words.insert(words.end(), {"--samples", std::to_string(*o.samples)});
  if (o.seconds > 0) words.insert(words.end(), {"--seconds", fmt::format("{}", o.seconds)});
  if (!has_spec_units(o.spec.units)) words.insert(words.end(), {"--units", o.spec.units});
  for (const std::string& set : o.spec.overrides) words.insert(words.end(), {"--set", set});
  return files::join_command(std::move(words));
}

}  // namespace balance::app
