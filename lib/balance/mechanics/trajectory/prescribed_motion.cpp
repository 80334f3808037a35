#include "balance/mechanics/trajectory/prescribed_motion.hpp"

#include "balance/mechanics/trajectory/geometric_path.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace balance::trajectory {
namespace {

constexpr int phase_plane_intervals = 400;  // per duration

}  // namespace

void sample_phase_plane(const PrescribedMotion& motion, PhasePlane& plane) {
  const double duration = motion.duration();
  std::vector<std::pair<double, Side>> instants;
  for (int k = 0; k <= phase_plane_intervals; ++k)
    instants.emplace_back(k == phase_plane_intervals ? duration : duration * k / phase_plane_intervals,
                          k == phase_plane_intervals ? Side::before : Side::after);
  for (const double jump : motion.jump_times()) {
    instants.emplace_back(jump, Side::before);
    instants.emplace_back(jump, Side::after);
  }
  std::sort(instants.begin(), instants.end());
  const auto count = static_cast<Eigen::Index>(instants.size());
  plane.time.resize(count), plane.path_parameter.resize(count), plane.path_rate.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto [time, side] = instants[static_cast<std::size_t>(i)];
    const MotionLawValue progress = motion.path_progress(time, side);
    plane.time[i] = time, plane.path_parameter[i] = progress.s, plane.path_rate[i] = progress.ds;
  }
}

namespace {

/// Callers keep their own time. Times outside by up to this fraction of the duration are round-off.
constexpr double end_time_tolerance = 1e-9;

/// Relative differences below this are round-off rather than jumps.
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
  SegmentedPath path;
  std::optional<TimeScaling>
      path_time_scaling;  ///< for an optimised law of the whole path: maps time to the time of the uniform legs
  std::vector<ComponentOffset> offsets;
  std::vector<double> jumps;
  bool has_real_time = true;

  double duration() const { return path_time_scaling ? path_time_scaling->duration() : path.duration; }
  const PathSegment& leg_at(double time, Side side) const;
  /// The leg at a time, and the progress along it.
  std::pair<const PathSegment*, MotionLawValue> leg_progress(double time, Side side) const;
  /// The parameter of an offset at a time, 0 to 1: time as a fraction of the duration, or progress along all legs.
  MotionLawValue offset_parameter(const ComponentOffset& offset, double time, const PathSegment& leg,
                                  const MotionLawValue& progress) const;
  MotionLawValue path_progress(const PathSegment& leg, const MotionLawValue& progress) const;
  void add(const ComponentOffset& offset, const MotionLawValue& parameter, Side side, DriveSample& sample) const;
  void add_jump(const PrescribedMotion& motion, double time);
  void add_jumps(const PrescribedMotion& motion, const std::vector<double>& switches);
  /// The first jump after a time, or the end.
  double next_jump(double time) const;
};

namespace {

/// For a law of the whole path: the path alone, at constant speed.
PrescribedMotion::Request make_uniform_path_request(PrescribedMotion::Request request) {
  if (!is_mechanism_dependent(request.law.kind)) return request;
  request.law = {.kind = MotionLawKind::uniform};
  request.duration = 1;
  return request;
}

}  // namespace

std::pair<const PathSegment*, MotionLawValue> PrescribedMotion::Implementation::leg_progress(double time,
                                                                                             Side side) const {
  if (!path_time_scaling) {
    const PathSegment& leg = leg_at(time, side);
    return {&leg, leg.time_scaling.at(time, side)};
  }
  const MotionLawValue path_progress = path_time_scaling->at(time, side);
  const double path_time = path_progress.s * path.duration;
  const PathSegment& leg = leg_at(path_time, side);
  const MotionLawValue leg_value = leg.time_scaling.at(path_time, side);
  const double rate = leg_value.ds * path.duration;
  return {&leg, {leg_value.s, rate * path_progress.ds, rate * path_progress.dds}};
}

