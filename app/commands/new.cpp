#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/help.hpp"
#include "starters.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"

#include <fmt/format.h>

#include <memory>

namespace balance::app {
namespace {

struct NewOptions {
  std::string kind, output;
  bool json = false, force = false;
};

std::vector<std::string> kinds() {
  std::vector<std::string> names;
  for (const Starter& starter : starters()) names.emplace_back(starter.kind);
  return names;
}

const Starter& find(const std::string& kind) {
  for (const Starter& starter : starters())
    if (starter.kind == kind) return starter;
  throw UsageError(fmt::format("there is no starter {}: expected {}{}", quote_for_message(kind),
                               join_alternatives(kinds()), append_nearest_name(kind, kinds())));
}

std::string list_text() {
  std::string text;
  for (const Starter& starter : starters()) text += fmt::format("{:<13} {}\n", starter.kind, starter.summary());
  return text + "\nbalance new KIND -o spec.yaml writes one of them.\n";
}

std::string list_json() {
  Json list = Json::array();
  for (const Starter& starter : starters()) list.push_back({{"kind", starter.kind}, {"summary", starter.summary()}});
  return files::format_json({{"kinds", list}});
}

std::string starter_json(const Starter& starter) {
  return files::format_json({{"kind", starter.kind}, {"summary", starter.summary()}, {"spec", starter.text}});
}

ExitCode run(const NewOptions& options) {
  if (options.kind.empty()) {
    if (!options.output.empty()) throw UsageError("--output needs a KIND: " + join_alternatives(kinds()));
    print(options.json ? list_json() : list_text());
    return ExitCode::done;
  }
  const Starter& starter = find(options.kind);
  if (!options.output.empty() && options.output != files::standard_output_path) {
    check_output(options.output, "the spec", FileFormat::yaml, {}, options.force);
    files::AtomicFile file(options.output,
                           options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid);
    file.write(std::string(starter.text));
    file.commit();
    print_text(options.json ? files::format_json({{"kind", starter.kind}, {"files", {options.output}}})
                            : format_written_message(options.output));
    return ExitCode::done;
  }
  print(options.json ? starter_json(starter) : std::string(starter.text));
  return ExitCode::done;
}

}  // namespace

Command setup_new(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("new", "Write a commented spec to start from");
  const auto options = std::make_shared<NewOptions>();
  CLI::Option* kind = parser->add_option("kind", options->kind, "kind of mechanism; lists the kinds if omitted");
  suggest_words(kind->type_name("KIND"), kinds());
  parser->add_option("-o,--output", options->output, "write the spec to this file")->type_name("FILE");
  parser->add_flag("--force", options->force, "overwrite an existing file");
  parser->add_flag("--json", options->json, "print JSON, errors included");
  parser->footer(
      "The spec is complete: it can be checked, simulated and, where numbers are free, designed, and\n"
      "its comments say what to change. docs/spec.md describes the language.\n\n"
      "Examples:\n"
      "  balance new\n"
      "  balance new four-bar -o spec.yaml\n"
      "  balance new delta --json");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
