#include "balance/synthesis/verification/natural_equations.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/regularity.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace balance::verification::natural {

namespace {

constexpr double max_correction = 0.1;  // of a prediction, in radians or characteristic lengths
constexpr int max_step_halvings = 24;
constexpr double min_pivot = 1e-7;  // half of the digits are lost

}  // namespace

NaturalStepper::NaturalStepper(const NaturalModel& model, DriveRows drive, const trajectory::PrescribedMotion& schedule,
                               int freedoms)
    : model_(model), schedule_(schedule), freedoms_(freedoms), equations_(model, std::move(drive)) {
  state_.position = model.start;
  state_.velocity = state_.acceleration = model.start;
  state_.velocity.set(VectorX::Zero(model.unknowns()));
  state_.acceleration.set(VectorX::Zero(model.unknowns()));
}

bool NaturalStepper::begin(const NaturalCoordinates& initial_position) {
  state_.time = 0;
  state_.position = initial_position;
  schedule_.at(0, trajectory::Side::after, sample_);
  if (!equations_.newton(state_.position, sample_.value) || !equations_.differentiate(state_, sample_)) {
    stop(StepResult::no_convergence);
    return false;
  }
  iterations_ = equations_.iterations();
  update_angles(model_.body_angles);
  constraint_monitor_.factorise(equations_.jacobian(state_.position));
  constraint_monitor_.store();
  if (!actuation_matrix_) return true;
  const bool is_held = actuation_monitor_.factorise(actuation_matrix_(state_.position)) >= min_pivot;
  actuation_monitor_.store();
  if (!is_held) stop(StepResult::actuation_singular);
  return is_held;
}

double NaturalStepper::angular_velocity(BodyId body) const {
  const BodyModel& b = model_.bodies[static_cast<std::size_t>(body)];
  if (b.angle >= 0) return state_.velocity.scalars[static_cast<std::size_t>(b.angle)];
  return cross(b.direction.at(state_.position), b.direction.rate(state_.velocity));
}

double NaturalStepper::angular_acceleration(BodyId body) const {
  const BodyModel& b = model_.bodies[static_cast<std::size_t>(body)];
  if (b.angle >= 0) return state_.acceleration.scalars[static_cast<std::size_t>(b.angle)];
  return cross(b.direction.at(state_.position), b.direction.rate(state_.acceleration));
}

void NaturalStepper::update_angles(const std::vector<double>& expected) {
  constexpr double two_pi = 2 * std::numbers::pi;
  angles_.resize(model_.bodies.size());
  for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
    const BodyModel& body = model_.bodies[b];
    if (body.angle >= 0) {
      angles_[b] = state_.position.scalars[static_cast<std::size_t>(body.angle)];
    } else {
      const double angle = std::arg(body.direction.at(state_.position));
      angles_[b] = angle + two_pi * std::round((expected[b] - angle) / two_pi);
    }
  }
}

bool NaturalStepper::is_far_from_prediction(const NaturalCoordinates& predicted,
                                            const NaturalCoordinates& corrected) const {
  for (std::size_t k = 0; k < corrected.points.size(); ++k)
    if (std::abs(corrected.points[k] - predicted.points[k]) > max_correction) return true;
  for (std::size_t s = 0; s < corrected.scalars.size(); ++s)
    if (std::abs(corrected.scalars[s] - predicted.scalars[s]) > max_correction) return true;
  for (const BodyModel& body : model_.bodies)
    if (std::abs(body.direction.at(corrected) - body.direction.at(predicted)) > max_correction) return true;
  return false;
}

NaturalStepper::StepResult NaturalStepper::step(double time) {
  const double h = time - state_.time;
  schedule_.at(time, trajectory::Side::after, sample_);
  NaturalState next = state_;
  next.time = time;
  for (std::size_t k = 0; k < next.position.points.size(); ++k)
    next.position.points[k] += h * state_.velocity.points[k] + h * h / 2 * state_.acceleration.points[k];
  for (std::size_t s = 0; s < next.position.scalars.size(); ++s)
    next.position.scalars[s] += h * state_.velocity.scalars[s] + h * h / 2 * state_.acceleration.scalars[s];
  const NaturalCoordinates predicted = next.position;
  if (!equations_.newton(next.position, sample_.value)) return StepResult::no_convergence;
  iterations_ += equations_.iterations();
  if (is_far_from_prediction(predicted, next.position)) return StepResult::far_from_prediction;
  if (!equations_.differentiate(next, sample_)) return StepResult::no_convergence;
  const StepResult attempt = check_step(next);
  if (attempt != StepResult::done) return attempt;
  std::vector<double> expected(model_.bodies.size());
  for (std::size_t b = 0; b < expected.size(); ++b)
    expected[b] =
        angles_[b] + h * angular_velocity(static_cast<int>(b)) + h * h / 2 * angular_acceleration(static_cast<int>(b));
  state_ = std::move(next);
  constraint_monitor_.store();
  actuation_monitor_.store();
  update_angles(expected);
  return StepResult::done;
}

