#include "command.hpp"
#include "compare_options.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "read_or_run.hpp"
#include "signals.hpp"

#include "balance/compare/run_names.hpp"
#include "balance/present/comparison_json.hpp"
#include "balance/present/comparison_text.hpp"
#include "balance/read/requirement.hpp"
#include "balance/spec/text_file.hpp"
#include "balance/write/pending_file.hpp"

#include <memory>

namespace balance::app {
namespace {

std::vector<NamedRun> read_runs(const CompareOptions& options) {
  std::vector<NamedRun> runs;
  std::vector<RunLocation> places;
  for (const std::string& file : options.files) {
    StoredRun run = load_or_simulate_run(file, options.output, "the comparison");
    places.push_back({run.path == standard_input ? "stdin" : run.path, run.group});
    runs.push_back({"", file, run.title, run.trajectory, run.law, run.drive, std::move(run.result)});
  }
  const std::vector<std::string> names = make_run_names(places);
  for (std::size_t i = 0; i < runs.size(); ++i) runs[i].name = names[i];
  return runs;
}

std::vector<RequirementVerdict> judge(const std::vector<std::string>& texts, const std::vector<NamedRun>& runs) {
  try {
    return judge_requirements(texts, runs);
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--require ") + error.what());
  }
}

std::string format_comparison(ComparisonFormat format, const ComparedRuns& compared,
                              const std::vector<RequirementVerdict>& verdicts, QuantitySelection shown) {
  switch (format) {
    case ComparisonFormat::text: return comparison_text(compared, verdicts, shown);
    case ComparisonFormat::markdown: return comparison_markdown(compared, verdicts, shown);
    case ComparisonFormat::csv: return comparison_csv(compared);
    case ComparisonFormat::json: return comparison_json(compared, verdicts);
    case ComparisonFormat::junit: return junit_xml("balance compare", {make_verdict_suite("requirements", verdicts)});
  }
  return "";
}

void write_file(const CompareOptions& options, const std::string& content) {
  const SignalDeferral deferred;
  AtomicFile pending(options.output, options.force ? OverwritePolicy::replace : OverwritePolicy::forbid);
  pending.write(content);
  if (pending_signal() != 0) throw Cancelled(nothing_written_message);
  pending.commit();
}

ExitCode run(const CompareOptions& options) {
  const ComparisonFormat format = choose_format(options);
  check_standard_input_once(options.files);
  std::vector<InputFile> inputs;
  for (const std::string& file : options.files) inputs.push_back({file, "what it is made from"});
  check_output(options.output, "the comparison", inputs, options.force);
  const std::vector<NamedRun> runs = read_runs(options);
  const std::vector<RequirementVerdict> verdicts = judge(options.requirements, runs);
  const std::string content = format_comparison(format, compare_runs(runs), verdicts,
                                                options.all ? QuantitySelection::all : QuantitySelection::main);
  if (options.output.empty()) {
    print_text(content);
  } else {
    write_file(options, content);
    if (!options.quiet)
      print_status({options.output}, format_verdicts(verdicts) + format_written_message(options.output));
  }
  // A table of values has no place for them.
  const bool shown = options.output.empty() ? format != ComparisonFormat::csv : !options.quiet;
  for (const RequirementVerdict& verdict : verdicts) {
    if (!verdict.holds && !shown) print_message(format_verdict_line(verdict));
  }
  return do_all_hold(verdicts) ? ExitCode::done : ExitCode::not_met;
}

}  // namespace

Command setup_compare(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("compare", "Compare runs; check requirements on their figures");
  const auto options = std::make_shared<CompareOptions>();
  add_compare_options(*parser, *options);
  parser->footer(
      "The first run is the base; a spec, with a trajectory behind a colon, is run first. Requirements compare peak, "
      "rms, mean and range of a quantity, and\n"
      "energy(), of each other file with numbers and with other files, which are called by their names\n"
      "without folder and ending; docs/compare.md describes them.\n\n"
      "Examples:\n"
      "  balance compare original.h5 balanced.h5\n"
      "  balance compare 3rrr.yaml:cycloid 3rrr.yaml:bang-bang\n"
      "  balance compare a.h5 b.h5 --require 'peak(shaking_force) <= 0.9 * base'\n"
      "  balance compare a.h5 b.h5 --require 'rms(torque) < 1.2 * base' -o junit.xml\n"
      "  balance compare d.h5:before/cycloid d.h5:after/cycloid --format markdown");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
