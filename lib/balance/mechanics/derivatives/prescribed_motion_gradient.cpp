#include "balance/mechanics/derivatives/prescribed_motion_gradient.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/kinematics/kinematic_equations.hpp"
#include "balance/mechanics/trajectory/trajectory_conversion.hpp"

#include <algorithm>
#include <cmath>

namespace balance::derivatives {

using trajectory::DriveValue;

namespace {

constexpr double stencil_offsets[] = {-2, -1, 1, 2};
constexpr double stencil_weights[] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
constexpr double stencil_step = 1e-4;  ///< largest change of a value per step [m, rad, fraction]

/// The driven quantities at a pose of the mechanism, with their derivatives.
template <class S>
trajectory::DriveSampleOf<DualNumber> measure_drive_dual(const MechanismOf<DualNumber>& mechanism,
                                                         const kinematics::Tree<S>& values,
                                                         const std::vector<CoordinateId>& needed,
                                                         const trajectory::PoseTargetOf<DualNumber>& pose,
                                                         const VectorX& y,
                                                         const trajectory::DriveQuantities& quantities) {
  using D = DualSpace<S>;
  kinematics::Tree<D> tree = kinematics::compile_tree<D>(mechanism, needed);
  for (const kinematics::NodeId spherical : values.spherical_joints)
    tree.nodes[spherical].R_PF = kinematics::cast<DualNumber>(values.nodes[spherical].R_PF);
  const kinematics::PoseEquations<D> pose_equations = make_pose_equations(mechanism, tree, pose);
  kinematics::KinematicEquations<D> equations(tree, pose_equations.drive, true);
  kinematics::TreeState<D> state(tree.nodes.size());
  VectorXOf<DualNumber> dual_y = y.cast<DualNumber>();
  std::vector<DualNumber> x(static_cast<std::size_t>(std::max(tree.columns, equations.rows())));
  compute_poses(tree, dual_y.data(), state);
  equations.evaluate(state, dual_y.data(), pose_equations.target, x.data());
  equations.factorise();
  equations.solve(x.data());
  for (int c = 0; c < tree.columns; ++c) dual_y[c].d = (-x[static_cast<std::size_t>(c)]).d;
  compute_poses(tree, dual_y.data(), state);
  return measure_drive(tree, make_drive(mechanism, tree, quantities), state, dual_y.data());
}

DriveValue extract_endpoint_derivative(const trajectory::DriveSampleOf<DualNumber>& sample, std::size_t k) {
  const auto derivative = [k](const DualNumber& x) { return x.d[k]; };
  return {sample.value.unaryExpr(derivative), sample.rotation.unaryExpr(derivative)};
}

/// The value displaced along its derivative by a step.
DriveValue displace_value(const DriveValue& value, const DriveValue& rate, double step) {
  DriveValue out = value;
  if (out.value.size() > 0) out.value += step * rate.value;
  const Matrix3 spin = rate.rotation * value.rotation.transpose();
  out.rotation = rotation_from_rotation_vector(step * Vector3(spin(2, 1), spin(0, 2), spin(1, 0))) * value.rotation;
  return out;
}

double max_component(const DriveValue& value) {
  return std::max(numerics::max_abs(value.value), numerics::max_abs(value.rotation));
}

/// Largest derivative among the numbers that define a trajectory's path and law; a table's times count as fractions of
/// the duration.
double find_max_path_derivative(const Trajectory& rate, double duration) {
  double max_derivative = 0;
  Trajectory path_and_law;
  path_and_law.duration = 0;
  path_and_law.law = rate.law;
  path_and_law.path = rate.path;
  if (auto* table = std::get_if<trajectory::TablePath>(&path_and_law.path))
    for (double& time : table->time) time /= duration;
  trajectory::cast_scalar<double>(path_and_law, [&max_derivative](double x) {
    max_derivative = std::max(max_derivative, std::abs(x));
    return x;
  });
  return max_derivative;
}

bool has_task_derivative(const Trajectory& rate) {
  return std::any_of(rate.secondary_tasks.begin(), rate.secondary_tasks.end(),
                     [](const trajectory::SecondaryTask& task) {
                       const auto& c = std::get<trajectory::SplineTask>(task.kind).coefficients;
                       return std::any_of(c.begin(), c.end(), [](double x) { return x != 0; });
                     });
}

/// Whether the prescribed values are linear in the end points and via points.
bool is_linear_in_points(const Trajectory& values, const Trajectory& rate,
                         const trajectory::DriveQuantities& quantities) {
  if (!quantities.rotation.empty() || rate.law.ramp_up != 0 || rate.law.ramp_down != 0) return false;
  const auto all_zero = [](const std::vector<double>& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](double x) { return x == 0; });
  };
  if (const auto* waypoints = std::get_if<trajectory::WaypointPath>(&values.path))
    return !waypoints->fractions.empty() && all_zero(std::get<trajectory::WaypointPath>(rate.path).fractions);
  return std::holds_alternative<trajectory::LinePath>(values.path);
}

