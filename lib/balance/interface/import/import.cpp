#include "balance/interface/import/import.hpp"

#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/foreign_readers.hpp"
#include "balance/interface/import/model_simplification.hpp"
#include "balance/interface/import/spec_writer.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance::foreign {

namespace {

/// Values of coordinates without motors, and of those with motors that are not at zero.
std::vector<AssemblyValue> list_initial_values(const Mechanism& mechanism, const std::vector<double>& start) {
  std::vector<AssemblyValue> values;
  for (std::size_t c = 0; c < start.size(); ++c) {
    const int coordinate = static_cast<int>(c);
    const bool is_follower = std::any_of(mechanism.couplings.begin(), mechanism.couplings.end(),
                                         [&](const Coupling& one) { return one.follower == coordinate; });
    const bool is_actuated =
        std::find(mechanism.actuators.begin(), mechanism.actuators.end(), coordinate) != mechanism.actuators.end();
    const bool is_zero = std::abs(start[c]) < 1e-9;
    if (!std::isfinite(start[c]) || is_follower || (is_actuated && is_zero)) continue;
    values.emplace_back(mechanism.coordinates[c].name, is_zero ? 0 : start[c]);
  }
  return values;
}

/// Closes the loops near the file's zero pose: with the motors at zero or, if that is
/// impossible, with all coordinates free.
void assemble(ImportResult& imported, Study study) {
  CheckReport report = check_mechanism(study);
  if (report.outcome.status != MotionStatus::done && !report.loops.empty() && !study.mechanism.actuators.empty()) {
    Study unactuated_study = study;
    unactuated_study.mechanism.actuators.clear();
    CheckReport unactuated_report = check_mechanism(unactuated_study);
    if (unactuated_report.outcome.status == MotionStatus::done) report = std::move(unactuated_report);
  }
  imported.bodies = report.bodies;
  imported.joints = report.joints;
  imported.loops = static_cast<int>(report.loops.size());
  imported.total_mass = report.total_mass;
  for (const int actuator : study.mechanism.actuators)
    imported.actuators.push_back(study.mechanism.coordinates[static_cast<std::size_t>(actuator)].name);
  if (report.outcome.status != MotionStatus::done) {
    imported.assembly_failure_reason = report.outcome.reason;
    return;
  }
  imported.degrees_of_freedom = report.degrees_of_freedom;
  if (!report.loops.empty()) imported.assembly = list_initial_values(study.mechanism, report.start);
}

/// The spec was generated here: its errors stem from numbers of the file that no spec can have.
Study read_generated_spec(const std::string& spec, const std::string& file) {
  try {
    return read_spec(spec, file);
  } catch (const SpecError& error) {
    const Diagnostic& diagnostic = error.diagnostics().front();
    const std::string location = diagnostic.place.key.empty() ? "" : diagnostic.place.key + ": ";
    throw SpecError(
        {.place = {file, 1, 1, ""}, .message = "it cannot be converted to a spec: " + location + diagnostic.message});
  }
}

}  // namespace

bool ImportResult::has_warnings() const {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& one) { return one.level == Severity::warning; });
}

ImportResult import_text(const std::string& text, const std::string& file, const ImportOptions& options) {
  ForeignModel robot = read_foreign_model(text, file);
  if (!options.loops.empty())
    read_gepetto_loops(specification::read_text_file(options.loops, "closures"),
                       specification::display_name(options.loops), robot);
  simplify_model(robot, options);

  ImportResult imported;
  imported.format = robot.format;
  imported.spec = generate_spec(robot, {}).text;
  assemble(imported, read_generated_spec(imported.spec, file));
  GeneratedSpec final_spec = generate_spec(robot, imported.assembly);
  imported.spec = std::move(final_spec.text);
  imported.renamed = std::move(final_spec.renamed);
  imported.findings = std::move(robot.findings);
  imported.ignored = std::move(robot.ignored);
  return imported;
}

ImportResult import_file(const std::string& path, const ImportOptions& options) {
  return import_text(specification::read_text_file(path, "mechanism"), specification::display_name(path), options);
}

}  // namespace balance::foreign
