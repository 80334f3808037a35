#include "balance/mechanics/results/run_quantities.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace balance::results {

namespace {

/// Names of what the columns of a quantity belong to; null: of a whole scalar or vector.
const std::vector<std::string>* owner_names(ColumnKind columns, const RunResult& run) {
  switch (columns) {
    case ColumnKind::coordinate: return &run.coordinate_names;
    case ColumnKind::actuator: return &run.actuator_names;
    case ColumnKind::joint:
    case ColumnKind::joint_axis: return &run.joint_names;
    case ColumnKind::constraint: return &run.constraint_names;
    case ColumnKind::sliding: return &run.sliding_names;
    case ColumnKind::body:
    case ColumnKind::body_axis:
    case ColumnKind::body_quaternion: return &run.body_names;
    case ColumnKind::single:
    case ColumnKind::axis:
    case ColumnKind::quaternion: return nullptr;
  }
  return nullptr;
}

std::vector<std::string> component_names(const QuantityDefinition& kind, const RunResult& run) {
  switch (columns_of(kind, run)) {
    case ColumnKind::axis:
    case ColumnKind::joint_axis:
    case ColumnKind::body_axis: return axis_labels(run.axes);
    case ColumnKind::quaternion:
    case ColumnKind::body_quaternion: return quaternion_labels();
    default:
      if (kind.shape == QuantityDefinition::Shape::moment) return {"z"};
      return {};
  }
}

/// The name without spaces, as in inertia[J1,J2].
std::string without_spaces(std::string name) {
  std::erase(name, ' ');
  return name;
}

VectorX angular_components(const Vector3& w, int moment_axes) {
  if (moment_axes == 1) return VectorX::Constant(1, w.z());
  return w;
}

/// Arrays that follow from the motion and the geometry alone.
bool is_kinematic(Samples RunResult::*array) {
  constexpr std::array arrays = {&RunResult::joint_position,     &RunResult::joint_velocity,
                                 &RunResult::joint_acceleration, &RunResult::tool_position,
                                 &RunResult::tool_orientation,   &RunResult::mobility,
                                 &RunResult::body_position,      &RunResult::body_orientation};
  return std::find(arrays.begin(), arrays.end(), array) != arrays.end();
}

}  // namespace

double distance_to_segment(const Vector3& point, const Vector3& begin, const Vector3& end) {
  const Vector3 direction = end - begin;
  const double squared_length = direction.squaredNorm();
  const double fraction =
      squared_length > 0 ? std::clamp((point - begin).dot(direction) / squared_length, 0.0, 1.0) : 0;
  return (point - begin - fraction * direction).norm();
}

Samples NamedQuantity::samples() const {
  Samples all = quantity->samples();
  if (component < 0) return all;
  return all.col(component);
}

double NamedQuantity::round_off() const {
  double largest = 0;
  for (std::size_t k = 0; k < quantity->round_off.size(); ++k)
    if (component < 0 || static_cast<int>(k) == component) largest = std::max(largest, quantity->round_off[k]);
  return largest;
}

std::pair<std::string, std::string> split_moment_point(const std::string& name) {
  constexpr std::string_view about = " about ";
  const std::size_t at = name.find(about);
  if (at == std::string::npos) return {name, ""};
  return {std::string(trim(name.substr(0, at))), std::string(trim(name.substr(at + about.size())))};
}

std::pair<std::string, std::string> split_component(const std::string& name) {
  const std::size_t bracket = name.rfind('['), point = name.rfind('.');
  if (name.ends_with("]") && bracket != std::string::npos)
    return {name.substr(0, bracket), name.substr(bracket + 1, name.size() - bracket - 2)};
  if (point != std::string::npos) return {name.substr(0, point), name.substr(point + 1)};
  return {"", ""};
}

