#include "balance/motion/simulation/simulate.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/term_magnitude_recorder.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/tree_payloads.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/simulation/group_stepper.hpp"
#include "balance/motion/simulation/payload_events.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance {

namespace {

/// Which moments' terms are measured: some fifty evenly spread ones, and wherever accelerations are larger or the mobility is
/// smaller than at all before.
class MagnitudeSampling {
 public:
  explicit MagnitudeSampling(long samples) : stride_(std::max(1L, samples / 50)) {}

  bool is_sample_due(long row, const VectorX& accelerations, double mobility) {
    const double fastest = max_abs(accelerations);
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
class SimulationRun {
 public:
  SimulationRun(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        progress_(progress),
        tree_(compile_tree<S>(mechanism, prescribed_coordinates(trajectory))),
        plan_(compile_trajectory(mechanism, tree_, trajectory)) {}

  RunResult run() {
    RunResult result;
    result.outcome = plan_.outcome;
    if (plan_.outcome.status != MotionStatus::done) return result;
    const typename S::Vector about = to_vector<S>(trajectory_.about);
    SampleEvaluator<S> observer(mechanism_, tree_, plan_.freedoms, about);
    if (!observer.actuation().mismatch().empty()) {
      result.outcome = {MotionStatus::mismatch, 0, observer.actuation().mismatch(), {}};
      return result;
    }
    MotionStepper<S> stepper(mechanism_, tree_, plan_);
    stepper.set_regularity_monitor(observer.regularity_monitor());
    name_columns(mechanism_, result);
    result.moment_reference = trajectory_.about;
    IntermediateSamples between;
    name_columns(mechanism_, between.rows);
    resize_arrays(mechanism_, trajectory_.samples, {}, result);
    resize_arrays(mechanism_, max_intermediate_rows(*plan_.prescribed_motion, trajectory_.samples), {}, between.rows);
    recorder_.emplace(result);
    const double clock = 1 / plan_.prescribed_motion->duration(),
                 fall = mechanism_.gravity.norm() / tree_.characteristic_length;
    meter_.emplace(mechanism_, tree_, about, RestScale{clock, std::max(clock * clock, fall)});
    loads_.emplace(mechanism_, tree_, plan_.prescribed_motion->duration());
    loads_->apply(0, tree_);
    GroupStepper<S> leader(mechanism_, tree_, plan_, {plan_.prescribed_motion->duration(), trajectory_.samples}, about,
                           stepper, observer);
    if (!follow(leader, stepper, observer, result, between)) {
      RunResult stopped;
      stopped.outcome = failure_;
      return stopped;
    }
    set_round_off(result, meter_->magnitudes(), meter_->amplified_magnitudes());
    add_metrics(result, between);
    if (const auto overflow = find_overflow(result, between, mechanism_)) {
      RunResult stopped;
      stopped.outcome = *overflow;
      return stopped;
    }
    clear_round_off(result);
    sample_phase_plane(*plan_.prescribed_motion, result.phase_plane);
    result.outcome = {MotionStatus::done, plan_.prescribed_motion->duration(), "", observer.actuation().notes()};
    if (const std::string note = check_sampling_density(result, between); !note.empty())
      result.outcome.notes.push_back(note);
    for (std::string& note : stepper.notes()) result.outcome.notes.push_back(std::move(note));
    for (const PassiveFreedom& spin : tree_.locked_freedoms)
      result.outcome.notes.push_back(describe_locked_freedom(mechanism_, spin));
    add_payload_notes(mechanism_, plan_.prescribed_motion->duration(), result);
    return result;
  }

 private:
  /// Through the whole walk.
  bool follow(GroupStepper<S>& leader, MotionStepper<S>& stepper, SampleEvaluator<S>& observer, RunResult& result,
              IntermediateSamples& between) {
    const long between_reports = 1 + (1 << 15) / (8 + tree_.columns);  // a large mechanism's samples take longer
    const auto see = [&](const TimeGridPoint& stop) {
      if (progress_ && stop.index % between_reports == between_reports - 1)
        progress_(static_cast<double>(stop.index) / static_cast<double>(trajectory_.samples));
      if (stop.kind == TimeGridPoint::Kind::sample) return record(leader, stepper, observer, result, stop.index);
      if (stop.has_coincident_next && stop.kind == TimeGridPoint::Kind::after_jump) return true;
      return record(leader, stepper, observer, between.rows, between.add(stop.next_sample));
    };
    const bool done =
        visit_time_grid(leader, *plan_.prescribed_motion, trajectory_.samples, [&](const TimeGridPoint& stop) {
          if (stop.kind == TimeGridPoint::Kind::after_jump) change_loads(leader, result);
          return see(stop);
        });
    if (!done && failure_.status == MotionStatus::unsolved) failure_ = stepper.outcome();
    return done;
  }

  /// On the far side of a jump, whose near side was seen last: payloads that are taken up or set down there.
  void change_loads(GroupStepper<S>& leader, RunResult& result) {
    const int before = loads_->current_interval();
    const VectorX effort = leader.last().effort;
    if (!loads_->apply(leader.time(), tree_)) return;
    leader.update_masses();
    if (!leader.observe()) return;  // who records the moment finds the same
    const TreeMotion<S> now = leader.at_current_sample();
    const auto motion = [&](std::size_t a) {
      const Attachment& payload = mechanism_.attachments[a];
      const FixedFrame<S>& body = tree_.bodies[static_cast<std::size_t>(payload.body)];
      const NodeState<S>& node = now.state[static_cast<std::size_t>(body.node)];
      const typename S::Vector place = body.p_N + body.R_N * to_vector<S>(payload.position);
      return PayloadMotion{point_velocity<S>(node, place).norm(), angular_to_3d(node.angular_velocity).norm()};
    };
    add_payload_changes(mechanism_, loads_->intervals(),
                        {leader.time(), before, loads_->current_interval(), effort, leader.last().effort}, motion,
                        result);
  }

  bool record(GroupStepper<S>& leader, MotionStepper<S>& stepper, SampleEvaluator<S>& observer, RunResult& result,
              long row) {
    if (!leader.observe()) {
      failure_ =
          make_actuation_singularity_outcome(stepper.time(), format_configuration(mechanism_, tree_, stepper.y()));
      return false;
    }
    const Sample& seen = leader.last();
    recorder_->write(seen, row, result);
    if (selection_.is_sample_due(row, seen.acceleration, seen.mobility))
      meter_->sample(leader.at_current_sample(), seen, observer.actuation().multipliers(), seen.mobility);
    return true;
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const Progress& progress_;
  Tree<S> tree_;
  CompiledTrajectory<S> plan_;
  std::optional<ResultRecorder> recorder_;
  std::optional<TermMagnitudeRecorder<S>> meter_;
  std::optional<TreePayloads<S>> loads_;
  MagnitudeSampling selection_{trajectory_.samples};
  MotionOutcome failure_;  ///< why the run ended early
};

}  // namespace

RunResult simulate(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress) {
  check_timing(trajectory);
  const ResolvedTrajectory timed = resolve_trajectory(mechanism, trajectory);
  RunResult result;
  result.outcome = timed.outcome;
  if (timed.outcome.status != MotionStatus::done) return result;
  result = dispatch_space(mechanism.space,
                          [&]<class S>(S) { return SimulationRun<S>(mechanism, timed.trajectory, progress).run(); });
  result.optimised_law = timed.optimised_law;
  result.corridor_result = timed.corridor;
  result.phase_plane.mvc_path_parameter = timed.phase_plane.mvc_path_parameter;
  result.phase_plane.mvc_path_rate = timed.phase_plane.mvc_path_rate;
  return result;
}

}  // namespace balance
