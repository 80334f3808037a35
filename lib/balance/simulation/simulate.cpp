#include "balance/simulation/simulate.hpp"

#include "balance/base/rotation.hpp"
#include "balance/dynamics/observer.hpp"
#include "balance/dynamics/term_meter.hpp"
#include "balance/motion/configuration_text.hpp"
#include "balance/motion/walk.hpp"
#include "balance/motion/wording.hpp"
#include "balance/result/columns.hpp"
#include "balance/result/metrics.hpp"
#include "balance/result/overflow.hpp"
#include "balance/result/round_off.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance {

namespace {

template <int N>
void put(Samples& array, long row, int column, const Eigen::Matrix<double, N, 1>& v) {
  for (int k = 0; k < N; ++k) array(row, column + k) = v[k];
}
void put(Samples& array, long row, int column, double v) { array(row, column) = v; }
void put(Samples& array, long row, const std::vector<double>& values) {
  for (std::size_t k = 0; k < values.size(); ++k) array(row, static_cast<Eigen::Index>(k)) = values[k];
}

void put_orientation(Samples& array, long row, const Observation<Planar>& seen) { array(row, 0) = seen.tool_angle; }
void put_orientation(Samples& array, long row, const Observation<Spatial>& seen) {
  Eigen::Vector4d q = quaternion_of(seen.tool_rotation.matrix);
  if (row > 0 && array.row(row - 1).dot(q) < 0) q = -q;  // of the two signs the one that goes on smoothly
  array.row(row) = q;
}

/// Which moments' terms are measured: some hundred evenly spread ones, and wherever accelerations are larger or the mobility is
/// smaller than at all before.
class Selection {
 public:
  explicit Selection(long samples) : stride_(std::max(1L, samples / 128)) {}

  bool takes(long row, const std::vector<double>& accelerations, double mobility) {
    double fastest = 0;
    for (const double acceleration : accelerations) fastest = std::max(fastest, std::abs(acceleration));
    if (row % stride_ != 0 && fastest <= 1.25 * fastest_ && mobility >= 0.8 * mobility_) return false;
    fastest_ = std::max(fastest_, fastest);
    mobility_ = std::min(mobility_, mobility);
    return true;
  }

