#include "balance/synthesis/verification/natural_simulation.hpp"

#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"
#include "balance/synthesis/verification/natural_equations.hpp"

#include <stdexcept>

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
    if (solve_start_pose() && choose_drive() && compute_end_values() && make_schedule())
      plan_.outcome.status = MotionStatus::done;
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
    DriveValue zero;
    zero.value.setZero(quantities.value_count());
    return read_pose_values(quantities, pose, zero).value;
  }

  /// Moves the caller's start to meet the constraints and the values stated in `from`. A table has its own start.
  bool solve_start_pose() {
    const bool is_table = std::holds_alternative<TablePath>(trajectory_.path);
    const PoseTarget from = is_table ? PoseTarget{} : trajectory_.from;
    const DriveQuantities quantities = list_pose_quantities(mechanism_, from);
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

  DriveValue measure_drive(const NaturalCoordinates& position) const {
    DriveValue value;
    value.value = equations(plan_.quantities).measure(position);
    return value;
  }

  bool compute_end_values() {
    request_.from = read_pose_values(plan_.quantities, trajectory_.from, measure_drive(plan_.start));
    request_.to = request_.from;
    if (is_end_prescribed(plan_.quantities, trajectory_)) {
      request_.to = read_pose_values(plan_.quantities, trajectory_.to, request_.from);
      return true;
    }
    return track_to_end_pose();
  }

  /// `to` is stated in other quantities than the drive's: moves there straight in these, and measures the drive's.
  bool track_to_end_pose() {
    const DriveQuantities quantities = list_pose_quantities(mechanism_, trajectory_.to);
    PrescribedMotion::Request request;
    request.law.kind = MotionLawKind::uniform;
    request.from.value = equations(quantities).measure(plan_.start);
    request.to.value = values(quantities, trajectory_.to);
    const PrescribedMotion schedule(request);
    NaturalStepper stepper(model_, make_drive_rows(mechanism_, model_, quantities), schedule, plan_.freedoms);
    constexpr int end_pose_steps = 32;
    bool is_reached = quantities.value_count() == plan_.freedoms && stepper.begin(plan_.start);
    for (int k = 1; k <= end_pose_steps && is_reached; ++k)
      is_reached = stepper.advance(static_cast<double>(k) / end_pose_steps);
    if (!is_reached)
      return fail(MotionStatus::unreachable,
                  "the end pose (to) cannot be reached from the start pose without leaving the assembly mode",
                  trajectory_.duration);
    request_.to = measure_drive(stepper.state().position);
    return true;
  }

  bool make_schedule() {
    request_.law = trajectory_.law;
    request_.path = trajectory_.path;
    request_.duration = trajectory_.duration;
    const std::vector<int>& components = plan_.quantities.point.empty() ? plan_.quantities.com : plan_.quantities.point;
    request_.position_components = components.size() == 2 ? 2 : 0;
    if (const auto* waypoints = std::get_if<WaypointPath>(&trajectory_.path))
      for (const PoseTarget& point : waypoints->points)
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

struct NaturalSimulation::Parts {
  Mechanism mechanism, current_mechanism;  ///< as stated; with the payloads of the current interval
  NaturalModel model;
  NaturalCompiledTrajectory plan;
  std::optional<NaturalStepper> stepper;
  std::optional<NaturalSampleEvaluator> observer;
  Vector3 about = Vector3::Zero();
};

NaturalSimulation::NaturalSimulation(const Mechanism& mechanism, const Trajectory& trajectory,
                                     const InitialCoordinates& start)
    : parts_(std::make_unique<Parts>()) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("natural coordinates are for planar mechanisms, this one is spatial");
  if (has_velocity_constraints(mechanism))
    throw std::invalid_argument("natural coordinates do not support constraints on speeds");
  Parts& p = *parts_;
  p.mechanism = mechanism;
  p.model = build_model(p.mechanism, prescribed_coordinates(trajectory), has_tool_angle(mechanism, trajectory), start);
  p.plan = compile_natural_trajectory(p.mechanism, p.model, trajectory);
  outcome_ = p.plan.outcome;
  if (outcome_.status != MotionStatus::done) return;
  p.about = trajectory.about;
  p.observer.emplace(p.mechanism, p.model, p.plan.freedoms, p.about);
  if (!p.observer->mismatch().empty()) {
    outcome_ = {MotionStatus::mismatch, 0, p.observer->mismatch(), {}};
    return;
  }
  p.stepper.emplace(p.model, make_drive_rows(p.mechanism, p.model, p.plan.quantities), *p.plan.schedule,
                    p.plan.freedoms);
}

NaturalSimulation::~NaturalSimulation() = default;

const PrescribedMotion& NaturalSimulation::schedule() const { return parts_->plan.schedule.value(); }

int NaturalSimulation::freedoms() const { return parts_->plan.freedoms; }

const std::vector<std::string>& NaturalSimulation::notes() const { return parts_->observer.value().notes(); }

bool NaturalSimulation::begin() {
  const Parts& p = *parts_;
  parts_->stepper.value().set_actuation_matrix([&p](const NaturalCoordinates& position) {
    return p.observer->actuation_matrix(p.stepper->equations(), position);
  });
  if (parts_->stepper->begin(p.plan.start)) return true;
  outcome_ = parts_->stepper->outcome();
  return false;
}

bool NaturalSimulation::advance(double time) {
  if (parts_->stepper.value().advance(time)) return true;
  outcome_ = parts_->stepper->outcome();
  return false;
}

double NaturalSimulation::time() const { return parts_->stepper.value().time(); }

void NaturalSimulation::update_accelerations(Side side) { parts_->stepper.value().accelerate(side); }

/// The mass matrix is constant within an interval.
void NaturalSimulation::apply_payloads(const PayloadIntervals& intervals, int interval) {
  Parts& p = *parts_;
  if (!has_temporary_payloads(p.mechanism)) return;
  p.current_mechanism = mechanism_in_interval(p.mechanism, intervals, interval);
  p.model.mass.clear();
  p.model.rotors.clear();
  p.model.ground_disc_moment = 0;
  add_masses(p.current_mechanism, p.model);
  p.observer.emplace(p.current_mechanism, p.model, p.plan.freedoms, p.about);
}

double NaturalSimulation::speed_of(BodyId body, const Vector3& point) const {
  const NaturalModel& model = parts_->model;
  const AffineForm form = model.bodies[static_cast<std::size_t>(body)].place(to_complex(point, model.length()));
  return model.length() * std::abs(form.rate(parts_->stepper.value().state().velocity));
}

double NaturalSimulation::angular_speed_of(BodyId body) const {
  return std::abs(parts_->stepper.value().angular_velocity(body));
}

bool NaturalSimulation::observe() {
  Parts& p = *parts_;
  if (p.observer.value().observe(p.stepper.value())) return true;
  outcome_ = make_actuation_singularity_outcome(time(), "");
  return false;
}

const Sample& NaturalSimulation::last() const { return parts_->observer.value().last(); }

int NaturalSimulation::iterations() const { return parts_->stepper.value().iterations(); }

}  // namespace balance::natural
