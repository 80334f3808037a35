#pragma once
/// What the commands share. A command is set up, which tells the parser its options, and then run with what was parsed.

#include "cli/failures.hpp"

#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/specification/read_spec.hpp"

#include <CLI/CLI.hpp>

#include <functional>
#include <string>
#include <vector>

namespace balance::app {

struct Command {
  CLI::App* parser = nullptr;  ///< knows whether the user called this command
  std::function<ExitCode()> run;
};

/// Options that every command on a spec has.
struct SpecOptions {
  std::string spec;
  std::vector<std::string> overrides;  ///< `name=value`
  bool json = false;
};

void add_spec_options(CLI::App& parser, SpecOptions& options);

/// Reads the spec with its overrides. @throws UsageError for an override that is not `name=value` or that the spec
/// has no place for; otherwise as read_spec_file
Study read_study(const SpecOptions& options);

/// The same with its free numbers still free.
DesignSpace read_space(const SpecOptions& options);

/// The overrides alone. @throws UsageError for one that is not `name=value`
ReadOptions read_options(const SpecOptions& options);

/// What a spec is read from: itself, its tables, its parts and theirs.
std::vector<InputFile> list_input_files(const Study& study);

/// @param output empty: none
/// @param what "the result", "the page"
/// @throws UsageError if the output would replace one of the inputs, by whatever path
void check_overwrites_no_input(const std::string& output, const std::string& what,
                               const std::vector<InputFile>& inputs);

/// Every output passes here before anything is computed. Inputs are kept with --force, too.
/// @throws UsageError as check_overwrites_no_input, SystemError as check_writable
void check_output(const std::string& output, const std::string& what, const std::vector<InputFile>& inputs, bool force);

/// Refuses more than standard output can take: two files, a file and JSON, or binary data on a terminal.
/// @param files to be written; empty names: none @throws UsageError
void check_standard_output(const std::vector<std::string>& files, bool json, bool binary);

Command setup_batch(CLI::App& program);
Command setup_check(CLI::App& program);
Command setup_compare(CLI::App& program);
Command setup_completion(CLI::App& program);
Command setup_conditions(CLI::App& program);
Command setup_control(CLI::App& program);
Command setup_design(CLI::App& program);
Command setup_equations(CLI::App& program);
Command setup_export(CLI::App& program);
Command setup_import(CLI::App& program);
Command setup_man(CLI::App& program);
Command setup_new(CLI::App& program);
Command setup_plot(CLI::App& program);
Command setup_report(CLI::App& program);
Command setup_simulate(CLI::App& program);
Command setup_tolerance(CLI::App& program);

}  // namespace balance::app
