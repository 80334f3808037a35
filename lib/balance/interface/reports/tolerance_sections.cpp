#include "balance/interface/reports/tolerance_sections.hpp"

#include "balance/interface/files/provenance.hpp"
#include "balance/interface/files/result_group.hpp"
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

using files::DisplayUnit;
using files::TextOptions;
using hdf5::Hdf5Writer;
using tolerance::QuantityTolerance;
using tolerance::ToleranceReport;

namespace {

constexpr double disagreement_threshold = 4;
constexpr double min_listed_share = 0.005;

const char* name_of(study::Distribution distribution) {
  return distribution == study::Distribution::normal ? "normal" : "uniform";
}

/// Short name of a number: "cw1.mass".
std::string tolerance_name(const study::TolerancedParameter& number) {
  return number.path.substr(number.path.find('.') + 1);
}

/// Numbers that open joints, with the gaps.
const std::vector<tolerance::IncompatibleParameter>& incompatible_parameters_of(const ToleranceReportData& view) {
  static const std::vector<tolerance::IncompatibleParameter> none;
  if (view.report) return view.report->incompatible_parameters;
  return view.at_rest ? view.at_rest->incompatible_parameters : none;
}

/// The deviation of one of a quantity's figures; nullptr if the report does not have it.
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

/// Difference of the sampled and the first-order standard deviation, in standard errors; NaN if either is unknown.
double sampling_disagreement(const ToleranceReport& report, const tolerance::SampledFigure& sampled) {
  const tolerance::FigureDeviation* first_order = find_deviation(report, sampled.quantity, sampled.figure);
  if (first_order == nullptr || !(sampled.deviation_error > 0)) return std::numeric_limits<double>::quiet_NaN();
  return std::abs(sampled.deviation - first_order->deviation) / sampled.deviation_error;
}

/// An entry per number.
Json contributions_json(const Tolerances& numbers, const VectorX& values) {
  Json json = Json::object();
  for (std::size_t i = 0; i < numbers.size() && static_cast<Eigen::Index>(i) < values.size(); ++i)
    json[numbers[i].path] = values[static_cast<Eigen::Index>(i)];
  return json;
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

ReportFields<study::TolerancedParameter> toleranced_number_fields() {
  using Row = study::TolerancedParameter;
  return {{&Row::path, JsonKey{"path"}, TextColumn{"number"}, Hdf5Dataset{"key path in the spec", "number"}},
          {nullptr, TextColumn{"unit"}, files::unit_name},
          {&Row::value, JsonKey{"value"}, TextColumn{}, Hdf5Dataset{"value in the spec, SI; parameters as written"}},
          {[](const Row& one) { return name_of(one.distribution); }, JsonKey{"distribution"},
           Hdf5Dataset{"normal or uniform"}},
          {&Row::width, JsonKey{"width"}, Hdf5Dataset{"standard deviation; of uniform ones half of the interval"}},
          {&Row::deviation, JsonKey{"deviation"}, TextColumn{}, Hdf5Dataset{"standard deviation"}},
          {nullptr, TextColumn{"distribution"}, [](const Row& one, const DisplayUnit& unit) {
             return one.distribution == study::Distribution::normal
                        ? "normal"
                        : fmt::format("uniform, ± {:.6g}", unit.convert(one.width));
           }}};
}

/// Numbers whose deviation would open joints; one row per number and joint.
ReportFields<tolerance::IncompatibleParameter> opening_fields() {
  using Row = tolerance::IncompatibleParameter;
  return {{&Row::key_path, JsonKey{"number"}, TextColumn{},
           Hdf5Dataset{"number that over-constrained loops cannot follow on its own", "opening"}},
          {&Row::joint, JsonKey{"joint"}, TextColumn{}, Hdf5Dataset{"joint that it opens"}},
          {&Row::gap, JsonKey{"gap"}, TextColumn{"opens by"},
           Hdf5Dataset{"smallest opening of the joint by its deviation"}},
          {&Row::unit, JsonKey{"unit"}, TextColumn{}, files::unit_name, Hdf5Dataset{"of the gap"}}};
}

Json figure_json(const tolerance::FigureDeviation& figure, const Tolerances& numbers) {
  return {{"value", figure.value},
          {"deviation", figure.deviation},
          {"by_number", contributions_json(numbers, figure.contributions)},
          {"rival_times", figure.extremum_times}};
}

/// "0.12", with a star if other extrema compete, or "kink" if the figure has no derivative.
std::string deviation_text(const tolerance::FigureDeviation& figure, const DisplayUnit& unit) {
  if (std::isnan(figure.deviation)) return "kink";
  return files::format_figure(unit.convert(figure.deviation)) + (figure.extremum_times.empty() ? "" : "*");
}

/// The figures of a run's `metrics` and their deviations, one row per quantity.
ReportFields<QuantityTolerance> figure_fields(const Tolerances& numbers) {
  using Row = QuantityTolerance;
  ReportFields<Row> fields{
      {&Row::quantity, JsonKey{"quantity"}, TextColumn{}, Hdf5Dataset{"quantity"}},
      {&Row::unit, JsonKey{"unit"}, TextColumn{}, files::unit_name_or_1, Hdf5Dataset{"unit of the quantity"}}};
  const auto add = [&](const std::string& name, tolerance::FigureDeviation Row::*figure) {
    fields.push_back({[=, &numbers](const Row& one) { return figure_json(one.*figure, numbers); }, JsonKey{name}});
    fields.push_back({[=](const Row& one) { return (one.*figure).value; }, TextColumn{name}});
    fields.push_back({[=](const Row& one) { return (one.*figure).deviation; }, TextColumn{"±"},
                      [=](const Row& one, const DisplayUnit& unit) { return deviation_text(one.*figure, unit); },
                      Hdf5Dataset{"standard deviation of the " + name + " to first order", name}});
    fields.push_back(
        {[=](const Row& one) { return (one.*figure).extremum_times.size(); }, SiUnit{"1"},
         Hdf5Dataset{"moments to which the " + name + " may move; 0: it stays where it is", name + "_rivals"}});
    fields.push_back({[=](const Row& one) { return files::numbers_json((one.*figure).contributions); },
                      Hdf5Dataset{"change of the " + name + " by a number's deviation", name + "_by_number"}});
  };
  add("peak", &Row::peak);
  add("rms", &Row::rms);
  fields.push_back({&Row::expected_rms, TextColumn{"expected rms"}});
  add("mean", &Row::mean);
  add("range", &Row::range);
  fields.push_back({&Row::expected_rms, JsonKey{"expected_rms"}, Hdf5Dataset{"root of the expected mean square"}});
  fields.push_back({&Row::square_deviation, JsonKey{"mean_square_deviation"}, SiUnit{"mixed"},
                    Hdf5Dataset{"standard deviation of the mean square, in the unit's square"}});
  return fields;
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

/// The sample with the largest deviation of each quantity.
ReportFields<QuantityTolerance> worst_sample_fields(const ToleranceReport& report,
                                                    const specification::SpecUnits& units = {}) {
  using Row = QuantityTolerance;
  return {{&Row::quantity, TextColumn{"worst sample of"}},
          {&Row::unit, TextColumn{"unit"}, files::unit_name},
          {[](const Row& one) { return one.worst.time; }, JsonKey{"worst_sample/time"}, TextColumn{"time", "{:.4g}"},
           SiUnit{"s"}, Hdf5Dataset{"time of the sample with the largest deviation", "worst_time"}},
          {[](const Row& one) { return one.worst.value; }, JsonKey{"worst_sample/value"}, TextColumn{"value"},
           Hdf5Dataset{"value of that sample in the spec", "worst_value"}},
          {[](const Row& one) { return one.worst.deviation; }, JsonKey{"worst_sample/deviation"}, TextColumn{"±"},
           Hdf5Dataset{"standard deviation of that sample", "worst_deviation"}},
          {[&](const Row& one) {
             return files::named_numbers_json(report.run.coordinate_names,
                                              report.run.joint_position.row(one.worst.row).transpose());
           },
           JsonKey{"worst_sample/coordinates"}, TextColumn{"pose" + bracket_unit(pose_unit(report, units))},
           [&report, units](const Row& one, const DisplayUnit&) { return pose_text(report, one.worst.row, units); }},
          {[&](const Row& one) { return contributions_json(report.numbers, one.worst.shares); },
           JsonKey{"worst_sample/shares"}, TextColumn{"main causes"},
           [&](const Row& one, const DisplayUnit&) { return shares_text(report.numbers, one.worst.shares); },
           SiUnit{"1"}, Hdf5Dataset{"share of a number in that sample's variance", "worst_share"}}};
}

/// All that is known of a quantity.
ReportFields<QuantityTolerance> quantity_fields(const ToleranceReport& report) {
  ReportFields<QuantityTolerance> fields = figure_fields(report.numbers);
  for (ReportField<QuantityTolerance>& field : worst_sample_fields(report)) fields.push_back(std::move(field));
  return fields;
}

ReportFields<tolerance::SampledFigure> sampled_figure_fields(const ToleranceReportData& view) {
  using Row = tolerance::SampledFigure;
  constexpr const char* words[] = {"peak", "rms", "mean", "range"};
  const auto quantile = [](std::size_t k) { return [k](const Row& one) { return one.quantiles[k]; }; };
  return {{&Row::quantity, JsonKey{"quantity"}},
          {[](const Row& one) { return design::objective_term_name(one.figure); }, JsonKey{"figure"}},
          {[words](const Row& one) { return fmt::format("{} {}", words[static_cast<int>(one.figure)], one.quantity); },
           TextColumn{"figure"}},
          {&Row::unit, JsonKey{"unit"}, TextColumn{}, files::unit_name},
          {&Row::mean, JsonKey{"mean"}, TextColumn{}},
          {&Row::mean_error, JsonKey{"mean_error"}, TextColumn{"±", "{:.2g}"}},
          {&Row::deviation, JsonKey{"deviation"}, TextColumn{}},
          {&Row::deviation_error, JsonKey{"deviation_error"}, TextColumn{"±", "{:.2g}"}},
          {quantile(0), JsonKey{"quantiles/5"}, TextColumn{"5 %"}},
          {quantile(1), JsonKey{"quantiles/50"}, TextColumn{"50 %"}},
          {quantile(2), JsonKey{"quantiles/95"}, TextColumn{"95 %"}},
          {[&](const Row& one) { return view.report ? Json(sampling_disagreement(*view.report, one)) : Json(); },
           JsonKey{"disagreement"}, TextColumn{"first order"},
           [&](const Row& one, const DisplayUnit&) {
             const double standard_errors = sampling_disagreement(*view.report, one);
             return std::isnan(standard_errors)                 ? "-"
                    : standard_errors <= disagreement_threshold ? "agrees"
                                                                : fmt::format("{:.1f} errors off", standard_errors);
           }}};
}

ReportFields<tolerance::StaticDeviation> static_deviation_fields(const ToleranceReportData& view,
                                                                 const specification::SpecUnits& units = {}) {
  using Row = tolerance::StaticDeviation;
  const std::vector<std::string>& coordinates = view.at_rest->coordinates;
  const DisplayUnit angle = files::find_display_unit("rad", units);  // the only kind of independent coordinate here
  return {{&Row::actuator, JsonKey{"actuator"}, TextColumn{}},
          {&Row::unit, JsonKey{"unit"}, TextColumn{}, files::unit_name},
          {&Row::deviation, JsonKey{"deviation"}, TextColumn{"largest ±"}},
          {&Row::effort, JsonKey{"effort"}, TextColumn{"effort there"}},
          {[&](const Row& one) { return files::named_numbers_json(coordinates, one.pose); }, JsonKey{"coordinates"},
           TextColumn{"pose" + bracket_unit(angle)},
           [&coordinates, angle](const Row& one, const DisplayUnit&) {
             std::string pose;
             for (std::size_t k = 0; k < coordinates.size(); ++k)
               pose += fmt::format("{}{} {:.4g}", k == 0 ? "" : ", ", coordinates[k],
                                   angle.convert(one.pose[static_cast<Eigen::Index>(k)]));
             return pose;
           }},
          {[&](const Row& one) { return contributions_json(view.numbers, one.shares); }, JsonKey{"shares"},
           TextColumn{"main causes"},
           [&](const Row& one, const DisplayUnit&) { return shares_text(view.numbers, one.shares); }}};
}

void add_figures(Hdf5Writer& file, Hdf5Writer::Group parent, const ToleranceReport& report) {
  const Hdf5Writer::Group group = file.add_group(parent, "metrics");
  file.add_variable(group, {"energy", "standard deviation of the energy moved by the actuators", "J", {}, {}},
                    std::span(&report.energy.deviation, 1));
  if (report.quantities.empty()) return;
  // every group has its own dimension, so that readers of one group see all its labels
  const Hdf5Writer::Dimension number =
      files::write_rows<study::TolerancedParameter>(file, group, report.numbers, {toleranced_number_fields().front()});
  std::vector<std::string> units;
  for (const QuantityTolerance& one : report.quantities) units.push_back(one.unit);
  write_rows(file, group, report.quantities, quantity_fields(report), results::common_unit(units), number);
}

}  // namespace

void write_tolerance(const std::string& path, const ToleranceReportData& view, const files::Provenance& description,
                     const files::WriteOptions& options) {
  if (!view.report) throw std::invalid_argument("only what is off along a trajectory is written");
  write_hdf5_file(path, description, options, [&](Hdf5Writer& file) {
    files::write_run_attributes(file, {}, description);
    files::write_result_variables(file, {}, view.report->run, options);
    const Hdf5Writer::Group group = file.add_group("tolerance");
    write_deviation_variables(file, group, view.report->deviation, options);
    write_rows(file, file.add_group(group, "numbers"), view.numbers, toleranced_number_fields());
    const auto& openings = view.report->incompatible_parameters;
    if (!openings.empty()) write_rows(file, file.add_group(group, "openings"), openings, opening_fields());
    add_figures(file, group, *view.report);
  });
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

std::string tolerance_json(const ToleranceReportData& view) {
  Json json = {{"mechanism", view.mechanism}, {"numbers", rows_json(view.numbers, toleranced_number_fields())}};
  json["openings"] = rows_json(incompatible_parameters_of(view), opening_fields());
  json["trajectory"] = view.report ? Json(view.trajectory) : Json(nullptr);
  json["first_order"] = nullptr;
  if (view.report)
    json["first_order"] = {{"quantities", rows_json(view.report->quantities, quantity_fields(*view.report))},
                           {"energy", figure_json(view.report->energy, view.report->numbers)},
                           {"notes", view.report->run.outcome.notes}};
  json["sampling"] = nullptr;
  if (view.sampling)
    json["sampling"] = {{"draws", view.draws.count},
                        {"seed", view.draws.seed},
                        {"drawn", view.sampling->run_count},
                        {"refused", view.sampling->rejections},
                        {"figures", rows_json(view.sampling->figures, sampled_figure_fields(view))}};
  json["at_rest"] = nullptr;
  if (view.at_rest)
    json["at_rest"] = {{"poses", view.at_rest->pose_count},
                       {"unreached", view.at_rest->unreachable_count},
                       {"actuators", rows_json(view.at_rest->actuators, static_deviation_fields(view))}};
  return files::format_json(json);
}

namespace {

std::string numbers_table(const Tolerances& numbers, const TextOptions& options) {
  using Row = study::TolerancedParameter;
  files::TextTable table = files::rows_table<Row>(numbers, toleranced_number_fields(), options.units,
                                                  [&](const Row& one) { return find_number_unit(one.path, options); });
  table.key_columns = 2;
  remove_empty_units(table);
  return format_table(table, options.width);
}

/// Numbers whose deviation would open joints.
std::string format_incompatible_parameters(const ToleranceReportData& view, const TextOptions& options) {
  const std::vector<tolerance::IncompatibleParameter>& openings = incompatible_parameters_of(view);
  if (openings.empty()) return "";
  return "\nover-constrained loops cannot follow these numbers on their own: their deviations would open joints, at "
         "least by the amounts listed. They are not included in ± and are not sampled\n" +
         format_table(rows_table(openings, opening_fields(), options.units), options.width);
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
  files::TextTable table = rows_table(report.quantities, figure_fields(report.numbers), options.units);
  table.key_columns = 2;
  table.blocks = {2, 4, 7, 9};
  return format_table(table, options.width);
}

std::string worst_table(const ToleranceReport& report, const TextOptions& options) {
  std::vector<QuantityTolerance> changing;
  for (const QuantityTolerance& one : report.quantities)
    if (one.worst.deviation > 0) changing.push_back(one);
  if (changing.empty()) return "nothing changes to first order\n";
  return format_table(rows_table(changing, worst_sample_fields(report, options.units), options.units), options.width);
}

std::string report_text(const ToleranceReportData& view, const TextOptions& options) {
  const DisplayUnit energy = files::find_display_unit("J", options.units);
  const ToleranceReport& report = *view.report;
  std::string text = fmt::format("\nalong {}, to first order: ± is the standard deviation\n{}", view.trajectory,
                                 figures_table(report, options));
  text += fmt::format("energy {} {} ± {}\n", files::format_figure(energy.convert(report.energy.value)), energy.name,
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
  files::TextTable table = rows_table(sampling.figures, sampled_figure_fields(view), options.units);
  table.key_columns = 2;
  table.blocks = {2, 4, 6, 9};
  return text + format_table(table, options.width);
}

std::string poses_at_rest_text(const ToleranceReportData& view, const TextOptions& options) {
  const tolerance::StaticTolerance& static_tolerance = *view.at_rest;
  std::string text = fmt::format("\nat rest, in all poses (whole turns, {} of a grid", static_tolerance.pose_count);
  text += static_tolerance.unreachable_count > 0
              ? fmt::format(", {} cannot be reached)\n", static_tolerance.unreachable_count)
              : ")\n";
  return text + format_table(
                    rows_table(static_tolerance.actuators, static_deviation_fields(view, options.units), options.units),
                    options.width);
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

}  // namespace balance::reports
