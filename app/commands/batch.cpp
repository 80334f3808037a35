#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/batch/batch_folder.hpp"
#include "balance/interface/batch/batch_run.hpp"
#include "balance/interface/batch/batch_summary.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/help.hpp"
#include "cli/signals.hpp"
#include "cli/validators.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace balance::app {

/// Options of `batch`.
struct BatchCommandOptions {
  std::string suite;
  std::string output;                     ///< folder; empty: the suite's stem with `-results`, in the current folder
  unsigned jobs = 0;                      ///< 0: one per core
  std::string shard;                      ///< "i/n"
  std::string case_timeout, case_memory;  ///< empty: the defaults of the library
  bool metrics_only = false;
  bool retry_failed = false;
  bool merge = false;
  bool list = false;
  bool force = false;
  bool json = false;
  bool quiet = false;
};

void add_batch_options(CLI::App& parser, BatchCommandOptions& options);

/// @throws UsageError if the text is not of the form i/n
std::optional<batch::Shard> parse_shard(const std::string& text);

/// The folder for the results.
std::string choose_output_folder(const BatchCommandOptions& options);

/// The library's options without the progress callback. @throws UsageError for an invalid limit
batch::BatchOptions make_batch_options(const BatchCommandOptions& options);

namespace {

std::string format_progress(const batch::BatchProgress& progress) {
  std::string text = fmt::format("{} of {} cases", progress.finished, progress.total);
  if (progress.reused > 0) text += fmt::format(", {} finished before", progress.reused);
  if (progress.failed > 0) text += fmt::format(", {} failed", progress.failed);
  return text;
}

/// Lists the cases and the files that they depend on, for scripts.
ExitCode print_case_list(const batch::BatchPlan& plan, const BatchCommandOptions& options,
                         const std::optional<batch::Shard>& shard) {
  Json json = {{"suite", plan.suite.name}, {"cases", Json::array()}};
  std::string names;
  for (const batch::SuiteCase& one : plan.suite.cases) {
    if (shard && !is_in_shard(one.name, *shard)) continue;
    names += one.name + "\n";
    json["cases"].push_back(one.name);
  }
  json["files"] = {options.suite};
  for (const batch::SpecSource& spec : plan.specs) {
    json["files"].push_back(spec.path);
    for (const std::string& table : spec.referenced_files) json["files"].push_back(table);
  }
  print(options.json ? files::format_json(json) : names);
  return ExitCode::done;
}

/// Notes the cases that earlier batches have finished.
void print_reused_cases(const batch::BatchOutcome& outcome, const BatchCommandOptions& options) {
  const batch::BatchProgress& progress = outcome.progress;
  if (options.quiet || progress.reused == 0) return;
  std::string text = fmt::format("note: {} of {} cases were finished already", progress.reused, progress.total);
  if (progress.reused_failed > 0)
    text += fmt::format(", {} of them without a result; --retry-failed computes those again", progress.reused_failed);
  print_message(text);
}

std::string format_case(const batch::CaseRecord& record) {
  return escape_for_terminal(record.name + ": " + record.status +
                             (record.message.empty() ? "" : ": " + record.message));
}

/// Reports the results of a shard, without the summary of all cases and without requirements.
ExitCode report_shard(const batch::BatchOutcome& outcome, const BatchCommandOptions& options) {
  int code = 0;
  std::string text;
  Json json = {{"shard", options.shard}, {"cases", Json::array()}};
  for (const batch::CaseRecord& record : outcome.records) {
    code = std::max(code, record.exit_code());
    text += format_case(record) + "\n";
    json["cases"].push_back({{"name", record.name}, {"status", record.status}, {"message", record.message}});
  }
  if (options.json)
    print(files::format_json(json));
  else if (!options.quiet)
    print_text(text);
  else
    for (const batch::CaseRecord& record : outcome.records)
      if (record.status != "done") print_message("FAILED " + format_case(record));
  return static_cast<ExitCode>(code);
}

ExitCode report(const batch::BatchPlan& plan, batch::BatchOutcome outcome, const BatchCommandOptions& options) {
  const batch::BatchSummary summary = summarise_batch(plan.suite, std::move(outcome.records));
  const std::vector<std::string> files = [&] {
    const SignalDeferral deferred;
    return write_summary(choose_output_folder(options), summary);
  }();
  if (pending_signal() != 0) throw files::Cancelled("interrupted, after the summary was written");
  if (options.json) {
    print(summary_json(summary));
  } else if (!options.quiet) {
    std::string text = format_batch_text(summary);
    for (const std::string& file : files) text += format_written_message(file);
    // Failures come last, because the end of a log is what people read.
    const std::string failures = format_failures(summary);
    print_text(text + (failures.empty() ? "" : "\n") + failures);
  } else if (const std::string failures = format_failures(summary); !failures.empty()) {
    print_message_lines(failures.substr(0, failures.size() - 1));
  }
  return static_cast<ExitCode>(summary.exit_code());
}

ExitCode run(const BatchCommandOptions& options) {
  const std::optional<batch::Shard> shard = parse_shard(options.shard);
  if (options.merge && shard) throw UsageError("--merge covers all cases and cannot be combined with --shard");
  const batch::BatchPlan plan = make_batch_plan(batch::read_suite_file(options.suite));
  if (options.list) return print_case_list(plan, options, shard);
  if (const std::string conflict = find_overwritten_input(plan, choose_output_folder(options)); !conflict.empty())
    throw UsageError(conflict);
  if (options.merge) return report(plan, collect_batch(plan, choose_output_folder(options)), options);
  set_interrupt_message("interrupted; finished cases are kept, and the same command continues after them");
  batch::BatchOutcome outcome;
  {
    ProgressLine line(options.quiet);
    batch::BatchOptions batch = make_batch_options(options);
    batch.progress = [&line](const batch::BatchProgress& progress) { line.draw(format_progress(progress)); };
    outcome = run_batch(plan, batch);
  }
  print_reused_cases(outcome, options);
  return shard ? report_shard(outcome, options) : report(plan, std::move(outcome), options);
}

}  // namespace

