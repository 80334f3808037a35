#include "command.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "value_check.hpp"

#include "balance/base/plain_text.hpp"
#include "balance/import/export_masses.hpp"
#include "balance/import/source_files.hpp"
#include "balance/spec/text_file.hpp"
#include "balance/write/file_identity.hpp"
#include "balance/write/json_parts.hpp"
#include "balance/write/pending_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

namespace balance::app {
namespace {

struct ExportCall {
  SpecOptions spec;
  std::string urdf, mjcf, output, parts, base;
  ImportOptions options;
  bool force = false;

  const std::string& robot() const { return urdf.empty() ? mjcf : urdf; }
};

void check_call(const ExportCall& call) {
  if (call.urdf.empty() == call.mjcf.empty()) throw UsageError("expected --urdf FILE or --mjcf FILE");
  check_standard_output({call.output, call.parts}, call.spec.json, false);
  const std::vector<InputFile> inputs = {{call.spec.spec, "the spec"},
                                         {call.robot(), "what it is made from"},
                                         {call.options.loops, "what it is made from"}};
  for (const std::string& output : {call.output, call.parts}) check_output(output, "it", inputs, call.force);
  if (!call.parts.empty() && same_file(call.output, call.parts))
    throw UsageError("--output and --parts name the same file: " + call.output);
}

void keep_sources(const ExportCall& call, const Study& study, const std::string& robot) {
  std::vector<InputFile> inputs = inputs_of(study);
  for (std::string& file : files_named_by_robot(robot, shown_name(call.robot())))
    inputs.push_back({std::move(file), "a file that the mechanism names"});
  for (const std::string& output : {call.output, call.parts}) keep_inputs(output, "it", inputs);
}

void write_file(const std::string& path, const std::string& text, bool force) {
  if (path.empty()) return;
  PendingFile file(path, force ? Existing::replace : Existing::keep);
  file.write(text);
  file.commit();
}

ExitCode run(const ExportCall& call) {
  check_call(call);
  const Study study = read_study(call.spec);
  const std::string robot = read_text_file(call.robot(), "robot file");
  keep_sources(call, study, robot);
  const ExportedMasses exported = export_masses(study, robot, shown_name(call.robot()), call.options);
  for (const std::string& warning : study.warnings) tell("warning: " + warning);
  for (const std::string& note : exported.notes) tell("note: " + note);
  write_file(call.output, exported.text, call.force);
  write_file(call.parts, parts_csv(study.mechanism), call.force);
  if (call.spec.json) {
    print(dump({{"file", call.output},
                {"parts", call.parts.empty() ? Json() : Json(call.parts)},
                {"changed", exported.changed},
                {"notes", exported.notes}}));
    return ExitCode::done;
  }
  const std::string changed =
      exported.changed.empty() ? "nothing changes" : fmt::format("changed: {}", fmt::join(exported.changed, ", "));
  std::vector<std::string> files{call.output};
  if (!call.parts.empty()) files.push_back(call.parts);
  print_beside(files,
               changed + "\n" + written_line(call.output) + (call.parts.empty() ? "" : written_line(call.parts)));
  return ExitCode::done;
}

}  // namespace

Command setup_export(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("export", "Write a balanced spec's masses back into its URDF or MJCF");
  const auto call = std::make_shared<ExportCall>();
  add_spec_options(*parser, call->spec);
  parser->add_option("--urdf", call->urdf, "the URDF that the spec was imported from")->type_name("FILE");
  parser->add_option("--mjcf", call->mjcf, "the MJCF that it was imported from")->type_name("FILE");
  parser->add_option("--loops", call->options.loops, "its closures, as they were imported")->type_name("FILE");
  require_word(parser->add_option("--base", call->base, "fixed: as it was imported")->type_name("WORD"), {"fixed"});
  parser->add_option("-o,--output", call->output, "the file to write")->required()->type_name("FILE");
  parser->add_option("--parts", call->parts, "a CSV file of counterweights and discs")->type_name("FILE");
  parser->add_flag("--force", call->force, "replace files that exist");
  parser->footer(
      "Masses, centres of mass and inertias of the spec's bodies, with their counterweights, are written\n"
      "into the links or bodies that they are from, and nothing else of the file changes. Of those that are\n"
      "fixed to each other the first with an inertial takes what changed.\n\n"
      "Examples:\n"
      "  balance export balanced.yaml --urdf robot.urdf -o new.urdf\n"
      "  balance export balanced.yaml --urdf robot.urdf -o new.urdf --parts parts.csv\n"
      "  balance export balanced.yaml --mjcf robot.xml -o new.xml");
  return {parser, [call] {
            call->options.fixed_base = call->base == "fixed";
            return run(*call);
          }};
}

}  // namespace balance::app
