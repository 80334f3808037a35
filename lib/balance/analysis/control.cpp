#include "balance/analysis/control.hpp"

#include "balance/analysis/control_record.hpp"
#include "balance/base/extrema.hpp"
#include "balance/control/control_law.hpp"
#include "balance/control/desired_motion.hpp"
#include "balance/control/plant.hpp"
#include "balance/control/sensor.hpp"
#include "balance/control/singularity_watch.hpp"
#include "balance/model/coordinates.hpp"
#include "balance/model/payload_stretches.hpp"
#include "balance/motion/timing_bounds.hpp"
#include "balance/motion/walk.hpp"
#include "balance/motion/wording.hpp"
#include "balance/result/metrics.hpp"
#include "balance/result/overflow.hpp"
#include "balance/result/recorder.hpp"
#include "balance/result/round_off.hpp"
#include "balance/timing/time_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace balance {

namespace {

/// A moment at which something happens: a sample of the result, a sample of the controller, or both. Neither is a place that
/// figures rest on besides.
struct Event {
  double time;
  long sample;  ///< the first sample at or after it
  bool on_sample;
  bool tick;
};

std::vector<Event> list_events(double step, long samples, const Controller& controller) {
  std::vector<Event> events;
  const double end = step * static_cast<double>(samples - 1), same = 1e-9 * std::min(step, controller.period);
  long tick = controller.samples() ? 0 : -1;
  for (long k = 0; k < samples; ++k) {
    const double time = k == samples - 1 ? end : step * static_cast<double>(k);
    for (; tick >= 0; ++tick) {
      const double at = controller.period * static_cast<double>(tick);
      if (at >= time - same) break;
      events.push_back({at, k, false, true});
    }
    const bool together = tick >= 0 && std::abs(controller.period * static_cast<double>(tick) - time) <= same;
    // At the very end a new torque would act no more.
    events.push_back({time, k, true, together && k < samples - 1});
    if (together) ++tick;
  }
  return events;
}

/// With the moments at which stated efforts are not smooth, which may be their largest.
std::vector<Event> with_knots(std::vector<Event> events, const EffortCourse& course) {
  std::vector<Event> out;
  const double time_tolerance = 1e-9 * (events.size() > 1 ? events[1].time - events[0].time : 1);
  auto knot = course.knots().begin();
  const auto end = course.knots().end();
  for (const Event& event : events) {
    for (; knot != end && *knot < event.time - time_tolerance; ++knot)
      if (!out.empty() && *knot > out.back().time + time_tolerance) out.push_back({*knot, event.sample, false, false});
    out.push_back(event);
  }
  return out;
}

/// With places between events that are so far apart that figures need them.
/// @param steps that the whole run has at least
std::vector<Event> with_places(const std::vector<Event>& events, long steps) {
  std::vector<Event> out;
  const double longest = events.back().time / static_cast<double>(steps);
  for (const Event& event : events) {
    const double last = out.empty() ? event.time : out.back().time, gap = event.time - last;
    const auto pieces = static_cast<int>(std::ceil(gap / longest - 1e-9));
    for (int i = 1; i < pieces; ++i) out.push_back({last + gap * i / pieces, event.sample, false, false});
    out.push_back(event);
  }
  return out;
}

DesiredState state_of(const DesiredMotion& motion, Eigen::Index row) {
  return {motion.position.row(row), motion.velocity.row(row), motion.acceleration.row(row)};
}

constexpr double enormous = 1e100;  // of rates and positions: what comes of them are no numbers

std::string lost_track(const std::string& name, const std::string& error, const std::string& range, double time) {
  return fmt::format(
      "the controller does not lead {}: the error grows to {} (at t = {:.6g} s), where the motion's range is {}", name,
      error, time, range);
}

class ControlRun {
 public:
  ControlRun(const Mechanism& mechanism, const Trajectory& trajectory, const Controller& controller,
             const ControlOptions& options)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        controller_(controller),
        law_(mechanism, controller),
        sensor_(controller.measurement, controller.period),
        watch_(mechanism),
        options_(options),
        record_(mechanism, law_, desired_),
        efforts_(VectorX::Zero(static_cast<Eigen::Index>(mechanism.actuators.size()))),
        variation_(efforts_) {
    const double duration = duration_of(trajectory), step = duration / static_cast<double>(trajectory.samples - 1);
    if (!(duration >= shortest_run)) throw std::invalid_argument("the trajectory takes less than 1e-12 s");
    const double extra = std::ceil(options.settle / step - 1e-9),
                 steps = static_cast<double>(trajectory.samples) + extra;
    if (controller.is_continuous()) course_.emplace(controller.efforts, controller.torque_limit);
    const double all = steps + (controller.samples() ? (duration + options.settle) / controller.period : 0) +
                       (course_ ? static_cast<double>(course_->knots().size()) : 0);
    if (!(all <= most_control_steps))
      throw std::invalid_argument("the run has more than " + std::to_string(static_cast<long>(most_control_steps)) +
                                  " samples of controller and result together");
    samples_ = trajectory.samples + static_cast<long>(extra);
    std::vector<Event> stated = list_events(step, samples_, controller);
    if (course_) stated = with_knots(std::move(stated), *course_);
    // what is not sampled has no samples of a controller to rest on
    events_ = with_places(stated, course_ ? 5 * least_steps : least_steps);
    PlantOptions plant{.dynamics = {.preferred = mechanism.actuators}};
    const auto default_steps = 500'000 + 50 * static_cast<long>(stated.size());
    plant.most_steps = options.most_steps > 0 ? options.most_steps : default_steps;
    plant_.emplace(mechanism, plant, trajectory.about);
  }

