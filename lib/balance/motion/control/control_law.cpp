#include "balance/motion/control/control_law.hpp"

#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/model/couplings.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/motion/control/controller_error.hpp"
#include "balance/motion/control/default_gains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance::control {

using study::ControllerType;

EffortProfile::EffortProfile(const study::EffortTable& table, const VectorX& limit) : effort_limit_(limit) {
  if (table.time.empty() || table.effort.size() != table.time.size())
    throw std::invalid_argument("efforts over time need one row per time");
  make_pieces(table);
  knots_ = table.time;
  if (effort_limit_.size() > 0) add_saturation_knots();
  std::sort(knots_.begin(), knots_.end());
}

void EffortProfile::make_pieces(const study::EffortTable& table) {
  const std::size_t rows = table.time.size();
  const Eigen::Index actuators = table.effort.front().size();
  Samples values(static_cast<Eigen::Index>(rows), actuators), curvature = Samples::Zero(values.rows(), actuators);
  Samples slope = curvature;
  for (Eigen::Index k = 0; k < values.rows(); ++k) values.row(k) = table.effort[static_cast<std::size_t>(k)];
  const bool is_spline = table.interpolation == study::EffortTable::Interpolation::spline && rows > 1;
  if (is_spline) {
    const numerics::CubicSpline spline(table.time, values, numerics::SplineEnd::not_a_knot);
    VectorX value(actuators), first(actuators), second(actuators);
    for (Eigen::Index k = 0; k < values.rows(); ++k) {
      spline.at(table.time[static_cast<std::size_t>(k)], value, first, second);
      slope.row(k) = first;
      curvature.row(k) = second;
    }
  }
  for (std::size_t k = 0; k + 1 < rows; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const double h = table.time[k + 1] - table.time[k];
    Piece piece{table.time[k], table.time[k + 1], {}};
    for (Eigen::Index a = 0; a < actuators; ++a) {
      const double secant_slope = (values(row + 1, a) - values(row, a)) / h;
      const double quadratic_coefficient = curvature(row, a) / 2,
                   cubic_coefficient = (curvature(row + 1, a) - curvature(row, a)) / (6 * h);
      piece.efforts.push_back(
          {values(row, a), is_spline ? slope(row, a) : secant_slope, quadratic_coefficient, cubic_coefficient});
    }
    pieces_.push_back(std::move(piece));
  }
  if (!pieces_.empty()) return;
  Piece constant{table.time[0], table.time[0], {}};
  for (Eigen::Index a = 0; a < actuators; ++a) constant.efforts.push_back({values(0, a), 0, 0, 0});
  pieces_.push_back(std::move(constant));
}

/// Bisects monotone intervals, each of which has at most one crossing of +limit and of −limit.
void EffortProfile::add_saturation_knots() {
  constexpr int max_bisections = 60;
  for (const Piece& piece : pieces_)
    for (std::size_t a = 0; a < piece.efforts.size(); ++a) {
      const std::vector<double> ends = find_monotone_intervals(piece.efforts[a], piece.begin, piece.end);
      for (std::size_t k = 0; k + 1 < ends.size(); ++k)
        for (const double level :
             {effort_limit_[static_cast<Eigen::Index>(a)], -effort_limit_[static_cast<Eigen::Index>(a)]}) {
          double low = ends[k], high = ends[k + 1];
          const bool begins_above = evaluate_unsaturated(piece, a, low) > level;
          if (begins_above == (evaluate_unsaturated(piece, a, high) > level)) continue;
          for (int iteration = 0; iteration < max_bisections; ++iteration) {
            const double middle = (low + high) / 2;
            ((evaluate_unsaturated(piece, a, middle) > level) == begins_above ? low : high) = middle;
          }
          if (high > piece.begin && high < piece.end) knots_.push_back(high);
        }
    }
}

const EffortProfile::Piece& EffortProfile::find_piece(double time) const {
  const auto next = std::upper_bound(pieces_.begin(), pieces_.end(), time,
                                     [](double t, const Piece& piece) { return t < piece.begin; });
  return next == pieces_.begin() ? pieces_.front() : *(next - 1);
}

