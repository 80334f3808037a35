#include "balance/mechanics/derivatives/prescribed_motion_gradient.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/kinematics/kinematic_equations.hpp"
#include "balance/mechanics/trajectory/trajectory_conversion.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double stencil_offsets[] = {-2, -1, 1, 2};
constexpr double stencil_weights[] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
constexpr double stencil_step = 1e-4;  ///< of a step [m, rad, parts]

/// The driven quantities at a pose of the mechanism, with their derivatives.
template <class S>
DriveSampleOf<DualNumber> measure_drive_dual(const MechanismOf<DualNumber>& mechanism, const Tree<S>& values,
                                             const std::vector<CoordinateId>& needed,
                                             const PoseTargetOf<DualNumber>& pose, const VectorX& y,
                                             const DriveQuantities& quantities) {
  using D = DualSpace<S>;
  Tree<D> tree = compile_tree<D>(mechanism, needed);
  for (const NodeId spherical : values.spherical_joints)
    tree.nodes[spherical].R_PF = cast<DualNumber>(values.nodes[spherical].R_PF);
  const PoseEquations<D> stated = make_pose_equations(mechanism, tree, pose);
  KinematicEquations<D> equations(tree, stated.drive, true);
  TreeState<D> state(tree.nodes.size());
  VectorXOf<DualNumber> dual_y = y.cast<DualNumber>();
  std::vector<DualNumber> x(static_cast<std::size_t>(std::max(tree.columns, equations.rows())));
  compute_poses(tree, dual_y.data(), state);
  equations.evaluate(state, dual_y.data(), stated.target, x.data());
  equations.factorise();
  equations.solve(x.data());
  for (int c = 0; c < tree.columns; ++c) dual_y[c].d = (-x[static_cast<std::size_t>(c)]).d;
  compute_poses(tree, dual_y.data(), state);
  return measure_drive(tree, make_drive(mechanism, tree, quantities), state, dual_y.data());
}

DriveValue extract_endpoint_derivative(const DriveSampleOf<DualNumber>& sample, std::size_t k) {
  const auto number = [k](const DualNumber& x) { return x.d[k]; };
  return {sample.value.unaryExpr(number), sample.rotation.unaryExpr(number)};
}

/// The value moved along its derivative.
DriveValue displace_value(const DriveValue& value, const DriveValue& rate, double step) {
  DriveValue out = value;
  if (out.value.size() > 0) out.value += step * rate.value;
  const Matrix3 spin = rate.rotation * value.rotation.transpose();
  out.rotation = rotation_from_rotation_vector(step * Vector3(spin(2, 1), spin(0, 2), spin(1, 0))) * value.rotation;
  return out;
}

double largest(const DriveValue& value) { return std::max(max_abs(value.value), max_abs(value.rotation)); }

/// Of the numbers that say which way a trajectory goes and by what law; a table's times as parts of their whole.
double find_max_path_derivative(const Trajectory& rate, double duration) {
  double size = 0;
  Trajectory way;
  way.duration = 0;
  way.law = rate.law;
  way.path = rate.path;
  if (auto* table = std::get_if<TablePath>(&way.path))
    for (double& time : table->time) time /= duration;
  cast_scalar<double>(way, [&size](double x) {
    size = std::max(size, std::abs(x));
    return x;
  });
  return size;
}

bool has_task_derivative(const Trajectory& rate) {
  return std::any_of(rate.secondary_tasks.begin(), rate.secondary_tasks.end(), [](const SecondaryTask& course) {
    const auto& c = std::get<SplineTask>(course.kind).coefficients;
    return std::any_of(c.begin(), c.end(), [](double x) { return x != 0; });
  });
}

/// What the ends and the points between them are prescribed by is linear in them.
bool is_linear_in_points(const Trajectory& values, const Trajectory& rate, const DriveQuantities& quantities) {
  if (!quantities.rotation.empty() || rate.law.ramp_up != 0 || rate.law.ramp_down != 0) return false;
  const auto still = [](const std::vector<double>& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](double x) { return x == 0; });
  };
  if (const auto* way = std::get_if<WaypointPath>(&values.path))
    return !way->fractions.empty() && still(std::get<WaypointPath>(rate.path).fractions);
  return std::holds_alternative<LinePath>(values.path);
}

/// Nothing but courses changes, and they do not ask where on the way the motion is, or the way is one leg.
bool is_task_change_only(const Trajectory& values, double way) {
  const auto* points = std::get_if<WaypointPath>(&values.path);
  const bool one_leg = points == nullptr || points->spline;
  return way == 0 && (one_leg || std::all_of(values.secondary_tasks.begin(), values.secondary_tasks.end(),
                                             [](const SecondaryTask& course) {
                                               return std::get<SplineTask>(course.kind).over_time;
                                             }));
}

