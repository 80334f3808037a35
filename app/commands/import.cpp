#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/validators.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/import/foreign_readers.hpp"
#include "balance/interface/import/import.hpp"
#include "balance/interface/specification/text_file.hpp"

#include <fmt/format.h>

#include <memory>
#include <utility>

namespace balance::app {
namespace {

struct ImportCommandOptions {
  std::string file, output, base;
  foreign::ImportOptions options;
  bool strict = false, json = false, force = false;
};

Json findings_json(const foreign::ImportResult& imported) {
  Json list = Json::array();
  for (const foreign::Finding& one : imported.findings)
    list.push_back({{"level", one.level == foreign::Severity::warning ? "warning" : "note"},
                    {"code", one.code},
                    {"file", one.place.file},
                    {"line", one.place.line > 0 ? Json(one.place.line) : Json()},
                    {"subject", one.subject},
                    {"message", one.message}});
  return list;
}

std::string import_json(const foreign::ImportResult& imported, const std::string& output) {
  Json json{{"format", imported.format},
            {"bodies", imported.bodies},
            {"joints", imported.joints},
            {"loops", imported.loops},
            {"degrees_of_freedom", imported.degrees_of_freedom ? Json(*imported.degrees_of_freedom) : Json()},
            {"total_mass", imported.total_mass},
            {"actuators", imported.actuators}};
  Json assembly = Json::object(), ignored = Json::object(), renamed = Json::object();
  for (const auto& [name, value] : imported.assembly) assembly[name] = value;
  for (const auto& [what, count] : imported.ignored) ignored[what] = count;
  for (const auto& [before, after] : imported.renamed) renamed[before] = after;
  json["assembly"] = assembly;
  json["not_assembled"] = imported.assembly_failure_reason.empty() ? Json() : Json(imported.assembly_failure_reason);
  json["findings"] = findings_json(imported);
  json["ignored"] = ignored;
  json["renamed"] = renamed;
  json["file"] = output.empty() ? Json() : Json(output);
  json["spec"] = imported.spec;
  return files::format_json(json);
}

/// Report for people: all findings, then the outcome.
std::string report_text(const foreign::ImportResult& imported) {
  std::string text;
  for (const foreign::Finding& one : imported.findings) text += one.text() + "\n";
  std::string ignored, renamed, assembly;
  for (const auto& [what, count] : imported.ignored)
    ignored += (ignored.empty() ? "" : ", ") + what + (count == 1 ? "" : fmt::format(" ({})", count));
  for (const auto& [before, after] : imported.renamed)
    renamed += fmt::format("{}{} to {}", renamed.empty() ? "" : ", ", before, after);
  for (const auto& [name, value] : imported.assembly)
    assembly += fmt::format("{}{}: {:.6g}", assembly.empty() ? "" : ", ", name, value);
  if (!ignored.empty()) text += "left out: " + ignored + "\n";
  if (!renamed.empty()) text += "renamed: " + renamed + "\n";
  text += fmt::format("{}: {}, {}, {}; moving mass {:.9g} kg\n", imported.format,
                      count_noun(imported.bodies, "moving body", "moving bodies"),
                      count_noun(imported.joints, "joint", "joints"), count_noun(imported.loops, "loop", "loops"),
                      imported.total_mass);
  if (imported.degrees_of_freedom)
    text += fmt::format("{}, {}\n", count_noun(*imported.degrees_of_freedom, "degree of freedom", "degrees of freedom"),
                        count_noun(static_cast<int>(imported.actuators.size()), "actuator", "actuators"));
  if (!assembly.empty()) text += "assembled near the file's zero pose: {" + assembly + "}\n";
  if (!imported.assembly_failure_reason.empty())
    text += "warning: the mechanism could not be assembled: " + imported.assembly_failure_reason + "\n";
  return text;
}

void check_call(const ImportCommandOptions& call) {
  check_standard_output({call.output}, call.json, false);
  check_output(call.output, "the spec", FileFormat::yaml, {{call.file, "its input"}, {call.options.loops, "its input"}},
               call.force);
}

void check_overwrites_no_robot_file(const ImportCommandOptions& call, const std::string& text) {
  std::vector<files::InputFile> inputs;
  for (std::string& file : foreign::list_referenced_robot_files(text, specification::display_name(call.file)))
    inputs.push_back({std::move(file), "a file that the mechanism refers to"});
  check_overwrites_no_input(call.output, "the spec", inputs);
}

void write_spec(const ImportCommandOptions& call, const foreign::ImportResult& imported) {
  files::AtomicFile file(call.output, call.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid);
  file.write(imported.spec);
  file.commit();
}

ExitCode run(const ImportCommandOptions& call) {
  check_call(call);
  const std::string text = specification::read_text_file(call.file, "mechanism");
  check_overwrites_no_robot_file(call, text);
  const foreign::ImportResult imported = import_text(text, specification::display_name(call.file), call.options);
  const bool has_strict_failure = call.strict && (imported.has_warnings() || !imported.assembly_failure_reason.empty());
  const bool to_stdout = call.output.empty() || call.output == files::standard_output_path;
  if (!to_stdout) write_spec(call, imported);
  if (call.json) {
    print(import_json(imported, call.output));
  } else {
    const std::string report = report_text(imported);
    if (to_stdout) {
      print_message_lines(report.substr(0, report.size() - 1));
      print(imported.spec);
    } else {
      print_text(report + format_written_message(call.output));
    }
  }
  return has_strict_failure ? ExitCode::not_met : ExitCode::done;
}

}  // namespace

Command setup_import(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("import", "Make a spec from a URDF, MJCF, MBSE or Chrono file");
  const auto call = std::make_shared<ImportCommandOptions>();
  parser->add_option("file", call->file, "the mechanism: URDF or MJCF (XML), MBSE or Chrono (YAML)")
      ->required()
      ->type_name("FILE");
  parser->add_option("--loops", call->options.loops, "loop closures of a URDF: a YAML file with closed_loop and type")
      ->type_name("FILE");
  CLI::Option* base = parser->add_option("--base", call->base, "fixed: hold a floating base where it is");
  add_choice_validator(base->type_name("WORD"), {"fixed"});
  parser
      ->add_option("--actuate", call->options.actuate, "joints that have motors, named as in the file, comma-separated")
      ->delimiter(',')
      ->type_name("NAMES")
      ->allow_extra_args(false);
  parser->add_option("-o,--output", call->output, "the spec to write (default: standard output)")->type_name("FILE");
  parser->add_flag("--strict", call->strict, "exit code 1 if there are warnings");
  parser->add_flag("--force", call->force, "overwrite an existing file");
  parser->add_flag("--json", call->json, "print JSON, errors included");
  parser->footer(
      "Links that are fixed to each other become one body, closures become joints, names that a spec\n"
      "does not allow are changed and reported. Nothing is repaired: a physically impossible inertia is\n"
      "kept with as_given, and suspicious masses are reported with their line. Meshes, collisions and\n"
      "sensors are counted and left out.\n\n"
      "Loops are closed near the file's zero pose, and the resulting values are written to assembly.\n\n"
      "Examples:\n"
      "  balance import arm.urdf -o arm.yaml\n"
      "  balance import leg.urdf --loops leg.yaml --actuate hip,knee -o spec.yaml\n"
      "  balance import gripper.xml --strict --json");
  return {parser, [call] {
            call->options.fixed_base = call->base == "fixed";
            return run(*call);
          }};
}

}  // namespace balance::app