/// Constant before the first and after the last row.
double EffortProfile::evaluate_unsaturated(const Piece& piece, std::size_t actuator, double time) const {
  const Cubic& c = piece.efforts[actuator];
  const double x = std::clamp(time, piece.begin, piece.end) - piece.begin;
  return c[0] + x * (c[1] + x * (c[2] + x * c[3]));
}

double EffortProfile::saturate(std::size_t actuator, double effort) const {
  if (effort_limit_.size() == 0) return effort;
  const double limit = effort_limit_[static_cast<Eigen::Index>(actuator)];
  return std::clamp(effort, -limit, limit);
}

/// The ends, and the zeros of the derivative between them.
std::vector<double> EffortProfile::find_monotone_intervals(const Cubic& c, double begin, double end) {
  std::vector<double> ends{begin};
  const double a = 3 * c[3], half = c[2], discriminant = half * half - a * c[1];
  if (discriminant > 0) {
    // roots of a x² + 2 half x + c1, without cancellation
    const double q = -(half + std::copysign(std::sqrt(discriminant), half));
    for (const double x : {q / a, c[1] / q})
      if (std::isfinite(x) && x > 0 && x < end - begin) ends.push_back(begin + x);
  }
  ends.push_back(end);
  std::sort(ends.begin(), ends.end());
  return ends;
}

void EffortProfile::evaluate(double time, VectorX& effort) const {
  const Piece& piece = find_piece(time);
  for (std::size_t a = 0; a < piece.efforts.size(); ++a)
    effort[static_cast<Eigen::Index>(a)] = saturate(a, evaluate_unsaturated(piece, a, time));
}

VectorX EffortProfile::evaluate(double time) const {
  VectorX effort(static_cast<Eigen::Index>(pieces_.front().efforts.size()));
  evaluate(time, effort);
  return effort;
}

VectorX EffortProfile::saturation(double time) const {
  const Piece& piece = find_piece(time);
  VectorX out = VectorX::Zero(static_cast<Eigen::Index>(piece.efforts.size()));
  for (std::size_t a = 0; a < piece.efforts.size(); ++a) {
    const double effort = evaluate_unsaturated(piece, a, time);
    if (saturate(a, effort) != effort) out[static_cast<Eigen::Index>(a)] = 1;
  }
  return out;
}

VectorX EffortProfile::total_variation(double from, double to) const {
  VectorX sum = VectorX::Zero(static_cast<Eigen::Index>(pieces_.front().efforts.size()));
  for (auto piece = pieces_.begin() + (&find_piece(from) - pieces_.data()); piece != pieces_.end(); ++piece) {
    if (piece->begin >= to) break;
    const double begin = std::max(from, piece->begin), end = std::min(to, piece->end);
    if (!(begin < end)) continue;
    for (std::size_t a = 0; a < piece->efforts.size(); ++a) {
      double last = saturate(a, evaluate_unsaturated(*piece, a, begin));
      for (const double extremum : find_monotone_intervals(piece->efforts[a], piece->begin, piece->end)) {
        if (extremum <= begin) continue;
        const double next = saturate(a, evaluate_unsaturated(*piece, a, std::min(extremum, end)));
        sum[static_cast<Eigen::Index>(a)] += std::abs(next - last);
        last = next;
        if (extremum >= end) break;
      }
    }
  }
  return sum;
}

namespace {

MotionOutcome make_done() { return {MotionStatus::done, 0, "", {}}; }

MotionOutcome make_actuation_failure(double time) {
  return {MotionStatus::actuation_singularity,
          time,
          trajectory::format_time_prefix(time) +
              "actuation singularity: the actuators cannot give the mechanism the acceleration that the controller "
              "asks for",
          {}};
}

void check_size(const VectorX& values, Eigen::Index size, const char* key) {
  if (values.size() != 0 && values.size() != size)
    throw ControllerError(key, fmt::format("a controller needs one {} per actuator or speed", key));
}

}  // namespace

bool is_inverse_dynamics_based(const Controller& controller) {
  switch (controller.type) {
    case ControllerType::none: return false;
    case ControllerType::open_loop: return controller.efforts.time.empty();
    case ControllerType::pd: return controller.gravity == study::GravityCompensation::compensated;
    case ControllerType::computed_torque:
    case ControllerType::sliding_mode:
    case ControllerType::extended_sliding_mode: return true;
  }
  return true;
}

