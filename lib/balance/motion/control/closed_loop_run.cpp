#include "balance/motion/control/closed_loop_run.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/overdetermined_system.hpp"
#include "balance/foundation/numerics/regularity.hpp"
#include "balance/mechanics/dynamics/forward_dynamics.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/results/spring_travel.hpp"
#include "balance/mechanics/trajectory/adaptation.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/control/control_law.hpp"
#include "balance/motion/control/desired_motion.hpp"
#include "balance/motion/control/extended_controller.hpp"
#include "balance/motion/control/payload_impact.hpp"
#include "balance/motion/control/plant.hpp"
#include "balance/motion/control/sensor.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/payload_events.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace balance::control {

// States of a controlled run as rows of a RunResult.

/// State of the controller at one time.
struct ControllerState {
  const VectorX& variation;  ///< sum of all absolute changes of the efforts so far, per actuator
  const VectorX& saturated;  ///< 1 where the limit is active, per actuator; may be empty
};

class ClosedLoopRecorder {
 public:
  /// @param desired may be filled in later, but must not move; `law` must be started before rows are written
  ClosedLoopRecorder(const Mechanism& mechanism, const ControlLaw& law, const trajectory::MotionTable& desired)
      : mechanism_(mechanism), law_(law), desired_(desired) {}

  /// Sets names and allocates rows. Omits quantities that need a desired motion if that motion is not known.
  void allocate_rows(long rows, const Vector3& about, RunResult& result) const;

  /// @param event row of the desired motion
  void write_row(const Sample& sample, const ControllerState& state, double time, Eigen::Index event, long row,
                 RunResult& result);

 private:
  void write_tracking_errors(Eigen::Index event);

  const Mechanism& mechanism_;
  const ControlLaw& law_;
  const trajectory::MotionTable& desired_;
  std::optional<results::ResultRecorder> recorder_;
  Sample sample_;
};

/// Detects configurations in which the actuators do not determine the motion, even if they are passed between two
/// checks.
class ActuationMonitor {
 public:
  /// @param mechanism must outlive the monitor
  explicit ActuationMonitor(const Mechanism& mechanism);

  /// Checks a state. Call in order of time, with small changes between calls.
  /// @param position, velocity per mechanism coordinate
  /// @return done; actuation_singularity if loop closures and actuated coordinates together do not determine the
  ///        motion, or do not on the straight line from their matrix at the last check. Always done with fewer
  ///        actuators than freedoms.
  MotionOutcome check(double time, const VectorX& position, const VectorX& velocity);

 private:
  MatrixX matrix();

  const Mechanism& mechanism_;
  dynamics::ForwardDynamics dynamics_;
  numerics::RankMonitor rank_monitor_;
  bool has_previous_ = false;
};

