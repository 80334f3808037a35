#include "balance/synthesis/verification/simulate_natural.hpp"

#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/simulation/payload_events.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"
#include "balance/synthesis/verification/natural_simulation.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace balance {

NaturalStart find_natural_start(const Mechanism& mechanism, const Trajectory& trajectory) {
  Tree<Planar> tree = compile_tree<Planar>(mechanism, prescribed_coordinates(trajectory));
  const CompiledTrajectory<Planar> plan = compile_trajectory(mechanism, tree, trajectory);
  NaturalStart result{plan.outcome, {}};
  if (plan.outcome.status != MotionStatus::done) return result;
  SampleEvaluator<Planar> evaluator(mechanism, tree, plan.freedoms, Vector2::Zero());
  if (!evaluator.actuation().mismatch().empty()) {
    result.outcome = {MotionStatus::mismatch, 0, evaluator.actuation().mismatch(), {}};
    return result;
  }
  MotionStepper<Planar> stepper(mechanism, tree, plan);
  if (!stepper.begin()) {
    result.outcome = stepper.outcome();
    return result;
  }
  evaluator.evaluate(stepper, Detail::forces);
  const VectorX& position = evaluator.sample().position;
  result.start = {{position.begin(), position.end()}, evaluator.sample().tool_angle};
  return result;
}

NaturalStart find_natural_start(const Mechanism& mechanism) {
  const Tree<Planar> tree = compile_tree<Planar>(mechanism, {});
  ConstraintSystem<Planar> closures(tree, Drive<Planar>{});
  const AssemblySolution assembly = solve_pose(mechanism, tree, closures, {});
  NaturalStart result;
  if (!assembly.found) {
    result.outcome = {MotionStatus::not_assembled, 0, "the loops cannot be closed", {}};
    return result;
  }
  result.outcome.status = MotionStatus::done;
  result.start.coordinates = compute_coordinates(mechanism, tree, assembly.y);
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const LinearQuantity& expression = tree.coordinate_expressions[c];
    if (expression.has_terms())  // with its whole turns
      result.start.coordinates[c] = expression.value(assembly.y.data());
  }
  return result;
}

namespace {

class NaturalRun {
 public:
  NaturalRun(const Mechanism& mechanism, const Trajectory& trajectory, const natural::InitialCoordinates& start,
             const Progress& progress)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        progress_(progress),
        simulation_(mechanism, trajectory, start) {}

  RunResult run() {
    RunResult result;
    result.outcome = simulation_.outcome();
    if (result.outcome.status != MotionStatus::done) return result;
    name_columns(mechanism_, result);
    result.moment_reference = trajectory_.about;
    IntermediateSamples intermediate_samples;
    name_columns(mechanism_, intermediate_samples.rows);
    const PrescribedMotion& schedule = simulation_.schedule();
    constexpr RecordedContents contents{.reactions = false};
    resize_arrays(mechanism_, trajectory_.samples, contents, result);
    resize_arrays(mechanism_, max_intermediate_rows(schedule, trajectory_.samples), contents,
                  intermediate_samples.rows);
    ResultRecorder recorder(result);
    const auto record = [&](RunResult& rows, long row) {
      if (!simulation_.observe()) return false;
      recorder.write(simulation_.last(), row, rows);
      return true;
    };
    const PayloadIntervals intervals(mechanism_, schedule.duration());
    int interval = 0;
    simulation_.apply_payloads(intervals, interval);
    const auto update_payloads = [&] {
      const int before = std::exchange(interval, intervals.index_at(simulation_.time()));
      if (interval == before) return;
      const VectorX effort = simulation_.last().effort;
      simulation_.apply_payloads(intervals, interval);
      if (!simulation_.observe()) return;  // recording at this time fails in the same way
      add_payload_changes(
          mechanism_, intervals, {simulation_.time(), before, interval, effort, simulation_.last().effort},
          [&](std::size_t a) {
            return PayloadMotion{
                simulation_.speed_of(mechanism_.attachments[a].body, mechanism_.attachments[a].position),
                simulation_.angular_speed_of(mechanism_.attachments[a].body)};
          },
          result);
    };
    const bool done = visit_time_grid(simulation_, schedule, trajectory_.samples, [&](const TimeGridPoint& grid_point) {
      if (grid_point.kind == TimeGridPoint::Kind::after_jump) update_payloads();
      constexpr long samples_per_report = 1 << 8;
      if (progress_ && grid_point.index % samples_per_report == samples_per_report - 1)
        progress_(static_cast<double>(grid_point.index) / static_cast<double>(trajectory_.samples));
      if (grid_point.kind == TimeGridPoint::Kind::sample) return record(result, grid_point.index);
      if (grid_point.has_coincident_next && grid_point.kind == TimeGridPoint::Kind::after_jump) return true;
      return record(intermediate_samples.rows, intermediate_samples.add(grid_point.next_sample));
    });
    if (!done) {
      RunResult stopped;
      stopped.outcome = simulation_.outcome();
      return stopped;
    }
    measure_terms(result);
    add_metrics(result, intermediate_samples);
    if (const auto overflow = find_overflow(result, intermediate_samples, mechanism_)) {
      RunResult stopped;
      stopped.outcome = *overflow;
      return stopped;
    }
    clear_round_off(result);
    sample_phase_plane(schedule, result.phase_plane);
    result.outcome = {MotionStatus::done, schedule.duration(), "", simulation_.notes()};
    if (const std::string note = check_sampling_density(result, intermediate_samples); !note.empty())
      result.outcome.notes.push_back(note);
    add_payload_notes(mechanism_, schedule.duration(), result);
    return result;
  }

 private:
  /// Magnitudes of terms depend on the mechanism, not on the formulation: the first one measures them at a few samples.
  void measure_terms(RunResult& result) const {
    Trajectory coarse = trajectory_;
    coarse.samples = std::min(coarse.samples, 101L);
    const RunResult measured = simulate(mechanism_, coarse);
    result.term_magnitudes = measured.term_magnitudes;
    result.round_off = measured.round_off;
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const Progress& progress_;
  natural::NaturalSimulation simulation_;
};

}  // namespace

RunResult simulate_natural(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("natural coordinates are for planar mechanisms, this one is spatial");
  if (has_velocity_constraints(mechanism))
    throw std::invalid_argument("natural coordinates do not support constraints on speeds");
  check_timing(trajectory);
  const ResolvedTrajectory resolved = resolve_trajectory(mechanism, trajectory);
  RunResult result;
  result.outcome = resolved.outcome;
  if (resolved.outcome.status != MotionStatus::done) return result;
  const NaturalStart start = find_natural_start(mechanism, resolved.trajectory);
  result.outcome = start.outcome;
  if (start.outcome.status != MotionStatus::done) return result;
  result = NaturalRun(mechanism, resolved.trajectory, start.start, progress).run();
  result.optimised_law = resolved.optimised_law;
  result.corridor_result = resolved.corridor;
  result.phase_plane.mvc_path_parameter = resolved.phase_plane.mvc_path_parameter;
  result.phase_plane.mvc_path_rate = resolved.phase_plane.mvc_path_rate;
  return result;
}

}  // namespace balance
