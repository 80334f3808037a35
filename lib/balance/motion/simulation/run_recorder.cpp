#include "balance/motion/simulation/run_recorder.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/results/spring_travel.hpp"
#include "balance/mechanics/trajectory/adaptation.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"
#include "balance/motion/simulation/free_motion.hpp"
#include "balance/motion/simulation/partly_driven_mechanism.hpp"
#include "balance/motion/simulation/payload_events.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>

namespace balance::simulation {

namespace {

RunResult without_samples(const MotionOutcome& outcome) {
  RunResult result;
  result.outcome = outcome;
  return result;
}

/// The fictitious actuators of the free coordinates have no effort, to this fraction of the efforts' terms.
constexpr double free_effort_tolerance = 1e-7;

std::size_t count_free_coordinates(const Trajectory& trajectory) {
  return static_cast<std::size_t>(
      std::count_if(trajectory.courses.begin(), trajectory.courses.end(),
                    [](const trajectory::CoordinateCourse& course) { return course.is_free(); }));
}

/// Drops the actuators of the free coordinates, the last ones.
/// @return why the motion is not that of the dynamics; empty if it is
std::string leave_out_free_coordinates(std::size_t free, RunResult& result,
                                       results::IntermediateSamples& intermediate_samples) {
  if (free == 0) return "";
  const auto columns = static_cast<Eigen::Index>(free);
  // the other formulation knows the terms of the actuators that are kept, perhaps none; energies are efforts by radians
  double largest_term = numerics::max_abs(result.term_magnitudes.effort);
  for (const auto member : {&results::TermMagnitudes::moment, &results::TermMagnitudes::kinetic_energy,
                            &results::TermMagnitudes::potential_energy})
    largest_term = std::max(largest_term, numerics::max_abs(result.term_magnitudes.*member));
  const double largest_effort = numerics::max_abs(result.torque.rightCols(columns));
  const std::size_t kept = result.actuator_names.size() - free;
  truncate_actuators(kept, result);
  truncate_actuators(kept, intermediate_samples.rows);
  if (largest_effort <= free_effort_tolerance * largest_term) return "";
  char text[200];
  std::snprintf(text, sizeof text,
                "the motion of the free coordinates does not follow the dynamics: efforts up to %.3g would be needed "
                "along them, of terms up to %.3g",
                largest_effort, largest_term);
  return text;
}

/// "B from -0.1 to 0.73 rad", at all times that were visited.
std::string describe_range(const RunResult& result, CoordinateId coordinate) {
  const auto column = static_cast<Eigen::Index>(coordinate);
  VectorX values = result.joint_position.col(column);
  if (result.intermediate) {
    const auto rows = static_cast<Eigen::Index>(result.intermediate->next_sample.size());
    values.conservativeResize(values.size() + rows);
    values.tail(rows) = result.intermediate->rows.joint_position.col(column).head(rows);
  }
  const double round_off = column_round_off(result, &RunResult::joint_position, column);
  char range[80];
  std::snprintf(range, sizeof range, " from %.6g to %.6g ",
                results::suppress_round_off(round_off, numerics::min_coefficient(values)),
                results::suppress_round_off(round_off, numerics::max_coefficient(values)));
  const auto c = static_cast<std::size_t>(coordinate);
  return result.coordinate_names[c] + range + result.coordinate_units[c];
}

}  // namespace

RunResult RunRecorder::record(trajectory::MotionSource& source, const results::RecordedContents& contents,
                              long samples_per_report) {
  if (source.outcome().status != MotionStatus::done) return without_samples(source.outcome());
  const trajectory::PrescribedMotion& motion = source.prescribed_motion();
  RunResult result;
  results::IntermediateSamples intermediate_samples;
  name_columns(mechanism_, result);
  name_columns(mechanism_, intermediate_samples.rows);
  result.moment_reference = trajectory_.about;
  resize_arrays(mechanism_, trajectory_.samples, contents, result);
  resize_arrays(mechanism_, max_intermediate_rows(motion, trajectory_.samples), contents, intermediate_samples.rows);
  results::ResultRecorder recorder(result);
  const auto write = [&](RunResult& rows, long row) {
    if (!source.evaluate()) return false;
    recorder.write(source.sample(), row, rows);
    take_sample(row);
    return true;
  };
  const model::PayloadIntervals intervals(mechanism_, motion.duration());
  int interval = intervals.index_at(0);
  // after a jump, with its near side evaluated last
  const auto add_payload_events = [&] {
    const int before = std::exchange(interval, intervals.index_at(source.time()));
    if (interval == before) return;
    const VectorX effort = source.sample().effort;
    if (!source.evaluate()) return;  // writing this moment fails in the same way
    const auto payload_motion = [&](std::size_t a) {
      const Attachment& payload = mechanism_.attachments[a];
      return PayloadMotion{source.point_speed(payload.body, payload.position), source.angular_speed(payload.body)};
    };
    add_payload_changes(mechanism_, intervals, {source.time(), before, interval, effort, source.sample().effort},
                        payload_motion, result);
  };
  const bool is_completed =
      visit_time_grid(source, trajectory_.samples, [&](const trajectory::TimeGridPoint& grid_point) {
        const bool is_after_jump = grid_point.kind == trajectory::TimeGridPoint::Kind::after_jump;
        if (is_after_jump) add_payload_events();
        if (progress_ && grid_point.index % samples_per_report == samples_per_report - 1)
          progress_(static_cast<double>(grid_point.index) / static_cast<double>(trajectory_.samples));
        if (grid_point.kind == trajectory::TimeGridPoint::Kind::sample) return write(result, grid_point.index);
        if (is_after_jump && grid_point.has_coincident_next) return true;
        return write(intermediate_samples.rows, intermediate_samples.add(grid_point.next_sample));
      });
  if (!is_completed) return without_samples(source.outcome());
  set_term_magnitudes(result);
  if (const std::string issue =
          leave_out_free_coordinates(count_free_coordinates(trajectory_), result, intermediate_samples);
      !issue.empty())
    return without_samples({MotionStatus::unreachable, motion.duration(), issue, {}});
  add_metrics(result, intermediate_samples);
  add_adaptation_moves(mechanism_, trajectory_.courses, intermediate_samples, result);
  if (const auto overflow = find_overflow(result, intermediate_samples, mechanism_)) return without_samples(*overflow);
  clear_round_off(result);
  sample_phase_plane(motion, result.phase_plane);
  result.outcome = {MotionStatus::done, motion.duration(), "", actuation_notes()};
  if (const std::string note = check_sampling_density(result, intermediate_samples); !note.empty())
    result.outcome.notes.push_back(note);
  for (std::string& note : motion_notes()) result.outcome.notes.push_back(std::move(note));
  add_payload_notes(mechanism_, motion.duration(), result);
  results::add_travel_notes(mechanism_, result);
  record_torque_distribution(mechanism_, intermediate_samples.rows, intermediate_samples.next_sample.size(),
                             results::EffortOrigin::motion, result);
  result.intermediate = std::make_shared<const results::IntermediateSamples>(std::move(intermediate_samples));
  return result;
}

namespace {

RunResult run_free_motion(const Mechanism& mechanism, const Trajectory& trajectory, const Run& run) {
  const SolvedFreeMotion solved = solve_free_motion(mechanism, trajectory);
  if (solved.outcome.status != MotionStatus::done) return without_samples(solved.outcome);
  RunResult result = run_resolved(solved.mechanism, solved.trajectory, run);
  if (result.outcome.status != MotionStatus::done) return result;
  std::vector<std::string> notes = solved.outcome.notes;
  std::string ranges;
  for (const CoordinateId coordinate : trajectory.free_motion->free)
    ranges += (ranges.empty() ? "" : ", ") + describe_range(result, coordinate);
  notes.push_back("moved by the dynamics: " + ranges);
  result.outcome.notes.insert(result.outcome.notes.begin(), notes.begin(), notes.end());
  return result;
}

}  // namespace

RunResult run_resolved(const Mechanism& mechanism, const Trajectory& trajectory, const Run& run) {
  if (!trajectory.adaptations.empty()) {
    const trajectory::AdaptedMotion adapted = model_adaptations(mechanism, trajectory);
    return run_resolved(adapted.mechanism, adapted.trajectory, run);
  }
  check_timing(trajectory);
  if (trajectory.free_motion) return run_free_motion(mechanism, trajectory, run);
  const time_optimal::ResolvedTrajectory resolved = time_optimal::resolve_trajectory(mechanism, trajectory);
  if (resolved.outcome.status != MotionStatus::done) return without_samples(resolved.outcome);
  RunResult result = run(mechanism, resolved.trajectory);
  if (result.outcome.status == MotionStatus::mismatch && trajectory.drive == DriveKind::joints &&
      !std::holds_alternative<trajectory::TablePath>(trajectory.path))
    if (const std::string reason = explain_undriven_coordinates(mechanism, trajectory); !reason.empty())
      result.outcome.reason += "; " + reason;
  result.optimised_law = resolved.optimised_law;
  result.corridor_result = resolved.corridor;
  result.phase_plane.mvc_path_parameter = resolved.phase_plane.mvc_path_parameter;
  result.phase_plane.mvc_path_rate = resolved.phase_plane.mvc_path_rate;
  return result;
}

}  // namespace balance::simulation
