#include "balance/gradients/schedule_gradient.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/rotation.hpp"
#include "balance/motion/equations.hpp"
#include "balance/motion/trajectory_conversion.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double places[] = {-2, -1, 1, 2};
constexpr double weights[] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
constexpr double reach = 1e-4;  ///< of a step [m, rad, parts]

/// The driven quantities at a pose of the mechanism, with their derivatives.
template <class S>
DriveSampleOf<DualNumber> measured(const MechanismOf<DualNumber>& mechanism, const Tree<S>& values,
                                   const std::vector<CoordinateId>& needed, const PoseTargetOf<DualNumber>& pose,
                                   const VectorX& y, const DriveQuantities& quantities) {
  using D = OverDuals<S>;
  Tree<D> tree = compile<D>(mechanism, needed);
  for (const NodeId spherical : values.spherical_joints)
    tree.nodes[spherical].R_PF = cast<DualNumber>(values.nodes[spherical].R_PF);
  const PoseEquations<D> stated = pose_equations(mechanism, tree, pose);
  Equations<D> equations(tree, stated.drive, true);
  State<D> state(tree.nodes.size());
  VectorXOf<DualNumber> dual_y = y.cast<DualNumber>();
  std::vector<DualNumber> x(static_cast<std::size_t>(std::max(tree.columns, equations.rows())));
  poses(tree, dual_y.data(), state);
  equations.fill(state, dual_y.data(), stated.target, x.data());
  equations.factorise();
  equations.solve(x.data());
  for (int c = 0; c < tree.columns; ++c) dual_y[c].d = (-x[static_cast<std::size_t>(c)]).d;
  poses(tree, dual_y.data(), state);
  return measure(tree, drive_rows(mechanism, tree, quantities), state, dual_y.data());
}

DriveValue derivative_of(const DriveSampleOf<DualNumber>& sample, std::size_t k) {
  const auto number = [k](const DualNumber& x) { return x.d[k]; };
  return {sample.value.unaryExpr(number), sample.rotation.unaryExpr(number)};
}

/// The value moved along its derivative.
DriveValue moved(const DriveValue& value, const DriveValue& rate, double step) {
  DriveValue out = value;
  if (out.value.size() > 0) out.value += step * rate.value;
  const Matrix3 spin = rate.rotation * value.rotation.transpose();
  out.rotation = rotation_from_vector(step * Vector3(spin(2, 1), spin(0, 2), spin(1, 0))) * value.rotation;
  return out;
}

double largest(const DriveValue& value) { return std::max(max_abs(value.value), max_abs(value.rotation)); }

/// Of the numbers that say which way a trajectory goes and by what law; a table's times as parts of their whole.
double largest_of_way(const Trajectory& rate, double duration) {
  double size = 0;
  Trajectory way;
  way.duration = 0;
  way.law = rate.law;
  way.path = rate.path;
  if (auto* table = std::get_if<TablePath>(&way.path))
    for (double& time : table->time) time /= duration;
  converted<double>(way, [&size](double x) {
    size = std::max(size, std::abs(x));
    return x;
  });
  return size;
}

bool any_course(const Trajectory& rate) {
  return std::any_of(rate.courses.begin(), rate.courses.end(), [](const Course& course) {
    const auto& c = std::get<AddedSpline>(course.kind).coefficients;
    return std::any_of(c.begin(), c.end(), [](double x) { return x != 0; });
  });
}

/// What the ends and the points between them are prescribed by is linear in them.
bool linear_in_points(const Trajectory& values, const Trajectory& rate, const DriveQuantities& quantities) {
  if (!quantities.rotation.empty() || rate.law.ramp_up != 0 || rate.law.ramp_down != 0) return false;
  const auto still = [](const std::vector<double>& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](double x) { return x == 0; });
  };
  if (const auto* way = std::get_if<WaypointPath>(&values.path))
    return !way->fractions.empty() && still(std::get<WaypointPath>(rate.path).fractions);
  return std::holds_alternative<LinePath>(values.path);
}