bool needs_desired_motion(const Controller& controller) {
  if (controller.type == ControllerType::open_loop) return controller.efforts.time.empty();
  return controller.type != ControllerType::none;
}

ControlLaw::ControlLaw(const Mechanism& truth, const Controller& controller, const Mechanism& model)
    : mechanism_(truth),
      controller_(controller),
      model_mechanism_(&model),
      model_(model, {.preferred = model.actuators}),
      length_(characteristic_length(truth)) {
  const auto actuators = static_cast<Eigen::Index>(truth.actuators.size());
  const bool extended = controller.type == ControllerType::extended_sliding_mode;
  if (model.coordinates.size() != truth.coordinates.size() || model.actuators != truth.actuators)
    throw ControllerError("model", "a controller's model must have the coordinates and actuators of the mechanism");
  if (!controller.speeds.empty()) {
    if (const std::string reason = study::why_no_speeds(controller.type); !reason.empty())
      throw ControllerError("speeds", reason);
    task_.emplace(model, controller.speeds);
  }
  const Eigen::Index controlled = task_ ? task_->size() : actuators;
  check_size(controller.kp, controlled, "kp");
  check_size(controller.kd, controlled, "kd");
  check_size(controller.lambda, extended ? 1 : controlled, "lambda");
  check_size(controller.switching_gain, extended ? 1 : controlled, "k");
  check_size(controller.boundary_layer, extended ? 1 : controlled, "boundary_layer");
  check_size(controller.torque_limit, actuators, "torque_limit");
  efforts_.setZero(actuators);
  saturation_.setZero(actuators);
  if (controller.type == ControllerType::open_loop && !controller.efforts.time.empty())
    effort_profile_.emplace(controller.efforts, VectorX());
  for (const Coordinate& coordinate : truth.coordinates) {
    const JointType type = truth.joints[static_cast<std::size_t>(coordinate.joint)].type;
    is_assembly_independent_.push_back(type != JointType::spherical &&
                                       (type != JointType::rolling_sphere || coordinate.index < 2) &&
                                       (type != JointType::free || coordinate.index < 3));
  }
  for (const int a : truth.actuators) is_assembly_independent_[static_cast<std::size_t>(a)] = true;
  compute_coupling_map();
  if (model_mechanism_->torque_distribution) distribution_ = model::scale_distribution(*model_mechanism_, length_);
}

void ControlLaw::change_model(double time, const Mechanism& model) {
  model_mechanism_ = &model;
  model_ = dynamics::ForwardDynamics(model, {.preferred = model.actuators});
  if (task_) task_.emplace(model, controller_.speeds);  // its centre of mass is the model's
  if (state_.size() > 0) model_.set_state(time, state_, rates_);
}

MotionOutcome ControlLaw::start(const VectorX& position, const VectorX& velocity, const GainDesignMotion& basis) {
  if (!controller_.is_sampled()) return make_done();
  const MotionOutcome outcome = model_.set_state(0, position, velocity);
  if (outcome.status != MotionStatus::done) return outcome;
  state_ = model_.position();
  rates_ = model_.velocity();
  const int motors = static_cast<int>(mechanism_.actuators.size());
  if (motors == 0 || (motors < model_.freedoms() && (task_ || is_inverse_dynamics_based(controller_))))
    return {MotionStatus::mismatch,
            0,
            "a " + std::string(controller_type_name(controller_.type)) +
                " controller needs an actuator for every degree of freedom: there are " + std::to_string(motors) +
                " for " + std::to_string(model_.freedoms()),
            {}};
  if (task_ && has_velocity_constraints(mechanism_))
    return {MotionStatus::mismatch,
            0,
            "a controller with speeds needs positions that follow from those of the actuators, but here rates are "
            "constrained and positions are not",
            {}};
  if (task_ && task_->size() != model_.freedoms())
    return {MotionStatus::mismatch,
            0,
            "the controller has " + std::to_string(task_->size()) + " speeds for " + std::to_string(model_.freedoms()) +
                " degrees of freedom: as many are needed",
            {}};
  MotionOutcome result = set_gains(basis);
  if (distribution_ && is_inverse_dynamics_based(controller_))
    trajectory::add_distribution_note(*model_mechanism_, model_.freedoms(), notes_);
  return result;
}