namespace {

/// A time of the run: a sample of the result, a sample of the controller, or both. If it is neither, it only adds to
/// the accuracy of figures.
struct SampleEvent {
  double time;
  long sample;  ///< the first sample at or after it
  bool on_sample;
  bool tick;
};

std::vector<SampleEvent> list_events(double step, long samples, const Controller& controller) {
  std::vector<SampleEvent> events;
  const double end = step * static_cast<double>(samples - 1), time_tolerance = 1e-9 * std::min(step, controller.period);
  long tick = controller.is_sampled() ? 0 : -1;
  for (long k = 0; k < samples; ++k) {
    const double time = k == samples - 1 ? end : step * static_cast<double>(k);
    for (; tick >= 0; ++tick) {
      const double tick_time = controller.period * static_cast<double>(tick);
      if (tick_time >= time - time_tolerance) break;
      events.push_back({tick_time, k, false, true});
    }
    const bool coincides =
        tick >= 0 && std::abs(controller.period * static_cast<double>(tick) - time) <= time_tolerance;
    // At the very end, a new torque would have no effect.
    events.push_back({time, k, true, coincides && k < samples - 1});
    if (coincides) ++tick;
  }
  return events;
}

/// Adds times at which the motion is not smooth and figures may have their maxima.
/// @param knots increasing
std::vector<SampleEvent> insert_knot_times(std::vector<SampleEvent> events, const std::vector<double>& knots) {
  std::vector<SampleEvent> out;
  const double time_tolerance = 1e-9 * (events.size() > 1 ? events[1].time - events[0].time : 1);
  auto knot = knots.begin();
  const auto end = knots.end();
  for (const SampleEvent& event : events) {
    for (; knot != end && *knot < event.time - time_tolerance; ++knot)
      if (!out.empty() && *knot > out.back().time + time_tolerance) out.push_back({*knot, event.sample, false, false});
    out.push_back(event);
  }
  return out;
}

/// Adds times between events that are too far from each other for accurate figures.
/// @param steps minimum number of steps of the whole run
std::vector<SampleEvent> insert_figure_samples(const std::vector<SampleEvent>& events, long steps) {
  std::vector<SampleEvent> out;
  const double max_interval = events.back().time / static_cast<double>(steps);
  for (const SampleEvent& event : events) {
    const double last = out.empty() ? event.time : out.back().time, interval = event.time - last;
    const auto step_count = static_cast<int>(std::ceil(interval / max_interval - 1e-9));
    for (int i = 1; i < step_count; ++i) out.push_back({last + interval * i / step_count, event.sample, false, false});
    out.push_back(event);
  }
  return out;
}

DesiredState desired_state_at(const trajectory::MotionTable& motion, Eigen::Index row) {
  return {motion.position.row(row), motion.velocity.row(row), motion.acceleration.row(row)};
}

/// The mechanism in every interval between payload changes.
std::vector<Mechanism> list_phases(const Mechanism& mechanism, const model::PayloadIntervals& intervals) {
  std::vector<Mechanism> phases;
  for (int k = 0; k < intervals.count(); ++k) phases.push_back(mechanism_in_interval(mechanism, intervals, k));
  return phases;
}

/// What the controller takes the mechanism for in these intervals.
std::vector<Mechanism> list_model_phases(const Controller& controller, const std::vector<Mechanism>& truth,
                                         const model::PayloadIntervals& intervals) {
  if (!controller.model) return truth;
  std::vector<Mechanism> phases;
  for (int k = 0; k < intervals.count(); ++k)
    phases.push_back(
        mechanism_at_time(*controller.model, k == 0 ? 0 : intervals.switch_times()[static_cast<std::size_t>(k - 1)]));
  return phases;
}

/// "cargo is taken up at 0.2 s at rest: the impact takes 0.03 J"
std::string describe_impact(const Mechanism& mechanism, const model::PayloadIntervals& intervals, int interval,
                            double time, double energy_loss) {
  std::string text;
  for (std::size_t a = 0; a < mechanism.attachments.size(); ++a) {
    const bool is_there = intervals.is_attached(a, interval);
    if (is_there == intervals.is_attached(a, interval - 1)) continue;
    text += fmt::format("{}payload '{}' is {} at {:.4g} s", text.empty() ? "" : ", ", mechanism.attachments[a].name,
                        is_there ? "taken up" : "set down", time);
  }
  if (energy_loss > 0)
    text += fmt::format("; what was at rest comes along at once: the impact takes {:.4g} J", energy_loss);
  return text;
}

constexpr double state_overflow_limit = 1e100;  // of rates and positions: beyond this, results are not finite

std::string tracking_loss_text(const std::string& name, const std::string& error, const std::string& range,
                               double time) {
  return fmt::format(
      "the controller does not track {}: the error grows to {} (at t = {:.6g} s), while the motion's range is {}", name,
      error, time, range);
}

class ClosedLoopRun {
 public:
  ClosedLoopRun(const Mechanism& mechanism, const Trajectory& trajectory, const Controller& controller,
                const ClosedLoopOptions& options)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        controller_(controller),
        intervals_(mechanism, find_trajectory_duration(trajectory) + options.hold_time),
        phases_(list_phases(mechanism, intervals_)),
        model_phases_(list_model_phases(controller, phases_, intervals_)),
        law_(phases_[0], controller, model_phases_[0]),
        sensor_(controller.measurement, controller.period),
        actuation_monitor_(phases_[0]),
        options_(options),
        recorder_(mechanism, law_, desired_),
        efforts_(VectorX::Zero(static_cast<Eigen::Index>(mechanism.actuators.size()))),
        variation_(efforts_) {
    const double duration = find_trajectory_duration(trajectory),
                 step = duration / static_cast<double>(trajectory.samples - 1);
    if (!(duration >= min_closed_loop_duration)) throw std::invalid_argument("the trajectory takes less than 1e-12 s");
    const double hold_steps = std::ceil(options.hold_time / step - 1e-9),
                 steps = static_cast<double>(trajectory.samples) + hold_steps;
    if (controller.is_continuous()) effort_profile_.emplace(controller.efforts, controller.torque_limit);
    const double sample_count = steps +
                                (controller.is_sampled() ? (duration + options.hold_time) / controller.period : 0) +
                                (effort_profile_ ? static_cast<double>(effort_profile_->knots().size()) : 0);
    if (!(sample_count <= max_closed_loop_samples))
      throw std::invalid_argument("the run has more than " +
                                  std::to_string(static_cast<long>(max_closed_loop_samples)) +
                                  " samples of controller and result together");
    samples_ = trajectory.samples + static_cast<long>(hold_steps);
    switch_tolerance_ = 2e-9 * step;  // events nearer than half of it count as one
    std::vector<SampleEvent> events = list_events(step, samples_, controller);
    if (effort_profile_) events = insert_knot_times(std::move(events), effort_profile_->knots());
    events = insert_knot_times(std::move(events), intervals_.switch_times());
    std::vector<double> move_times = list_move_times(trajectory.courses);
    std::sort(move_times.begin(), move_times.end());
    events = insert_knot_times(std::move(events), move_times);
    // figures of a continuous controller cannot rely on its samples
    events_ =
        insert_figure_samples(events, effort_profile_ ? 5 * trajectory::min_time_steps : trajectory::min_time_steps);
    plant_options_.dynamics.preferred = mechanism.actuators;
    const auto default_steps = 500'000 + 50 * static_cast<long>(events.size());
    plant_options_.max_steps = options.max_steps > 0 ? options.max_steps : default_steps;
    plant_.emplace(phases_[0], plant_options_, trajectory.about);
  }

