#include "balance/mechanics/trajectory/prescribed_motion.hpp"

#include "balance/mechanics/trajectory/geometric_path.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace balance {
namespace {

constexpr int phase_plane_intervals = 400;  // of the duration

}  // namespace

void sample_phase_plane(const PrescribedMotion& schedule, PhasePlane& plane) {
  const double duration = schedule.duration();
  std::vector<std::pair<double, Side>> moments;
  for (int k = 0; k <= phase_plane_intervals; ++k)
    moments.emplace_back(k == phase_plane_intervals ? duration : duration * k / phase_plane_intervals,
                         k == phase_plane_intervals ? Side::before : Side::after);
  for (const double jump : schedule.jump_times()) {
    moments.emplace_back(jump, Side::before);
    moments.emplace_back(jump, Side::after);
  }
  std::sort(moments.begin(), moments.end());
  const auto count = static_cast<Eigen::Index>(moments.size());
  plane.time.resize(count), plane.path_parameter.resize(count), plane.path_rate.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto [time, side] = moments[static_cast<std::size_t>(i)];
    const MotionLawValue here = schedule.path_progress(time, side);
    plane.time[i] = time, plane.path_parameter[i] = here.s, plane.path_rate[i] = here.ds;
  }
}

namespace {

/// Callers count their own time; what they miss the ends by is round-off up to this part of the duration.
constexpr double end_time_tolerance = 1e-9;

/// Relative to their sizes, differences below this are round-off and no jump.
constexpr double jump_tolerance = 1e-9;

[[noreturn]] void throw_time_out_of_range(double time, double duration) {
  throw std::invalid_argument("the motion lasts from 0 to " + std::to_string(duration) + " s; asked for " +
                              std::to_string(time) + " s");
}

template <typename Vector>
bool is_jump(const Vector& a, const Vector& b) {
  return (a - b).norm() > jump_tolerance * (a.norm() + b.norm());
}

}  // namespace

struct PrescribedMotion::Implementation {
  SegmentedPath itinerary;
  std::optional<TimeScaling>
      path_time_scaling;  ///< of a law that was found for the whole path: leads through the legs' uniform clocks
  std::vector<ComponentOffset> courses;
  std::vector<double> jumps;

  double duration() const { return path_time_scaling ? path_time_scaling->duration() : itinerary.duration; }
  const PathSegment& leg_at(double time, Side side) const;
  /// The leg that is run through at a time, and how far it is on.
  std::pair<const PathSegment*, MotionLawValue> progress(double time, Side side) const;
  /// The parameter of a course at a time, 0 to 1: the time as part of the duration, or how much of all legs is behind.
  MotionLawValue parameter(const ComponentOffset& course, double time, const PathSegment& leg,
                           const MotionLawValue& progress) const;
  MotionLawValue way(const PathSegment& leg, const MotionLawValue& progress) const;
  void add(const ComponentOffset& course, const MotionLawValue& parameter, Side side, DriveSample& sample) const;
  void add_jump(const PrescribedMotion& schedule, double time);
  void add_jumps(const PrescribedMotion& schedule, const std::vector<double>& switches);
  /// The first jump later than a time, or the end.
  double next_jump(double time) const;
};

namespace {

/// The path alone, at constant speed, where the law is one for the whole of it.
PrescribedMotion::Request make_uniform_path_request(PrescribedMotion::Request request) {
  if (!is_mechanism_dependent(request.law.kind)) return request;
  request.law = {.kind = MotionLawKind::uniform};
  request.duration = 1;
  return request;
}

}  // namespace

std::pair<const PathSegment*, MotionLawValue> PrescribedMotion::Implementation::progress(double time, Side side) const {
  if (!path_time_scaling) {
    const PathSegment& leg = leg_at(time, side);
    return {&leg, leg.time_scaling.at(time, side)};
  }
  const MotionLawValue way = path_time_scaling->at(time, side);
  const double place = way.s * itinerary.duration;
  const PathSegment& leg = leg_at(place, side);
  const MotionLawValue here = leg.time_scaling.at(place, side);
  const double rate = here.ds * itinerary.duration;
  return {&leg, {here.s, rate * way.ds, rate * way.dds}};
}

