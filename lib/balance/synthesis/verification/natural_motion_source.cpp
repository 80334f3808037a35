#include "balance/synthesis/verification/natural_motion_source.hpp"

#include <stdexcept>
#include <utility>

namespace balance::verification::natural {

namespace {

/// Whether the trajectory refers to the tool's angle, or may do so.
bool has_tool_angle(const Mechanism& mechanism, const Trajectory& trajectory) {
  return mechanism.tool && (trajectory.drive != DriveKind::joints || trajectory.from.angle || trajectory.to.angle);
}

class NaturalTrajectoryCompiler {
 public:
  NaturalTrajectoryCompiler(const Mechanism& mechanism, const NaturalModel& model, const Trajectory& trajectory)
      : mechanism_(mechanism), model_(model), trajectory_(trajectory) {}

  NaturalCompiledTrajectory run() {
    if (solve_start_pose() && choose_drive() && compute_end_values() && compile_prescribed_motion())
      plan_.outcome.status = MotionStatus::done;
    return std::move(plan_);
  }

 private:
  bool fail(MotionStatus status, std::string reason, double time = 0) {
    plan_.outcome = {status, time, std::move(reason), {}};
    return false;
  }

  NaturalKinematicEquations equations(const trajectory::DriveQuantities& quantities) const {
    return {model_, make_drive_rows(mechanism_, model_, quantities)};
  }

  static VectorX values(const trajectory::DriveQuantities& quantities, const trajectory::PoseTarget& pose) {
    trajectory::DriveValue zero;
    zero.value.setZero(quantities.value_count());
    return read_pose_values(quantities, pose, zero).value;
  }

  /// Moves the caller's start to meet the constraints and the values stated in `from`. A table has its own start.
  bool solve_start_pose() {
    const bool is_table = std::holds_alternative<trajectory::TablePath>(trajectory_.path);
    const trajectory::PoseTarget from = is_table ? trajectory::PoseTarget{} : trajectory_.from;
    const trajectory::DriveQuantities quantities = list_pose_quantities(mechanism_, from);
    plan_.start = model_.start;
    if (!equations(quantities).solve_least_norm(plan_.start, values(quantities, from)))
      return fail(MotionStatus::not_assembled, "the mechanism cannot be assembled near the given start");
    plan_.freedoms = model_.unknowns() - find_generic_constraint_rank(model_, plan_.start);
    return true;
  }

  bool choose_drive() {
    plan_.quantities = choose_drive_quantities(mechanism_, trajectory_, plan_.freedoms);
    if (!plan_.quantities.mismatch.empty()) return fail(MotionStatus::mismatch, plan_.quantities.mismatch);
    return true;
  }

  trajectory::DriveValue measure_drive(const NaturalCoordinates& position) const {
    trajectory::DriveValue value;
    value.value = equations(plan_.quantities).measure(position);
    return value;
  }

  bool compute_end_values() {
    from_ = read_pose_values(plan_.quantities, trajectory_.from, measure_drive(plan_.start));
    to_ = from_;
    if (is_end_prescribed(plan_.quantities, trajectory_)) {
      to_ = read_pose_values(plan_.quantities, trajectory_.to, from_);
      return true;
    }
    return track_to_end_pose();
  }

  /// `to` is stated in other quantities than the drive's: moves there straight in these, and measures the drive's.
  bool track_to_end_pose() {
    const trajectory::DriveQuantities quantities = list_pose_quantities(mechanism_, trajectory_.to);
    trajectory::PrescribedMotion::Request request;
    request.law.kind = MotionLawKind::uniform;
    request.from.value = equations(quantities).measure(plan_.start);
    request.to.value = values(quantities, trajectory_.to);
    const trajectory::PrescribedMotion schedule(request);
    NaturalStepper stepper(model_, make_drive_rows(mechanism_, model_, quantities), schedule, plan_.freedoms);
    constexpr int end_pose_steps = 32;
    bool is_reached = quantities.value_count() == plan_.freedoms && stepper.begin(plan_.start);
    for (int k = 1; k <= end_pose_steps && is_reached; ++k)
      is_reached = stepper.advance(static_cast<double>(k) / end_pose_steps);
    if (!is_reached)
      return fail(MotionStatus::unreachable,
                  "the end pose (to) cannot be reached from the start pose without leaving the assembly mode",
                  trajectory_.duration);
    to_ = measure_drive(stepper.state().position);
    return true;
  }

  bool compile_prescribed_motion() {
    trajectory::PrescribedMotion::Request request =
        make_prescribed_motion_request(trajectory_, plan_.quantities, from_, to_);
    const std::vector<double> payload_times = payload_switch_times(mechanism_);
    request.switch_times.insert(request.switch_times.end(), payload_times.begin(), payload_times.end());
    plan_.prescribed_motion.emplace(request);
    return true;
  }

  const Mechanism& mechanism_;
  const NaturalModel& model_;
  const Trajectory& trajectory_;
  NaturalCompiledTrajectory plan_;
  trajectory::DriveValue from_, to_;
};

}  // namespace

NaturalMotionSource::NaturalMotionSource(const Mechanism& mechanism, const Trajectory& trajectory,
                                         const InitialCoordinates& start)
    : mechanism_(mechanism), about_(trajectory.about) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("natural coordinates are for planar mechanisms, this one is spatial");
  if (has_velocity_constraints(mechanism))
    throw std::invalid_argument("natural coordinates do not support constraints on speeds");
  model_ = build_model(mechanism_, prescribed_coordinates(trajectory), has_tool_angle(mechanism, trajectory), start);
  plan_ = NaturalTrajectoryCompiler(mechanism_, model_, trajectory).run();
  outcome_ = plan_.outcome;
  if (outcome_.status != MotionStatus::done) return;
  evaluator_.emplace(mechanism_, model_, plan_.freedoms, about_);
  if (!evaluator_->mismatch().empty()) {
    outcome_ = {MotionStatus::mismatch, 0, evaluator_->mismatch(), {}};
    return;
  }
  intervals_.emplace(mechanism_, plan_.prescribed_motion->duration());
  stepper_.emplace(model_, make_drive_rows(mechanism_, model_, plan_.quantities), *plan_.prescribed_motion,
                   plan_.freedoms);
  stepper_->set_actuation_matrix([this](const NaturalCoordinates& position) {
    return evaluator_->actuation_matrix(stepper_->equations(), position);
  });
}

bool NaturalMotionSource::begin() { return stepper_ && check(stepper_->begin(plan_.start)); }

/// The mass matrix is constant within an interval.
bool NaturalMotionSource::update_payloads() {
  const int before = std::exchange(interval_, intervals_->index_at(time()));
  if (interval_ == before || !has_temporary_payloads(mechanism_)) return false;
  current_mechanism_ = mechanism_in_interval(mechanism_, *intervals_, interval_);
  model_.mass.clear();
  model_.rotors.clear();
  model_.ground_disc_moment = 0;
  add_masses(current_mechanism_, model_);
  evaluator_.emplace(current_mechanism_, model_, plan_.freedoms, about_);
  return true;
}

bool NaturalMotionSource::evaluate() {
  if (evaluator_->observe(*stepper_)) {
    sample_ = evaluator_->last();
    return true;
  }
  outcome_ = trajectory::make_actuation_singularity_outcome(time(), "");
  return false;
}

double NaturalMotionSource::point_speed(BodyId body, const Vector3& point) const {
  const AffineForm form = model_.bodies[static_cast<std::size_t>(body)].place(to_complex(point, model_.length()));
  return model_.length() * std::abs(form.rate(stepper_->state().velocity));
}

}  // namespace balance::verification::natural
