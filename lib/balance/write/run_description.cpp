#include "balance/write/run_description.hpp"

#include "balance/base/version.hpp"
#include "balance/write/names.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

namespace balance {

std::string shell_word(const std::string& text) {
  static constexpr const char* harmless = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
  if (!text.empty() && text.find_first_not_of(harmless) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

std::string simulate_command(const SimulateCall& call) {
  std::vector<std::string> words = {"balance", "simulate", std::filesystem::path(call.spec_file).filename().string(),
                                    "--trajectory", call.trajectory};
  if (call.samples) words.insert(words.end(), {"--samples", std::to_string(*call.samples)});
  if (call.duration) words.insert(words.end(), {"--duration", fmt::format("{}", *call.duration)});
  if (!call.about.empty()) words.push_back("--about=" + call.about);
  for (const std::string& set : call.set) words.insert(words.end(), {"--set", set});
  if (call.formulation != "tree") words.insert(words.end(), {"--formulation", call.formulation});
  if (call.compress) words.push_back("--compress");
  for (std::string& word : words) word = shell_word(word);
  return fmt::format("{}", fmt::join(words, " "));
}

FileDescription describe_simulation(const Study& study, const Trajectory& trajectory, const SimulateCall& call) {
  FileDescription description;
  description.title = study.mechanism.name;
  description.version = version();
  description.spec_text = study.spec_text;
  description.command_line = simulate_command(call);
  description.trajectory = trajectory.name;
  description.law = std::holds_alternative<TablePath>(trajectory.path) ? "table" : name_of(trajectory.law.kind);
  description.drive = name_of(trajectory.drive);
  description.formulation = call.formulation;
  return description;
}

}  // namespace balance
