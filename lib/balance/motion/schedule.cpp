#include "balance/motion/schedule.hpp"

#include "balance/motion/leg.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

namespace balance {
namespace {

/// Callers count their own time; what they miss the ends by is round-off up to this part of the duration.
constexpr double slack = 1e-9;

/// Relative to their sizes, differences below this are round-off and no jump.
constexpr double least_jump = 1e-9;

[[noreturn]] void refuse(double time, double duration) {
  throw std::invalid_argument("the motion lasts from 0 to " + std::to_string(duration) + " s; asked for " +
                              std::to_string(time) + " s");
}

template <typename Vector>
bool differ(const Vector& a, const Vector& b) {
  return (a - b).norm() > least_jump * (a.norm() + b.norm());
}

}  // namespace

struct Schedule::Implementation {
  Itinerary itinerary;
  std::vector<double> jumps;

  const Leg& leg_at(double time, Side side) const;
};

const Leg& Schedule::Implementation::leg_at(double time, Side side) const {
  const std::vector<Leg>& legs = itinerary.legs;
  if (legs.size() == 1) return legs.front();
  const double same = same_time * itinerary.duration;
  const double latest = side == Side::after ? time + same : time - same;
  const auto next = std::upper_bound(legs.begin() + 1, legs.end(), latest,
                                     [](double t, const Leg& leg) { return t < leg.clock.start(); });
  return *(next - 1);
}

Schedule::Schedule(const Request& request) : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.itinerary = make_itinerary(request);
  DriveSample before, after;
  const auto add_if_jump = [&](double time) {
    at(time, Side::before, before);
    at(time, Side::after, after);
    if (differ(before.acceleration, after.acceleration) || differ(before.rate, after.rate) ||
        differ(before.angular_acceleration, after.angular_acceleration) ||
        differ(before.angular_velocity, after.angular_velocity)) {
      self.jumps.push_back(time);
    }
  };
  for (const Leg& leg : self.itinerary.legs) {
    if (&leg != &self.itinerary.legs.front()) add_if_jump(leg.clock.start());
    for (const double time : leg.clock.jumps()) add_if_jump(time);
  }
}

Schedule::~Schedule() = default;
Schedule::Schedule(Schedule&&) noexcept = default;
Schedule& Schedule::operator=(Schedule&&) noexcept = default;

void Schedule::at(double time, Side side, DriveSample& sample) const {
  const Itinerary& itinerary = implementation_->itinerary;
  const double margin = slack * itinerary.duration;
  if (!(time >= -margin && time <= itinerary.duration + margin)) refuse(time, itinerary.duration);
  sample.value.resize(itinerary.size);  // keeps its memory where the size is right already
  sample.rate.resize(itinerary.size);
  sample.acceleration.resize(itinerary.size);
  const Leg& leg = implementation_->leg_at(time, side);
  const LawValue progress = leg.clock.at(time, side);
  std::visit([&](const auto& curve) { curve.fill(progress, sample); }, leg.curve);
  std::visit([&](const auto& turn) { turn.fill(progress, sample); }, leg.turn);
}

double Schedule::longest_step(double time) const {
  constexpr double part = 1.0 / 24, least = 1e-6;  // of a leg: its law has one rise, at most two bends
  const double same = same_time * duration();
  const Leg& leg = implementation_->leg_at(time, Side::after);
  const double whole = leg.clock.duration();
  double step = part * whole;
  if (const auto* curve = std::get_if<SplineCurve>(&leg.curve)) {
    const double stretch = curve->spline.stretch(leg.clock.at(time, Side::after).s);
    step = std::clamp(stretch * whole, least * whole, step);
  }
  const double left = leg.clock.start() + whole - time;
  return left > same ? std::min(step, left) : step;
}

double Schedule::duration() const { return implementation_->itinerary.duration; }

int Schedule::size() const { return implementation_->itinerary.size; }

const std::vector<double>& Schedule::jumps() const { return implementation_->jumps; }

}  // namespace balance
