#include "report_options.hpp"

#include "failure.hpp"
#include "value_check.hpp"

#include "balance/base/nearest.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/run_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

namespace balance::app {
namespace {

constexpr long max_report_samples = 20'000;  // a page with more is slow to open, and no chart is that wide

}  // namespace

void add_report_options(CLI::App& parser, ReportOptions& o) {
  add_spec_options(parser, o.spec);
  parser.add_option("-o,--output", o.output, "the page; the spec's name with .html if not given")->type_name("FILE");
  parser
      .add_option("-t,--trajectory", o.trajectories, "a trajectory to show; may be repeated; all of them if not given")
      ->type_name("NAME")
      ->allow_extra_args(false);
  parser.add_option("-c,--controller", o.controller, "run every trajectory under this controller")->type_name("NAME");
  add_goal_options(parser, o.goal);
  parser.add_option("--samples", o.samples, "samples of every trajectory, both ends included")
      ->type_name("N")
      ->check(integer_range_validator(2, max_report_samples));
  parser.add_flag("--force", o.force, "replace a file that exists");
  parser.add_flag("-q,--quiet", o.quiet, "print nothing but errors (and JSON if asked for)");
}

std::vector<std::string> choose_trajectories(const ReportOptions& options, const Study& study) {
  std::vector<std::string> names, chosen;
  for (const Trajectory& trajectory : study.trajectories) names.push_back(trajectory.name);
  for (const std::string& wish : options.trajectories) {
    if (std::find(names.begin(), names.end(), wish) == names.end())
      throw UsageError(fmt::format("{} has no trajectory {}, only {}{}", study.spec_file, quote_for_message(wish),
                                   fmt::join(names, ", "), append_nearest_name(wish, names)));
  }
  for (const std::string& name : names) {
    const auto& wishes = options.trajectories;
    if (wishes.empty() || std::find(wishes.begin(), wishes.end(), name) != wishes.end()) chosen.push_back(name);
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
  for (const std::string& set : o.spec.overrides) words.insert(words.end(), {"--set", set});
  for (std::string& word : words) word = quote_for_shell(word);
  return fmt::format("{}", fmt::join(words, " "));
}

}  // namespace balance::app
