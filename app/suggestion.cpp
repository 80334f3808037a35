#include "suggestion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string_view>

namespace balance::app {
namespace {

// A check that always passes carries the suggestion in its name, which no help text shows.
constexpr std::string_view words_mark = "suggest words:";
constexpr std::string_view files_mark = "suggest files:";

void attach(CLI::Option* option, std::string_view mark, const std::vector<std::string>& items) {
  const auto passes = [](std::string&) { return std::string(); };
  option->check(CLI::Validator(passes, "", fmt::format("{}{}", mark, fmt::join(items, ","))));
}

std::vector<std::string> split(std::string_view text) {
  std::vector<std::string> items;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    items.emplace_back(text.substr(0, comma));
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
  }
  return items;
}

std::optional<ValueCompletion> read(const CLI::Validator& check) {
  const std::string& name = check.get_name();
  if (name.starts_with(words_mark))
    return ValueCompletion{ValueCompletion::Kind::words, split(name.substr(words_mark.size()))};
  if (name.starts_with(files_mark))
    return ValueCompletion{ValueCompletion::Kind::files, split(name.substr(files_mark.size()))};
  return std::nullopt;
}

/// The option's checks one by one; CLI11 tells their number only by refusing the next.
std::optional<ValueCompletion> read_checks(CLI::Option& option) {
  for (int i = 0;; ++i) {
    try {
      if (auto found = read(*option.get_validator(i))) return found;
    } catch (const CLI::OptionNotFound&) {
      return std::nullopt;
    }
  }
}

}  // namespace

void suggest_words(CLI::Option* option, const std::vector<std::string>& words) { attach(option, words_mark, words); }

void suggest_files(CLI::Option* option, const std::vector<std::string>& suffixes) {
  attach(option, files_mark, suffixes);
}

ValueCompletion find_value_completion(CLI::Option& option) {
  if (const auto found = read_checks(option)) return *found;
  const std::string value = option.get_type_name();
  if (value.starts_with("SPEC")) return {ValueCompletion::Kind::files, {"yaml", "yml"}};
  if (value.starts_with("RESULT")) return {ValueCompletion::Kind::files, {"h5"}};
  if (value.starts_with("FILE")) return {ValueCompletion::Kind::files, {}};
  return {};
}

}  // namespace balance::app