/// Nothing but courses changes, and they do not ask where on the way the motion is, or the way is one leg.
bool only_courses(const Trajectory& values, double way) {
  const auto* points = std::get_if<WaypointPath>(&values.path);
  const bool one_leg = points == nullptr || points->spline;
  return way == 0 && (one_leg || std::all_of(values.courses.begin(), values.courses.end(), [](const Course& course) {
                        return std::get<AddedSpline>(course.kind).over_time;
                      }));
}

/// Adds part of a sample to the derivatives by a number.
void add(const DriveSample& part, double weight, std::size_t number, DriveSampleOf<DualNumber>& sample) {
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
void set(const DriveSample& values, DriveSampleOf<DualNumber>& sample) {
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
ScheduleGradient::ScheduleGradient(const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree,
                                   const std::vector<CoordinateId>& needed, const TrajectoryOf<DualNumber>& trajectory,
                                   const Trajectory& values, const Plan<S>& plan)
    : schedule_(*plan.schedule) {
  Ways rates;
  for (std::size_t k = 0; k < dual_width; ++k)
    rates[k] = converted<double>(trajectory, [k](const DualNumber& x) { return x.d[k]; });
  const bool table = std::holds_alternative<TablePath>(values.path);
  const auto ends = derive_ends(mechanism, tree, needed, trajectory, plan, rates);
  for (std::size_t k = 0; k < dual_width; ++k) {
    const double points = table ? 0 : std::max(largest(ends[k].from), largest(ends[k].to));
    const double way = std::max(points, largest_of_way(rates[k], schedule_.duration()));
    if (!table) stretch_[k] = rates[k].duration / schedule_.duration();
    if (way == 0 && !any_course(rates[k])) continue;
    if (linear_in_points(values, rates[k], plan.quantities) || only_courses(values, way))
      add_tangent(k, values, rates[k], ends[k], plan.quantities);
    else
      add_neighbours(k, trajectory, way, plan.request, ends[k], plan.quantities);
  }
}

template <class S>
std::array<ScheduleGradient::Ends, dual_width> ScheduleGradient::derive_ends(
    const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree, const std::vector<CoordinateId>& needed,
    const TrajectoryOf<DualNumber>& trajectory, const Plan<S>& plan, const Ways& rates) const {
  std::array<Ends, dual_width> ends;
  if (std::holds_alternative<TablePath>(plan.request.path)) return ends;
  const DriveSampleOf<DualNumber> start =
      measured(mechanism, tree, needed, trajectory.from, plan.start, plan.quantities);
  DriveSampleOf<DualNumber> end;
  if (plan.end.size() > 0) end = measured(mechanism, tree, needed, trajectory.to, plan.end, plan.quantities);
  for (std::size_t k = 0; k < dual_width; ++k) {
    ends[k].from = stated_values(plan.quantities, rates[k].from, derivative_of(start, k));
    ends[k].to =
        plan.end.size() > 0 ? derivative_of(end, k) : stated_values(plan.quantities, rates[k].to, ends[k].from);
    if (plan.quantities.rotation.empty()) ends[k].from.rotation = ends[k].to.rotation = Matrix3::Zero();
  }
  return ends;
}

/// Where only courses change the way does not matter, and a straight one has no bends that could not be linear.
void ScheduleGradient::add_tangent(std::size_t number, const Trajectory& values, const Trajectory& rate,
                                   const Ends& ends, const DriveQuantities& quantities) {
  Trajectory tangent = rate;
  tangent.law = values.law;
  tangent.duration = schedule_.duration();
  if (auto* way = std::get_if<WaypointPath>(&tangent.path); way != nullptr && !way->fractions.empty())
    way->fractions = std::get<WaypointPath>(values.path).fractions;
  else
    tangent.path = LinePath{};
  DriveValue from{ends.from.value, Matrix3::Identity()}, to{ends.to.value, Matrix3::Identity()};
  tangents_.push_back({number, Schedule(make_request(tangent, quantities, std::move(from), std::move(to)))});
}

void ScheduleGradient::add_neighbours(std::size_t number, const TrajectoryOf<DualNumber>& trajectory, double size,
                                      const Schedule::Request& request, const Ends& ends,
                                      const DriveQuantities& quantities) {
  Neighbours near{number, reach / (size > 0 ? size : 1), {}, true};
  const bool table = std::holds_alternative<TablePath>(request.path);
  const bool ends_there = request.to.value.size() == ends.to.value.size();
  for (const double place : places) {
    const double step = place * near.step;
    Trajectory other = converted<double>(trajectory, [&](const DualNumber& x) { return x.value + step * x.d[number]; });
    other.duration = request.duration;  // its change is told apart
    DriveValue from = table ? request.from : moved(request.from, ends.from, step);
    DriveValue to = table || !ends_there ? request.to : moved(request.to, ends.to, step);
    Schedule::Request there = make_request(other, quantities, std::move(from), std::move(to));
    there.switches = request.switches;
    near.schedules.emplace_back(there);
    near.same_jumps = near.same_jumps && near.schedules.back().jumps().size() == schedule_.jumps().size();
  }
  neighbours_.push_back(std::move(near));
}

DualNumber ScheduleGradient::at(double time, Side side, long jump, DriveSampleOf<DualNumber>& sample) {
  schedule_.at(time, side, now_);
  set(now_, sample);
  DualNumber when(time);
  const double part = time / schedule_.duration();
  for (const Tangent& tangent : tangents_) {
    tangent.schedule.at(time, side, now_);
    add(now_, 1, tangent.number, sample);
  }
  for (const Neighbours& near : neighbours_)
    for (std::size_t i = 0; i < near.schedules.size(); ++i) {
      const Schedule& other = near.schedules[i];
      const double there =
          jump >= 0 && near.same_jumps ? other.jumps()[static_cast<std::size_t>(jump)] : part * other.duration();
      other.at(there, side, now_);
      const double weight = weights[i] / near.step;
      add(now_, weight, near.number, sample);
      when.d[near.number] += weight * there;
    }
  // slower by the longer duration: rates by its part, accelerations by twice that
  for (std::size_t k = 0; k < dual_width; ++k) {
    if (stretch_[k] == 0) continue;
    when.d[k] += stretch_[k] * time;
    for (DualNumber& x : sample.rate) x.d[k] -= stretch_[k] * x.value;
    for (DualNumber& x : sample.acceleration) x.d[k] -= 2 * stretch_[k] * x.value;
    for (DualNumber& x : sample.angular_velocity) x.d[k] -= stretch_[k] * x.value;
    for (DualNumber& x : sample.angular_acceleration) x.d[k] -= 2 * stretch_[k] * x.value;
  }
  return when;
}

bool ScheduleGradient::moves(long jump) const {
  const double time = schedule_.jumps()[static_cast<std::size_t>(jump)];
  return std::any_of(neighbours_.begin(), neighbours_.end(), [&](const Neighbours& near) {
    if (!near.same_jumps) return false;
    const Schedule& other = near.schedules.back();
    return std::abs(other.jumps()[static_cast<std::size_t>(jump)] / other.duration() - time / schedule_.duration()) >
           1e-9 * reach;
  });
}

template ScheduleGradient::ScheduleGradient(const MechanismOf<DualNumber>&, const Tree<Planar>&,
                                            const std::vector<CoordinateId>&, const TrajectoryOf<DualNumber>&,
                                            const Trajectory&, const Plan<Planar>&);
template ScheduleGradient::ScheduleGradient(const MechanismOf<DualNumber>&, const Tree<Spatial>&,
                                            const std::vector<CoordinateId>&, const TrajectoryOf<DualNumber>&,
                                            const Trajectory&, const Plan<Spatial>&);

}  // namespace balance
