#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/reports/certificate_file.hpp"
#include "balance/interface/reports/design_sections.hpp"
#include "balance/interface/reports/front_sections.hpp"
#include "balance/interface/specification/spec_locations.hpp"
#include "balance/synthesis/design/length_bound_search.hpp"
#include "balance_options.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/signals.hpp"
#include "design_options.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace balance::app {

// Interactive search for a design.

/// Shows the progress of the search on a terminal. Ctrl-C ends the search with the best result so far.
/// @throws Cancelled if there is none yet
/// @param what description of the search, for the terminal
/// @param find runs the search with the options that it is passed
/// @param interrupted time of Ctrl-C since the start [s]
template <class Find>
auto run_interruptible_search(const DesignCommandOptions& options, DesignStudyOptions study_options,
                              const std::string& what, std::optional<double>& interrupted, Find&& find) {
  ProgressLine line(options.quiet || options.spec.json);
  const InterruptGuard interrupt;
  const Stopwatch watch;
  study_options.on_progress = [&](const design::SearchProgress& progress) {
    line.draw_fraction(what, progress.seconds / progress.max_time);
    if (interrupt.was_interrupted() && !interrupted) interrupted = watch.seconds();
    return !interrupt.was_interrupted();
  };
  try {
    return std::forward<Find>(find)(study_options);
  } catch (const DeadlineExceeded&) {
    if (!interrupt.was_interrupted()) throw;
  } catch (const MechanismFailure&) {
    if (!interrupt.was_interrupted()) throw;
  }
  throw files::Cancelled(nothing_written_message);
}

namespace {

/// @throws UsageError if a certificate is asked for and there is an obstacle
void check_certificate(const DesignCommandOptions& options, const std::string& obstacle) {
  if (!options.certificate.empty() && !obstacle.empty())
    throw UsageError("--certificate: no certificate because " + obstacle);
}

std::vector<std::string> write_files(const DesignCommandOptions& options, const DesignSpace& space,
                                     const std::string& balanced, const reports::DesignReportData& view) {
  files::WriteOptions write;
  write.existing = options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  std::vector<std::string> files;
  const auto write_text = [&](const std::string& path, const std::string& text) {
    files::AtomicFile file(path, write.existing);
    file.write(text);
    throw_if_cancelled(write);
    file.commit();
    files.push_back(path);
  };
  if (!options.output.empty()) write_text(options.output, balanced);
  if (!options.certificate.empty())
    write_text(options.certificate,
               reports::format_certificate(view.report, view.objective, describe(options, space.start)));
  if (!options.h5.empty()) {
    write_design(options.h5, view, describe(options, space.start), write);
    files.push_back(options.h5);
  }
  return files;
}

ExitCode run(const DesignCommandOptions& options) {
  const DesignSpace space = read_space(options.spec);
  check_front_options(options, space.start);
  const DesignStudyOptions study_options = make_study_options(options, space.start);
  check_outputs(options, space.start);
  if (!options.certificate.empty()) check_certificate(options, design::find_certificate_obstacle(space, study_options));
  if (!options.quiet)
    for (const std::string& warning : space.start.warnings) print_message("warning: " + warning);
  if (is_front_requested(options, space.start)) return run_front(options, space);
  std::optional<double> interrupted;
  DesignReport report = run_interruptible_search(
      options, study_options, "searching (Ctrl-C stops with the best so far)", interrupted,
      [&](const DesignStudyOptions& interruptible_options) { return design_or_throw(space, interruptible_options); });
  const bool done = is_success(report.outcome);
  if (!report.length_bound) check_certificate(options, "the search ended without a bound");
  if (report.length_bound) check_certificate(options, report.length_bound->reason);
  const std::string spec = designed_spec_or_throw(space, report);
  reports::DesignReportData view = reports::make_design_data(study_options, space, spec, std::move(report));
  view.interrupted = interrupted;
  const std::vector<std::string> files = write_files(options, space, spec, view);
  if (options.spec.json) {
    print(files::format_json(design_json(view, files)));
  } else if (!options.quiet) {
    std::string text = design_text(view, choose_design_text_options(options.spec, space.start));
    std::string lines;
    for (const std::string& file : files)
      lines += format_written_message(file, done ? "written" : "written, not balanced");
    if (!lines.empty()) text += "\n" + lines;
    print_status(files, text);
  }
  return done ? ExitCode::done : ExitCode::not_met;
}

}  // namespace

Command setup_design(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("design", "Find numbers that balance a mechanism");
  const auto options = std::make_shared<DesignCommandOptions>();
  add_design_options(*parser, *options);
  add_verbose_flag(*parser, options->spec.verbose);
  parser->footer(
      "Finds values for the spec's free numbers that meet all conditions of its goal, the best ones if\n"
      "there is an objective; if there are none, the best compromise and the reason. States what is known\n"
      "about optimality: proved-best, local-best or stopped. Prints the numbers, the conditions, their\n"
      "cost and the gain along the trajectories that the objective and the limits name (--verbose: along\n"
      "every trajectory). Without a goal, the objective alone determines the numbers. Ctrl-C stops the\n"
      "search with the best result so far.\n"
      "If the spec has a front, a trade-off between two or three figures, designs along it are listed,\n"
      "numbered from 1; --point K shows one and, with -o, writes it.\n"
      "Exit code 0: balanced (or no goal) and within all limits; 1: a compromise, or impossible; files\n"
      "are written in both cases.\n\n"
      "Examples:\n"
      "  balance design 5r.yaml -o balanced.yaml\n"
      "  balance design 5r.yaml --goal static --minimize added-mass --h5 design.h5\n"
      "  balance design 5r.yaml --strategy modular --json\n"
      "  balance design front.yaml --csv front.csv --point middle -o middle.yaml");
  return {parser, [options] { return run(*options); }};
}