RunQuantities::RunQuantities(const RunResult* run, const Mechanism* mechanism, std::vector<FigurePoint> points)
    : run_(run), mechanism_(mechanism), points_(std::move(points)) {
  if (run_ == nullptr) return;
  const IntermediateSamples* between = run_->intermediate.get();
  std::size_t j = 0;
  for (Eigen::Index k = 0; k < run_->time.size(); ++k) {
    for (; between != nullptr && j < between->next_sample.size() && between->next_sample[j] == k; ++j)
      rows_.emplace_back(&between->rows, static_cast<Eigen::Index>(j));
    rows_.emplace_back(run_, k);
  }
  times_.resize(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t i = 0; i < rows_.size(); ++i)
    times_[static_cast<Eigen::Index>(i)] = rows_[i].first->time[rows_[i].second];
  recorded_times_ = run_->time;
  list_run_quantities();
  if (mechanism_ == nullptr || run_->coordinate_names.size() != mechanism_->coordinates.size() ||
      run_->joint_position.rows() != run_->time.size())
    return;
  list_motion_quantities();
  list_spring_quantities();
  list_force_element_quantities();
}

/// Whether there are samples of an array at all rows, not only at the recorded ones.
bool RunQuantities::is_merged(Samples RunResult::*array) const {
  const IntermediateSamples* between = run_->intermediate.get();
  return between == nullptr || (between->rows.*array).cols() == (run_->*array).cols();
}

/// Columns of an array at all rows; only at the recorded ones if the intermediate samples lack them.
Samples RunQuantities::merge(Samples RunResult::*array, int first, int count) const {
  const Samples& recorded = run_->*array;
  if (run_->intermediate == nullptr || !is_merged(array)) return recorded.middleCols(first, count);
  Samples merged(static_cast<Eigen::Index>(rows_.size()), count);
  for (std::size_t i = 0; i < rows_.size(); ++i)
    merged.row(static_cast<Eigen::Index>(i)) = (rows_[i].first->*array).row(rows_[i].second).segment(first, count);
  return merged;
}

void RunQuantities::list_run_quantities() {
  const RunResult& run = *run_;
  const std::vector<Quantity> all = list_all_quantities(run);
  for (std::size_t q = 0; q < all.size(); ++q) {
    const Quantity& quantity = all[q];
    const QuantityDefinition& kind = quantity_table()[q];
    if (quantity.samples->size() == 0 || quantity.samples->rows() != run.time.size()) continue;
    // the bodies' poses follow from the mechanism where it is known
    if (kind.occasion == Availability::poses && mechanism_ != nullptr) continue;
    const std::vector<std::string>* owners = owner_names(quantity.columns, run);
    const std::size_t count = owners == nullptr ? 1 : owners->size();
    const int width = static_cast<int>(quantity.samples->cols()) / static_cast<int>(count);
    for (std::size_t owner = 0; owner < count; ++owner) {
      const int first = static_cast<int>(owner) * width;
      const std::string& unit = quantity.unit_of(owner, count);
      std::vector<double> round_off;
      for (int k = 0; k < width; ++k) round_off.push_back(column_round_off(run, quantity.member, first + k));
      quantities_.push_back(
          {owners == nullptr ? quantity.name : effort_display_name(quantity.name, unit) + "[" + (*owners)[owner] + "]",
           unit == "1" ? "" : unit, component_names(kind, run),
           [this, member = quantity.member, first, width] { return merge(member, first, width); },
           is_merged(quantity.member) ? &times_ : &recorded_times_, std::move(round_off), is_kinematic(quantity.member),
           quantity.member, first});
    }
  }
}

const std::vector<std::vector<BodyMotion>>& RunQuantities::motions() {
  if (!motions_.empty()) return motions_;
  const IntermediateSamples* between = run_->intermediate.get();
  std::vector<std::vector<BodyMotion>> recorded = body_motions(*mechanism_, *run_, run_->time.size()), intermediate;
  if (between != nullptr)
    intermediate = body_motions(*mechanism_, between->rows, static_cast<Eigen::Index>(between->next_sample.size()));
  for (const auto& [result, row] : rows_)
    motions_.push_back(std::move((result == run_ ? recorded : intermediate)[static_cast<std::size_t>(row)]));
  return motions_;
}

