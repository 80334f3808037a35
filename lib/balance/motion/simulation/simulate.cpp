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

/// Selects samples for term magnitudes: some fifty evenly spaced ones, and those with larger accelerations or a smaller
/// mobility than all before.
class MagnitudeSampling {
 public:
  explicit MagnitudeSampling(long samples) : stride_(std::max(1L, samples / 50)) {}

  bool is_sample_due(long row, const VectorX& accelerations, double mobility) {
    const double max_acceleration = max_abs(accelerations);
    if (row % stride_ != 0 && max_acceleration <= 1.25 * max_acceleration_ && mobility >= 0.8 * min_mobility_)
      return false;
    max_acceleration_ = std::max(max_acceleration_, max_acceleration);
    min_mobility_ = std::min(min_mobility_, mobility);
    return true;
  }

 private:
  long stride_;
  double max_acceleration_ = 0, min_mobility_ = 1;
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
    SampleEvaluator<S> evaluator(mechanism_, tree_, plan_.freedoms, about);
    if (!evaluator.actuation().mismatch().empty()) {
      result.outcome = {MotionStatus::mismatch, 0, evaluator.actuation().mismatch(), {}};
      return result;
    }
    MotionStepper<S> stepper(mechanism_, tree_, plan_);
    stepper.set_regularity_monitor(evaluator.regularity_monitor());
    name_columns(mechanism_, result);
    result.moment_reference = trajectory_.about;
    IntermediateSamples intermediate_samples;
    name_columns(mechanism_, intermediate_samples.rows);
    resize_arrays(mechanism_, trajectory_.samples, {}, result);
    resize_arrays(mechanism_, max_intermediate_rows(*plan_.prescribed_motion, trajectory_.samples), {},
                  intermediate_samples.rows);
    recorder_.emplace(result);
    const double inverse_duration = 1 / plan_.prescribed_motion->duration(),
                 free_fall = mechanism_.gravity.norm() / tree_.characteristic_length;
    magnitude_recorder_.emplace(mechanism_, tree_, about,
                                RestScale{inverse_duration, std::max(inverse_duration * inverse_duration, free_fall)});
    payloads_.emplace(mechanism_, tree_, plan_.prescribed_motion->duration());
    payloads_->apply(0, tree_);
    GroupStepper<S> group_stepper(mechanism_, tree_, plan_, {plan_.prescribed_motion->duration(), trajectory_.samples},
                                  about, stepper, evaluator);
    if (!traverse(group_stepper, stepper, evaluator, result, intermediate_samples)) {
      RunResult stopped;
      stopped.outcome = failure_;
      return stopped;
    }
    set_round_off(result, magnitude_recorder_->magnitudes(), magnitude_recorder_->amplified_magnitudes());
    add_metrics(result, intermediate_samples);
    if (const auto overflow = find_overflow(result, intermediate_samples, mechanism_)) {
      RunResult stopped;
      stopped.outcome = *overflow;
      return stopped;
    }
    clear_round_off(result);
    sample_phase_plane(*plan_.prescribed_motion, result.phase_plane);
    result.outcome = {MotionStatus::done, plan_.prescribed_motion->duration(), "", evaluator.actuation().notes()};
    if (const std::string note = check_sampling_density(result, intermediate_samples); !note.empty())
      result.outcome.notes.push_back(note);
    for (std::string& note : stepper.notes()) result.outcome.notes.push_back(std::move(note));
    for (const PassiveFreedom& spin : tree_.locked_freedoms)
      result.outcome.notes.push_back(describe_locked_freedom(mechanism_, spin));
    add_payload_notes(mechanism_, plan_.prescribed_motion->duration(), result);
    result.intermediate = std::make_shared<const IntermediateSamples>(std::move(intermediate_samples));
    return result;
  }

 private:
  /// Traverses the whole time grid.
  bool traverse(GroupStepper<S>& group_stepper, MotionStepper<S>& stepper, SampleEvaluator<S>& evaluator,
                RunResult& result, IntermediateSamples& intermediate_samples) {
    const long samples_per_report = 1 + (1 << 15) / (8 + tree_.columns);  // samples of a large mechanism take longer
    const auto visit = [&](const TimeGridPoint& grid_point) {
      if (progress_ && grid_point.index % samples_per_report == samples_per_report - 1)
        progress_(static_cast<double>(grid_point.index) / static_cast<double>(trajectory_.samples));
      if (grid_point.kind == TimeGridPoint::Kind::sample)
        return record(group_stepper, stepper, evaluator, result, grid_point.index);
      if (grid_point.has_coincident_next && grid_point.kind == TimeGridPoint::Kind::after_jump) return true;
      return record(group_stepper, stepper, evaluator, intermediate_samples.rows,
                    intermediate_samples.add(grid_point.next_sample));
    };
    const bool done = visit_time_grid(group_stepper, *plan_.prescribed_motion, trajectory_.samples,
                                      [&](const TimeGridPoint& grid_point) {
                                        if (grid_point.kind == TimeGridPoint::Kind::after_jump)
                                          update_payloads(group_stepper, result);
                                        return visit(grid_point);
                                      });
    if (!done && failure_.status == MotionStatus::unsolved) failure_ = stepper.outcome();
    return done;
  }

  /// After a jump, with its near side observed last: applies payloads that are taken up or set down there.
  void update_payloads(GroupStepper<S>& group_stepper, RunResult& result) {
    const int before = payloads_->current_interval();
    const VectorX effort = group_stepper.last().effort;
    if (!payloads_->apply(group_stepper.time(), tree_)) return;
    group_stepper.update_masses();
    if (!group_stepper.observe()) return;  // recording this moment reports the failure
    const TreeMotion<S> motion_state = group_stepper.at_current_sample();
    const auto motion = [&](std::size_t a) {
      const Attachment& payload = mechanism_.attachments[a];
      const FixedFrame<S>& body = tree_.bodies[static_cast<std::size_t>(payload.body)];
      const NodeState<S>& node = motion_state.state[static_cast<std::size_t>(body.node)];
      const typename S::Vector point = body.p_N + body.R_N * to_vector<S>(payload.position);
      return PayloadMotion{point_velocity<S>(node, point).norm(), angular_to_3d(node.angular_velocity).norm()};
    };
    add_payload_changes(
        mechanism_, payloads_->intervals(),
        {group_stepper.time(), before, payloads_->current_interval(), effort, group_stepper.last().effort}, motion,
        result);
  }

  bool record(GroupStepper<S>& group_stepper, MotionStepper<S>& stepper, SampleEvaluator<S>& evaluator,
              RunResult& result, long row) {
    if (!group_stepper.observe()) {
      failure_ =
          make_actuation_singularity_outcome(stepper.time(), format_configuration(mechanism_, tree_, stepper.y()));
      return false;
    }
    const Sample& sample = group_stepper.last();
    recorder_->write(sample, row, result);
    if (magnitude_sampling_.is_sample_due(row, sample.acceleration, sample.mobility))
      magnitude_recorder_->sample(group_stepper.at_current_sample(), sample, evaluator.actuation().multipliers(),
                                  sample.mobility);
    return true;
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const Progress& progress_;
  Tree<S> tree_;
  CompiledTrajectory<S> plan_;
  std::optional<ResultRecorder> recorder_;
  std::optional<TermMagnitudeRecorder<S>> magnitude_recorder_;
  std::optional<TreePayloads<S>> payloads_;
  MagnitudeSampling magnitude_sampling_{trajectory_.samples};
  MotionOutcome failure_;  ///< why the run ended early
};

}  // namespace

RunResult simulate(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress) {
  check_timing(trajectory);
  const ResolvedTrajectory resolved = resolve_trajectory(mechanism, trajectory);
  RunResult result;
  result.outcome = resolved.outcome;
  if (resolved.outcome.status != MotionStatus::done) return result;
  result = dispatch_space(mechanism.space,
                          [&]<class S>(S) { return SimulationRun<S>(mechanism, resolved.trajectory, progress).run(); });
  result.optimised_law = resolved.optimised_law;
  result.corridor_result = resolved.corridor;
  result.phase_plane.mvc_path_parameter = resolved.phase_plane.mvc_path_parameter;
  result.phase_plane.mvc_path_rate = resolved.phase_plane.mvc_path_rate;
  return result;
}

}  // namespace balance
