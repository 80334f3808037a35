#include "balance/gradients/schedule_gradient.hpp"

#include "balance/base/rotation.hpp"
#include "balance/motion/equations.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// The driven quantities at a pose of the mechanism, with their derivatives.
template <class S>
DriveSampleOf<DualNumber> measured(const MechanismOf<DualNumber>& mechanism, const Tree<S>& values,
                                   const std::vector<int>& needed, const PoseTarget& pose, const VectorX& y,
                                   const DriveQuantities& quantities) {
  using D = OverDuals<S>;
  Tree<D> tree = compile<D>(mechanism, needed);
  for (const int ball : values.balls) tree.nodes[ball].R_PF = constant(values.nodes[ball].R_PF);
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

/// The value moved along the derivative of a measured one, where it was measured at all: what a pose states does not depend on numbers.
DriveValue moved(const DriveValue& value, const DriveSampleOf<DualNumber>& measured, std::size_t k, double step) {
  DriveValue out = value;
  for (Eigen::Index i = 0; i < out.value.size(); ++i) out.value[i] += step * measured.value[i].d[k];
  Matrix3 rate;  // of the rotation
  for (int i = 0; i < 9; ++i) rate(i) = measured.rotation(i).d[k];
  const Matrix3 spin = rate * value.rotation.transpose();
  out.rotation = rotation_from_vector(step * Vector3(spin(2, 1), spin(0, 2), spin(1, 0))) * value.rotation;
  return out;
}

/// Values that a pose states have no derivatives.
void drop_stated(const DriveQuantities& quantities, const PoseTarget& pose, DriveSampleOf<DualNumber>& measured) {
  DriveValue unstated{VectorX::Constant(measured.value.size(), NAN), Matrix3::Identity()};
  const DriveValue stated = stated_values(quantities, pose, unstated);
  for (Eigen::Index i = 0; i < measured.value.size(); ++i)
    if (std::isfinite(stated.value[i])) measured.value[i].d.fill(0);
  if (pose.orientation || quantities.rotation.empty())
    for (int i = 0; i < 9; ++i) measured.rotation(i).d.fill(0);
}

double largest_derivative(const DriveSampleOf<DualNumber>& sample, std::size_t k) {
  double largest = 0;
  for (const DualNumber& x : sample.value) largest = std::max(largest, std::abs(x.d[k]));
  for (int i = 0; i < 9; ++i) largest = std::max(largest, std::abs(sample.rotation(i).d[k]));
  return largest;
}

constexpr double places[] = {-2, -1, 1, 2};
constexpr double weights[] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};

}  // namespace

template <class S>
void ScheduleGradient::add_neighbours(const Plan<S>& plan, const Trajectory& trajectory,
                                      const DriveSampleOf<DualNumber>& from, const DriveSampleOf<DualNumber>& to,
                                      std::size_t number) {
  Neighbours near{number, 1e-4 / std::max(largest_derivative(from, number), largest_derivative(to, number)), {}};
  for (const double place : places) {
    Schedule::Request other = plan.request;
    other.from = moved(other.from, from, number, place * near.step);
    other.to = moved(other.to, to, number, place * near.step);
    if (const auto* way = std::get_if<WaypointPath>(&trajectory.path)) {
      other.via.clear();
      for (const PoseTarget& point : way->points)
        other.via.push_back(stated_values(plan.quantities, point, other.via.empty() ? other.from : other.via.back()));
    }
    near.schedules.emplace_back(other);
  }
  neighbours_.push_back(std::move(near));
}

template <class S>
ScheduleGradient::ScheduleGradient(const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree,
                                   const std::vector<int>& needed, const Trajectory& trajectory, const Plan<S>& plan)
    : schedule_(*plan.schedule) {
  if (std::holds_alternative<TablePath>(trajectory.path)) return;
  DriveSampleOf<DualNumber> from = measured(mechanism, tree, needed, trajectory.from, plan.start, plan.quantities);
  drop_stated(plan.quantities, trajectory.from, from);
  DriveSampleOf<DualNumber> to = from;
  if (plan.end.size() > 0)
    to = measured(mechanism, tree, needed, trajectory.to, plan.end, plan.quantities);
  else
    drop_stated(plan.quantities, trajectory.to, to);
  for (std::size_t k = 0; k < dual_width; ++k)
    if (std::max(largest_derivative(from, k), largest_derivative(to, k)) > 0)
      add_neighbours(plan, trajectory, from, to, k);
}

void ScheduleGradient::at(double time, Side side, DriveSampleOf<DualNumber>& sample) const {
  DriveSample now;
  schedule_.at(time, side, now);
  sample = {now.value.cast<DualNumber>(),
            now.rate.cast<DualNumber>(),
            now.acceleration.cast<DualNumber>(),
            now.rotation.cast<DualNumber>(),
            now.angular_velocity.cast<DualNumber>(),
            now.angular_acceleration.cast<DualNumber>()};
  for (const Neighbours& near : neighbours_)
    for (std::size_t i = 0; i < near.schedules.size(); ++i) {
      near.schedules[i].at(time, side, now);
      const double weight = weights[i] / near.step;
      const auto add = [&](auto& duals, const auto& values) {
        for (Eigen::Index e = 0; e < values.size(); ++e) duals(e).d[near.number] += weight * values(e);
      };
      add(sample.value, now.value);
      add(sample.rate, now.rate);
      add(sample.acceleration, now.acceleration);
      add(sample.rotation, now.rotation);
      add(sample.angular_velocity, now.angular_velocity);
      add(sample.angular_acceleration, now.angular_acceleration);
    }
}

template ScheduleGradient::ScheduleGradient(const MechanismOf<DualNumber>&, const Tree<Planar>&,
                                            const std::vector<int>&, const Trajectory&, const Plan<Planar>&);
template ScheduleGradient::ScheduleGradient(const MechanismOf<DualNumber>&, const Tree<Spatial>&,
                                            const std::vector<int>&, const Trajectory&, const Plan<Spatial>&);

}  // namespace balance
