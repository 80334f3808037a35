#include "balance/natural/stepper.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/motion/regularity.hpp"
#include "balance/motion/wording.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace balance::natural
