#include "balance/motion/simulation/partly_driven_mechanism.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace balance::simulation {

using trajectory::Side;

namespace {

constexpr double min_rank_pivot = 1e-8;  // of the rates of coordinates: below this they depend on each other
constexpr double reliable_pivot = 1e-8;  // of the largest: above this partial pivoting is as good as complete

bool contains(const std::vector<CoordinateId>& list, CoordinateId coordinate) {
  return std::find(list.begin(), list.end(), coordinate) != list.end();
}

std::string list_names(const Mechanism& mechanism, const std::vector<CoordinateId>& coordinates) {
  std::string list;
  for (const CoordinateId coordinate : coordinates)
    list += (list.empty() ? "" : ", ") + mechanism.coordinates[static_cast<std::size_t>(coordinate)].name;
  return list;
}

/// The trajectory with the free and held coordinates at rest at their start.
Trajectory hold_undriven_coordinates(const Trajectory& original) {
  Trajectory trajectory = original;
  const trajectory::FreeMotion free = *std::exchange(trajectory.free_motion, std::nullopt);
  for (const auto* list : {&free.held, &free.free})
    for (const CoordinateId coordinate : *list) {
      const auto start = std::find_if(trajectory.from.joints.begin(), trajectory.from.joints.end(),
                                      [&](const CoordinateValue& value) { return value.coordinate == coordinate; });
      if (start == trajectory.from.joints.end())
        throw std::invalid_argument("the trajectory '" + trajectory.name + "' has no start values of free coordinates");
      trajectory.to.joints.push_back(*start);
      trajectory.courses.push_back({coordinate, {}});
    }
  return trajectory;
}

void require_supported(const Mechanism& mechanism, const Trajectory& trajectory, RateConstraints rate_constraints) {
  const auto refuse = [&](const std::string& reason) {
    throw std::invalid_argument("the trajectory '" + trajectory.name + "' cannot leave coordinates free: " + reason);
  };
  if (!trajectory.free_motion) throw std::invalid_argument("the trajectory has no free coordinates");
  if (trajectory.drive != DriveKind::joints) refuse("its drive is not 'joints'");
  if (is_mechanism_dependent(trajectory)) refuse("its law is found for the mechanism");
  if (rate_constraints == RateConstraints::refused && has_velocity_constraints(mechanism))
    refuse("the mechanism has constraints on speeds");
  if (model::PayloadIntervals(mechanism, find_trajectory_duration(trajectory)).count() > 1)
    refuse("payloads are taken up or set down on the way");
}

const trajectory::FreeMotion& supported_free_motion(const Mechanism& mechanism, const Trajectory& trajectory,
                                                    RateConstraints rate_constraints) {
  require_supported(mechanism, trajectory, rate_constraints);
  return *trajectory.free_motion;
}

}  // namespace

PartlyDrivenMechanism::PartlyDrivenMechanism(const Mechanism& mechanism, const Trajectory& trajectory,
                                             RateConstraints rate_constraints)
    : free_(supported_free_motion(mechanism, trajectory, rate_constraints)),
      mechanism_(mechanism),
      trajectory_(hold_undriven_coordinates(trajectory)),
      duration_(find_trajectory_duration(trajectory)) {
  if (compile() && check_friction() && release_actuators() && choose_actuators()) begin();
}

PartlyDrivenMechanism::PartlyDrivenMechanism(const Mechanism& mechanism, const Trajectory* trajectory, AllFree)
    : mechanism_(mechanism), outcome_{MotionStatus::done, 0, "", {}} {
  if (trajectory != nullptr) {
    trajectory_ = *trajectory;
    trajectory_.free_motion.reset();
    duration_ = find_trajectory_duration(trajectory_);
    if (!compile()) return;
  }
  if (release() && check_friction()) begin();
}

/// The first choice of free coordinates: driven joints, else independent coordinates.
bool PartlyDrivenMechanism::release() {
  const std::vector<CoordinateId> actuators = std::exchange(mechanism_.actuators, {});
  mechanism_.torque_distribution.reset();
  dynamics::ForwardOptions options;
  options.preferred = driven_.empty() ? actuators : driven_;
  if (start_.size() == 0) {
    start_.setZero(static_cast<Eigen::Index>(mechanism_.coordinates.size()));
    for (const CoordinateValue& value : mechanism_.assembly) start_[value.coordinate] = value.value;
  }
  dynamics::ForwardDynamics dynamics(mechanism_, options);
  outcome_ = dynamics.set_state(0, start_, VectorX::Zero(start_.size()));
  if (outcome_.status != MotionStatus::done) return false;
  free_.free = dynamics.independent();
  start_ = dynamics.position();
  if (motion_ && trajectory_.drive == DriveKind::joints && trajectory_.law.kind == MotionLawKind::uniform &&
      std::holds_alternative<trajectory::LinePath>(trajectory_.path)) {
    motion_->at(0, Side::after, sample_);
    for (std::size_t k = 0; k < driven_.size(); ++k)
      free_.rate.push_back({driven_[k], sample_.rate[static_cast<Eigen::Index>(k)]});
  }
  driven_ = free_.free;
  motion_.reset();
  return true;
}