MotionLawValue PrescribedMotion::Implementation::offset_parameter(const ComponentOffset& offset, double time,
                                                                  const PathSegment& leg,
                                                                  const MotionLawValue& progress) const {
  if (offset.over_time) return {std::clamp(time / duration(), 0.0, 1.0), 1 / duration(), 0};
  return path_progress(leg, progress);
}

MotionLawValue PrescribedMotion::Implementation::path_progress(const PathSegment& leg,
                                                               const MotionLawValue& progress) const {
  const double fraction = leg.time_scaling.duration() / path.duration;
  return {leg.time_scaling.start() / path.duration + fraction * progress.s, fraction * progress.ds,
          fraction * progress.dds};
}

void PrescribedMotion::Implementation::add(const ComponentOffset& offset, const MotionLawValue& parameter, Side side,
                                           DriveSample& sample) const {
  const ValueWithDerivatives offset_value = evaluate_with_derivatives(offset.series, parameter.s, side);
  sample.value[offset.component] += offset_value.value;
  sample.rate[offset.component] += offset_value.first * parameter.ds;
  sample.acceleration[offset.component] +=
      offset_value.second * parameter.ds * parameter.ds + offset_value.first * parameter.dds;
}

/// Records `time` as a jump if an acceleration or velocity jumps there.
void PrescribedMotion::Implementation::add_jump(const PrescribedMotion& motion, double time) {
  DriveSample before, after;
  motion.at(time, Side::before, before);
  motion.at(time, Side::after, after);
  if (is_jump(before.acceleration, after.acceleration) || is_jump(before.rate, after.rate) ||
      is_jump(before.angular_acceleration, after.angular_acceleration) ||
      is_jump(before.angular_velocity, after.angular_velocity)) {
    jumps.push_back(time);
  }
}

void PrescribedMotion::Implementation::add_jumps(const PrescribedMotion& motion, const std::vector<double>& switches) {
  if (path_time_scaling)
    for (const double time : path_time_scaling->jumps()) add_jump(motion, time);
  else
    for (const PathSegment& leg : path.segments) {
      if (&leg != &path.segments.front()) add_jump(motion, leg.time_scaling.start());
      for (const double time : leg.time_scaling.jumps()) add_jump(motion, time);
    }
  for (const ComponentOffset& offset : offsets)
    if (offset.over_time)
      for (const numerics::Panel& panel : offset.series.panels())
        if (panel.begin > 0) add_jump(motion, panel.begin * duration());
  const double margin = time_tolerance * duration();
  for (const double time : switches)
    if (time > margin && time < duration() - margin) jumps.push_back(time);
  std::sort(jumps.begin(), jumps.end());
  const auto is_same = [this](double a, double b) { return b - a < time_tolerance * duration(); };
  jumps.erase(std::unique(jumps.begin(), jumps.end(), is_same), jumps.end());
}

const PathSegment& PrescribedMotion::Implementation::leg_at(double time, Side side) const {
  const std::vector<PathSegment>& legs = path.segments;
  if (legs.size() == 1) return legs.front();
  const double tolerance = time_tolerance * path.duration;
  const double latest = side == Side::after ? time + tolerance : time - tolerance;
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
  self.path = make_segmented_path(make_uniform_path_request(request));
  if (is_mechanism_dependent(request.law.kind)) {
    validate(request.law);
    self.path_time_scaling.emplace(request.law, 0, request.duration, time_tolerance * request.duration);
  }
  self.offsets = request.component_offsets;
  self.has_real_time = request.has_real_time;
  self.add_jumps(*this, request.switch_times);
}

PrescribedMotion::~PrescribedMotion() = default;
PrescribedMotion::PrescribedMotion(PrescribedMotion&&) noexcept = default;
PrescribedMotion& PrescribedMotion::operator=(PrescribedMotion&&) noexcept = default;