/// Maximum deviation of an entry from a straight line: entries are linear in points or in directions that rotate with
/// them.
double NaturalStepper::curvature(const NaturalState& next) const {
  double max_acceleration = 0;
  for (const NaturalState* state : {&state_, &next}) {
    for (const Complex p : state->acceleration.points) max_acceleration = std::max(max_acceleration, std::abs(p));
    for (const BodyModel& body : model_.bodies)
      max_acceleration = std::max(max_acceleration, std::abs(body.direction.rate(state->acceleration)));
  }
  const double h = next.time - state_.time;
  return h * h / 4 * max_acceleration;
}

/// Checks whether one of the matrices may have lost rank since the current state.
NaturalStepper::StepResult NaturalStepper::check_step(const NaturalState& next) {
  const double deviation = curvature(next), pivot = constraint_monitor_.factorise(equations_.jacobian(next.position));
  if (!(pivot >= min_pivot && deviation <= numerics::max_matrix_curvature * pivot &&
        constraint_monitor_.is_near_stored(numerics::max_matrix_change)))
    return StepResult::possible_rank_loss;
  if (actuation_matrix_) {
    const double actuation_pivot = actuation_monitor_.factorise(actuation_matrix_(next.position));
    if (!(actuation_pivot >= min_pivot && deviation <= numerics::max_matrix_curvature * actuation_pivot &&
          actuation_monitor_.is_near_stored(numerics::max_matrix_change)))
      return StepResult::actuation_singular;
    actuation_extrapolation_.add_sample(actuation_pivot, next.time);
  }
  pivot_extrapolation_.add_sample(pivot, next.time);
  return StepResult::done;
}

bool NaturalStepper::advance(double time) {
  iterations_ = 0;
  double step_size = time - state_.time;
  const double min_step_size = std::ldexp(step_size, -max_step_halvings);
  while (state_.time < time) {
    // the last step ends exactly at the requested time
    double next = time - state_.time < 1.5 * step_size ? time : state_.time + step_size;
    const double max_step_size = schedule_.max_step(state_.time);
    if (next - state_.time > (1 + 1e-6) * max_step_size) next = state_.time + max_step_size;
    const StepResult attempt = step(next);
    if (attempt == StepResult::done) {
      step_size *= 2;
    } else if ((step_size = std::min(step_size, next - state_.time) / 2) < min_step_size) {
      stop(attempt);
      return false;
    }
  }
  return true;
}

void NaturalStepper::accelerate(trajectory::Side side) {
  schedule_.at(state_.time, side, sample_);
  equations_.accelerate(state_, sample_);
}

/// Determines which matrix has lost rank at the last good configuration.
void NaturalStepper::stop(StepResult attempt) {
  const numerics::PivotExtrapolation& extrapolation =
      attempt == StepResult::actuation_singular ? actuation_extrapolation_ : pivot_extrapolation_;
  const double time = std::min(extrapolation.extrapolate_zero(state_.time), schedule_.duration());
  if (attempt == StepResult::actuation_singular) {
    outcome_ = trajectory::make_actuation_singularity_outcome(time, "");
    return;
  }
  const int rank = model_.unknowns() - freedoms_;
  const auto singular_value_ratio = [](const MatrixX& matrix, int k) {
    if (k <= 0 || matrix.rows() < k) return 1.0;
    const VectorX values = numerics::singular_values(matrix);
    return values[0] > 0 ? values[k - 1] / values[0] : 0.0;
  };
  const double constraint_ratio = singular_value_ratio(equations_.constraint_jacobian(state_.position), rank);
  const double system_ratio = singular_value_ratio(equations_.jacobian(state_.position), model_.unknowns());
  constexpr double rank_loss_threshold = 0.02;  // at distance ε from a singularity the values are of the order √ε
  const char* reason;
  if (constraint_ratio < rank_loss_threshold && constraint_ratio < 10 * system_ratio) {
    outcome_.status = MotionStatus::constraint_singularity;
    reason = "constraint singularity: the constraints lose rank, the mechanism gains a freedom";
  } else if (system_ratio < rank_loss_threshold) {
    outcome_.status = MotionStatus::drive_singularity;
    reason =
        "drive singularity: the prescribed quantities no longer determine the motion (the path may leave the workspace "
        "here)";
  } else if (attempt == StepResult::no_convergence) {
    outcome_.status = MotionStatus::unreachable;
    reason = "the prescribed values cannot be reached";
  } else {
    outcome_.status = MotionStatus::assembly_jump;
    reason = "the motion could only continue by jumping to another assembly mode";
  }
  outcome_.time = time;
  outcome_.reason = trajectory::format_time_prefix(time) + reason;
}