void PartlyDrivenMechanism::begin() {
  dynamics::ForwardOptions options;
  options.preferred = driven_;
  dynamics_.emplace(mechanism_, options);
  const double length = characteristic_length(mechanism_);
  unit_.resize(count());
  for (Eigen::Index k = 0; k < count(); ++k) unit_[k] = coordinate(k).kind == CoordinateKind::length ? length : 1;
}

bool PartlyDrivenMechanism::fail(MotionStatus status, const std::string& reason) {
  outcome_ = {status, 0, reason, {}};
  return false;
}

bool PartlyDrivenMechanism::compile() {
  kinematics::dispatch_space(mechanism_.space, [&]<class S>(S) {
    kinematics::CompiledMotion<S> compiled(mechanism_, trajectory_);
    outcome_ = compiled.plan.outcome;
    if (outcome_.status != MotionStatus::done) return;
    motion_ = std::move(compiled.plan.prescribed_motion);
    driven_ = compiled.plan.quantities.coordinates;
    const std::vector<double> start = compute_coordinates(mechanism_, compiled.tree, compiled.plan.start);
    start_ = Eigen::Map<const VectorX>(start.data(), static_cast<Eigen::Index>(start.size()));
  });
  if (outcome_.status == MotionStatus::mismatch)
    if (const std::string reason = explain_undriven_coordinates(mechanism_, trajectory_); !reason.empty())
      outcome_.reason = reason;
  return outcome_.status == MotionStatus::done;
}

VectorX PartlyDrivenMechanism::free_start() const {
  VectorX position(count());
  for (Eigen::Index k = 0; k < count(); ++k) position[k] = start_[free_.free[k]];
  return position;
}

VectorX PartlyDrivenMechanism::free_rate() const {
  VectorX rate = VectorX::Zero(count());
  for (Eigen::Index k = 0; k < count(); ++k)
    for (const CoordinateValue& value : free_.rate)
      if (value.coordinate == free_.free[k]) rate[k] = value.value;
  return rate;
}

std::string explain_undriven_coordinates(const Mechanism& mechanism, const Trajectory& trajectory) {
  dynamics::ForwardOptions options;
  VectorX position = VectorX::Zero(static_cast<Eigen::Index>(mechanism.coordinates.size()));
  for (const CoordinateValue& value : mechanism.assembly) position[value.coordinate] = value.value;
  for (const CoordinateValue& value : trajectory.from.joints) {
    position[value.coordinate] = value.value;
    options.preferred.push_back(value.coordinate);
  }
  dynamics::ForwardDynamics dynamics(mechanism, options);
  if (dynamics.set_state(0, position, VectorX::Zero(position.size())).status != MotionStatus::done) return "";
  const MatrixX rates = dynamics.transformation().matrix;
  const auto rank_of = [&](const std::vector<CoordinateId>& coordinates) {
    MatrixX rows(static_cast<Eigen::Index>(coordinates.size()), rates.cols());
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      rows.row(static_cast<Eigen::Index>(k)) = rates.row(coordinates[k]);
    Eigen::FullPivLU<MatrixX> solver(rows);
    solver.setThreshold(min_rank_pivot);
    return solver.rank();
  };
  // the first coordinates that determine the others: the trajectory's, then what they leave open in the spec's order
  std::vector<CoordinateId> chosen, dependent, missing;
  const auto is_needed = [&](CoordinateId coordinate) {
    chosen.push_back(coordinate);
    if (rank_of(chosen) == static_cast<Eigen::Index>(chosen.size())) return true;
    chosen.pop_back();
    return false;
  };
  for (const CoordinateId listed : options.preferred)
    if (!is_needed(listed)) dependent.push_back(listed);
  if (!dependent.empty())
    return list_names(mechanism, dependent) + " cannot be chosen independently of " + list_names(mechanism, chosen) +
           ": driven, held and free coordinates together are as many as the degrees of freedom, " +
           std::to_string(rates.cols());
  for (std::size_t c = 0; c < mechanism.coordinates.size() && std::ssize(chosen) < rates.cols(); ++c)
    if (is_needed(static_cast<int>(c))) missing.push_back(static_cast<int>(c));
  if (missing.empty()) return "";
  return "coordinates are neither driven, held nor free: " + list_names(mechanism, missing);
}

