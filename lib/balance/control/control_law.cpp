#include "balance/control/control_law.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/control/default_gains.hpp"
#include "balance/model/coupling_roots.hpp"
#include "balance/motion/wording.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance {

namespace {

MotionOutcome make_done() { return {MotionStatus::done, 0, "", {}}; }

MotionOutcome make_actuation_failure(double time) {
  return {MotionStatus::actuation_singularity,
          time,
          format_time_prefix(time) +
              "actuation singularity: the actuators cannot give the mechanism the acceleration that the controller "
              "asks for",
          {}};
}

void check_size(const VectorX& values, Eigen::Index size, const char* what) {
  if (values.size() != 0 && values.size() != size)
    throw std::invalid_argument(std::string("a controller needs one ") + what + " per actuator");
}

}  // namespace

bool is_inverse_dynamics_based(const Controller& controller) {
  switch (controller.type) {
    case ControllerType::none: return false;
    case ControllerType::open_loop: return controller.efforts.time.empty();
    case ControllerType::pd: return controller.gravity == GravityCompensation::compensated;
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

ControlLaw::ControlLaw(const Mechanism& truth, const Controller& controller)
    : mechanism_(truth),
      controller_(controller),
      model_mechanism_(controller.model ? *controller.model : truth),
      model_(model_mechanism_, {.preferred = model_mechanism_.actuators}),
      length_(characteristic_length(truth)) {
  const auto actuators = static_cast<Eigen::Index>(truth.actuators.size());
  const bool extended = controller.type == ControllerType::extended_sliding_mode;
  if (model_mechanism_.coordinates.size() != truth.coordinates.size() || model_mechanism_.actuators != truth.actuators)
    throw std::invalid_argument("a controller's model has the coordinates and actuators of the mechanism");
  check_size(controller.kp, actuators, "kp");
  check_size(controller.kd, actuators, "kd");
  check_size(controller.lambda, extended ? 1 : actuators, "lambda");
  check_size(controller.switching_gain, extended ? 1 : actuators, "k");
  check_size(controller.boundary_layer, extended ? 1 : actuators, "boundary layer");
  check_size(controller.torque_limit, actuators, "torque limit");
  efforts_.setZero(actuators);
  at_limit_.setZero(actuators);
  if (controller.type == ControllerType::open_loop && !controller.efforts.time.empty())
    effort_profile_.emplace(controller.efforts, VectorX());
  for (const Coordinate& coordinate : truth.coordinates) {
    const JointType type = truth.joints[static_cast<std::size_t>(coordinate.joint)].type;
    is_assembly_independent_.push_back(type != JointType::spherical &&
                                       (type != JointType::rolling_sphere || coordinate.index < 2));
  }
  for (const int a : truth.actuators) is_assembly_independent_[static_cast<std::size_t>(a)] = true;
  compute_coupling_map();
}

MotionOutcome ControlLaw::start(const VectorX& position, const VectorX& velocity, const GainDesignMotion& basis) {
  if (!controller_.is_sampled()) return make_done();
  const MotionOutcome assembled = model_.set_state(0, position, velocity);
  if (assembled.status != MotionStatus::done) return assembled;
  state_ = model_.position();
  rates_ = model_.velocity();
  const int motors = static_cast<int>(mechanism_.actuators.size());
  if (motors == 0 || (motors < model_.freedoms() && is_inverse_dynamics_based(controller_)))
    return {MotionStatus::mismatch,
            0,
            "a " + std::string(controller_type_name(controller_.type)) +
                " controller needs an actuator for every degree of freedom: there are " + std::to_string(motors) +
                " for " + std::to_string(model_.freedoms()),
            {}};
  return set_gains(basis);
}

MotionOutcome ControlLaw::set_gains(const GainDesignMotion& basis) {
  const auto actuators = static_cast<Eigen::Index>(mechanism_.actuators.size());
  const double frequency = controller_.natural_frequency();
  kp_ = VectorX::Constant(actuators, frequency * frequency);
  kd_ = VectorX::Constant(actuators, 2 * controller_.damping * frequency);
  if (controller_.type == ControllerType::pd && (controller_.kp.size() == 0 || controller_.kd.size() == 0)) {
    // A start without a motion to follow is all that there is to go by.
    const std::vector<DesiredState> here = {{state_, rates_, VectorX::Zero(state_.size())}};
    const PdGains gains = default_pd_gains(model_mechanism_, controller_, basis.along.empty() ? here : basis.along);
    kp_ = gains.kp;
    kd_ = gains.kd;
    notes_ = gains.notes;
  }
  if (controller_.kp.size() > 0) kp_ = controller_.kp;
  if (controller_.kd.size() > 0) kd_ = controller_.kd;
  if (controller_.type == ControllerType::sliding_mode) {
    sliding_ = mechanism_.actuators;
  } else if (controller_.type == ControllerType::extended_sliding_mode) {
    for (const int c : model_.tree())
      if (is_assembly_independent_[static_cast<std::size_t>(c)]) sliding_.push_back(c);
  }
  const auto count = static_cast<Eigen::Index>(sliding_.size());
  lambda_ = VectorX::Constant(count, frequency);
  if (controller_.lambda.size() > 0)
    lambda_ = controller_.lambda.size() == count ? controller_.lambda : VectorX::Constant(count, controller_.lambda[0]);
  k_ = controller_.switching_gain;
  if (k_.size() > 0) return make_done();
  // A quarter of what the fastest motor of the kind is asked for: enough against errors of the model of that size.
  const bool extended = controller_.type == ControllerType::extended_sliding_mode;
  double largest[2] = {frequency * frequency / 1000, frequency * frequency / 1000};  // angles; slides per length
  for (Eigen::Index a = 0; a < actuators; ++a) {
    const bool slide =
        mechanism_.coordinates[static_cast<std::size_t>(mechanism_.actuators[static_cast<std::size_t>(a)])].kind ==
        CoordinateKind::length;
    double& most = largest[slide && !extended ? 1 : 0];
    most = std::max(most, basis.peak_acceleration[a] / (slide ? length_ : 1) / 4);
  }
  k_ = VectorX::Constant(extended ? 1 : actuators, largest[0]);
  if (extended) return make_done();
  for (Eigen::Index a = 0; a < actuators; ++a)
    if (mechanism_.coordinates[static_cast<std::size_t>(mechanism_.actuators[static_cast<std::size_t>(a)])].kind ==
        CoordinateKind::length)
      k_[a] = largest[1] * length_;
  return make_done();
}

/// The least motion of those coordinates that follow none in which the actuated ones move as they do.
void ControlLaw::compute_coupling_map() {
  const std::vector<ResolvedCouplingOf<double>> roots = resolve_couplings(model_mechanism_);
  const auto count = static_cast<Eigen::Index>(roots.size());
  const auto actuators = static_cast<Eigen::Index>(mechanism_.actuators.size());
  MatrixX all = MatrixX::Zero(count, count), actuated(actuators, count);
  for (Eigen::Index c = 0; c < count; ++c)
    for (const CoordinateTerm& term : roots[static_cast<std::size_t>(c)].terms) all(c, term.coordinate) = term.ratio;
  for (Eigen::Index a = 0; a < actuators; ++a)
    actuated.row(a) = all.row(mechanism_.actuators[static_cast<std::size_t>(a)]);
  coupling_map_ = all * CompleteOrthogonalDecomposition(actuated).pseudoInverse();
}

/// Puts the model where the measurements say that the mechanism is.
MotionOutcome ControlLaw::update_model(double time, const VectorX& position, const VectorX& velocity) {
  VectorX off = position, rate_off = velocity;
  for (std::size_t a = 0; a < mechanism_.actuators.size(); ++a) {
    off[static_cast<Eigen::Index>(a)] -= state_[mechanism_.actuators[a]];
    rate_off[static_cast<Eigen::Index>(a)] -= rates_[mechanism_.actuators[a]];
  }
  state_ += coupling_map_ * off;
  rates_ += coupling_map_ * rate_off;
  MotionOutcome outcome = model_.set_state(time, state_, rates_);
  if (outcome.status == MotionStatus::done) {
    state_ = model_.position();
    rates_ = model_.velocity();
    return outcome;
  }
  outcome.time = time;
  outcome.reason = format_time_prefix(time) +
                   "what the controller believes of the mechanism does not fit its motors: " + outcome.reason;
  return outcome;
}

MotionOutcome ControlLaw::compute_efforts(double time, const DesiredState& desired, const VectorX& position,
                                          const VectorX& velocity) {
  efforts_.setZero();
  failure_ = make_done();
  bool found = true;
  switch (controller_.type) {
    case ControllerType::none: break;
    case ControllerType::open_loop: found = open_loop(time, desired); break;
    case ControllerType::pd: {
      const TrackingErrors e = actuated_errors(desired, position, velocity);
      if (controller_.gravity == GravityCompensation::compensated) found = compensate_gravity(time, position);
      efforts_ += kp_.cwiseProduct(e.position) + kd_.cwiseProduct(e.rate);
      break;
    }
    case ControllerType::computed_torque: found = apply_computed_torque(time, desired, position, velocity); break;
    case ControllerType::sliding_mode:
      failure_ = update_model(time, position, velocity);
      found = failure_.status == MotionStatus::done && apply_sliding_mode(desired, position, velocity);
      break;
    case ControllerType::extended_sliding_mode:
      failure_ = update_model(time, position, velocity);
      found = failure_.status == MotionStatus::done && apply_extended_sliding_mode(desired);
      break;
  }
  if (!found) return failure_.status == MotionStatus::done ? make_actuation_failure(time) : failure_;
  saturate_efforts();
  return make_done();
}

}  // namespace balance
