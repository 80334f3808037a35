// Where a motion cannot go on: the place, and which matrix has become singular there.

#include "balance/base/factorizations.hpp"
#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/motion/configuration_text.hpp"
#include "balance/motion/links_in_line.hpp"
#include "balance/motion/stepper.hpp"
#include "balance/motion/wording.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

template <class S>
double Stepper<S>::mobility() {
  if (direct_) return 1;
  return equations_.least_singular_value();
}

/// On from the last good moment, nearer to the singular configuration than results are wanted: to where steps fail for good, or to
/// the smallest pivot if it is only touched. Leaves the present moment there.
template <class S>
void Stepper<S>::locate(Attempt attempt, double smallest) {
  const bool hold = attempt == Attempt::not_held;
  const double duration = plan_.schedule->duration();
  // Round-off moves a configuration by 1e-16 / pivot of what determines it, so that the pivot itself is no better known than this.
  floor_ = hold ? 1e-11 : 2e-8;
  evaluations_left_ = max_evaluations / 10;
  const auto pivot = [&] { return hold ? guard_->look(equations_) : equations_.regularity(); };
  double size = smallest, least = INFINITY;
  MotionMoment nearest = now_;
  while (now_.time < duration) {
    const double next = duration - now_.time < 1.5 * size ? duration : now_.time + size;
    if (step(next) == Attempt::done) {
      const double reached = pivot();
      if (reached > 2 * least) break;
      if (reached < least) least = reached, nearest = now_;
      size *= 2;
    } else if (evaluations_left_ < 0 || (size = std::min(size, next - now_.time) / 2) < smallest) {
      break;
    }
  }
  now_ = nearest;
}

/// What to tell the user, by which matrix has lost rank at the last good configuration.
/// @param smallest step that was tried [s]; 0 if there was none
template <class S>
void Stepper<S>::stop(Attempt attempt, double smallest) {
  if (smallest > 0) locate(attempt, smallest);
  const Approach& approach = attempt == Attempt::not_held ? hold_approach_ : approach_;
  const double time = std::min(approach.vanishes(now_.time), plan_.schedule->duration());
  poses(tree_, now_.y.data(), state_);
  std::string links = links_in_line(mechanism_, tree_, state_);
  if (rolls_ && links.empty()) links = flat_disc(mechanism_, read_coordinates(mechanism_, tree_, now_.y));
  const std::string where =
      configuration_text(mechanism_, tree_, now_.y.data()) + (links.empty() ? "" : ", where " + links);
  const auto [status, what] = diagnose(attempt);
  if (status == MotionStatus::actuation_singularity) {
    outcome_ = no_longer_held(time, where);
    return;
  }
  outcome_.time = time;
  outcome_.status = status;
  outcome_.reason = at_time(time) + what + "; configuration: " + where;
}

template <class S>
std::pair<MotionStatus, const char*> Stepper<S>::diagnose(Attempt attempt) {
  System<S> system(tree_, plan_.drive);
  MatrixX jacobian;
  plan_.schedule->at(std::min(now_.time, plan_.schedule->duration()), Side::after, sample_);
  system.rates(now_.y, sample_, jacobian);
  const int rank = tree_.columns - plan_.freedoms;
  const auto relative = [](const MatrixX& matrix, int k) {
    if (k == 0 || matrix.size() == 0) return 1.0;
    const VectorX values = singular_values(matrix);
    return values[0] > 0 ? values[k - 1] / values[0] : 0.0;
  };
  const double loops = relative(jacobian.topRows(tree_.closure_rows), rank);
  const double all = relative(jacobian, std::min<int>(tree_.columns, static_cast<int>(jacobian.rows())));
  // At distance ε from a singularity the values are of the order √ε; closures without rank do not hold either.
  const double lost = attempt == Attempt::not_held ? 1e-5 : 0.02;
  if (loops < lost && loops < 10 * all)
    return {MotionStatus::constraint_singularity,
            "constraint singularity: the loop closures lose rank, the mechanism gains a freedom"};
  if (attempt == Attempt::not_held) return {MotionStatus::actuation_singularity, ""};
  if (all < lost)
    return {MotionStatus::drive_singularity,
            "drive singularity: the prescribed quantities no longer determine the motion (the path may leave the "
            "workspace here)"};
  if (attempt == Attempt::no_convergence) return {MotionStatus::unreachable, "the prescribed values cannot be reached"};
  if (attempt == Attempt::exhausted)
    return {MotionStatus::unreachable,
            "the way cannot be followed further: rates change so fast that steps become shorter without end"};
  return {MotionStatus::assembly_jump, "the motion could only go on by a jump to another assembly mode"};
}

#define BALANCE_INSTANTIATE(S)                                   \
  template double Stepper<S>::mobility();                        \
  template void Stepper<S>::locate(Stepper<S>::Attempt, double); \
  template void Stepper<S>::stop(Stepper<S>::Attempt, double);   \
  template std::pair<MotionStatus, const char*> Stepper<S>::diagnose(Stepper<S>::Attempt);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
