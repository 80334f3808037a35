#include "balance/natural/plan.hpp"

#include "balance/model/payload_stretches.hpp"
#include "balance/motion/course.hpp"
#include "balance/natural/stepper.hpp"

namespace balance::natural {

bool has_tool_angle(const Mechanism& mechanism, const Trajectory& trajectory) {
  return mechanism.tool && (trajectory.drive != DriveKind::joints || trajectory.from.angle || trajectory.to.angle);
}

namespace {

class NaturalTrajectoryCompiler {
 public:
  NaturalTrajectoryCompiler(const Mechanism& mechanism, const NaturalModel& model, const Trajectory& trajectory)
      : mechanism_(mechanism), model_(model), trajectory_(trajectory) {}

  NaturalCompiledTrajectory run() {
    if (start_pose() && pick_drive() && end_values() && make_schedule()) plan_.outcome.status = MotionStatus::done;
    return std::move(plan_);
  }

 private:
  bool fail(MotionStatus status, std::string reason, double time = 0) {
    plan_.outcome = {status, time, std::move(reason), {}};
    return false;
  }

  NaturalKinematicEquations equations(const DriveQuantities& quantities) const {
    return {model_, make_drive_rows(mechanism_, model_, quantities)};
  }

  static VectorX values(const DriveQuantities& quantities, const PoseTarget& pose) {
    DriveValue none;
    none.value.setZero(quantities.value_count());
    return read_pose_values(quantities, pose, none).value;
  }

  /// The caller's start, made to meet the constraints and what `from` states. A table has its own start.
  bool start_pose() {
    const bool table = std::holds_alternative<TablePath>(trajectory_.path);
    const PoseTarget from = table ? PoseTarget{} : trajectory_.from;
    const DriveQuantities stated = list_pose_quantities(mechanism_, from);
    plan_.start = model_.start;
    if (!equations(stated).solve_least_norm(plan_.start, values(stated, from)))
      return fail(MotionStatus::not_assembled, "the mechanism cannot be assembled near the start that was given");
    plan_.freedoms = model_.unknowns() - find_generic_constraint_rank(model_, plan_.start);
    return true;
  }

  bool pick_drive() {
    plan_.quantities = choose_drive_quantities(mechanism_, trajectory_, plan_.freedoms);
    if (!plan_.quantities.mismatch.empty()) return fail(MotionStatus::mismatch, plan_.quantities.mismatch);
    return true;
  }

  DriveValue measured(const NaturalCoordinates& position) const {
    DriveValue value;
    value.value = equations(plan_.quantities).measure(position);
    return value;
  }

  bool end_values() {
    request_.from = read_pose_values(plan_.quantities, trajectory_.from, measured(plan_.start));
    request_.to = request_.from;
    if (is_end_prescribed(plan_.quantities, trajectory_)) {
      request_.to = read_pose_values(plan_.quantities, trajectory_.to, request_.from);
      return true;
    }
    return track_to_end_pose();
  }

  /// `to` is stated in other quantities than the drive's: go there straight in those and look.
  bool track_to_end_pose() {
    const DriveQuantities stated = list_pose_quantities(mechanism_, trajectory_.to);
    PrescribedMotion::Request way;
    way.law.kind = MotionLawKind::uniform;
    way.from.value = equations(stated).measure(plan_.start);
    way.to.value = values(stated, trajectory_.to);
    const PrescribedMotion schedule(way);
    NaturalStepper stepper(model_, make_drive_rows(mechanism_, model_, stated), schedule, plan_.freedoms);
    constexpr int end_pose_steps = 32;
    bool there = stated.value_count() == plan_.freedoms && stepper.begin(plan_.start);
    for (int k = 1; k <= end_pose_steps && there; ++k) there = stepper.advance(static_cast<double>(k) / end_pose_steps);
    if (!there)
      return fail(MotionStatus::unreachable,
                  "the end pose (to) cannot be reached from the start pose without leaving the assembly mode",
                  trajectory_.duration);
    request_.to = measured(stepper.state().position);
    return true;
  }

  bool make_schedule() {
    request_.law = trajectory_.law;
    request_.path = trajectory_.path;
    request_.duration = trajectory_.duration;
    const std::vector<int>& place = plan_.quantities.point.empty() ? plan_.quantities.com : plan_.quantities.point;
    request_.position_components = place.size() == 2 ? 2 : 0;
    if (const auto* way = std::get_if<WaypointPath>(&trajectory_.path))
      for (const PoseTarget& point : way->points)
        request_.via.push_back(
            read_pose_values(plan_.quantities, point, request_.via.empty() ? request_.from : request_.via.back()));
    add_secondary_tasks(trajectory_, plan_.quantities, request_);
    request_.switch_times = payload_switch_times(mechanism_);
    plan_.schedule.emplace(request_);
    return true;
  }

  const Mechanism& mechanism_;
  const NaturalModel& model_;
  const Trajectory& trajectory_;
  NaturalCompiledTrajectory plan_;
  PrescribedMotion::Request request_;
};

}  // namespace

NaturalCompiledTrajectory compile_natural_trajectory(const Mechanism& mechanism, const NaturalModel& model,
                                                     const Trajectory& trajectory) {
  return NaturalTrajectoryCompiler(mechanism, model, trajectory).run();
}

}  // namespace balance::natural