MotionLawValue PrescribedMotion::Implementation::parameter(const ComponentOffset& course, double time,
                                                           const PathSegment& leg,
                                                           const MotionLawValue& progress) const {
  if (course.over_time) return {std::clamp(time / duration(), 0.0, 1.0), 1 / duration(), 0};
  return way(leg, progress);
}

MotionLawValue PrescribedMotion::Implementation::way(const PathSegment& leg, const MotionLawValue& progress) const {
  const double share = leg.time_scaling.duration() / itinerary.duration;
  return {leg.time_scaling.start() / itinerary.duration + share * progress.s, share * progress.ds,
          share * progress.dds};
}

void PrescribedMotion::Implementation::add(const ComponentOffset& course, const MotionLawValue& parameter, Side side,
                                           DriveSample& sample) const {
  const ValueWithDerivatives here = evaluate_with_derivatives(course.series, parameter.s, side);
  sample.value[course.component] += here.value;
  sample.rate[course.component] += here.first * parameter.ds;
  sample.acceleration[course.component] += here.second * parameter.ds * parameter.ds + here.first * parameter.dds;
}

/// Of times at which something may jump those at which something does.
void PrescribedMotion::Implementation::add_jump(const PrescribedMotion& schedule, double time) {
  DriveSample before, after;
  schedule.at(time, Side::before, before);
  schedule.at(time, Side::after, after);
  if (is_jump(before.acceleration, after.acceleration) || is_jump(before.rate, after.rate) ||
      is_jump(before.angular_acceleration, after.angular_acceleration) ||
      is_jump(before.angular_velocity, after.angular_velocity)) {
    jumps.push_back(time);
  }
}

void PrescribedMotion::Implementation::add_jumps(const PrescribedMotion& schedule,
                                                 const std::vector<double>& switches) {
  if (path_time_scaling)
    for (const double time : path_time_scaling->jumps()) add_jump(schedule, time);
  else
    for (const PathSegment& leg : itinerary.segments) {
      if (&leg != &itinerary.segments.front()) add_jump(schedule, leg.time_scaling.start());
      for (const double time : leg.time_scaling.jumps()) add_jump(schedule, time);
    }
  for (const ComponentOffset& course : courses)
    if (course.over_time)
      for (const Panel& panel : course.series.panels())
        if (panel.begin > 0) add_jump(schedule, panel.begin * duration());
  const double margin = time_tolerance * duration();
  for (const double time : switches)
    if (time > margin && time < duration() - margin) jumps.push_back(time);
  std::sort(jumps.begin(), jumps.end());
  const auto same = [this](double a, double b) { return b - a < time_tolerance * duration(); };
  jumps.erase(std::unique(jumps.begin(), jumps.end(), same), jumps.end());
}

const PathSegment& PrescribedMotion::Implementation::leg_at(double time, Side side) const {
  const std::vector<PathSegment>& legs = itinerary.segments;
  if (legs.size() == 1) return legs.front();
  const double same = time_tolerance * itinerary.duration;
  const double latest = side == Side::after ? time + same : time - same;
  const auto next = std::upper_bound(legs.begin() + 1, legs.end(), latest,
                                     [](double t, const PathSegment& leg) { return t < leg.time_scaling.start(); });
  return *(next - 1);
}

double PrescribedMotion::Implementation::next_jump(double time) const {
  const auto next = std::upper_bound(jumps.begin(), jumps.end(), time + time_tolerance * duration());
  return next == jumps.end() ? duration() : *next;
}

PrescribedMotion::PrescribedMotion(const Request& request) : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.itinerary = make_segmented_path(make_uniform_path_request(request));
  if (is_mechanism_dependent(request.law.kind)) {
    validate(request.law);
    self.path_time_scaling.emplace(request.law, 0, request.duration, time_tolerance * request.duration);
  }
  self.courses = request.component_offsets;
  self.add_jumps(*this, request.switch_times);
}