/// Adds part of a sample to the derivatives by a number.
void add_derivative(const DriveSample& part, double weight, std::size_t number, DriveSampleOf<DualNumber>& sample) {
  const auto one = [&](auto& duals, const auto& values) {
    for (Eigen::Index e = 0; e < values.size(); ++e) duals(e).d[number] += weight * values(e);
  };
  one(sample.value, part.value);
  one(sample.rate, part.rate);
  one(sample.acceleration, part.acceleration);
  one(sample.rotation, part.rotation);
  one(sample.angular_velocity, part.angular_velocity);
  one(sample.angular_acceleration, part.angular_acceleration);
}

/// Without derivatives.
void set_without_derivatives(const DriveSample& values, DriveSampleOf<DualNumber>& sample) {
  const auto one = [](auto& duals, const auto& numbers) {
    duals.resize(numbers.rows(), numbers.cols());
    for (Eigen::Index e = 0; e < numbers.size(); ++e) duals(e) = numbers(e);
  };
  one(sample.value, values.value);
  one(sample.rate, values.rate);
  one(sample.acceleration, values.acceleration);
  one(sample.rotation, values.rotation);
  one(sample.angular_velocity, values.angular_velocity);
  one(sample.angular_acceleration, values.angular_acceleration);
}

}  // namespace

template <class S>
PrescribedMotionGradient::PrescribedMotionGradient(const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree,
                                                   const std::vector<CoordinateId>& needed,
                                                   const TrajectoryOf<DualNumber>& trajectory, const Trajectory& values,
                                                   const CompiledTrajectory<S>& plan)
    : schedule_(*plan.prescribed_motion) {
  TrajectoryDerivatives rates;
  for (std::size_t k = 0; k < dual_width; ++k)
    rates[k] = cast_scalar<double>(trajectory, [k](const DualNumber& x) { return x.d[k]; });
  const bool table = std::holds_alternative<TablePath>(values.path);
  const auto ends = differentiate_endpoints(mechanism, tree, needed, trajectory, plan, rates);
  for (std::size_t k = 0; k < dual_width; ++k) {
    const double points = table ? 0 : std::max(largest(ends[k].from), largest(ends[k].to));
    const double way = std::max(points, find_max_path_derivative(rates[k], schedule_.duration()));
    if (!table) relative_duration_rate_[k] = rates[k].duration / schedule_.duration();
    if (way == 0 && !has_task_derivative(rates[k])) continue;
    if (is_linear_in_points(values, rates[k], plan.quantities) || is_task_change_only(values, way))
      add_tangent(k, values, rates[k], ends[k], plan.quantities);
    else
      add_stencil(k, trajectory, way, plan.request, ends[k], plan.quantities);
  }
}

template <class S>
std::array<PrescribedMotionGradient::Endpoints, dual_width> PrescribedMotionGradient::differentiate_endpoints(
    const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree, const std::vector<CoordinateId>& needed,
    const TrajectoryOf<DualNumber>& trajectory, const CompiledTrajectory<S>& plan,
    const TrajectoryDerivatives& rates) const {
  std::array<Endpoints, dual_width> ends;
  if (std::holds_alternative<TablePath>(plan.request.path)) return ends;
  const DriveSampleOf<DualNumber> start =
      measure_drive_dual(mechanism, tree, needed, trajectory.from, plan.start, plan.quantities);
  DriveSampleOf<DualNumber> end;
  if (plan.end.size() > 0) end = measure_drive_dual(mechanism, tree, needed, trajectory.to, plan.end, plan.quantities);
  for (std::size_t k = 0; k < dual_width; ++k) {
    ends[k].from = read_pose_values(plan.quantities, rates[k].from, extract_endpoint_derivative(start, k));
    ends[k].to = plan.end.size() > 0 ? extract_endpoint_derivative(end, k)
                                     : read_pose_values(plan.quantities, rates[k].to, ends[k].from);
    if (plan.quantities.rotation.empty()) ends[k].from.rotation = ends[k].to.rotation = Matrix3::Zero();
  }
  return ends;
}

/// Where only courses change the way does not matter, and a straight one has no bends that could not be linear.
void PrescribedMotionGradient::add_tangent(std::size_t number, const Trajectory& values, const Trajectory& rate,
                                           const Endpoints& ends, const DriveQuantities& quantities) {
  Trajectory tangent = rate;
  tangent.law = values.law;
  tangent.duration = schedule_.duration();
  if (auto* way = std::get_if<WaypointPath>(&tangent.path); way != nullptr && !way->fractions.empty())
    way->fractions = std::get<WaypointPath>(values.path).fractions;
  else
    tangent.path = LinePath{};
  DriveValue from{ends.from.value, Matrix3::Identity()}, to{ends.to.value, Matrix3::Identity()};
  tangents_.push_back(
      {number, PrescribedMotion(make_prescribed_motion_request(tangent, quantities, std::move(from), std::move(to)))});
}

