#include "balance/motion/plan.hpp"

#include "balance/base/rotation.hpp"
#include "balance/motion/drive_choice.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

namespace balance {

std::vector<int> prescribed_coordinates(const Trajectory& trajectory) {
  std::vector<int> coordinates = trajectory.remaining;
  const auto add = [&](const PoseTarget& pose) {
    for (const CoordinateValue& joint : pose.joints) coordinates.push_back(joint.coordinate);
  };
  add(trajectory.from);
  add(trajectory.to);
  if (const auto* way = std::get_if<WaypointPath>(&trajectory.path))
    for (const PoseTarget& point : way->points) add(point);
  return coordinates;
}

namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

MotionOutcome failed(MotionStatus status, std::string reason) { return {status, 0, std::move(reason), {}}; }

/// Why no start configuration was found: do the loops close at all?
template <class S>
MotionOutcome explain_missing_start(const Mechanism& mechanism, const Tree<S>& tree, const Solution& attempt) {
  System<S> closures(tree, Drive<S>{});
  const Solution loops = find_pose(mechanism, tree, closures, {});
  if (!loops.found) {
    std::string worst;
    double gap = -1;
    for (const Closure<S>& closure : tree.closures) {
      const ClosurePose<S> pose = closure_pose(closures.state(), closure);
      const double miss = (pose.p_B - pose.p_A).norm();
      if (miss > gap) gap = miss, worst = mechanism.joints[closure.joint].name;
    }
    return failed(MotionStatus::not_assembled,
                  "the loops cannot be closed: joint " + worst + " stays open by " + number(gap) + " m at best");
  }
  return failed(MotionStatus::unreachable,
                "the start pose cannot be reached: the nearest configuration found misses it by " +
                    number(attempt.residual * tree.length) + " (m or, times the length, rad)");
}

/// Prescribed values that a pose states for a drive; whatever it leaves out is taken from `base`.
template <class S>
DriveValue stated_values(const DriveChoice<S>& choice, const PoseTarget& pose, const DriveValue& base) {
  DriveValue out = base;
  int k = 0;
  for (const int component : choice.drive.point) {
    if (pose.tool) out.value[k] = (*pose.tool)[component];
    ++k;
  }
  for (const int component : choice.drive.com) {
    if (pose.com) out.value[k] = (*pose.com)[component];
    ++k;
  }
  if (choice.tool_angle) {
    if (pose.angle) out.value[k] = *pose.angle;
    ++k;
  }
  for (const int coordinate : choice.coordinates) {
    for (const CoordinateValue& joint : pose.joints)
      if (joint.coordinate == coordinate) out.value[k] = joint.value;
    ++k;
  }
  if (pose.orientation) out.rotation = *pose.orientation;
  return out;
}

/// The pose says everything that the drive prescribes, so that no configuration has to be found for it.
template <class S>
bool states_all(const DriveChoice<S>& choice, const PoseTarget& pose) {
  return (choice.drive.point.empty() || pose.tool) && (choice.drive.com.empty() || pose.com) &&
         (!choice.tool_angle || pose.angle) && (choice.drive.rotation.empty() || pose.orientation) &&
         std::all_of(choice.coordinates.begin(), choice.coordinates.end(), [&](int coordinate) {
           return std::any_of(pose.joints.begin(), pose.joints.end(),
                              [&](const CoordinateValue& joint) { return joint.coordinate == coordinate; });
         });
}

template <class S>
class Planner {
 public:
  Planner(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory)
      : mechanism_(mechanism), tree_(tree), trajectory_(trajectory) {}

  Plan<S> run() {
    if (start_pose() && pick_drive() && end_values() && make_schedule()) plan_.outcome.status = MotionStatus::done;
    return std::move(plan_);
  }

 private:
  bool fail(MotionOutcome outcome) {
    plan_.outcome = std::move(outcome);
    return false;
  }

  bool start_pose() {
    const PoseEquations<S> from = pose_equations(mechanism_, tree_, trajectory_.from);
    System<S> system(tree_, from.drive);
    const Solution start = find_pose(mechanism_, tree_, system, from.target);
    if (!start.found) return fail(explain_missing_start(mechanism_, tree_, start));
    plan_.start = start.y;
    const RankReport rank = generic_closure_rank(tree_, start.y);
    plan_.freedoms = tree_.columns - rank.rank;
    plan_.redundant = tree_.closure_rows > rank.rank;
    if (from.drive.rows() < plan_.freedoms && !std::holds_alternative<TablePath>(trajectory_.path))
      return fail(failed(MotionStatus::mismatch, "the start pose (from) states " + std::to_string(from.drive.rows()) +
                                                     " values, but the mechanism has " +
                                                     std::to_string(plan_.freedoms) + " degrees of freedom"));
    return true;
  }

