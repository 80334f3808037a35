#include "balance/write/names.hpp"

namespace balance {

const char* name_of(LawKind kind) {
  switch (kind) {
    case LawKind::cycloidal: return "cycloidal";
    case LawKind::bang_bang: return "bang-bang";
    case LawKind::uniform: return "uniform";
    case LawKind::cubic: return "cubic";
    case LawKind::polynomial_345: return "3-4-5";
    case LawKind::polynomial_4567: return "4-5-6-7";
    case LawKind::harmonic: return "harmonic";
    case LawKind::modified_sine: return "modified-sine";
    case LawKind::modified_trapezoidal: return "modified-trapezoidal";
    case LawKind::trapezoidal_velocity: return "trapezoidal-velocity";
  }
  return "";
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
  }
  return "";
}

const char* name_of(ConditionsStatus status) {
  switch (status) {
    case ConditionsStatus::unsolved: return "unsolved";
    case ConditionsStatus::done: return "done";
    case ConditionsStatus::not_assembled: return "not-assembled";
    case ConditionsStatus::mismatch: return "mismatch";
    case ConditionsStatus::rank_unclear: return "rank-unclear";
  }
  return "";
}

const char* name_of(DesignStatus status) {
  switch (status) {
    case DesignStatus::unsolved: return "unsolved";
    case DesignStatus::balanced: return "balanced";
    case DesignStatus::compromise: return "compromise";
    case DesignStatus::impossible: return "impossible";
    case DesignStatus::not_found: return "not-found";
    case DesignStatus::not_asked: return "not-asked";
  }
  return "";
}

const char* name_of(Optimality optimality) {
  switch (optimality) {
    case Optimality::not_asked: return "not-asked";
    case Optimality::proved_best: return "proved-best";
    case Optimality::local_best: return "local-best";
    case Optimality::stopped: return "stopped";
  }
  return "";
}

const char* name_of(DesignMethod method) {
  switch (method) {
    case DesignMethod::nothing_to_do: return "nothing-to-do";
    case DesignMethod::affine: return "affine";
    case DesignMethod::polynomial: return "polynomial";
    case DesignMethod::geometric: return "geometric";
  }
  return "";
}

std::string list_names(const std::vector<Goal>& goals) {
  std::string text;
  for (const Goal& goal : goals) text += (text.empty() ? "" : ", ") + name_of(goal);
  return text;
}

std::string in_words(const Goal& goal) {
  const auto meaning = [&]() -> std::string {
    switch (goal.kind) {
      case GoalKind::statics: return "at rest the actuators carry nothing";
      case GoalKind::gyroscopic:
        return "the actuators carry nothing at rest and feel no velocity terms, written in the accelerations of all "
               "tree "
               "coordinates";
      case GoalKind::gyroscopic_independent:
        return "the actuators carry nothing at rest and feel no velocity terms, written in their own accelerations";
      case GoalKind::decoupled:
        return "the actuators carry nothing at rest, feel no velocity terms and no acceleration but their own";
      case GoalKind::force: return "the frame feels no shaking force: the centre of mass stands still";
      case GoalKind::moment: return "the frame feels no shaking moment: the angular momentum is always zero";
      case GoalKind::dynamic: return "the frame feels neither shaking force nor shaking moment";
      case GoalKind::proportional:
        return "the centre of mass follows the tool: its velocity is a constant matrix times the tool's";
      case GoalKind::affine:
        return "the centre of mass follows the tool's body: it is a constant matrix times the tool's place, plus "
               "another times the body's rotation, plus a constant";
    }
    return "";
  };
  return meaning() + (goal.fully ? ", and feel the same inertia everywhere" : "");
}

}  // namespace balance
