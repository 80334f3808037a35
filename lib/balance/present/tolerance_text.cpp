#include "balance/present/tolerance_text.hpp"

#include "balance/write/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace balance {

namespace {

constexpr double disagreement_threshold = 4;
constexpr double min_listed_share = 0.005;

std::string tolerance_number(double value) { return value == 0 ? "0" : format_number(value); }

/// "0.12", with a star where other moments count, or a word where there is no slope.
std::string deviation_text(const FigureDeviation& figure) {
  if (std::isnan(figure.deviation)) return "kink";
  return tolerance_number(figure.deviation) + (figure.extremum_times.empty() ? "" : "*");
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

std::string numbers_table(const Tolerances& numbers) {
  TextTable table{
      {"number", "value", "deviation", "distribution"}, {Align::left, Align::right, Align::right, Align::left}, {}};
  for (const TolerancedParameter& one : numbers)
    table.rows.push_back(
        {one.path, tolerance_number(one.value), tolerance_number(one.deviation()),
         one.distribution == Distribution::normal ? "normal" : fmt::format("uniform, ± {:.6g}", one.width)});
  return format_table(table);
}

/// What no mechanism has, by number.
std::string format_incompatible_parameters(const ToleranceReportData& view) {
  const std::vector<IncompatibleParameter>& openings = incompatible_parameters_of(view);
  if (openings.empty()) return "";
  std::string text =
      "\nover-constrained loops cannot follow these numbers by themselves: their deviations would open joints, the\n"
      "rest being moved so that it is least. They have no part in what is behind ±, and are not drawn\n";
  TextTable table{{"number", "joint", "opens by", "unit"}, {Align::left, Align::left, Align::right, Align::left}, {}};
  for (const IncompatibleParameter& one : openings)
    table.rows.push_back({one.key_path, one.joint, tolerance_number(one.gap), one.unit});
  return text + format_table(table);
}

/// Peaks and ranges that may come to be at other moments, and when.
std::string format_extremum_times(const ToleranceReport& report) {
  std::string text;
  for (const QuantityTolerance& one : report.quantities)
    for (const auto& [word, figure] : {std::pair{"peak", &one.peak}, {"range", &one.range}}) {
      if (figure->extremum_times.empty()) continue;
      std::vector<std::string> times;
      for (const double time : figure->extremum_times) times.push_back(fmt::format("{:.4g}", time));
      text += fmt::format("  {} of {}: at {} s\n", word, one.quantity, fmt::join(times, ", "));
    }
  if (text.empty()) return "";
  return "*: which moment is the largest depends on the numbers; ± is that of the largest of them, good to a "
         "hundredth\n" +
         text;
}

std::string figures_table(const ToleranceReport& report) {
  TextTable table{{"quantity", "unit", "peak", "±", "rms", "±", "expected rms", "mean", "±", "range", "±"},
                  {Align::left, Align::left},
                  {}};
  table.align.resize(table.heading.size(), Align::right);
  for (const QuantityTolerance& one : report.quantities)
    table.rows.push_back({one.quantity, one.unit, tolerance_number(one.peak.value), deviation_text(one.peak),
                          tolerance_number(one.rms.value), deviation_text(one.rms), tolerance_number(one.expected_rms),
                          tolerance_number(one.mean.value), deviation_text(one.mean), tolerance_number(one.range.value),
                          deviation_text(one.range)});
  return format_table(table);
}

std::string pose_text(const ToleranceReport& report, long row) {
  constexpr std::size_t max_listed_pose_coordinates = 4;
  std::string text;
  for (std::size_t c = 0; c < std::min(max_listed_pose_coordinates, report.run.coordinate_names.size()); ++c)
    text += fmt::format("{}{} {:.4g}", c == 0 ? "" : ", ", report.run.coordinate_names[c],
                        report.run.joint_position(row, static_cast<Eigen::Index>(c)));
  return report.run.coordinate_names.size() > max_listed_pose_coordinates ? text + ", …" : text;
}

std::string worst_table(const ToleranceReport& report) {
  TextTable table{{"worst sample of", "time [s]", "value", "±", "pose", "what makes it so"},
                  {Align::left, Align::right, Align::right, Align::right, Align::left, Align::left},
                  {}};
  for (const QuantityTolerance& one : report.quantities)
    if (one.worst.deviation > 0)
      table.rows.push_back({one.quantity, fmt::format("{:.4g}", one.worst.time), tolerance_number(one.worst.value),
                            tolerance_number(one.worst.deviation), pose_text(report, one.worst.row),
                            shares_text(report.numbers, one.worst.shares)});
  return table.rows.empty() ? "nothing changes to first order\n" : format_table(table);
}

std::string report_text(const ToleranceReportData& view) {
  const ToleranceReport& report = *view.report;
  std::string text = fmt::format("\nalong {}, to first order: standard deviations behind ±\n{}", view.trajectory,
                                 figures_table(report));
  text += fmt::format("energy {} J ± {}\n", tolerance_number(report.energy.value), deviation_text(report.energy));
  text +=
      "kink: the figure is not three times its own deviations, so it has no slope there; the expected rms has\n"
      "their squares, and --monte-carlo its distribution\n";
  text += format_extremum_times(report);
  for (const std::string& note : report.run.outcome.notes) text += "note: " + note + "\n";
  return text + "\n" + worst_table(report);
}

std::string sampling_text(const ToleranceReportData& view) {
  const MonteCarloReport& found = *view.sampling;
  std::string text = fmt::format("\n{} of {} draws, seed {}\n", found.run_count, view.draws.count, view.draws.seed);
  for (const auto& [why, count] : found.rejections) text += fmt::format("  {} refused: {}\n", count, why);
  if (found.figures.empty()) return text;
  TextTable table{{"figure", "mean", "±", "deviation", "±", "5 %", "50 %", "95 %", "first order"}, {Align::left}, {}};
  table.align.resize(table.heading.size(), Align::right);
  constexpr const char* words[] = {"peak", "rms", "mean", "range"};
  for (const SampledFigure& one : found.figures) {
    const double errors = sampling_disagreement(*view.report, one);
    table.rows.push_back({fmt::format("{} {}", words[static_cast<int>(one.figure)], one.quantity),
                          tolerance_number(one.mean), fmt::format("{:.2g}", one.mean_error),
                          tolerance_number(one.deviation), fmt::format("{:.2g}", one.deviation_error),
                          tolerance_number(one.quantiles[0]), tolerance_number(one.quantiles[1]),
                          tolerance_number(one.quantiles[2]),
                          std::isnan(errors)                 ? "-"
                          : errors <= disagreement_threshold ? "agrees"
                                                             : fmt::format("{:.1f} errors off", errors)});
  }
  return text + format_table(table);
}

std::string poses_at_rest_text(const ToleranceReportData& view) {
  const StaticTolerance& rest = *view.at_rest;
  std::string text = fmt::format("\nat rest, in all poses (whole turns, {} of a grid", rest.pose_count);
  text += rest.unreachable_count > 0 ? fmt::format(", {} cannot be taken)\n", rest.unreachable_count) : ")\n";
  TextTable table{{"actuator", "unit", "largest ±", "effort there", "pose", "what makes it so"},
                  {Align::left, Align::left, Align::right, Align::right, Align::left, Align::left},
                  {}};
  for (const StaticDeviation& one : rest.actuators) {
    std::string pose;
    for (std::size_t k = 0; k < rest.coordinates.size(); ++k)
      pose +=
          fmt::format("{}{} {:.4g}", k == 0 ? "" : ", ", rest.coordinates[k], one.pose[static_cast<Eigen::Index>(k)]);
    table.rows.push_back({one.actuator, one.unit, tolerance_number(one.deviation), tolerance_number(one.effort), pose,
                          shares_text(view.numbers, one.shares)});
  }
  return text + format_table(table);
}

}  // namespace

std::string tolerance_text(const ToleranceReportData& view) {
  std::string text = fmt::format("{}\nnumbers that may be off, independently of each other\n{}", view.mechanism,
                                 numbers_table(view.numbers));
  text += format_incompatible_parameters(view);
  if (view.report) text += report_text(view);
  if (view.sampling) text += sampling_text(view);
  if (view.at_rest) text += poses_at_rest_text(view);
  return text;
}

}  // namespace balance