/// Whether only secondary tasks change, and these are functions of time or the path is a single leg.
bool is_task_change_only(const Trajectory& values, double max_path_derivative) {
  const auto* waypoints = std::get_if<trajectory::WaypointPath>(&values.path);
  const bool is_single_leg = waypoints == nullptr || waypoints->spline;
  return max_path_derivative == 0 &&
         (is_single_leg || std::all_of(values.secondary_tasks.begin(), values.secondary_tasks.end(),
                                       [](const trajectory::SecondaryTask& task) {
                                         return std::get<trajectory::SplineTask>(task.kind).over_time;
                                       }));
}

/// Adds weight · term to the derivatives with respect to one variable.
void add_derivative(const trajectory::DriveSample& term, double weight, std::size_t variable,
                    trajectory::DriveSampleOf<DualNumber>& sample) {
  const auto accumulate = [&](auto& duals, const auto& values) {
    for (Eigen::Index e = 0; e < values.size(); ++e) duals(e).d[variable] += weight * values(e);
  };
  accumulate(sample.value, term.value);
  accumulate(sample.rate, term.rate);
  accumulate(sample.acceleration, term.acceleration);
  accumulate(sample.rotation, term.rotation);
  accumulate(sample.angular_velocity, term.angular_velocity);
  accumulate(sample.angular_acceleration, term.angular_acceleration);
}

void set_without_derivatives(const trajectory::DriveSample& values, trajectory::DriveSampleOf<DualNumber>& sample) {
  const auto assign = [](auto& duals, const auto& numbers) {
    duals.resize(numbers.rows(), numbers.cols());
    for (Eigen::Index e = 0; e < numbers.size(); ++e) duals(e) = numbers(e);
  };
  assign(sample.value, values.value);
  assign(sample.rate, values.rate);
  assign(sample.acceleration, values.acceleration);
  assign(sample.rotation, values.rotation);
  assign(sample.angular_velocity, values.angular_velocity);
  assign(sample.angular_acceleration, values.angular_acceleration);
}

}  // namespace

template <class S>
PrescribedMotionGradient::PrescribedMotionGradient(const MechanismOf<DualNumber>& mechanism,
                                                   const kinematics::Tree<S>& tree,
                                                   const std::vector<CoordinateId>& needed,
                                                   const TrajectoryOf<DualNumber>& trajectory, const Trajectory& values,
                                                   const kinematics::CompiledTrajectory<S>& plan)
    : prescribed_motion_(*plan.prescribed_motion) {
  TrajectoryDerivatives rates;
  for (std::size_t k = 0; k < numerics::dual_width; ++k)
    rates[k] = trajectory::cast_scalar<double>(trajectory, [k](const DualNumber& x) { return x.d[k]; });
  const bool table = std::holds_alternative<trajectory::TablePath>(values.path);
  const auto ends = differentiate_endpoints(mechanism, tree, needed, trajectory, plan, rates);
  for (std::size_t k = 0; k < numerics::dual_width; ++k) {
    const double max_end_derivative = table ? 0 : std::max(max_component(ends[k].from), max_component(ends[k].to));
    const double max_derivative =
        std::max(max_end_derivative, find_max_path_derivative(rates[k], prescribed_motion_.duration()));
    if (!table) relative_duration_rate_[k] = rates[k].duration / prescribed_motion_.duration();
    if (max_derivative == 0 && !has_task_derivative(rates[k])) continue;
    if (is_linear_in_points(values, rates[k], plan.quantities) || is_task_change_only(values, max_derivative))
      add_tangent(k, values, rates[k], ends[k], plan.quantities);
    else
      add_stencil(k, trajectory, max_derivative, plan.request, ends[k], plan.quantities);
  }
}