  RunResult run() {
    std::vector<double> times;
    for (const SampleEvent& event : events_) times.push_back(event.time);
    desired_ = compute_desired_motion(mechanism_, trajectory_, times);
    const bool has_desired_motion = desired_.outcome.status == MotionStatus::done;
    if (!has_desired_motion && needs_desired_motion(controller_)) return make_rejected_result();
    if (!initialise()) return make_rejected_result();
    long done_rows = 0;
    for (std::size_t e = 0; e < events_.size(); ++e) {
      if (!advance_to_event(e, done_rows)) break;
    }
    std::erase_if(result_.payload_events, [&](const results::PayloadEvent& change) {
      return change.effort_after.size() != efforts_.size();  // the run ended there
    });
    if (done_rows < samples_) {
      truncate_rows(done_rows, result_);
      truncate_rows(static_cast<long>(intermediate_samples_.next_sample.size()), intermediate_samples_.rows);
    }
    add_round_off();
    if (result_.time.size() >= 2) {
      add_metrics(result_, intermediate_samples_);
      add_adaptation_moves(mechanism_, trajectory_.courses, intermediate_samples_, result_);
      if (const auto overflow = find_overflow(result_, intermediate_samples_, mechanism_);
          overflow && outcome_.status == MotionStatus::done)
        outcome_ = *overflow;
    }
    clear_round_off(result_);
    result_.outcome = outcome_;
    keep_plant_notes();
    result_.outcome.notes = plant_notes_;
    result_.outcome.notes.insert(result_.outcome.notes.end(), payload_notes_.begin(), payload_notes_.end());
    simulation::add_payload_notes(mechanism_, events_.back().time, result_);
    const std::vector<std::string>& controller_notes = law_.notes();
    result_.outcome.notes.insert(result_.outcome.notes.end(), controller_notes.begin(), controller_notes.end());
    if (result_.time.size() >= 2) {
      const std::string note = check_sampling_density(result_, intermediate_samples_);
      if (!note.empty()) result_.outcome.notes.push_back(note);
    }
    results::add_travel_notes(mechanism_, result_);
    if (!has_desired_motion)
      result_.outcome.notes.push_back("no errors are reported, because the desired motion does not exist: " +
                                      desired_.outcome.reason);
    warn_of_tracking_loss();
    if (result_.time.size() > 0 && is_inverse_dynamics_based(controller_))
      record_torque_distribution(mechanism_, intermediate_samples_.rows, intermediate_samples_.next_sample.size(),
                                 results::EffortOrigin::controller, result_);
    result_.intermediate = std::make_shared<const results::IntermediateSamples>(std::move(intermediate_samples_));
    return std::move(result_);
  }

