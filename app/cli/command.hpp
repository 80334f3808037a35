#pragma once
/// Infrastructure shared by the commands. A command is first set up, which registers its options with the parser, and
/// then run with the parsed values.

#include "cli/failures.hpp"

#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/interface/specification/read_spec.hpp"

#include <CLI/CLI.hpp>

#include <functional>
#include <string>
#include <vector>

namespace balance::app {

struct Command {
  CLI::App* parser = nullptr;  ///< records whether the user called this command
  std::function<ExitCode()> run;
};

/// Options of every command that reads a spec.
struct SpecOptions {
  std::string spec;
  std::vector<std::string> overrides;  ///< `name=value`
  bool json = false;
  std::string units = "spec";  ///< of text: `spec` or `si`
  bool verbose = false;        ///< text also has lines that say that there is nothing
};

void add_spec_options(CLI::App& parser, SpecOptions& options);

/// `--units`, of commands that print numbers of one spec. @param value "spec" or "si"
void add_units_option(CLI::App& parser, std::string& value);

/// `--verbose`, of commands whose text leaves out what says nothing.
void add_verbose_flag(CLI::App& parser, bool& value);

/// Whether `--units` asks for the units of the spec.
bool has_spec_units(const std::string& value);

/// Units of the spec unless `--units si`; as wide as the terminal, at least and otherwise 80 columns.
files::TextOptions choose_text_options(const SpecOptions& options, const Study& study);

/// The same, with the units of the spec's numbers. Reads the text of the spec again.
files::TextOptions choose_design_text_options(const SpecOptions& options, const Study& study);

/// Reads the spec and applies the overrides. @throws UsageError for an override that is not of the form `name=value` or
/// does not match the spec; otherwise as read_spec_file
Study read_study(const SpecOptions& options);

/// The same, but keeps free numbers free.
DesignSpace read_space(const SpecOptions& options);

/// Parses only the overrides. @throws UsageError for one that is not of the form `name=value`
ReadOptions read_options(const SpecOptions& options);

/// All files that the spec is read from: itself, its tables and, recursively, its parts.
std::vector<files::InputFile> list_input_files(const Study& study);

/// @param output empty: none
/// @param what "the result", "the page"
/// @throws UsageError if the output would replace one of the inputs, under any path
void check_overwrites_no_input(const std::string& output, const std::string& what,
                               const std::vector<files::InputFile>& inputs);

/// What an output file holds.
enum class FileFormat { hdf5, csv, yaml, json, html, other };

/// Checks an output file before the computation. --force does not permit replacing an input.
/// @throws UsageError as check_overwrites_no_input, or if the file's suffix is that of another format; SystemError as
///   check_writable
void check_output(const std::string& output, const std::string& what, FileFormat format,
                  const std::vector<files::InputFile>& inputs, bool force);

/// Rejects conflicting uses of standard output: two files, a file and JSON, or binary data on a terminal.
/// @param files that will be written; empty names: none @throws UsageError
void check_standard_output(const std::vector<std::string>& files, bool json, bool binary);

Command setup_batch(CLI::App& program);
Command setup_check(CLI::App& program);
Command setup_compare(CLI::App& program);
Command setup_completion(CLI::App& program);
Command setup_conditions(CLI::App& program);
Command setup_control(CLI::App& program);
Command setup_design(CLI::App& program);
Command setup_equations(CLI::App& program);
Command setup_excite(CLI::App& program);
Command setup_export(CLI::App& program);
Command setup_identify(CLI::App& program);
Command setup_import(CLI::App& program);
Command setup_man(CLI::App& program);
Command setup_modes(CLI::App& program);
Command setup_new(CLI::App& program);
Command setup_plot(CLI::App& program);
Command setup_report(CLI::App& program);
Command setup_simulate(CLI::App& program);
Command setup_tolerance(CLI::App& program);

}  // namespace balance::app
