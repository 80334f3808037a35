#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/figure_evaluation.hpp"
#include "balance/interface/comparison/requirement.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/interface/reports/comparison_sections.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/signals.hpp"
#include "cli/validators.hpp"
#include "run_operands.hpp"

#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace balance::app {

/// Options of `balance compare`.
enum class ComparisonFormat { text, markdown, csv, json, junit };

struct CompareOptions {
  std::vector<std::string> files;
  std::vector<std::string> requirements;
  std::string format;  ///< empty: given by the suffix of the output, else text
  std::string output;  ///< empty: stdout
  bool json = false;
  bool all = false;
  bool force = false;
  bool quiet = false;
};

void add_compare_options(CLI::App& parser, CompareOptions& options);

/// @throws UsageError if the options contradict each other
ComparisonFormat choose_format(const CompareOptions& options);

namespace {

/// @param specs_are_si set to false if a spec is in other units
std::vector<comparison::NamedRun> read_runs(const CompareOptions& options, bool& specs_are_si) {
  std::vector<comparison::NamedRun> runs;
  std::vector<comparison::RunLocation> locations;
  for (const std::string& file : options.files) {
    files::StoredRun run = load_or_simulate_run(file, options.output, "the comparison");
    if (files::has_other_units(specification::read_display_units(run.spec_text))) specs_are_si = false;
    locations.push_back({run.path == specification::standard_input ? "stdin" : run.path, run.group});
    std::shared_ptr<const Mechanism> mechanism =
        options.requirements.empty()
            ? nullptr
            : comparison::read_mechanism_of(run.result, run.trajectory, run.spec_text, run.path, run.overrides);
    runs.push_back(
        {"", file, run.title, run.trajectory, run.law, run.drive, std::move(run.result), std::move(mechanism)});
  }
  const std::vector<std::string> names = make_run_names(locations);
  for (std::size_t i = 0; i < runs.size(); ++i) runs[i].name = names[i];
  return runs;
}

std::vector<comparison::RequirementVerdict> judge(const std::vector<std::string>& texts,
                                                  const std::vector<comparison::NamedRun>& runs) {
  try {
    return judge_requirements(texts, runs);
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--require ") + error.what());
  }
}

std::string format_comparison(ComparisonFormat format, const comparison::ComparedRuns& compared,
                              const std::vector<comparison::RequirementVerdict>& verdicts,
                              reports::QuantitySelection selection, std::size_t width) {
  switch (format) {
    case ComparisonFormat::text: return comparison_text(compared, verdicts, selection, width);
    case ComparisonFormat::markdown: return comparison_markdown(compared, verdicts, selection);
    case ComparisonFormat::csv: return reports::comparison_csv(compared);
    case ComparisonFormat::json: return reports::comparison_json(compared, verdicts);
    case ComparisonFormat::junit:
      return reports::junit_xml("balance compare", {reports::make_verdict_suite("requirements", verdicts)});
  }
  return "";
}

void write_file(const CompareOptions& options, const std::string& content) {
  const SignalDeferral deferred;
  files::AtomicFile pending(options.output,
                            options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid);
  pending.write(content);
  if (pending_signal() != 0) throw files::Cancelled(nothing_written_message);
  pending.commit();
}

ExitCode run(const CompareOptions& options) {
  const ComparisonFormat format = choose_format(options);
  check_standard_input_once(options.files);
  std::vector<files::InputFile> inputs;
  for (const std::string& file : options.files) inputs.push_back({file, "its input"});
  check_output(options.output, "the comparison", FileFormat::other, inputs, options.force);
  bool specs_are_si = true;
  const std::vector<comparison::NamedRun> runs = read_runs(options, specs_are_si);
  const std::vector<comparison::RequirementVerdict> verdicts = judge(options.requirements, runs);
  comparison::ComparedRuns compared = compare_runs(runs);
  if (!specs_are_si) compared.notes.emplace_back("all figures are SI, although the specs are in other units");
  const std::string content = format_comparison(
      format, compared, verdicts, options.all ? reports::QuantitySelection::all : reports::QuantitySelection::main,
      options.output.empty() ? text_width() : files::default_text_width);
  if (options.output.empty()) {
    print_text(content);
  } else {
    write_file(options, content);
    if (!options.quiet)
      print_status({options.output}, reports::format_verdicts(verdicts) + format_written_message(options.output));
  }
  // A table of values cannot contain verdicts.
  const bool shown = options.output.empty() ? format != ComparisonFormat::csv : !options.quiet;
  for (const comparison::RequirementVerdict& verdict : verdicts) {
    if (!verdict.holds && !shown) print_message(reports::format_verdict_line(verdict));
  }
  return do_all_hold(verdicts) ? ExitCode::done : ExitCode::not_met;
}

}  // namespace