 private:
  RunResult make_rejected_result() const {
    RunResult result;
    result.outcome = outcome_.status == MotionStatus::unsolved ? desired_.outcome : outcome_;
    return result;
  }

  bool is_successful(MotionOutcome outcome) {
    outcome_ = std::move(outcome);
    return outcome_.status == MotionStatus::done;
  }

  VectorX actuated(const VectorX& values) const {
    VectorX actuated_values(efforts_.size());
    for (Eigen::Index a = 0; a < actuated_values.size(); ++a)
      actuated_values[a] = values[mechanism_.actuators[static_cast<std::size_t>(a)]];
    return actuated_values;
  }

  /// Puts the mechanism at its start and allocates the rows.
  bool initialise() {
    const auto coordinates = static_cast<Eigen::Index>(mechanism_.coordinates.size());
    VectorX position(coordinates), velocity = VectorX::Zero(coordinates);
    if (desired_.rows > 0) {
      position = desired_.position.row(0);
      velocity = desired_.velocity.row(0);
    } else {  // the trajectory cannot be followed
      const std::vector<CoordinateValue> start = simulation::start_coordinates(mechanism_, trajectory_);
      if (start.empty()) return is_successful({MotionStatus::unreachable, 0, "the start pose cannot be reached", {}});
      for (const CoordinateValue& joint : start) position[joint.coordinate] = joint.value;
    }
    const study::InitialError& error = controller_.initial_error;
    if (error.tool && !is_successful(displace_tool(mechanism_, trajectory_, *error.tool, error.angle, position)))
      return false;
    for (const CoordinateValue& joint : error.joints) position[joint.coordinate] += joint.value;
    if (!is_successful(plant_->start(0, position, velocity))) return false;
    if (mechanism_.actuators.empty() && controller_.type != study::ControllerType::none)
      return is_successful(
          {MotionStatus::mismatch, 0, trajectory::describe_under_actuation(0, plant_->freedoms()), {}});
    if (!is_successful(law_.start(plant_->position(), plant_->velocity(), make_gain_basis()))) return false;
    auto rows = static_cast<long>(intervals_.switch_times().size());
    for (std::size_t e = 1; e < events_.size(); ++e) rows += events_[e].tick ? 2 : events_[e].on_sample ? 0 : 1;
    recorder_.allocate_rows(samples_, trajectory_.about, result_);
    recorder_.allocate_rows(rows, trajectory_.about, intermediate_samples_.rows);
    return true;
  }

