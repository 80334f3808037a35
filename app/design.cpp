#include "answers.hpp"
#include "console.hpp"
#include "design_front.hpp"
#include "design_options.hpp"
#include "signals.hpp"
#include "watched_search.hpp"

#include "balance/present/design_hdf5.hpp"
#include "balance/present/design_json.hpp"
#include "balance/present/design_text.hpp"

#include <memory>

namespace balance::app {
namespace {

std::vector<std::string> write_files(const DesignCommandOptions& options, const DesignSpace& space,
                                     const std::string& balanced, const DesignReportData& view) {
  WriteOptions write;
  write.existing = options.force ? OverwritePolicy::replace : OverwritePolicy::forbid;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  std::vector<std::string> files;
  if (!options.output.empty()) {
    AtomicFile file(options.output, write.existing);
    file.write(balanced);
    throw_if_cancelled(write);
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
  check_front_options(options, space.start);
  const DesignStudyOptions wanted = make_study_options(options, space.start);
  check_outputs(options, space.start);
  if (!options.quiet)
    for (const std::string& warning : space.start.warnings) print_message("warning: " + warning);
  if (is_front_requested(options, space.start)) return run_front(options, space);
  std::optional<double> interrupted;
  DesignReport report =
      run_interruptible_search(options, wanted, "searching, Ctrl-C ends it with the best so far", interrupted,
                               [&](const DesignStudyOptions& watched) { return design_or_throw(space, watched); });
  const DesignStatus status = report.outcome.status;
  const bool done = status == DesignStatus::balanced || status == DesignStatus::no_goal;
  const std::string spec = designed_spec_or_throw(space, report);
  DesignReportData view = make_design_data(wanted, space, spec, std::move(report));
  view.interrupted = interrupted;
  const std::vector<std::string> files = write_files(options, space, spec, view);
  if (options.spec.json) {
    print(design_json(view, files));
  } else if (!options.quiet) {
    std::string text = design_text(view);
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
  parser->footer(
      "Finds values for the spec's free numbers that meet all conditions of its goal, the best of them\n"
      "if something is to be minimized; otherwise the best compromise and the reason why there is no\n"
      "solution. Says what was shown: proved-best, local-best or stopped. Prints the numbers, the\n"
      "conditions, what they cost and what every trajectory gains. Without a goal the numbers are\n"
      "chosen for what is to be minimized alone. Ctrl-C ends the search with the best so far.\n"
      "Where the spec has a front, a trade-off between two or three figures, designs all along it are\n"
      "listed, numbered from 1; --point K shows one, and writes it with -o.\n"
      "Exit code 0: balanced (or no goal) and within all limits; 1: a compromise, or it is impossible;\n"
      "files are written all the same.\n\n"
      "Examples:\n"
      "  balance design 5r.yaml -o balanced.yaml\n"
      "  balance design 5r.yaml --goal static --minimize added-mass --h5 design.h5\n"
      "  balance design 5r.yaml --strategy modular --json\n"
      "  balance design front.yaml --csv front.csv --point middle -o middle.yaml");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