void RunQuantities::add_motion(std::string name, const char* unit, std::vector<std::string> components,
                               std::function<VectorX(const std::vector<BodyMotion>&)> value) {
  const auto samples = [this, value = std::move(value)] {
    const std::vector<std::vector<BodyMotion>>& all = motions();
    Samples rows;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const VectorX row = value(all[i]);
      if (i == 0) rows.resize(static_cast<Eigen::Index>(all.size()), row.size());
      rows.row(static_cast<Eigen::Index>(i)) = row.transpose();
    }
    return rows;
  };
  quantities_.push_back({std::move(name), unit, std::move(components), samples, &times_, {}, true});
}

void RunQuantities::add_moving_point(const std::string& position_name, const std::string& velocity_name,
                                     const std::string& acceleration_name, BodyId body, const Vector3& r) {
  const auto b = static_cast<std::size_t>(body);
  const int axes = run_->axes;
  const std::vector<std::string> labels = axis_labels(axes);
  if (!position_name.empty())
    add_motion(position_name, "m", labels, [=](const std::vector<BodyMotion>& bodies) -> VectorX {
      return bodies[b].point_position(r).head(axes);
    });
  add_motion(velocity_name, "m/s", labels,
             [=](const std::vector<BodyMotion>& bodies) -> VectorX { return bodies[b].point_velocity(r).head(axes); });
  add_motion(acceleration_name, "m/s^2", labels, [=](const std::vector<BodyMotion>& bodies) -> VectorX {
    return bodies[b].point_acceleration(r).head(axes);
  });
}

void RunQuantities::list_motion_quantities() {
  const Mechanism& mechanism = *mechanism_;
  const RunResult& run = *run_;
  const bool planar = run.moment_axes == 1;
  const std::vector<std::string> turn_labels = planar ? std::vector<std::string>{"z"} : axis_labels(3);
  if (mechanism.tool)
    add_moving_point("", "tool_velocity", "tool_acceleration", mechanism.tool->body, mechanism.tool->position);
  for (const FigurePoint& point : points_)
    add_moving_point("point_position[" + point.name + "]", "point_velocity[" + point.name + "]",
                     "point_acceleration[" + point.name + "]", point.body, point.position);
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) {
    const std::string owner = "[" + mechanism.bodies[b].name + "]";
    add_moving_point("body_position" + owner, "body_velocity" + owner, "body_acceleration" + owner, static_cast<int>(b),
                     Vector3::Zero());
    add_motion("body_angular_velocity" + owner, "rad/s", turn_labels, [=, axes = run.moment_axes](const auto& bodies) {
      return angular_components(bodies[b].angular_velocity, axes);
    });
    add_motion("body_angular_acceleration" + owner, "rad/s^2", turn_labels,
               [=, axes = run.moment_axes](const auto& bodies) {
                 return angular_components(bodies[b].angular_acceleration, axes);
               });
    add_body_orientation(static_cast<int>(b));
  }
}

void RunQuantities::add_body_orientation(BodyId body) {
  const auto b = static_cast<std::size_t>(body);
  const bool planar = run_->moment_axes == 1;
  const auto samples = [this, b, planar] {
    const std::vector<std::vector<BodyMotion>>& all = motions();
    Samples rows(static_cast<Eigen::Index>(all.size()), planar ? 1 : 4);
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      Eigen::Vector4d quaternion = quaternion_of(all[static_cast<std::size_t>(i)][b].rotation);
      if (planar) {
        const double previous = i == 0 ? 0 : rows(i - 1, 0);
        rows(i, 0) = previous + std::remainder(2 * elementary::atan2(quaternion[3], quaternion[0]) - previous,
                                               2 * std::numbers::pi);
        continue;
      }
      if (i > 0 && rows.row(i - 1).dot(quaternion.transpose()) < 0) quaternion = -quaternion;
      rows.row(i) = quaternion.transpose();
    }
    return rows;
  };
  quantities_.push_back({"body_orientation[" + mechanism_->bodies[b].name + "]",
                         planar ? "rad" : "",
                         planar ? std::vector<std::string>{} : quaternion_labels(),
                         samples,
                         &times_,
                         {},
                         true});
}

