#include "balance/motion/schedule.hpp"

#include "balance/motion/course.hpp"
#include "balance/motion/leg.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
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
  std::optional<Clock> whole;  ///< of a law that was found for the whole path: leads through the legs' uniform clocks
  std::vector<AddedCourse> courses;
  std::vector<double> jumps;

  double duration() const { return whole ? whole->duration() : itinerary.duration; }
  const Leg& leg_at(double time, Side side) const;
  /// The leg that is run through at a time, and how far it is on.
  std::pair<const Leg*, LawValue> progress(double time, Side side) const;
  /// The parameter of a course at a time, 0 to 1: the time as part of the duration, or how much of all legs is behind.
  LawValue parameter(const AddedCourse& course, double time, const Leg& leg, const LawValue& progress) const;
  LawValue way(const Leg& leg, const LawValue& progress) const;
  void add(const AddedCourse& course, const LawValue& parameter, Side side, DriveSample& sample) const;
  void add_jump(const Schedule& schedule, double time);
  void add_jumps(const Schedule& schedule, const std::vector<double>& switches);
  /// The first jump later than a time, or the end.
  double next_jump(double time) const;
};

namespace {

/// The path alone, at constant speed, where the law is one for the whole of it.
Schedule::Request path_of(Schedule::Request request) {
  if (!is_searched(request.law.kind)) return request;
  request.law = {.kind = LawKind::uniform};
  request.duration = 1;
  return request;
}

}  // namespace

std::pair<const Leg*, LawValue> Schedule::Implementation::progress(double time, Side side) const {
  if (!whole) {
    const Leg& leg = leg_at(time, side);
    return {&leg, leg.clock.at(time, side)};
  }
  const LawValue way = whole->at(time, side);
  const double place = way.s * itinerary.duration;
  const Leg& leg = leg_at(place, side);
  const LawValue here = leg.clock.at(place, side);
  const double rate = here.ds * itinerary.duration;
  return {&leg, {here.s, rate * way.ds, rate * way.dds}};
}

LawValue Schedule::Implementation::parameter(const AddedCourse& course, double time, const Leg& leg,
                                             const LawValue& progress) const {
  if (course.over_time) return {std::clamp(time / duration(), 0.0, 1.0), 1 / duration(), 0};
  return way(leg, progress);
}

LawValue Schedule::Implementation::way(const Leg& leg, const LawValue& progress) const {
  const double share = leg.clock.duration() / itinerary.duration;
  return {leg.clock.start() / itinerary.duration + share * progress.s, share * progress.ds, share * progress.dds};
}

void Schedule::Implementation::add(const AddedCourse& course, const LawValue& parameter, Side side,
                                   DriveSample& sample) const {
  const CourseValue here = evaluate(course.series, parameter.s, side);
  sample.value[course.component] += here.value;
  sample.rate[course.component] += here.first * parameter.ds;
  sample.acceleration[course.component] += here.second * parameter.ds * parameter.ds + here.first * parameter.dds;
}

/// Of times at which something may jump those at which something does.
void Schedule::Implementation::add_jump(const Schedule& schedule, double time) {
  DriveSample before, after;
  schedule.at(time, Side::before, before);
  schedule.at(time, Side::after, after);
  if (differ(before.acceleration, after.acceleration) || differ(before.rate, after.rate) ||
      differ(before.angular_acceleration, after.angular_acceleration) ||
      differ(before.angular_velocity, after.angular_velocity)) {
    jumps.push_back(time);
  }
}

void Schedule::Implementation::add_jumps(const Schedule& schedule, const std::vector<double>& switches) {
  if (whole)
    for (const double time : whole->jumps()) add_jump(schedule, time);
  else
    for (const Leg& leg : itinerary.legs) {
      if (&leg != &itinerary.legs.front()) add_jump(schedule, leg.clock.start());
      for (const double time : leg.clock.jumps()) add_jump(schedule, time);
    }
  for (const AddedCourse& course : courses)
    if (course.over_time)
      for (const Panel& panel : course.series.panels())
        if (panel.begin > 0) add_jump(schedule, panel.begin * duration());
  const double margin = same_time * duration();
  for (const double time : switches)
    if (time > margin && time < duration() - margin) jumps.push_back(time);
  std::sort(jumps.begin(), jumps.end());
  const auto same = [this](double a, double b) { return b - a < same_time * duration(); };
  jumps.erase(std::unique(jumps.begin(), jumps.end(), same), jumps.end());
}