  /// Basis of gains: the desired motion at times of its own, so that gains do not depend on the sampling.
  GainDesignMotion make_gain_basis() const {
    GainDesignMotion basis{VectorX::Zero(efforts_.size()), {}};
    if (!needs_desired_motion(controller_)) return basis;
    constexpr int gain_samples = 40, gain_sample_refinement = 10;
    std::vector<double> times;
    for (int k = 0; k <= gain_samples * gain_sample_refinement; ++k)
      times.push_back(find_trajectory_duration(trajectory_) * k / (gain_samples * gain_sample_refinement));
    const trajectory::MotionTable motion = compute_desired_motion(mechanism_, trajectory_, times);
    for (Eigen::Index k = 0; k < motion.rows; ++k) {
      basis.peak_acceleration =
          basis.peak_acceleration.cwiseMax(actuated(motion.acceleration.row(k).transpose()).cwiseAbs());
      if (k % gain_sample_refinement == 0) basis.along.push_back(desired_state_at(motion, k));
    }
    return basis;
  }

  MotionOutcome advance(double time) {
    return effort_profile_ ? plant_->advance(time, *effort_profile_) : plant_->advance(time, efforts_);
  }

  void sample_effort_profile(std::size_t e) {
    efforts_ = effort_profile_->evaluate(events_[e].time);
    saturated_ = effort_profile_->saturation(events_[e].time);
    if (e > 0) variation_ += effort_profile_->total_variation(events_[e - 1].time, events_[e].time);
  }

  void keep_plant_notes() {
    for (const std::string& note : plant_->notes())
      if (std::find(plant_notes_.begin(), plant_notes_.end(), note) == plant_notes_.end()) plant_notes_.push_back(note);
  }

  /// Lists what changes at the beginning of the present interval, before the rates jump.
  void add_payload_events(double time, const VectorX& position, const VectorX& velocity) {
    const std::vector<results::BodyMotion> motions =
        results::body_motions_at(mechanism_, position, velocity, VectorX::Zero(position.size()));
    const auto payload_motion = [&](std::size_t a) {
      const Attachment& payload = mechanism_.attachments[a];
      const results::BodyMotion& body = motions[static_cast<std::size_t>(payload.body)];
      return simulation::PayloadMotion{body.point_velocity(payload.position).norm(), body.angular_velocity.norm()};
    };
    simulation::add_payload_changes(mechanism_, intervals_, {time, interval_ - 1, interval_, efforts_, VectorX()},
                                    payload_motion, result_);
  }

  /// Takes up and sets down payloads: the rates jump, and a plant with other masses goes on. Both sides are recorded.
  bool change_payloads(std::size_t e) {
    const double time = events_[e].time;
    write(intermediate_samples_.rows, intermediate_samples_.add(events_[e].sample), e);
    const int interval = ++interval_;
    const Mechanism& after = phases_[static_cast<std::size_t>(interval)];
    Mechanism before = after;  // without what is taken up
    bool takes_up = false;
    for (std::size_t a = 0; a < before.attachments.size(); ++a) {
      if (!intervals_.is_attached(a, interval) || intervals_.is_attached(a, interval - 1)) continue;
      model::detach(before.attachments[a]);
      takes_up = true;
    }
    const VectorX position = plant_->position();
    VectorX velocity = plant_->velocity();
    const std::size_t first_event = result_.payload_events.size();
    add_payload_events(intervals_.switch_times()[static_cast<std::size_t>(interval) - 1], position, velocity);
    double energy_loss = 0;
    if (takes_up) {
      PayloadImpact impact = take_up_payloads(before, after, time, position, velocity);
      if (!is_successful(impact.outcome)) return false;
      velocity = std::move(impact.velocity);
      energy_loss = impact.energy_loss;
    }
    for (std::size_t k = first_event; k < result_.payload_events.size(); ++k)
      result_.payload_events[k].impact_loss = result_.payload_events[k].taken_up ? energy_loss : 0;
    payload_notes_.push_back(describe_impact(mechanism_, intervals_, interval, time, energy_loss));
    keep_plant_notes();
    past_term_sizes_.emplace_back(plant_->term_sizes(), plant_->term_sizes_over_mobility());
    plant_options_.max_steps = std::max(1L, plant_options_.max_steps - plant_->cost().steps);
    plant_.emplace(after, plant_options_, trajectory_.about);
    law_.change_model(time, model_phases_[static_cast<std::size_t>(interval)]);
    return is_successful(plant_->start(time, position, velocity));
  }

