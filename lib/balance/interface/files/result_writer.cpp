#include "balance/foundation/hdf5/hdf5_writer.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/optimised_law_summary.hpp"
#include "balance/interface/files/order_summary.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/result_group.hpp"
#include "balance/interface/files/sha256.hpp"
#include "balance/interface/files/torque_distribution_summary.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::files {

using hdf5::Hdf5Writer;
using results::ColumnKind;
using trajectory::ActiveLimitInterval;

// Writes the law of motion of a run to its result file.

/// Writes the group `law`, if the law was optimised or has limits.
void write_law_group(Hdf5Writer& file, Hdf5Writer::Group parent, const RunResult& result);

namespace {

using Dimension = Hdf5Writer::Dimension;

void add_plane(Hdf5Writer& file, Hdf5Writer::Group group, const trajectory::PhasePlane& plane) {
  if (plane.time.size() > 0) {
    const Dimension time = file.add_dimension(group, {"time", "time", "s", {}, {}}, hdf5::entries_of(plane.time));
    file.add_variable(group, {"place", "fraction of the path covered", "1", {time}, {}},
                      hdf5::entries_of(plane.path_parameter));
    file.add_variable(group, {"rate", "rate of the place", "1/s", {time}, {}}, hdf5::entries_of(plane.path_rate));
  }
  if (plane.mvc_path_parameter.size() == 0) return;
  const Dimension path_parameter =
      file.add_dimension(group, {"ceiling_place", "fraction of the path covered", "1", {}, {}},
                         hdf5::entries_of(plane.mvc_path_parameter));
  file.add_variable(group, {"ceiling", "largest rate of the place within the limits", "1/s", {path_parameter}, {}},
                    hdf5::entries_of(plane.mvc_path_rate));
}

void add_active_limits(Hdf5Writer& file, Hdf5Writer::Group group, const std::vector<ActiveLimitInterval>& intervals) {
  if (intervals.empty()) return;
  write_rows(file, group, intervals, active_limit_fields());
}

void add_optimised_law(Hdf5Writer& file, Hdf5Writer::Group group, const trajectory::OptimisedLaw& law) {
  const auto add = [&](const char* name, const char* long_name, const std::string& unit, const double& value) {
    file.add_variable(group, {name, long_name, unit, {}, {}}, std::span(&value, 1));
  };
  add("duration", "duration", "s", law.duration);
  if (law.momentum != 0) add("momentum", "angular momentum that is kept", "N m s", law.momentum);
  if (!law.objective.empty()) {
    add("peak", "least peak of the quantity in the attribute 'of'", law.unit, law.objective_value);
    file.set_attribute(group, "of", law.objective);
  }
  if (!law.switch_times.empty())
    file.add_dimension(group, {"switch", "time of a jump in the acceleration along the path", "s", {}, {}},
                       std::span(law.switch_times));
  add_active_limits(file, group, law.active_limits);
}

}  // namespace

void write_law_group(Hdf5Writer& file, Hdf5Writer::Group parent, const RunResult& result) {
  if (!result.optimised_law && result.phase_plane.mvc_path_rate.size() == 0) return;
  const Hdf5Writer::Group group = file.add_group(parent, "law");
  if (result.optimised_law) add_optimised_law(file, group, *result.optimised_law);
  add_plane(file, group, result.phase_plane);
}

