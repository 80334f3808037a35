/// The plant's dry friction: joints come to rest, stick, turn back and break loose at moments that are found, and between them the
/// motion is smooth.

#include "balance/control/plant_engine.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

constexpr double rest = 1e-10;        // part of the largest rate so far that counts as none where a joint may stick
constexpr double resolution = 4e-16;  // of a moment, as part of the time or the step
constexpr double round_off = 1e-13;   // excess that is as good as none
constexpr int most_halvings = 80;
constexpr int most_events_here = 30;  // without progress, before a step takes no notice of them

}  // namespace

template <class S>
void EngineOf<S>::grow_fastest() {
  if (!loops_.dry()) return;
  for (int c = 0; c < loops_.columns(); ++c) fastest_ = std::max(fastest_, std::abs(dy_[c]) / loops_.scale()[c]);
}

/// At the present state: which joints stick under these efforts. Those that do hold columns of the tree.
/// @return false at a singularity of the closures
template <class S>
bool EngineOf<S>::settle_friction(const VectorX& efforts) {
  if (!loops_.dry()) return true;
  if (!loops_.close(y_.data(), dy_.data())) return false;
  const FrictionChange change = loops_.decide_friction(time_, dy_.data(), efforts.data(), rest * fastest_);
  if (change != FrictionChange::none) integrator_.restart();
  if (change != FrictionChange::sticks) return true;
  last_x_ = x_;
  const bool good = choose_anew();
  store();
  if (loops_.stuck_share() && !shared_) {
    shared_ = true;
    notes_.push_back(
        "dry friction: joints at rest share what holds the mechanism; their friction is one of many that would hold "
        "it");
  }
  return good;
}

template <class S>
double EngineOf<S>::friction_margin(double time) {
  ++cost_.evaluations;
  push(time);
  return loops_.friction_margin(time, dy_.data(), efforts_.data(), fastest_);
}

/// To as much after the step's start, x_ being the state there; the integrator begins anew.
template <class S>
bool EngineOf<S>::leap(double at) {
  x_ = last_x_;
  const auto slope = [this](const std::vector<double>& x, std::vector<double>& dxdt, double t) {
    derivative(x, dxdt, t);
  };
  integrator_.leap(slope, x_, time_, at);
  load(x_);
  return loops_.close(y_.data(), dy_.data());
}

/// Where in a step from last_x_ a joint that slips may have stopped, though it moves on at the end: the part at which its rate is
/// least by the cubic through the rates and accelerations at both ends, if that is below zero. 0 if there is none.
template <class S>
double EngineOf<S>::dip(double step) const {
  double first = 0;
  for (const JointFriction& joint : loops_.frictions()) {
    if (!joint.dry() || joint.stuck) continue;
    const double unit = joint.sign * joint.ratio();
    const double begin = unit * last_x_[loops_.columns() + joint.column()] * loops_.scale()[joint.column()],
                 gain = unit * dy_[joint.column()] - begin;
    const double falls = unit * step * start_ddy_[joint.column()], rises = unit * step * ddy_[joint.column()];
    if (!(falls < 0 && rises > 0)) continue;
    // begin + falls p + square p² + cube p³
    const double square = 3 * gain - 2 * falls - rises, cube = falls + rises - 2 * gain;
    const double part = -falls / (square + std::sqrt(std::max(0.0, square * square - 3 * falls * cube)));
    if (!(part > 0 && part < 1) || begin + part * (falls + part * (square + part * cube)) >= 0) continue;
    first = first > 0 ? std::min(first, part) : part;
  }
  return first;
}

/// After a good step: is there an event in it?
/// @param high on return the part of the step before which it is @param over the margin there, not negative if there is none
/// @return false if the way there cannot be made
template <class S>
bool EngineOf<S>::event_within(double step, double& high, double& over) {
  high = step;
  over = friction_margin(time_ + step);
  if (over < 0) return true;
  const double part = dip(step);
  if (part == 0) return true;
  const std::vector<double> end = x_;
  const VectorX end_ddy = ddy_;
  high = part * step;
  if (!leap(high)) return false;
  over = friction_margin(time_ + high);
  if (over < 0) {
    store();
    return true;
  }
  x_ = end;
  ddy_ = end_ddy;
  load(x_);
  return loops_.close(y_.data(), dy_.data());
}

/// After a good step from last_x_ to x_: goes back to the first event on the way, if there is one.
/// @param step that was made @param time at its end; on return of the event
/// @return false if the way there cannot be made
template <class S>
bool EngineOf<S>::find_event(double step, double& time) {
  event_ = false;
  if (!loops_.dry() || blind_) {
    blind_ = false;
    return true;
  }
  double low = 0, high, over;
  if (!event_within(step, high, over)) return false;
  if (over >= 0) return true;
  event_ = true;
  std::vector<double> there = x_;
  load(last_x_);
  if (!loops_.close(y_.data(), dy_.data())) return false;
  double under = std::max(friction_margin(time_), round_off), beyond = over;
  bool above = false, below = false;  // which end the last turn has moved
  for (int turn = 0; turn < most_halvings; ++turn) {
    if (high - low <= resolution * std::max(std::abs(time_), step) || beyond > -round_off) break;
    // false position (Illinois), with a bisection now and then
    double at = turn % 4 == 3 ? (low + high) / 2 : low + (high - low) * under / (under - over);
    if (!(at > low && at < high)) at = (low + high) / 2;
    if (!(at > low && at < high)) break;
    if (!leap(at)) return false;
    const double margin = friction_margin(time_ + at);
    if (margin < 0) {
      high = at, over = beyond = margin;
      if (above) under /= 2;
      store();
      there = x_;
    } else {
      low = at, under = std::max(margin, round_off);
      if (below) over /= 2;
    }
    above = margin < 0, below = !above;
  }
  x_ = there;
  load(x_);
  if (!loops_.close(y_.data(), dy_.data())) return false;
  store();
  time = time_ + high;
  return true;
}

/// What sticks and slips from here on.
template <class S>
bool EngineOf<S>::pass_event() {
  ++cost_.events;
  integrator_.restart();
  const bool progress = time_ - event_time_ > 1e-12 * std::max(std::abs(time_), options_.longest_step);
  event_time_ = time_;
  events_here_ = progress ? 0 : events_here_ + 1;
  if (events_here_ == most_events_here) {
    blind_ = true;
    events_here_ = 0;
    step_ = std::max(step_, 1e-6 * options_.longest_step);
    const std::string note = "dry friction: sticking and slipping follow each other without end somewhere; steps of " +
                             std::to_string(1e6 * step_) + " us go through it";
    if (std::find(notes_.begin(), notes_.end(), note) == notes_.end() && notes_.size() < 20) notes_.push_back(note);
  }
  push(time_);
  const bool good = settle_friction(efforts_);
  store();
  last_x_ = x_;
  return good;
}

#define BALANCE_INSTANTIATE(S)                                       \
  template void EngineOf<S>::grow_fastest();                         \
  template bool EngineOf<S>::settle_friction(const VectorX&);        \
  template double EngineOf<S>::friction_margin(double);              \
  template bool EngineOf<S>::leap(double);                           \
  template double EngineOf<S>::dip(double) const;                    \
  template bool EngineOf<S>::event_within(double, double&, double&); \
  template bool EngineOf<S>::find_event(double, double&);            \
  template bool EngineOf<S>::pass_event();
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