AffineForm make_com_form(const NaturalModel& model) {
  AffineForm sum = make_constant_form(model.ground_disc_moment / model.total_mass);
  for (const MassEntry& entry : model.mass)
    sum = sum + AffineForm{{}, {{entry.column, entry.value / model.total_mass}}};
  return sum;
}

AffineForm make_tool_form(const Mechanism& mechanism, const NaturalModel& model) {
  const Tool& tool = mechanism.tool.value();
  return model.bodies[static_cast<std::size_t>(tool.body)].place(to_complex(tool.position, model.length()));
}

DriveRows make_drive_rows(const Mechanism& mechanism, const NaturalModel& model,
                          const trajectory::DriveQuantities& quantities) {
  DriveRows drive;
  const auto add_components = [&](const std::vector<int>& components, const AffineForm& point) {
    for (const int k : components) {
      drive.rows.push_back({.left = make_constant_form(k == 0 ? Complex(1) : imaginary), .right = point});
      drive.unit.push_back(model.length());
    }
  };
  if (!quantities.point.empty()) add_components(quantities.point, make_tool_form(mechanism, model));
  if (!quantities.com.empty()) add_components(quantities.com, make_com_form(model));
  if (quantities.tool_angle) {
    const int angle = model.bodies[static_cast<std::size_t>(mechanism.tool->body)].angle;
    ConstraintRow row;
    row.scalars.push_back({angle, 1});
    row.constant = model.tool_angle_offset;
    drive.rows.push_back(row);
    drive.unit.push_back(1);
  }
  for (const int c : quantities.coordinates) {
    const JointCoordinate& coordinate = model.coordinates[static_cast<std::size_t>(c)];
    const double unit = coordinate.angle ? 1 : model.length();
    ConstraintRow row;
    for (const ScalarTerm& term : coordinate.form.terms) row.scalars.push_back({term.scalar, term.coefficient / unit});
    row.constant = -coordinate.form.constant / unit;
    drive.rows.push_back(row);
    drive.unit.push_back(unit);
  }
  return drive;
}

namespace {

constexpr double natural_residual_tolerance = 1e-12;  // residual after which one correction is the last
constexpr int max_newton_iterations = 10;

/// Distance of the farthest fixed point in characteristic lengths, at least one: round-off is proportional to it.
double compute_ground_extent(const NaturalModel& model) {
  double extent = 1;
  for (const Complex p : model.basic.fixed) extent = std::max(extent, std::abs(p));
  return extent;
}

}  // namespace

NaturalKinematicEquations::NaturalKinematicEquations(const NaturalModel& model, DriveRows drive)
    : model_(model),
      drive_(std::move(drive)),
      residual_tolerance_(natural_residual_tolerance * compute_ground_extent(model)) {
  square_ = rows() == unknown_count();
}

VectorX NaturalKinematicEquations::residual(const NaturalCoordinates& position, const VectorX& prescribed) const {
  VectorX out(rows());
  for (int r = 0; r < constraint_count(); ++r) out[r] = model_.constraints[static_cast<std::size_t>(r)].value(position);
  for (int k = 0; k < drive_row_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    out[constraint_count() + k] = drive_.rows[i].value(position) - prescribed[k] / drive_.unit[i];
  }
  return out;
}

MatrixX NaturalKinematicEquations::jacobian(const NaturalCoordinates& position) const {
  MatrixX out(rows(), unknown_count());
  Eigen::RowVectorXd row(unknown_count());
  for (int r = 0; r < rows(); ++r) {
    const ConstraintRow& equation = r < constraint_count()
                                        ? model_.constraints[static_cast<std::size_t>(r)]
                                        : drive_.rows[static_cast<std::size_t>(r - constraint_count())];
    equation.gradient(position, model_.basic.moving, row);
    out.row(r) = row;
  }
  return out;
}

MatrixX NaturalKinematicEquations::constraint_jacobian(const NaturalCoordinates& position) const {
  return jacobian(position).topRows(constraint_count());
}

VectorX NaturalKinematicEquations::measure(const NaturalCoordinates& position) const {
  VectorX out(drive_row_count());
  for (int k = 0; k < drive_row_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    out[k] = drive_.unit[i] * drive_.rows[i].value(position);
  }
  return out;
}

bool NaturalKinematicEquations::factorise(const NaturalCoordinates& position) {
  const MatrixX matrix = jacobian(position);
  if (!square_) {
    qr_.compute(matrix);
    return qr_.rank() == unknown_count();
  }
  lu_.compute(matrix);
  const auto diagonal = lu_.matrixLU().diagonal();
  return std::all_of(diagonal.begin(), diagonal.end(), [](double pivot) { return std::abs(pivot) > 1e-300; });
}

