#include "balance/present/design_hdf5.hpp"

#include "balance/motion/names.hpp"
#include "balance/present/names.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/result_group.hpp"

#include <algorithm>
#include <span>

namespace balance {
namespace {

using Dimension = Hdf5File::Dimension;
using Group = Hdf5File::Group;

constexpr Group root{};

std::span<const double> values_of(const VectorX& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

void add_scalar(Hdf5File& file, const char* name, const char* long_name, const std::string& units, double value) {
  file.add(root, {name, long_name, units, {}, {}}, std::span(&value, 1));
}

void describe_design(Hdf5File& file, const DesignView& view) {
  const DesignOutcome& outcome = view.report.outcome;
  file.set_attribute(root, "formulation", "tree");
  file.set_attribute(root, "goal", list_names(outcome.conditions.goals));
  file.set_attribute(root, "strategy", view.conditions.strategy);
  file.set_attribute(root, "status", name_of(outcome.status));
  file.set_attribute(root, "optimality", name_of(outcome.optimality));
  file.set_attribute(root, "tried", outcome.tried);
  file.set_attribute(root, "proved", outcome.proved ? "yes" : "no");
  file.set_attribute(root, "method", name_of(outcome.method));
  file.set_attribute(root, "reason", outcome.reason);
  file.set_attribute(root, "proof", outcome.proof ? outcome.proof->sentence : "");
  file.set_attribute(root, "objective", view.objective);
}

void add_numbers(Hdf5File& file, const DesignReport& report) {
  std::vector<std::string> paths;
  VectorX lower(report.before.size()), upper(report.before.size());
  for (std::size_t i = 0; i < report.numbers.size(); ++i) {
    paths.push_back(report.numbers[i].path);
    lower[static_cast<Eigen::Index>(i)] = report.numbers[i].lower;
    upper[static_cast<Eigen::Index>(i)] = report.numbers[i].upper;
  }
  const Dimension number = file.add_dimension(root, {"free_number", "key path in the spec", "1", {}, {}}, paths);
  const auto add = [&](const char* name, const char* long_name, const VectorX& values) {
    file.add(root, {name, long_name, "mixed", {number}, {}}, values_of(values));
  };
  add("lower", "lower bound, SI; free parameters as written", lower);
  add("upper", "upper bound", upper);
  add("start", "value in the mechanism before, the spec's start values", report.before);
  add("value", "value in the designed mechanism", report.outcome.x);
}

void add_conditions(Hdf5File& file, const DesignView& view) {
  const Conditions& c = view.conditions.conditions;
  if (c.matrix.rows() == 0) return;
  std::vector<std::string> texts, names;
  for (int row = 0; row < static_cast<int>(c.matrix.rows()); ++row)
    texts.push_back(condition_text(c, row, view.conditions.names));
  for (const Parameter& p : c.parameters) names.push_back(p.name);
  const Dimension condition = file.add_dimension(root, {"condition", "what must vanish", "1", {}, {}}, texts);
  const Dimension parameter = file.add_dimension(root, {"parameter", "inertial parameter", "1", {}, {}}, names);
  const Samples matrix = c.matrix;
  file.add(root,
           {"condition_matrix",
            "coefficients of the conditions at the designed geometry",
            "mixed",
            {condition, parameter},
            {{"smallest_kept", {c.smallest_kept}}, {"largest_dropped", {c.largest_dropped}}, {"gap", {c.gap}}}},
           std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
  const auto add = [&](const char* name, const char* long_name, const char* units, const VectorX& values) {
    file.add(root, {name, long_name, units, {condition}, {}}, values_of(values));
  };
  add("condition_scale", "size of the terms, by which residuals are divided", "mixed", c.scale);
  add("residual_before", "scaled residual of the mechanism before", "1", view.residuals_before);
  add("residual_after", "scaled residual of the designed mechanism", "1", view.conditions.residuals);
}

void add_sizes(Hdf5File& file, const DesignView& view) {
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
  add_scalar(file, "objective_start", "what is minimized, at the start values", unit, report.outcome.objective_start);
  add_scalar(file, "objective_value", "what is minimized, designed", unit, report.outcome.objective);
  add_scalar(file, "objective_bound", "what no design is below, if known", unit, report.outcome.lower_bound);
}

FileDescription description_of(const Study& study, const std::string& name) {
  FileDescription description;
  description.trajectory = name;
  const auto at = std::find_if(study.trajectories.begin(), study.trajectories.end(),
                               [&](const Trajectory& trajectory) { return trajectory.name == name; });
  if (at == study.trajectories.end()) return description;
  description.law = law_name(*at);
  description.drive = name_of(at->drive);
  return description;
}

/// A run that did not come to its end has only attributes.
void add_run(Hdf5File& file, Group parent, const Result& result, const FileDescription& run,
             const WriteOptions& options) {
  // A slash would be a group of its own.
  std::string name = run.trajectory;
  std::replace(name.begin(), name.end(), '/', '_');
  const Group group = file.add_group(parent, name);
  describe_run(file, group, run);
  file.set_attribute(group, "status", name_of(result.outcome.status));
  file.set_attribute(group, "reason", result.outcome.reason);
  if (result.outcome.status == MotionStatus::done) add_result(file, group, result, options);
}

void add_runs(Hdf5File& file, const DesignReport& report, const WriteOptions& options) {
  if (report.comparisons.empty()) return;
  const Group before = file.add_group("before"), after = file.add_group("after");
  for (const TrajectoryComparison& c : report.comparisons) {
    add_run(file, before, c.before, description_of(report.study_before, c.trajectory), options);
    add_run(file, after, c.after, description_of(report.study_after, c.trajectory), options);
  }
}

}  // namespace

void write_design(const std::string& path, const DesignView& view, const FileDescription& description,
                  const WriteOptions& options) {
  PendingFile pending(path, options.existing, options.mark);
  const bool compress = options.compression == Compression::gzip;
  Hdf5File file(pending.descriptor(), path, compress ? Hdf5File::Storage::compressed : Hdf5File::Storage::contiguous);
  describe_source(file, description);
  describe_design(file, view);
  add_numbers(file, view.report);
  add_conditions(file, view);
  add_sizes(file, view);
  add_runs(file, view.report, options);
  file.close();
  stop_if_cancelled(options);
  pending.commit();
}

}  // namespace balance
