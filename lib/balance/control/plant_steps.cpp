/// The plant's integration: one step after another, each ending on the closures.

#include "balance/base/extrema.hpp"
#include "balance/control/plant_engine.hpp"
#include "balance/control/tree_state.hpp"
#include "balance/motion/regularity.hpp"
#include "balance/motion/wording.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double refactor_ratio = 0.3;  // part of its first regularity below which a choice of coordinates is made anew
constexpr double min_integration_step_fraction = 1e-9;  // of the longest one
constexpr double singular_closure_threshold =
    1e-3;                                // regularity of the closures that explains steps too short to go on
constexpr double overflow_limit = 1e60;  // of coordinates, rates, efforts and accelerations
constexpr double redundant_residual_tolerance =
    1e-9;  // residual of redundant rows that says that they are not redundant here

}  // namespace

template <class S>
void PlantOf<S>::pack_state() {
  const int n = loops_.columns();
  for (int c = 0; c < n; ++c) {
    x_[c] = y_[c] / loops_.scale()[c];
    x_[n + c] = dy_[c] / loops_.scale()[c];
  }
}

template <class S>
void PlantOf<S>::unpack_state(const std::vector<double>& x) {
  const int n = loops_.columns();
  for (int c = 0; c < n; ++c) {
    y_[c] = x[c] * loops_.scale()[c];
    dy_[c] = x[n + c] * loops_.scale()[c];
  }
}

/// All tree coordinates and rates are integrated, the dependent ones replaced by what the closures say at every evaluation: so
/// the error control watches them too, and Newton starts next to its solution.
template <class S>
void PlantOf<S>::derivative(const std::vector<double>& x, std::vector<double>& dxdt, double time) {
  unpack_state(x);
  ++cost_.evaluations;
  update_efforts(time);
  if (!loops_.solve_dependent(y_.data(), dy_.data())) throw StateRejected{};
  if (!loops_.accelerate(time, dy_.data(), efforts_.data(), ddy_.data())) throw StateRejected{};
  if (loops_.has_dry_friction() && time == time_) start_ddy_ = ddy_;
  const int n = loops_.columns();
  for (int c = 0; c < n; ++c) {
    dxdt[c] = dy_[c] / loops_.scale()[c];
    dxdt[n + c] = ddy_[c] / loops_.scale()[c];
  }
}

/// @param step as tried, on return what to try next
/// @param refused the step leads over a singularity or to no state at all
/// @return false if nothing has changed
template <class S>
bool PlantOf<S>::try_step(double& time, double& step, bool& refused, bool& fresh) {
  const double tried = step;
  const int doubts = suspect_steps_;
  last_x_ = x_;
  refused = false;
  try {
    const auto slope = [this](const std::vector<double>& x, std::vector<double>& dxdt, double t) {
      derivative(x, dxdt, t);
    };
    if (!integrator_.try_step(slope, x_, time, step)) return false;
    if (project_step(tried, fresh) && locate_event(tried, time)) {
      loops_.store();
      suspect_steps_ = 0;
      if (loops_.has_dry_friction()) start_ddy_ = ddy_;
      return true;
    }
    restore_step_start();
  } catch (const StateRejected&) {
  }
  const bool doubted = suspect_steps_ > doubts;
  refused = !doubted || doubts > 0;  // other independent coordinates may help where a shorter step does not
  step = tried / (doubted ? 2 : 4);
  return false;
}

/// After a step that cannot be kept.
template <class S>
void PlantOf<S>::restore_step_start() {
  x_ = last_x_;
  integrator_.restart();
  unpack_state(x_);
  if (loops_.solve_dependent(y_.data(), dy_.data())) loops_.store();
}

/// Steps to the end of a smooth piece.
template <class S>
MotionOutcome PlantOf<S>::integrate_to(double end) {
  bool fresh = false;  // the independent coordinates have just been chosen, at the state that the step starts from
  while (time_ < end) {
    if (cost_.steps + cost_.rejected >= options_.max_steps) return stop(MotionStatus::unreachable);
    const double whole = std::min(step_, options_.max_step), left = end - time_;
    const bool last = left <= whole * (1 + 1e-9);
    const double tried = last ? left : left >= 2 * whole ? whole : left / 2;  // no tiny step at the end
    double step = tried, time = time_;
    bool refused;
    if (try_step(time, step, refused, fresh)) {
      ++cost_.steps;
      time_ = last && !is_at_event_ ? end : time;
      step_ = tried < whole ? std::max(step_, step) : step;
      if (is_at_event_ && !handle_event()) return stop(MotionStatus::constraint_singularity);
      update_max_rate();
      if (loops_.reset_spherical_references(1, y_.data(), dy_.data())) {  // other coordinates, other rates
        fresh = choose_independent_columns();
        pack_state();
        last_x_ = x_;
        integrator_.restart();
        if (!fresh) return stop(MotionStatus::constraint_singularity);
      }
      if (reads_each_step_) update_coordinates();
      continue;
    }
    ++cost_.rejected;
    step_ = step;
    unpack_state(last_x_);
    if (refused && !fresh) {
      if (!choose_independent_columns()) return stop(MotionStatus::constraint_singularity);
      integrator_.restart();
      fresh = true;
      step_ = tried;
    } else if (step_ < std::max(min_integration_step_fraction * options_.max_step, 1e-14 * std::abs(time_))) {
      return stop(refused ? MotionStatus::constraint_singularity : MotionStatus::unreachable);
    }
  }
  return {MotionStatus::done, time_, "", {}};
}

