#include "balance/interface/reports/tolerance_sections.hpp"

#include "balance/foundation/hdf5/hdf5_writer.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/result_group.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/synthesis/design/objective_builder.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

namespace balance::reports {

using files::Align;
using files::DisplayUnit;
using files::TextOptions;
using hdf5::Hdf5Writer;
using tolerance::QuantityTolerance;
using tolerance::ToleranceReport;

namespace {

using Dimension = Hdf5Writer::Dimension;
using Group = Hdf5Writer::Group;

// Every group has its own dimension, so that readers of one group see all its labels.
Dimension add_number_labels(Hdf5Writer& file, Group group, const Tolerances& numbers) {
  std::vector<std::string> paths;
  for (const study::TolerancedParameter& one : numbers) paths.push_back(one.path);
  return file.add_dimension(group, {"number", "key path in the spec", "1", {}, {}}, paths);
}

/// One entry per number and joint.
void add_incompatible_parameter_table(Hdf5Writer& file, Group parent,
                                      const std::vector<tolerance::IncompatibleParameter>& openings) {
  if (openings.empty()) return;
  const Group group = file.add_group(parent, "openings");
  std::vector<std::string> paths, joints, units;
  std::vector<double> gaps;
  for (const tolerance::IncompatibleParameter& one : openings) {
    paths.push_back(one.key_path);
    joints.push_back(one.joint);
    units.push_back(one.unit);
    gaps.push_back(one.gap);
  }
  const Dimension opening = file.add_dimension(
      group, {"opening", "number that over-constrained loops cannot follow on its own", "1", {}, {}}, paths);
  file.add_variable(group, {"joint", "joint that it opens", "1", {opening}, {}}, joints);
  file.add_variable(group, {"unit", "of the gap", "1", {opening}, {}}, units);
  file.add_variable(group, {"gap", "smallest opening of the joint by its deviation", "mixed", {opening}, {}}, gaps);
}

void add_tolerances(Hdf5Writer& file, Group parent, const Tolerances& numbers) {
  const Group group = file.add_group(parent, "numbers");
  const Dimension number = add_number_labels(file, group, numbers);
  std::vector<double> value, width, deviation;
  std::vector<std::string> distribution;
  for (const study::TolerancedParameter& one : numbers) {
    value.push_back(one.value);
    width.push_back(one.width);
    deviation.push_back(one.deviation());
    distribution.emplace_back(one.distribution == study::Distribution::normal ? "normal" : "uniform");
  }
  file.add_variable(group, {"value", "value in the spec, SI; parameters as written", "mixed", {number}, {}}, value);
  file.add_variable(group, {"width", "standard deviation; of uniform ones half of the interval", "mixed", {number}, {}},
                    width);
  file.add_variable(group, {"deviation", "standard deviation", "mixed", {number}, {}}, deviation);
  file.add_variable(group, {"distribution", "normal or uniform", "1", {number}, {}}, distribution);
}

/// The figures of a run's `metrics` and their deviations, one row per quantity.
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
    unit_ = results::common_unit(units);
  }

  void add_figure(const std::string& name, tolerance::FigureDeviation QuantityTolerance::*figure) const {
    add(name, "standard deviation of the " + name + " to first order", unit_,
        [&](const QuantityTolerance& one) { return (one.*figure).deviation; });
    add(name + "_rivals", "moments to which the " + name + " may move; 0: it stays where it is", "1",
        [&](const QuantityTolerance& one) { return static_cast<double>((one.*figure).extremum_times.size()); });
    add_shares(name + "_by_number", "change of the " + name + " by a number's deviation", unit_,
               [&](const QuantityTolerance& one) { return (one.*figure).contributions; });
  }

  void add_squares() const {
    add("expected_rms", "root of the expected mean square", unit_, [](const auto& one) { return one.expected_rms; });
    add("mean_square_deviation", "standard deviation of the mean square, in the unit's square", "mixed",
        [](const auto& one) { return one.square_deviation; });
  }

