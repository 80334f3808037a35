#include "balance/synthesis/verification/natural_equations.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/regularity.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace balance::natural {

namespace {

constexpr double max_correction = 0.1;  // of a prediction, in radians or characteristic lengths
constexpr int max_step_halvings = 24;
constexpr double singular = 1e-7;  // smallest pivot: half of the digits are lost

}  // namespace

NaturalStepper::NaturalStepper(const NaturalModel& model, DriveRows drive, const PrescribedMotion& schedule,
                               int freedoms)
    : model_(model), schedule_(schedule), freedoms_(freedoms), equations_(model, std::move(drive)) {
  now_.position = model.start;
  now_.velocity = now_.acceleration = model.start;
  now_.velocity.set(VectorX::Zero(model.unknowns()));
  now_.acceleration.set(VectorX::Zero(model.unknowns()));
}

bool NaturalStepper::begin(const NaturalCoordinates& near) {
  now_.time = 0;
  now_.position = near;
  schedule_.at(0, Side::after, sample_);
  if (!equations_.newton(now_.position, sample_.value) || !equations_.differentiate(now_, sample_)) {
    stop(StepResult::no_convergence);
    return false;
  }
  iterations_ = equations_.iterations();
  read_angles(model_.body_angles);
  constraint_monitor_.factorise(equations_.jacobian(now_.position));
  constraint_monitor_.store();
  if (!actuation_matrix_) return true;
  const bool holds = actuation_.factorise(actuation_matrix_(now_.position)) >= singular;
  actuation_.store();
  if (!holds) stop(StepResult::actuation_singular);
  return holds;
}

double NaturalStepper::angular_velocity(BodyId body) const {
  const BodyModel& b = model_.bodies[static_cast<std::size_t>(body)];
  if (b.angle >= 0) return now_.velocity.scalars[static_cast<std::size_t>(b.angle)];
  return cross(b.direction.at(now_.position), b.direction.rate(now_.velocity));
}

double NaturalStepper::angular_acceleration(BodyId body) const {
  const BodyModel& b = model_.bodies[static_cast<std::size_t>(body)];
  if (b.angle >= 0) return now_.acceleration.scalars[static_cast<std::size_t>(b.angle)];
  return cross(b.direction.at(now_.position), b.direction.rate(now_.acceleration));
}

void NaturalStepper::read_angles(const std::vector<double>& expected) {
  constexpr double two_pi = 2 * std::numbers::pi;
  angles_.resize(model_.bodies.size());
  for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
    const BodyModel& body = model_.bodies[b];
    if (body.angle >= 0) {
      angles_[b] = now_.position.scalars[static_cast<std::size_t>(body.angle)];
    } else {
      const double angle = std::arg(body.direction.at(now_.position));
      angles_[b] = angle + two_pi * std::round((expected[b] - angle) / two_pi);
    }
  }
}

bool NaturalStepper::is_far_from_prediction(const NaturalCoordinates& predicted,
                                            const NaturalCoordinates& found) const {
  for (std::size_t k = 0; k < found.points.size(); ++k)
    if (std::abs(found.points[k] - predicted.points[k]) > max_correction) return true;
  for (std::size_t s = 0; s < found.scalars.size(); ++s)
    if (std::abs(found.scalars[s] - predicted.scalars[s]) > max_correction) return true;
  for (const BodyModel& body : model_.bodies)
    if (std::abs(body.direction.at(found) - body.direction.at(predicted)) > max_correction) return true;
  return false;
}

NaturalStepper::StepResult NaturalStepper::step(double time) {
  const double h = time - now_.time;
  schedule_.at(time, Side::after, sample_);
  NaturalState next = now_;
  next.time = time;
  for (std::size_t k = 0; k < next.position.points.size(); ++k)
    next.position.points[k] += h * now_.velocity.points[k] + h * h / 2 * now_.acceleration.points[k];
  for (std::size_t s = 0; s < next.position.scalars.size(); ++s)
    next.position.scalars[s] += h * now_.velocity.scalars[s] + h * h / 2 * now_.acceleration.scalars[s];
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
  now_ = std::move(next);
  constraint_monitor_.store();
  actuation_.store();
  read_angles(expected);
  return StepResult::done;
}

/// Largest change of an entry off the straight way: entries are linear in the points, or in directions that turn with them.
double NaturalStepper::curvature(const NaturalState& next) const {
  double most = 0;
  for (const NaturalState* state : {&now_, &next}) {
    for (const Complex p : state->acceleration.points) most = std::max(most, std::abs(p));
    for (const BodyModel& body : model_.bodies)
      most = std::max(most, std::abs(body.direction.rate(state->acceleration)));
  }
  const double h = next.time - now_.time;
  return h * h / 4 * most;
}

