#include "balance/simulation/simulate_natural.hpp"

#include "balance/dynamics/observer.hpp"
#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/motion/law_curve.hpp"
#include "balance/motion/timing_bounds.hpp"
#include "balance/motion/walk.hpp"
#include "balance/natural/simulation.hpp"
#include "balance/result/metrics.hpp"
#include "balance/result/overflow.hpp"
#include "balance/result/recorder.hpp"
#include "balance/result/round_off.hpp"
#include "balance/simulation/payload_watch.hpp"
#include "balance/simulation/simulate.hpp"
#include "balance/timing/time_law.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace balance {

NaturalStart find_start(const Mechanism& mechanism, const Trajectory& trajectory) {
  Tree<Planar> tree = compile<Planar>(mechanism, prescribed_coordinates(trajectory));
  const Plan<Planar> plan = make_plan(mechanism, tree, trajectory);
  NaturalStart found{plan.outcome, {}};
  if (plan.outcome.status != MotionStatus::done) return found;
  Observer<Planar> observer(mechanism, tree, plan.freedoms, Vector2::Zero());
  if (!observer.actuation().mismatch().empty()) {
    found.outcome = {MotionStatus::mismatch, 0, observer.actuation().mismatch(), {}};
    return found;
  }
  Stepper<Planar> stepper(mechanism, tree, plan);
  if (!stepper.begin()) {
    found.outcome = stepper.outcome();
    return found;
  }
  observer.observe(stepper, Detail::forces);
  const VectorX& position = observer.last().position;
  found.start = {{position.begin(), position.end()}, observer.last().tool_angle};
  return found;
}

NaturalStart find_start(const Mechanism& mechanism) {
  const Tree<Planar> tree = compile<Planar>(mechanism, {});
  System<Planar> closures(tree, Drive<Planar>{});
  const Solution found = find_pose(mechanism, tree, closures, {});
  NaturalStart result;
  if (!found.found) {
    result.outcome = {MotionStatus::not_assembled, 0, "the loops cannot be closed", {}};
    return result;
  }
  result.outcome.status = MotionStatus::done;
  result.start.coordinates = read_coordinates(mechanism, tree, found.y);
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const LinearQuantity& source = tree.sources[c];
    if (source.depends())  // with its whole turns
      result.start.coordinates[c] = source.value(found.y.data());
  }
  return result;
}

namespace {

class NaturalRun {
 public:
  NaturalRun(const Mechanism& mechanism, const Trajectory& trajectory, const natural::Start& start,
             const Progress& progress)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        progress_(progress),
        simulation_(mechanism, trajectory, start) {}

  Result run() {
    Result result;
    result.outcome = simulation_.outcome();
    if (result.outcome.status != MotionStatus::done) return result;
    name_columns(mechanism_, result);
    result.about = trajectory_.about;
    BetweenSamples between;
    name_columns(mechanism_, between.rows);
    const Schedule& schedule = simulation_.schedule();
    constexpr Contents contents{.reactions = false};
    size_arrays(mechanism_, trajectory_.samples, contents, result);
    size_arrays(mechanism_, most_rows_between(schedule, trajectory_.samples), contents, between.rows);
    Recorder recorder(result);
    const auto record = [&](Result& rows, long row) {
      if (!simulation_.observe()) return false;
      recorder.write(simulation_.last(), row, rows);
      return true;
    };
    const PayloadStretches stretches(mechanism_, schedule.duration());
    int stretch = 0;
    simulation_.carry(stretches, stretch);
    const auto change_loads = [&] {
      const int before = std::exchange(stretch, stretches.from(simulation_.time()));
      if (stretch == before) return;
      const VectorX effort = simulation_.last().effort;
      simulation_.carry(stretches, stretch);
      if (!simulation_.observe()) return;  // who records the moment finds the same
      add_payload_changes(
          mechanism_, stretches, {simulation_.time(), before, stretch, effort, simulation_.last().effort},
          [&](std::size_t a) {
            return PayloadMotion{
                simulation_.speed_of(mechanism_.attachments[a].body, mechanism_.attachments[a].position),
                simulation_.turning_of(mechanism_.attachments[a].body)};
          },
          result);
    };
    const bool done = walk(simulation_, schedule, trajectory_.samples, [&](const Stop& stop) {
      if (stop.kind == Stop::Kind::after_jump) change_loads();
      constexpr long between_reports = 1 << 8;
      if (progress_ && stop.index % between_reports == between_reports - 1)
        progress_(static_cast<double>(stop.index) / static_cast<double>(trajectory_.samples));
      if (stop.kind == Stop::Kind::sample) return record(result, stop.index);
      if (stop.followed && stop.kind == Stop::Kind::after_jump) return true;
      return record(between.rows, between.add(stop.next_sample));
    });
    if (!done) {
      Result stopped;
      stopped.outcome = simulation_.outcome();
      return stopped;
    }
    measure_terms(result);
    add_metrics(result, between);
    if (const auto overflow = find_overflow(result, between, mechanism_)) {
      Result stopped;
      stopped.outcome = *overflow;
      return stopped;
    }
    clear_round_off(result);
    trace_law(schedule, result.phase_plane);
    result.outcome = {MotionStatus::done, schedule.duration(), "", simulation_.notes()};
    if (const std::string note = sampling_note(result, between); !note.empty()) result.outcome.notes.push_back(note);
    add_payload_notes(mechanism_, schedule.duration(), result);
    return result;
  }

 private:
  /// The terms are the mechanism's, not the formulation's: the first one measures them, at a few places.
  void measure_terms(Result& result) const {
    Trajectory few = trajectory_;
    few.samples = std::min(few.samples, 101L);
    const Result measured = simulate(mechanism_, few);
    result.term_sizes = measured.term_sizes;
    result.round_off = measured.round_off;
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const Progress& progress_;
  natural::Simulation simulation_;
};

}  // namespace

Result simulate_natural(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("natural coordinates are for planar mechanisms, this one is spatial");
  if (binds_rates(mechanism)) throw std::invalid_argument("natural coordinates know no constraints on speeds");
  check_timing(trajectory);
  const TimedTrajectory timed = time_law(mechanism, trajectory);
  Result result;
  result.outcome = timed.outcome;
  if (timed.outcome.status != MotionStatus::done) return result;
  const NaturalStart found = find_start(mechanism, timed.trajectory);
  result.outcome = found.outcome;
  if (found.outcome.status != MotionStatus::done) return result;
  result = NaturalRun(mechanism, timed.trajectory, found.start, progress).run();
  result.found_law = timed.found;
  result.found_corridor = timed.corridor;
  result.phase_plane.ceiling_place = timed.phase_plane.ceiling_place;
  result.phase_plane.ceiling = timed.phase_plane.ceiling;
  return result;
}

}  // namespace balance
