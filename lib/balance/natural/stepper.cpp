#include "balance/natural/stepper.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/motion/regularity.hpp"
#include "balance/motion/wording.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::natural {

namespace {

constexpr double longest_correction = 0.1;  // of a prediction, in radians or characteristic lengths
constexpr int halvings = 24;
constexpr double singular = 1e-7;  // smallest pivot: half of the digits are lost

}  // namespace

Stepper::Stepper(const Model& model, DriveRows drive, const Schedule& schedule, int freedoms)
    : model_(model), schedule_(schedule), freedoms_(freedoms), equations_(model, std::move(drive)) {
  now_.position = model.start;
  now_.velocity = now_.acceleration = model.start;
  now_.velocity.set(VectorX::Zero(model.unknowns()));
  now_.acceleration.set(VectorX::Zero(model.unknowns()));
}

bool Stepper::begin(const Coordinates& near) {
  now_.time = 0;
  now_.position = near;
  schedule_.at(0, Side::after, sample_);
  if (!equations_.newton(now_.position, sample_.value) || !equations_.differentiate(now_, sample_)) {
    stop(Attempt::no_convergence);
    return false;
  }
  iterations_ = equations_.iterations();
  read_angles(model_.body_angles);
  all_.look(equations_.jacobian(now_.position));
  all_.keep();
  if (!held_) return true;
  const bool holds = actuation_.look(held_(now_.position)) >= singular;
  actuation_.keep();
  if (!holds) stop(Attempt::not_held);
  return holds;
}

double Stepper::spin(BodyId body) const {
  const BodyModel& b = model_.bodies[static_cast<std::size_t>(body)];
  if (b.angle >= 0) return now_.velocity.scalars[static_cast<std::size_t>(b.angle)];
  return cross(b.direction.at(now_.position), b.direction.rate(now_.velocity));
}

double Stepper::spin_rate(BodyId body) const {
  const BodyModel& b = model_.bodies[static_cast<std::size_t>(body)];
  if (b.angle >= 0) return now_.acceleration.scalars[static_cast<std::size_t>(b.angle)];
  return cross(b.direction.at(now_.position), b.direction.rate(now_.acceleration));
}

void Stepper::read_angles(const std::vector<double>& expected) {
  constexpr double turn = 2 * std::numbers::pi;
  angles_.resize(model_.bodies.size());
  for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
    const BodyModel& body = model_.bodies[b];
    if (body.angle >= 0) {
      angles_[b] = now_.position.scalars[static_cast<std::size_t>(body.angle)];
    } else {
      const double angle = std::arg(body.direction.at(now_.position));
      angles_[b] = angle + turn * std::round((expected[b] - angle) / turn);
    }
  }
}

bool Stepper::far_from(const Coordinates& predicted, const Coordinates& found) const {
  for (std::size_t k = 0; k < found.points.size(); ++k)
    if (std::abs(found.points[k] - predicted.points[k]) > longest_correction) return true;
  for (std::size_t s = 0; s < found.scalars.size(); ++s)
    if (std::abs(found.scalars[s] - predicted.scalars[s]) > longest_correction) return true;
  for (const BodyModel& body : model_.bodies)
    if (std::abs(body.direction.at(found) - body.direction.at(predicted)) > longest_correction) return true;
  return false;
}

