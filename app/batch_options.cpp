#include "batch_options.hpp"

#include "failure.hpp"
#include "suggestion.hpp"
#include "value_check.hpp"

#include "balance/base/nearest.hpp"
#include "balance/motion/timing_bounds.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <thread>
#include <utility>

namespace balance::app {
namespace {

/// A number ≥ 0 and what stands behind it. @throws UsageError
std::pair<double, std::string> split_number(const std::string& text, const std::string& complaint) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, wrong] = std::from_chars(text.data(), end, number);
  if (wrong != std::errc() || !std::isfinite(number) || number < 0) throw UsageError(complaint);
  return {number, std::string(rest, end)};
}

double parse_seconds(const std::string& text) {
  const std::string complaint =
      "--case-timeout needs seconds, such as 60, or 0 for none, not " + quote_for_message(text);
  const auto [number, unit] = split_number(text, complaint);
  for (const auto& [name, seconds] : {std::pair("", 1.0), {"s", 1.0}, {"min", 60.0}, {"h", 3600.0}})
    if (unit == name && number * seconds <= max_duration) return number * seconds;
  throw UsageError(complaint);
}

constexpr double min_case_memory = 16;  // MiB: what a process has before it reads its spec

std::uintmax_t parse_bytes(const std::string& text) {
  const std::string complaint =
      "--case-memory needs MiB, such as 512, or a size such as 2GiB, or 0 for no limit, not " + quote_for_message(text);
  const auto [number, unit] = split_number(text, complaint);
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
    if (number * bytes > 1e18) throw UsageError(complaint);
    if (number > 0 && number * bytes < min_case_memory * mebibyte)
      throw UsageError(fmt::format("--case-memory {}: expected at least {:g} MiB, without which no case can begin",
                                   quote_for_message(text), min_case_memory));
    return static_cast<std::uintmax_t>(number * bytes);
  }
  throw UsageError(complaint);
}

}  // namespace

void add_batch_options(CLI::App& parser, BatchCommandOptions& o) {
  suggest_files(parser.add_option("suite", o.suite, "the suite, a YAML file")->required()->type_name("SUITE"),
                {"yaml", "yml"});
  parser.add_option("-o,--output", o.output, "folder for results; SUITE's name with -results if not given")
      ->type_name("FOLDER");
  parser.add_option("-j,--jobs", o.jobs, "cases computed at once; all cores if not given")
      ->type_name("N")
      ->check(integer_range_validator(1, 4096));
  parser.add_option("--shard", o.shard, "compute only the i-th of n parts of the cases")->type_name("I/N");
  parser.add_option("--case-timeout", o.case_timeout, "longest time of a case in seconds; 3600 if not given, 0: none")
      ->type_name("SECONDS");
  parser
      .add_option("--case-memory", o.case_memory,
                  "most memory of a case in MiB, or as 2GiB; the machine's, divided by the cases at once, if not "
                  "given, 0: no limit")
      ->type_name("SIZE");
  parser.add_flag("--metrics-only", o.metrics_only, "keep no samples: no HDF5 files, only metrics and summaries");
  parser.add_flag("--retry-failed", o.retry_failed, "compute cases again that failed, although nothing has changed");
  parser.add_flag("--merge", o.merge, "compute nothing; summarise what shards have computed");
  parser.add_flag("--list", o.list, "compute nothing; print the cases' names, with --json the files too");
  parser.add_flag("--force", o.force, "use a folder that holds other things; files of the same names are replaced");
  parser.add_flag("--json", o.json, "print JSON, errors included");
  parser.add_flag("-q,--quiet", o.quiet, "print nothing but errors (and JSON if asked for)");
}

std::optional<Shard> parse_shard(const std::string& text) {
  if (text.empty()) return std::nullopt;
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto [slash, wrong] = std::from_chars(text.data(), end, shard.index);
  const bool first = wrong == std::errc() && slash != end && *slash == '/';
  const auto [last, wrong_too] = first ? std::from_chars(slash + 1, end, shard.count) : std::from_chars_result{};
  if (!first || wrong_too != std::errc() || last != end || shard.index < 1 || shard.index > shard.count)
    throw UsageError("--shard needs i/n with 1 <= i <= n, such as 2/8, not '" + text + "'");
  return shard;
}

std::string choose_output_folder(const BatchCommandOptions& options) {
  if (!options.output.empty()) return options.output;
  if (options.suite == "-") throw UsageError("--output is needed for a suite from standard input");
  return std::filesystem::path(options.suite).stem().string() + "-results";
}

BatchOptions make_batch_options(const BatchCommandOptions& options) {
  BatchOptions batch;
  batch.folder = choose_output_folder(options);
  batch.jobs = options.jobs > 0 ? options.jobs : std::max(1U, std::thread::hardware_concurrency());
  batch.shard = parse_shard(options.shard);
  batch.force = options.force;
  if (!options.case_timeout.empty()) batch.limits.wall_seconds = parse_seconds(options.case_timeout);
  if (!options.case_memory.empty()) batch.limits.memory_bytes = parse_bytes(options.case_memory);
  batch.stored_output = options.metrics_only ? StoredOutput::metrics_only : StoredOutput::series;
  batch.retry_failed = options.retry_failed;
  return batch;
}

}  // namespace balance::app
