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
double MotionStepper<S>::mobility() {
  if (direct_) return 1;
  return equations_.min_singular_value();
}

/// On from the last good moment, nearer to the singular configuration than results are wanted: to where steps fail for good, or to
/// the smallest pivot if it is only touched. Leaves the present moment there.
template <class S>
void MotionStepper<S>::locate_singularity(StepResult attempt, double smallest) {
  const bool hold = attempt == StepResult::actuation_singular;
  const double duration = plan_.prescribed_motion->duration();
  // Round-off moves a configuration by 1e-16 / pivot of what determines it, so that the pivot itself is no better known than this.
  pivot_threshold_ = hold ? 1e-11 : 2e-8;
  evaluations_left_ = max_evaluations / 10;
  const auto pivot = [&] { return hold ? guard_->factorise(equations_) : equations_.regularity(); };
  double size = smallest, least = INFINITY;
  CoordinateSample nearest = now_;
  while (now_.time < duration) {
    const double next = duration - now_.time < 1.5 * size ? duration : now_.time + size;
    if (step(next) == StepResult::done) {
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
void MotionStepper<S>::explain_stop(StepResult attempt, double smallest) {
  if (smallest > 0) locate_singularity(attempt, smallest);
  const PivotExtrapolation& approach = attempt == StepResult::actuation_singular ? actuation_extrapolation_ : approach_;
  const double time = std::min(approach.extrapolate_zero(now_.time), plan_.prescribed_motion->duration());
  compute_poses(tree_, now_.y.data(), state_);
  std::string links = describe_collinear_links(mechanism_, tree_, state_);
  if (has_velocity_closures_ && links.empty())
    links = describe_flat_disc(mechanism_, compute_coordinates(mechanism_, tree_, now_.y));
  const std::string where =
      format_configuration(mechanism_, tree_, now_.y.data()) + (links.empty() ? "" : ", where " + links);
  const auto [status, what] = diagnose(attempt);
  if (status == MotionStatus::actuation_singularity) {
    outcome_ = make_actuation_singularity_outcome(time, where);
    return;
  }
  outcome_.time = time;
  outcome_.status = status;
  outcome_.reason = format_time_prefix(time) + what + "; configuration: " + where;
}

template <class S>
std::pair<MotionStatus, const char*> MotionStepper<S>::diagnose(StepResult attempt) {
  ConstraintSystem<S> system(tree_, plan_.drive);
  MatrixX jacobian;
  plan_.prescribed_motion->at(std::min(now_.time, plan_.prescribed_motion->duration()), Side::after, sample_);
  system.velocity_jacobian(now_.y, sample_, jacobian);
  const int rank = tree_.columns - plan_.freedoms;
  const auto relative = [](const MatrixX& matrix, int k) {
    if (k == 0 || matrix.size() == 0) return 1.0;
    const VectorX values = singular_values(matrix);
    return values[0] > 0 ? values[k - 1] / values[0] : 0.0;
  };
  const double loops = relative(jacobian.topRows(tree_.closure_rows), rank);
  const double all = relative(jacobian, std::min<int>(tree_.columns, static_cast<int>(jacobian.rows())));
  // At distance ε from a singularity the values are of the order √ε; closures without rank do not hold either.
  const double lost = attempt == StepResult::actuation_singular ? 1e-5 : 0.02;
  if (loops < lost && loops < 10 * all)
    return {MotionStatus::constraint_singularity,
            "constraint singularity: the loop closures lose rank, the mechanism gains a freedom"};
  if (attempt == StepResult::actuation_singular) return {MotionStatus::actuation_singularity, ""};
  if (all < lost)
    return {MotionStatus::drive_singularity,
            "drive singularity: the prescribed quantities no longer determine the motion (the path may leave the "
            "workspace here)"};
  if (attempt == StepResult::no_convergence)
    return {MotionStatus::unreachable, "the prescribed values cannot be reached"};
  if (attempt == StepResult::evaluations_exhausted)
    return {MotionStatus::unreachable,
            "the way cannot be followed further: rates change so fast that steps become shorter without end"};
  return {MotionStatus::assembly_jump, "the motion could only go on by a jump to another assembly mode"};
}

#define BALANCE_INSTANTIATE(S)                                                              \
  template double MotionStepper<S>::mobility();                                             \
  template void MotionStepper<S>::locate_singularity(MotionStepper<S>::StepResult, double); \
  template void MotionStepper<S>::explain_stop(MotionStepper<S>::StepResult, double);       \
  template std::pair<MotionStatus, const char*> MotionStepper<S>::diagnose(MotionStepper<S>::StepResult);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
