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
          {"by_number", by_number(numbers, figure.by_number)},
          {"rival_times", figure.rivals}};
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

Json openings_json(const ToleranceView& view) {
  Json openings = Json::array();
  for (const NumberOpening& one : openings_of(view))
    openings.push_back({{"number", one.path}, {"joint", one.joint}, {"gap", one.gap}, {"unit", one.unit}});
  return openings;
}

Json sampling_json(const ToleranceView& view) {
  if (!view.sampling) return nullptr;
  Json figures = Json::array();
  for (const SampledFigure& one : view.sampling->figures)
    figures.push_back({{"quantity", one.quantity},
                       {"figure", name_of(one.figure)},
                       {"unit", one.unit},
                       {"mean", one.mean},
                       {"mean_error", one.mean_error},
                       {"deviation", one.deviation},
                       {"deviation_error", one.deviation_error},
                       {"quantiles", {{"5", one.quantiles[0]}, {"50", one.quantiles[1]}, {"95", one.quantiles[2]}}},
                       {"disagreement", view.report ? Json(disagreement(*view.report, one)) : Json(nullptr)}});
  Json refused = Json::object();
  for (const auto& [why, count] : view.sampling->refused) refused[why] = count;
  return {{"draws", view.draws.count},
          {"seed", view.draws.seed},
          {"drawn", view.sampling->drawn},
          {"refused", std::move(refused)},
          {"figures", std::move(figures)}};
}

Json poses_at_rest_json(const ToleranceView& view) {
  if (!view.at_rest) return nullptr;
  const RestTolerance& rest = *view.at_rest;
  Json actuators = Json::array();
  for (const RestDeviation& one : rest.actuators) {
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
  return {{"poses", rest.poses}, {"unreached", rest.unreached}, {"actuators", std::move(actuators)}};
}

}  // namespace

std::string tolerance_json(const ToleranceView& view) {
  Json numbers = Json::array();
  for (const ToleranceNumber& one : view.numbers)
    numbers.push_back({{"path", one.path},
                       {"value", one.value},
                       {"distribution", one.spread == Spread::normal ? "normal" : "uniform"},
                       {"width", one.width},
                       {"deviation", one.deviation()}});
  Json json = {{"mechanism", view.mechanism}, {"numbers", std::move(numbers)}};
  json["openings"] = openings_json(view);
  json["trajectory"] = view.report ? Json(view.trajectory) : Json(nullptr);
  json["first_order"] = view.report ? report_json(*view.report) : Json(nullptr);
  json["sampling"] = sampling_json(view);
  json["at_rest"] = poses_at_rest_json(view);
  return dump(json);
}

}  // namespace balance