namespace {

using Dimension = Hdf5Writer::Dimension;

/// The dimensions of this result's quantities.
struct Dimensions {
  Dimension time;
  std::optional<Dimension> coordinate, joint, actuator, axis, quaternion, constraint, sliding, body;
};

std::optional<Dimension> add_labels(Hdf5Writer& file, Hdf5Writer::Group group, const std::string& name,
                                    const std::string& long_name, const std::vector<std::string>& labels) {
  if (labels.empty()) return std::nullopt;
  return file.add_dimension(group, {name, long_name, "1", {}, {}}, labels);
}

Dimensions add_dimensions(Hdf5Writer& file, Hdf5Writer::Group group, const RunResult& r) {
  Dimensions d;
  d.time = file.add_dimension(group, {"time", "time", "s", {}, {}}, hdf5::entries_of(r.time));
  d.coordinate = add_labels(file, group, "coordinate", "joint coordinate", r.coordinate_names);
  d.joint = add_labels(file, group, "joint", "joint", r.joint_names);
  d.actuator = add_labels(file, group, "actuator", "actuated joint coordinate", r.actuator_names);
  d.axis = add_labels(file, group, "axis", "axis of the world", results::axis_labels(r.axes));
  if (r.axes == 3 && (r.tool_orientation.cols() > 0 || r.body_orientation.cols() > 0)) {
    d.quaternion = add_labels(file, group, "quaternion", "component of the quaternion", results::quaternion_labels());
  }
  d.constraint = add_labels(file, group, "constraint", "constraint on speeds", r.constraint_names);
  if (!r.sliding_names.empty())
    d.sliding = add_labels(file, group, "sliding", "joint coordinate with a sliding variable", r.sliding_names);
  d.body = add_labels(file, group, "body", "moving body", r.body_names);
  return d;
}

std::vector<Dimension> dimensions_of(ColumnKind columns, const Dimensions& d) {
  switch (columns) {
    case ColumnKind::single: return {d.time};
    case ColumnKind::coordinate: return {d.time, d.coordinate.value()};
    case ColumnKind::actuator: return {d.time, d.actuator.value()};
    case ColumnKind::axis: return {d.time, d.axis.value()};
    case ColumnKind::quaternion: return {d.time, d.quaternion.value()};
    case ColumnKind::joint: return {d.time, d.joint.value()};
    case ColumnKind::joint_axis: return {d.time, d.joint.value(), d.axis.value()};
    case ColumnKind::constraint: return {d.time, d.constraint.value()};
    case ColumnKind::sliding: return {d.time, d.sliding.value()};
    case ColumnKind::body: return {d.time, d.body.value()};
    case ColumnKind::body_axis: return {d.time, d.body.value(), d.axis.value()};
    case ColumnKind::body_quaternion: return {d.time, d.body.value(), d.quaternion.value()};
  }
  return {};
}

/// Writes the unit of each label, if they differ.
void add_units(Hdf5Writer& file, Hdf5Writer::Group group, const std::string& name, const std::string& long_name,
               Dimension dimension, const std::vector<std::string>& units) {
  if (results::common_unit(units) != "mixed") return;
  file.add_variable(group, {name, long_name, "1", {dimension}, {}}, units);
}

/// Writes display names of the columns of `torque`, if some are forces.
void add_effort_names(Hdf5Writer& file, Hdf5Writer::Group group, Dimension dimension, const RunResult& r) {
  std::vector<std::string> names;
  for (std::size_t a = 0; a < r.actuator_names.size(); ++a)
    names.push_back(results::effort_display_name("torque", r.actuator_units[a]) + "[" + r.actuator_names[a] + "]");
  if (std::any_of(names.begin(), names.end(), [](const std::string& name) { return name.starts_with("force"); }))
    file.add_variable(group, {"effort", "name of the actuator's torque or force", "1", {dimension}, {}}, names);
}

/// Adds the dimensions, and units for those whose labels differ in unit.
Dimensions add_columns(Hdf5Writer& file, Hdf5Writer::Group group, const RunResult& r) {
  const Dimensions dimensions = add_dimensions(file, group, r);
  if (dimensions.coordinate) {
    add_units(file, group, "coordinate_unit", "unit of the joint coordinate", *dimensions.coordinate,
              r.coordinate_units);
  }
  if (dimensions.actuator) {
    add_units(file, group, "actuator_unit", "unit of the actuator's torque or force", *dimensions.actuator,
              r.actuator_units);
    add_effort_names(file, group, *dimensions.actuator, r);
  }
  if (dimensions.constraint)
    add_units(file, group, "constraint_unit", "unit of the constraint's force or moment", *dimensions.constraint,
              r.constraint_units);
  if (dimensions.sliding)
    add_units(file, group, "sliding_unit", "unit of the sliding variable", *dimensions.sliding, r.sliding_units);
  return dimensions;
}

/// One number, or one per label if they differ in kind; empty if unknown.
std::vector<double> round_off_per_label(const RunResult& r, const Quantity& quantity) {
  VectorX results::TermMagnitudes::*const size = results::term_magnitude_of(quantity.member);
  if (size == nullptr) return {};
  const VectorX& magnitudes = r.round_off.*size;
  return {magnitudes.data(), magnitudes.data() + magnitudes.size()};
}

void add_samples(Hdf5Writer& file, Hdf5Writer::Group group, const RunResult& r, const Dimensions& d,
                 const WriteOptions& options) {
  const std::vector<double> moment_reference(r.moment_reference.data(), r.moment_reference.data() + r.axes);
  for (const Quantity& quantity : list_sampled_quantities(r)) {
    throw_if_cancelled(options);
    Hdf5Writer::Variable variable{quantity.name,
                                  quantity.long_name,
                                  results::common_unit(quantity.units),
                                  dimensions_of(quantity.columns, d),
                                  {}};
    if (quantity.has_moment_reference) variable.attributes.push_back({"about", moment_reference});
    if (const auto round_off = round_off_per_label(r, quantity); !round_off.empty())
      variable.attributes.push_back({"round_off", round_off});
    file.add_variable(group, variable, hdf5::entries_of(*quantity.samples));
  }
  if (r.newton_iterations.size() == 0) return;
  file.add_variable(group, {"newton_iterations", "Newton iterations for the position", "1", {d.time}, {}},
                    std::span(r.newton_iterations.data(), r.newton_iterations.size()));
}

void add_metrics(Hdf5Writer& file, Hdf5Writer::Group parent, const RunResult& r) {
  const Hdf5Writer::Group group = file.add_group(parent, "metrics");
  file.add_variable(group, {"energy", "energy moved by the actuators, the integral of the sum of |power|", "J", {}, {}},
                    std::span(&r.energy, 1));
  if (r.metrics.empty()) return;
  std::vector<std::string> units;
  for (const Metric& metric : r.metrics) units.push_back(metric.unit);
  write_rows(file, group, r.metrics, metric_fields(), results::common_unit(units));
}

}  // namespace