Command setup_compare(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("compare", "Compare runs; check requirements on their figures");
  const auto options = std::make_shared<CompareOptions>();
  add_compare_options(*parser, *options);
  parser->footer(
      "The first run is the base; a spec, optionally followed by a colon and a trajectory, is simulated\n"
      "first. Requirements compare figures of each other file (peak, rms, mean, range, minimum, maximum,\n"
      "a value at a time or where another quantity has a value, duration, energy) with numbers or with\n"
      "other files, named without folder and suffix; docs/compare.md describes them.\n\n"
      "Examples:\n"
      "  balance compare original.h5 balanced.h5\n"
      "  balance compare 3rrr.yaml:cycloid 3rrr.yaml:bang-bang\n"
      "  balance compare a.h5 b.h5 --require 'peak(shaking_force) <= 0.9 * base'\n"
      "  balance compare a.h5 b.h5 --require 'rms(torque) < 1.2 * base' -o junit.xml\n"
      "  balance compare a.h5 b.h5 --require 'value(tool_position[x], end) >= base'\n"
      "  balance compare d.h5:before/cycloid d.h5:after/cycloid --format markdown");
  return {parser, [options] { return run(*options); }};
}

namespace {

struct NamedFormat {
  const char* name;
  const char* ending;
  ComparisonFormat format;
};

constexpr NamedFormat formats[]{{"text", ".txt", ComparisonFormat::text},
                                {"markdown", ".md", ComparisonFormat::markdown},
                                {"csv", ".csv", ComparisonFormat::csv},
                                {"json", ".json", ComparisonFormat::json},
                                {"junit", ".xml", ComparisonFormat::junit}};

ComparisonFormat find_format(const CompareOptions& options) {
  const std::string ending = std::filesystem::path(options.output).extension().string();
  for (const NamedFormat& one : formats) {
    if (options.format.empty() ? ending == one.ending : options.format == one.name) return one.format;
  }
  return ComparisonFormat::text;
}

}  // namespace

void add_compare_options(CLI::App& parser, CompareOptions& o) {
  std::vector<std::string> names;
  for (const NamedFormat& one : formats) names.emplace_back(one.name);
  add_run_operands(parser, o.files)
      ->description(
          "result files, runs of design files (design.h5:after/cycloid) or specs (arm.yaml:cycloid), the base first");
  parser.add_option("--require", o.requirements, "requirement to check; may be repeated")
      ->type_name("EXPR")
      ->allow_extra_args(false);
  CLI::Option* format =
      parser.add_option("--format", o.format, "output format (default: by the output's suffix, else text)");
  add_choice_validator(format->type_name("FORMAT"), names);
  parser.add_flag("--json", o.json, "same as --format json, errors included")->excludes(format);
  parser.add_option("-o,--output", o.output, "write to this file instead of the terminal")->type_name("FILE");
  parser.add_flag("--all", o.all, "show all quantities, including joint reactions (csv and json always do)");
  parser.add_flag("--force", o.force, "overwrite an existing file");
  parser.add_flag("-q,--quiet", o.quiet, "with --output: print only errors");
}

ComparisonFormat choose_format(const CompareOptions& options) {
  if (options.files.size() < 2)
    throw UsageError("expected at least two runs to compare, the base first: result files or specs (arm.yaml:cycloid)");
  const ComparisonFormat format = options.json ? ComparisonFormat::json : find_format(options);
  if (format == ComparisonFormat::junit && options.requirements.empty()) {
    throw UsageError("a JUnit report lists requirements: give at least one --require");
  }
  return format;
}

}  // namespace balance::app
