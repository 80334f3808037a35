// What each controller makes of its errors.

#include "balance/base/factorizations.hpp"
#include "balance/control/control_law.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

namespace {

/// The least-norm solution of A x = b.
/// @return false if A does not reach every b
bool solve_full_row_rank(const MatrixX& A, const VectorX& b, VectorX& x) {
  CompleteOrthogonalDecomposition factors;
  factors.setThreshold(1e-10);
  factors.compute(A);
  if (factors.rank() < A.rows()) return false;
  x = factors.solve(b);
  return x.allFinite();
}

/// Whole turns do not count.
double wrap_angle(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

}  // namespace

ControlLaw::TrackingErrors ControlLaw::actuated_errors(const DesiredState& desired, const VectorX& position,
                                                       const VectorX& velocity) const {
  TrackingErrors e{-position, -velocity, VectorX(position.size())};
  for (Eigen::Index a = 0; a < position.size(); ++a) {
    const int c = mechanism_.actuators[static_cast<std::size_t>(a)];
    e.position[a] += desired.position[c];
    e.rate[a] += desired.velocity[c];
    e.acceleration[a] = desired.acceleration[c];
  }
  return e;
}

/// Efforts that give the actuated coordinates these accelerations at the model's state.
bool ControlLaw::add_acceleration_efforts(const VectorX& actuated) {
  const EquationOfMotion equation = model_.equation();
  VectorX rate_change;
  if (model_.independent() == mechanism_.actuators) {
    rate_change = actuated;
  } else {
    const Transformation all = model_.transformation();
    const auto motors = static_cast<Eigen::Index>(mechanism_.actuators.size());
    MatrixX rows(motors, all.matrix.cols());
    VectorX rest(motors);
    for (Eigen::Index a = 0; a < motors; ++a) {
      const int c = mechanism_.actuators[static_cast<std::size_t>(a)];
      rows.row(a) = all.matrix.row(c);
      rest[a] = actuated[a] - all.bias[c];
    }
    // More motors than freedoms measure the same twice: their average.
    if (!solve_full_row_rank(rows.transpose() * rows, rows.transpose() * rest, rate_change)) return false;
  }
  VectorX efforts;
  if (!solve_full_row_rank(equation.input, equation.mass * rate_change + equation.bias, efforts)) return false;
  efforts_ += efforts;
  return true;
}

/// Efforts that do the work of generalised forces on the independent coordinates.
bool ControlLaw::add_generalised_forces(const VectorX& generalised) {
  VectorX efforts;
  if (!solve_full_row_rank(model_.equation().input, generalised, efforts)) return false;
  efforts_ += efforts;
  return true;
}

/// Efforts that hold the model at rest where it is.
bool ControlLaw::compensate_gravity(double time, const VectorX& position) {
  failure_ = update_model(time, position, VectorX::Zero(position.size()));
  return failure_.status == MotionStatus::done && add_generalised_forces(model_.equation().bias);
}

bool ControlLaw::apply_computed_torque(double time, const DesiredState& desired, const VectorX& position,
                                       const VectorX& velocity) {
  failure_ = update_model(time, position, velocity);
  if (failure_.status != MotionStatus::done) return false;
  const TrackingErrors e = actuated_errors(desired, position, velocity);
  return add_acceleration_efforts(e.acceleration + kd_.cwiseProduct(e.rate) + kp_.cwiseProduct(e.position));
}

/// sign(s), or its linear version inside the boundary layer.
/// @param layer which of the boundary layers. @param unit that it is told in: 1, or the length that s is measured in
double ControlLaw::switching(double s, Eigen::Index layer, double unit) const {
  if (controller_.boundary_layer.size() > 0)
    return std::clamp(s / (controller_.boundary_layer[layer] * unit), -1.0, 1.0);
  return s > 0 ? 1 : s < 0 ? -1 : 0;
}

/// P0 eq. 47 for every actuated coordinate.
bool ControlLaw::apply_sliding_mode(const DesiredState& desired, const VectorX& position, const VectorX& velocity) {
  const TrackingErrors e = actuated_errors(desired, position, velocity);
  VectorX v = e.acceleration + lambda_.cwiseProduct(e.rate);
  for (Eigen::Index a = 0; a < v.size(); ++a)
    v[a] -= k_[a] * switching(-(e.rate[a] + lambda_[a] * e.position[a]), a, 1);
  return add_acceleration_efforts(v);
}

/// Errors of the tree's coordinates at the model's state. Where a coordinate has no reading of its own (a spherical joint's), the
/// error is the one that the others' errors cause to first order.
ControlLaw::TrackingErrors ControlLaw::tree_errors(const DesiredState& desired, const Transformation& tree) const {
  const std::vector<CoordinateId>&columns = model_.tree(), &independent = model_.independent();
  const auto error = [&](int c) {
    const double e = desired.position[c] - state_[c];
    const bool driven =
        std::find(mechanism_.actuators.begin(), mechanism_.actuators.end(), c) != mechanism_.actuators.end();
    const bool angle = mechanism_.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::angle;
    return angle && !driven ? wrap_angle(e) : e;
  };
  const auto d = static_cast<Eigen::Index>(independent.size()), n = static_cast<Eigen::Index>(columns.size());
  TrackingErrors own{VectorX::Zero(d), VectorX::Zero(d), VectorX::Zero(d)};
  for (Eigen::Index i = 0; i < d; ++i) {
    const int c = independent[static_cast<std::size_t>(i)];
    if (!is_assembly_independent_[static_cast<std::size_t>(c)]) continue;
    own.position[i] = error(c);
    own.rate[i] = desired.velocity[c] - rates_[c];
    own.acceleration[i] = desired.acceleration[c];
  }
  TrackingErrors e{tree.matrix * own.position, tree.matrix * own.rate, tree.matrix * own.acceleration + tree.bias};
  for (Eigen::Index i = 0; i < n; ++i) {
    const int c = columns[static_cast<std::size_t>(i)];
    if (!is_assembly_independent_[static_cast<std::size_t>(c)]) continue;
    e.position[i] = error(c);
    e.rate[i] = desired.velocity[c] - rates_[c];
    e.acceleration[i] = desired.acceleration[c];
  }
  return e;
}

/// P0 eq. 56 and 61, or with the other projection.
bool ControlLaw::apply_extended_sliding_mode(const DesiredState& desired) {
  const Transformation tree = model_.tree_transformation();
  const TrackingErrors e = tree_errors(desired, tree);
  const double lambda = controller_.lambda.size() > 0 ? controller_.lambda[0] : controller_.natural_frequency();
  VectorX wished = e.acceleration + lambda * e.rate, unit(wished.size());
  for (Eigen::Index i = 0; i < wished.size(); ++i) {
    const int c = model_.tree()[static_cast<std::size_t>(i)];
    unit[i] = mechanism_.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::length ? length_ : 1;
    wished[i] -= k_[0] * unit[i] * switching(-(e.rate[i] + lambda * e.position[i]), 0, unit[i]);
  }
  if (controller_.projection == AccelerationProjection::inertia) {
    const TreeEquation equation = model_.tree_equation();
    return add_generalised_forces(tree.matrix.transpose() * (equation.mass * wished + equation.bias));
  }
  const MatrixX scaled = unit.cwiseInverse().asDiagonal() * tree.matrix;
  const VectorX rest = (wished - tree.bias).cwiseQuotient(unit);
  VectorX rate_change;
  if (!solve_full_row_rank(scaled.transpose() * scaled, scaled.transpose() * rest, rate_change)) return false;
  const EquationOfMotion equation = model_.equation();
  return add_generalised_forces(equation.mass * rate_change + equation.bias);
}

bool ControlLaw::open_loop(double time, const DesiredState& desired) {
  if (effort_profile_) {
    effort_profile_->evaluate(time, efforts_);
    return true;
  }
  const auto motors = static_cast<Eigen::Index>(mechanism_.actuators.size());
  VectorX position(motors), velocity(motors), acceleration(motors);
  for (Eigen::Index a = 0; a < motors; ++a) {
    const int c = mechanism_.actuators[static_cast<std::size_t>(a)];
    position[a] = desired.position[c];
    velocity[a] = desired.velocity[c];
    acceleration[a] = desired.acceleration[c];
  }
  failure_ = update_model(time, position, velocity);
  return failure_.status == MotionStatus::done && add_acceleration_efforts(acceleration);
}

void ControlLaw::saturate_efforts() {
  at_limit_.setZero();
  if (controller_.torque_limit.size() == 0) return;
  for (Eigen::Index a = 0; a < efforts_.size(); ++a) {
    const double most = controller_.torque_limit[a];
    if (std::abs(efforts_[a]) <= most) continue;
    efforts_[a] = std::copysign(most, efforts_[a]);
    at_limit_[a] = 1;
  }
}

}  // namespace balance
