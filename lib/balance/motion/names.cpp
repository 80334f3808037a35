#include "balance/motion/names.hpp"

namespace balance {

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
  const bool by_table =
      std::holds_alternative<TablePath>(trajectory.path) && !is_mechanism_dependent(trajectory.law.kind);
  return by_table ? "table" : name_of(trajectory.law.kind);
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

}  // namespace balance
