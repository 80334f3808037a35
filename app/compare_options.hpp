#pragma once
/// What the user asks of `balance compare`.

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace balance::app {

enum class ComparisonFormat { text, markdown, csv, json, junit };

struct CompareOptions {
  std::vector<std::string> files;
  std::vector<std::string> requirements;
  std::string format;  ///< empty: by the output's ending, else text
  std::string output;  ///< empty: stdout
  bool json = false;
  bool all = false;
  bool force = false;
  bool quiet = false;
};

void add_compare_options(CLI::App& parser, CompareOptions& options);

/// @throws UsageError if options contradict each other
ComparisonFormat choose_format(const CompareOptions& options);

}  // namespace balance::app
