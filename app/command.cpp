#include "command.hpp"

#include "failure.hpp"

#include "balance/base/error.hpp"

#include <filesystem>
#include <string_view>

namespace balance::app {

void add_spec_options(CLI::App& parser, SpecOptions& options) {
  parser.add_option("spec", options.spec, "the mechanism, a YAML file")->required()->type_name("SPEC");
  parser.add_option("--set", options.set, "override a parameter of the spec; may be repeated")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);  // or it would swallow the spec's name
  parser.add_flag("--json", options.json, "print JSON, errors included");
}

ReadOptions read_options(const SpecOptions& options) {
  ReadOptions read;
  for (const std::string& text : options.set) {
    const std::size_t equals = text.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == text.size()) {
      throw UsageError("--set needs name=value, not '" + text + "'");
    }
    read.set.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return read;
}

Study read_study(const SpecOptions& options) { return read_space(options).start; }

DesignSpace read_space(const SpecOptions& options) {
  const ReadOptions read = read_options(options);
  try {
    return read_design_space_file(options.spec, read);
  } catch (const SpecError& error) {
    // The reader names the place of every mistake; one whose place is the command line is not the spec's.
    if (std::string_view(error.what()).starts_with("--set ")) throw UsageError(error.what());
    throw;
  }
}

bool same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code error;
  return fs::weakly_canonical(a, error) == fs::weakly_canonical(b, error);
}

}  // namespace balance::app
