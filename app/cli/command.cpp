#include "cli/command.hpp"

#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/validators.hpp"

#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/specification/include_expansion.hpp"

#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace balance::app {

void add_spec_options(CLI::App& parser, SpecOptions& options) {
  parser.add_option("spec", options.spec, "the mechanism, a YAML file")->required()->type_name("SPEC");
  parser.add_option("--set", options.overrides, "override a parameter of the spec; may be repeated")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);  // otherwise it would consume the name of the spec
  parser.add_flag("--json", options.json, "print JSON, errors included");
}

void add_units_option(CLI::App& parser, std::string& value) {
  add_choice_validator(parser.add_option("--units", value, "units of numbers: spec, those of the spec, or si")
                           ->type_name("NAME")
                           ->capture_default_str(),
                       {"spec", "si"});
}

void add_verbose_flag(CLI::App& parser, bool& value) {
  parser.add_flag("--verbose", value, "also print what is zero, or what there is none of");
}

bool has_spec_units(const std::string& value) { return value == "spec"; }

files::TextOptions choose_text_options(const SpecOptions& options, const Study& study) {
  files::TextOptions text =
      has_spec_units(options.units) ? files::make_text_options(study.spec_text) : files::TextOptions();
  text.width = text_width();
  text.verbose = options.verbose;
  return text;
}

files::TextOptions choose_design_text_options(const SpecOptions& options, const Study& study) {
  files::TextOptions text = choose_text_options(options, study);
  text.number_units = specification::list_number_units(study);
  return text;
}

ReadOptions read_options(const SpecOptions& options) {
  ReadOptions read;
  for (const std::string& text : options.overrides) {
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
  return read_design_space_file(options.spec, read_options(options));
}

void check_standard_output(const std::vector<std::string>& files, bool json, bool binary) {
  const auto stdout_count = std::count(files.begin(), files.end(), files::standard_output_path);
  if (stdout_count == 0) return;
  if (stdout_count > 1) throw UsageError("two files cannot both go to standard output");
  if (json) throw UsageError("--json uses standard output, so no file can be written to -");
  if (binary && ::isatty(STDOUT_FILENO) == 1)
    throw UsageError("standard output is a terminal, which cannot show HDF5; redirect it to a file or a program");
}

std::vector<files::InputFile> list_input_files(const Study& study) {
  std::vector<files::InputFile> inputs = {{study.spec_file, "the spec"}};
  for (const std::string& file : specification::list_spec_files(study.spec_text, study.spec_file))
    if (file != study.spec_file) inputs.push_back({file, "a table or a part of the spec"});
  return inputs;
}

void check_overwrites_no_input(const std::string& output, const std::string& what,
                               const std::vector<files::InputFile>& inputs) {
  if (const files::InputFile* replaced = find_replaced_input(output, inputs))
    throw UsageError(fmt::format("{} would replace {}: {}", what, replaced->description, replaced->path));
}

namespace {

struct FormatSuffixes {
  FileFormat format;
  const char* name;
  std::vector<std::string> suffixes;  ///< the usual one first
};

const std::vector<FormatSuffixes>& list_format_suffixes() {
  static const std::vector<FormatSuffixes> formats = {
      {FileFormat::hdf5, "an HDF5 file", {".h5", ".hdf5", ".hdf", ".nc"}},
      {FileFormat::csv, "a CSV file", {".csv", ".tsv"}},
      {FileFormat::yaml, "a YAML file", {".yaml", ".yml"}},
      {FileFormat::json, "a JSON file", {".json"}},
      {FileFormat::html, "an HTML page", {".html", ".htm"}},
      {FileFormat::other, "a picture", {".svg", ".pdf", ".png"}}};
  return formats;
}

/// The suffix of another format would mislead people and programs, and is often a slip that replaces another file.
void check_suffix(const std::string& output, const std::string& what, FileFormat format) {
  if (format == FileFormat::other) return;
  const auto& formats = list_format_suffixes();
  const std::string suffix = CLI::detail::to_lower(std::filesystem::path(output).extension().string());
  const auto own = std::find_if(formats.begin(), formats.end(), [&](const auto& one) { return one.format == format; });
  for (const FormatSuffixes& one : formats)
    if (one.format != format && std::find(one.suffixes.begin(), one.suffixes.end(), suffix) != one.suffixes.end())
      throw UsageError(fmt::format("{}: {} is {}, not {}: end its name in {}", output, what, own->name, one.name,
                                   own->suffixes.front()));
}

}  // namespace

void check_output(const std::string& output, const std::string& what, FileFormat format,
                  const std::vector<files::InputFile>& inputs, bool force) {
  if (output.empty()) return;
  check_overwrites_no_input(output, what, inputs);
  check_suffix(output, what, format);
  check_writable(output, force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid);
}

}  // namespace balance::app
