/// Parses, runs one command, translates exceptions to exit codes.

#include "command.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "signals.hpp"

#include "balance/base/error.hpp"
#include "balance/base/version.hpp"
#include "balance/read/nearest.hpp"
#include "balance/write/json.hpp"
#include "balance/write/pending_file.hpp"

#include <algorithm>
#include <new>
#include <sstream>

namespace balance::app {
namespace {

constexpr const char* footer =
    "Examples:\n"
    "  balance new 3rrr > 3rrr.yaml\n"
    "  balance check 3rrr.yaml\n"
    "  balance compare original.h5 balanced.h5 --require 'peak(shaking_force) <= 0.9 * base'\n"
    "  balance conditions 5r.yaml --goal static\n"
    "  balance control 5r.yaml --trajectory cycloid --controller computed-torque\n"
    "  balance design 5r.yaml -o balanced.yaml\n"
    "  balance report 3rrr.yaml -o 3rrr.html\n"
    "  balance simulate 3rrr.yaml --trajectory cycloid -o out.h5\n\n"
    "Exit codes: 0 done; 1 a requirement is not met or a design is only a compromise; 2 wrong usage;\n"
    "3 invalid spec; 4 the mechanism cannot do it; 5 file or system error.";

constexpr const char* usage_hint = "balance --help and balance <command> --help show the usage";

/// Says on stderr what went wrong, and on stdout too if the user reads JSON there.
ExitCode fail(ExitCode code, const std::string& message, const std::string& json) {
  tell(message);
  try {
    if (!json.empty()) print(json);
  } catch (const SystemError&) {
    return ExitCode::system;  // stderr has the message
  }
  return code;
}

/// --help and --version end the parsing too; everything else is a mistake.
ExitCode finish_parsing(const CLI::App& program, const CLI::ParseError& error) {
  std::ostringstream out, err;
  if (program.exit(error, out, err) != 0) throw CallError(error.what());
  print(out.str());
  return ExitCode::done;
}

/// @throws CallError: no command was called; `words` are those that the parser could not place
[[noreturn]] void fail_without_command(const std::vector<Command>& commands, const std::vector<std::string>& words) {
  std::vector<std::string> names;
  for (const Command& command : commands) {
    if (!command.parser->get_group().empty()) names.push_back(command.parser->get_name());  // not the hidden ones
  }
  if (words.empty()) throw CallError("a command is needed: " + read::one_of(names));
  if (words.front().starts_with('-')) {
    throw CallError(read::in_quotes(words.front()) + " must stand behind a command: " + read::one_of(names));
  }
  throw CallError(read::in_quotes(words.front()) + " is no command: " + read::one_of(names) +
                  read::nearest_hint(words.front(), names));
}

ExitCode parse_and_run(int argc, char** argv) {
  CLI::App program("balance: balancing conditions, torques and shaking forces of mechanisms", "balance");
  program.set_version_flag("--version", std::string("balance ") + version(), "Print the version and exit");
  program.footer(footer);
  const std::vector<Command> commands = {
      setup_batch(program),       //
      setup_check(program),       //
      setup_compare(program),     //
      setup_completion(program),  //
      setup_conditions(program),  //
      setup_control(program),     //
      setup_design(program),      //
      setup_man(program),         //
      setup_new(program),         //
      setup_plot(program),        //
      setup_report(program),      //
      setup_simulate(program),
  };
  program.require_subcommand(0, 1);
  program.allow_extras();  // after the commands, which would inherit it: only here can the message be a good one
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return finish_parsing(program, error);
  }
  const std::vector<std::string> words = program.remaining();
  for (const Command& command : commands) {
    if (command.parser->parsed() && words.empty()) return command.run();
  }
  fail_without_command(commands, words);
}

ExitCode translate(int argc, char** argv) {
  const bool json = std::find(argv, argv + argc, std::string("--json")) != argv + argc;
  const auto failed = [&](ExitCode code, const char* kind, const std::string& shown, const std::string& message) {
    return fail(code, shown, json ? error_json(kind, message) : "");
  };
  try {
    return parse_and_run(argc, argv);
  } catch (const CallError& error) {
    return failed(ExitCode::usage, "usage", std::string("error: ") + error.what() + "\n" + usage_hint, error.what());
  } catch (const UsageError& error) {
    return failed(ExitCode::usage, "usage", std::string("error: ") + error.what(), error.what());
  } catch (const SpecError& error) {
    // Begins with file:line:column, which editors look for at the start of a line.
    return failed(ExitCode::spec, "spec", error.what(), error.what());
  } catch (const MotionFailure& error) {
    const std::string message = std::string("error: ") + error.what();
    return fail(ExitCode::mechanism, message, json ? error_json("mechanism", error.outcome) : "");
  } catch (const MechanismFailure& error) {
    const std::string message = std::string("error: ") + error.what();
    return fail(ExitCode::mechanism, message, json ? error_json("mechanism", error.what(), error.status) : "");
  } catch (const SystemError& error) {
    return failed(ExitCode::system, "system", std::string("error: ") + error.what(), error.what());
  } catch (const Cancelled& error) {
    tell(error.what());
    return static_cast<ExitCode>(static_cast<int>(ExitCode::signal) + pending_signal());
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