namespace {

constexpr const char* middle = "middle";

/// Index of the point named by the option; −1 if none.
int choose_point(const std::string& name, const design::ParetoFront& front) {
  if (name.empty() || front.points.empty()) return -1;
  if (name == middle) return find_compromise_point(front);
  const auto count = static_cast<int>(front.points.size());
  const int k = std::stoi(name);
  if (k > count) throw UsageError(fmt::format("--point {}: the front has {} point{}", k, count, count == 1 ? "" : "s"));
  return k - 1;
}

/// The design of a point of the front, with its reports.
struct FrontDesign {  // NOLINT(bugprone-exception-escape): Json is noexcept, whatever its assertions do
  std::string spec, text;
  Json json;  ///< null: no point was chosen
};

FrontDesign make_front_design(const DesignStudyOptions& study_options, const DesignSpace& space,
                              const design::ParetoPoint& point, const files::TextOptions& text) {
  FrontDesign chosen;
  DesignReport report = make_pareto_design(space, point, study_options.compare_trajectories);
  chosen.spec = designed_spec_or_throw(space, report);
  const reports::DesignReportData view =
      reports::make_design_data(study_options, point.space, chosen.spec, std::move(report));
  chosen.text = design_text(view, text);
  chosen.json = reports::design_json(view, {});
  return chosen;
}

std::vector<std::string> write_files(const DesignCommandOptions& options, const DesignSpace& space,
                                     const std::string& balanced, const reports::FrontReportData& view) {
  files::WriteOptions write;
  write.existing = options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  std::vector<std::string> files;
  const auto write_text = [&](const std::string& path, const std::string& text) {
    if (path.empty()) return;
    files::AtomicFile file(path, write.existing);
    file.write(text);
    throw_if_cancelled(write);
    file.commit();
    files.push_back(path);
  };
  if (!balanced.empty()) write_text(options.output, balanced);
  write_text(options.csv, front_csv(view));
  if (!options.h5.empty()) {
    write_front(options.h5, view, describe(options, space.start), write);
    files.push_back(options.h5);
  }
  return files;
}

}  // namespace

bool is_front_requested(const DesignCommandOptions& options, const Study& study) {
  return study.design.front && options.minimize.empty();
}

void check_front_options(const DesignCommandOptions& options, const Study& study) {
  const bool is_number = !options.point.empty() && options.point.size() < 6 && options.point[0] != '0' &&
                         options.point.find_first_not_of("0123456789") == std::string::npos;
  if (!options.point.empty() && options.point != middle && !is_number)
    throw UsageError(
        fmt::format("--point {}: expected the number of a point, from 1, or middle", quote_for_message(options.point)));
  if (!is_front_requested(options, study)) {
    for (const auto& [name, value] : {std::pair("--point", options.point), std::pair("--csv", options.csv)})
      if (!value.empty())
        throw UsageError(fmt::format("{} needs a spec with a front (design: front), and no --minimize", name));
    return;
  }
  check_certificate(options, "a front has several objectives; choose one with --minimize");
  if (!options.output.empty() && options.point.empty())
    throw UsageError(
        "--output writes one design, but a front has several: choose one with --point K or --point middle");
}

design::ParetoFront find_front_or_throw(const DesignSpace& space, const DesignStudyOptions& options) {
  try {
    design::ParetoFront front = compute_pareto_front(space, options);
    if (front.points.empty())
      if (const reports::RequestFailure refusal = reports::find_failure(front.failure))
        throw MechanismFailure(refusal.status, refusal.reason);
    return front;
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = specification::locate_key(space.start, "design"), .message = error.what()});
  }
}

ExitCode run_front(const DesignCommandOptions& options, const DesignSpace& space) {
  const DesignStudyOptions study_options = make_study_options(options, space.start);
  std::optional<double> interrupted;
  design::ParetoFront front =
      run_interruptible_search(options, study_options, "searching the front (Ctrl-C stops with the points so far)",
                               interrupted, [&](const DesignStudyOptions& interruptible_options) {
                                 return find_front_or_throw(space, interruptible_options);
                               });
  reports::FrontReportData view = reports::make_front_report_data(study_options, space, std::move(front));
  view.interrupted = interrupted;
  const int k = choose_point(options.point, view.front);
  FrontDesign chosen;
  const files::TextOptions text_options = choose_design_text_options(options.spec, space.start);
  if (k >= 0)
    chosen = make_front_design(study_options, space, view.front.points[static_cast<std::size_t>(k)], text_options);
  const std::vector<std::string> files = write_files(options, space, chosen.spec, view);
  if (options.spec.json) {
    print(files::format_json(front_json(view, files, chosen.json)));
  } else if (!options.quiet) {
    std::string text = front_text(view, text_options);
    if (k >= 0) text += fmt::format("\npoint {}\n", k + 1) + chosen.text;
    std::string lines;
    for (const std::string& file : files) lines += format_written_message(file);
    print_status(files, text + (lines.empty() ? "" : "\n" + lines));
  }
  return view.front.points.empty() ? ExitCode::not_met : ExitCode::done;
}

}  // namespace balance::app