  Result run() {
    std::vector<double> times;
    for (const Event& event : events_) times.push_back(event.time);
    desired_ = desired_motion(mechanism_, trajectory_, times);
    const bool wanted = desired_.outcome.status == MotionStatus::done;
    if (!wanted && needs_desired_motion(controller_)) return refused();
    if (!begin()) return refused();
    long done_rows = 0;
    for (std::size_t e = 0; e < events_.size(); ++e) {
      if (!pass(e, done_rows)) break;
    }
    if (done_rows < samples_) {
      cut_rows(done_rows, result_);
      cut_rows(static_cast<long>(between_.next_sample.size()), between_.rows);
    }
    add_round_off();
    if (result_.time.size() >= 2) {
      add_metrics(result_, between_);
      if (const auto lost = find_overflow(result_, between_, mechanism_); lost && outcome_.status == MotionStatus::done)
        outcome_ = *lost;
    }
    clear_round_off(result_);
    result_.outcome = outcome_;
    result_.outcome.notes = plant_->notes();
    const std::vector<std::string>& own = law_.notes();
    result_.outcome.notes.insert(result_.outcome.notes.end(), own.begin(), own.end());
    if (result_.time.size() >= 2) {
      const std::string note = sampling_note(result_, between_);
      if (!note.empty()) result_.outcome.notes.push_back(note);
    }
    if (!wanted)
      result_.outcome.notes.push_back("no errors are reported, because the desired motion does not exist: " +
                                      desired_.outcome.reason);
    note_lost_track();
    return std::move(result_);
  }

 private:
  Result refused() const {
    Result result;
    result.outcome = outcome_.status == MotionStatus::unsolved ? desired_.outcome : outcome_;
    return result;
  }

  bool good(MotionOutcome outcome) {
    outcome_ = std::move(outcome);
    return outcome_.status == MotionStatus::done;
  }

  VectorX actuated(const VectorX& all) const {
    VectorX chosen(efforts_.size());
    for (Eigen::Index a = 0; a < chosen.size(); ++a) chosen[a] = all[mechanism_.actuators[static_cast<std::size_t>(a)]];
    return chosen;
  }