MotionOutcome ControlLaw::set_gains(const GainDesignMotion& basis) {
  const auto actuators = static_cast<Eigen::Index>(mechanism_.actuators.size());
  const Eigen::Index controlled = task_ ? task_->size() : actuators;
  const double frequency = controller_.natural_frequency();
  kp_ = VectorX::Constant(controlled, frequency * frequency);
  kd_ = VectorX::Constant(controlled, 2 * controller_.damping * frequency);
  if (controller_.type == ControllerType::pd && (controller_.kp.size() == 0 || controller_.kd.size() == 0)) {
    // Without a motion to follow, only the start is known.
    const std::vector<DesiredState> start_states = {{state_, rates_, VectorX::Zero(state_.size())}};
    const PdGains gains = default_pd_gains(*model_mechanism_, controller_,
                                           basis.along.empty() ? start_states : basis.along, task_ ? &*task_ : nullptr);
    kp_ = gains.kp;
    kd_ = gains.kd;
    notes_ = gains.notes;
  }
  if (controller_.kp.size() > 0) kp_ = controller_.kp;
  if (controller_.kd.size() > 0) kd_ = controller_.kd;
  if (controller_.type == ControllerType::sliding_mode) {
    if (!task_) sliding_ = mechanism_.actuators;
  } else if (controller_.type == ControllerType::extended_sliding_mode) {
    for (const int c : model_.tree())
      if (is_assembly_independent_[static_cast<std::size_t>(c)]) sliding_.push_back(c);
  }
  const auto count = static_cast<Eigen::Index>(sliding_quantities().size());
  lambda_ = VectorX::Constant(count, frequency);
  if (controller_.lambda.size() > 0)
    lambda_ = controller_.lambda.size() == count ? controller_.lambda : VectorX::Constant(count, controller_.lambda[0]);
  k_ = controller_.switching_gain;
  if (k_.size() > 0) return make_done();
  k_ = task_ ? default_task_switching_gains(basis) : default_switching_gains(basis);
  return make_done();
}

/// A quarter of the largest acceleration among motors of the kind: enough for model errors of that size.
VectorX ControlLaw::default_switching_gains(const GainDesignMotion& basis) const {
  const auto actuators = static_cast<Eigen::Index>(mechanism_.actuators.size());
  const double frequency = controller_.natural_frequency();
  const bool extended = controller_.type == ControllerType::extended_sliding_mode;
  double max_accelerations[2] = {frequency * frequency / 1000,
                                 frequency * frequency / 1000};  // angles; slides per length
  for (Eigen::Index a = 0; a < actuators; ++a) {
    const bool is_slide =
        mechanism_.coordinates[static_cast<std::size_t>(mechanism_.actuators[static_cast<std::size_t>(a)])].kind ==
        CoordinateKind::length;
    double& max_acceleration = max_accelerations[is_slide && !extended ? 1 : 0];
    max_acceleration = std::max(max_acceleration, basis.peak_acceleration[a] / (is_slide ? length_ : 1) / 4);
  }
  VectorX gains = VectorX::Constant(extended ? 1 : actuators, max_accelerations[0]);
  if (extended) return gains;
  for (Eigen::Index a = 0; a < actuators; ++a)
    if (mechanism_.coordinates[static_cast<std::size_t>(mechanism_.actuators[static_cast<std::size_t>(a)])].kind ==
        CoordinateKind::length)
      gains[a] = max_accelerations[1] * length_;
  return gains;
}

/// The same among speeds of the kind.
VectorX ControlLaw::default_task_switching_gains(const GainDesignMotion& basis) const {
  const double frequency = controller_.natural_frequency();
  double max_accelerations[2] = {frequency * frequency / 1000, frequency * frequency / 1000 * length_};
  for (const DesiredState& state : basis.along) {
    const VectorX accelerations = task_->accelerations(state.position, state.velocity, state.acceleration);
    for (Eigen::Index i = 0; i < task_->size(); ++i) {
      double& max_acceleration = max_accelerations[task_->is_length(i) ? 1 : 0];
      max_acceleration = std::max(max_acceleration, std::abs(accelerations[i]) / 4);
    }
  }
  VectorX gains(task_->size());
  for (Eigen::Index i = 0; i < task_->size(); ++i) gains[i] = max_accelerations[task_->is_length(i) ? 1 : 0];
  return gains;
}

