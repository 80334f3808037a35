#include "balance/motion/plan.hpp"

#include "balance/base/rotation.hpp"
#include "balance/model/payload_stretches.hpp"
#include "balance/motion/com_drive.hpp"
#include "balance/motion/course.hpp"
#include "balance/motion/drive_choice.hpp"
#include "balance/motion/missing_start.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance {

namespace {

/// A circle or arc in the coordinate plane of two components.
Path project_path(Path path, int a, int b) {
  const auto flat = [&](const Vector3& v) { return Vector3(v[a], v[b], 0); };
  if (auto* circle = std::get_if<CirclePath>(&path)) {
    const Vector3 across = Vector3::Unit(a).cross(Vector3::Unit(b));
    circle->normal = flat(circle->normal) + circle->normal.dot(across) * Vector3::UnitZ();
    circle->centre = flat(circle->centre);
  } else if (auto* arc = std::get_if<ArcPath>(&path)) {
    arc->via = flat(arc->via);
  }
  return path;
}

MotionOutcome make_failure(MotionStatus status, std::string reason) { return {status, 0, std::move(reason), {}}; }

}  // namespace

PrescribedMotion::Request make_prescribed_motion_request(const Trajectory& trajectory,
                                                         const DriveQuantities& quantities, DriveValue from,
                                                         DriveValue to) {
  PrescribedMotion::Request request;
  request.law = trajectory.law;
  request.duration = trajectory.duration;
  request.from = std::move(from), request.to = std::move(to);
  const std::vector<int>& place = quantities.point.empty() ? quantities.com : quantities.point;
  request.position_components = place.size() < 2 ? 0 : static_cast<int>(place.size());
  request.path = place.size() == 2 ? project_path(trajectory.path, place[0], place[1]) : trajectory.path;
  request.has_rotation = !quantities.rotation.empty();
  if (const auto* way = std::get_if<WaypointPath>(&trajectory.path))
    for (const PoseTarget& point : way->points)
      request.via.push_back(
          read_pose_values(quantities, point, request.via.empty() ? request.from : request.via.back()));
  add_secondary_tasks(trajectory, quantities, request);
  return request;
}

namespace {

template <class S>
class TrajectoryCompiler {
 public:
  TrajectoryCompiler(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory)
      : mechanism_(mechanism), tree_(tree), trajectory_(trajectory) {}

  CompiledTrajectory<S> run() {
    if (check_com() && start_pose() && choose_drive() && find_end_values() && make_schedule())
      plan_.outcome.status = MotionStatus::done;
    return std::move(plan_);
  }

 private:
  bool fail(const MotionOutcome& outcome) {
    plan_.outcome = outcome;
    return false;
  }

  /// Said before a start is looked for: where the centre of mass stands still, none would be found.
  bool check_com() {
    if (trajectory_.drive != DriveKind::com) return true;
    ConstraintSystem<S> closures(tree_, Drive<S>{});
    const AssemblySolution assembled = solve_pose(mechanism_, tree_, closures, {});
    if (!assembled.found) return true;
    const int freedoms = tree_.columns - find_generic_closure_rank(tree_, assembled.y);
    const DriveQuantities quantities =
        balance::choose_drive(mechanism_, tree_, trajectory_, assembled.y, freedoms).quantities;
    if (!quantities.mismatch.empty()) return true;
    const std::string reason = check_com_mobility(tree_, assembled.y, quantities.com);
    return reason.empty() || fail(make_failure(MotionStatus::mismatch, reason));
  }

  bool start_pose() {
    const PoseEquations<S> from = make_pose_equations(mechanism_, tree_, trajectory_.from);
    ConstraintSystem<S> system(tree_, from.drive);
    const AssemblySolution start = solve_pose(mechanism_, tree_, system, from.target);
    if (!start.found) return fail(explain_assembly_failure(mechanism_, tree_, start, trajectory_.from));
    plan_.start = start.y;
    const int rank = find_generic_closure_rank(tree_, start.y);
    plan_.freedoms = tree_.columns - rank;
    plan_.has_redundant_closures = tree_.closure_rows > rank;
    configuration_freedoms_ = tree_.columns - find_generic_position_rank(tree_, start.y);
    if (from.drive.row_count() < plan_.freedoms && !std::holds_alternative<TablePath>(trajectory_.path))
      return fail(make_failure(MotionStatus::mismatch, "the start pose (from) states " +
                                                           std::to_string(from.drive.row_count()) +
                                                           " values, but the mechanism has " +
                                                           std::to_string(plan_.freedoms) + " degrees of freedom"));
    return true;
  }