/// After a step: the dependent coordinates as the closures have them; new independent ones where the present ones wear out.
template <class S>
bool PlantOf<S>::project_step(double step, bool& fresh) {
  unpack_state(x_);
  if (!loops_.solve_dependent(y_.data(), dy_.data())) return false;
  if (loops_.has_redundant_closures() && loops_.residual() > redundant_residual_tolerance) return false;
  if (can_have_crossed_singularity(step)) {
    ++suspect_steps_;
    return false;
  }
  fresh = loops_.regularity() < refactor_ratio * loops_.regularity_at_choice();
  if (fresh && !choose_independent_columns()) return false;
  pack_state();
  return true;
}

/// Could the closures, for the present choice of coordinates, have lost rank within a step that led to the state last closed?
template <class S>
bool PlantOf<S>::can_have_crossed_singularity(double step) {
  double way = 0;  // of any coordinate, by the rates at both ends too, for it may turn back in between
  const int n = loops_.columns();
  for (const int c : matrix_columns_) {
    const double rate = std::max(std::abs(dy_[c]) / loops_.scale()[c], std::abs(last_x_[n + c]));
    way = std::max(way, std::max(std::abs(y_[c] / loops_.scale()[c] - last_x_[c]), step * rate));
  }
  return !(way * way <= max_matrix_curvature * loops_.regularity()) || !loops_.near_kept(max_matrix_change);
}

template <class S>
bool PlantOf<S>::choose_independent_columns() {
  const bool good =
      loops_.choose_independent_columns(y_.data(), false) && loops_.solve_dependent(y_.data(), dy_.data());
  if (good) loops_.store();
  cost_.choices = loops_.choice_count();
  return good;
}

/// Whether what stopped the integration are numbers beyond bounds that no mechanism has.
template <class S>
bool PlantOf<S>::overflows() {
  const auto beyond = [](const VectorX& v, double bound) { return v.size() > 0 && !(max_abs(v) < bound); };
  if (beyond(efforts_, overflow_limit) || beyond(y_, overflow_limit) || beyond(dy_, overflow_limit)) return true;
  if (!loops_.solve_dependent(y_.data(), dy_.data())) return false;
  loops_.accelerate(time_, dy_.data(), efforts_.data(), ddy_.data());
  return beyond(ddy_, overflow_limit);
}

template <class S>
MotionOutcome PlantOf<S>::stop(MotionStatus status) {
  unpack_state(last_x_);
  update_coordinates();
  if (overflows()) return make_overflow_outcome(time_, "the motion under these efforts");
  if (status != MotionStatus::constraint_singularity &&
      (!choose_independent_columns() || loops_.closure_regularity() < singular_closure_threshold))
    status = MotionStatus::constraint_singularity;
  std::string what = "the integration needs steps that are too short to go on";
  const std::string flat = describe_flat_disc(mechanism_, {position_.begin(), position_.end()});
  if (status == MotionStatus::constraint_singularity) {
    what = "constraint singularity: the loop closures lose rank, the mechanism gains a freedom";
  } else if (cost_.steps + cost_.rejected >= options_.max_steps) {
    what = "the integration has taken the " + std::to_string(options_.max_steps) +
           " steps that it may take: the motion is faster than the run is long (stiff springs, hard control), or more "
           "steps must be allowed";
  }
  if (!flat.empty()) what += ": " + flat;
  return {status,
          time_,
          format_time_prefix(time_) + what + "; configuration: " + format_configuration(mechanism_, position_),
          {}};
}

#define BALANCE_INSTANTIATE(S)                                                                    \
  template void PlantOf<S>::pack_state();                                                         \
  template void PlantOf<S>::unpack_state(const std::vector<double>&);                             \
  template void PlantOf<S>::derivative(const std::vector<double>&, std::vector<double>&, double); \
  template bool PlantOf<S>::try_step(double&, double&, bool&, bool&);                             \
  template MotionOutcome PlantOf<S>::integrate_to(double);                                        \
  template bool PlantOf<S>::project_step(double, bool&);                                          \
  template bool PlantOf<S>::can_have_crossed_singularity(double);                                 \
  template void PlantOf<S>::restore_step_start();                                                 \
  template bool PlantOf<S>::choose_independent_columns();                                         \
  template bool PlantOf<S>::overflows();                                                          \
  template MotionOutcome PlantOf<S>::stop(MotionStatus);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