  /// Advances to the event and processes it. @return false if the run ends here
  bool advance_to_event(std::size_t e, long& done_rows) {
    const SampleEvent& event = events_[e];
    if (e > 0 && !is_successful(advance(event.time))) return false;
    if (effort_profile_) sample_effort_profile(e);
    const std::vector<double>& switches = intervals_.switch_times();
    while (static_cast<std::size_t>(interval_) < switches.size() &&
           event.time >= switches[static_cast<std::size_t>(interval_)] - switch_tolerance_)
      if (!change_payloads(e)) return false;
    if (!(numerics::max_abs(plant_->velocity()) < state_overflow_limit) ||
        !(numerics::max_abs(plant_->position()) < state_overflow_limit))
      return is_successful(trajectory::make_overflow_outcome(event.time, "the motion"));
    if (options_.progress) options_.progress(static_cast<double>(e) / static_cast<double>(events_.size()));
    const bool checks_actuation = is_inverse_dynamics_based(controller_) && (event.tick || !event.on_sample);
    if (checks_actuation &&
        !is_successful(actuation_monitor_.check(event.time, plant_->position(), plant_->velocity())))
      return false;
    if (!event.tick && !event.on_sample) write(intermediate_samples_.rows, intermediate_samples_.add(event.sample), e);
    if (event.tick) {
      if (e > 0) write(intermediate_samples_.rows, intermediate_samples_.add(event.sample), e);
      const DesiredState desired = desired_state_at(desired_, static_cast<Eigen::Index>(e));
      sensor_.read(actuated(plant_->position()), actuated(plant_->velocity()), actuated(desired.velocity));
      if (!is_successful(law_.compute_efforts(event.time, desired, sensor_.position(), sensor_.velocity())))
        return false;
      if (!law_.efforts().allFinite())
        return is_successful(trajectory::make_overflow_outcome(event.time, "the torque"));
      if (e > 0) variation_ += (law_.efforts() - efforts_).cwiseAbs();
      efforts_ = law_.efforts();
      saturated_ = law_.saturation();
      if (e > 0 && !event.on_sample) write(intermediate_samples_.rows, intermediate_samples_.add(event.sample), e);
    }
    for (results::PayloadEvent& change : result_.payload_events)
      if (change.effort_after.size() == 0) change.effort_after = efforts_;
    if (!event.on_sample) return true;
    write(result_, event.sample, e);
    done_rows = event.sample + 1;
    return true;
  }

  void write(RunResult& result, long row, std::size_t e) {
    recorder_.write_row(plant_->observe(efforts_), {variation_, saturated_}, events_[e].time,
                        static_cast<Eigen::Index>(e), row, result);
  }

  /// Adds a note if the controller loses a coordinate: the error exceeds the range of its motion, or a radian.
  void warn_of_tracking_loss() {
    if (result_.tracking_error.size() == 0 || controller_.type == study::ControllerType::none) return;
    for (const int c : mechanism_.actuators) {
      const double range =
          numerics::max_coefficient(desired_.position.col(c)) - numerics::min_coefficient(desired_.position.col(c));
      const Eigen::Index worst = numerics::max_index(result_.tracking_error.col(c).cwiseAbs());
      const double error = std::abs(result_.tracking_error(worst, c));
      const double start = std::abs(result_.tracking_error(0, c));
      const Coordinate& coordinate = mechanism_.coordinates[static_cast<std::size_t>(c)];
      const double unit = is_length_coordinate(mechanism_, c) ? characteristic_length(mechanism_) : 1;
      const double bound = range > 1e-9 * unit ? std::min(range, unit) : 0.1 * unit;
      if (!(error > std::max(bound, 2 * start))) continue;
      const auto text_of = [&](double value) { return format_coordinate(mechanism_, c, value); };
      result_.outcome.notes.push_back(
          tracking_loss_text(coordinate.name, text_of(error), text_of(range), result_.time[worst]));
    }
  }