/// Lengths and tensions of springs between points, and what is left of their travel; of springs in joints what they exert on the coordinate.
void RunQuantities::list_spring_quantities() {
  for (std::size_t s = 0; s < mechanism_->springs.size(); ++s) {
    const Spring& spring = mechanism_->springs[s];
    const std::string owner = "[" + spring.name + "]";
    if (spring.is_joint_spring()) {
      const bool is_length =
          mechanism_->coordinates[static_cast<std::size_t>(spring.coordinate)].kind == CoordinateKind::length;
      quantities_.push_back({(is_length ? "spring_force" : "spring_torque") + owner,
                             is_length ? "N" : "N m",
                             {},
                             [this, &spring]() -> Samples {
                               const Samples position = merge(&RunResult::joint_position, spring.coordinate, 1);
                               return (spring.preload - spring.stiffness * position.array()).matrix();
                             },
                             &times_,
                             {},
                             true});
      continue;
    }
    const auto length = [&spring](const std::vector<BodyMotion>& bodies) {
      return (bodies[static_cast<std::size_t>(spring.second)].point_position(spring.point_second) -
              bodies[static_cast<std::size_t>(spring.first)].point_position(spring.point_first))
          .norm();
    };
    add_motion("spring_length" + owner, "m", {}, [length](const std::vector<BodyMotion>& bodies) -> VectorX {
      return VectorX::Constant(1, length(bodies));
    });
    add_motion("spring_force" + owner, "N", {}, [length, &spring](const std::vector<BodyMotion>& bodies) -> VectorX {
      const double at = length(bodies);
      const bool is_slack = spring.slack_length && at <= *spring.slack_length;
      return VectorX::Constant(1, is_slack ? 0 : spring.stiffness * (at - spring.free_length));
    });
    if (!spring.has_travel()) continue;
    add_motion("spring_margin" + owner, "m", {}, [length, &spring](const std::vector<BodyMotion>& bodies) -> VectorX {
      return VectorX::Constant(1, spring.travel_margin(length(bodies)));
    });
  }
}

/// The same for springs with a table; of dampers between points length, its rate and the tension.
void RunQuantities::list_force_element_quantities() {
  for (const ForceElement& element : mechanism_->force_elements) {
    const std::string owner = "[" + element.name + "]";
    const auto law = element.is_damper() ? model::ForceLawOf<double>() : model::ForceLawOf<double>(element.table);
    if (element.is_in_joint()) {
      const bool is_length = is_length_coordinate(*mechanism_, element.coordinate);
      quantities_.push_back({(is_length ? "spring_force" : "spring_torque") + owner,
                             is_length ? "N" : "N m",
                             {},
                             [this, law, &element]() -> Samples {
                               const Samples position = merge(&RunResult::joint_position, element.coordinate, 1);
                               return position.unaryExpr([&law](double q) { return law.force(q); });
                             },
                             &times_,
                             {},
                             true});
      continue;
    }
    const auto distance = [&element](const std::vector<BodyMotion>& bodies) -> Vector3 {
      return bodies[static_cast<std::size_t>(element.second)].point_position(element.point_second) -
             bodies[static_cast<std::size_t>(element.first)].point_position(element.point_first);
    };
    const std::string kind = element.is_damper() ? "damper" : "spring";
    add_motion(kind + "_length" + owner, "m", {}, [distance](const std::vector<BodyMotion>& bodies) -> VectorX {
      return VectorX::Constant(1, distance(bodies).norm());
    });
    add_motion(
        kind + "_force" + owner, "N", {}, [distance, law, &element](const std::vector<BodyMotion>& bodies) -> VectorX {
          const Vector3 d = distance(bodies);
          if (!element.is_damper()) return VectorX::Constant(1, law.force(d.norm()));
          if (!(d.norm() > 0)) return VectorX::Zero(1);
          const Vector3 rate = bodies[static_cast<std::size_t>(element.second)].point_velocity(element.point_second) -
                               bodies[static_cast<std::size_t>(element.first)].point_velocity(element.point_first);
          return VectorX::Constant(1, element.damping * d.normalized().dot(rate));
        });
  }
}

