/// Hidden commands that print the files installed with the program: manual pages and shell completions.

#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/man_page.hpp"
#include "cli/shell_completion.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"

#include <fmt/format.h>

#include <memory>

namespace balance::app {
namespace {

struct ManOptions {
  std::string command, folder;
};

const CommandHelp& find(const ProgramHelp& help, const std::string& name) {
  std::vector<std::string> names;
  for (const CommandHelp& command : help.commands) {
    if (command.name == name) return command;
    names.push_back(command.name);
  }
  throw UsageError(fmt::format("{} is not a command: expected {}{}", quote_for_message(name), join_alternatives(names),
                               append_nearest_name(name, names)));
}

void write(const std::string& path, const std::string& text) {
  files::AtomicFile file(path, files::OverwritePolicy::replace);
  file.write(text);
  file.commit();
}

ExitCode run_man(const ManOptions& options, CLI::App& program) {
  const ProgramHelp help = describe_program(program);
  if (options.folder.empty()) {
    print(options.command.empty() ? man_page(help) : man_page(help, find(help, options.command)));
    return ExitCode::done;
  }
  write(options.folder + "/balance.1", man_page(help));
  for (const CommandHelp& command : help.commands)
    write(options.folder + "/balance-" + command.name + ".1", man_page(help, command));
  return ExitCode::done;
}

ExitCode run_completion(const std::string& shell, CLI::App& program) {
  const ProgramHelp help = describe_program(program);
  const std::vector<std::string> shells = {"bash", "fish", "zsh"};
  if (shell == "bash") {
    print(bash_completion(help));
  } else if (shell == "fish") {
    print(fish_completion(help));
  } else if (shell == "zsh") {
    print(zsh_completion(help));
  } else {
    throw UsageError(fmt::format("there is no completion for {}: expected {}{}", quote_for_message(shell),
                                 join_alternatives(shells), append_nearest_name(shell, shells)));
  }
  return ExitCode::done;
}

}  // namespace

Command setup_completion(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("completion", "Print a script that completes command lines in a shell");
  parser->group("");
  const auto shell = std::make_shared<std::string>();
  parser->add_option("shell", *shell, "bash, fish or zsh")->required()->type_name("SHELL");
  parser->footer("Examples:\n  eval \"$(balance completion bash)\"\n  balance completion zsh > ~/.zfunc/_balance");
  return {parser, [shell, &program] { return run_completion(*shell, program); }};
}

Command setup_man(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("man", "Print a manual page");
  parser->group("");
  const auto options = std::make_shared<ManOptions>();
  CLI::Option* command = parser->add_option("command", options->command, "command to document (default: the program)");
  command->type_name("COMMAND");
  parser->add_option("--all", options->folder, "write all pages into this folder")
      ->type_name("FOLDER")
      ->excludes(command);
  parser->footer("Examples:\n  balance man simulate | man -l -\n  balance man --all man1");
  return {parser, [options, &program] { return run_man(*options, program); }};
}

}  // namespace balance::app