VectorX NaturalKinematicEquations::solve(const VectorX& right_hand_side) const {
  if (square_) return lu_.solve(right_hand_side);
  return qr_.solve(right_hand_side);
}

bool NaturalKinematicEquations::newton(NaturalCoordinates& position, const VectorX& prescribed) {
  double previous_error = INFINITY;
  for (iterations_ = 0; iterations_ <= max_newton_iterations; ++iterations_) {
    const VectorX error = residual(position, prescribed);
    const double max_error = error.size() > 0 ? error.lpNorm<Eigen::Infinity>() : 0;
    if (!std::isfinite(max_error) || !factorise(position)) return false;
    position.add(-1, solve(error));
    // either small, or as small as round-off allows
    if (max_error <= residual_tolerance_ || (max_error <= 10 * residual_tolerance_ && max_error >= previous_error))
      return true;
    previous_error = max_error;
  }
  return false;
}

bool NaturalKinematicEquations::solve_least_norm(NaturalCoordinates& position, const VectorX& prescribed) const {
  for (int k = 0; k < 30; ++k) {
    const VectorX error = residual(position, prescribed);
    const double max_error = error.size() > 0 ? error.lpNorm<Eigen::Infinity>() : 0;
    if (!std::isfinite(max_error)) return false;
    numerics::CompleteOrthogonalDecomposition qr;
    qr.setThreshold(1e-9);
    qr.compute(jacobian(position));
    const VectorX step = qr.solve(error);
    if (!step.allFinite()) return false;
    const double max_component = step.size() > 0 ? step.lpNorm<Eigen::Infinity>() : 0;
    position.add(max_component > 1 ? -1 / max_component : -1, step);
    if (max_error <= 10 * residual_tolerance_) return true;
  }
  return false;
}

bool NaturalKinematicEquations::differentiate(NaturalState& state, const trajectory::DriveSample& sample) {
  if (!factorise(state.position)) return false;
  VectorX right_hand_side = VectorX::Zero(rows());
  for (int k = 0; k < drive_row_count(); ++k)
    right_hand_side[constraint_count() + k] = sample.rate[k] / drive_.unit[static_cast<std::size_t>(k)];
  state.velocity.set(solve(right_hand_side));
  accelerate(state, sample);
  return true;
}

void NaturalKinematicEquations::accelerate(NaturalState& state, const trajectory::DriveSample& sample) const {
  VectorX right_hand_side(rows());
  for (int r = 0; r < constraint_count(); ++r)
    right_hand_side[r] = -model_.constraints[static_cast<std::size_t>(r)].bias(state.position, state.velocity);
  for (int k = 0; k < drive_row_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    right_hand_side[constraint_count() + k] =
        sample.acceleration[k] / drive_.unit[i] - drive_.rows[i].bias(state.position, state.velocity);
  }
  state.acceleration.set(solve(right_hand_side));
}

MatrixX NaturalKinematicEquations::allowed_velocities() const {
  MatrixX right_hand_sides = MatrixX::Zero(rows(), drive_row_count());
  right_hand_sides.bottomRows(drive_row_count()).setIdentity();
  MatrixX out(unknown_count(), drive_row_count());
  for (int k = 0; k < drive_row_count(); ++k) out.col(k) = solve(right_hand_sides.col(k));
  return out;
}

namespace {

int compute_numerical_rank(const MatrixX& matrix) {
  if (matrix.size() == 0) return 0;
  const VectorX values = numerics::singular_values(matrix);
  int rank = 0;
  while (rank < values.size() && values[rank] > 1e-8 * values[0]) ++rank;
  return rank;
}

}  // namespace

int find_generic_constraint_rank(const NaturalModel& model, const NaturalCoordinates& position) {
  NaturalKinematicEquations constraints(model, {});
  NaturalCoordinates current = position;
  int rank = compute_numerical_rank(constraints.jacobian(current));
  std::mt19937 random(1);
  for (int k = 0; k < 4 && rank < model.unknowns() && constraints.rows() > 0; ++k) {
    VectorX step(model.unknowns());
    for (double& entry : step) entry = (static_cast<double>(random()) / 4294967296.0 - 0.5) * 0.2;
    NaturalCoordinates candidate = current;
    const numerics::CompleteOrthogonalDecomposition qr(constraints.jacobian(current));
    candidate.add(1, step - qr.solve(constraints.jacobian(current) * step));
    if (!constraints.solve_least_norm(candidate, VectorX())) continue;
    current = candidate;
    rank = std::max(rank, compute_numerical_rank(constraints.jacobian(current)));
  }
  return rank;
}

}  // namespace balance::verification::natural