  void add_worst() const {
    add("worst_time", "time of the sample with the largest deviation", "s",
        [](const auto& one) { return one.worst.time; });
    add("worst_value", "value of that sample in the spec", unit_, [](const auto& one) { return one.worst.value; });
    add("worst_deviation", "standard deviation of that sample", unit_,
        [](const auto& one) { return one.worst.deviation; });
    add_shares("worst_share", "share of a number in that sample's variance", "1",
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

void write_tolerance(const std::string& path, const ToleranceReportData& view, const files::Provenance& description,
                     const files::WriteOptions& options) {
  if (!view.report) throw std::invalid_argument("only what is off along a trajectory is written");
  files::AtomicFile pending(path, options.existing, options.temporary_tag);
  {
    const bool compress = options.compression == files::Compression::gzip;
    Hdf5Writer file(pending.descriptor(), path,
                    compress ? Hdf5Writer::Storage::compressed : Hdf5Writer::Storage::contiguous);
    write_source_attributes(file, description);
    files::write_run_attributes(file, {}, description);
    files::write_result_variables(file, {}, view.report->run, options);
    const Group group = file.add_group("tolerance");
    write_deviation_variables(file, group, view.report->deviation, options);
    add_tolerances(file, group, view.numbers);
    add_incompatible_parameter_table(file, group, view.report->incompatible_parameters);
    add_figures(file, group, *view.report);
    file.close();
  }  // other threads may use HDF5 while this one waits for the disk
  throw_if_cancelled(options);
  pending.commit(options.durability);
}

files::Provenance make_tolerance_provenance(const Study& study, const Trajectory& trajectory,
                                            const ToleranceCommand& command) {
  files::Provenance description = files::make_simulation_provenance(
      study, trajectory, {.spec_file = study.spec_file, .trajectory = trajectory.name});
  std::vector<std::string> arguments = {"balance", "tolerance",
                                        std::filesystem::path(study.spec_file).filename().string(), "--trajectory",
                                        trajectory.name};
  for (const std::string& quantity : command.of) arguments.insert(arguments.end(), {"--of", quantity});
  if (command.samples) arguments.insert(arguments.end(), {"--samples", fmt::format("{}", *command.samples)});
  files::append_overrides(arguments, study);
  description.command_line = files::join_command(std::move(arguments));
  return description;
}

namespace {

Json contributions_json(const Tolerances& numbers, const VectorX& values) {
  Json json = Json::object();
  for (std::size_t i = 0; i < numbers.size() && static_cast<Eigen::Index>(i) < values.size(); ++i)
    json[numbers[i].path] = values[static_cast<Eigen::Index>(i)];
  return json;
}

Json figure_json(const tolerance::FigureDeviation& figure, const Tolerances& numbers) {
  return {{"value", figure.value},
          {"deviation", figure.deviation},
          {"by_number", contributions_json(numbers, figure.contributions)},
          {"rival_times", figure.extremum_times}};
}

Json worst_json(const tolerance::WorstSample& worst, const ToleranceReport& report) {
  Json pose = Json::object();
  for (std::size_t c = 0; c < report.run.coordinate_names.size(); ++c)
    pose[report.run.coordinate_names[c]] = report.run.joint_position(worst.row, static_cast<Eigen::Index>(c));
  return {{"time", worst.time},
          {"value", worst.value},
          {"deviation", worst.deviation},
          {"coordinates", std::move(pose)},
          {"shares", contributions_json(report.numbers, worst.shares)}};
}

Json report_json(const ToleranceReport& report) {
  Json quantities = Json::array();
  for (const QuantityTolerance& one : report.quantities)
    quantities.push_back({{"quantity", one.quantity},
                          {"unit", one.unit},
                          {"peak", figure_json(one.peak, report.numbers)},
                          {"rms", figure_json(one.rms, report.numbers)},
                          {"mean", figure_json(one.mean, report.numbers)},
                          {"range", figure_json(one.range, report.numbers)},
                          {"expected_rms", one.expected_rms},
                          {"mean_square_deviation", one.square_deviation},
                          {"worst_sample", worst_json(one.worst, report)}});
  return {{"quantities", std::move(quantities)},
          {"energy", figure_json(report.energy, report.numbers)},
          {"notes", report.run.outcome.notes}};
}

Json incompatible_parameters_json(const ToleranceReportData& view) {
  Json openings = Json::array();
  for (const tolerance::IncompatibleParameter& one : incompatible_parameters_of(view))
    openings.push_back({{"number", one.key_path}, {"joint", one.joint}, {"gap", one.gap}, {"unit", one.unit}});
  return openings;
}

Json sampling_json(const ToleranceReportData& view) {
  if (!view.sampling) return nullptr;
  Json figures = Json::array();
  for (const tolerance::SampledFigure& one : view.sampling->figures)
    figures.push_back({{"quantity", one.quantity},
                       {"figure", design::objective_term_name(one.figure)},
                       {"unit", one.unit},
                       {"mean", one.mean},
                       {"mean_error", one.mean_error},
                       {"deviation", one.deviation},
                       {"deviation_error", one.deviation_error},
                       {"quantiles", {{"5", one.quantiles[0]}, {"50", one.quantiles[1]}, {"95", one.quantiles[2]}}},
                       {"disagreement", view.report ? Json(sampling_disagreement(*view.report, one)) : Json(nullptr)}});
  Json rejections = Json::object();
  for (const auto& [reason, count] : view.sampling->rejections) rejections[reason] = count;
  return {{"draws", view.draws.count},
          {"seed", view.draws.seed},
          {"drawn", view.sampling->run_count},
          {"refused", std::move(rejections)},
          {"figures", std::move(figures)}};
}

Json poses_at_rest_json(const ToleranceReportData& view) {
  if (!view.at_rest) return nullptr;
  const tolerance::StaticTolerance& static_tolerance = *view.at_rest;
  Json actuators = Json::array();
  for (const tolerance::StaticDeviation& one : static_tolerance.actuators) {
    Json pose = Json::object();
    for (std::size_t k = 0; k < static_tolerance.coordinates.size(); ++k)
      pose[static_tolerance.coordinates[k]] = one.pose[static_cast<Eigen::Index>(k)];
    actuators.push_back({{"actuator", one.actuator},
                         {"unit", one.unit},
                         {"deviation", one.deviation},
                         {"effort", one.effort},
                         {"coordinates", std::move(pose)},
                         {"shares", contributions_json(view.numbers, one.shares)}});
  }
  return {{"poses", static_tolerance.pose_count},
          {"unreached", static_tolerance.unreachable_count},
          {"actuators", std::move(actuators)}};
}

}  // namespace

std::string tolerance_json(const ToleranceReportData& view) {
  Json numbers = Json::array();
  for (const study::TolerancedParameter& one : view.numbers)
    numbers.push_back({{"path", one.path},
                       {"value", one.value},
                       {"distribution", one.distribution == study::Distribution::normal ? "normal" : "uniform"},
                       {"width", one.width},
                       {"deviation", one.deviation()}});
  Json json = {{"mechanism", view.mechanism}, {"numbers", std::move(numbers)}};
  json["openings"] = incompatible_parameters_json(view);
  json["trajectory"] = view.report ? Json(view.trajectory) : Json(nullptr);
  json["first_order"] = view.report ? report_json(*view.report) : Json(nullptr);
  json["sampling"] = sampling_json(view);
  json["at_rest"] = poses_at_rest_json(view);
  return files::format_json(json);
}

namespace {

constexpr double disagreement_threshold = 4;
constexpr double min_listed_share = 0.005;

std::string tolerance_number(double value) { return value == 0 ? "0" : files::format_number(value); }

/// "0.12", with a star if other extrema compete, or "kink" if the figure has no derivative.
std::string deviation_text(const tolerance::FigureDeviation& figure, const DisplayUnit& unit) {
  if (std::isnan(figure.deviation)) return "kink";
  return tolerance_number(unit.convert(figure.deviation)) + (figure.extremum_times.empty() ? "" : "*");
}

/// "cw1.mass 71 %, cw2.mass 29 %", the largest first.
std::string shares_text(const Tolerances& numbers, const VectorX& shares) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(shares.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return shares[a] > shares[b]; });
  std::string text;
  for (const Eigen::Index i : order)
    if (shares[i] >= min_listed_share)
      text += fmt::format("{}{} {:.0f} %", text.empty() ? "" : ", ",
                          tolerance_name(numbers[static_cast<std::size_t>(i)]), 100 * shares[i]);
  return text.empty() ? "-" : text;
}

std::string numbers_table(const Tolerances& numbers, const TextOptions& options) {
  files::TextTable table{{"number", "unit", "value", "deviation", "distribution"},
                         {Align::left, Align::left, Align::right, Align::right, Align::left},
                         {},
                         2};
  for (const study::TolerancedParameter& one : numbers) {
    const DisplayUnit unit = find_number_unit(one.path, options);
    table.rows.push_back({one.path, unit.name, tolerance_number(unit.convert(one.value)),
                          tolerance_number(unit.convert(one.deviation())),
                          one.distribution == study::Distribution::normal
                              ? "normal"
                              : fmt::format("uniform, ± {:.6g}", unit.convert(one.width))});
  }
  remove_empty_units(table);
  return format_table(table, options.width);
}

/// Numbers whose deviation would open joints.
std::string format_incompatible_parameters(const ToleranceReportData& view, const TextOptions& options) {
  const std::vector<tolerance::IncompatibleParameter>& openings = incompatible_parameters_of(view);
  if (openings.empty()) return "";
  std::string text =
      "\nover-constrained loops cannot follow these numbers on their own: their deviations would open joints, at "
      "least by the amounts listed. They are not included in ± and are not sampled\n";
  files::TextTable table{
      {"number", "joint", "opens by", "unit"}, {Align::left, Align::left, Align::right, Align::left}, {}};
  for (const tolerance::IncompatibleParameter& one : openings) {
    const DisplayUnit unit = files::find_display_unit(one.unit, options.units);
    table.rows.push_back({one.key_path, one.joint, tolerance_number(unit.convert(one.gap)), unit.name});
  }
  return text + format_table(table, options.width);
}

/// Peaks and ranges that may move to other moments, with these moments.
std::string format_extremum_times(const ToleranceReport& report, const specification::SpecUnits& units) {
  const DisplayUnit unit = files::find_display_unit("s", units);
  std::string text;
  for (const QuantityTolerance& one : report.quantities)
    for (const auto& [word, figure] : {std::pair{"peak", &one.peak}, {"range", &one.range}}) {
      if (figure->extremum_times.empty()) continue;
      std::vector<std::string> times;
      for (const double time : figure->extremum_times) times.push_back(fmt::format("{:.4g}", unit.convert(time)));
      text += fmt::format("  {} of {}: at {} {}\n", word, one.quantity, fmt::join(times, ", "), unit.name);
    }
  if (text.empty()) return "";
  return "*: which moment is the largest depends on the numbers; ± is that of the largest of them, accurate to a "
         "hundredth\n" +
         text;
}

std::string figures_table(const ToleranceReport& report, const TextOptions& options) {
  files::TextTable table{{"quantity", "unit", "peak", "±", "rms", "±", "expected rms", "mean", "±", "range", "±"},
                         {Align::left, Align::left},
                         {},
                         2,
                         {2, 4, 7, 9}};
  table.align.resize(table.heading.size(), Align::right);
  for (const QuantityTolerance& one : report.quantities) {
    const DisplayUnit unit = files::find_display_unit(one.unit, options.units);
    std::vector<std::string> row{one.quantity, unit_cell(unit)};
    const auto add = [&](const tolerance::FigureDeviation& figure) {
      row.push_back(tolerance_number(unit.convert(figure.value)));
      row.push_back(deviation_text(figure, unit));
    };
    add(one.peak);
    add(one.rms);
    row.push_back(tolerance_number(unit.convert(one.expected_rms)));
    add(one.mean);
    add(one.range);
    table.rows.push_back(std::move(row));
  }
  return format_table(table, options.width);
}

/// Unit of the heading of a column of poses; none if angles and slides are mixed: then each number has its own.
DisplayUnit pose_unit(const ToleranceReport& report, const specification::SpecUnits& units) {
  const std::vector<std::string>& si_units = report.run.coordinate_units;
  const bool is_mixed = std::adjacent_find(si_units.begin(), si_units.end(), std::not_equal_to<>()) != si_units.end();
  return si_units.empty() || is_mixed ? DisplayUnit{} : files::find_display_unit(si_units.front(), units);
}

std::string pose_text(const ToleranceReport& report, long row, const specification::SpecUnits& units) {
  constexpr std::size_t max_listed_pose_coordinates = 4;
  const bool has_heading_unit = !pose_unit(report, units).name.empty();
  std::string text;
  for (std::size_t c = 0; c < std::min(max_listed_pose_coordinates, report.run.coordinate_names.size()); ++c) {
    const DisplayUnit unit = files::find_display_unit(report.run.coordinate_units[c], units);
    text += fmt::format("{}{} {:.4g}{}", c == 0 ? "" : ", ", report.run.coordinate_names[c],
                        unit.convert(report.run.joint_position(row, static_cast<Eigen::Index>(c))),
                        has_heading_unit ? "" : append_unit(unit));
  }
  return report.run.coordinate_names.size() > max_listed_pose_coordinates ? text + ", …" : text;
}

std::string worst_table(const ToleranceReport& report, const TextOptions& options) {
  const DisplayUnit time = files::find_display_unit("s", options.units);
  files::TextTable table{{"worst sample of", "unit", "time" + bracket_unit(time), "value", "±",
                          "pose" + bracket_unit(pose_unit(report, options.units)), "main causes"},
                         {Align::left, Align::left, Align::right, Align::right, Align::right, Align::left, Align::left},
                         {}};
  for (const QuantityTolerance& one : report.quantities) {
    if (!(one.worst.deviation > 0)) continue;
    const DisplayUnit unit = files::find_display_unit(one.unit, options.units);
    table.rows.push_back(
        {one.quantity, unit.name, fmt::format("{:.4g}", time.convert(one.worst.time)),
         tolerance_number(unit.convert(one.worst.value)), tolerance_number(unit.convert(one.worst.deviation)),
         pose_text(report, one.worst.row, options.units), shares_text(report.numbers, one.worst.shares)});
  }
  return table.rows.empty() ? "nothing changes to first order\n" : format_table(table, options.width);
}

std::string report_text(const ToleranceReportData& view, const TextOptions& options) {
  const DisplayUnit energy = files::find_display_unit("J", options.units);
  const ToleranceReport& report = *view.report;
  std::string text = fmt::format("\nalong {}, to first order: ± is the standard deviation\n{}", view.trajectory,
                                 figures_table(report, options));
  text += fmt::format("energy {} {} ± {}\n", tolerance_number(energy.convert(report.energy.value)), energy.name,
                      deviation_text(report.energy, energy));
  const bool has_kink = std::any_of(report.quantities.begin(), report.quantities.end(), [](const auto& one) {
    return std::isnan(one.peak.deviation) || std::isnan(one.rms.deviation) || std::isnan(one.mean.deviation) ||
           std::isnan(one.range.deviation);
  });
  if (has_kink || std::isnan(report.energy.deviation))
    text +=
        "kink: the figure is less than three times its deviation, so it has no slope there; the expected rms "
        "includes its square, and --monte-carlo gives its distribution\n";
  text += format_extremum_times(report, options.units);
  for (const std::string& note : report.run.outcome.notes) text += "note: " + note + "\n";
  return text + "\n" + worst_table(report, options);
}

std::string sampling_text(const ToleranceReportData& view, const TextOptions& options) {
  const tolerance::MonteCarloReport& sampling = *view.sampling;
  std::string text = fmt::format("\n{} of {} draws, seed {}\n", sampling.run_count, view.draws.count, view.draws.seed);
  for (const auto& [reason, count] : sampling.rejections) text += fmt::format("  {} refused: {}\n", count, reason);
  if (sampling.figures.empty()) return text;
  files::TextTable table{{"figure", "unit", "mean", "±", "deviation", "±", "5 %", "50 %", "95 %", "first order"},
                         {Align::left, Align::left},
                         {},
                         2,
                         {2, 4, 6, 9}};
  table.align.resize(table.heading.size(), Align::right);
  constexpr const char* words[] = {"peak", "rms", "mean", "range"};
  for (const tolerance::SampledFigure& one : sampling.figures) {
    const DisplayUnit unit = files::find_display_unit(one.unit, options.units);
    const auto number = [&](double value) { return tolerance_number(unit.convert(value)); };
    const double standard_errors = sampling_disagreement(*view.report, one);
    table.rows.push_back({fmt::format("{} {}", words[static_cast<int>(one.figure)], one.quantity), unit.name,
                          number(one.mean), fmt::format("{:.2g}", unit.convert(one.mean_error)), number(one.deviation),
                          fmt::format("{:.2g}", unit.convert(one.deviation_error)), number(one.quantiles[0]),
                          number(one.quantiles[1]), number(one.quantiles[2]),
                          std::isnan(standard_errors) ? "-"
                          : standard_errors <= disagreement_threshold
                              ? "agrees"
                              : fmt::format("{:.1f} errors off", standard_errors)});
  }
  return text + format_table(table, options.width);
}

std::string poses_at_rest_text(const ToleranceReportData& view, const TextOptions& options) {
  const tolerance::StaticTolerance& static_tolerance = *view.at_rest;
  std::string text = fmt::format("\nat rest, in all poses (whole turns, {} of a grid", static_tolerance.pose_count);
  text += static_tolerance.unreachable_count > 0
              ? fmt::format(", {} cannot be reached)\n", static_tolerance.unreachable_count)
              : ")\n";
  const DisplayUnit angle =
      files::find_display_unit("rad", options.units);  // the only kind of independent coordinate here
  files::TextTable table{{"actuator", "unit", "largest ±", "effort there", "pose" + bracket_unit(angle), "main causes"},
                         {Align::left, Align::left, Align::right, Align::right, Align::left, Align::left},
                         {}};
  for (const tolerance::StaticDeviation& one : static_tolerance.actuators) {
    std::string pose;
    for (std::size_t k = 0; k < static_tolerance.coordinates.size(); ++k)
      pose += fmt::format("{}{} {:.4g}", k == 0 ? "" : ", ", static_tolerance.coordinates[k],
                          angle.convert(one.pose[static_cast<Eigen::Index>(k)]));
    const DisplayUnit unit = files::find_display_unit(one.unit, options.units);
    table.rows.push_back({one.actuator, unit.name, tolerance_number(unit.convert(one.deviation)),
                          tolerance_number(unit.convert(one.effort)), pose, shares_text(view.numbers, one.shares)});
  }
  return text + format_table(table, options.width);
}

}  // namespace

std::string tolerance_text(const ToleranceReportData& view, const TextOptions& options) {
  std::string text =
      fmt::format("{}\nnumbers with independent deviations\n{}", view.mechanism, numbers_table(view.numbers, options));
  text += format_incompatible_parameters(view, options);
  if (view.report) text += report_text(view, options);
  if (view.sampling) text += sampling_text(view, options);
  if (view.at_rest) text += poses_at_rest_text(view, options);
  return files::wrap_lines(text, options.width);
}

const std::vector<tolerance::IncompatibleParameter>& incompatible_parameters_of(const ToleranceReportData& view) {
  static const std::vector<tolerance::IncompatibleParameter> none;
  if (view.report) return view.report->incompatible_parameters;
  return view.at_rest ? view.at_rest->incompatible_parameters : none;
}

const tolerance::FigureDeviation* find_deviation(const ToleranceReport& report, const std::string& quantity,
                                                 Statistic figure) {
  for (const QuantityTolerance& one : report.quantities) {
    if (one.quantity != quantity) continue;
    switch (figure) {
      case Statistic::peak: return &one.peak;
      case Statistic::rms: return &one.rms;
      case Statistic::mean: return &one.mean;
      case Statistic::range: return &one.range;
      case Statistic::minimum:
      case Statistic::maximum: break;  // have no deviations in a report
    }
  }
  return nullptr;
}

double sampling_disagreement(const ToleranceReport& report, const tolerance::SampledFigure& sampled) {
  const tolerance::FigureDeviation* first_order = find_deviation(report, sampled.quantity, sampled.figure);
  if (first_order == nullptr || !(sampled.deviation_error > 0)) return std::numeric_limits<double>::quiet_NaN();
  return std::abs(sampled.deviation - first_order->deviation) / sampled.deviation_error;
}

}  // namespace balance::reports