Stepper::Attempt Stepper::step(double time) {
  const double h = time - now_.time;
  schedule_.at(time, Side::after, sample_);
  State next = now_;
  next.time = time;
  for (std::size_t k = 0; k < next.position.points.size(); ++k)
    next.position.points[k] += h * now_.velocity.points[k] + h * h / 2 * now_.acceleration.points[k];
  for (std::size_t s = 0; s < next.position.scalars.size(); ++s)
    next.position.scalars[s] += h * now_.velocity.scalars[s] + h * h / 2 * now_.acceleration.scalars[s];
  const Coordinates predicted = next.position;
  if (!equations_.newton(next.position, sample_.value)) return Attempt::no_convergence;
  iterations_ += equations_.iterations();
  if (far_from(predicted, next.position)) return Attempt::far;
  if (!equations_.differentiate(next, sample_)) return Attempt::no_convergence;
  const Attempt attempt = judge(next);
  if (attempt != Attempt::done) return attempt;
  std::vector<double> expected(model_.bodies.size());
  for (std::size_t b = 0; b < expected.size(); ++b)
    expected[b] = angles_[b] + h * spin(static_cast<int>(b)) + h * h / 2 * spin_rate(static_cast<int>(b));
  now_ = std::move(next);
  all_.keep();
  actuation_.keep();
  read_angles(expected);
  return Attempt::done;
}

/// Largest change of an entry off the straight way: entries are linear in the points, or in directions that turn with them.
double Stepper::curvature(const State& next) const {
  double most = 0;
  for (const State* state : {&now_, &next}) {
    for (const Complex p : state->acceleration.points) most = std::max(most, std::abs(p));
    for (const BodyModel& body : model_.bodies)
      most = std::max(most, std::abs(body.direction.rate(state->acceleration)));
  }
  const double h = next.time - now_.time;
  return h * h / 4 * most;
}

/// Could one of the matrices have lost rank since the present state?
Stepper::Attempt Stepper::judge(const State& next) {
  const double off = curvature(next), pivot = all_.look(equations_.jacobian(next.position));
  if (!(pivot >= singular && off <= most_curvature * pivot && all_.near_kept(most_change))) return Attempt::singular;
  if (held_) {
    const double actuation = actuation_.look(held_(next.position));
    if (!(actuation >= singular && off <= most_curvature * actuation && actuation_.near_kept(most_change)))
      return Attempt::not_held;
    actuation_approach_.see(actuation, next.time);
  }
  approach_.see(pivot, next.time);
  return Attempt::done;
}

bool Stepper::advance(double time) {
  iterations_ = 0;
  double size = time - now_.time;
  const double smallest = std::ldexp(size, -halvings);
  while (now_.time < time) {
    // the last piece ends exactly where it should
    double next = time - now_.time < 1.5 * size ? time : now_.time + size;
    const double longest = schedule_.longest_step(now_.time);
    if (next - now_.time > (1 + 1e-6) * longest) next = now_.time + longest;
    const Attempt attempt = step(next);
    if (attempt == Attempt::done) {
      size *= 2;
    } else if ((size = std::min(size, next - now_.time) / 2) < smallest) {
      stop(attempt);
      return false;
    }
  }
  return true;
}

void Stepper::accelerate(Side side) {
  schedule_.at(now_.time, side, sample_);
  equations_.accelerate(now_, sample_);
}

/// Which matrix has lost rank at the last good configuration?
void Stepper::stop(Attempt attempt) {
  const Approach& approach = attempt == Attempt::not_held ? actuation_approach_ : approach_;
  const double time = std::min(approach.vanishes(now_.time), schedule_.duration());
  if (attempt == Attempt::not_held) {
    outcome_ = no_longer_held(time, "");
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
  constexpr double lost = 0.02;  // at distance ε from a singularity the values are of the order √ε
  const char* what;
  if (loops < lost && loops < 10 * all) {
    outcome_.status = MotionStatus::constraint_singularity;
    what = "constraint singularity: the constraints lose rank, the mechanism gains a freedom";
  } else if (all < lost) {
    outcome_.status = MotionStatus::drive_singularity;
    what =
        "drive singularity: the prescribed quantities no longer determine the motion (the path may leave the workspace "
        "here)";
  } else if (attempt == Attempt::no_convergence) {
    outcome_.status = MotionStatus::unreachable;
    what = "the prescribed values cannot be reached";
  } else {
    outcome_.status = MotionStatus::assembly_jump;
    what = "the motion could only go on by a jump to another assembly mode";
  }
  outcome_.time = time;
  outcome_.reason = at_time(time) + what;
}

}  // namespace balance::natural
