#include "call_mistake.hpp"

#include "failure.hpp"
#include "help_model.hpp"
#include "suggestion.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace balance::app {
namespace {

std::vector<std::string> option_names(CLI::App& command) {
  std::vector<std::string> names;
  for (CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string operands_text(CLI::App& command) {
  std::vector<std::string> operands;
  for (CLI::Option* option : command.get_options())
    if (option->get_positional()) operands.push_back(value_name(*option));
  return operands.empty() ? "no argument" : fmt::format("{}", fmt::join(operands, " "));
}

std::string unplaced_text(CLI::App& command, const std::vector<std::string>& words) {
  const std::string name = call_of(command);
  for (const std::string& word : words) {
    if (const std::string cure = cure_for(word); !cure.empty()) return word + ": " + cure;
    if (word.size() < 2 || word.front() != '-') continue;
    const std::string option = word.substr(0, word.find('='));
    return fmt::format("{} has no option {}{}", name, in_quotes(option), nearest_hint(option, option_names(command)));
  }
  return fmt::format("{} is one too many: {} takes {}", in_quotes(words.front()), name, operands_text(command));
}

/// Whether a file is a suite rather than a spec: a line of it begins with one of a suite's own keys.
bool is_suite(const std::filesystem::path& path) {
  constexpr std::streamsize looked_at = 65536;
  std::string text(looked_at, '\0');
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), looked_at);
  text.resize(static_cast<std::size_t>(file.gcount()));
  text.insert(0, "\n");
  return text.find("\ncases:") != std::string::npos || text.find("\nmatrix:") != std::string::npos;
}

/// The files in this folder that an operand may mean, if they are few.
std::vector<std::string> files_at_hand(CLI::Option& operand) {
  constexpr std::size_t max_listed = 6;
  const Suggestion suggestion = suggestion_of(operand);
  std::vector<std::string> found;
  std::error_code error;
  const bool wants_suite = value_name(operand) == "SUITE", among_yaml = wants_suite || value_name(operand) == "SPEC";
  for (std::filesystem::directory_iterator at(".", error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string(), suffix = at->path().extension().string();
    const auto& wanted = suggestion.items;
    if (!suffix.empty() && std::find(wanted.begin(), wanted.end(), suffix.substr(1)) != wanted.end() &&
        (!among_yaml || is_suite(at->path()) == wants_suite))
      found.push_back(name);
  }
  std::sort(found.begin(), found.end());
  if (found.size() > max_listed) found.clear();
  return found;
}

std::string missing_text(CLI::App& command, CLI::Option& option) {
  if (!option.get_positional())
    return fmt::format("{} needs {} {}: {}", call_of(command), option.get_name(), value_name(option),
                       option.get_description());
  std::string what = value_name(option);
  std::transform(what.begin(), what.end(), what.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::vector<std::string> files = files_at_hand(option);
  const std::string needed = fmt::format("{} needs {}", call_of(command), option.get_description());
  if (files.empty()) return fmt::format("which {}? {}", what, needed);
  return fmt::format("which {}? here {}: {}", what, files.size() == 1 ? "is" : "are",
                     visible(fmt::format("{}", fmt::join(files, ", "))));
}

/// Options that do not go together, or one that is there without the other that it needs; else empty.
std::string relation_text(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    for (const CLI::Option* other : option->get_excludes())
      if (other->count() > 0) return fmt::format("{} and {} do not go together", option->get_name(), other->get_name());
    for (const CLI::Option* other : option->get_needs())
      if (other->count() == 0) return fmt::format("{} needs {}", option->get_name(), other->get_name());
  }
  return "";
}

/// The option that the parser's message begins with, or names behind `before`.
CLI::Option* option_in(CLI::App& command, const std::string& message, std::string_view before) {
  if (!message.starts_with(before)) return nullptr;
  CLI::Option* longest = nullptr;
  for (CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (name.empty() || message.compare(before.size(), name.size(), name) != 0) continue;
    if (longest == nullptr || name.size() > longest->get_name().size()) longest = option;
  }
  return longest;
}

std::string value_text(CLI::Option& option, const CLI::ParseError& error) {
  const std::string name = option.get_name(), message = error.what();
  if (option.get_items_expected_max() == 0) return name + " takes no value";
  if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr) {
    const std::string found = option.results().empty() ? "" : option.results().back();
    return fmt::format("{}: expected a number, found {}{}", name, in_quotes(found), decimal_comma_hint(found));
  }
  if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr) return message;  // made by a check of ours
  if (option.count() > 1) return name + " is given more than once";
  return fmt::format("{} needs a value: {}", name, value_name(option));
}

}  // namespace

std::string call_of(const CLI::App& command) {
  return command.get_parent() == nullptr ? "balance" : "balance " + command.get_name();
}

std::string cure_for(const std::string& word) {
  if (word == "--verbose" || word == "-v")
    return "there is none; what matters is always said, --quiet (-q) says less and --json more";
  return "";
}

std::string describe_mistake(CLI::App& command, const CLI::ParseError& error) {
  if (const std::vector<std::string> words = command.remaining(); !words.empty()) return unplaced_text(command, words);
  const bool about_value = dynamic_cast<const CLI::ConversionError*>(&error) != nullptr ||
                           dynamic_cast<const CLI::ValidationError*>(&error) != nullptr ||
                           dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr;
  if (about_value)
    for (const char* before : {"", "Could not convert: "})
      if (CLI::Option* option = option_in(command, error.what(), before)) return value_text(*option, error);
  if (const std::string relation = relation_text(command); !relation.empty()) return relation;
  for (CLI::Option* option : command.get_options())
    if (option->get_required() && option->count() == 0) return missing_text(command, *option);
  return error.what();
}

void refuse_empty_names(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    const std::string value = value_name(*option);
    if (value != "FILE" && value != "FOLDER" && !option->get_positional()) continue;
    const std::vector<std::string>& given = option->results();
    if (std::find(given.begin(), given.end(), "") == given.end()) continue;
    throw CallError(
        fmt::format("{} needs {}, found ''", option->get_positional() ? call_of(command) : option->get_name(),
                    option->get_positional() ? "the name of a " + value
                    : value == "FOLDER"      ? "a folder's name"
                                             : "a file's name"),
        call_of(command) + " --help");
  }
}

}  // namespace balance::app
