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

constexpr double worn = 0.3;            // part of its first regularity below which a choice of coordinates is made anew
constexpr double smallest_step = 1e-9;  // of the longest one
constexpr double singular = 1e-3;       // regularity of the closures that explains steps too short to go on
constexpr double enormous = 1e60;       // of coordinates, rates, efforts and accelerations
constexpr double open = 1e-9;           // residual of redundant rows that says that they are not redundant here

}  // namespace

template <class S>
void EngineOf<S>::store() {
  const int n = loops_.columns();
  for (int c = 0; c < n; ++c) {
    x_[c] = y_[c] / loops_.scale()[c];
    x_[n + c] = dy_[c] / loops_.scale()[c];
  }
}

template <class S>
void EngineOf<S>::load(const std::vector<double>& x) {
  const int n = loops_.columns();
  for (int c = 0; c < n; ++c) {
    y_[c] = x[c] * loops_.scale()[c];
    dy_[c] = x[n + c] * loops_.scale()[c];
  }
}

/// All tree coordinates and rates are integrated, the dependent ones replaced by what the closures say at every evaluation: so
/// the error control watches them too, and Newton starts next to its solution.
template <class S>
void EngineOf<S>::derivative(const std::vector<double>& x, std::vector<double>& dxdt, double time) {
  load(x);
  ++cost_.evaluations;
  push(time);
  if (!loops_.close(y_.data(), dy_.data())) throw Refused{};
  if (!loops_.accelerate(time, dy_.data(), efforts_.data(), ddy_.data())) throw Refused{};
  if (loops_.dry() && time == time_) start_ddy_ = ddy_;
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
bool EngineOf<S>::try_step(double& time, double& step, bool& refused, bool& fresh) {
  const double tried = step;
  const int doubts = doubts_;
  last_x_ = x_;
  refused = false;
  try {
    const auto slope = [this](const std::vector<double>& x, std::vector<double>& dxdt, double t) {
      derivative(x, dxdt, t);
    };
    if (!integrator_.try_step(slope, x_, time, step)) return false;
    if (settle(tried, fresh) && find_event(tried, time)) {
      loops_.keep();
      doubts_ = 0;
      if (loops_.dry()) start_ddy_ = ddy_;
      return true;
    }
    back_to_start();
  } catch (const Refused&) {
  }
  const bool doubted = doubts_ > doubts;
  refused = !doubted || doubts > 0;  // other independent coordinates may help where a shorter step does not
  step = tried / (doubted ? 2 : 4);
  return false;
}

/// After a step that cannot be kept.
template <class S>
void EngineOf<S>::back_to_start() {
  x_ = last_x_;
  integrator_.restart();
  load(x_);
  if (loops_.close(y_.data(), dy_.data())) loops_.keep();
}

/// Steps to the end of a smooth piece.
template <class S>
MotionOutcome EngineOf<S>::go(double end) {
  bool fresh = false;  // the independent coordinates have just been chosen, at the state that the step starts from
  while (time_ < end) {
    if (cost_.steps + cost_.rejected >= options_.most_steps) return stop(MotionStatus::unreachable);
    const double whole = std::min(step_, options_.longest_step), left = end - time_;
    const bool last = left <= whole * (1 + 1e-9);
    const double tried = last ? left : left >= 2 * whole ? whole : left / 2;  // no tiny step at the end
    double step = tried, time = time_;
    bool refused;
    if (try_step(time, step, refused, fresh)) {
      ++cost_.steps;
      time_ = last && !event_ ? end : time;
      step_ = tried < whole ? std::max(step_, step) : step;
      if (event_ && !pass_event()) return stop(MotionStatus::constraint_singularity);
      grow_fastest();
      if (loops_.rereference_spherical_joints(1, y_.data(), dy_.data())) {  // other coordinates, other rates
        fresh = choose_anew();
        store();
        last_x_ = x_;
        integrator_.restart();
        if (!fresh) return stop(MotionStatus::constraint_singularity);
      }
      if (reads_each_step_) follow();
      continue;
    }
    ++cost_.rejected;
    step_ = step;
    load(last_x_);
    if (refused && !fresh) {
      if (!choose_anew()) return stop(MotionStatus::constraint_singularity);
      integrator_.restart();
      fresh = true;
      step_ = tried;
    } else if (step_ < std::max(smallest_step * options_.longest_step, 1e-14 * std::abs(time_))) {
      return stop(refused ? MotionStatus::constraint_singularity : MotionStatus::unreachable);
    }
  }
  return {MotionStatus::done, time_, "", {}};
}

/// After a step: the dependent coordinates as the closures have them; new independent ones where the present ones wear out.
template <class S>
bool EngineOf<S>::settle(double step, bool& fresh) {
  load(x_);
  if (!loops_.close(y_.data(), dy_.data())) return false;
  if (loops_.redundant() && loops_.residual() > open) return false;
  if (may_have_been_singular(step)) {
    ++doubts_;
    return false;
  }
  fresh = loops_.regularity() < worn * loops_.regularity_at_choice();
  if (fresh && !choose_anew()) return false;
  store();
  return true;
}

/// Could the closures, for the present choice of coordinates, have lost rank within a step that led to the state last closed?
template <class S>
bool EngineOf<S>::may_have_been_singular(double step) {
  double way = 0;  // of any coordinate, by the rates at both ends too, for it may turn back in between
  const int n = loops_.columns();
  for (const int c : matrix_columns_) {
    const double rate = std::max(std::abs(dy_[c]) / loops_.scale()[c], std::abs(last_x_[n + c]));
    way = std::max(way, std::max(std::abs(y_[c] / loops_.scale()[c] - last_x_[c]), step * rate));
  }
  return !(way * way <= most_curvature * loops_.regularity()) || !loops_.near_kept(most_change);
}

template <class S>
bool EngineOf<S>::choose_anew() {
  const bool good = loops_.choose(y_.data(), false) && loops_.close(y_.data(), dy_.data());
  if (good) loops_.keep();
  cost_.choices = loops_.choices();
  return good;
}

/// Whether what stopped the integration are numbers beyond bounds that no mechanism has.
template <class S>
bool EngineOf<S>::overflows() {
  const auto beyond = [](const VectorX& v, double bound) { return v.size() > 0 && !(max_abs(v) < bound); };
  if (beyond(efforts_, enormous) || beyond(y_, enormous) || beyond(dy_, enormous)) return true;
  if (!loops_.close(y_.data(), dy_.data())) return false;
  loops_.accelerate(time_, dy_.data(), efforts_.data(), ddy_.data());
  return beyond(ddy_, enormous);
}

template <class S>
MotionOutcome EngineOf<S>::stop(MotionStatus status) {
  load(last_x_);
  follow();
  if (overflows()) return numbers_overflow(time_, "the motion under these efforts");
  if (status != MotionStatus::constraint_singularity && (!choose_anew() || loops_.closure_regularity() < singular))
    status = MotionStatus::constraint_singularity;
  std::string what = "the integration needs steps that are too short to go on";
  const std::string flat = flat_disc(mechanism_, {position_.begin(), position_.end()});
  if (status == MotionStatus::constraint_singularity) {
    what = "constraint singularity: the loop closures lose rank, the mechanism gains a freedom";
  } else if (cost_.steps + cost_.rejected >= options_.most_steps) {
    what = "the integration has taken the " + std::to_string(options_.most_steps) +
           " steps that it may take: the motion is faster than the run is long (stiff springs, hard control), or more "
           "steps must be allowed";
  }
  if (!flat.empty()) what += ": " + flat;
  return {status, time_, at_time(time_) + what + "; configuration: " + configuration_text(mechanism_, position_), {}};
}

#define BALANCE_INSTANTIATE(S)                                                                     \
  template void EngineOf<S>::store();                                                              \
  template void EngineOf<S>::load(const std::vector<double>&);                                     \
  template void EngineOf<S>::derivative(const std::vector<double>&, std::vector<double>&, double); \
  template bool EngineOf<S>::try_step(double&, double&, bool&, bool&);                             \
  template MotionOutcome EngineOf<S>::go(double);                                                  \
  template bool EngineOf<S>::settle(double, bool&);                                                \
  template bool EngineOf<S>::may_have_been_singular(double);                                       \
  template void EngineOf<S>::back_to_start();                                                      \
  template bool EngineOf<S>::choose_anew();                                                        \
  template bool EngineOf<S>::overflows();                                                          \
  template MotionOutcome EngineOf<S>::stop(MotionStatus);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