namespace {

void write_source_attributes(Hdf5Writer& file, const Provenance& d) {
  file.set_attribute(hdf5::root_group, "title", d.title);
  file.set_attribute(hdf5::root_group, "Conventions", "balance-1");
  file.set_attribute(hdf5::root_group, "balance_version", d.version);
  file.set_attribute(hdf5::root_group, "spec", d.spec_text);
  file.set_attribute(hdf5::root_group, "spec_sha256", sha256(d.spec_text));
  file.set_attribute(hdf5::root_group, "command_line", d.command_line);
  if (d.overrides.empty()) return;
  std::vector<std::string> names, values;
  for (const auto& [name, value] : d.overrides) names.push_back(name), values.push_back(value);
  file.set_attribute(hdf5::root_group, "override_names", names);
  file.set_attribute(hdf5::root_group, "override_values", values);
}

}  // namespace

void write_hdf5_file(const std::string& path, const Provenance& description, const WriteOptions& options,
                     const std::function<void(Hdf5Writer&)>& write) {
  AtomicFile output(path, options.existing, options.temporary_tag);
  const bool compress = options.compression == Compression::gzip;
  {
    Hdf5Writer file(output.descriptor(), path,
                    compress ? Hdf5Writer::Storage::compressed : Hdf5Writer::Storage::contiguous);
    write_source_attributes(file, description);
    write(file);
    file.close();
  }  // others may use HDF5 while this one waits for the disk
  throw_if_cancelled(options);
  output.commit(options.durability);
}

void write_run_attributes(Hdf5Writer& file, Hdf5Writer::Group group, const Provenance& d) {
  if (!d.pose.empty()) return file.set_attribute(group, "at", d.pose);
  file.set_attribute(group, "trajectory", d.trajectory);
  file.set_attribute(group, "law", d.law);
  file.set_attribute(group, "drive", d.drive);
  file.set_attribute(group, "formulation", d.formulation);
  if (d.controller.empty()) return;
  file.set_attribute(group, "controller", d.controller);
  file.set_attribute(group, "controller_type", d.controller_type);
}

void write_outcome_attributes(Hdf5Writer& file, Hdf5Writer::Group group, const MotionOutcome& outcome) {
  file.set_attribute(group, "status", name_of(outcome.status));
  file.set_attribute(group, "reason", outcome.reason);
}

void write_result_variables(Hdf5Writer& file, Hdf5Writer::Group group, const RunResult& r,
                            const WriteOptions& options) {
  if (r.corridor_result)
    file.set_attribute(group, "found_corridor", format_json(corridor_result_json(*r.corridor_result)));
  if (r.torque_distribution) file.set_attribute(group, "torque_distribution", format_json(torque_distribution_json(r)));
  const Dimensions dimensions = add_columns(file, group, r);
  add_samples(file, group, r, dimensions, options);
  add_metrics(file, group, r);
  write_law_group(file, group, r);
  write_payload_events(file, group, r);
  write_adaptation(file, group, r);
  if (r.orders) write_orders(file, group, *r.orders);
}

void write_deviation_variables(Hdf5Writer& file, Hdf5Writer::Group group, const RunResult& deviation,
                               const WriteOptions& options) {
  const Dimensions dimensions = add_columns(file, group, deviation);
  for (const Quantity& quantity : list_sampled_quantities(deviation)) {
    throw_if_cancelled(options);
    if (quantity.columns == ColumnKind::quaternion || quantity.columns == ColumnKind::body_quaternion) continue;
    file.add_variable(group,
                      {quantity.name,
                       "standard deviation of the " + quantity.long_name,
                       results::common_unit(quantity.units),
                       dimensions_of(quantity.columns, dimensions),
                       {}},
                      hdf5::entries_of(*quantity.samples));
  }
}

void write_result_hdf5(const std::string& path, const RunResult& result, const Provenance& description,
                       const WriteOptions& options) {
  if (result.outcome.status != MotionStatus::done && description.controller.empty())
    throw std::invalid_argument("only a run that is done, or one under control, is written");
  if (result.time.size() == 0) throw std::invalid_argument("only a result with samples is written");
  write_hdf5_file(path, description, options, [&](Hdf5Writer& file) {
    write_run_attributes(file, {}, description);
    if (!description.controller.empty()) write_outcome_attributes(file, {}, result.outcome);
    write_result_variables(file, {}, result, options);
  });
}

}  // namespace balance::files
