#include "balance/report/page_run.hpp"

#include "balance/base/elementary.hpp"
#include "balance/report/base64.hpp"
#include "balance/report/page_rows.hpp"
#include "balance/result/body_poses.hpp"
#include "balance/result/quantities.hpp"
#include "balance/result/round_off.hpp"
#include "balance/write/found_law.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace balance {
namespace {

/// Not every array of a result file is worth its bytes in a page.
constexpr std::array omitted_quantities = {"tool_orientation", "joint_moment", "body_position", "body_orientation"};

/// Planar poses are x, y, angle; spatial ones x, y, z and a quaternion.
Samples packed_poses(const Mechanism& mechanism, const RunResult& result) {
  const BodyPoses poses = body_poses(mechanism, result);
  const auto bodies = static_cast<Eigen::Index>(mechanism.bodies.size());
  const bool planar = mechanism.space == SpaceKind::planar;
  const Eigen::Index width = planar ? 3 : 7;
  Samples packed(result.time.size(), width * bodies);
  for (Eigen::Index k = 0; k < packed.rows(); ++k)
    for (Eigen::Index b = 0; b < bodies; ++b) {
      const auto turn = poses.orientation.row(k).segment<4>(4 * b);
      auto pose = packed.row(k).segment(width * b, width);
      if (planar) {
        pose.head<2>() = poses.position.row(k).segment<2>(3 * b);
        pose[2] = 2 * elementary::atan2(turn[3], turn[0]);
      } else {
        pose.head<3>() = poses.position.row(k).segment<3>(3 * b);
        pose.tail<4>() = turn;
      }
    }
  return packed;
}

/// Reactions by their size alone: a column a joint.
Samples magnitudes(const Samples& vectors, int axes) {
  Samples sizes(vectors.rows(), vectors.cols() / axes);
  for (Eigen::Index j = 0; j < sizes.cols(); ++j) sizes.col(j) = vectors.middleCols(j * axes, axes).rowwise().norm();
  return sizes;
}

std::vector<std::string> column_names(const Quantity& quantity, const RunResult& result) {
  using enum ColumnKind;
  switch (quantity.columns) {
    case coordinate: return result.coordinate_names;
    case actuator: return result.actuator_names;
    case joint:
    case joint_axis: return result.joint_names;
    case axis: return axis_labels(static_cast<int>(quantity.samples->cols()));
    case quaternion: return quaternion_labels();
    case constraint: return result.constraint_names;
    case sliding: return result.sliding_names;
    case single: return {"value"};
    case body:
    case body_axis:
    case body_quaternion: break;  // the picture has them
  }
  return {};
}

Json series_json(const RunResult& result) {
  Json list = Json::array();
  for (const Quantity& quantity : list_sampled_quantities(result)) {
    if (std::find(omitted_quantities.begin(), omitted_quantities.end(), std::string(quantity.name)) !=
        omitted_quantities.end())
      continue;
    const bool reaction = quantity.columns == ColumnKind::joint_axis;
    const Samples clean = suppress_round_off(result, quantity.member);
    const Samples samples = reaction ? magnitudes(clean, result.axes) : clean;
    list.push_back({{"quantity", quantity.name},
                    {"columns", column_names(quantity, result)},
                    {"units", quantity.units},
                    {"values", {{"f32", base64_float_columns(samples)}}}});
  }
  return list;
}

/// What bands are drawn of: as series, but as they are.
constexpr std::array band_quantities = {&RunResult::torque, &RunResult::shaking_force, &RunResult::shaking_moment};

Json deviation_json(const RunResult& deviation, const std::vector<Eigen::Index>& rows) {
  Json list = Json::array();
  for (const Quantity& quantity : list_sampled_quantities(deviation))
    if (std::find(band_quantities.begin(), band_quantities.end(), quantity.member) != band_quantities.end())
      list.push_back(
          {{"quantity", quantity.name},
           {"columns", column_names(quantity, deviation)},
           {"units", quantity.units},
           {"values", {{"f32", base64_float_columns((deviation.*quantity.member)(rows, Eigen::all).eval())}}}});
  return list;
}

/// As little as a picture needs.
Json phase_plane_json(const PhasePlane& plane) {
  const auto packed = [](const VectorX& values) { return Json{{"f32", base64_floats(Samples(values))}}; };
  return {{"time", packed(plane.time)},
          {"place", packed(plane.path_parameter)},
          {"rate", packed(plane.path_rate)},
          {"ceiling_place", packed(plane.mvc_path_parameter)},
          {"ceiling", packed(plane.mvc_path_rate)}};
}

}  // namespace

Json run_data_json(const Mechanism& mechanism, const RunResult& computed, const std::vector<Eigen::Index>& rows,
                   const RunResult* deviation) {
  Json json = {{"outcome", outcome_json(computed.outcome)}};
  if (computed.outcome.status != MotionStatus::done) return json;
  const bool all = static_cast<Eigen::Index>(rows.size()) == computed.time.size();
  const RunResult thinned = all ? RunResult{} : extract_rows(computed, rows);
  const RunResult& result = all ? computed : thinned;
  json["notes"] = result.outcome.notes;
  json["metrics"] = Json::array();
  for (const Metric& metric : result.metrics) json["metrics"].push_back(metric_json(metric));
  json["energy"] = result.energy;
  json["about"] = vector_json(result.moment_reference, result.axes);
  if (computed.corridor_result) json["found_corridor"] = corridor_result_json(*computed.corridor_result);
  if (computed.optimised_law) json["found_law"] = optimised_law_json(*computed.optimised_law);
  const PhasePlane& plane = computed.phase_plane;
  if (plane.time.size() > 1 && plane.mvc_path_rate.size() > 0) json["phase_plane"] = phase_plane_json(plane);
  json["samples"] = computed.time.size();
  json["time"] = {{"f64", base64_doubles(result.time)}};
  json["poses"] = {{"f32", base64_floats(packed_poses(mechanism, result))}};
  json["series"] = series_json(result);
  if (deviation != nullptr && deviation->time.size() == computed.time.size())
    json["deviation"] = deviation_json(*deviation, rows);
  return json;
}

}  // namespace balance
