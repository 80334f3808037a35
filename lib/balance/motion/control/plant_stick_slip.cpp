/// Dry friction of the plant: finds the times at which joints come to rest, stick, reverse or break loose. Between them
/// the motion is smooth.

#include "balance/motion/control/plant_impl.hpp"

#include <algorithm>
#include <cmath>

namespace balance::control {

namespace {

constexpr double rest_rate_fraction = 1e-10;    // fraction of the largest rate so far below which a joint may stick
constexpr double event_time_epsilon = 4e-16;    // of an event time, as a fraction of the time or the step
constexpr double event_margin_epsilon = 1e-13;  // a smaller excess counts as none
constexpr int max_event_iterations = 80;
constexpr int max_stalled_events = 30;  // without progress, before a step ignores them

}  // namespace

template <class S>
void PlantOf<S>::update_max_rate() {
  if (!loops_.has_dry_friction()) return;
  for (int c = 0; c < loops_.columns(); ++c) max_rate_ = std::max(max_rate_, std::abs(dy_[c]) / loops_.scale()[c]);
}

/// Determines which joints stick under these efforts at the current state. Sticking joints hold columns of the tree.
/// @return false at a singularity of the closures
template <class S>
bool PlantOf<S>::update_friction(const VectorX& efforts) {
  if (!loops_.has_dry_friction()) return true;
  if (!loops_.solve_dependent(time_, y_.data(), dy_.data())) return false;
  const dynamics::FrictionChange change =
      loops_.decide_friction(time_, dy_.data(), efforts.data(), rest_rate_fraction * max_rate_);
  if (change != dynamics::FrictionChange::none) integrator_.restart();
  if (change != dynamics::FrictionChange::sticking_set) return true;
  step_start_x_ = x_;
  const bool is_regular = choose_independent_columns(time_);
  pack_state();
  if (loops_.has_shared_stiction() && !has_noted_shared_stiction_) {
    has_noted_shared_stiction_ = true;
    notes_.push_back(
        "dry friction: joints at rest share the load; their friction is one of many solutions that hold the mechanism");
  }
  return is_regular;
}

template <class S>
double PlantOf<S>::friction_margin(double time) {
  ++cost_.evaluations;
  update_efforts(time);
  return loops_.friction_margin(time, dy_.data(), efforts_.data(), max_rate_);
}

/// Integrates for the time `step` from the start of the step; x_ is then the state there. The integrator starts anew.
template <class S>
bool PlantOf<S>::step_without_error_control(double step) {
  x_ = step_start_x_;
  const auto right_hand_side = [this](const std::vector<double>& x, std::vector<double>& dxdt, double t) {
    derivative(x, dxdt, t);
  };
  integrator_.step_without_error_control(right_hand_side, x_, time_, step);
  unpack_state(x_);
  return loops_.solve_dependent(time_ + step, y_.data(), dy_.data());
}

/// Fraction of a step from step_start_x_ at which a slipping joint may have stopped although it moves at the end: the
/// minimum of its rate, by the cubic through the rates and accelerations at both ends, if that is below zero. 0 if
/// there is none.
template <class S>
double PlantOf<S>::find_rate_minimum(double step) const {
  double first = 0;
  for (const dynamics::JointFriction& joint : loops_.frictions()) {
    if (!joint.has_dry_friction() || joint.is_sticking) continue;
    const double unit = joint.slip_direction * joint.ratio();
    const double begin_rate = unit * step_start_x_[loops_.columns() + joint.column()] * loops_.scale()[joint.column()],
                 rate_change = unit * dy_[joint.column()] - begin_rate;
    const double initial_slope = unit * step * start_ddy_[joint.column()],
                 final_slope = unit * step * ddy_[joint.column()];
    if (!(initial_slope < 0 && final_slope > 0)) continue;
    // begin_rate + initial_slope p + quadratic p² + cubic p³
    const double quadratic = 3 * rate_change - 2 * initial_slope - final_slope,
                 cubic = initial_slope + final_slope - 2 * rate_change;
    const double fraction =
        -initial_slope / (quadratic + std::sqrt(std::max(0.0, quadratic * quadratic - 3 * initial_slope * cubic)));
    if (!(fraction > 0 && fraction < 1) ||
        begin_rate + fraction * (initial_slope + fraction * (quadratic + fraction * cubic)) >= 0)
      continue;
    first = first > 0 ? std::min(first, fraction) : fraction;
  }
  return first;
}

/// Whether an accepted step contains an event.
/// @param high on return, a time within the step by which the event has occurred
/// @param margin on return, the margin there; non-negative if there is no event
/// @return false if the integration to there fails
template <class S>
bool PlantOf<S>::has_event_within(double step, double& high, double& margin) {
  high = step;
  margin = friction_margin(time_ + step);
  if (margin < 0) return true;
  const double fraction = find_rate_minimum(step);
  if (fraction == 0) return true;
  const std::vector<double> end = x_;
  const VectorX end_ddy = ddy_;
  high = fraction * step;
  if (!step_without_error_control(high)) return false;
  margin = friction_margin(time_ + high);
  if (margin < 0) {
    pack_state();
    return true;
  }
  x_ = end;
  ddy_ = end_ddy;
  unpack_state(x_);
  return loops_.solve_dependent(time_ + step, y_.data(), dy_.data());
}

/// After an accepted step from step_start_x_ to x_: returns to the first event in it, if there is one.
/// @param step length of the step
/// @param time its end; on return, the time of the event
/// @return false if the integration to the event fails
template <class S>
bool PlantOf<S>::locate_event(double step, double& time) {
  is_at_event_ = false;
  if (!loops_.has_dry_friction() || is_ignoring_events_) {
    is_ignoring_events_ = false;
    return true;
  }
  double low = 0, high, upper_margin;
  if (!has_event_within(step, high, upper_margin)) return false;
  if (upper_margin >= 0) return true;
  is_at_event_ = true;
  std::vector<double> event_state = x_;
  unpack_state(step_start_x_);
  if (!loops_.solve_dependent(time_, y_.data(), dy_.data())) return false;
  double lower_margin = std::max(friction_margin(time_), event_margin_epsilon), last_margin = upper_margin;
  bool has_moved_high = false, has_moved_low = false;  // the end that the last iteration moved
  for (int iteration = 0; iteration < max_event_iterations; ++iteration) {
    if (high - low <= event_time_epsilon * std::max(std::abs(time_), step) || last_margin > -event_margin_epsilon)
      break;
    // false position (Illinois), with occasional bisection
    double trial_step =
        iteration % 4 == 3 ? (low + high) / 2 : low + (high - low) * lower_margin / (lower_margin - upper_margin);
    if (!(trial_step > low && trial_step < high)) trial_step = (low + high) / 2;
    if (!(trial_step > low && trial_step < high)) break;
    if (!step_without_error_control(trial_step)) return false;
    const double margin = friction_margin(time_ + trial_step);
    if (margin < 0) {
      high = trial_step, upper_margin = last_margin = margin;
      if (has_moved_high) lower_margin /= 2;
      pack_state();
      event_state = x_;
    } else {
      low = trial_step, lower_margin = std::max(margin, event_margin_epsilon);
      if (has_moved_low) upper_margin /= 2;
    }
    has_moved_high = margin < 0, has_moved_low = !has_moved_high;
  }
  x_ = event_state;
  unpack_state(x_);
  time = time_ + high;
  if (!loops_.solve_dependent(time, y_.data(), dy_.data())) return false;
  pack_state();
  return true;
}

/// Determines what sticks and slips from here on.
template <class S>
bool PlantOf<S>::handle_event() {
  ++cost_.events;
  integrator_.restart();
  const bool has_progressed = time_ - event_time_ > 1e-12 * std::max(std::abs(time_), options_.max_step);
  event_time_ = time_;
  stalled_events_ = has_progressed ? 0 : stalled_events_ + 1;
  if (stalled_events_ == max_stalled_events) {
    is_ignoring_events_ = true;
    stalled_events_ = 0;
    step_ = std::max(step_, 1e-6 * options_.max_step);
    const std::string note = "dry friction: sticking and slipping alternate endlessly somewhere; steps of " +
                             std::to_string(1e6 * step_) + " us pass through it";
    if (std::find(notes_.begin(), notes_.end(), note) == notes_.end() && notes_.size() < 20) notes_.push_back(note);
  }
  update_efforts(time_);
  const bool is_regular = update_friction(efforts_);
  pack_state();
  step_start_x_ = x_;
  return is_regular;
}

#define BALANCE_INSTANTIATE(S)                                          \
  template void PlantOf<S>::update_max_rate();                          \
  template bool PlantOf<S>::update_friction(const VectorX&);            \
  template double PlantOf<S>::friction_margin(double);                  \
  template bool PlantOf<S>::step_without_error_control(double);         \
  template double PlantOf<S>::find_rate_minimum(double) const;          \
  template bool PlantOf<S>::has_event_within(double, double&, double&); \
  template bool PlantOf<S>::locate_event(double, double&);              \
  template bool PlantOf<S>::handle_event();
BALANCE_INSTANTIATE(kinematics::Planar)
BALANCE_INSTANTIATE(kinematics::Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance::control
