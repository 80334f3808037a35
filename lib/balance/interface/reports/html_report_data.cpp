#include "balance/interface/reports/html_report_data.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/files/optimised_law_summary.hpp"
#include "balance/interface/files/order_summary.hpp"
#include "balance/interface/files/torque_distribution_summary.hpp"
#include "balance/mechanics/model/load_table.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/mechanics/results/orders.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <stdexcept>

/// Indices are plain numbers.
template <class Kind>
struct nlohmann::adl_serializer<balance::TypedIndex<Kind>> {
  static void to_json(balance::Json& json, const balance::TypedIndex<Kind>& id) { json = static_cast<int>(id); }
};

namespace balance::reports {
namespace {

static_assert(std::endian::native == std::endian::little, "the page's samples are little-endian");

template <class Number>
void append(std::string& bytes, Number number) {
  char raw[sizeof number];
  std::memcpy(raw, &number, sizeof number);
  bytes.append(raw, sizeof number);
}

}  // namespace

std::string base64(std::string_view bytes) {
  static constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

std::string base64_floats(const Samples& samples) {
  std::string bytes;
  bytes.reserve(static_cast<std::size_t>(samples.size()) * sizeof(float));
  for (Eigen::Index i = 0; i < samples.rows(); ++i)
    for (Eigen::Index j = 0; j < samples.cols(); ++j) append(bytes, static_cast<float>(samples(i, j)));
  return base64(bytes);
}

std::string base64_float_columns(const Samples& samples) { return base64_floats(Samples(samples.transpose())); }

std::string base64_doubles(const VectorX& numbers) {
  std::string bytes;
  for (const double number : numbers) append(bytes, number);
  return base64(bytes);
}

namespace {

Json position_json(const Vector3& p) { return files::vector_json(p, 3); }

Json inertia_json(const Matrix3& inertia, SpaceKind space) {
  if (space == SpaceKind::planar) return std::array{inertia(2, 2)};
  const double xy = inertia(0, 1), xz = inertia(0, 2), yz = inertia(1, 2);
  if (xy == 0 && xz == 0 && yz == 0) return std::array{inertia(0, 0), inertia(1, 1), inertia(2, 2)};
  return std::array{inertia(0, 0), inertia(1, 1), inertia(2, 2), xy, xz, yz};
}

Json named_point_json(const model::NamedPoint& point) {
  return {{"name", point.name}, {"position", position_json(point.position)}};
}

Json body_json(const Body& body, SpaceKind space) {
  return {{"name", body.name},
          {"mass", body.mass},
          {"com", position_json(body.com)},
          {"inertia", inertia_json(body.inertia, space)},
          {"points", files::list_json(body.points, named_point_json)}};
}

Json joint_json(const Joint& joint) {
  Json json = {{"name", joint.name},
               {"type", name_of(joint.type)},
               {"first", joint.first},
               {"second", joint.second},
               {"point_first", position_json(joint.point_first)},
               {"point_second", position_json(joint.point_second)},
               {"axis", position_json(joint.axis)}};
  if (is_rolling(joint.type)) json["radius"] = joint.radius;
  if (joint.type == JointType::rolling_disc)  // the disc's own axis, in its frame
    json["spin"] = position_json(joint.rotation.transpose() * joint.axis.cross(joint.axis2));
  return json;
}

const char* shape_kind_name(model::ShapeKind kind) {
  switch (kind) {
    case model::ShapeKind::cylinder: return "cylinder";
    case model::ShapeKind::ring: return "ring";
    case model::ShapeKind::sector: return "sector";
    case model::ShapeKind::plate: return "plate";
  }
  return "";
}

Json shape_json(const model::Shape& shape) {
  return {{"kind", shape_kind_name(shape.kind)},
          {"diameter", shape.diameter},
          {"inner_diameter", shape.inner_diameter},
          {"length", shape.length},
          {"width", shape.width},
          {"thickness", shape.thickness},
          {"opening", shape.opening},
          {"axis_distance", shape.axis_distance},
          {"direction", position_json(shape.rotation.col(0))},
          {"axis", position_json(shape.rotation.col(2))}};
}

Json attachment_json(const Attachment& a) {
  return {{"name", a.name},
          {"shape", a.shape ? shape_json(*a.shape) : Json(nullptr)},
          {"kind", a.kind == AttachmentKind::counterweight ? "counterweight" : "payload"},
          {"body", a.body},
          {"position", position_json(a.position)},
          {"mass", a.mass}};
}

Json term_json(const model::CoordinateTerm& term) { return {{"coordinate", term.coordinate}, {"ratio", term.ratio}}; }

Json disc_json(const Disc& disc) {
  return {{"name", disc.name},
          {"body", disc.body},
          {"position", position_json(disc.position)},
          {"axis", position_json(disc.axis)},
          {"follows", files::list_json(disc.follows.terms, term_json)},
          {"ratio", disc.ratio},
          {"mass", disc.mass},
          {"axial", disc.axis.dot(disc.inertia * disc.axis)}};
}

Json spring_json(const Spring& spring) {
  return {{"name", spring.name},
          {"first", spring.first},
          {"second", spring.second},
          {"point_first", position_json(spring.point_first)},
          {"point_second", position_json(spring.point_second)},
          {"stiffness", spring.stiffness},
          {"free_length", spring.free_length},
          {"preload", spring.preload},
          {"coordinate", spring.coordinate}};
}

/// A damper, or a spring with a table.
Json force_element_json(const ForceElement& element) {
  const auto largest = element.is_damper() ? 0 : model::ForceLawOf<double>(element.table).max_force();
  return {{"name", element.name},
          {"is_damper", element.is_damper()},
          {"first", element.first},
          {"second", element.second},
          {"point_first", position_json(element.point_first)},
          {"point_second", position_json(element.point_second)},
          {"damping", element.damping},
          {"rows", element.table.force.size()},
          {"largest", largest},
          {"coordinate", element.coordinate}};
}

Json coordinate_json(const Coordinate& coordinate) {
  return {{"name", coordinate.name},
          {"joint", coordinate.joint},
          {"unit", coordinate.kind == CoordinateKind::angle ? "rad" : "m"}};
}

Json coupling_json(const Coupling& coupling) {
  return {{"follower", coupling.follower},
          {"leaders", files::list_json(coupling.leader.terms, term_json)},
          {"ratio", coupling.ratio},
          {"offset", coupling.offset}};
}

/// The load with straight lines between its entries, close enough for a picture.
Load straighten_load(const Load& load) {
  constexpr int lines_per_entry = 8;
  if (!load.is_spline) return load;
  const model::LoadTable<double> table(load);
  Load straight = load;
  straight.arguments.clear(), straight.force.clear(), straight.moment.clear();
  const auto add = [&](double argument, const Vector3& force, const Vector3& moment) {
    straight.arguments.push_back(argument), straight.force.push_back(force), straight.moment.push_back(moment);
  };
  for (std::size_t k = 0; k + 1 < load.arguments.size(); ++k)
    for (int line = 0; line < lines_per_entry; ++line) {
      const double part = static_cast<double>(line) / lines_per_entry;
      const double argument = (1 - part) * load.arguments[k] + part * load.arguments[k + 1];
      Vector3 force, moment;
      table.evaluate(argument, force, moment);
      add(argument, force, moment);
    }
  add(load.arguments.back(), load.force.back(), load.moment.back());
  return straight;
}

Json load_json(const Load& load) {
  const Load rows = straighten_load(load);
  return {{"name", load.name},
          {"body", load.body},
          {"point", position_json(load.point)},
          {"frame", load.frame == model::Frame::world ? "world" : "body"},
          {"coordinate", load.coordinate},
          {"arguments", rows.arguments},
          {"is_periodic", load.is_periodic},
          {"force", files::list_json(rows.force, position_json)},
          {"moment", files::list_json(rows.moment, position_json)}};
}

Json friction_json(const Friction& friction) {
  return {{"coordinate", friction.coordinate},
          {"viscous", friction.viscous},
          {"coulomb", friction.dry_friction(1)},
          {"coulomb_backward", friction.dry_friction(-1)}};
}

}  // namespace

Json mechanism_json(const Mechanism& mechanism) {
  Json json = {{"length", characteristic_length(mechanism)},
               {"bodies",
                files::list_json(mechanism.bodies, [&](const Body& body) { return body_json(body, mechanism.space); })},
               {"joints", files::list_json(mechanism.joints, joint_json)},
               {"attachments", files::list_json(mechanism.attachments, attachment_json)},
               {"discs", files::list_json(mechanism.discs, disc_json)},
               {"springs", files::list_json(mechanism.springs, spring_json)},
               {"force_elements", files::list_json(mechanism.force_elements, force_element_json)},
               {"coordinates", files::list_json(mechanism.coordinates, coordinate_json)},
               {"couplings", files::list_json(mechanism.couplings, coupling_json)},
               {"loads", files::list_json(mechanism.loads, load_json)},
               {"friction", files::list_json(mechanism.friction, friction_json)}};
  json["actuated"] = files::list_json(mechanism.actuators, [&](int actuator) {
    return mechanism.coordinates[static_cast<std::size_t>(actuator)].joint;
  });
  json["tool"] = nullptr;
  if (mechanism.tool)
    json["tool"] = {{"body", mechanism.tool->body}, {"position", position_json(mechanism.tool->position)}};
  return json;
}

namespace {

/// Significance of the rows of a run: the maximum over its columns.
class RowSignificance {
 public:
  RowSignificance(Eigen::Index rows, const std::vector<Eigen::Index>& spaced_rows)
      : spaced_rows_(spaced_rows), significance_(static_cast<std::size_t>(rows), 0) {}

  void add_column(const Samples& samples, Eigen::Index column) {
    if (samples.rows() == 0) return;
    const Eigen::Index low = numerics::min_index(samples.col(column)), high = numerics::max_index(samples.col(column));
    const double minimum = samples(low, column), maximum = samples(high, column);
    if (!(maximum > minimum)) return;
    raise(low, std::numeric_limits<double>::infinity());
    raise(high, std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i + 1 < spaced_rows_.size(); ++i)
      add_segment_extremes(samples, column, spaced_rows_[i], spaced_rows_[i + 1], maximum - minimum);
  }

  const std::vector<double>& values() const { return significance_; }

 private:
  void raise(Eigen::Index row, double significance) {
    double& value = significance_[static_cast<std::size_t>(row)];
    value = std::max(value, significance);
  }

  /// Raises the two rows between first and last that are farthest above and below the straight line.
  void add_segment_extremes(const Samples& samples, Eigen::Index column, Eigen::Index first, Eigen::Index last,
                            double span) {
    const double start = samples(first, column);
    const double slope = (samples(last, column) - start) / static_cast<double>(last - first);
    double max_deviation = 0, min_deviation = 0;
    Eigen::Index high = first, low = first;
    for (Eigen::Index k = first + 1; k < last; ++k) {
      const double deviation = samples(k, column) - start - slope * static_cast<double>(k - first);
      if (deviation > max_deviation) max_deviation = deviation, high = k;
      if (deviation < min_deviation) min_deviation = deviation, low = k;
    }
    if (max_deviation > 0) raise(high, max_deviation / span);
    if (min_deviation < 0) raise(low, -min_deviation / span);
  }

  const std::vector<Eigen::Index>& spaced_rows_;
  std::vector<double> significance_;
};

}  // namespace

std::vector<Eigen::Index> select_display_rows(const std::vector<const RunResult*>& runs, Eigen::Index max_rows) {
  const Eigen::Index row_count = runs.front()->time.size();
  std::vector<Eigen::Index> rows;
  if (row_count <= max_rows) {
    rows.resize(static_cast<std::size_t>(row_count));
    std::iota(rows.begin(), rows.end(), Eigen::Index{0});
    return rows;
  }
  const Eigen::Index spaced_count = max_rows / 2;
  for (Eigen::Index i = 0; i < spaced_count; ++i) rows.push_back(i * (row_count - 1) / (spaced_count - 1));
  RowSignificance significance(row_count, rows);
  for (const RunResult* run : runs)
    for (const Quantity& quantity : list_sampled_quantities(*run))
      for (Eigen::Index c = 0; c < quantity.samples->cols(); ++c) significance.add_column(*quantity.samples, c);
  std::vector<Eigen::Index> candidates;
  for (Eigen::Index k = 0; k < row_count; ++k)
    if (significance.values()[static_cast<std::size_t>(k)] > 0) candidates.push_back(k);
  const auto is_more_significant = [&](Eigen::Index a, Eigen::Index b) {
    return significance.values()[static_cast<std::size_t>(a)] > significance.values()[static_cast<std::size_t>(b)];
  };
  const auto candidate_count = std::min(static_cast<std::size_t>(max_rows) - rows.size(), candidates.size());
  std::partial_sort(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(candidate_count),
                    candidates.end(), is_more_significant);
  rows.insert(rows.end(), candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(candidate_count));
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

RunResult extract_rows(const RunResult& result, const std::vector<Eigen::Index>& rows) {
  RunResult extracted;  // not a copy, which would duplicate a million samples
  extracted.outcome = result.outcome;
  extracted.coordinate_names = result.coordinate_names;
  extracted.coordinate_units = result.coordinate_units;
  extracted.joint_names = result.joint_names;
  extracted.actuator_names = result.actuator_names;
  extracted.actuator_units = result.actuator_units;
  extracted.body_names = result.body_names;
  extracted.constraint_names = result.constraint_names;
  extracted.constraint_units = result.constraint_units;
  extracted.sliding_names = result.sliding_names;
  extracted.sliding_units = result.sliding_units;
  extracted.axes = result.axes;
  extracted.moment_axes = result.moment_axes;
  extracted.moment_reference = result.moment_reference;
  extracted.metrics = result.metrics;
  extracted.energy = result.energy;
  extracted.round_off = result.round_off;
  extracted.time = result.time(rows);
  if (result.newton_iterations.size() > 0) extracted.newton_iterations = result.newton_iterations(rows);
  for (const Quantity& quantity : list_sampled_quantities(result))
    extracted.*quantity.member = (result.*quantity.member)(rows, Eigen::all);
  return extracted;
}

namespace {

/// Arrays of a result file that the page does not need.
constexpr std::array omitted_quantities = {"tool_orientation", "joint_moment", "body_position", "body_orientation"};

/// The positions of a run that moves no counterweights, or not all of those that have a slide in the mechanism.
RunResult with_slides_at_rest(const Mechanism& mechanism, const RunResult& run) {
  RunResult result;
  result.time = run.time;
  result.joint_position.setZero(run.joint_position.rows(), static_cast<Eigen::Index>(mechanism.coordinates.size()));
  for (const Coordinate& coordinate : mechanism.coordinates) {
    const auto name = std::find(run.coordinate_names.begin(), run.coordinate_names.end(), coordinate.name);
    if (name != run.coordinate_names.end())
      result.joint_position.col(static_cast<Eigen::Index>(result.coordinate_names.size())) =
          run.joint_position.col(name - run.coordinate_names.begin());
    result.coordinate_names.push_back(coordinate.name);
  }
  return result;
}

/// Planar poses are x, y, angle; spatial poses x, y, z and a quaternion.
Samples packed_poses(const Mechanism& mechanism, const RunResult& result) {
  const bool lacks_slides = result.coordinate_names.size() < mechanism.coordinates.size();
  const results::BodyPoses poses =
      body_poses(mechanism, lacks_slides ? with_slides_at_rest(mechanism, result) : result);
  const auto bodies = static_cast<Eigen::Index>(mechanism.bodies.size());
  const bool planar = mechanism.space == SpaceKind::planar;
  const Eigen::Index width = planar ? 3 : 7;
  Samples packed(result.time.size(), width * bodies);
  for (Eigen::Index k = 0; k < packed.rows(); ++k)
    for (Eigen::Index b = 0; b < bodies; ++b) {
      const auto quaternion = poses.orientation.row(k).segment<4>(4 * b);
      auto pose = packed.row(k).segment(width * b, width);
      if (planar) {
        pose.head<2>() = poses.position.row(k).segment<2>(3 * b);
        pose[2] = 2 * elementary::atan2(quaternion[3], quaternion[0]);
      } else {
        pose.head<3>() = poses.position.row(k).segment<3>(3 * b);
        pose.tail<4>() = quaternion;
      }
    }
  return packed;
}

/// Magnitudes of reactions, one column per joint.
Samples magnitudes(const Samples& vectors, int axes) {
  Samples norms(vectors.rows(), vectors.cols() / axes);
  for (Eigen::Index j = 0; j < norms.cols(); ++j) norms.col(j) = vectors.middleCols(j * axes, axes).rowwise().norm();
  return norms;
}

std::vector<std::string> column_names(const Quantity& quantity, const RunResult& result) {
  using enum results::ColumnKind;
  switch (quantity.columns) {
    case coordinate: return result.coordinate_names;
    case actuator: return result.actuator_names;
    case joint:
    case joint_axis: return result.joint_names;
    case axis: return results::axis_labels(static_cast<int>(quantity.samples->cols()));
    case quaternion: return results::quaternion_labels();
    case constraint: return result.constraint_names;
    case sliding: return result.sliding_names;
    case single: return {"value"};
    case body:
    case body_axis:
    case body_quaternion: break;  // `poses` contains them
  }
  return {};
}

Json series_json(const RunResult& result) {
  Json list = Json::array();
  for (const Quantity& quantity : list_sampled_quantities(result)) {
    if (std::find(omitted_quantities.begin(), omitted_quantities.end(), std::string(quantity.name)) !=
        omitted_quantities.end())
      continue;
    const bool reaction = quantity.columns == results::ColumnKind::joint_axis;
    const Samples filtered = suppress_round_off(result, quantity.member);
    const Samples samples = reaction ? magnitudes(filtered, result.axes) : filtered;
    list.push_back({{"quantity", quantity.name},
                    {"columns", column_names(quantity, result)},
                    {"units", quantity.units},
                    {"values", {{"f32", base64_float_columns(samples)}}}});
  }
  return list;
}

/// Quantities with bands of their deviation: like the series, but without suppressed round-off.
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

/// Only what a picture needs.
Json phase_plane_json(const trajectory::PhasePlane& plane) {
  const auto packed = [](const VectorX& values) { return Json{{"f32", base64_floats(Samples(values))}}; };
  return {{"time", packed(plane.time)},
          {"place", packed(plane.path_parameter)},
          {"rate", packed(plane.path_rate)},
          {"ceiling_place", packed(plane.mvc_path_parameter)},
          {"ceiling", packed(plane.mvc_path_rate)}};
}

/// The orders of efforts, shaking force and shaking moment, without their components; null where nothing turns at constant
/// speed or the run does not repeat.
Json main_orders_json(const RunResult& result) {
  constexpr int highest_order = 8;
  results::OrderAnalysis analysis;
  try {
    analysis = results::analyse_orders(result, highest_order);
  } catch (const std::invalid_argument&) {
    return nullptr;
  }
  std::erase_if(analysis.quantities, [](const results::QuantityOrders& quantity) {
    const std::string& name = quantity.quantity;
    return !name.starts_with("torque[") && !name.starts_with("force[") && name != "shaking_force" &&
           name != "shaking_moment";
  });
  return files::orders_json(analysis);
}

}  // namespace

Json run_data_json(const Mechanism& mechanism, const RunResult& computed, const std::vector<Eigen::Index>& rows,
                   const RunResult* deviation) {
  Json json = {{"outcome", files::outcome_json(computed.outcome)}};
  if (computed.outcome.status != MotionStatus::done) return json;
  const bool is_complete = static_cast<Eigen::Index>(rows.size()) == computed.time.size();
  const RunResult thinned = is_complete ? RunResult{} : extract_rows(computed, rows);
  const RunResult& result = is_complete ? computed : thinned;
  json["notes"] = result.outcome.notes;
  json["metrics"] = files::metrics_json(result.metrics);
  json["energy"] = result.energy;
  json["about"] = files::vector_json(result.moment_reference, result.axes);
  if (computed.corridor_result) json["found_corridor"] = files::corridor_result_json(*computed.corridor_result);
  if (computed.torque_distribution) json["torque_distribution"] = files::torque_distribution_json(computed);
  if (Json orders = main_orders_json(computed); !orders.is_null()) json["orders"] = std::move(orders);
  if (computed.optimised_law) json["found_law"] = files::optimised_law_json(*computed.optimised_law);
  const trajectory::PhasePlane& plane = computed.phase_plane;
  if (plane.time.size() > 1 && plane.mvc_path_rate.size() > 0) json["phase_plane"] = phase_plane_json(plane);
  json["samples"] = computed.time.size();
  json["time"] = {{"f64", base64_doubles(result.time)}};
  json["poses"] = {{"f32", base64_floats(packed_poses(mechanism, result))}};
  json["series"] = series_json(result);
  if (deviation != nullptr && deviation->time.size() == computed.time.size())
    json["deviation"] = deviation_json(*deviation, rows);
  return json;
}

}  // namespace balance::reports