  bool pick_drive() {
    choice_ = choose_drive(mechanism_, tree_, trajectory_, plan_.freedoms);
    if (!choice_.mismatch.empty()) return fail(failed(MotionStatus::mismatch, choice_.mismatch));
    plan_.drive = choice_.drive;
    return true;
  }

  DriveValue measured(const VectorX& y) const {
    System<S> system(tree_, choice_.drive);
    VectorX residual;
    MatrixX jacobian;
    DriveSample zero;
    zero.value.setZero(choice_.drive.values());
    system.evaluate(y, zero, residual, jacobian);
    const DriveSample sample = system.measure(y);
    return {sample.value, sample.rotation};
  }

  bool end_values() {
    request_.from = stated_values(choice_, trajectory_.from, measured(plan_.start));
    request_.to = request_.from;
    const bool ends_itself =
        std::holds_alternative<TablePath>(trajectory_.path) || std::holds_alternative<CirclePath>(trajectory_.path);
    if (ends_itself || states_all(choice_, trajectory_.to) || same_quantities()) {
      request_.to = stated_values(choice_, trajectory_.to, request_.from);
      return true;
    }
    // `to` is stated in other quantities than the drive's: go there and look
    const PoseEquations<S> to = pose_equations(mechanism_, tree_, trajectory_.to);
    System<S> system(tree_, to.drive);
    VectorX residual;
    MatrixX jacobian;
    system.evaluate(plan_.start, to.target, residual, jacobian);
    const Solution end = continue_to(system, plan_.start, system.measure(plan_.start), to.target);
    if (!end.found)
      return fail({MotionStatus::unreachable,
                   trajectory_.duration,
                   "the end pose (to) cannot be reached from the start pose without leaving the assembly mode",
                   {}});
    request_.to = measured(end.y);
    return true;
  }

  /// `to` speaks of the drive's own quantities, if not of all of them: the others stay.
  bool same_quantities() const {
    const PoseTarget& to = trajectory_.to;
    switch (trajectory_.drive) {
      case DriveKind::joints: return !to.joints.empty();
      case DriveKind::tool: return (to.tool || choice_.drive.point.empty()) && trajectory_.remaining.empty();
      case DriveKind::com: return to.com && !to.tool && to.joints.empty();
    }
    return false;
  }

  bool make_schedule() {
    request_.law = trajectory_.law;
    request_.path = trajectory_.path;
    request_.duration = trajectory_.duration;
    const std::vector<int>& place = choice_.drive.point.empty() ? choice_.drive.com : choice_.drive.point;
    request_.position_components = static_cast<int>(place.size()) == S::dimension ? S::dimension : 0;
    request_.turns = !choice_.drive.rotation.empty();
    if (const auto* way = std::get_if<WaypointPath>(&trajectory_.path))
      for (const PoseTarget& point : way->points)
        request_.via.push_back(
            stated_values(choice_, point, request_.via.empty() ? request_.from : request_.via.back()));
    plan_.schedule.emplace(request_);
    DriveSample first;
    plan_.schedule->at(0, Side::after, first);
    System<S> system(tree_, choice_.drive);
    Solution start = solve(system, plan_.start, first);
    if (!start.found && std::holds_alternative<TablePath>(trajectory_.path))
      start = find_pose(mechanism_, tree_, system, first);
    if (!start.found)
      return fail(
          failed(MotionStatus::unreachable, "the first prescribed values cannot be reached from the start pose"));
    plan_.start = start.y;
    return true;
  }

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  const Trajectory& trajectory_;
  Plan<S> plan_;
  DriveChoice<S> choice_;
  Schedule::Request request_;
};

}  // namespace

template <class S>
Plan<S> make_plan(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory) {
  return Planner<S>(mechanism, tree, trajectory).run();
}

template Plan<Planar> make_plan<Planar>(const Mechanism&, const Tree<Planar>&, const Trajectory&);
template Plan<Spatial> make_plan<Spatial>(const Mechanism&, const Tree<Spatial>&, const Trajectory&);

}  // namespace balance
