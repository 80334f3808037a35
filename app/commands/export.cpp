#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/validators.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/import/foreign_readers.hpp"
#include "balance/interface/import/mass_export.hpp"
#include "balance/interface/import/robot_export.hpp"
#include "balance/interface/specification/text_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

namespace balance::app {
namespace {

struct ExportOptions {
  SpecOptions spec;
  std::string urdf, mjcf, output, parts, base, format, trajectory;
  foreign::ImportOptions options;
  bool force = false, strict = false;

  /// Whether masses go back into a file that the spec was imported from.
  bool is_written_back() const { return !urdf.empty() || !mjcf.empty(); }

  const std::string& robot() const { return urdf.empty() ? mjcf : urdf; }
};

void check_call(const ExportOptions& call) {
  if (!call.urdf.empty() && !call.mjcf.empty()) throw UsageError("expected either --urdf FILE or --mjcf FILE");
  const auto refuse = [](bool is_given, const char* option, const char* other) {
    if (is_given) throw UsageError(std::string(option) + " goes only " + other);
  };
  const bool is_back = call.is_written_back();
  refuse(is_back && !call.format.empty(), "--format", "without --urdf and --mjcf");
  refuse(is_back && !call.trajectory.empty(), "--trajectory", "without --urdf and --mjcf");
  refuse(is_back && call.strict, "--strict", "without --urdf and --mjcf");
  refuse(!is_back && !call.options.loops.empty(), "--loops", "with --urdf or --mjcf");
  refuse(!is_back && !call.base.empty(), "--base", "with --urdf or --mjcf");
  check_standard_output({call.output, call.parts}, call.spec.json, false);
  const std::vector<files::InputFile> inputs = {
      {call.spec.spec, "the spec"}, {call.robot(), "its input"}, {call.options.loops, "its input"}};
  for (const std::string& output : {call.output, call.parts})
    check_output(output, "the output", FileFormat::other, inputs, call.force);
  if (!call.parts.empty() && files::is_same_file(call.output, call.parts))
    throw UsageError("--output and --parts name the same file: " + call.output);
}

/// @param robot text of the file that the spec was imported from; empty: none
void check_overwrites_no_source(const ExportOptions& call, const Study& study, const std::string& robot) {
  std::vector<files::InputFile> inputs = list_input_files(study);
  if (call.is_written_back())
    for (std::string& file : foreign::list_referenced_robot_files(robot, specification::display_name(call.robot())))
      inputs.push_back({std::move(file), "a file that the mechanism refers to"});
  for (const std::string& output : {call.output, call.parts}) check_overwrites_no_input(output, "the output", inputs);
}

void write_file(const std::string& path, const std::string& text, bool force) {
  if (path.empty()) return;
  files::AtomicFile file(path, force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid);
  file.write(text);
  file.commit();
}

/// That of `--format`, or of the output's name.
foreign::RobotFormat choose_format(const ExportOptions& call) {
  try {
    return foreign::choose_robot_format(call.format, call.output);
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--format: ") + error.what());
  }
}

ExitCode run_whole(const ExportOptions& call) {
  const foreign::RobotFormat format = choose_format(call);
  const Study study = read_study(call.spec);
  check_overwrites_no_source(call, study, "");
  const foreign::RobotExport exported = foreign::export_robot(study, format, call.trajectory);
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  for (const std::string& note : exported.notes) print_message("note: " + note);
  for (const std::string& what : exported.missing) print_message("warning: not in the file: " + what);
  write_file(call.output, exported.text, call.force);
  write_file(call.parts, foreign::format_balancing_elements_csv(study.mechanism), call.force);
  const ExitCode code = call.strict && !exported.missing.empty() ? ExitCode::not_met : ExitCode::done;
  if (call.spec.json) {
    print(files::format_json({{"file", call.output},
                              {"format", foreign::name_of(format)},
                              {"parts", call.parts.empty() ? Json() : Json(call.parts)},
                              {"notes", exported.notes},
                              {"missing", exported.missing}}));
    return code;
  }
  std::vector<std::string> files{call.output};
  if (!call.parts.empty()) files.push_back(call.parts);
  print_status(files,
               format_written_message(call.output) + (call.parts.empty() ? "" : format_written_message(call.parts)));
  return code;
}

ExitCode run(const ExportOptions& call) {
  check_call(call);
  if (!call.is_written_back()) return run_whole(call);
  const Study study = read_study(call.spec);
  const std::string robot = specification::read_text_file(call.robot(), "robot file");
  check_overwrites_no_source(call, study, robot);
  const foreign::MassExport exported =
      export_masses(study, robot, specification::display_name(call.robot()), call.options);
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  for (const std::string& note : exported.notes) print_message("note: " + note);
  write_file(call.output, exported.text, call.force);
  write_file(call.parts, foreign::format_balancing_elements_csv(study.mechanism), call.force);
  if (call.spec.json) {
    print(files::format_json({{"file", call.output},
                              {"parts", call.parts.empty() ? Json() : Json(call.parts)},
                              {"changed", exported.changed},
                              {"notes", exported.notes}}));
    return ExitCode::done;
  }
  const std::string changed =
      exported.changed.empty() ? "nothing changes" : fmt::format("changed: {}", fmt::join(exported.changed, ", "));
  std::vector<std::string> files{call.output};
  if (!call.parts.empty()) files.push_back(call.parts);
  print_status(files, changed + "\n" + format_written_message(call.output) +
                          (call.parts.empty() ? "" : format_written_message(call.parts)));
  return ExitCode::done;
}

}  // namespace

Command setup_export(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("export", "Write a mechanism for simulators: MJCF, SDF, URDF");
  const auto call = std::make_shared<ExportOptions>();
  add_spec_options(*parser, call->spec);
  parser->add_option("-o,--output", call->output, "the file to write")->required()->type_name("FILE");
  add_choice_validator(
      parser->add_option("--format", call->format, "its format, if its name does not tell: mjcf, sdf or urdf")
          ->type_name("WORD"),
      {"mjcf", "sdf", "urdf"});
  parser->add_option("-t,--trajectory", call->trajectory, "whose start is the start pose; default: the first one")
      ->type_name("NAME");
  parser->add_flag("--strict", call->strict, "exit code 1 if the format cannot express something");
  parser->add_option("--urdf", call->urdf, "write masses back into this URDF, which the spec was imported from")
      ->type_name("FILE");
  parser->add_option("--mjcf", call->mjcf, "write masses back into this MJCF, which the spec was imported from")
      ->type_name("FILE");
  parser->add_option("--loops", call->options.loops, "loop closures, as in the import")->type_name("FILE");
  add_choice_validator(
      parser->add_option("--base", call->base, "fixed, if the import had --base fixed")->type_name("WORD"), {"fixed"});
  parser->add_option("--parts", call->parts, "write counterweights and discs to this CSV file")->type_name("FILE");
  parser->add_flag("--force", call->force, "overwrite existing files");
  parser->footer(
      "MJCF (.xml, .mjcf) has everything but loads and tables: loops, gears and discs are equality\n"
      "constraints, qpos are the spec's coordinates. SDF (.sdf, .world) and URDF (.urdf) have the tree;\n"
      "comments name the joints that close loops. What a format lacks is listed.\n\n"
      "With --urdf or --mjcf, masses, centres of mass and inertias of the spec's bodies, with their\n"
      "counterweights, go into the links or bodies that they come from; nothing else changes.\n\n"
      "Examples:\n"
      "  balance export configs/5r-balanced.yaml -o five-bar.xml\n"
      "  balance export balanced.yaml --urdf robot.urdf -o new.urdf --parts parts.csv\n"
      "  balance export balanced.yaml --mjcf robot.xml -o new.xml");
  return {parser, [call] {
            call->options.fixed_base = call->base == "fixed";
            return run(*call);
          }};
}

}  // namespace balance::app
