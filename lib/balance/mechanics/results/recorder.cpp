#include "balance/mechanics/results/recorder.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/mechanics/model/speed_units.hpp"

#include <algorithm>

namespace balance::results {
namespace {

bool has_quantity(const Mechanism& mechanism, const RecordedContents& contents, const RunResult& result,
                  Availability availability) {
  switch (availability) {
    case Availability::always: return true;
    case Availability::tool: return mechanism.tool.has_value();
    case Availability::uniform_actuators:
      return result.actuator_units.size() > 1 && common_unit(result.actuator_units) != "mixed";
    case Availability::reactions: return contents.reactions;
    case Availability::prescribed_speeds: return contents.reactions && has_prescribed_speeds(mechanism);
    case Availability::control: return contents.control;
    case Availability::tracking: return contents.tracking;
    case Availability::tool_tracking: return contents.tracking && mechanism.tool.has_value();
    case Availability::poses:
    case Availability::split:
    case Availability::measured: return false;
  }
  return false;
}

}  // namespace

void name_columns(const Mechanism& mechanism, RunResult& result) {
  const bool planar = mechanism.space == SpaceKind::planar;
  result.axes = planar ? 2 : 3;
  result.moment_axes = planar ? 1 : 3;
  for (const Coordinate& coordinate : mechanism.coordinates) {
    result.coordinate_names.push_back(coordinate.name);
    result.coordinate_units.push_back(coordinate.kind == CoordinateKind::angle ? "rad" : "m");
  }
  for (const Joint& joint : mechanism.joints) result.joint_names.push_back(joint.name);
  for (const model::GeneralisedSpeed& constraint : mechanism.constraints) {
    result.constraint_names.push_back(constraint.name);
    result.constraint_units.push_back(model::is_length_speed(mechanism, constraint) ? "N" : "N m");
  }
  for (const int actuator : mechanism.actuators) {
    result.actuator_names.push_back(mechanism.coordinates[actuator].name);
    result.actuator_units.push_back(mechanism.coordinates[actuator].kind == CoordinateKind::angle ? "N m" : "N");
  }
}

void resize_arrays(const Mechanism& mechanism, long rows, const RecordedContents& contents, RunResult& result) {
  result.time.resize(rows);
  result.newton_iterations.resize(rows);
  for (const QuantityDefinition& kind : quantity_table())
    if (has_quantity(mechanism, contents, result, kind.occasion))
      (result.*kind.member).resize(rows, count_columns(columns_of(kind, result), result));
}

void truncate_rows(long rows, RunResult& result) {
  result.time.conservativeResize(rows);
  if (result.newton_iterations.size() > 0) result.newton_iterations.conservativeResize(rows);
  for (const QuantityDefinition& kind : quantity_table()) {
    Samples& samples = result.*kind.member;
    if (samples.size() > 0) samples.conservativeResize(rows, Eigen::NoChange);
  }
}

void truncate_actuators(std::size_t count, RunResult& result) {
  const auto columns = static_cast<Eigen::Index>(count);
  result.actuator_names.resize(count);
  result.actuator_units.resize(count);
  for (const QuantityDefinition& kind : quantity_table())
    if (Samples& samples = result.*kind.member; kind.columns == ColumnKind::actuator && samples.cols() > columns)
      samples.conservativeResize(Eigen::NoChange, columns);
  if (count > 1 && common_unit(result.actuator_units) != "mixed")
    result.total_torque = result.torque.rowwise().norm();
  else
    result.total_torque.resize(0, 0);
  for (TermMagnitudes* magnitudes : {&result.term_magnitudes, &result.round_off})
    for (VectorX* values : {&magnitudes->effort, &magnitudes->power})
      if (values->size() > columns) values->conservativeResize(columns);
}

ResultRecorder::ResultRecorder(const RunResult& shape) {
  for (const QuantityDefinition& kind : quantity_table()) {
    if ((shape.*kind.member).cols() == 0 || kind.values == nullptr) continue;
    const ColumnKind columns = columns_of(kind, shape);
    const bool is_vector = kind.columns == ColumnKind::axis || kind.columns == ColumnKind::joint_axis;
    const long count = (shape.*kind.member).cols();
    const bool is_moment = is_vector && (columns == ColumnKind::single || columns == ColumnKind::joint);  // along z
    const long width = !is_vector ? count : is_moment ? 1 : shape.axes;
    entries_.push_back({&kind, columns == ColumnKind::quaternion, count / width, width, 3, is_moment ? 2 : 0});
  }
}

void ResultRecorder::write(const Sample& sample, long row, RunResult& result) {
  result.time[row] = sample.time;
  result.newton_iterations[row] = sample.newton_iterations;
  for (const ColumnMapping& entry : entries_) {
    double* out = &(result.*entry.kind->member)(row, 0);
    if (entry.quaternion) {
      Eigen::Vector4d quaternion = quaternion_of(sample.tool_rotation);
      if (quaternion_.dot(quaternion) < 0) quaternion = -quaternion;  // choose the sign that is continuous
      quaternion_ = quaternion;
      Eigen::Vector4d::Map(out) = quaternion;
      continue;
    }
    const double* in = entry.kind->values(sample) + entry.skip;
    for (long block = 0; block < entry.blocks; ++block, in += entry.stride, out += entry.width)
      for (long i = 0; i < entry.width; ++i) out[i] = in[i];
  }
}

}  // namespace balance::results
