#include "balance/mechanics/trajectory/trajectory.hpp"

#include "balance/mechanics/trajectory/drive_quantities.hpp"

#include <cstdio>
#include <stdexcept>

namespace balance::trajectory {

std::string format_duration_range() {
  char text[64];
  std::snprintf(text, sizeof text, "a duration from %g s to %g s", min_duration, max_duration);
  return text;
}

namespace {

void check_duration(double duration) {
  if (is_valid_duration(duration)) return;
  char actual[40];
  std::snprintf(actual, sizeof actual, ", found %.6g s", duration);
  throw std::invalid_argument("expected " + format_duration_range() + actual);
}

void check_samples(long samples) {
  if (is_valid_sample_count(samples)) return;
  throw std::invalid_argument("expected from " + std::to_string(min_samples) + " to " + std::to_string(max_samples) +
                              " samples, found " + std::to_string(samples));
}

}  // namespace

double find_trajectory_duration(const Trajectory& trajectory) {
  const auto* table = std::get_if<TablePath>(&trajectory.path);
  return table == nullptr || is_mechanism_dependent(trajectory.law.kind) ? trajectory.duration
                                                                         : table->time.back() - table->time.front();
}

std::vector<double> list_move_times(const std::vector<CoordinateCourse>& courses) {
  std::vector<double> times;
  for (const CoordinateCourse& course : courses)
    for (const CoordinateMove& move : course.moves) times.insert(times.end(), {move.start, move.start + move.duration});
  return times;
}

void check_timing(const Trajectory& trajectory) {
  check_samples(trajectory.samples);
  check_duration(trajectory.duration);
}

void change_duration(Trajectory& trajectory, double duration) {
  check_duration(duration);
  if (trajectory.law.kind == MotionLawKind::time_optimal)
    throw std::invalid_argument("cannot be set for '" + trajectory.name + "', whose law determines it");
  if (std::holds_alternative<TablePath>(trajectory.path) && !is_mechanism_dependent(trajectory.law.kind))
    throw std::invalid_argument("cannot be set for '" + trajectory.name + "': its table has its own times");
  trajectory.duration = duration;
}

void change_samples(Trajectory& trajectory, long samples) {
  check_samples(samples);
  trajectory.samples = samples;
}

const char* name_of(MotionLawKind kind) {
  switch (kind) {
    case MotionLawKind::cycloidal: return "cycloidal";
    case MotionLawKind::bang_bang: return "bang-bang";
    case MotionLawKind::uniform: return "uniform";
    case MotionLawKind::cubic: return "cubic";
    case MotionLawKind::polynomial_345: return "3-4-5";
    case MotionLawKind::polynomial_4567: return "4-5-6-7";
    case MotionLawKind::harmonic: return "harmonic";
    case MotionLawKind::modified_sine: return "modified-sine";
    case MotionLawKind::modified_trapezoidal: return "modified-trapezoidal";
    case MotionLawKind::trapezoidal_velocity: return "trapezoidal-velocity";
    case MotionLawKind::time_optimal: return "fastest";
    case MotionLawKind::min_peak: return "gentlest";
    case MotionLawKind::constant_momentum: return "steady-momentum";
  }
  return "";
}

const char* law_name(const Trajectory& trajectory) {
  const bool is_table_timed =
      std::holds_alternative<TablePath>(trajectory.path) && !is_mechanism_dependent(trajectory.law.kind);
  if (is_table_timed) return "table";
  return drives_nothing(trajectory) ? "free" : name_of(trajectory.law.kind);
}

const char* name_of(DriveKind kind) {
  switch (kind) {
    case DriveKind::joints: return "joints";
    case DriveKind::tool: return "tool";
    case DriveKind::com: return "com";
  }
  return "";
}

const char* name_of(MotionStatus status) {
  switch (status) {
    case MotionStatus::unsolved: return "unsolved";
    case MotionStatus::done: return "done";
    case MotionStatus::not_assembled: return "not-assembled";
    case MotionStatus::unreachable: return "unreachable";
    case MotionStatus::drive_singularity: return "drive-singularity";
    case MotionStatus::constraint_singularity: return "constraint-singularity";
    case MotionStatus::actuation_singularity: return "actuation-singularity";
    case MotionStatus::assembly_jump: return "assembly-jump";
    case MotionStatus::mismatch: return "mismatch";
    case MotionStatus::overflow: return "overflow";
    case MotionStatus::limits_not_held: return "limits-not-held";
  }
  return "";
}

}  // namespace balance::trajectory