PrescribedMotion::~PrescribedMotion() = default;
PrescribedMotion::PrescribedMotion(PrescribedMotion&&) noexcept = default;
PrescribedMotion& PrescribedMotion::operator=(PrescribedMotion&&) noexcept = default;

void PrescribedMotion::at(double time, Side side, DriveSample& sample) const {
  const SegmentedPath& itinerary = implementation_->itinerary;
  const double margin = end_time_tolerance * duration();
  if (!(time >= -margin && time <= duration() + margin)) throw_time_out_of_range(time, duration());
  sample.value.resize(itinerary.size);  // keeps its memory where the size is right already
  sample.rate.resize(itinerary.size);
  sample.acceleration.resize(itinerary.size);
  const auto [leg, progress] = implementation_->progress(time, side);
  std::visit([&, &progress = progress](const auto& curve) { curve.fill(progress, sample); }, leg->curve);
  std::visit([&, &progress = progress](const auto& turn) { turn.fill(progress, sample); }, leg->rotation);
  for (const ComponentOffset& course : implementation_->courses)
    implementation_->add(course, implementation_->parameter(course, time, *leg, progress), side, sample);
}

MotionLawValue PrescribedMotion::path_progress(double time, Side side) const {
  const auto [leg, progress] = implementation_->progress(time, side);
  return implementation_->way(*leg, progress);
}

double PrescribedMotion::max_step(double time) const {
  constexpr double max_step_fraction = 1.0 / 24,
                   min_step_fraction = 1e-6;  // of a leg: its law has one rise, at most two bends
  const double same = time_tolerance * duration();
  const bool found = implementation_->path_time_scaling.has_value();
  const PathSegment* leg = found ? nullptr : &implementation_->leg_at(time, Side::after);
  MotionLawValue progress;
  // Of a plain leg its length says all; every step asks.
  if (found || !implementation_->courses.empty() || std::holds_alternative<SplineCurve>(leg->curve))
    std::tie(leg, progress) = implementation_->progress(time, Side::after);
  const double whole = found ? duration() : leg->time_scaling.duration();
  double step = max_step_fraction * whole;
  if (const auto* curve = std::get_if<SplineCurve>(&leg->curve)) {
    const double stretch = curve->spline.interval_length(progress.s);
    const double takes = found ? stretch / std::max(progress.ds, 1 / whole) : stretch * whole;
    step = std::clamp(takes, min_step_fraction * whole, step);
  }
  for (const ComponentOffset& course : implementation_->courses) {
    const MotionLawValue here = implementation_->parameter(course, time, *leg, progress);
    const Panel& panel = course.series.panels()[course.series.find_panel(here.s, 0, course.series.panels().size())];
    const double takes = (panel.end - panel.begin) / std::max(here.ds, 1 / duration());
    step = std::min(step, std::max(takes, min_step_fraction * whole));
  }
  const double left = found ? implementation_->next_jump(time) - time : leg->time_scaling.start() + whole - time;
  return left > same ? std::min(step, left) : step;
}

double PrescribedMotion::duration() const { return implementation_->duration(); }

int PrescribedMotion::component_count() const { return implementation_->itinerary.size; }

const std::vector<double>& PrescribedMotion::jump_times() const { return implementation_->jumps; }

std::vector<double> PrescribedMotion::knot_times() const {
  std::vector<double> times;
  for (const PathSegment& leg : implementation_->itinerary.segments)
    if (const auto* curve = std::get_if<SplineCurve>(&leg.curve))
      for (const double knot : curve->spline.knots())
        if (knot > 0 && knot < 1) times.push_back(leg.time_scaling.start() + knot * leg.time_scaling.duration());
  for (const ComponentOffset& course : implementation_->courses)
    for (const Panel& panel : course.series.panels())
      if (panel.begin > 0) times.push_back(panel.begin * duration());
  std::sort(times.begin(), times.end());
  return times;
}

std::vector<double> PrescribedMotion::segment_end_times() const {
  std::vector<double> times;
  for (const PathSegment& leg : implementation_->itinerary.segments)
    if (&leg != &implementation_->itinerary.segments.front()) times.push_back(leg.time_scaling.start());
  return times;
}

}  // namespace balance