/// Could one of the matrices have lost rank since the present state?
NaturalStepper::StepResult NaturalStepper::check_step(const NaturalState& next) {
  const double off = curvature(next), pivot = constraint_monitor_.factorise(equations_.jacobian(next.position));
  if (!(pivot >= singular && off <= max_matrix_curvature * pivot &&
        constraint_monitor_.is_near_stored(max_matrix_change)))
    return StepResult::natural_pivot_threshold;
  if (actuation_matrix_) {
    const double actuation = actuation_.factorise(actuation_matrix_(next.position));
    if (!(actuation >= singular && off <= max_matrix_curvature * actuation &&
          actuation_.is_near_stored(max_matrix_change)))
      return StepResult::actuation_singular;
    actuation_approach_.add_sample(actuation, next.time);
  }
  approach_.add_sample(pivot, next.time);
  return StepResult::done;
}

bool NaturalStepper::advance(double time) {
  iterations_ = 0;
  double size = time - now_.time;
  const double smallest = std::ldexp(size, -max_step_halvings);
  while (now_.time < time) {
    // the last piece ends exactly where it should
    double next = time - now_.time < 1.5 * size ? time : now_.time + size;
    const double longest = schedule_.max_step(now_.time);
    if (next - now_.time > (1 + 1e-6) * longest) next = now_.time + longest;
    const StepResult attempt = step(next);
    if (attempt == StepResult::done) {
      size *= 2;
    } else if ((size = std::min(size, next - now_.time) / 2) < smallest) {
      stop(attempt);
      return false;
    }
  }
  return true;
}

void NaturalStepper::accelerate(Side side) {
  schedule_.at(now_.time, side, sample_);
  equations_.accelerate(now_, sample_);
}