Command setup_batch(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("batch", "Run many cases, compare them, check requirements");
  const auto options = std::make_shared<BatchCommandOptions>();
  add_batch_options(*parser, *options);
  parser->footer(
      "Runs the cases of a suite, which docs/suite.md describes, and writes into a folder: one HDF5 file\n"
      "per case, summary.json, summary.csv, summary.md and junit.xml. Every case runs in a process of its\n"
      "own: one that fails, crashes or exceeds --case-timeout or --case-memory does not stop the others.\n"
      "An interrupted batch continues where it stopped and repeats nothing; a failed case is retried if\n"
      "something it depends on has changed, or with --retry-failed.\n\n"
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

namespace {

/// Splits a number ≥ 0 from the text that follows it. @throws UsageError
std::pair<double, std::string> split_number(const std::string& text, const std::string& error_message) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || !std::isfinite(number) || number < 0) throw UsageError(error_message);
  return {number, std::string(rest, end)};
}

double parse_seconds(const std::string& text) {
  const std::string error_message =
      "--case-timeout needs seconds, such as 60, or 0 for none, not " + quote_for_message(text);
  const auto [number, unit] = split_number(text, error_message);
  for (const auto& [name, seconds] : {std::pair("", 1.0), {"s", 1.0}, {"min", 60.0}, {"h", 3600.0}})
    if (unit == name && number * seconds <= trajectory::max_duration) return number * seconds;
  throw UsageError(error_message);
}

constexpr double min_case_memory = 16;  // MiB: used by a process before it reads its spec

std::uintmax_t parse_bytes(const std::string& text) {
  const std::string error_message =
      "--case-memory needs MiB, such as 512, or a size such as 2GiB, or 0 for no limit, not " + quote_for_message(text);
  const auto [number, unit] = split_number(text, error_message);
  constexpr double kibibyte = 1024, mebibyte = kibibyte * kibibyte;
  for (const auto& [name, bytes] : {std::pair("", mebibyte),
                                    {"K", kibibyte},
                                    {"KiB", kibibyte},
                                    {"M", mebibyte},
                                    {"MiB", mebibyte},
                                    {"G", mebibyte * kibibyte},
                                    {"GiB", mebibyte * kibibyte},
                                    {"T", mebibyte * mebibyte},
                                    {"TiB", mebibyte * mebibyte},
                                    {"kB", 1e3},
                                    {"MB", 1e6},
                                    {"GB", 1e9},
                                    {"TB", 1e12}}) {
    if (unit != name) continue;
    if (number * bytes > 1e18) throw UsageError(error_message);
    if (number > 0 && number * bytes < min_case_memory * mebibyte)
      throw UsageError(fmt::format("--case-memory {}: expected at least {:g} MiB, which every case needs to start",
                                   quote_for_message(text), min_case_memory));
    return static_cast<std::uintmax_t>(number * bytes);
  }
  throw UsageError(error_message);
}

}  // namespace

