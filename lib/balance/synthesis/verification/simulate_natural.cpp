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
  NaturalStart found{plan.outcome, {}};
  if (plan.outcome.status != MotionStatus::done) return found;
  SampleEvaluator<Planar> observer(mechanism, tree, plan.freedoms, Vector2::Zero());
  if (!observer.actuation().mismatch().empty()) {
    found.outcome = {MotionStatus::mismatch, 0, observer.actuation().mismatch(), {}};
    return found;
  }
  MotionStepper<Planar> stepper(mechanism, tree, plan);
  if (!stepper.begin()) {
    found.outcome = stepper.outcome();
    return found;
  }
  observer.evaluate(stepper, Detail::forces);
  const VectorX& position = observer.sample().position;
  found.start = {{position.begin(), position.end()}, observer.sample().tool_angle};
  return found;
}

NaturalStart find_natural_start(const Mechanism& mechanism) {
  const Tree<Planar> tree = compile_tree<Planar>(mechanism, {});
  ConstraintSystem<Planar> closures(tree, Drive<Planar>{});
  const AssemblySolution found = solve_pose(mechanism, tree, closures, {});
  NaturalStart result;
  if (!found.found) {
    result.outcome = {MotionStatus::not_assembled, 0, "the loops cannot be closed", {}};
    return result;
  }
  result.outcome.status = MotionStatus::done;
  result.start.coordinates = compute_coordinates(mechanism, tree, found.y);
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const LinearQuantity& source = tree.coordinate_expressions[c];
    if (source.has_terms())  // with its whole turns
      result.start.coordinates[c] = source.value(found.y.data());
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
    IntermediateSamples between;
    name_columns(mechanism_, between.rows);
    const PrescribedMotion& schedule = simulation_.schedule();
    constexpr RecordedContents contents{.reactions = false};
    resize_arrays(mechanism_, trajectory_.samples, contents, result);
    resize_arrays(mechanism_, max_intermediate_rows(schedule, trajectory_.samples), contents, between.rows);
    ResultRecorder recorder(result);
    const auto record = [&](RunResult& rows, long row) {
      if (!simulation_.observe()) return false;
      recorder.write(simulation_.last(), row, rows);
      return true;
    };
    const PayloadIntervals stretches(mechanism_, schedule.duration());
    int stretch = 0;
    simulation_.apply_payloads(stretches, stretch);
    const auto change_loads = [&] {
      const int before = std::exchange(stretch, stretches.index_at(simulation_.time()));
      if (stretch == before) return;
      const VectorX effort = simulation_.last().effort;
      simulation_.apply_payloads(stretches, stretch);
      if (!simulation_.observe()) return;  // who records the moment finds the same
      add_payload_changes(
          mechanism_, stretches, {simulation_.time(), before, stretch, effort, simulation_.last().effort},
          [&](std::size_t a) {
            return PayloadMotion{
                simulation_.speed_of(mechanism_.attachments[a].body, mechanism_.attachments[a].position),
                simulation_.angular_speed_of(mechanism_.attachments[a].body)};
          },
          result);
    };
    const bool done = visit_time_grid(simulation_, schedule, trajectory_.samples, [&](const TimeGridPoint& stop) {
      if (stop.kind == TimeGridPoint::Kind::after_jump) change_loads();
      constexpr long between_reports = 1 << 8;
      if (progress_ && stop.index % between_reports == between_reports - 1)
        progress_(static_cast<double>(stop.index) / static_cast<double>(trajectory_.samples));
      if (stop.kind == TimeGridPoint::Kind::sample) return record(result, stop.index);
      if (stop.has_coincident_next && stop.kind == TimeGridPoint::Kind::after_jump) return true;
      return record(between.rows, between.add(stop.next_sample));
    });
    if (!done) {
      RunResult stopped;
      stopped.outcome = simulation_.outcome();
      return stopped;
    }
    measure_terms(result);
    add_metrics(result, between);
    if (const auto overflow = find_overflow(result, between, mechanism_)) {
      RunResult stopped;
      stopped.outcome = *overflow;
      return stopped;
    }
    clear_round_off(result);
    sample_phase_plane(schedule, result.phase_plane);
    result.outcome = {MotionStatus::done, schedule.duration(), "", simulation_.notes()};
    if (const std::string note = check_sampling_density(result, between); !note.empty())
      result.outcome.notes.push_back(note);
    add_payload_notes(mechanism_, schedule.duration(), result);
    return result;
  }

 private:
  /// The terms are the mechanism's, not the formulation's: the first one measures them, at a few places.
  void measure_terms(RunResult& result) const {
    Trajectory few = trajectory_;
    few.samples = std::min(few.samples, 101L);
    const RunResult measured = simulate(mechanism_, few);
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
    throw std::invalid_argument("natural coordinates know no constraints on speeds");
  check_timing(trajectory);
  const ResolvedTrajectory timed = resolve_trajectory(mechanism, trajectory);
  RunResult result;
  result.outcome = timed.outcome;
  if (timed.outcome.status != MotionStatus::done) return result;
  const NaturalStart found = find_natural_start(mechanism, timed.trajectory);
  result.outcome = found.outcome;
  if (found.outcome.status != MotionStatus::done) return result;
  result = NaturalRun(mechanism, timed.trajectory, found.start, progress).run();
  result.optimised_law = timed.optimised_law;
  result.corridor_result = timed.corridor;
  result.phase_plane.mvc_path_parameter = timed.phase_plane.mvc_path_parameter;
  result.phase_plane.mvc_path_rate = timed.phase_plane.mvc_path_rate;
  return result;
}

}  // namespace balance
