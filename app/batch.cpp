#include "batch_options.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "progress_line.hpp"
#include "signals.hpp"

#include "balance/base/error.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/batch/folder.hpp"
#include "balance/batch/summary.hpp"
#include "balance/write/json_parts.hpp"
#include "balance/write/pending_file.hpp"

#include <fmt/format.h>

#include <memory>

namespace balance::app {
namespace {

std::string format_progress(const BatchProgress& progress) {
  std::string text = fmt::format("{} of {} cases", progress.finished, progress.total);
  if (progress.reused > 0) text += fmt::format(", {} found finished", progress.reused);
  if (progress.failed > 0) text += fmt::format(", {} failed", progress.failed);
  return text;
}

/// The cases and the files that they are made of, for scripts.
ExitCode print_case_list(const BatchPlan& plan, const BatchCommandOptions& options, const std::optional<Shard>& shard) {
  Json json = {{"suite", plan.suite.name}, {"cases", Json::array()}};
  std::string names;
  for (const SuiteCase& one : plan.suite.cases) {
    if (shard && !is_in_shard(one.name, *shard)) continue;
    names += one.name + "\n";
    json["cases"].push_back(one.name);
  }
  json["files"] = {options.suite};
  for (const SpecSource& spec : plan.specs) {
    json["files"].push_back(spec.path);
    for (const std::string& table : spec.referenced_files) json["files"].push_back(table);
  }
  print(options.json ? format_json(json) : names);
  return ExitCode::done;
}

/// What earlier batches have left.
void print_reused_cases(const BatchOutcome& outcome, const BatchCommandOptions& options) {
  const BatchProgress& progress = outcome.progress;
  if (options.quiet || progress.reused == 0) return;
  std::string text = fmt::format("note: {} of {} cases were finished already", progress.reused, progress.total);
  if (progress.reused_failed > 0)
    text += fmt::format(", {} of them without a result; --retry-failed computes those again", progress.reused_failed);
  print_message(text);
}

std::string format_case(const CaseRecord& record) {
  return escape_for_terminal(record.name + ": " + record.status +
                             (record.message.empty() ? "" : ": " + record.message));
}

/// A shard's part of the results: no summary of all, no requirements.
ExitCode report_shard(const BatchOutcome& outcome, const BatchCommandOptions& options) {
  int code = 0;
  std::string text;
  Json json = {{"shard", options.shard}, {"cases", Json::array()}};
  for (const CaseRecord& record : outcome.records) {
    code = std::max(code, record.exit_code());
    text += format_case(record) + "\n";
    json["cases"].push_back({{"name", record.name}, {"status", record.status}, {"message", record.message}});
  }
  if (options.json)
    print(format_json(json));
  else if (!options.quiet)
    print_text(text);
  else
    for (const CaseRecord& record : outcome.records)
      if (record.status != "done") print_message("FAILED " + format_case(record));
  return static_cast<ExitCode>(code);
}

ExitCode report(const BatchPlan& plan, BatchOutcome outcome, const BatchCommandOptions& options) {
  const BatchSummary summary = summarise_batch(plan.suite, std::move(outcome.records));
  const std::vector<std::string> files = [&] {
    const SignalDeferral deferred;
    return write_summary(choose_output_folder(options), summary);
  }();
  if (pending_signal() != 0) throw Cancelled("interrupted, after the summary was written");
  if (options.json) {
    print(summary_json(summary));
  } else if (!options.quiet) {
    std::string text = format_batch_text(summary);
    for (const std::string& file : files) text += format_written_message(file);
    // The end of a log is what is read of it.
    const std::string failures = format_failures(summary);
    print_text(text + (failures.empty() ? "" : "\n") + failures);
  } else if (const std::string failures = format_failures(summary); !failures.empty()) {
    tell_lines(failures.substr(0, failures.size() - 1));
  }
  return static_cast<ExitCode>(summary.exit_code());
}

ExitCode run(const BatchCommandOptions& options) {
  const std::optional<Shard> shard = parse_shard(options.shard);
  if (options.merge && shard) throw UsageError("--merge is about all cases and does not go with --shard");
  const BatchPlan plan = make_batch_plan(read_suite_file(options.suite));
  if (options.list) return print_case_list(plan, options, shard);
  if (const std::string trouble = find_overwritten_input(plan, choose_output_folder(options)); !trouble.empty())
    throw UsageError(trouble);
  if (options.merge) return report(plan, collect_batch(plan, choose_output_folder(options)), options);
  set_interrupt_message("interrupted; cases that are finished are kept, and the same command goes on behind them");
  BatchOutcome outcome;
  {
    ProgressLine line(options.quiet);
    BatchOptions batch = make_batch_options(options);
    batch.progress = [&line](const BatchProgress& progress) { line.draw(format_progress(progress)); };
    outcome = run_batch(plan, batch);
  }
  print_reused_cases(outcome, options);
  return shard ? report_shard(outcome, options) : report(plan, std::move(outcome), options);
}

}  // namespace

Command setup_batch(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("batch", "Run many cases, compare them, judge requirements");
  const auto options = std::make_shared<BatchCommandOptions>();
  add_batch_options(*parser, *options);
  parser->footer(
      "Runs the cases of a suite, which docs/suite.md describes, and writes into a folder: one HDF5 file\n"
      "per case, summary.json, summary.csv, summary.md and junit.xml. Every case runs in a process of its\n"
      "own: one that fails, crashes or goes beyond --case-timeout or --case-memory does not stop the\n"
      "others. A batch that was interrupted goes on where it stopped and does nothing twice; a case that\n"
      "failed is tried again when something that it depends on has changed, or with --retry-failed.\n\n"
      "Exit code 0: all cases are done and the requirements hold; 1: a requirement is missed or a design\n"
      "is only a compromise; else the largest code (3, 4 or 5) among the cases that failed.\n\n"
      "Examples:\n"
      "  balance batch suite.yaml\n"
      "  balance batch suite.yaml -j 4 -o results\n"
      "  balance batch suite.yaml --metrics-only --case-timeout 60 --case-memory 1GiB\n"
      "  balance batch suite.yaml --shard 2/8 -o results\n"
      "  balance batch suite.yaml --merge -o results");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