template <class S>
std::array<PrescribedMotionGradient::Endpoints, numerics::dual_width> PrescribedMotionGradient::differentiate_endpoints(
    const MechanismOf<DualNumber>& mechanism, const kinematics::Tree<S>& tree, const std::vector<CoordinateId>& needed,
    const TrajectoryOf<DualNumber>& trajectory, const kinematics::CompiledTrajectory<S>& plan,
    const TrajectoryDerivatives& rates) const {
  std::array<Endpoints, numerics::dual_width> ends;
  if (std::holds_alternative<trajectory::TablePath>(plan.request.path)) return ends;
  const trajectory::DriveSampleOf<DualNumber> start =
      measure_drive_dual(mechanism, tree, needed, trajectory.from, plan.start, plan.quantities);
  trajectory::DriveSampleOf<DualNumber> end;
  if (plan.end.size() > 0) end = measure_drive_dual(mechanism, tree, needed, trajectory.to, plan.end, plan.quantities);
  for (std::size_t k = 0; k < numerics::dual_width; ++k) {
    ends[k].from = read_pose_values(plan.quantities, rates[k].from, extract_endpoint_derivative(start, k));
    ends[k].to = plan.end.size() > 0 ? extract_endpoint_derivative(end, k)
                                     : read_pose_values(plan.quantities, rates[k].to, ends[k].from);
    if (plan.quantities.rotation.empty()) ends[k].from.rotation = ends[k].to.rotation = Matrix3::Zero();
  }
  return ends;
}

/// If only secondary tasks change, the path is irrelevant and is replaced by a straight line, which is linear.
void PrescribedMotionGradient::add_tangent(std::size_t variable, const Trajectory& values, const Trajectory& rate,
                                           const Endpoints& ends, const trajectory::DriveQuantities& quantities) {
  Trajectory tangent = rate;
  tangent.law = values.law;
  tangent.duration = prescribed_motion_.duration();
  if (auto* waypoints = std::get_if<trajectory::WaypointPath>(&tangent.path);
      waypoints != nullptr && !waypoints->fractions.empty())
    waypoints->fractions = std::get<trajectory::WaypointPath>(values.path).fractions;
  else
    tangent.path = trajectory::LinePath{};
  DriveValue from{ends.from.value, Matrix3::Identity()}, to{ends.to.value, Matrix3::Identity()};
  tangents_.push_back({variable, trajectory::PrescribedMotion(make_prescribed_motion_request(
                                     tangent, quantities, std::move(from), std::move(to)))});
}

void PrescribedMotionGradient::add_stencil(std::size_t variable, const TrajectoryOf<DualNumber>& trajectory,
                                           double size, const trajectory::PrescribedMotion::Request& request,
                                           const Endpoints& ends, const trajectory::DriveQuantities& quantities) {
  DifferenceStencil stencil{variable, stencil_step / (size > 0 ? size : 1), {}, true};
  const bool table = std::holds_alternative<trajectory::TablePath>(request.path);
  const bool has_end_derivative = request.to.value.size() == ends.to.value.size();
  for (const double stencil_offset : stencil_offsets) {
    const double step = stencil_offset * stencil.step;
    Trajectory shifted = trajectory::cast_scalar<double>(
        trajectory, [&](const DualNumber& x) { return x.value + step * x.d[variable]; });
    shifted.duration = request.duration;  // its change is accounted for separately
    DriveValue from = table ? request.from : displace_value(request.from, ends.from, step);
    DriveValue to = table || !has_end_derivative ? request.to : displace_value(request.to, ends.to, step);
    trajectory::PrescribedMotion::Request shifted_request =
        make_prescribed_motion_request(shifted, quantities, std::move(from), std::move(to));
    shifted_request.switch_times = request.switch_times;
    stencil.motions.emplace_back(shifted_request);
    stencil.has_matching_jumps = stencil.has_matching_jumps &&
                                 stencil.motions.back().jump_times().size() == prescribed_motion_.jump_times().size();
  }
  stencils_.push_back(std::move(stencil));
}