void PrescribedMotionGradient::add_stencil(std::size_t number, const TrajectoryOf<DualNumber>& trajectory, double size,
                                           const PrescribedMotion::Request& request, const Endpoints& ends,
                                           const DriveQuantities& quantities) {
  DifferenceStencil near{number, stencil_step / (size > 0 ? size : 1), {}, true};
  const bool table = std::holds_alternative<TablePath>(request.path);
  const bool ends_there = request.to.value.size() == ends.to.value.size();
  for (const double place : stencil_offsets) {
    const double step = place * near.step;
    Trajectory other =
        cast_scalar<double>(trajectory, [&](const DualNumber& x) { return x.value + step * x.d[number]; });
    other.duration = request.duration;  // its change is told apart
    DriveValue from = table ? request.from : displace_value(request.from, ends.from, step);
    DriveValue to = table || !ends_there ? request.to : displace_value(request.to, ends.to, step);
    PrescribedMotion::Request there = make_prescribed_motion_request(other, quantities, std::move(from), std::move(to));
    there.switch_times = request.switch_times;
    near.schedules.emplace_back(there);
    near.has_matching_jumps =
        near.has_matching_jumps && near.schedules.back().jump_times().size() == schedule_.jump_times().size();
  }
  neighbours_.push_back(std::move(near));
}

DualNumber PrescribedMotionGradient::at(double time, Side side, long jump, DriveSampleOf<DualNumber>& sample) {
  schedule_.at(time, side, now_);
  set_without_derivatives(now_, sample);
  DualNumber when(time);
  const double part = time / schedule_.duration();
  for (const TangentMotion& tangent : tangents_) {
    tangent.schedule.at(time, side, now_);
    add_derivative(now_, 1, tangent.number, sample);
  }
  for (const DifferenceStencil& near : neighbours_)
    for (std::size_t i = 0; i < near.schedules.size(); ++i) {
      const PrescribedMotion& other = near.schedules[i];
      const double there = jump >= 0 && near.has_matching_jumps ? other.jump_times()[static_cast<std::size_t>(jump)]
                                                                : part * other.duration();
      other.at(there, side, now_);
      const double weight = stencil_weights[i] / near.step;
      add_derivative(now_, weight, near.number, sample);
      when.d[near.number] += weight * there;
    }
  // slower by the longer duration: rates by its part, accelerations by twice that
  for (std::size_t k = 0; k < dual_width; ++k) {
    if (relative_duration_rate_[k] == 0) continue;
    when.d[k] += relative_duration_rate_[k] * time;
    for (DualNumber& x : sample.rate) x.d[k] -= relative_duration_rate_[k] * x.value;
    for (DualNumber& x : sample.acceleration) x.d[k] -= 2 * relative_duration_rate_[k] * x.value;
    for (DualNumber& x : sample.angular_velocity) x.d[k] -= relative_duration_rate_[k] * x.value;
    for (DualNumber& x : sample.angular_acceleration) x.d[k] -= 2 * relative_duration_rate_[k] * x.value;
  }
  return when;
}

bool PrescribedMotionGradient::is_moving_jump(long jump) const {
  const double time = schedule_.jump_times()[static_cast<std::size_t>(jump)];
  return std::any_of(neighbours_.begin(), neighbours_.end(), [&](const DifferenceStencil& near) {
    if (!near.has_matching_jumps) return false;
    const PrescribedMotion& other = near.schedules.back();
    return std::abs(other.jump_times()[static_cast<std::size_t>(jump)] / other.duration() -
                    time / schedule_.duration()) > 1e-9 * stencil_step;
  });
}

template PrescribedMotionGradient::PrescribedMotionGradient(const MechanismOf<DualNumber>&, const Tree<Planar>&,
                                                            const std::vector<CoordinateId>&,
                                                            const TrajectoryOf<DualNumber>&, const Trajectory&,
                                                            const CompiledTrajectory<Planar>&);
template PrescribedMotionGradient::PrescribedMotionGradient(const MechanismOf<DualNumber>&, const Tree<Spatial>&,
                                                            const std::vector<CoordinateId>&,
                                                            const TrajectoryOf<DualNumber>&, const Trajectory&,
                                                            const CompiledTrajectory<Spatial>&);

}  // namespace balance