  bool choose_drive() {
    choice_ = balance::choose_drive(mechanism_, tree_, trajectory_, plan_.start, plan_.freedoms);
    const std::string& mismatch = choice_.quantities.mismatch;
    if (!mismatch.empty()) return fail(make_failure(MotionStatus::mismatch, mismatch));
    plan_.drive = choice_.drive;
    plan_.quantities = choice_.quantities;
    return true;
  }

  DriveValue measure_drive_at(const VectorX& y) const {
    ConstraintSystem<S> system(tree_, choice_.drive);
    VectorX residual;
    SparseMatrix jacobian;
    DriveSample zero;
    zero.value.setZero(choice_.drive.value_count());
    system.evaluate(y, zero, residual, jacobian);
    const DriveSample sample = system.measure(y);
    return {sample.value, sample.rotation};
  }

  bool find_end_values() {
    plan_.request.from = read_pose_values(choice_.quantities, trajectory_.from, measure_drive_at(plan_.start));
    plan_.request.to = plan_.request.from;
    if (is_end_prescribed(choice_.quantities, trajectory_)) {
      plan_.request.to = read_pose_values(choice_.quantities, trajectory_.to, plan_.request.from);
      return true;
    }
    if (configuration_freedoms_ > plan_.freedoms)
      return fail(
          make_failure(MotionStatus::mismatch,
                       "the end pose (to) must state what is driven: rates are bound, so that the way there decides "
                       "about everything else"));
    // `to` is stated in other quantities than the drive's: go there and look
    const PoseEquations<S> to = make_pose_equations(mechanism_, tree_, trajectory_.to);
    ConstraintSystem<S> system(tree_, to.drive);
    VectorX residual;
    SparseMatrix jacobian;
    system.evaluate(plan_.start, to.target, residual, jacobian);
    const AssemblySolution end = track_to(system, plan_.start, system.measure(plan_.start), to.target);
    if (!end.found)
      return fail({MotionStatus::unreachable,
                   trajectory_.duration,
                   "the end pose (to) cannot be reached from the start pose without leaving the assembly mode",
                   {}});
    plan_.request.to = measure_drive_at(end.y);
    plan_.end = end.y;
    return true;
  }

  bool make_schedule() {
    plan_.request =
        make_prescribed_motion_request(trajectory_, choice_.quantities, plan_.request.from, plan_.request.to);
    plan_.request.switch_times = payload_switch_times(mechanism_);
    plan_.prescribed_motion.emplace(plan_.request);
    DriveSample first;
    plan_.prescribed_motion->at(0, Side::after, first);
    ConstraintSystem<S> system(tree_, choice_.drive);
    AssemblySolution start = solve_assembly(system, plan_.start, first);
    if (!start.found && std::holds_alternative<TablePath>(trajectory_.path))
      start = solve_pose(mechanism_, tree_, system, first);
    if (!start.found)
      return fail(
          make_failure(MotionStatus::unreachable, "the first prescribed values cannot be reached from the start pose"));
    plan_.start = start.y;
    return true;
  }

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  const Trajectory& trajectory_;
  CompiledTrajectory<S> plan_;
  int configuration_freedoms_ = 0;  ///< freedoms of the configuration: more than the rates', where something rolls
  DriveChoice<S> choice_;
};

}  // namespace

template <class S>
CompiledTrajectory<S> compile_trajectory(const Mechanism& mechanism, const Tree<S>& tree,
                                         const Trajectory& trajectory) {
  return TrajectoryCompiler<S>(mechanism, tree, trajectory).run();
}

template CompiledTrajectory<Planar> compile_trajectory<Planar>(const Mechanism&, const Tree<Planar>&,
                                                               const Trajectory&);
template CompiledTrajectory<Spatial> compile_trajectory<Spatial>(const Mechanism&, const Tree<Spatial>&,
                                                                 const Trajectory&);

}  // namespace balance