DualNumber PrescribedMotionGradient::at(double time, trajectory::Side side, long jump,
                                        trajectory::DriveSampleOf<DualNumber>& sample) {
  prescribed_motion_.at(time, side, drive_sample_);
  set_without_derivatives(drive_sample_, sample);
  DualNumber dual_time(time);
  const double time_fraction = time / prescribed_motion_.duration();
  for (const TangentMotion& tangent : tangents_) {
    tangent.motion.at(time, side, drive_sample_);
    add_derivative(drive_sample_, 1, tangent.variable, sample);
  }
  for (const DifferenceStencil& stencil : stencils_)
    for (std::size_t i = 0; i < stencil.motions.size(); ++i) {
      const trajectory::PrescribedMotion& shifted = stencil.motions[i];
      const double shifted_time = jump >= 0 && stencil.has_matching_jumps
                                      ? shifted.jump_times()[static_cast<std::size_t>(jump)]
                                      : time_fraction * shifted.duration();
      shifted.at(shifted_time, side, drive_sample_);
      const double weight = stencil_weights[i] / stencil.step;
      add_derivative(drive_sample_, weight, stencil.variable, sample);
      dual_time.d[stencil.variable] += weight * shifted_time;
    }
  // a longer duration slows the motion down: rates by its relative change, accelerations by twice that
  for (std::size_t k = 0; k < numerics::dual_width; ++k) {
    if (relative_duration_rate_[k] == 0) continue;
    dual_time.d[k] += relative_duration_rate_[k] * time;
    for (DualNumber& x : sample.rate) x.d[k] -= relative_duration_rate_[k] * x.value;
    for (DualNumber& x : sample.acceleration) x.d[k] -= 2 * relative_duration_rate_[k] * x.value;
    for (DualNumber& x : sample.angular_velocity) x.d[k] -= relative_duration_rate_[k] * x.value;
    for (DualNumber& x : sample.angular_acceleration) x.d[k] -= 2 * relative_duration_rate_[k] * x.value;
  }
  return dual_time;
}

bool PrescribedMotionGradient::is_moving_jump(long jump) const {
  const double time = prescribed_motion_.jump_times()[static_cast<std::size_t>(jump)];
  return std::any_of(stencils_.begin(), stencils_.end(), [&](const DifferenceStencil& stencil) {
    if (!stencil.has_matching_jumps) return false;
    const trajectory::PrescribedMotion& shifted = stencil.motions.back();
    return std::abs(shifted.jump_times()[static_cast<std::size_t>(jump)] / shifted.duration() -
                    time / prescribed_motion_.duration()) > 1e-9 * stencil_step;
  });
}

template PrescribedMotionGradient::PrescribedMotionGradient(const MechanismOf<DualNumber>&,
                                                            const kinematics::Tree<kinematics::Planar>&,
                                                            const std::vector<CoordinateId>&,
                                                            const TrajectoryOf<DualNumber>&, const Trajectory&,
                                                            const kinematics::CompiledTrajectory<kinematics::Planar>&);
template PrescribedMotionGradient::PrescribedMotionGradient(const MechanismOf<DualNumber>&,
                                                            const kinematics::Tree<kinematics::Spatial>&,
                                                            const std::vector<CoordinateId>&,
                                                            const TrajectoryOf<DualNumber>&, const Trajectory&,
                                                            const kinematics::CompiledTrajectory<kinematics::Spatial>&);

}  // namespace balance::derivatives
