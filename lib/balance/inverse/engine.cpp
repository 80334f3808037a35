#include "balance/inverse/engine.hpp"

#include "balance/dynamics/friction.hpp"
#include "balance/dynamics/regressor.hpp"
#include "balance/dynamics/term_meter.hpp"
#include "balance/motion/configuration_text.hpp"
#include "balance/motion/wording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance {

namespace {

constexpr double quiet_nan = std::numeric_limits<double>::quiet_NaN();

/// The first quantity of a sample that is no number; null if all are.
const char* find_nonfinite_quantity(const Sample& s) {
  const auto finite = [](const std::vector<Vector3>& all) {
    for (const Vector3& v : all)
      if (!v.allFinite()) return false;
    return true;
  };
  if (!s.position.allFinite() || !s.velocity.allFinite() || !s.acceleration.allFinite()) return "the joints' motion";
  if (!s.effort.allFinite()) return "torque";
  if (!s.power.allFinite()) return "power";
  if (!s.shaking_force.allFinite()) return "shaking_force";
  if (!s.shaking_moment.allFinite() || !s.shaking_moment_com.allFinite()) return "shaking_moment";
  if (!s.ground_force.allFinite() || !s.ground_moment.allFinite()) return "ground_force";
  if (!finite(s.joint_force) || !finite(s.joint_moment)) return "joint_force";
  if (!std::isfinite(s.kinetic_energy) || !std::isfinite(s.potential_energy)) return "energy";
  return nullptr;
}

void invalidate_efforts(bool loops, Sample& sample) {
  sample.effort.setConstant(quiet_nan);
  sample.power.setConstant(quiet_nan);
  sample.total_torque = quiet_nan;
  if (!loops) return;  // what an open tree's joints transmit does not depend on what drives them
  for (auto* all : {&sample.joint_force, &sample.joint_moment})
    for (Vector3& v : *all) v.setConstant(quiet_nan);
}

}  // namespace

