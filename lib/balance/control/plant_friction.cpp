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
  return loops_.friction_margin(time, dy_.data(), efforts_.data(), fastest_);
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
  double over = friction_margin(time);
  if (over >= 0) return true;
  event_ = true;
  const double start = time_;
  const auto slope = [this](const std::vector<double>& x, std::vector<double>& dxdt, double t) {
    derivative(x, dxdt, t);
  };
  load(last_x_);
  if (!loops_.close(y_.data(), dy_.data())) return false;
  double low = 0, high = step, under = std::max(friction_margin(start), round_off), beyond = over;
  bool above = false, below = false;  // which end the last turn has moved
  std::vector<double> there = x_;
  for (int turn = 0; turn < most_halvings; ++turn) {
    if (high - low <= resolution * std::max(std::abs(start), step) || beyond > -round_off) break;
    // false position (Illinois), with a bisection now and then
    double at = turn % 4 == 3 ? (low + high) / 2 : low + (high - low) * under / (under - over);
    if (!(at > low && at < high)) at = (low + high) / 2;
    if (!(at > low && at < high)) break;
    x_ = last_x_;
    integrator_.leap(slope, x_, start, at);
    load(x_);
    if (!loops_.close(y_.data(), dy_.data())) return false;
    const double margin = friction_margin(start + at);
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
  time = start + high;
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
  const bool good = settle_friction(efforts_);
  store();
  last_x_ = x_;
  return good;
}

#define BALANCE_INSTANTIATE(S)                                \
  template void EngineOf<S>::grow_fastest();                  \
  template bool EngineOf<S>::settle_friction(const VectorX&); \
  template double EngineOf<S>::friction_margin(double);       \
  template bool EngineOf<S>::find_event(double, double&);     \
  template bool EngineOf<S>::pass_event();
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