/// A point of the mechanism that a name means.
std::optional<model::BodyPoint> RunQuantities::find_point(const std::string& name, std::string& mistake) const {
  if (mechanism_ == nullptr) {
    mistake = quote_for_message(name) + " is unknown: the mechanism of the run is";
    return std::nullopt;
  }
  if (const std::optional<model::Landmark> landmark = find_landmark(*mechanism_, name))
    return locate_landmark(*mechanism_, *landmark);
  for (const FigurePoint& point : points_)
    if (point.name == name) return model::BodyPoint{point.body, point.position};
  const std::vector<std::string> names = list_landmarks(*mechanism_);
  mistake = "there is no point " + quote_for_message(name) + ", only " + join_with_conjunction(names, "and") +
            append_nearest_name(name, names);
  return std::nullopt;
}

/// "distance[arm.A, ground.B]", or to a line segment, "distance[arm.A, leg.B to leg.C]".
const RunQuantity* RunQuantities::add_distance(const std::string& name, std::string& mistake) {
  const std::string inner = name.substr(name.find('[') + 1, name.size() - name.find('[') - 2);
  const std::size_t comma = inner.find(',');
  if (comma == std::string::npos) {
    mistake = quote_for_message(name) + " needs two points: distance[body.point, body.point]";
    return nullptr;
  }
  std::vector<std::string> ends{inner.substr(comma + 1)};
  if (const std::size_t to = ends[0].find(" to "); to != std::string::npos)
    ends = {ends[0].substr(0, to), ends[0].substr(to + 4)};
  std::vector<model::BodyPoint> points;
  for (const std::string& end : {inner.substr(0, comma), ends.front(), ends.back()}) {
    const std::optional<model::BodyPoint> point = find_point(std::string(trim(end)), mistake);
    if (!point) return nullptr;
    points.push_back(*point);
  }
  add_motion(name, "m", {}, [points](const std::vector<BodyMotion>& bodies) -> VectorX {
    const auto at = [&](std::size_t k) {
      return bodies[static_cast<std::size_t>(points[k].body)].point_position(points[k].position);
    };
    return VectorX::Constant(1, distance_to_segment(at(0), at(1), at(2)));
  });
  return &quantities_.back();
}

/// A moment on the frame about another point of the frame: the moment minus the cross product of the way to that point
/// and the force.
const RunQuantity* RunQuantities::add_moment_about(const std::string& name, const RunQuantity& moment,
                                                   const std::string& point_name, std::string& mistake) {
  const bool is_shaking = moment.name == "shaking_moment";
  if (!is_shaking && moment.name != "ground_moment") {
    mistake = moment.name + " has no other point: only shaking_moment and ground_moment are taken about a point";
    return nullptr;
  }
  const std::optional<model::BodyPoint> point = find_point(point_name, mistake);
  if (!point) return nullptr;
  if (point->body != model::ground) {
    mistake = quote_for_message(point_name) + " moves: moments are about points of the ground";
    return nullptr;
  }
  const Vector3 shift = point->position - run_->moment_reference;
  const auto samples = [this, is_shaking, shift] {
    const int axes = run_->axes, moment_axes = run_->moment_axes;
    Samples moments = merge(is_shaking ? &RunResult::shaking_moment : &RunResult::ground_moment, 0, moment_axes);
    const Samples forces = merge(is_shaking ? &RunResult::shaking_force : &RunResult::ground_force, 0, axes);
    for (Eigen::Index k = 0; k < moments.rows(); ++k) {
      Vector3 force = Vector3::Zero();
      for (int i = 0; i < axes; ++i) force[i] = forces(k, i);
      const Vector3 change = shift.cross(force);
      for (int i = 0; i < moment_axes; ++i) moments(k, i) -= change[moment_axes == 1 ? 2 : i];
    }
    return moments;
  };
  quantities_.push_back({name, moment.unit, moment.components, samples, moment.times, moment.round_off});
  return &quantities_.back();
}