  /// Puts the mechanism where it starts and makes room for the rows.
  bool begin() {
    const auto coordinates = static_cast<Eigen::Index>(mechanism_.coordinates.size());
    VectorX position(coordinates), velocity = VectorX::Zero(coordinates);
    if (desired_.rows > 0) {
      position = desired_.position.row(0);
      velocity = desired_.velocity.row(0);
    } else if (!good(start_position(mechanism_, trajectory_, position))) {
      return false;
    }
    const InitialError& error = controller_.initial_error;
    if (error.tool && !good(displace_tool(mechanism_, trajectory_, *error.tool, error.angle, position))) return false;
    for (const CoordinateValue& joint : error.joints) position[joint.coordinate] += joint.value;
    if (!good(plant_->start(0, position, velocity))) return false;
    if (mechanism_.actuators.empty() && controller_.type != ControllerType::none)
      return good({MotionStatus::mismatch, 0, under_actuated(0, plant_->freedoms()), {}});
    if (!good(law_.start(plant_->position(), plant_->velocity(), basis()))) return false;
    long rows = 0;
    for (std::size_t e = 1; e < events_.size(); ++e) rows += events_[e].tick ? 2 : events_[e].on_sample ? 0 : 1;
    record_.shape(samples_, trajectory_.about, result_);
    record_.shape(rows, trajectory_.about, between_.rows);
    return true;
  }

  /// What gains follow from: the desired motion at moments of its own, so that they do not depend on what is sampled.
  GainBasis basis() const {
    GainBasis basis{VectorX::Zero(efforts_.size()), {}};
    if (!needs_desired_motion(controller_)) return basis;
    constexpr int moments = 40, finer = 10;
    std::vector<double> times;
    for (int k = 0; k <= moments * finer; ++k) times.push_back(duration_of(trajectory_) * k / (moments * finer));
    const DesiredMotion motion = desired_motion(mechanism_, trajectory_, times);
    for (Eigen::Index k = 0; k < motion.rows; ++k) {
      basis.peak_acceleration =
          basis.peak_acceleration.cwiseMax(actuated(motion.acceleration.row(k).transpose()).cwiseAbs());
      if (k % finer == 0) basis.along.push_back(state_of(motion, k));
    }
    return basis;
  }

  MotionOutcome advance(double time) {
    return course_ ? plant_->advance(time, *course_) : plant_->advance(time, efforts_);
  }

  void follow_course(std::size_t e) {
    efforts_ = course_->at(events_[e].time);
    saturated_ = course_->at_limit(events_[e].time);
    if (e > 0) variation_ += course_->variation(events_[e - 1].time, events_[e].time);
  }

  /// On to the event, and through it. @return false if the run ends here
  bool pass(std::size_t e, long& done_rows) {
    const Event& event = events_[e];
    if (e > 0 && !good(advance(event.time))) return false;
    if (course_) follow_course(e);
    if (!(max_abs(plant_->velocity()) < enormous) || !(max_abs(plant_->position()) < enormous))
      return good(numbers_overflow(event.time, "the motion"));
    if (options_.progress) options_.progress(static_cast<double>(e) / static_cast<double>(events_.size()));
    const bool looks = inverts(controller_) && (event.tick || !event.on_sample);
    if (looks && !good(watch_.look(event.time, plant_->position(), plant_->velocity()))) return false;
    if (!event.tick && !event.on_sample) write(between_.rows, between_.add(event.sample), e);
    if (event.tick) {
      if (e > 0) write(between_.rows, between_.add(event.sample), e);
      const DesiredState wanted = state_of(desired_, static_cast<Eigen::Index>(e));
      sensor_.read(actuated(plant_->position()), actuated(plant_->velocity()), actuated(wanted.velocity));
      if (!good(law_.command(event.time, wanted, sensor_.position(), sensor_.velocity()))) return false;
      if (!law_.efforts().allFinite()) return good(numbers_overflow(event.time, "the torque"));
      if (e > 0) variation_ += (law_.efforts() - efforts_).cwiseAbs();
      efforts_ = law_.efforts();
      saturated_ = law_.at_limit();
      if (e > 0 && !event.on_sample) write(between_.rows, between_.add(event.sample), e);
    }
    if (!event.on_sample) return true;
    write(result_, event.sample, e);
    done_rows = event.sample + 1;
    return true;
  }

