#include "balance/interface/files/provenance.hpp"

#include "balance/foundation/base/version.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <utility>

namespace balance::files {

namespace {

std::string file_name_of(const std::string& path) { return std::filesystem::path(path).filename().string(); }

std::string quote_for_shell(const std::string& text) {
  static constexpr const char* unquoted_characters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
  if (!text.empty() && text.find_first_not_of(unquoted_characters) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

std::string format_simulate_command(const Study& study, const SimulateCommand& command) {
  const bool controlled = !command.controller.empty();
  std::vector<std::string> words = {"balance", controlled ? "control" : "simulate", file_name_of(command.spec_file),
                                    "--trajectory", command.trajectory};
  if (controlled) words.insert(words.end(), {"--controller", command.controller});
  if (command.steps > 0) words.insert(words.end(), {"--steps", fmt::format("{}", command.steps)});
  if (command.settle > 0) words.insert(words.end(), {"--settle", fmt::format("{}", command.settle)});
  if (command.samples) words.insert(words.end(), {"--samples", std::to_string(*command.samples)});
  if (command.duration) words.insert(words.end(), {"--duration", fmt::format("{}", *command.duration)});
  if (!command.about.empty()) words.push_back("--about=" + command.about);
  append_overrides(words, study);
  if (command.formulation != "tree") words.insert(words.end(), {"--formulation", command.formulation});
  if (command.compress) words.push_back("--compress");
  if (command.poses) words.push_back("--poses");
  if (command.orders) words.insert(words.end(), {"--orders", std::to_string(*command.orders)});
  if (command.fluctuation) words.insert(words.end(), {"--fluctuation", fmt::format("{}", *command.fluctuation)});
  if (command.split) words.push_back("--split");
  return join_command(std::move(words));
}

}  // namespace

std::string join_command(std::vector<std::string> words) {
  for (std::string& word : words) word = quote_for_shell(word);
  return fmt::format("{}", fmt::join(words, " "));
}

void append_overrides(std::vector<std::string>& words, const Study& study) {
  for (const auto& [name, value] : study.overrides) words.insert(words.end(), {"--set", name + "=" + value});
}

Provenance make_provenance(const Study& study, std::string command_line) {
  Provenance description;
  description.title = study.mechanism.name;
  description.version = version();
  description.spec_text = study.spec_text;
  description.command_line = std::move(command_line);
  description.overrides = study.overrides;
  return description;
}

Provenance make_simulation_provenance(const Study& study, const Trajectory& trajectory,
                                      const SimulateCommand& command) {
  Provenance description = make_provenance(study, format_simulate_command(study, command));
  description.trajectory = trajectory.name;
  description.law = law_name(trajectory);
  description.drive = drive_name(trajectory);
  description.formulation = command.formulation;
  description.controller = command.controller;
  if (const Controller* controller = find_by_name(study.controllers, command.controller))
    description.controller_type = controller_type_name(controller->type);
  return description;
}

Provenance describe_state(const Study& study, const StateCommand& command) {
  std::vector<std::string> words = {"balance", "simulate", file_name_of(command.spec_file), "--at=" + command.at};
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) words.push_back(std::string(option) + "=" + value);
  };
  add("--rates", command.rates);
  add("--accelerations", command.accelerations);
  add("--time", command.time == 0 ? "" : fmt::format("{}", command.time));
  add("--independent", fmt::format("{}", fmt::join(command.independent, ",")));
  add("--trajectory", command.trajectory);
  add("--about", command.about);
  append_overrides(words, study);
  if (command.compress) words.emplace_back("--compress");
  if (command.poses) words.emplace_back("--poses");
  Provenance description = make_provenance(study, join_command(std::move(words)));
  description.pose = command.at;
  return description;
}

}  // namespace balance::files
