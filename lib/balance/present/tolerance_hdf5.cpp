#include "balance/present/tolerance_hdf5.hpp"

#include "balance/hdf5/file.hpp"
#include "balance/result/quantities.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/result_group.hpp"
#include "balance/write/run_description.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <span>
#include <stdexcept>

namespace balance {
namespace {

using Dimension = Hdf5Writer::Dimension;
using Group = Hdf5Writer::Group;

// Every group has a dimension of its own: readers of one group see all of its labels.
Dimension add_number_labels(Hdf5Writer& file, Group group, const Tolerances& numbers) {
  std::vector<std::string> paths;
  for (const TolerancedParameter& one : numbers) paths.push_back(one.path);
  return file.add_dimension(group, {"number", "key path in the spec", "1", {}, {}}, paths);
}

/// An entry per number and joint.
void add_incompatible_parameter_table(Hdf5Writer& file, Group parent,
                                      const std::vector<IncompatibleParameter>& openings) {
  if (openings.empty()) return;
  const Group group = file.add_group(parent, "openings");
  std::vector<std::string> paths, joints, units;
  std::vector<double> gaps;
  for (const IncompatibleParameter& one : openings) {
    paths.push_back(one.key_path);
    joints.push_back(one.joint);
    units.push_back(one.unit);
    gaps.push_back(one.gap);
  }
  const Dimension opening = file.add_dimension(
      group, {"opening", "number that over-constrained loops cannot follow by itself", "1", {}, {}}, paths);
  file.add_variable(group, {"joint", "joint that it opens", "1", {opening}, {}}, joints);
  file.add_variable(group, {"unit", "of the gap", "1", {opening}, {}}, units);
  file.add_variable(group, {"gap", "what its deviation opens the joint by at least", "mixed", {opening}, {}}, gaps);
}

void add_tolerances(Hdf5Writer& file, Group parent, const Tolerances& numbers) {
  const Group group = file.add_group(parent, "numbers");
  const Dimension number = add_number_labels(file, group, numbers);
  std::vector<double> value, width, deviation;
  std::vector<std::string> distribution;
  for (const TolerancedParameter& one : numbers) {
    value.push_back(one.value);
    width.push_back(one.width);
    deviation.push_back(one.deviation());
    distribution.emplace_back(one.distribution == Distribution::normal ? "normal" : "uniform");
  }
  file.add_variable(group, {"value", "as the spec has it, SI; parameters as written", "mixed", {number}, {}}, value);
  file.add_variable(group, {"width", "standard deviation; of uniform ones half of the interval", "mixed", {number}, {}},
                    width);
  file.add_variable(group, {"deviation", "standard deviation", "mixed", {number}, {}}, deviation);
  file.add_variable(group, {"distribution", "normal or uniform", "1", {number}, {}}, distribution);
}

/// The figures of a run's `metrics` and how far they are off, a row per quantity.
class DeviationWriter {
 public:
  DeviationWriter(Hdf5Writer& file, Group group, const ToleranceReport& report)
      : file_(file), group_(group), report_(report) {
    std::vector<std::string> names, units;
    for (const QuantityTolerance& one : report.quantities) {
      names.push_back(one.quantity);
      units.push_back(one.unit);
    }
    quantity_ = file.add_dimension(group, {"quantity", "quantity", "1", {}, {}}, names);
    number_ = add_number_labels(file, group, report.numbers);
    file.add_variable(group, {"unit", "unit of the quantity", "1", {quantity_}, {}}, units);
    unit_ = common_unit(units);
  }

  void add_figure(const std::string& name, FigureDeviation QuantityTolerance::*figure) const {
    add(name, "standard deviation of the " + name + " to first order", unit_,
        [&](const QuantityTolerance& one) { return (one.*figure).deviation; });
    add(name + "_rivals", "moments that the " + name + " may come to be at; 0: it stays where it is", "1",
        [&](const QuantityTolerance& one) { return static_cast<double>((one.*figure).extremum_times.size()); });
    add_shares(name + "_by_number", "what a number's deviation changes the " + name + " by", unit_,
               [&](const QuantityTolerance& one) { return (one.*figure).contributions; });
  }

