#include "balance/interface/files/provenance.hpp"

#include "balance/foundation/base/version.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <utility>

namespace balance {

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

std::string format_simulate_command(const Study& study, const SimulateCommand& call) {
  const bool controlled = !call.controller.empty();
  std::vector<std::string> words = {"balance", controlled ? "control" : "simulate", file_name_of(call.spec_file),
                                    "--trajectory", call.trajectory};
  if (controlled) words.insert(words.end(), {"--controller", call.controller});
  if (call.steps > 0) words.insert(words.end(), {"--steps", fmt::format("{}", call.steps)});
  if (call.settle > 0) words.insert(words.end(), {"--settle", fmt::format("{}", call.settle)});
  if (call.samples) words.insert(words.end(), {"--samples", std::to_string(*call.samples)});
  if (call.duration) words.insert(words.end(), {"--duration", fmt::format("{}", *call.duration)});
  if (!call.about.empty()) words.push_back("--about=" + call.about);
  append_overrides(words, study);
  if (call.formulation != "tree") words.insert(words.end(), {"--formulation", call.formulation});
  if (call.compress) words.push_back("--compress");
  if (call.poses) words.push_back("--poses");
  if (call.split) words.push_back("--split");
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

Provenance make_simulation_provenance(const Study& study, const Trajectory& trajectory, const SimulateCommand& call) {
  Provenance description = make_provenance(study, format_simulate_command(study, call));
  description.trajectory = trajectory.name;
  description.law = law_name(trajectory);
  description.drive = name_of(trajectory.drive);
  description.formulation = call.formulation;
  description.controller = call.controller;
  for (const Controller& controller : study.controllers)
    if (controller.name == call.controller) description.controller_type = controller_type_name(controller.type);
  return description;
}

Provenance describe_state(const Study& study, const StateCommand& call) {
  std::vector<std::string> words = {"balance", "simulate", file_name_of(call.spec_file), "--at=" + call.at};
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) words.push_back(std::string(option) + "=" + value);
  };
  add("--rates", call.rates);
  add("--accelerations", call.accelerations);
  add("--time", call.time == 0 ? "" : fmt::format("{}", call.time));
  add("--independent", fmt::format("{}", fmt::join(call.independent, ",")));
  add("--trajectory", call.trajectory);
  add("--about", call.about);
  append_overrides(words, study);
  if (call.compress) words.emplace_back("--compress");
  if (call.poses) words.emplace_back("--poses");
  Provenance description = make_provenance(study, join_command(std::move(words)));
  description.pose = call.at;
  return description;
}

}  // namespace balance