const Leg& Schedule::Implementation::leg_at(double time, Side side) const {
  const std::vector<Leg>& legs = itinerary.legs;
  if (legs.size() == 1) return legs.front();
  const double same = same_time * itinerary.duration;
  const double latest = side == Side::after ? time + same : time - same;
  const auto next = std::upper_bound(legs.begin() + 1, legs.end(), latest,
                                     [](double t, const Leg& leg) { return t < leg.clock.start(); });
  return *(next - 1);
}

double Schedule::Implementation::next_jump(double time) const {
  const auto next = std::upper_bound(jumps.begin(), jumps.end(), time + same_time * duration());
  return next == jumps.end() ? duration() : *next;
}

Schedule::Schedule(const Request& request) : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.itinerary = make_itinerary(path_of(request));
  if (is_searched(request.law.kind)) {
    validate(request.law);
    self.whole.emplace(request.law, 0, request.duration, same_time * request.duration);
  }
  self.courses = request.courses;
  self.add_jumps(*this, request.switches);
}

Schedule::~Schedule() = default;
Schedule::Schedule(Schedule&&) noexcept = default;
Schedule& Schedule::operator=(Schedule&&) noexcept = default;

void Schedule::at(double time, Side side, DriveSample& sample) const {
  const Itinerary& itinerary = implementation_->itinerary;
  const double margin = slack * duration();
  if (!(time >= -margin && time <= duration() + margin)) refuse(time, duration());
  sample.value.resize(itinerary.size);  // keeps its memory where the size is right already
  sample.rate.resize(itinerary.size);
  sample.acceleration.resize(itinerary.size);
  const auto [leg, progress] = implementation_->progress(time, side);
  std::visit([&, &progress = progress](const auto& curve) { curve.fill(progress, sample); }, leg->curve);
  std::visit([&, &progress = progress](const auto& turn) { turn.fill(progress, sample); }, leg->turn);
  for (const AddedCourse& course : implementation_->courses)
    implementation_->add(course, implementation_->parameter(course, time, *leg, progress), side, sample);
}

LawValue Schedule::way(double time, Side side) const {
  const auto [leg, progress] = implementation_->progress(time, side);
  return implementation_->way(*leg, progress);
}

double Schedule::longest_step(double time) const {
  constexpr double part = 1.0 / 24, least = 1e-6;  // of a leg: its law has one rise, at most two bends
  const double same = same_time * duration();
  const bool found = implementation_->whole.has_value();
  const Leg* leg = found ? nullptr : &implementation_->leg_at(time, Side::after);
  LawValue progress;
  // Of a plain leg its length says all; every step asks.
  if (found || !implementation_->courses.empty() || std::holds_alternative<SplineCurve>(leg->curve))
    std::tie(leg, progress) = implementation_->progress(time, Side::after);
  const double whole = found ? duration() : leg->clock.duration();
  double step = part * whole;
  if (const auto* curve = std::get_if<SplineCurve>(&leg->curve)) {
    const double stretch = curve->spline.stretch(progress.s);
    const double takes = found ? stretch / std::max(progress.ds, 1 / whole) : stretch * whole;
    step = std::clamp(takes, least * whole, step);
  }
  for (const AddedCourse& course : implementation_->courses) {
    const LawValue here = implementation_->parameter(course, time, *leg, progress);
    const Panel& panel = course.series.panels()[course.series.panel_at(here.s, 0, course.series.panels().size())];
    const double takes = (panel.end - panel.begin) / std::max(here.ds, 1 / duration());
    step = std::min(step, std::max(takes, least * whole));
  }
  const double left = found ? implementation_->next_jump(time) - time : leg->clock.start() + whole - time;
  return left > same ? std::min(step, left) : step;
}

double Schedule::duration() const { return implementation_->duration(); }

int Schedule::size() const { return implementation_->itinerary.size; }

const std::vector<double>& Schedule::jumps() const { return implementation_->jumps; }

std::vector<double> Schedule::knots() const {
  std::vector<double> times;
  for (const Leg& leg : implementation_->itinerary.legs)
    if (const auto* curve = std::get_if<SplineCurve>(&leg.curve))
      for (const double knot : curve->spline.knots())
        if (knot > 0 && knot < 1) times.push_back(leg.clock.start() + knot * leg.clock.duration());
  for (const AddedCourse& course : implementation_->courses)
    for (const Panel& panel : course.series.panels())
      if (panel.begin > 0) times.push_back(panel.begin * duration());
  std::sort(times.begin(), times.end());
  return times;
}

std::vector<double> Schedule::leg_ends() const {
  std::vector<double> times;
  for (const Leg& leg : implementation_->itinerary.legs)
    if (&leg != &implementation_->itinerary.legs.front()) times.push_back(leg.clock.start());
  return times;
}

}  // namespace balance