  void add_squares() const {
    add("expected_rms", "root of the expected mean square", unit_, [](const auto& one) { return one.expected_rms; });
    add("mean_square_deviation", "standard deviation of the mean square, in the unit's square", "mixed",
        [](const auto& one) { return one.square_deviation; });
  }

  void add_worst() const {
    add("worst_time", "time of the sample that is off most", "s", [](const auto& one) { return one.worst.time; });
    add("worst_value", "that sample as the spec has it", unit_, [](const auto& one) { return one.worst.value; });
    add("worst_deviation", "standard deviation of that sample", unit_,
        [](const auto& one) { return one.worst.deviation; });
    add_shares("worst_share", "part of a number in that sample's variance", "1",
               [](const auto& one) { return one.worst.shares; });
  }

 private:
  template <class Value>
  void add(const std::string& name, const std::string& long_name, const std::string& unit, const Value& value) const {
    std::vector<double> values;
    for (const QuantityTolerance& one : report_.quantities) values.push_back(value(one));
    file_.add_variable(group_, {name, long_name, unit, {quantity_}, {}}, values);
  }

  template <class Value>
  void add_shares(const std::string& name, const std::string& long_name, const std::string& unit,
                  const Value& value) const {
    std::vector<double> values;
    for (const QuantityTolerance& one : report_.quantities) {
      const VectorX row = value(one);
      values.insert(values.end(), row.begin(), row.end());
    }
    file_.add_variable(group_, {name, long_name, unit, {quantity_, number_}, {}}, values);
  }

  Hdf5Writer& file_;
  Group group_;
  const ToleranceReport& report_;
  Dimension quantity_, number_;
  std::string unit_;
};

void add_figures(Hdf5Writer& file, Group parent, const ToleranceReport& report) {
  const Group group = file.add_group(parent, "metrics");
  file.add_variable(group, {"energy", "standard deviation of the energy moved by the actuators", "J", {}, {}},
                    std::span(&report.energy.deviation, 1));
  if (report.quantities.empty()) return;
  const DeviationWriter table(file, group, report);
  table.add_figure("peak", &QuantityTolerance::peak);
  table.add_figure("rms", &QuantityTolerance::rms);
  table.add_figure("mean", &QuantityTolerance::mean);
  table.add_figure("range", &QuantityTolerance::range);
  table.add_squares();
  table.add_worst();
}

}  // namespace

void write_tolerance(const std::string& path, const ToleranceReportData& view, const Provenance& description,
                     const WriteOptions& options) {
  if (!view.report) throw std::invalid_argument("only what is off along a trajectory is written");
  AtomicFile pending(path, options.existing, options.temporary_tag);
  {
    const bool compress = options.compression == Compression::gzip;
    Hdf5Writer file(pending.descriptor(), path,
                    compress ? Hdf5Writer::Storage::compressed : Hdf5Writer::Storage::contiguous);
    write_source_attributes(file, description);
    write_run_attributes(file, {}, description);
    write_result_variables(file, {}, view.report->run, options);
    const Group group = file.add_group("tolerance");
    write_deviation_variables(file, group, view.report->deviation, options);
    add_tolerances(file, group, view.numbers);
    add_incompatible_parameter_table(file, group, view.report->incompatible_parameters);
    add_figures(file, group, *view.report);
    file.close();
  }  // others have their turn with HDF5 while this one waits for the disk
  throw_if_cancelled(options);
  pending.commit(options.durability);
}

Provenance make_tolerance_provenance(const Study& study, const Trajectory& trajectory, const ToleranceCommand& call) {
  Provenance description =
      make_simulation_provenance(study, trajectory, {.spec_file = study.spec_file, .trajectory = trajectory.name});
  std::string line = "balance tolerance " +
                     quote_for_shell(std::filesystem::path(study.spec_file).filename().string()) + " --trajectory " +
                     quote_for_shell(trajectory.name);
  for (const std::string& quantity : call.of) line += " --of " + quote_for_shell(quantity);
  if (call.samples) line += fmt::format(" --samples {}", *call.samples);
  for (const std::string& set : call.set) line += " --set " + quote_for_shell(set);
  description.command_line = line;
  return description;
}

}  // namespace balance