/// Joints that are not prescribed might stick.
bool PartlyDrivenMechanism::check_friction() {
  for (const Friction& friction : mechanism_.friction)
    if ((friction.dry_friction(1) > 0 || friction.dry_friction(-1) > 0 || friction.static_limit(1) > 0 ||
         friction.static_limit(-1) > 0) &&
        (contains(free_.free, friction.coordinate) || !contains(driven_, friction.coordinate)))
      return fail(MotionStatus::mismatch,
                  "the dry friction of " + list_names(mechanism_, {friction.coordinate}) +
                      ", which is not driven, might make it stick: free coordinates go with dry friction of driven "
                      "and held ones only ('control' has joints that stick)");
  return true;
}

/// Actuators of free coordinates exert nothing.
bool PartlyDrivenMechanism::release_actuators() {
  std::vector<CoordinateId> released;
  for (const CoordinateId actuated : mechanism_.actuators)
    if (contains(free_.free, actuated)) released.push_back(actuated);
  if (released.empty()) return true;
  std::erase_if(mechanism_.actuators, [&](CoordinateId actuated) { return contains(released, actuated); });
  note_ = "free, so that its actuator exerts nothing: " + list_names(mechanism_, released);
  return true;
}

/// Prescribed coordinates without an actuator get one, held ones first, until there are as many actuators as
/// prescribed coordinates.
bool PartlyDrivenMechanism::choose_actuators() {
  std::vector<CoordinateId> candidates = free_.held, added;
  for (const CoordinateId driven : driven_)
    if (!contains(free_.free, driven) && !contains(candidates, driven)) candidates.push_back(driven);
  const std::size_t prescribed = candidates.size();
  if (mechanism_.actuators.size() > prescribed)
    return fail(MotionStatus::mismatch,
                std::to_string(mechanism_.actuators.size()) + " actuators and " + std::to_string(prescribed) +
                    " coordinates that are driven or held: the efforts of a partly driven mechanism are determined "
                    "only if the actuators are not more");
  for (const CoordinateId candidate : candidates)
    if (mechanism_.actuators.size() < prescribed && !contains(mechanism_.actuators, candidate)) {
      mechanism_.actuators.push_back(candidate);
      added.push_back(candidate);
    }
  mechanism_.torque_distribution.reset();
  if (!added.empty()) {
    note_ += note_.empty() ? "" : "; ";
    note_ += "without an actuator, driven or held by a guide: " + list_names(mechanism_, added);
  }
  return true;
}

// States.

void PartlyDrivenMechanism::restart_near(const VectorX& guess) {
  guess_ = guess;
  is_set_ = false;
}

bool PartlyDrivenMechanism::set_state(double time, Side side, const VectorX& position, const VectorX& rate,
                                      Driving driving) {
  position_ = guess_.size() > 0 ? guess_ : start_;
  set_prescribed(time, side, driving);
  for (Eigen::Index k = 0; k < count(); ++k) {
    const CoordinateId c = free_.free[k];
    position_[c] = position[k];
    velocity_[c] = rate[k];
    prescribed_[c] = 0;
  }
  time_ = time;
  if (!position_.allFinite() || !velocity_.allFinite()) return stop(time, "it grows beyond all bounds");
  if (!move_near(time) && !assemble(time)) return false;
  guess_ = dynamics_->position();
  return true;
}

void PartlyDrivenMechanism::set_prescribed(double time, Side side, Driving driving) {
  velocity_.setZero(position_.size());
  prescribed_.setZero(position_.size());
  if (!motion_) return;
  motion_->at(time, side, sample_);
  for (std::size_t k = 0; k < driven_.size(); ++k) {
    const CoordinateId c = driven_[k];
    const auto i = static_cast<Eigen::Index>(k);
    position_[c] = sample_.value[i];
    if (driving == Driving::at_rest) continue;
    velocity_[c] = sample_.rate[i];
    prescribed_[c] = sample_.acceleration[i];
  }
}

/// From the latest state, unless the guess is elsewhere.
bool PartlyDrivenMechanism::move_near(double time) {
  if (!is_set_) return false;
  const std::vector<CoordinateId>& independent = dynamics_->independent();
  VectorX position(static_cast<Eigen::Index>(independent.size())), rate(position.size());
  for (Eigen::Index k = 0; k < position.size(); ++k) {
    const CoordinateId c = independent[static_cast<std::size_t>(k)];
    position[k] = position_[c], rate[k] = velocity_[c];
  }
  return dynamics_->move_to(time, position, rate);
}

