#include "cli/parse_errors.hpp"

#include "cli/failures.hpp"
#include "cli/help.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace balance::app {
namespace {

std::vector<std::string> list_option_names(CLI::App& command) {
  std::vector<std::string> names;
  for (CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string format_operands(CLI::App& command) {
  std::vector<std::string> operands;
  for (CLI::Option* option : command.get_options())
    if (option->get_positional()) operands.push_back(value_name(*option));
  return operands.empty() ? "no argument" : fmt::format("{}", fmt::join(operands, " "));
}

std::string describe_extra_argument(CLI::App& command, const std::vector<std::string>& words) {
  const std::string name = qualified_command_name(command);
  for (const std::string& word : words) {
    if (const std::string suggestion = suggest_option(word); !suggestion.empty()) return word + ": " + suggestion;
    if (word.size() < 2 || word.front() != '-') continue;
    const std::string option = word.substr(0, word.find('='));
    return fmt::format("{} has no option {}{}", name, quote_for_message(option),
                       append_nearest_name(option, list_option_names(command)));
  }
  return fmt::format("unexpected argument {}: {} takes {}", quote_for_message(words.front()), name,
                     format_operands(command));
}

/// Whether a file is a suite rather than a spec: one of its lines begins with a top-level key of suites.
bool is_suite_file(const std::filesystem::path& path) {
  constexpr std::streamsize max_inspected_bytes = 65536;
  std::string text(max_inspected_bytes, '\0');
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), max_inspected_bytes);
  text.resize(static_cast<std::size_t>(file.gcount()));
  text.insert(0, "\n");
  return text.find("\ncases:") != std::string::npos || text.find("\nmatrix:") != std::string::npos;
}

/// The files in the current directory that the operand could mean; empty if there are too many.
std::vector<std::string> list_candidate_files(CLI::Option& operand) {
  constexpr std::size_t max_listed_files = 6;
  const ValueCompletion suggestion = find_value_completion(operand);
  std::vector<std::string> files;
  std::error_code error;
  const bool is_suite_wanted = value_name(operand) == "SUITE",
             among_yaml = is_suite_wanted || value_name(operand) == "SPEC";
  for (std::filesystem::directory_iterator at(".", error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string(), suffix = at->path().extension().string();
    const auto& suffixes = suggestion.items;
    if (!suffix.empty() && std::find(suffixes.begin(), suffixes.end(), suffix.substr(1)) != suffixes.end() &&
        (!among_yaml || is_suite_file(at->path()) == is_suite_wanted))
      files.push_back(name);
  }
  std::sort(files.begin(), files.end());
  if (files.size() > max_listed_files) files.clear();
  return files;
}

std::string describe_missing_argument(CLI::App& command, CLI::Option& option) {
  if (!option.get_positional())
    return fmt::format("{} needs {} {}: {}", qualified_command_name(command), option.get_name(), value_name(option),
                       option.get_description());
  std::string what = value_name(option);
  std::transform(what.begin(), what.end(), what.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::vector<std::string> files = list_candidate_files(option);
  const std::string needed = fmt::format("{} needs {}", qualified_command_name(command), option.get_description());
  if (files.empty()) return fmt::format("no {} given: {}", what, needed);
  return fmt::format("no {} given; this folder contains {}", what,
                     escape_for_terminal(fmt::format("{}", fmt::join(files, ", "))));
}

/// Describes options that exclude each other, or an option without another that it requires; empty if there is no
/// conflict.
std::string describe_option_conflict(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    for (const CLI::Option* other : option->get_excludes())
      if (other->count() > 0) return fmt::format("{} and {} cannot be combined", option->get_name(), other->get_name());
    for (const CLI::Option* other : option->get_needs())
      if (other->count() == 0) return fmt::format("{} needs {}", option->get_name(), other->get_name());
  }
  return "";
}

/// The option whose name follows `before` at the start of the parser's message; nullptr if there is none.
CLI::Option* find_option_in_message(CLI::App& command, const std::string& message, std::string_view before) {
  if (!message.starts_with(before)) return nullptr;
  CLI::Option* longest = nullptr;
  for (CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (name.empty() || message.compare(before.size(), name.size(), name) != 0) continue;
    if (longest == nullptr || name.size() > longest->get_name().size()) longest = option;
  }
  return longest;
}

std::string describe_value_error(CLI::Option& option, const CLI::ParseError& error) {
  const std::string name = option.get_name(), message = error.what();
  if (option.get_items_expected_max() == 0) return name + " takes no value";
  if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr) {
    const std::string value = option.results().empty() ? "" : option.results().back();
    return fmt::format("{}: expected a number, found {}{}", name, quote_for_message(value),
                       format_decimal_point_hint(value));
  }
  if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr) return message;  // from one of our own validators
  if (option.count() > 1) return name + " is given more than once";
  return fmt::format("{} needs a value: {}", name, value_name(option));
}

}  // namespace

std::string qualified_command_name(const CLI::App& command) {
  return command.get_parent() == nullptr ? "balance" : "balance " + command.get_name();
}

std::string suggest_option(const std::string& word) {
  if (word == "--verbose" || word == "-v") return "no such option; --quiet (-q) prints less, --json prints more";
  return "";
}

std::string describe_parse_error(CLI::App& command, const CLI::ParseError& error) {
  if (const std::vector<std::string> words = command.remaining(); !words.empty())
    return describe_extra_argument(command, words);
  const bool about_value = dynamic_cast<const CLI::ConversionError*>(&error) != nullptr ||
                           dynamic_cast<const CLI::ValidationError*>(&error) != nullptr ||
                           dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr;
  if (about_value)
    for (const char* before : {"", "Could not convert: "})
      if (CLI::Option* option = find_option_in_message(command, error.what(), before))
        return describe_value_error(*option, error);
  if (const std::string conflict = describe_option_conflict(command); !conflict.empty()) return conflict;
  for (CLI::Option* option : command.get_options())
    if (option->get_required() && option->count() == 0) return describe_missing_argument(command, *option);
  return error.what();
}

void check_names_not_empty(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    const std::string value = value_name(*option);
    if (value != "FILE" && value != "FOLDER" && !option->get_positional()) continue;
    const std::vector<std::string>& given = option->results();
    if (std::find(given.begin(), given.end(), "") == given.end()) continue;
    throw SyntaxUsageError(fmt::format("{} needs {}, found ''",
                                       option->get_positional() ? qualified_command_name(command) : option->get_name(),
                                       option->get_positional() ? "the name of a " + value
                                       : value == "FOLDER"      ? "a folder's name"
                                                                : "a file's name"),
                           qualified_command_name(command) + " --help");
  }
}

}  // namespace balance::app