void add_batch_options(CLI::App& parser, BatchCommandOptions& o) {
  suggest_files(parser.add_option("suite", o.suite, "the suite, a YAML file")->required()->type_name("SUITE"),
                {"yaml", "yml"});
  parser.add_option("-o,--output", o.output, "folder for results (default: SUITE's name with -results)")
      ->type_name("FOLDER");
  parser.add_option("-j,--jobs", o.jobs, "cases run at once (default: one per core)")
      ->type_name("N")
      ->check(integer_range_validator(1, 4096));
  parser.add_option("--shard", o.shard, "run only the i-th of n parts of the cases")->type_name("I/N");
  parser.add_option("--case-timeout", o.case_timeout, "time limit per case in seconds (default: 3600; 0: none)")
      ->type_name("SECONDS");
  parser
      .add_option("--case-memory", o.case_memory,
                  "memory limit per case in MiB, or such as 2GiB (default: the machine's memory divided by --jobs; "
                  "0: none)")
      ->type_name("SIZE");
  parser.add_flag("--metrics-only", o.metrics_only, "write only metrics and summaries, no HDF5 files");
  parser.add_flag("--retry-failed", o.retry_failed, "run failed cases again even if nothing has changed");
  parser.add_flag("--merge", o.merge, "run nothing; summarise the results of the shards");
  parser.add_flag("--list", o.list, "run nothing; print the names of the cases (--json: also files)");
  parser.add_flag("--force", o.force, "use a folder with other contents; overwrite files of the same names");
  parser.add_flag("--json", o.json, "print JSON, errors included");
  parser.add_flag("-q,--quiet", o.quiet, "print only errors (and JSON with --json)");
}

std::optional<batch::Shard> parse_shard(const std::string& text) {
  if (text.empty()) return std::nullopt;
  batch::Shard shard;
  const char* const end = text.data() + text.size();
  const auto [slash, index_error] = std::from_chars(text.data(), end, shard.index);
  const bool has_index = index_error == std::errc() && slash != end && *slash == '/';
  const auto [last, count_error] = has_index ? std::from_chars(slash + 1, end, shard.count) : std::from_chars_result{};
  if (!has_index || count_error != std::errc() || last != end || shard.index < 1 || shard.index > shard.count)
    throw UsageError("--shard needs i/n with 1 <= i <= n, such as 2/8, not '" + text + "'");
  return shard;
}

std::string choose_output_folder(const BatchCommandOptions& options) {
  if (!options.output.empty()) return options.output;
  if (options.suite == "-") throw UsageError("--output is needed for a suite from standard input");
  return std::filesystem::path(options.suite).stem().string() + "-results";
}

batch::BatchOptions make_batch_options(const BatchCommandOptions& options) {
  batch::BatchOptions batch;
  batch.folder = choose_output_folder(options);
  batch.jobs = options.jobs > 0 ? options.jobs : std::max(1U, std::thread::hardware_concurrency());
  batch.shard = parse_shard(options.shard);
  batch.force = options.force;
  if (!options.case_timeout.empty()) batch.limits.wall_seconds = parse_seconds(options.case_timeout);
  if (!options.case_memory.empty()) batch.limits.memory_bytes = parse_bytes(options.case_memory);
  batch.stored_output = options.metrics_only ? batch::StoredOutput::metrics_only : batch::StoredOutput::series;
  batch.retry_failed = options.retry_failed;
  return batch;
}

}  // namespace balance::app