bool PartlyDrivenMechanism::assemble(double time) {
  const MotionOutcome outcome = dynamics_->set_state(time, position_, velocity_);
  if (outcome.status != MotionStatus::done) {
    is_set_ = false;
    return stop(time, outcome.reason);
  }
  is_set_ = check_independent(time);
  return is_set_;
}

/// Whether exactly the prescribed and free coordinates are independent.
bool PartlyDrivenMechanism::check_independent(double time) {
  std::vector<CoordinateId> dependent;
  for (const CoordinateId listed : driven_)
    if (!contains(dynamics_->independent(), listed)) dependent.push_back(listed);
  if (dependent.empty()) return true;
  is_mismatch_ = true;
  return stop(time, list_names(mechanism_, dependent) +
                        " cannot be chosen independently of the other driven, held and free coordinates");
}

MatrixX PartlyDrivenMechanism::free_mass_columns(const MatrixX& mass) const {
  const std::vector<CoordinateId>& independent = dynamics_->independent();
  MatrixX columns(mass.rows(), count());
  for (Eigen::Index k = 0; k < count(); ++k)
    columns.col(k) = mass.col(std::find(independent.begin(), independent.end(), free_.free[k]) - independent.begin());
  return columns;
}

bool PartlyDrivenMechanism::find_accelerations(VectorX& acceleration) {
  const dynamics::EquationOfMotion equation = dynamics_->equation();
  const auto size = static_cast<Eigen::Index>(dynamics_->independent().size());
  VectorX known = -equation.bias;
  for (Eigen::Index j = 0; j < size; ++j)
    known -= equation.mass.col(j) * prescribed_[dynamics_->independent()[static_cast<std::size_t>(j)]];
  MatrixX matrix(size, size);
  matrix.leftCols(count()) = free_mass_columns(equation.mass);
  matrix.rightCols(size - count()) = -equation.input;
  const Eigen::PartialPivLU<MatrixX> solver(matrix);
  const VectorX pivots = solver.matrixLU().diagonal().cwiseAbs();
  if (numerics::min_coefficient(pivots) > reliable_pivot * numerics::max_coefficient(pivots)) {
    acceleration = solver.solve(known).head(count());
  } else {
    const Eigen::FullPivLU<MatrixX> careful(matrix);
    if (!careful.isInvertible())
      return stop(time_, "the actuators do not hold the prescribed coordinates, whatever the free ones do");
    acceleration = careful.solve(known).head(count());
  }
  return acceleration.allFinite() || stop(time_, "its accelerations are not finite");
}

/// With the rows of the free and of the prescribed coordinates, f and p, the efforts leave the equation by the rows
/// f − S_f S_p⁻¹ p.
bool PartlyDrivenMechanism::find_equation(FreeEquation& result) {
  const dynamics::EquationOfMotion equation = dynamics_->equation();
  const std::vector<CoordinateId>& independent = dynamics_->independent();
  const auto size = static_cast<Eigen::Index>(independent.size()), prescribed = size - count();
  VectorX force = equation.bias;
  MatrixX selection = MatrixX::Zero(size, count()), input(prescribed, prescribed), others(prescribed, size);
  others.setZero();
  for (Eigen::Index j = 0, p = 0; j < size; ++j) {
    const CoordinateId coordinate = independent[static_cast<std::size_t>(j)];
    force += equation.mass.col(j) * prescribed_[coordinate];
    const auto place = std::find(free_.free.begin(), free_.free.end(), coordinate);
    if (place != free_.free.end())
      selection(j, place - free_.free.begin()) = 1;
    else
      others(p++, j) = 1;
  }
  MatrixX rows = selection.transpose();
  if (prescribed > 0) {
    input = others * equation.input;
    const Eigen::FullPivLU<MatrixX> solver(input.transpose().eval());
    if (!solver.isInvertible())
      return stop(time_, "the actuators do not hold the prescribed coordinates, whatever the free ones do");
    const MatrixX share = solver.solve((rows * equation.input).transpose().eval());
    rows -= share.transpose() * others;
  }
  result.mass = rows * free_mass_columns(equation.mass);
  result.force = rows * force;
  return (result.mass.allFinite() && result.force.allFinite()) || stop(time_, "its accelerations are not finite");
}

bool PartlyDrivenMechanism::stop(double time, const std::string& reason) {
  stop_time_ = time;
  stop_reason_ = reason;
  return false;
}

MotionOutcome PartlyDrivenMechanism::stop_outcome() const {
  if (is_mismatch_) return {MotionStatus::mismatch, stop_time_, stop_reason_, {}};
  return {MotionStatus::unreachable,
          stop_time_,
          trajectory::format_time_prefix(stop_time_) +
              "the motion of the free coordinates cannot be followed: " + stop_reason_,
          {}};
}

}  // namespace balance::simulation