template <class S>
InverseDynamicsOf<S>::InverseDynamicsOf(const Mechanism& given, const InverseOptions& wishes)
    : Implementation(given, wishes),
      branch_(mechanism, choose_independent_coordinates<S>(mechanism, options.independent)),
      observer_(mechanism, branch_.tree(), branch_.freedoms(), to_vector<S>(options.about)),
      gravity_(to_vector<S>(mechanism.gravity)),
      wrenches_(branch_.tree().nodes.size()),
      tau_(static_cast<std::size_t>(branch_.tree().columns)) {
  const Tree<S>& tree = branch_.tree();
  freedoms = branch_.freedoms();
  for (const int c : branch_.independent()) independent.push_back(mechanism.coordinates[c].name);
  if (!branch_.note().empty()) notes.push_back(branch_.note());
  for (const std::string& note : observer_.actuation().notes()) notes.push_back(note);
  for (const PassiveFreedom& spin : tree.locked_freedoms) notes.push_back(describe_locked_freedom(mechanism, spin));
  std::vector<bool> driven(tau_.size(), false);
  for (const CoordinateId coordinate : mechanism.actuators) {
    const LinearQuantity& source = tree.coordinate_expressions[coordinate];
    if (!source.has_single_term()) continue;
    const auto& [column, ratio] = source.terms[0];
    motors_.push_back({column, 1 / ratio});
    driven[column] = true;
  }
  is_fully_actuated_tree = branch_.is_explicit() && motors_.size() == tau_.size() &&
                           motors_.size() == mechanism.actuators.size() && mechanism.loads.empty() &&
                           mechanism.springs.empty() && std::find(driven.begin(), driven.end(), false) == driven.end();
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::assemble(const double* q, const std::vector<CoordinateValue>& near,
                                             VectorX& coordinates) {
  observer_.restart();
  MotionOutcome outcome = branch_.assemble(q, near);
  if (outcome.status == MotionStatus::done) coordinates = branch_.coordinates();
  return outcome;
}

/// Tree coordinates, rates and accelerations of a state.
template <class S>
MotionOutcome InverseDynamicsOf<S>::set_state(const StateView& state) {
  MotionOutcome outcome = branch_.move_to(state.q);
  if (outcome.status != MotionStatus::done) {
    outcome.time = state.time;
    return outcome;
  }
  branch_.set_rates(state.dq);
  branch_.set_accelerations(state.ddq);
  return outcome;
}

template <class S>
TreeMotion<S> InverseDynamicsOf<S>::instant(double time) {
  return {branch_.state(), branch_.y(), branch_.dy(), branch_.ddy(), time, branch_.is_explicit()};
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::not_held(double time) const {
  const std::string where = format_configuration(mechanism, branch_.tree(), branch_.y());
  return {MotionStatus::actuation_singularity,
          time,
          "actuation singularity: the actuators do not hold the mechanism there; configuration: " + where,
          {}};
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::mismatch(double time) const {
  return {MotionStatus::mismatch, time, observer_.actuation().mismatch(), {}};
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::solve_open_tree(const StateView& state, double* effort) {
  const double *y = state.q, *dy = state.dq, *ddy = state.ddq;
  if (!branch_.has_identity_map()) {
    branch_.move_to(state.q);
    branch_.set_rates(state.dq);
    branch_.set_accelerations(state.ddq);
    y = branch_.y(), dy = branch_.dy(), ddy = branch_.ddy();
  }
  double* tau = tau_.data();
  open_tree_inverse_dynamics<S>(branch_.tree(), y, dy, ddy, gravity_, branch_.state(), wrenches_, tau);
  if (!mechanism.friction.empty()) add_friction_forces(mechanism, branch_.tree(), dy, options.time_scale, tau);
  double sum = 0;  // 0 if all are finite
  for (std::size_t a = 0; a < motors_.size(); ++a) {
    effort[a] = tau[motors_[a].column] * motors_[a].inverse;
    sum += effort[a] * 0;
  }
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (sum != 0 || std::isnan(sum)) outcome = make_overflow_outcome(state.time, "torque", mechanism);
  return outcome;
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::efforts(const StateView& state, double* effort) {
  if (is_fully_actuated_tree) return solve_open_tree(state, effort);
  if (!observer_.actuation().mismatch().empty()) return mismatch(state.time);
  MotionOutcome outcome = set_state(state);
  if (outcome.status != MotionStatus::done) return outcome;
  if (!observer_.solve_efforts(instant(state.time), branch_.equations(), options.time_scale))
    return not_held(state.time);
  const VectorX& found = observer_.sample().effort;
  if (!found.allFinite()) return make_overflow_outcome(state.time, "torque", mechanism);
  std::copy_n(found.data(), found.size(), effort);
  return outcome;
}

template <class S>
void InverseDynamicsOf<S>::efforts(const StateTableView& states, EffortBatch& table) {
  const Eigen::Index actuators = table.efforts.cols();
  for (Eigen::Index k = 0; k < states.rows(); ++k) {
    double* effort = table.efforts.data() + k * actuators;
    MotionOutcome outcome = InverseDynamicsOf::efforts(states.row(k), effort);
    if (outcome.status == MotionStatus::done) continue;
    std::fill_n(effort, actuators, quiet_nan);
    table.failures.push_back({k, std::move(outcome)});
  }
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::observe(const StateView& state, Sample& sample) {
  MotionOutcome outcome = set_state(state);
  if (outcome.status != MotionStatus::done) return outcome;
  const bool held = observer_.evaluate(instant(state.time), branch_.equations(), options.time_scale, Detail::all);
  sample = observer_.sample();
  sample.mobility = branch_.mobility();
  sample.newton_iterations = branch_.iterations();
  if (!held) {
    invalidate_efforts(!branch_.is_explicit(), sample);
    return observer_.actuation().mismatch().empty() ? not_held(state.time) : mismatch(state.time);
  }
  if (const char* what = find_nonfinite_quantity(sample)) return make_overflow_outcome(state.time, what, mechanism);
  return outcome;
}

template <class S>
void InverseDynamicsOf<S>::measure_terms(const Sample& sample, double time, TermMagnitudes& terms,
                                         TermMagnitudes& grown) {
  Sample known = sample;  // efforts that were not found have no size
  const auto forget = [](double& x) { x = std::isnan(x) ? 0 : x; };
  for (VectorX* all : {&known.effort, &known.power}) std::for_each(all->begin(), all->end(), forget);
  for (auto* all : {&known.joint_force, &known.joint_moment})
    for (Vector3& v : *all) std::for_each(v.begin(), v.end(), forget);
  const double rate = 1 / options.time_scale;
  TermMagnitudeRecorder<S> meter(mechanism, branch_.tree(), to_vector<S>(options.about), RestScale{rate, rate * rate});
  meter.sample(instant(time), known, observer_.actuation().multipliers(), sample.mobility);
  terms = meter.magnitudes();
  grown = meter.amplified_magnitudes();
}

/// One column after another: the generalised forces that a unit acceleration from rest takes without weight.
template <class S>
MotionOutcome InverseDynamicsOf<S>::mass_matrix(const double* q, MatrixX& mass) {
  const std::vector<double> rest(static_cast<std::size_t>(freedoms), 0);
  MotionOutcome outcome = set_state({q, rest.data(), rest.data(), 0});
  if (outcome.status != MotionStatus::done) return outcome;
  const Tree<S>& tree = branch_.tree();
  TreeState<S>& state = branch_.state();
  branch_.fill_transformation(C_);
  compute_poses(tree, branch_.y(), state);
  const VectorX zero = VectorX::Zero(tree.columns);
  compute_velocities(tree, zero.data(), state);
  mass.resize(freedoms, freedoms);
  for (int k = 0; k < freedoms; ++k) {
    for (auto& wrench : wrenches_) wrench = {};
    compute_accelerations<S>(tree, zero.data(), C_.col(k).data(), S::Vector::Zero(), state);
    inverse_dynamics(tree, state, wrenches_, tau_.data());
    mass.col(k) = C_.transpose() * Eigen::Map<const VectorX>(tau_.data(), tree.columns);
  }
  mass = (mass + mass.transpose().eval()) / 2;
  return mass.allFinite() ? outcome : make_overflow_outcome(0, "the mass matrix", mechanism);
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::bias(const StateView& state, VectorX& bias) {
  MotionOutcome outcome = set_state(state);
  if (outcome.status != MotionStatus::done) return outcome;
  observer_.solve_efforts(instant(state.time), branch_.equations(), options.time_scale);
  branch_.fill_transformation(C_);
  bias = C_.transpose() * Eigen::Map<const VectorX>(observer_.generalised_forces().data(), branch_.tree().columns);
  return bias.allFinite() ? outcome : make_overflow_outcome(state.time, "the bias", mechanism);
}

/// The matrices of the shaking force and moment: rates of momentum, without weight.
template <class S>
void InverseDynamicsOf<S>::fill_shaking(EffortRegressor& out) {
  const Tree<S>& tree = branch_.tree();
  compute_accelerations<S>(tree, branch_.dy(), branch_.ddy(), S::Vector::Zero(), branch_.state());
  const InertiaRegressor<S> momentum = balance::compute_regressor(tree, branch_.state());
  out.shaking_force = momentum.force;
  out.shaking_moment = momentum.moment;
  for (Eigen::Index p = 0; p < momentum.force.cols(); ++p) {
    const typename S::Vector force = momentum.force.col(p);
    const Vector3 moved = angular_to_3d(cross(to_vector<S>(options.about), force));
    out.shaking_moment.col(p) -= moved.template tail<S::angular_dimension>();
  }
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::regressor(const StateView& state, EffortRegressor& out) {
  MotionOutcome outcome = set_state(state);
  if (outcome.status != MotionStatus::done) return outcome;
  const Tree<S>& tree = branch_.tree();
  Mechanism massive = mechanism;
  massive.springs.clear();
  out.parameters = list_parameters(massive);
  out.values = list_inertial_parameters(tree);
  observer_.solve_efforts(instant(state.time), branch_.equations(), options.time_scale);
  const Eigen::Map<const VectorX> all(observer_.generalised_forces().data(), tree.columns);
  const InertiaRegressor<S> forces = balance::compute_regressor(tree, branch_.state());
  fill_shaking(out);
  if (!observer_.actuation().mismatch().empty()) return mismatch(state.time);
  MatrixX projection;
  if (!observer_.project(branch_.equations(), projection)) return not_held(state.time);
  out.effort = projection * forces.torque;
  out.constant_effort = projection * (all - forces.torque * out.values);
  return out.effort.allFinite() && out.constant_effort.allFinite()
             ? outcome
             : make_overflow_outcome(state.time, "the regressor", mechanism);
}

template class InverseDynamicsOf<Planar>;
template class InverseDynamicsOf<Spatial>;

}  // namespace balance