 private:
  long stride_;
  double fastest_ = 0, mobility_ = 1;
};

template <class S>
class Run {
 public:
  Run(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        progress_(progress),
        tree_(compile<S>(mechanism, prescribed_coordinates(trajectory))),
        plan_(make_plan(mechanism, tree_, trajectory)) {}

  Result run() {
    Result result;
    result.outcome = plan_.outcome;
    if (plan_.outcome.status != MotionStatus::done) return result;
    const typename S::Vector about = to_vector<S>(trajectory_.about);
    Observer<S> observer(mechanism_, tree_, plan_.freedoms, about);
    if (!observer.actuation().mismatch().empty()) {
      result.outcome = {MotionStatus::mismatch, 0, observer.actuation().mismatch(), {}};
      return result;
    }
    Stepper<S> stepper(mechanism_, tree_, plan_);
    stepper.watch(observer.guard());
    name_columns(mechanism_, result);
    result.about = trajectory_.about;
    BetweenSamples between;
    name_columns(mechanism_, between.rows);
    size_arrays(mechanism_, trajectory_.samples, Contents::everything, result);
    size_arrays(mechanism_, most_rows_between(*plan_.schedule, trajectory_.samples), Contents::everything,
                between.rows);
    meter_.emplace(mechanism_, tree_, about);
    if (!follow(stepper, observer, result, between)) {
      Result stopped;
      stopped.outcome = lost_;
      return stopped;
    }
    set_round_off(result, meter_->terms(), meter_->grown());
    add_metrics(result, between);
    if (const auto overflow = find_overflow(result, between)) {
      Result stopped;
      stopped.outcome = *overflow;
      return stopped;
    }
    result.outcome = {MotionStatus::done, plan_.schedule->duration(), "", observer.actuation().notes()};
    if (const std::string note = sampling_note(result, between); !note.empty()) result.outcome.notes.push_back(note);
    for (std::string& note : stepper.notes()) result.outcome.notes.push_back(std::move(note));
    for (const IdleSpin& spin : tree_.held_spins) result.outcome.notes.push_back(held_spin(mechanism_, spin));
    return result;
  }

 private:
  /// Through the whole walk.
  bool follow(Stepper<S>& stepper, Observer<S>& observer, Result& result, BetweenSamples& between) {
    const bool done = walk(stepper, *plan_.schedule, trajectory_.samples, [&](const Stop& stop) {
      constexpr long between_reports = 1 << 12;
      if (progress_ && stop.index % between_reports == between_reports - 1)
        progress_(static_cast<double>(stop.index) / static_cast<double>(trajectory_.samples));
      if (stop.kind == Stop::Kind::sample) return record(stepper, observer, result, stop.index);
      if (stop.followed && stop.kind == Stop::Kind::after_jump) return true;
      return record(stepper, observer, between.rows, between.add(stop.next_sample));
    });
    if (!done && lost_.status == MotionStatus::unsolved) lost_ = stepper.outcome();
    return done;
  }

  bool record(Stepper<S>& stepper, Observer<S>& observer, Result& result, long row) {
    if (!observer.observe(stepper, Detail::everything)) {
      lost_ = no_longer_held(stepper.time(), configuration_text(mechanism_, tree_, stepper.y()));
      return false;
    }
    write(stepper, observer.last(), result, row);
    if (selection_.takes(row, observer.last().acceleration, result.mobility(row, 0)))
      meter_->see({stepper.state(), stepper.y(), stepper.dy(), stepper.ddy(), stepper.time(), stepper.direct()},
                  observer.last(), observer.actuation().multipliers(), result.mobility(row, 0));
    return true;
  }

  void write(Stepper<S>& stepper, const Observation<S>& seen, Result& result, long row) {
    result.time[row] = stepper.time();
    put(result.joint_position, row, seen.position);
    put(result.joint_velocity, row, seen.velocity);
    put(result.joint_acceleration, row, seen.acceleration);
    put(result.torque, row, seen.effort);
    put(result.power, row, seen.power);
    put(result.com_position, row, 0, seen.com);
    put(result.com_velocity, row, 0, seen.com_velocity);
    put(result.com_acceleration, row, 0, seen.com_acceleration);
    put(result.shaking_force, row, 0, seen.shaking_force);
    put(result.shaking_moment, row, 0, seen.shaking_moment);
    put(result.ground_force, row, 0, seen.ground_force);
    put(result.ground_moment, row, 0, seen.ground_moment);
    for (std::size_t joint = 0; joint < seen.joint_force.size(); ++joint) {
      put(result.joint_force, row, static_cast<int>(joint) * S::dimension, seen.joint_force[joint]);
      put(result.joint_moment, row, static_cast<int>(joint) * S::angular, seen.joint_moment[joint]);
    }
    result.kinetic_energy(row, 0) = seen.kinetic_energy;
    result.potential_energy(row, 0) = seen.potential_energy;
    result.mobility(row, 0) = stepper.mobility();
    result.newton_iterations[row] = stepper.iterations();
    if (!mechanism_.tool) return;
    put(result.tool_position, row, 0, seen.tool_position);
    put_orientation(result.tool_orientation, row, seen);
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const Progress& progress_;
  Tree<S> tree_;
  Plan<S> plan_;
  std::optional<TermMeter<S>> meter_;
  Selection selection_{trajectory_.samples};
  MotionOutcome lost_;  ///< why the run ended early
};

}  // namespace

Result simulate(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress) {
  if (trajectory.samples < 2) throw std::invalid_argument("a trajectory needs at least two samples");
  return mechanism.space == SpaceKind::planar ? Run<Planar>(mechanism, trajectory, progress).run()
                                              : Run<Spatial>(mechanism, trajectory, progress).run();
}

}  // namespace balance
