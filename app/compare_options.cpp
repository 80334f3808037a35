#include "compare_options.hpp"

#include "failure.hpp"
#include "read_or_run.hpp"
#include "value_check.hpp"

#include <filesystem>

namespace balance::app {
namespace {

struct NamedFormat {
  const char* name;
  const char* ending;
  ComparisonFormat format;
};

constexpr NamedFormat formats[]{{"text", ".txt", ComparisonFormat::text},
                                {"markdown", ".md", ComparisonFormat::markdown},
                                {"csv", ".csv", ComparisonFormat::csv},
                                {"json", ".json", ComparisonFormat::json},
                                {"junit", ".xml", ComparisonFormat::junit}};

ComparisonFormat find_format(const CompareOptions& options) {
  const std::string ending = std::filesystem::path(options.output).extension().string();
  for (const NamedFormat& one : formats) {
    if (options.format.empty() ? ending == one.ending : options.format == one.name) return one.format;
  }
  return ComparisonFormat::text;
}

}  // namespace

void add_compare_options(CLI::App& parser, CompareOptions& o) {
  std::vector<std::string> names;
  for (const NamedFormat& one : formats) names.emplace_back(one.name);
  add_run_operands(parser, o.files)
      ->description(
          "result files, runs of design files (design.h5:after/cycloid) or specs (arm.yaml:cycloid), the base first");
  parser.add_option("--require", o.requirements, "what must hold; may be repeated")
      ->type_name("EXPR")
      ->allow_extra_args(false);
  CLI::Option* format =
      parser.add_option("--format", o.format, "how to write it; else by the output's ending, else text");
  add_choice_validator(format->type_name("FORMAT"), names);
  parser.add_flag("--json", o.json, "the same as --format json; errors too")->excludes(format);
  parser.add_option("-o,--output", o.output, "write to this file instead of the terminal")->type_name("FILE");
  parser.add_flag("--all", o.all, "show all quantities, every joint's reactions too (csv and json always do)");
  parser.add_flag("--force", o.force, "replace a file that exists");
  parser.add_flag("-q,--quiet", o.quiet, "with --output: print nothing but errors");
}

ComparisonFormat choose_format(const CompareOptions& options) {
  if (options.files.size() < 2)
    throw UsageError(
        "two runs at least are needed to compare, the base first: result files or specs (arm.yaml:cycloid)");
  const ComparisonFormat format = options.json ? ComparisonFormat::json : find_format(options);
  if (format == ComparisonFormat::junit && options.requirements.empty()) {
    throw UsageError("JUnit reports are on requirements: give at least one --require");
  }
  return format;
}

}  // namespace balance::app