/// Which matrix has lost rank at the last good configuration?
void NaturalStepper::stop(StepResult attempt) {
  const PivotExtrapolation& approach = attempt == StepResult::actuation_singular ? actuation_approach_ : approach_;
  const double time = std::min(approach.extrapolate_zero(now_.time), schedule_.duration());
  if (attempt == StepResult::actuation_singular) {
    outcome_ = make_actuation_singularity_outcome(time, "");
    return;
  }
  const int rank = model_.unknowns() - freedoms_;
  const auto relative = [](const MatrixX& matrix, int k) {
    if (k <= 0 || matrix.rows() < k) return 1.0;
    const VectorX values = singular_values(matrix);
    return values[0] > 0 ? values[k - 1] / values[0] : 0.0;
  };
  const double loops = relative(equations_.constraint_jacobian(now_.position), rank);
  const double all = relative(equations_.jacobian(now_.position), model_.unknowns());
  constexpr double rank_loss_threshold = 0.02;  // at distance ε from a singularity the values are of the order √ε
  const char* what;
  if (loops < rank_loss_threshold && loops < 10 * all) {
    outcome_.status = MotionStatus::constraint_singularity;
    what = "constraint singularity: the constraints lose rank, the mechanism gains a freedom";
  } else if (all < rank_loss_threshold) {
    outcome_.status = MotionStatus::drive_singularity;
    what =
        "drive singularity: the prescribed quantities no longer determine the motion (the path may leave the workspace "
        "here)";
  } else if (attempt == StepResult::no_convergence) {
    outcome_.status = MotionStatus::unreachable;
    what = "the prescribed values cannot be reached";
  } else {
    outcome_.status = MotionStatus::assembly_jump;
    what = "the motion could only go on by a jump to another assembly mode";
  }
  outcome_.time = time;
  outcome_.reason = format_time_prefix(time) + what;
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

DriveRows make_drive_rows(const Mechanism& mechanism, const NaturalModel& model, const DriveQuantities& quantities) {
  DriveRows drive;
  const auto add_components = [&](const std::vector<int>& components, const AffineForm& place) {
    for (const int k : components) {
      drive.rows.push_back({.left = make_constant_form(k == 0 ? Complex(1) : imaginary), .right = place});
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

/// Farthest fixed point in characteristic lengths: what round-off is proportional to.
double compute_ground_extent(const NaturalModel& model) {
  double largest = 1;
  for (const Complex p : model.basic.fixed) largest = std::max(largest, std::abs(p));
  return largest;
}

}  // namespace

NaturalKinematicEquations::NaturalKinematicEquations(const NaturalModel& model, DriveRows drive)
    : model_(model), drive_(std::move(drive)), round_off_(natural_residual_tolerance * compute_ground_extent(model)) {
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

VectorX NaturalKinematicEquations::solve(const VectorX& right) const {
  if (square_) return lu_.solve(right);
  return qr_.solve(right);
}

bool NaturalKinematicEquations::newton(NaturalCoordinates& position, const VectorX& prescribed) {
  double last = INFINITY;
  for (iterations_ = 0; iterations_ <= max_newton_iterations; ++iterations_) {
    const VectorX off = residual(position, prescribed);
    const double worst = off.size() > 0 ? off.lpNorm<Eigen::Infinity>() : 0;
    if (!std::isfinite(worst) || !factorise(position)) return false;
    position.add(-1, solve(off));
    // either small, or as small as round-off allows
    if (worst <= round_off_ || (worst <= 10 * round_off_ && worst >= last)) return true;
    last = worst;
  }
  return false;
}

bool NaturalKinematicEquations::solve_least_norm(NaturalCoordinates& position, const VectorX& prescribed) const {
  for (int k = 0; k < 30; ++k) {
    const VectorX off = residual(position, prescribed);
    const double worst = off.size() > 0 ? off.lpNorm<Eigen::Infinity>() : 0;
    if (!std::isfinite(worst)) return false;
    CompleteOrthogonalDecomposition qr;
    qr.setThreshold(1e-9);
    qr.compute(jacobian(position));
    const VectorX step = qr.solve(off);
    if (!step.allFinite()) return false;
    const double longest = step.size() > 0 ? step.lpNorm<Eigen::Infinity>() : 0;
    position.add(longest > 1 ? -1 / longest : -1, step);
    if (worst <= 10 * round_off_) return true;
  }
  return false;
}

bool NaturalKinematicEquations::differentiate(NaturalState& state, const DriveSample& sample) {
  if (!factorise(state.position)) return false;
  VectorX right = VectorX::Zero(rows());
  for (int k = 0; k < drive_row_count(); ++k)
    right[constraint_count() + k] = sample.rate[k] / drive_.unit[static_cast<std::size_t>(k)];
  state.velocity.set(solve(right));
  accelerate(state, sample);
  return true;
}

void NaturalKinematicEquations::accelerate(NaturalState& state, const DriveSample& sample) const {
  VectorX right(rows());
  for (int r = 0; r < constraint_count(); ++r)
    right[r] = -model_.constraints[static_cast<std::size_t>(r)].bias(state.position, state.velocity);
  for (int k = 0; k < drive_row_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    right[constraint_count() + k] =
        sample.acceleration[k] / drive_.unit[i] - drive_.rows[i].bias(state.position, state.velocity);
  }
  state.acceleration.set(solve(right));
}

MatrixX NaturalKinematicEquations::allowed_velocities() const {
  MatrixX right = MatrixX::Zero(rows(), drive_row_count());
  right.bottomRows(drive_row_count()).setIdentity();
  MatrixX out(unknown_count(), drive_row_count());
  for (int k = 0; k < drive_row_count(); ++k) out.col(k) = solve(right.col(k));
  return out;
}

namespace {

int compute_numerical_rank(const MatrixX& matrix) {
  if (matrix.size() == 0) return 0;
  const VectorX values = singular_values(matrix);
  int rank = 0;
  while (rank < values.size() && values[rank] > 1e-8 * values[0]) ++rank;
  return rank;
}

}  // namespace

int find_generic_constraint_rank(const NaturalModel& model, const NaturalCoordinates& position) {
  NaturalKinematicEquations constraints(model, {});
  NaturalCoordinates here = position;
  int best = compute_numerical_rank(constraints.jacobian(here));
  std::mt19937 random(1);
  for (int k = 0; k < 4 && best < model.unknowns() && constraints.rows() > 0; ++k) {
    VectorX step(model.unknowns());
    for (double& entry : step) entry = (static_cast<double>(random()) / 4294967296.0 - 0.5) * 0.2;
    NaturalCoordinates there = here;
    const CompleteOrthogonalDecomposition qr(constraints.jacobian(here));
    there.add(1, step - qr.solve(constraints.jacobian(here) * step));
    if (!constraints.solve_least_norm(there, VectorX())) continue;
    here = there;
    best = std::max(best, compute_numerical_rank(constraints.jacobian(here)));
  }
  return best;
}

}  // namespace balance::natural