  void write(Result& result, long row, std::size_t e) {
    record_.write(plant_->observe(efforts_), {variation_, saturated_}, events_[e].time, static_cast<Eigen::Index>(e),
                  row, result);
  }

  /// An error larger than all that the coordinate was to move, or than a radian, says that the controller does not lead it.
  void note_lost_track() {
    if (result_.tracking_error.size() == 0 || controller_.type == ControllerType::none) return;
    for (const int c : mechanism_.actuators) {
      const double range = max_coefficient(desired_.position.col(c)) - min_coefficient(desired_.position.col(c));
      const Eigen::Index worst = max_index(result_.tracking_error.col(c).cwiseAbs());
      const double error = std::abs(result_.tracking_error(worst, c));
      const double start = std::abs(result_.tracking_error(0, c));
      const Coordinate& coordinate = mechanism_.coordinates[static_cast<std::size_t>(c)];
      const double unit = is_length(mechanism_, c) ? characteristic_length(mechanism_) : 1;
      const double bound = range > 1e-9 * unit ? std::min(range, unit) : 0.1 * unit;
      if (!(error > std::max(bound, 2 * start))) continue;
      const auto text_of = [&](double value) { return coordinate_text(mechanism_, c, value); };
      result_.outcome.notes.push_back(lost_track(coordinate.name, text_of(error), text_of(range), result_.time[worst]));
    }
  }

  /// Of a sliding variable −(ė + λ e), what its rate and its position have.
  void add_round_off() {
    set_round_off(result_, plant_->term_sizes(), plant_->term_sizes_over_mobility());
    const auto count = static_cast<Eigen::Index>(law_.sliding().size());
    result_.round_off.sliding_variable.setZero(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const int c = law_.sliding()[static_cast<std::size_t>(i)];
      result_.round_off.sliding_variable[i] =
          result_.round_off.velocity[c] + law_.sliding_lambda()[i] * result_.round_off.position[c];
    }
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const Controller& controller_;
  ControlLaw law_;
  Sensor sensor_;
  SingularityWatch watch_;
  ControlOptions options_;
  ControlRecord record_;
  std::optional<EffortCourse> course_;  ///< of efforts that are not the controller's samples
  std::optional<Plant> plant_;
  long samples_ = 0;
  std::vector<Event> events_;
  DesiredMotion desired_;  ///< a row per event
  VectorX efforts_, variation_, saturated_;
  Result result_;
  BetweenSamples between_;
  MotionOutcome outcome_;
};

}  // namespace

Result control(const Mechanism& mechanism, const Trajectory& trajectory, const Controller& controller,
               const ControlOptions& options) {
  check_timing(trajectory);
  if (has_passing_payloads(mechanism))
    throw std::invalid_argument("a controlled run needs payloads that are always there");
  if (!(controller.period > 0)) throw std::invalid_argument("a controller needs a positive period");
  if (options.most_steps < 0) throw std::invalid_argument("a run cannot have a negative number of steps");
  if (!(options.settle >= 0)) throw std::invalid_argument("the time to settle cannot be negative");
  const TimedTrajectory timed = time_law(mechanism, trajectory);
  Result result;
  result.outcome = timed.outcome;
  if (timed.outcome.status != MotionStatus::done) return result;
  result = ControlRun(mechanism, timed.trajectory, controller, options).run();
  result.found_law = timed.found;
  result.found_corridor = timed.corridor;
  return result;
}

}  // namespace balance