  /// Sets the round-off. For a sliding variable −(ė + λ e) it is composed of that of its rate and its position.
  void add_round_off() {
    results::TermMagnitudes sizes = plant_->term_sizes(), over_mobility = plant_->term_sizes_over_mobility();
    for (const auto& [past, past_over_mobility] : past_term_sizes_) {
      sizes.raise_to(past, 1);
      over_mobility.raise_to(past_over_mobility, 1);
    }
    set_round_off(result_, sizes, over_mobility);
    result_.round_off.sliding_variable = law_.sliding_round_off(result_.round_off.position, result_.round_off.velocity);
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const Controller& controller_;
  model::PayloadIntervals intervals_;
  std::vector<Mechanism> phases_, model_phases_;  ///< per interval: the mechanism, and the controller's model of it
  int interval_ = 0;                              ///< the present one
  double switch_tolerance_ = 0;                   ///< [s]
  ControlLaw law_;
  Sensor sensor_;
  ActuationMonitor actuation_monitor_;
  ClosedLoopOptions options_;
  ClosedLoopRecorder recorder_;
  std::optional<EffortProfile> effort_profile_;  ///< of efforts that are not sampled by the controller
  PlantOptions plant_options_;
  std::optional<Plant> plant_;
  std::vector<std::pair<results::TermMagnitudes, results::TermMagnitudes>> past_term_sizes_;  ///< of earlier plants
  std::vector<std::string> plant_notes_, payload_notes_;
  long samples_ = 0;
  std::vector<SampleEvent> events_;
  trajectory::MotionTable desired_;  ///< one row per event
  VectorX efforts_, variation_, saturated_;
  RunResult result_;
  results::IntermediateSamples intermediate_samples_;
  MotionOutcome outcome_;
};

}  // namespace

RunResult simulate_closed_loop(const Mechanism& mechanism, const Trajectory& trajectory, const Controller& controller,
                               const ClosedLoopOptions& options) {
  check_timing(trajectory);
  if (!trajectory.adaptations.empty()) {
    const trajectory::AdaptedMotion adapted = model_adaptations(mechanism, trajectory);
    return simulate_closed_loop(adapted.mechanism, adapted.trajectory,
                                extend_controller(controller, mechanism, trajectory), options);
  }
  if (!(controller.period > 0)) throw std::invalid_argument("a controller needs a positive period");
  if (options.max_steps < 0) throw std::invalid_argument("a run cannot have a negative number of steps");
  if (!(options.hold_time >= 0)) throw std::invalid_argument("the time to settle cannot be negative");
  const time_optimal::ResolvedTrajectory resolved = time_optimal::resolve_trajectory(mechanism, trajectory);
  RunResult result;
  result.outcome = resolved.outcome;
  if (resolved.outcome.status != MotionStatus::done) return result;
  result = ClosedLoopRun(mechanism, resolved.trajectory, controller, options).run();
  result.optimised_law = resolved.optimised_law;
  result.corridor_result = resolved.corridor;
  return result;
}

void ClosedLoopRecorder::allocate_rows(long rows, const Vector3& about, RunResult& result) const {
  name_columns(mechanism_, result);
  const bool has_desired_motion = desired_.outcome.status == MotionStatus::done;
  for (const SlidingQuantity& quantity : law_.sliding_quantities()) {
    result.sliding_names.push_back(quantity.name);
    result.sliding_units.push_back(quantity.is_length ? "m/s" : "rad/s");
  }
  result.moment_reference = about;
  results::resize_arrays(mechanism_, rows, {.control = true, .tracking = has_desired_motion}, result);
}

void ClosedLoopRecorder::write_row(const Sample& sample, const ControllerState& state, double time, Eigen::Index event,
                                   long row, RunResult& result) {
  if (!recorder_) recorder_.emplace(result);
  sample_ = sample;
  sample_.time = time;
  sample_.torque_variation = state.variation;
  sample_.saturation = state.saturated;
  if (sample_.saturation.size() == 0) sample_.saturation.setZero(sample_.effort.size());
  if (result.tracking_error.size() > 0) write_tracking_errors(event);
  recorder_->write(sample_, row, result);
}

/// Computes the errors with respect to the desired motion.
void ClosedLoopRecorder::write_tracking_errors(Eigen::Index event) {
  Sample& s = sample_;
  s.desired_position = desired_.position.row(event);
  s.tracking_error = s.desired_position - s.position;
  const auto& motors = mechanism_.actuators;
  for (std::size_t i = 0; i < mechanism_.coordinates.size(); ++i) {
    // Whole turns of a coordinate without a motor do not count: it is computed from poses, not driven.
    double& error = s.tracking_error[static_cast<Eigen::Index>(i)];
    if (mechanism_.coordinates[i].kind == CoordinateKind::angle &&
        std::find(motors.begin(), motors.end(), static_cast<int>(i)) == motors.end())
      error = std::remainder(error, 2 * std::numbers::pi);
  }
  s.sliding_variable = law_.sliding_variables(desired_state_at(desired_, event), s.position, s.velocity);
  if (!mechanism_.tool) return;
  s.desired_tool_position = desired_.tool_position.row(event);
  s.tool_error = s.desired_tool_position - s.tool_position;
  if (mechanism_.space == SpaceKind::planar) {
    s.tool_angle_error = desired_.tool_angle[event] - s.tool_angle;
    return;
  }
  const Matrix3 rotation_error = desired_.tool_rotation[static_cast<std::size_t>(event)] * s.tool_rotation.transpose();
  const Eigen::Vector4d quaternion = quaternion_of(rotation_error);
  s.tool_angle_error = 2 * elementary::atan2(quaternion.tail<3>().norm(), std::abs(quaternion[0]));
}

ActuationMonitor::ActuationMonitor(const Mechanism& mechanism)
    : mechanism_(mechanism), dynamics_(mechanism, {.preferred = mechanism.actuators}) {}

/// Closures above actuated coordinates, lengths in characteristic lengths. Has full column rank if these determine the
/// motion.
MatrixX ActuationMonitor::matrix() {
  const dynamics::TreeEquation equation = dynamics_.tree_equation();
  const double length = characteristic_length(mechanism_);
  MatrixX out(equation.jacobian.rows() + equation.input.cols(), equation.jacobian.cols());
  out << equation.jacobian, equation.input.transpose();
  const std::vector<CoordinateId>& tree_coordinates = dynamics_.tree();
  for (std::size_t c = 0; c < tree_coordinates.size(); ++c)
    if (mechanism_.coordinates[static_cast<std::size_t>(tree_coordinates[c])].kind == CoordinateKind::length)
      out.col(static_cast<Eigen::Index>(c)) *= length;
  return out;
}

MotionOutcome ActuationMonitor::check(double time, const VectorX& position, const VectorX& velocity) {
  MotionOutcome outcome = dynamics_.set_state(time, position, velocity);
  if (outcome.status != MotionStatus::done) return outcome;
  if (static_cast<int>(mechanism_.actuators.size()) < dynamics_.freedoms()) return outcome;
  const bool is_regular = rank_monitor_.factorise(matrix()) > numerics::singular_pivot_threshold;
  const bool has_crossed_singularity = has_previous_ && is_regular && rank_monitor_.loses_rank_since_stored();
  rank_monitor_.store();
  has_previous_ = true;
  if (is_regular && !has_crossed_singularity) return outcome;
  return {MotionStatus::actuation_singularity,
          time,
          trajectory::format_time_prefix(time) +
              "actuation singularity: the mechanism reached a configuration in which the actuators do not determine "
              "its motion",
          {}};
}

}  // namespace balance::control
