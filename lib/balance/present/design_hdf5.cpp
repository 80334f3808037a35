#include "balance/present/design_hdf5.hpp"

#include "balance/motion/names.hpp"
#include "balance/present/names.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/result_group.hpp"

#include <algorithm>
#include <span>

namespace balance {
namespace {

using Dimension = Hdf5Writer::Dimension;
using Group = Hdf5Writer::Group;

constexpr Group root_group{};

std::span<const double> values_of(const VectorX& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

void add_scalar(Hdf5Writer& file, const char* name, const char* long_name, const std::string& units, double value) {
  file.add_variable(root_group, {name, long_name, units, {}, {}}, std::span(&value, 1));
}

void describe_design(Hdf5Writer& file, const DesignReportData& view) {
  const DesignOutcome& outcome = view.report.outcome;
  file.set_attribute(root_group, "formulation", "tree");
  file.set_attribute(root_group, "goal", join_goal_names(outcome.conditions.goals));
  file.set_attribute(root_group, "strategy", view.conditions.strategy);
  file.set_attribute(root_group, "status", name_of(outcome.status));
  file.set_attribute(root_group, "optimality", name_of(outcome.optimality));
  file.set_attribute(root_group, "tried", outcome.search_summary);
  file.set_attribute(root_group, "proved", outcome.is_proved_infeasible ? "yes" : "no");
  file.set_attribute(root_group, "method", name_of(outcome.method));
  file.set_attribute(root_group, "reason", outcome.reason);
  file.set_attribute(root_group, "proof", outcome.certificate ? outcome.certificate->statement : "");
  file.set_attribute(root_group, "objective", view.objective);
}

void add_numbers(Hdf5Writer& file, const DesignReport& report) {
  std::vector<std::string> paths;
  VectorX lower(report.before.size()), upper(report.before.size());
  for (std::size_t i = 0; i < report.free_numbers.size(); ++i) {
    paths.push_back(report.free_numbers[i].key_path);
    lower[static_cast<Eigen::Index>(i)] = report.free_numbers[i].lower;
    upper[static_cast<Eigen::Index>(i)] = report.free_numbers[i].upper;
  }
  const Dimension number = file.add_dimension(root_group, {"free_number", "key path in the spec", "1", {}, {}}, paths);
  const auto add = [&](const char* name, const char* long_name, const VectorX& values) {
    file.add_variable(root_group, {name, long_name, "mixed", {number}, {}}, values_of(values));
  };
  add("lower", "lower bound, SI; free parameters as written", lower);
  add("upper", "upper bound", upper);
  add("start", "value in the mechanism before, the spec's start values", report.before);
  add("value", "value in the designed mechanism", report.outcome.x);
}

void add_conditions(Hdf5Writer& file, const DesignReportData& view) {
  const Conditions& c = view.conditions.conditions;
  if (c.matrix.rows() == 0) return;
  std::vector<std::string> texts, names;
  for (int row = 0; row < static_cast<int>(c.matrix.rows()); ++row)
    texts.push_back(condition_text(c, row, view.conditions.names));
  for (const Parameter& p : c.parameters) names.push_back(p.name);
  const Dimension condition = file.add_dimension(root_group, {"condition", "what must vanish", "1", {}, {}}, texts);
  const Dimension parameter = file.add_dimension(root_group, {"parameter", "inertial parameter", "1", {}, {}}, names);
  const Samples matrix = c.matrix;
  file.add_variable(root_group,
                    {"condition_matrix",
                     "coefficients of the conditions at the designed geometry",
                     "mixed",
                     {condition, parameter},
                     {{"smallest_kept", {c.min_kept_singular_value}},
                      {"largest_dropped", {c.max_dropped_singular_value}},
                      {"gap", {c.singular_value_gap}}}},
                    std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
  const auto add = [&](const char* name, const char* long_name, const char* units, const VectorX& values) {
    file.add_variable(root_group, {name, long_name, units, {condition}, {}}, values_of(values));
  };
  add("condition_scale", "size of the terms, by which residuals are divided", "mixed", c.row_scales);
  add("residual_before", "scaled residual of the mechanism before", "1", view.residuals_before);
  add("residual_after", "scaled residual of the designed mechanism", "1", view.conditions.residuals);
}

void add_sizes(Hdf5Writer& file, const DesignReportData& view) {
  const DesignReport& report = view.report;
  add_scalar(file, "mass_before", "mass of everything that moves, before", "kg", report.mass_before);
  add_scalar(file, "mass_after", "mass of everything that moves, designed", "kg", report.mass_after);
  add_scalar(file, "inertia_before", "sum of the moments of inertia, before", "kg m^2", report.inertia_before);
  add_scalar(file, "inertia_after", "sum of the moments of inertia, designed", "kg m^2", report.inertia_after);
  add_scalar(file, "added_mass", "mass of counterweights and discs, designed", "kg", report.added_mass);
  add_scalar(file, "added_inertia", "moments of inertia of counterweights and discs, designed", "kg m^2",
             report.added_inertia);
  if (view.objective.empty()) return;
  const std::string unit = view.objective_unit.empty() ? "mixed" : view.objective_unit;
  add_scalar(file, "objective_start", "what is minimized, at the start values", unit, report.outcome.start_objective);
  add_scalar(file, "objective_value", "what is minimized, designed", unit, report.outcome.objective);
  add_scalar(file, "objective_bound", "what no design is below, if known", unit, report.outcome.lower_bound);
}

Provenance description_of(const Study& study, const std::string& name) {
  Provenance description;
  description.trajectory = name;
  const auto at = std::find_if(study.trajectories.begin(), study.trajectories.end(),
                               [&](const Trajectory& trajectory) { return trajectory.name == name; });
  if (at == study.trajectories.end()) return description;
  description.law = law_name(*at);
  description.drive = name_of(at->drive);
  return description;
}

/// A run that did not come to its end has only attributes.
void add_run(Hdf5Writer& file, Group parent, const RunResult& result, const Provenance& run,
             const WriteOptions& options) {
  // A slash would be a group of its own.
  std::string name = run.trajectory;
  std::replace(name.begin(), name.end(), '/', '_');
  const Group group = file.add_group(parent, name);
  write_run_attributes(file, group, run);
  file.set_attribute(group, "status", name_of(result.outcome.status));
  file.set_attribute(group, "reason", result.outcome.reason);
  if (result.outcome.status == MotionStatus::done) write_result_variables(file, group, result, options);
}

void add_runs(Hdf5Writer& file, const DesignReport& report, const WriteOptions& options) {
  if (report.comparisons.empty()) return;
  const Group before = file.add_group("before"), after = file.add_group("after");
  for (const TrajectoryComparison& c : report.comparisons) {
    add_run(file, before, c.before, description_of(report.study_before, c.trajectory), options);
    add_run(file, after, c.after, description_of(report.study_after, c.trajectory), options);
  }
}

}  // namespace

void write_design(const std::string& path, const DesignReportData& view, const Provenance& description,
                  const WriteOptions& options) {
  AtomicFile pending(path, options.existing, options.temporary_tag);
  const bool compress = options.compression == Compression::gzip;
  Hdf5Writer file(pending.descriptor(), path,
                  compress ? Hdf5Writer::Storage::compressed : Hdf5Writer::Storage::contiguous);
  write_source_attributes(file, description);
  describe_design(file, view);
  add_numbers(file, view.report);
  add_conditions(file, view);
  add_sizes(file, view);
  add_runs(file, view.report, options);
  file.close();
  throw_if_cancelled(options);
  pending.commit();
}

}  // namespace balance
