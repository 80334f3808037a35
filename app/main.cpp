/// Parses the command line, runs one command and translates exceptions to exit codes.

#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/help.hpp"
#include "cli/parse_errors.hpp"
#include "cli/signals.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/base/version.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"

#include <algorithm>
#include <csignal>
#include <new>

namespace balance::app {
namespace {

constexpr const char* footer =
    "balance COMMAND --help shows a command's options and examples. A spec named - is read from "
    "standard input, an output file named - is written to standard output.\n\n"
    "Examples:\n"
    "  balance new 3rrr > 3rrr.yaml\n"
    "  balance simulate 3rrr.yaml --trajectory cycloid -o out.h5\n"
    "  balance compare a.h5 b.h5 --require 'peak(shaking_force) <= 0.9 * base'\n\n"
    "Exit codes: 0 done; 1 a requirement is not met or a design is only a compromise; 2 wrong usage;\n"
    "3 invalid spec; 4 the mechanism cannot do it; 5 file or system error.";

/// Reports an error on stderr, and also on stdout if the user reads JSON there.
ExitCode fail(ExitCode code, const std::string& message, const std::string& json) {
  print_message_lines(message);
  try {
    if (!json.empty()) print(json);
  } catch (const SystemError&) {
    return ExitCode::system;  // the message is already on stderr
  }
  return code;
}

/// --help and --version also end the parsing with an exception; every other one is a usage error.
ExitCode finish_parsing(CLI::App& program, const CLI::ParseError& error) {
  const std::vector<CLI::App*> called = program.get_subcommands();
  CLI::App& command = called.empty() ? program : *called.front();
  if (error.get_exit_code() != 0)
    throw SyntaxUsageError(describe_parse_error(command, error), qualified_command_name(command) + " --help");
  if (dynamic_cast<const CLI::CallForVersion*>(&error) != nullptr) {
    print(error.what() + std::string("\n"));
  } else {
    print(called.empty() ? help_text(describe_program(program), help_width())
                         : help_text(describe_command(command), help_width()));
  }
  return ExitCode::done;
}

/// Makes `balance`, `balance help` and `balance help design` synonyms of --help.
std::vector<std::string> list_arguments(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (words.empty()) return {"--help"};
  if (words.front() != "help") return words;
  words.erase(words.begin());
  words.push_back("--help");
  return words;
}

/// @throws SyntaxUsageError because no command was given; `words` are the words that the parser could not assign
[[noreturn]] void fail_without_command(const std::vector<Command>& commands, const std::vector<std::string>& words) {
  std::vector<std::string> names;
  for (const Command& command : commands) {
    if (!command.parser->get_group().empty()) names.push_back(command.parser->get_name());  // skip hidden ones
  }
  const std::string& word = words.front();
  if (const std::string suggestion = suggest_option(word); !suggestion.empty())
    throw SyntaxUsageError(word + ": " + suggestion);
  if (word.starts_with('-'))
    throw SyntaxUsageError("options come after a command, such as balance check; balance has no option " +
                           quote_for_message(word) + append_nearest_name(word, {"--help", "--version"}));
  throw SyntaxUsageError(quote_for_message(word) + " is not a command: expected " + join_alternatives(names) +
                         append_nearest_name(word, names));
}

/// Sets the heading under which the list of commands shows this one.
Command in_group(const char* purpose, Command command) {
  command.parser->group(purpose);
  return command;
}

ExitCode parse_and_run(int argc, char** argv) {
  CLI::App program("balance: balancing conditions, torques and shaking forces of mechanisms", "balance");
  program.set_version_flag("-V,--version", std::string("balance ") + version(), "Print the version and exit");
  program.footer(footer);
  const std::vector<Command> commands = {
      in_group("Describe", setup_new(program)),
      in_group("Describe", setup_check(program)),
      in_group("Describe", setup_import(program)),
      in_group("Describe", setup_equations(program)),
      in_group("Balance", setup_conditions(program)),
      in_group("Balance", setup_design(program)),
      in_group("Balance", setup_tolerance(program)),
      in_group("Balance", setup_excite(program)),
      in_group("Balance", setup_identify(program)),
      in_group("Move", setup_simulate(program)),
      in_group("Move", setup_control(program)),
      in_group("Move", setup_modes(program)),
      in_group("Compare", setup_compare(program)),
      in_group("Compare", setup_batch(program)),
      in_group("Show", setup_plot(program)),
      in_group("Show", setup_report(program)),
      in_group("Show", setup_export(program)),
      setup_completion(program),
      setup_man(program),
  };
  program.require_subcommand(0, 1);
  program.allow_extras();  // after the commands, which would inherit it; only here can a good message be composed
  std::vector<std::string> arguments = list_arguments(argc, argv);
  try {
    program.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));  // CLI11 reads them back to front
  } catch (const CLI::ParseError& error) {
    return finish_parsing(program, error);
  }
  const std::vector<std::string> words = program.remaining();
  for (const Command& command : commands) {
    if (!command.parser->parsed() || !words.empty()) continue;
    check_names_not_empty(*command.parser);
    return command.run();
  }
  fail_without_command(commands, words);
}