void PrescribedMotion::at(double time, Side side, DriveSample& sample) const {
  const SegmentedPath& path = implementation_->path;
  const double margin = end_time_tolerance * duration();
  if (!(time >= -margin && time <= duration() + margin)) throw_time_out_of_range(time, duration());
  sample.value.resize(path.size);  // does not allocate if the size is right
  sample.rate.resize(path.size);
  sample.acceleration.resize(path.size);
  sample.constraint_time = implementation_->has_real_time ? time : std::numeric_limits<double>::quiet_NaN();
  const auto [leg, progress] = implementation_->leg_progress(time, side);
  std::visit([&, &progress = progress](const auto& curve) { curve.fill(progress, sample); }, leg->curve);
  std::visit([&, &progress = progress](const auto& rotation) { rotation.fill(progress, sample); }, leg->rotation);
  for (const ComponentOffset& offset : implementation_->offsets)
    implementation_->add(offset, implementation_->offset_parameter(offset, time, *leg, progress), side, sample);
}

MotionLawValue PrescribedMotion::path_progress(double time, Side side) const {
  const auto [leg, progress] = implementation_->leg_progress(time, side);
  return implementation_->path_progress(*leg, progress);
}

double PrescribedMotion::max_step(double time) const {
  constexpr double max_step_fraction = 1.0 / 24,
                   min_step_fraction = 1e-6;  // of a leg: its law has one rise and at most two bends
  const double tolerance = time_tolerance * duration();
  const bool has_path_time_scaling = implementation_->path_time_scaling.has_value();
  const PathSegment* leg = has_path_time_scaling ? nullptr : &implementation_->leg_at(time, Side::after);
  MotionLawValue progress;
  // A plain leg needs only its length; this is called for every step.
  if (has_path_time_scaling || !implementation_->offsets.empty() || std::holds_alternative<SplineCurve>(leg->curve))
    std::tie(leg, progress) = implementation_->leg_progress(time, Side::after);
  const double leg_duration = has_path_time_scaling ? duration() : leg->time_scaling.duration();
  double step = max_step_fraction * leg_duration;
  if (const auto* curve = std::get_if<SplineCurve>(&leg->curve)) {
    const double interval = curve->spline.interval_length(progress.s);
    const double step_limit =
        has_path_time_scaling ? interval / std::max(progress.ds, 1 / leg_duration) : interval * leg_duration;
    step = std::clamp(step_limit, min_step_fraction * leg_duration, step);
  }
  for (const ComponentOffset& offset : implementation_->offsets) {
    const MotionLawValue parameter = implementation_->offset_parameter(offset, time, *leg, progress);
    const numerics::Panel& panel =
        offset.series.panels()[offset.series.find_panel(parameter.s, 0, offset.series.panels().size())];
    const double step_limit = (panel.end - panel.begin) / std::max(parameter.ds, 1 / duration());
    step = std::min(step, std::max(step_limit, min_step_fraction * leg_duration));
  }
  const double remaining =
      has_path_time_scaling ? implementation_->next_jump(time) - time : leg->time_scaling.start() + leg_duration - time;
  return remaining > tolerance ? std::min(step, remaining) : step;
}

double PrescribedMotion::duration() const { return implementation_->duration(); }

int PrescribedMotion::component_count() const { return implementation_->path.size; }

const std::vector<double>& PrescribedMotion::jump_times() const { return implementation_->jumps; }

std::vector<double> PrescribedMotion::knot_times() const {
  std::vector<double> times;
  for (const PathSegment& leg : implementation_->path.segments)
    if (const auto* curve = std::get_if<SplineCurve>(&leg.curve))
      for (const double knot : curve->spline.knots())
        if (knot > 0 && knot < 1) times.push_back(leg.time_scaling.start() + knot * leg.time_scaling.duration());
  for (const ComponentOffset& offset : implementation_->offsets)
    for (const numerics::Panel& panel : offset.series.panels())
      if (panel.begin > 0) times.push_back(panel.begin * duration());
  std::sort(times.begin(), times.end());
  return times;
}

std::vector<double> PrescribedMotion::segment_end_times() const {
  std::vector<double> times;
  for (const PathSegment& leg : implementation_->path.segments)
    if (&leg != &implementation_->path.segments.front()) times.push_back(leg.time_scaling.start());
  return times;
}

}  // namespace balance::trajectory
