#include "balance/present/tolerance_json.hpp"

#include "balance/analysis/objective.hpp"
#include "balance/write/json_parts.hpp"

namespace balance {

namespace {

Json by_number(const Tolerances& numbers, const VectorX& values) {
  Json json = Json::object();
  for (std::size_t i = 0; i < numbers.size() && static_cast<Eigen::Index>(i) < values.size(); ++i)
    json[numbers[i].path] = values[static_cast<Eigen::Index>(i)];
  return json;
}

Json figure_json(const FigureDeviation& figure, const Tolerances& numbers) {
  return {{"value", figure.value},
          {"deviation", figure.deviation},
          {"by_number", by_number(numbers, figure.contributions)},
          {"rival_times", figure.extremum_times}};
}

Json worst_json(const WorstSample& worst, const ToleranceReport& report) {
  Json pose = Json::object();
  for (std::size_t c = 0; c < report.run.coordinate_names.size(); ++c)
    pose[report.run.coordinate_names[c]] = report.run.joint_position(worst.row, static_cast<Eigen::Index>(c));
  return {{"time", worst.time},
          {"value", worst.value},
          {"deviation", worst.deviation},
          {"coordinates", std::move(pose)},
          {"shares", by_number(report.numbers, worst.shares)}};
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
  for (const IncompatibleParameter& one : incompatible_parameters_of(view))
    openings.push_back({{"number", one.key_path}, {"joint", one.joint}, {"gap", one.gap}, {"unit", one.unit}});
  return openings;
}

Json sampling_json(const ToleranceReportData& view) {
  if (!view.sampling) return nullptr;
  Json figures = Json::array();
  for (const SampledFigure& one : view.sampling->figures)
    figures.push_back({{"quantity", one.quantity},
                       {"figure", objective_term_name(one.figure)},
                       {"unit", one.unit},
                       {"mean", one.mean},
                       {"mean_error", one.mean_error},
                       {"deviation", one.deviation},
                       {"deviation_error", one.deviation_error},
                       {"quantiles", {{"5", one.quantiles[0]}, {"50", one.quantiles[1]}, {"95", one.quantiles[2]}}},
                       {"disagreement", view.report ? Json(sampling_disagreement(*view.report, one)) : Json(nullptr)}});
  Json refused = Json::object();
  for (const auto& [why, count] : view.sampling->rejections) refused[why] = count;
  return {{"draws", view.draws.count},
          {"seed", view.draws.seed},
          {"drawn", view.sampling->run_count},
          {"refused", std::move(refused)},
          {"figures", std::move(figures)}};
}

Json poses_at_rest_json(const ToleranceReportData& view) {
  if (!view.at_rest) return nullptr;
  const StaticTolerance& rest = *view.at_rest;
  Json actuators = Json::array();
  for (const StaticDeviation& one : rest.actuators) {
    Json pose = Json::object();
    for (std::size_t k = 0; k < rest.coordinates.size(); ++k)
      pose[rest.coordinates[k]] = one.pose[static_cast<Eigen::Index>(k)];
    actuators.push_back({{"actuator", one.actuator},
                         {"unit", one.unit},
                         {"deviation", one.deviation},
                         {"effort", one.effort},
                         {"coordinates", std::move(pose)},
                         {"shares", by_number(view.numbers, one.shares)}});
  }
  return {{"poses", rest.pose_count}, {"unreached", rest.unreachable_count}, {"actuators", std::move(actuators)}};
}

}  // namespace

std::string tolerance_json(const ToleranceReportData& view) {
  Json numbers = Json::array();
  for (const TolerancedParameter& one : view.numbers)
    numbers.push_back({{"path", one.path},
                       {"value", one.value},
                       {"distribution", one.distribution == Distribution::normal ? "normal" : "uniform"},
                       {"width", one.width},
                       {"deviation", one.deviation()}});
  Json json = {{"mechanism", view.mechanism}, {"numbers", std::move(numbers)}};
  json["openings"] = incompatible_parameters_json(view);
  json["trajectory"] = view.report ? Json(view.trajectory) : Json(nullptr);
  json["first_order"] = view.report ? report_json(*view.report) : Json(nullptr);
  json["sampling"] = sampling_json(view);
  json["at_rest"] = poses_at_rest_json(view);
  return format_json(json);
}

}  // namespace balance