/// An error in an option is a usage error, not an error of the spec.
ExitCode fail_spec(const SpecError& error, bool json) {
  const bool option = error.diagnostics().front().place.is_option();
  // Errors of a spec begin with file:line:column, which editors look for at the start of a line.
  return fail(option ? ExitCode::usage : ExitCode::spec, (option ? "error: " : "") + std::string(error.what()),
              json ? files::format_error_json(option ? "usage" : "spec", error) : "");
}

ExitCode translate(int argc, char** argv) {
  const bool json = std::find(argv, argv + argc, std::string("--json")) != argv + argc;
  const auto failed = [&](ExitCode code, const char* kind, const std::string& shown, const std::string& message) {
    return fail(code, shown, json ? files::format_error_json(kind, message) : "");
  };
  try {
    return parse_and_run(argc, argv);
  } catch (const SyntaxUsageError& error) {
    return failed(ExitCode::usage, "usage",
                  "error: " + escape_for_terminal(error.what()) + "\n" + error.help + " shows the usage", error.what());
  } catch (const UsageError& error) {
    return failed(ExitCode::usage, "usage", "error: " + escape_for_terminal(error.what()), error.what());
  } catch (const study::UnknownNameError& error) {
    return failed(ExitCode::usage, "usage", "error: " + escape_for_terminal(error.what()), error.what());
  } catch (const SpecError& error) {
    return fail_spec(error, json);
  } catch (const MotionFailure& error) {
    return fail(ExitCode::mechanism, error.text(), json ? files::format_error_json("mechanism", error.outcome) : "");
  } catch (const MechanismFailure& error) {
    const std::string message = std::string("error: ") + error.what();
    return fail(ExitCode::mechanism, message,
                json ? files::format_error_json("mechanism", error.what(), error.status) : "");
  } catch (const kinematics::UnsolvableMechanism& error) {
    return fail(ExitCode::mechanism, std::string("error: ") + error.what(),
                json ? files::format_error_json("mechanism", error.outcome) : "");
  } catch (const DeadlineExceeded& error) {
    return fail(ExitCode::mechanism, std::string("error: ") + error.what(),
                json ? files::format_error_json("mechanism", error.what(), "stopped") : "");
  } catch (const SystemError& error) {
    return failed(ExitCode::system, "system", "error: " + escape_for_terminal(error.what()), error.what());
  } catch (const files::Cancelled& error) {
    print_message(error.what());
    // InterruptGuard has cleared a signal that it caught
    return static_cast<ExitCode>(static_cast<int>(ExitCode::signal) +
                                 (pending_signal() != 0 ? pending_signal() : SIGINT));
  } catch (const std::bad_alloc&) {
    return failed(ExitCode::system, "system", "error: out of memory", "out of memory");
  } catch (const std::exception& error) {
    return failed(ExitCode::system, "internal", std::string("internal error: ") + error.what(), error.what());
  }
}

}  // namespace
}  // namespace balance::app

int main(int argc, char** argv) {
  balance::app::reserve_standard_descriptors();
  balance::app::install_signal_handlers();
  return static_cast<int>(balance::app::translate(argc, argv));
}