const RunQuantity* RunQuantities::find_listed(const std::string& name) const {
  for (const std::string& candidate : {name, to_force_name(name)})
    for (const RunQuantity& quantity : quantities_)
      if (without_spaces(quantity.name) == without_spaces(candidate)) return &quantity;
  return nullptr;
}

NamedQuantity RunQuantities::find(const std::string& given) {
  const auto [moment_name, point] = split_moment_point(given);
  NamedQuantity found = find_with_component(moment_name);
  if (point.empty() || found.quantity == nullptr) return found;
  const std::string name = found.quantity->name + " about " + point;
  const RunQuantity* listed = find_listed(name);
  found.quantity = listed != nullptr ? listed : add_moment_about(name, *found.quantity, point, found.mistake);
  return found;
}

NamedQuantity RunQuantities::find_with_component(const std::string& given) {
  NamedQuantity found;
  if ((found.quantity = find_listed(given)) != nullptr) return found;
  if (given.starts_with("distance[") && given.ends_with("]")) {
    found.quantity = add_distance(given, found.mistake);
    return found;
  }
  const std::string name = without_spaces(given);
  std::vector<std::string> members;
  for (const RunQuantity& quantity : quantities_)
    if (quantity.name.starts_with(name + "[")) members.push_back(quantity.name);
  if (members.size() == 1) {
    found.quantity = find_listed(members.front());
    return found;
  }
  const auto [stem, label] = split_component(name);
  if (const RunQuantity* quantity = stem.empty() ? nullptr : find_listed(stem)) {
    const auto at = std::find(quantity->components.begin(), quantity->components.end(), label);
    if (at != quantity->components.end()) {
      found.component = static_cast<int>(at - quantity->components.begin());
      found.quantity = quantity;
    } else if (quantity->components.empty()) {
      found.mistake = quantity->name + " is a number: it has no component " + quote_for_message(label);
    } else {
      found.mistake = quantity->name + " has no component " + quote_for_message(label) + ", only " +
                      join_with_conjunction(quantity->components, "and");
    }
    return found;
  }
  if (name.starts_with("point_") && points_.empty()) {
    found.mistake = quote_for_message(given) + " needs a case with 'points', such as {D: body.point}";
    return found;
  }
  if (!members.empty()) {
    found.mistake = quote_for_message(given) + " has several values: " + join_alternatives(members);
    return found;
  }
  std::vector<std::string> names;
  if (run_ != nullptr)
    for (const Metric& metric : run_->metrics) names.push_back(metric.quantity);
  for (const RunQuantity& known : quantities_) names.push_back(known.name);
  found.mistake = "no run has a quantity " + quote_for_message(given) + append_nearest_name(given, names);
  return found;
}

void RunQuantities::add_constant(std::string name, const std::string& unit, double value) {
  const bool is_known = std::any_of(quantities_.begin(), quantities_.end(),
                                    [&](const RunQuantity& quantity) { return quantity.name == name; });
  if (is_known) return;
  if (times_.size() == 0) times_ = VectorX::Zero(1);
  quantities_.push_back({std::move(name), unit, {}, [value] { return Samples::Constant(1, 1, value); }, &times_, {}});
}

namespace {

/// A run of one row, without values.
RunResult make_empty_row(const Mechanism& mechanism) {
  RunResult shape;
  name_columns(mechanism, shape);
  resize_arrays(mechanism, 1, {}, shape);
  shape.time = VectorX::Zero(1);
  return shape;
}

}  // namespace

std::vector<std::string> list_quantities(const Mechanism& mechanism) {
  const RunResult shape = make_empty_row(mechanism);
  const RunQuantities quantities(&shape, &mechanism);
  std::vector<std::string> names;
  for (const RunQuantity& quantity : quantities.list()) names.push_back(quantity.name);
  return names;
}

