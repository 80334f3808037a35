#include "balance/study/control.hpp"

#include "balance/base/rotation.hpp"
#include "balance/control/control_law.hpp"
#include "balance/control/desired_motion.hpp"
#include "balance/control/plant.hpp"
#include "balance/control/sensor.hpp"
#include "balance/control/singularity_watch.hpp"
#include "balance/study/metrics.hpp"
#include "balance/study/result_columns.hpp"
#include "balance/study/result_rows.hpp"
#include "balance/study/round_off.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance {

namespace {

/// A moment at which something happens: a sample of the result, a sample of the controller, or both.
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

void put(Samples& array, long row, const Vector3& v, int first, int count) {
  for (int i = 0; i < count; ++i) array(row, first + i) = v[count == 1 ? 2 : i];
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
        plant_(mechanism, {.dynamics = {.preferred = mechanism.actuators}}, trajectory.about),
        efforts_(VectorX::Zero(static_cast<Eigen::Index>(mechanism.actuators.size()))),
        variation_(efforts_) {
    const double duration = duration_of(trajectory), step = duration / static_cast<double>(trajectory.samples - 1);
    const double extra = std::ceil(options.settle / step - 1e-9),
                 steps = static_cast<double>(trajectory.samples) + extra;
    if (!(steps + (duration + options.settle) / controller.period <= most_control_steps))
      throw std::invalid_argument("the run has more than " + std::to_string(static_cast<long>(most_control_steps)) +
                                  " samples of controller and result together");
    samples_ = trajectory.samples + static_cast<long>(extra);
    events_ = list_events(step, samples_, controller);
  }

  Result run() {
    std::vector<double> times;
    for (const Event& event : events_) times.push_back(event.time);
    desired_ = desired_motion(mechanism_, trajectory_, times);
    if (desired_.outcome.status != MotionStatus::done || !begin()) return refused();
    long done_rows = 0;
    for (std::size_t e = 0; e < events_.size(); ++e) {
      if (!pass(e, done_rows)) break;
    }
    if (done_rows < samples_) {
      cut_rows(done_rows, result_);
      cut_rows(static_cast<long>(between_.next_sample.size()), between_.rows);
    }
    add_round_off();
    if (result_.time.size() >= 2) add_metrics(result_, between_);
    result_.outcome = outcome_;
    result_.outcome.notes = plant_.notes();
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

  DesiredState desired(std::size_t event) const {
    const auto row = static_cast<Eigen::Index>(event);
    return {desired_.position.row(row), desired_.velocity.row(row), desired_.acceleration.row(row)};
  }

  VectorX actuated(const VectorX& all) const {
    VectorX chosen(efforts_.size());
    for (Eigen::Index a = 0; a < chosen.size(); ++a) chosen[a] = all[mechanism_.actuators[static_cast<std::size_t>(a)]];
    return chosen;
  }

  /// Puts the mechanism where it starts and makes room for the rows.
  bool begin() {
    VectorX position = desired_.position.row(0);
    const VectorX velocity = desired_.velocity.row(0);
    const InitialError& error = controller_.initial_error;
    if (error.tool && !good(displace_tool(mechanism_, trajectory_, *error.tool, error.angle, position))) return false;
    for (const CoordinateValue& joint : error.joints) position[joint.coordinate] += joint.value;
    GainBasis basis{VectorX::Zero(efforts_.size())};
    for (Eigen::Index e = 0; e < desired_.acceleration.rows(); ++e)
      basis.peak_acceleration =
          basis.peak_acceleration.cwiseMax(actuated(desired_.acceleration.row(e).transpose()).cwiseAbs());
    if (!good(plant_.start(0, position, velocity))) return false;
    if (!good(law_.start(plant_.position(), plant_.velocity(), basis))) return false;
    shape();
    return true;
  }

  void shape() {
    const auto ticks = std::count_if(events_.begin() + 1, events_.end(), [](const Event& event) { return event.tick; });
    for (const auto& [result, rows] : {std::pair{&result_, samples_}, {&between_.rows, 2 * static_cast<long>(ticks)}}) {
      name_columns(mechanism_, *result);
      for (const int c : law_.sliding()) {
        const Coordinate& coordinate = mechanism_.coordinates[static_cast<std::size_t>(c)];
        result->sliding_names.push_back(coordinate.name);
        result->sliding_units.push_back(coordinate.kind == CoordinateKind::angle ? "rad/s" : "m/s");
      }
      result->about = trajectory_.about;
      size_arrays(mechanism_, rows, Contents::everything, *result);
      size_control_rows(mechanism_, rows, *result);
    }
  }

  /// On to the event, and through it. @return false if the run ends here
  bool pass(std::size_t e, long& done_rows) {
    const Event& event = events_[e];
    if (e > 0 && !good(plant_.advance(event.time, efforts_))) return false;
    if (event.tick) {
      if (e > 0) write(between_.rows, between_.add(event.sample), e);
      const DesiredState wanted = desired(e);
      sensor_.read(actuated(plant_.position()), actuated(plant_.velocity()), actuated(wanted.velocity));
      if (inverts(controller_) && !good(watch_.look(event.time, plant_.position(), plant_.velocity()))) return false;
      if (!good(law_.command(event.time, wanted, sensor_.position(), sensor_.velocity()))) return false;
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

  void write(Result& result, long row, std::size_t event) {
    const PlantSample& seen = plant_.observe(efforts_);
    const int axes = result.axes, turns = result.moment_axes;
    result.time[row] = events_[event].time;
    result.joint_position.row(row) = seen.position;
    result.joint_velocity.row(row) = seen.velocity;
    result.joint_acceleration.row(row) = seen.acceleration;
    result.torque.row(row) = seen.effort;
    result.power.row(row) = seen.power;
    put(result.com_position, row, seen.com, 0, axes);
    put(result.com_velocity, row, seen.com_velocity, 0, axes);
    put(result.com_acceleration, row, seen.com_acceleration, 0, axes);
    put(result.shaking_force, row, seen.shaking_force, 0, axes);
    put(result.shaking_moment, row, seen.shaking_moment, 0, turns);
    put(result.ground_force, row, seen.ground_force, 0, axes);
    put(result.ground_moment, row, seen.ground_moment, 0, turns);
    for (std::size_t j = 0; j < seen.joint_force.size(); ++j) {
      put(result.joint_force, row, seen.joint_force[j], static_cast<int>(j) * axes, axes);
      put(result.joint_moment, row, seen.joint_moment[j], static_cast<int>(j) * turns, turns);
    }
    result.kinetic_energy(row, 0) = seen.kinetic_energy;
    result.potential_energy(row, 0) = seen.potential_energy;
    result.mobility(row, 0) = seen.mobility;
    result.newton_iterations[row] = seen.newton_iterations;
    write_errors(result, row, static_cast<Eigen::Index>(event), seen);
    if (mechanism_.tool) write_tool(result, row, static_cast<Eigen::Index>(event), seen);
  }

  void write_errors(Result& result, long row, Eigen::Index event, const PlantSample& seen) {
    result.desired_position.row(row) = desired_.position.row(event);
    for (std::size_t i = 0; i < mechanism_.coordinates.size(); ++i) {
      const auto c = static_cast<Eigen::Index>(i);
      double error = desired_.position(event, c) - seen.position[c];
      // Of a coordinate without a motor, whole turns do not count: they are read off, not driven.
      const auto& motors = mechanism_.actuators;
      if (mechanism_.coordinates[i].kind == CoordinateKind::angle && !motors.empty() &&
          std::find(motors.begin(), motors.end(), static_cast<int>(i)) == motors.end())
        error = std::remainder(error, 2 * std::numbers::pi);
      result.tracking_error(row, c) = error;
    }
    for (std::size_t i = 0; i < law_.sliding().size(); ++i) {
      const Eigen::Index c = law_.sliding()[i], column = static_cast<Eigen::Index>(i);
      result.sliding_variable(row, column) = seen.velocity[c] - desired_.velocity(event, c) -
                                             law_.sliding_lambda()[column] * result.tracking_error(row, c);
    }
    result.torque_variation.row(row) = variation_;
    if (saturated_.size() > 0) result.saturation.row(row) = saturated_;
  }

  /// Of a sliding variable −(ė + λ e), what its rate and its position have.
  void add_round_off() {
    set_round_off(result_, plant_.term_sizes(), plant_.term_sizes_over_mobility());
    const auto count = static_cast<Eigen::Index>(law_.sliding().size());
    result_.round_off.sliding_variable.setZero(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const int c = law_.sliding()[static_cast<std::size_t>(i)];
      result_.round_off.sliding_variable[i] =
          result_.round_off.velocity[c] + law_.sliding_lambda()[i] * result_.round_off.position[c];
    }
  }

  void write_tool(Result& result, long row, Eigen::Index event, const PlantSample& seen) {
    const Vector3 wanted = desired_.tool_position.row(event);
    put(result.tool_position, row, seen.tool_position, 0, result.axes);
    put(result.desired_tool_position, row, wanted, 0, result.axes);
    put(result.tool_error, row, wanted - seen.tool_position, 0, result.axes);
    if (mechanism_.space == SpaceKind::planar) {
      result.tool_orientation(row, 0) = seen.tool_angle;
      result.tool_angle_error(row, 0) = desired_.tool_angle[event] - seen.tool_angle;
      return;
    }
    Eigen::Vector4d q = quaternion_of(seen.tool_rotation);
    // Of the two signs the one that goes on smoothly.
    if (last_quaternion_.dot(q) < 0) q = -q;
    last_quaternion_ = q;
    result.tool_orientation.row(row) = q;
    const Matrix3 gap = desired_.tool_rotation[static_cast<std::size_t>(event)] * seen.tool_rotation.transpose();
    const Eigen::Vector4d turn = quaternion_of(gap);
    result.tool_angle_error(row, 0) = 2 * std::atan2(turn.tail<3>().norm(), std::abs(turn[0]));
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const Controller& controller_;
  ControlLaw law_;
  Sensor sensor_;
  SingularityWatch watch_;
  Plant plant_;
  long samples_ = 0;
  std::vector<Event> events_;
  DesiredMotion desired_;  ///< a row per event
  VectorX efforts_, variation_, saturated_;
  Eigen::Vector4d last_quaternion_ = Eigen::Vector4d::Zero();
  Result result_;
  BetweenSamples between_;
  MotionOutcome outcome_;
};

}  // namespace

Result control(const Mechanism& mechanism, const Trajectory& trajectory, const Controller& controller,
               const ControlOptions& options) {
  if (trajectory.samples < 2) throw std::invalid_argument("a trajectory needs at least two samples");
  if (!(controller.period > 0)) throw std::invalid_argument("a controller needs a positive period");
  if (!(options.settle >= 0)) throw std::invalid_argument("the time to settle cannot be negative");
  return ControlRun(mechanism, trajectory, controller, options).run();
}

}  // namespace balance