std::vector<SlidingQuantity> ControlLaw::sliding_quantities() const {
  std::vector<SlidingQuantity> quantities;
  if (task_ && controller_.type == ControllerType::sliding_mode)
    for (Eigen::Index i = 0; i < task_->size(); ++i) quantities.push_back({task_->name(i), task_->is_length(i)});
  for (const CoordinateId c : sliding_)
    quantities.push_back(
        {mechanism_.coordinates[static_cast<std::size_t>(c)].name, is_length_coordinate(mechanism_, c)});
  return quantities;
}

VectorX ControlLaw::sliding_variables(const DesiredState& desired, const VectorX& position,
                                      const VectorX& velocity) const {
  if (task_ && controller_.type == ControllerType::sliding_mode)
    return task_->rates(position, velocity) - task_->rates(desired.position, desired.velocity) -
           lambda_.cwiseProduct(task_->errors(desired.position, position));
  VectorX values(static_cast<Eigen::Index>(sliding_.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const CoordinateId c = sliding_[static_cast<std::size_t>(i)];
    values[i] = velocity[c] - desired.velocity[c] - lambda_[i] * coordinate_error(c, desired.position[c] - position[c]);
  }
  return values;
}

VectorX ControlLaw::sliding_round_off(const VectorX& position, const VectorX& velocity) const {
  if (task_ && controller_.type == ControllerType::sliding_mode)
    return task_->bound_changes(velocity) + lambda_.cwiseProduct(task_->bound_changes(position));
  VectorX values(static_cast<Eigen::Index>(sliding_.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const CoordinateId c = sliding_[static_cast<std::size_t>(i)];
    values[i] = velocity[c] + lambda_[i] * position[c];
  }
  return values;
}

/// Minimum-norm motion of the coordinates that follow none, for given motions of the actuated ones.
void ControlLaw::compute_coupling_map() {
  const std::vector<model::ResolvedCouplingOf<double>> roots = resolve_couplings(*model_mechanism_);
  const auto count = static_cast<Eigen::Index>(roots.size());
  const auto actuators = static_cast<Eigen::Index>(mechanism_.actuators.size());
  MatrixX expansion = MatrixX::Zero(count, count), actuated(actuators, count);
  for (Eigen::Index c = 0; c < count; ++c)
    for (const model::CoordinateTerm& term : roots[static_cast<std::size_t>(c)].terms)
      expansion(c, term.coordinate) = term.ratio;
  for (Eigen::Index a = 0; a < actuators; ++a)
    actuated.row(a) = expansion.row(mechanism_.actuators[static_cast<std::size_t>(a)]);
  coupling_map_ = expansion * numerics::CompleteOrthogonalDecomposition(actuated).pseudoInverse();
}

/// Sets the model to the measured state.
MotionOutcome ControlLaw::update_model(double time, const VectorX& position, const VectorX& velocity) {
  VectorX position_change = position, velocity_change = velocity;
  for (std::size_t a = 0; a < mechanism_.actuators.size(); ++a) {
    position_change[static_cast<Eigen::Index>(a)] -= state_[mechanism_.actuators[a]];
    velocity_change[static_cast<Eigen::Index>(a)] -= rates_[mechanism_.actuators[a]];
  }
  state_ += coupling_map_ * position_change;
  rates_ += coupling_map_ * velocity_change;
  MotionOutcome outcome = model_.set_state(time, state_, rates_);
  if (outcome.status == MotionStatus::done) {
    state_ = model_.position();
    rates_ = model_.velocity();
    return outcome;
  }
  outcome.time = time;
  outcome.reason = trajectory::format_time_prefix(time) +
                   "the controller's model does not fit the mechanism's actuators: " + outcome.reason;
  return outcome;
}

MotionOutcome ControlLaw::compute_efforts(double time, const DesiredState& desired, const VectorX& position,
                                          const VectorX& velocity) {
  efforts_.setZero();
  failure_ = make_done();
  bool is_solved = true;
  switch (controller_.type) {
    case ControllerType::none: break;
    case ControllerType::open_loop: is_solved = apply_open_loop(time, desired); break;
    case ControllerType::pd: is_solved = apply_pd(time, desired, position, velocity); break;
    case ControllerType::computed_torque: is_solved = apply_computed_torque(time, desired, position, velocity); break;
    case ControllerType::sliding_mode:
      failure_ = update_model(time, position, velocity);
      is_solved = failure_.status == MotionStatus::done && apply_sliding_mode(time, desired, position, velocity);
      break;
    case ControllerType::extended_sliding_mode:
      failure_ = update_model(time, position, velocity);
      is_solved = failure_.status == MotionStatus::done && apply_extended_sliding_mode(desired);
      break;
  }
  if (!is_solved) return failure_.status == MotionStatus::done ? make_actuation_failure(time) : failure_;
  saturate_efforts();
  return make_done();
}

// The control laws.

namespace {

/// The minimum-norm solution of A x = b.
/// @return false if A does not have full row rank
bool solve_full_row_rank(const MatrixX& A, const VectorX& b, VectorX& x) {
  numerics::CompleteOrthogonalDecomposition factors;
  factors.setThreshold(1e-10);
  factors.compute(A);
  if (factors.rank() < A.rows()) return false;
  x = factors.solve(b);
  return x.allFinite();
}

/// Removes whole turns.
double wrap_angle(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

}  // namespace

ControlLaw::TrackingErrors ControlLaw::actuated_errors(const DesiredState& desired, const VectorX& position,
                                                       const VectorX& velocity) const {
  TrackingErrors e{-position, -velocity, VectorX(position.size())};
  for (Eigen::Index a = 0; a < position.size(); ++a) {
    const int c = mechanism_.actuators[static_cast<std::size_t>(a)];
    e.position[a] += desired.position[c];
    e.rate[a] += desired.velocity[c];
    e.acceleration[a] = desired.acceleration[c];
  }
  return e;
}

/// Adds efforts that give the actuated coordinates these accelerations at the model's state.
bool ControlLaw::add_acceleration_efforts(const VectorX& actuated) {
  VectorX rate_change;
  if (model_.independent() == mechanism_.actuators) {
    rate_change = actuated;
  } else {
    const dynamics::Transformation transformation = model_.transformation();
    const auto motors = static_cast<Eigen::Index>(mechanism_.actuators.size());
    MatrixX rows(motors, transformation.matrix.cols());
    VectorX right_hand_side(motors);
    for (Eigen::Index a = 0; a < motors; ++a) {
      const int c = mechanism_.actuators[static_cast<std::size_t>(a)];
      rows.row(a) = transformation.matrix.row(c);
      right_hand_side[a] = actuated[a] - transformation.bias[c];
    }
    // With more motors than freedoms, their average.
    if (!solve_full_row_rank(rows.transpose() * rows, rows.transpose() * right_hand_side, rate_change)) return false;
  }
  return add_independent_acceleration_efforts(rate_change);
}

/// Adds efforts that give the independent coordinates these accelerations at the model's state.
bool ControlLaw::add_independent_acceleration_efforts(const VectorX& independent) {
  const dynamics::EquationOfMotion equation = model_.equation();
  return distribute(equation.input, equation.mass * independent + equation.bias);
}

/// Adds efforts that are equivalent to generalised forces on the independent coordinates.
bool ControlLaw::add_generalised_forces(const VectorX& generalised) {
  return distribute(model_.equation().input, generalised);
}

/// Adds efforts u with input · u = forces.
bool ControlLaw::distribute(const MatrixX& input, const VectorX& forces) {
  VectorX efforts;
  if (!solve_full_row_rank(input, forces, efforts)) return false;
  if (distribution_ && input.cols() > input.rows()) efforts = solve_distribution(*distribution_, input, forces);
  efforts_ += efforts;
  return true;
}

/// Adds efforts that hold the model at rest at this position.
bool ControlLaw::compensate_gravity(double time, const VectorX& position) {
  failure_ = update_model(time, position, VectorX::Zero(position.size()));
  return failure_.status == MotionStatus::done && add_generalised_forces(model_.equation().bias);
}

bool ControlLaw::apply_computed_torque(double time, const DesiredState& desired, const VectorX& position,
                                       const VectorX& velocity) {
  failure_ = update_model(time, position, velocity);
  if (failure_.status != MotionStatus::done) return false;
  const TrackingErrors e = task_ ? task_errors(desired) : actuated_errors(desired, position, velocity);
  const VectorX v = e.acceleration + kd_.cwiseProduct(e.rate) + kp_.cwiseProduct(e.position);
  return task_ ? add_task_acceleration_efforts(time, v) : add_acceleration_efforts(v);
}

/// Errors of the quantities x whose rates p = ẋ are the controller's speeds, at the model's state.
ControlLaw::TrackingErrors ControlLaw::task_errors(const DesiredState& desired) const {
  return {task_->errors(desired.position, state_),
          task_->rates(desired.position, desired.velocity) - task_->rates(state_, rates_),
          task_->accelerations(desired.position, desired.velocity, desired.acceleration)};
}

/// W in p = W ν, for the rates ν of the model's independent coordinates.
MatrixX ControlLaw::task_directions() { return task_->directions(state_, model_.transformation().matrix); }

/// Adds efforts that give the speeds these derivatives ṗ = W ν̇ + N at the model's state, N at zero ν̇.
bool ControlLaw::add_task_acceleration_efforts(double time, const VectorX& accelerations) {
  const VectorX bias = task_->accelerations(state_, rates_, model_.transformation().bias);
  VectorX rate_change;
  if (solve_full_row_rank(task_directions(), accelerations - bias, rate_change))
    return add_independent_acceleration_efforts(rate_change);
  failure_ = {
      MotionStatus::drive_singularity,
      time,
      trajectory::format_time_prefix(time) + "the controller's speeds do not determine the motion of the mechanism",
      {}};
  return false;
}

/// Springs and dampers between desired and actual coordinates, or quantities x: Wᵀ F is their force at the rates ν.
bool ControlLaw::apply_pd(double time, const DesiredState& desired, const VectorX& position, const VectorX& velocity) {
  const bool is_compensated = controller_.gravity == study::GravityCompensation::compensated;
  if (!task_) {
    const TrackingErrors e = actuated_errors(desired, position, velocity);
    if (is_compensated && !compensate_gravity(time, position)) return false;
    efforts_ += kp_.cwiseProduct(e.position) + kd_.cwiseProduct(e.rate);
    return true;
  }
  failure_ = update_model(time, position, velocity);
  if (failure_.status != MotionStatus::done) return false;
  const TrackingErrors e = task_errors(desired);
  VectorX forces = task_directions().transpose() * (kp_.cwiseProduct(e.position) + kd_.cwiseProduct(e.rate));
  if (is_compensated) {
    failure_ = update_model(time, position, VectorX::Zero(velocity.size()));
    if (failure_.status != MotionStatus::done) return false;
    forces += model_.equation().bias;
  }
  return add_generalised_forces(forces);
}

/// sign(s), or its linear version inside the boundary layer.
/// @param layer index of the boundary layer
/// @param unit of its width: 1, or the length that s is measured in
double ControlLaw::switching_function(double s, Eigen::Index layer, double unit) const {
  if (controller_.boundary_layer.size() > 0)
    return std::clamp(s / (controller_.boundary_layer[layer] * unit), -1.0, 1.0);
  return s > 0 ? 1 : s < 0 ? -1 : 0;
}

/// P0 eq. 47 for every actuated coordinate, or for every speed.
bool ControlLaw::apply_sliding_mode(double time, const DesiredState& desired, const VectorX& position,
                                    const VectorX& velocity) {
  const TrackingErrors e = task_ ? task_errors(desired) : actuated_errors(desired, position, velocity);
  VectorX v = e.acceleration + lambda_.cwiseProduct(e.rate);
  for (Eigen::Index a = 0; a < v.size(); ++a)
    v[a] -= k_[a] * switching_function(-(e.rate[a] + lambda_[a] * e.position[a]), a, 1);
  return task_ ? add_task_acceleration_efforts(time, v) : add_acceleration_efforts(v);
}

/// Whole turns of a coordinate without a motor do not count: it is computed from poses, not driven.
double ControlLaw::coordinate_error(CoordinateId c, double difference) const {
  const bool is_actuated =
      std::find(mechanism_.actuators.begin(), mechanism_.actuators.end(), c) != mechanism_.actuators.end();
  return is_length_coordinate(mechanism_, c) || is_actuated ? difference : wrap_angle(difference);
}

/// Errors of the tree's coordinates at the model's state. A coordinate without a measurement (of a spherical joint) has
/// the error that the others' errors cause to first order.
ControlLaw::TrackingErrors ControlLaw::tree_errors(const DesiredState& desired,
                                                   const dynamics::Transformation& tree) const {
  const std::vector<CoordinateId>&columns = model_.tree(), &independent = model_.independent();
  const auto error = [&](CoordinateId c) { return coordinate_error(c, desired.position[c] - state_[c]); };
  const auto d = static_cast<Eigen::Index>(independent.size()), n = static_cast<Eigen::Index>(columns.size());
  TrackingErrors independent_errors{VectorX::Zero(d), VectorX::Zero(d), VectorX::Zero(d)};
  for (Eigen::Index i = 0; i < d; ++i) {
    const int c = independent[static_cast<std::size_t>(i)];
    if (!is_assembly_independent_[static_cast<std::size_t>(c)]) continue;
    independent_errors.position[i] = error(c);
    independent_errors.rate[i] = desired.velocity[c] - rates_[c];
    independent_errors.acceleration[i] = desired.acceleration[c];
  }
  TrackingErrors e{tree.matrix * independent_errors.position, tree.matrix * independent_errors.rate,
                   tree.matrix * independent_errors.acceleration + tree.bias};
  for (Eigen::Index i = 0; i < n; ++i) {
    const int c = columns[static_cast<std::size_t>(i)];
    if (!is_assembly_independent_[static_cast<std::size_t>(c)]) continue;
    e.position[i] = error(c);
    e.rate[i] = desired.velocity[c] - rates_[c];
    e.acceleration[i] = desired.acceleration[c];
  }
  return e;
}

/// P0 eq. 56 and 61, or the identity projection.
bool ControlLaw::apply_extended_sliding_mode(const DesiredState& desired) {
  const dynamics::Transformation tree = model_.tree_transformation();
  const TrackingErrors e = tree_errors(desired, tree);
  const double lambda = controller_.lambda.size() > 0 ? controller_.lambda[0] : controller_.natural_frequency();
  VectorX commanded_acceleration = e.acceleration + lambda * e.rate, unit(commanded_acceleration.size());
  for (Eigen::Index i = 0; i < commanded_acceleration.size(); ++i) {
    const int c = model_.tree()[static_cast<std::size_t>(i)];
    unit[i] = mechanism_.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::length ? length_ : 1;
    commanded_acceleration[i] -=
        k_[0] * unit[i] * switching_function(-(e.rate[i] + lambda * e.position[i]), 0, unit[i]);
  }
  if (controller_.projection == study::AccelerationProjection::inertia) {
    const dynamics::TreeEquation equation = model_.tree_equation();
    return add_generalised_forces(tree.matrix.transpose() * (equation.mass * commanded_acceleration + equation.bias));
  }
  const MatrixX scaled = unit.cwiseInverse().asDiagonal() * tree.matrix;
  const VectorX right_hand_side = (commanded_acceleration - tree.bias).cwiseQuotient(unit);
  VectorX rate_change;
  if (!solve_full_row_rank(scaled.transpose() * scaled, scaled.transpose() * right_hand_side, rate_change))
    return false;
  const dynamics::EquationOfMotion equation = model_.equation();
  return add_generalised_forces(equation.mass * rate_change + equation.bias);
}

bool ControlLaw::apply_open_loop(double time, const DesiredState& desired) {
  if (effort_profile_) {
    effort_profile_->evaluate(time, efforts_);
    return true;
  }
  const auto motors = static_cast<Eigen::Index>(mechanism_.actuators.size());
  VectorX position(motors), velocity(motors), acceleration(motors);
  for (Eigen::Index a = 0; a < motors; ++a) {
    const int c = mechanism_.actuators[static_cast<std::size_t>(a)];
    position[a] = desired.position[c];
    velocity[a] = desired.velocity[c];
    acceleration[a] = desired.acceleration[c];
  }
  failure_ = update_model(time, position, velocity);
  return failure_.status == MotionStatus::done && add_acceleration_efforts(acceleration);
}

void ControlLaw::saturate_efforts() {
  saturation_.setZero();
  if (controller_.torque_limit.size() == 0) return;
  for (Eigen::Index a = 0; a < efforts_.size(); ++a) {
    const double limit = controller_.torque_limit[a];
    if (std::abs(efforts_[a]) <= limit) continue;
    efforts_[a] = std::copysign(limit, efforts_[a]);
    saturation_[a] = 1;
  }
}

}  // namespace balance::control