bool has_gradients(const Mechanism& mechanism, const std::string& quantity) {
  const std::vector<std::string> known = list_metric_names(mechanism);
  const auto is_meant = [&](const std::string& name) {
    return is_quantity_name(quantity, name) || name.starts_with(quantity + "[");
  };
  if (std::any_of(known.begin(), known.end(), is_meant)) return true;
  const std::optional<MetricSeries> series = find_series(make_empty_row(mechanism), quantity);
  return series && series->array != &RunResult::tool_orientation;
}

std::optional<QuantityDescription> describe_quantity(const Mechanism& mechanism, const std::string& name,
                                                     std::string& mistake) {
  const RunResult shape = make_empty_row(mechanism);
  RunQuantities quantities(&shape, &mechanism);
  const std::vector<std::string> known = list_metric_names(mechanism);
  const bool is_worst =
      std::find(known.begin(), known.end(), name) != known.end() && name.find('[') == std::string::npos;
  if (const std::string unit = find_metric_unit(mechanism, name); is_worst && !unit.empty()) {
    const NamedQuantity whole = quantities.find(name);
    return QuantityDescription{name, unit, whole.quantity == nullptr || whole.is_scalar(), false};
  }
  const NamedQuantity found = quantities.find(name);
  mistake = found.mistake;
  if (found.quantity == nullptr) {
    // the worst of all joints
    const std::string unit = name == "joint_force" ? "N" : name == "joint_moment" ? "N m" : "";
    if (unit.empty() || mechanism.joints.empty()) return std::nullopt;
    mistake.clear();
    return QuantityDescription{name, unit, name == "joint_moment" && mechanism.space == SpaceKind::planar, false};
  }
  QuantityDescription described{found.quantity->name, found.quantity->unit.empty() ? "1" : found.quantity->unit,
                                found.is_scalar(), found.quantity->is_kinematic};
  if (found.component >= 0) {
    const auto [moment, point] = split_moment_point(described.name);
    described.name = moment + "[" + found.quantity->components[static_cast<std::size_t>(found.component)] + "]" +
                     (point.empty() ? "" : " about " + point);
  }
  return described;
}

std::optional<MetricSeries> find_series(const RunResult& run, const std::string& name) {
  RunQuantities quantities(&run, nullptr);
  const NamedQuantity found = quantities.find(name);
  if (found.quantity == nullptr || found.quantity->array == nullptr) return std::nullopt;
  const int width = std::max<int>(1, static_cast<int>(found.quantity->components.size()));
  return MetricSeries{name,
                      found.quantity->unit,
                      found.quantity->array,
                      found.quantity->first + std::max(0, found.component),
                      found.component < 0 ? width : 1,
                      ""};
}

double compute_statistic(const RunResult& run, const Mechanism* mechanism, Statistic statistic,
                         const std::string& quantity) {
  for (const Metric& metric : run.metrics)
    if (is_quantity_name(quantity, metric.quantity))
      return suppress_round_off(metric.round_off, statistic_of(metric, statistic));
  if (quantity == "joint_force" || quantity == "joint_moment") {
    double worst = std::numeric_limits<double>::quiet_NaN();
    for (const Metric& metric : run.metrics) {
      if (!metric.quantity.starts_with(quantity + "[")) continue;
      const double value = suppress_round_off(metric.round_off, statistic_of(metric, statistic));
      if (std::isnan(worst) || (statistic == Statistic::minimum ? value < worst : value > worst)) worst = value;
    }
    return worst;
  }
  RunQuantities quantities(&run, mechanism);
  const NamedQuantity found = quantities.find(quantity);
  if (found.quantity == nullptr) return std::numeric_limits<double>::quiet_NaN();
  const Samples samples = found.samples();
  std::vector<double> values;
  for (Eigen::Index k = 0; k < samples.rows(); ++k)
    values.push_back(samples.cols() == 1 ? samples(k, 0) : samples.row(k).norm());
  return statistic_of(summarise_values(values, *found.quantity->times, found.round_off()), statistic);
}

}  // namespace balance::results
