#include "balance/mechanics/dynamics/inverse_dynamics.hpp"

#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/dynamics/inertia_regressor.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics_impl.hpp"
#include "balance/mechanics/dynamics/term_magnitude_recorder.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace balance::dynamics {

namespace {

constexpr double quiet_nan = std::numeric_limits<double>::quiet_NaN();

/// Name of the first quantity of a sample that is not finite; null if all are.
const char* find_nonfinite_quantity(const Sample& s) {
  const auto all_finite = [](const std::vector<Vector3>& all) {
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
  if (!all_finite(s.joint_force) || !all_finite(s.joint_moment)) return "joint_force";
  if (!std::isfinite(s.kinetic_energy) || !std::isfinite(s.potential_energy)) return "energy";
  return nullptr;
}

void invalidate_efforts(bool loops, Sample& sample) {
  sample.effort.setConstant(quiet_nan);
  sample.power.setConstant(quiet_nan);
  sample.total_torque = quiet_nan;
  if (!loops) return;  // reactions in an open tree do not depend on the efforts
  for (auto* all : {&sample.joint_force, &sample.joint_moment})
    for (Vector3& v : *all) v.setConstant(quiet_nan);
}

}  // namespace

template <class S>
InverseDynamicsOf<S>::InverseDynamicsOf(const Mechanism& source_mechanism, const InverseOptions& requested_options)
    : Implementation(source_mechanism, requested_options),
      branch_(mechanism, kinematics::choose_independent_coordinates<S>(mechanism, options.independent)),
      sample_evaluator_(mechanism, branch_.tree(), branch_.freedoms(), kinematics::to_vector<S>(options.about)),
      gravity_(kinematics::to_vector<S>(mechanism.gravity)),
      wrenches_(branch_.tree().nodes.size()),
      tau_(static_cast<std::size_t>(branch_.tree().columns)) {
  const kinematics::Tree<S>& tree = branch_.tree();
  freedoms = branch_.freedoms();
  for (const int c : branch_.independent()) independent.push_back(mechanism.coordinates[c].name);
  if (!branch_.note().empty()) notes.push_back(branch_.note());
  for (const std::string& note : sample_evaluator_.actuation().notes()) notes.push_back(note);
  for (const model::PassiveFreedom& freedom : tree.locked_freedoms)
    notes.push_back(trajectory::describe_locked_freedom(mechanism, freedom));
  std::vector<bool> is_driven(tau_.size(), false);
  for (const CoordinateId coordinate : mechanism.actuators) {
    const kinematics::LinearQuantity& source = tree.coordinate_expressions[coordinate];
    if (!source.has_single_term()) continue;
    const auto& [column, ratio] = source.terms[0];
    actuated_columns_.push_back({column, 1 / ratio});
    is_driven[column] = true;
  }
  is_fully_actuated_tree = branch_.is_explicit() && actuated_columns_.size() == tau_.size() &&
                           actuated_columns_.size() == mechanism.actuators.size() && mechanism.loads.empty() &&
                           mechanism.springs.empty() && mechanism.force_elements.empty() &&
                           std::find(is_driven.begin(), is_driven.end(), false) == is_driven.end();
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::assemble(const double* q, const std::vector<CoordinateValue>& near,
                                             VectorX& coordinates) {
  sample_evaluator_.restart();
  MotionOutcome outcome = branch_.assemble(q, near);
  if (outcome.status == MotionStatus::done) coordinates = branch_.coordinates();
  return outcome;
}

/// Sets the tree coordinates, rates and accelerations of a state.
template <class S>
MotionOutcome InverseDynamicsOf<S>::set_state(const StateView& state) {
  MotionOutcome outcome = branch_.move_to(state.q, state.time);
  if (outcome.status != MotionStatus::done) {
    outcome.time = state.time;
    return outcome;
  }
  branch_.set_rates(state.dq);
  branch_.set_accelerations(state.ddq);
  return outcome;
}

template <class S>
TreeMotion<S> InverseDynamicsOf<S>::current_motion(double time) {
  return {branch_.state(), branch_.y(), branch_.dy(), branch_.ddy(), time, branch_.is_explicit()};
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::make_not_held_outcome(double time) const {
  const std::string configuration = format_configuration(mechanism, branch_.tree(), branch_.y());
  return {MotionStatus::actuation_singularity,
          time,
          "actuation singularity: the actuators do not hold the mechanism there; configuration: " + configuration,
          {}};
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::mismatch(double time) const {
  return {MotionStatus::mismatch, time, sample_evaluator_.actuation().mismatch(), {}};
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::solve_open_tree(const StateView& state, double* effort) {
  const double *y = state.q, *dy = state.dq, *ddy = state.ddq;
  if (!branch_.has_identity_map()) {
    branch_.move_to(state.q, state.time);
    branch_.set_rates(state.dq);
    branch_.set_accelerations(state.ddq);
    y = branch_.y(), dy = branch_.dy(), ddy = branch_.ddy();
  }
  double* tau = tau_.data();
  open_tree_inverse_dynamics<S>(branch_.tree(), y, dy, ddy, gravity_, branch_.state(), wrenches_, tau);
  if (!mechanism.friction.empty()) add_friction_forces(mechanism, branch_.tree(), dy, options.time_scale, tau);
  double sum = 0;  // 0 if all are finite
  for (std::size_t a = 0; a < actuated_columns_.size(); ++a) {
    effort[a] = tau[actuated_columns_[a].column] * actuated_columns_[a].inverse;
    sum += effort[a] * 0;
  }
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (sum != 0 || std::isnan(sum)) outcome = trajectory::make_overflow_outcome(state.time, "torque", mechanism);
  return outcome;
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::efforts(const StateView& state, double* effort) {
  if (is_fully_actuated_tree) return solve_open_tree(state, effort);
  if (!sample_evaluator_.actuation().mismatch().empty()) return mismatch(state.time);
  MotionOutcome outcome = set_state(state);
  if (outcome.status != MotionStatus::done) return outcome;
  if (!sample_evaluator_.solve_efforts(current_motion(state.time), branch_.equations(), options.time_scale))
    return make_not_held_outcome(state.time);
  const VectorX& effort_values = sample_evaluator_.sample().effort;
  if (!effort_values.allFinite()) return trajectory::make_overflow_outcome(state.time, "torque", mechanism);
  std::copy_n(effort_values.data(), effort_values.size(), effort);
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
  const bool is_held =
      sample_evaluator_.evaluate(current_motion(state.time), branch_.equations(), options.time_scale, Detail::all);
  sample = sample_evaluator_.sample();
  sample.mobility = branch_.mobility();
  sample.newton_iterations = branch_.iterations();
  if (!is_held) {
    invalidate_efforts(!branch_.is_explicit(), sample);
    return sample_evaluator_.actuation().mismatch().empty() ? make_not_held_outcome(state.time) : mismatch(state.time);
  }
  if (const char* what = find_nonfinite_quantity(sample))
    return trajectory::make_overflow_outcome(state.time, what, mechanism);
  return outcome;
}

template <class S>
void InverseDynamicsOf<S>::measure_terms(const Sample& sample, double time, results::TermMagnitudes& terms,
                                         results::TermMagnitudes& amplified) {
  Sample finite_sample = sample;  // unknown efforts count as zero
  const auto replace_nan = [](double& x) { x = std::isnan(x) ? 0 : x; };
  for (VectorX* all : {&finite_sample.effort, &finite_sample.power})
    std::for_each(all->begin(), all->end(), replace_nan);
  for (auto* all : {&finite_sample.joint_force, &finite_sample.joint_moment})
    for (Vector3& v : *all) std::for_each(v.begin(), v.end(), replace_nan);
  const double rate = 1 / options.time_scale;
  TermMagnitudeRecorder<S> recorder(mechanism, branch_.tree(), kinematics::to_vector<S>(options.about),
                                    RestScale{rate, rate * rate});
  recorder.sample(current_motion(time), finite_sample, sample_evaluator_.actuation().multipliers(), sample.mobility);
  terms = recorder.magnitudes();
  amplified = recorder.amplified_magnitudes();
}

/// Column by column: the generalised forces of a unit acceleration from rest, without weight.
template <class S>
MotionOutcome InverseDynamicsOf<S>::mass_matrix(const double* q, MatrixX& mass) {
  const std::vector<double> zero_rates(static_cast<std::size_t>(freedoms), 0);
  MotionOutcome outcome = set_state({q, zero_rates.data(), zero_rates.data(), 0});
  if (outcome.status != MotionStatus::done) return outcome;
  const kinematics::Tree<S>& tree = branch_.tree();
  kinematics::TreeState<S>& state = branch_.state();
  branch_.fill_transformation(C_);
  compute_poses(tree, branch_.y(), state);
  const VectorX zero = VectorX::Zero(tree.columns);
  compute_velocities(tree, zero.data(), state);
  mass.resize(freedoms, freedoms);
  for (int k = 0; k < freedoms; ++k) {
    for (auto& wrench : wrenches_) wrench = {};
    kinematics::compute_accelerations<S>(tree, zero.data(), C_.col(k).data(), S::Vector::Zero(), state);
    inverse_dynamics(tree, state, wrenches_, tau_.data());
    mass.col(k) = C_.transpose() * Eigen::Map<const VectorX>(tau_.data(), tree.columns);
  }
  mass = (mass + mass.transpose().eval()) / 2;
  return mass.allFinite() ? outcome : trajectory::make_overflow_outcome(0, "the mass matrix", mechanism);
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::bias(const StateView& state, VectorX& bias) {
  MotionOutcome outcome = set_state(state);
  if (outcome.status != MotionStatus::done) return outcome;
  sample_evaluator_.solve_efforts(current_motion(state.time), branch_.equations(), options.time_scale);
  branch_.fill_transformation(C_);
  bias =
      C_.transpose() * Eigen::Map<const VectorX>(sample_evaluator_.generalised_forces().data(), branch_.tree().columns);
  return bias.allFinite() ? outcome : trajectory::make_overflow_outcome(state.time, "the bias", mechanism);
}

/// The matrices of the shaking force and moment: rates of momentum, without weight.
template <class S>
void InverseDynamicsOf<S>::fill_shaking(EffortRegressor& out) {
  const kinematics::Tree<S>& tree = branch_.tree();
  kinematics::compute_accelerations<S>(tree, branch_.dy(), branch_.ddy(), S::Vector::Zero(), branch_.state());
  const InertiaRegressor<S> momentum = dynamics::compute_regressor(tree, branch_.state());
  out.shaking_force = momentum.force;
  out.shaking_moment = momentum.moment;
  for (Eigen::Index p = 0; p < momentum.force.cols(); ++p) {
    const typename S::Vector force = momentum.force.col(p);
    const Vector3 moment_shift =
        kinematics::angular_to_3d(kinematics::cross(kinematics::to_vector<S>(options.about), force));
    out.shaking_moment.col(p) -= moment_shift.template tail<S::angular_dimension>();
  }
}

template <class S>
MotionOutcome InverseDynamicsOf<S>::regressor(const StateView& state, EffortRegressor& out) {
  MotionOutcome outcome = set_state(state);
  if (outcome.status != MotionStatus::done) return outcome;
  const kinematics::Tree<S>& tree = branch_.tree();
  Mechanism without_springs = mechanism;
  without_springs.springs.clear();
  out.parameters = list_parameters(without_springs);
  out.values = list_inertial_parameters(tree);
  sample_evaluator_.solve_efforts(current_motion(state.time), branch_.equations(), options.time_scale);
  const Eigen::Map<const VectorX> tau(sample_evaluator_.generalised_forces().data(), tree.columns);
  const InertiaRegressor<S> forces = dynamics::compute_regressor(tree, branch_.state());
  fill_shaking(out);
  if (!sample_evaluator_.actuation().mismatch().empty()) return mismatch(state.time);
  if (!sample_evaluator_.actuation().has_linear_projection())
    return {
        MotionStatus::mismatch, state.time, trajectory::describe_nonlinear_efforts("parameters times a matrix"), {}};
  MatrixX projection;
  if (!sample_evaluator_.project(branch_.equations(), projection)) return make_not_held_outcome(state.time);
  out.effort = projection * forces.torque;
  out.constant_effort = projection * (tau - forces.torque * out.values);
  return out.effort.allFinite() && out.constant_effort.allFinite()
             ? outcome
             : trajectory::make_overflow_outcome(state.time, "the regressor", mechanism);
}

template class InverseDynamicsOf<kinematics::Planar>;
template class InverseDynamicsOf<kinematics::Spatial>;

namespace {

std::string join_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

void check_size(const char* what, const VectorX& values, const std::vector<std::string>& names) {
  if (values.size() != static_cast<Eigen::Index>(names.size()))
    throw std::invalid_argument(std::string(what) + ": expected " + std::to_string(names.size()) + " numbers for " +
                                join_names(names) + "; got " + std::to_string(values.size()));
}

void check_finite(const char* what, const VectorX& values) {
  if (!values.allFinite()) throw std::invalid_argument(std::string(what) + ": expected finite numbers");
}

void check_state(const char* what, const VectorX& values, const std::vector<std::string>& names) {
  check_size(what, values, names);
  check_finite(what, values);
}

void check_table(const char* what, const Eigen::Ref<const Samples>& values, Eigen::Index rows,
                 const std::vector<std::string>& names) {
  const auto shape = [](const std::string& count, Eigen::Index columns) {
    return "(" + count + ", " + std::to_string(columns) + ")";
  };
  const auto columns = static_cast<Eigen::Index>(names.size());
  if (values.cols() != columns || (rows >= 0 && values.rows() != rows))
    throw std::invalid_argument(std::string(what) + ": expected " +
                                shape(rows >= 0 ? std::to_string(rows) : "…", columns) + " for " + join_names(names) +
                                "; got " + shape(std::to_string(values.rows()), values.cols()));
  for (Eigen::Index k = 0; k < values.rows(); ++k)
    if (!values.row(k).allFinite())
      throw std::invalid_argument(std::string(what) + ": expected finite numbers; row " + std::to_string(k) +
                                  " has non-finite ones");
}

void check_time(const VectorX& time, Eigen::Index rows) {
  if (time.size() != 0 && time.size() != rows)
    throw std::invalid_argument("time: expected " + std::to_string(rows) + " numbers or none; got " +
                                std::to_string(time.size()));
  if (!time.allFinite()) throw std::invalid_argument("time: expected finite numbers");
}

void check_time(double time) {
  if (!std::isfinite(time)) throw std::invalid_argument("time: expected a finite number");
}

std::unique_ptr<InverseDynamics::Implementation> make_inverse_dynamics(const Mechanism& mechanism,
                                                                       const InverseOptions& options) {
  require_valid(mechanism);
  if (has_temporary_payloads(mechanism))
    throw std::invalid_argument("single states need payloads that are always there");
  if (has_velocity_constraints(mechanism))
    throw std::invalid_argument(
        "constraints on speeds (also rolling joints): independent coordinates do not determine the configuration; use "
        "EquationTerms, which takes all coordinates");
  if (!options.about.allFinite()) throw std::invalid_argument("about: expected finite numbers");
  if (!(options.time_scale > 0) || !std::isfinite(options.time_scale))
    throw std::invalid_argument("time_scale: expected a positive number");
  return kinematics::dispatch_space(mechanism.space,
                                    [&]<class S>(S) -> std::unique_ptr<InverseDynamics::Implementation> {
                                      return std::make_unique<InverseDynamicsOf<S>>(mechanism, options);
                                    });
}

}  // namespace

InverseDynamics::InverseDynamics(const Mechanism& mechanism, const InverseOptions& options)
    : engine_(make_inverse_dynamics(mechanism, options)) {}
InverseDynamics::~InverseDynamics() = default;
InverseDynamics::InverseDynamics(InverseDynamics&&) noexcept = default;
InverseDynamics& InverseDynamics::operator=(InverseDynamics&&) noexcept = default;

const Mechanism& InverseDynamics::mechanism() const { return engine_->mechanism; }
int InverseDynamics::degrees_of_freedom() const { return engine_->freedoms; }
const std::vector<std::string>& InverseDynamics::independent() const { return engine_->independent; }
const std::vector<std::string>& InverseDynamics::notes() const { return engine_->notes; }

std::vector<std::string> InverseDynamics::actuators() const {
  std::vector<std::string> names;
  for (const int a : engine_->mechanism.actuators)
    names.push_back(engine_->mechanism.coordinates[static_cast<std::size_t>(a)].name);
  return names;
}

Expected<VectorX> InverseDynamics::assemble(const VectorX& q, const std::vector<CoordinateGuess>& near) {
  check_state("q", q, engine_->independent);
  std::vector<CoordinateValue> values;
  for (const CoordinateGuess& value : near) {
    if (!std::isfinite(value.value)) throw std::invalid_argument("near: expected finite numbers");
    values.push_back({kinematics::require_coordinate(engine_->mechanism, value.coordinate, "near"), value.value});
  }
  Expected<VectorX> result;
  result.outcome = engine_->assemble(q.data(), values, result.value);
  return result;
}

Expected<Sample> InverseDynamics::at(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time) {
  check_state("q", q, engine_->independent);
  check_state("dq", dq, engine_->independent);
  check_state("ddq", ddq, engine_->independent);
  check_time(time);
  Expected<Sample> result;
  result.outcome = engine_->observe({q.data(), dq.data(), ddq.data(), time}, result.value);
  return result;
}

MotionOutcome InverseDynamics::efforts(const VectorX& q, const VectorX& dq, const VectorX& ddq, VectorX& effort,
                                       double time) {
  check_size("q", q, engine_->independent);
  check_size("dq", dq, engine_->independent);
  check_size("ddq", ddq, engine_->independent);
  const auto check_numbers = [&] { check_finite("q", q), check_finite("dq", dq), check_finite("ddq", ddq); };
  check_time(time);
  effort.resize(static_cast<Eigen::Index>(engine_->mechanism.actuators.size()));
  if (!engine_->is_fully_actuated_tree) check_numbers();
  MotionOutcome outcome = engine_->efforts({q.data(), dq.data(), ddq.data(), time}, effort.data());
  if (engine_->is_fully_actuated_tree && outcome.status != MotionStatus::done)
    check_numbers();  // the fast path checks only now
  return outcome;
}

EffortBatch InverseDynamics::effort_rows(const Eigen::Ref<const Samples>& q, const Eigen::Ref<const Samples>& dq,
                                         const Eigen::Ref<const Samples>& ddq, const VectorX& time) {
  check_table("q", q, -1, engine_->independent);
  check_table("dq", dq, q.rows(), engine_->independent);
  check_table("ddq", ddq, q.rows(), engine_->independent);
  check_time(time, q.rows());
  EffortBatch table;
  table.efforts.resize(q.rows(), static_cast<Eigen::Index>(engine_->mechanism.actuators.size()));
  engine_->efforts(StateTableView{q, dq, ddq, time}, table);
  return table;
}

SampleBatch InverseDynamics::at_rows(const Eigen::Ref<const Samples>& q, const Eigen::Ref<const Samples>& dq,
                                     const Eigen::Ref<const Samples>& ddq, const VectorX& time) {
  check_table("q", q, -1, engine_->independent);
  check_table("dq", dq, q.rows(), engine_->independent);
  check_table("ddq", ddq, q.rows(), engine_->independent);
  check_time(time, q.rows());
  SampleBatch table;
  RunResult& result = table.result;
  name_columns(engine_->mechanism, result);
  results::resize_arrays(engine_->mechanism, q.rows(), {}, result);
  result.moment_reference = engine_->options.about;
  results::ResultRecorder recorder(result);
  const double none = std::numeric_limits<double>::quiet_NaN();
  Sample sample;
  const StateTableView states{q, dq, ddq, time};
  for (Eigen::Index k = 0; k < states.rows(); ++k) {
    const StateView state = states.row(k);
    MotionOutcome outcome = engine_->observe(state, sample);
    sample.time = state.time;
    if (outcome.status == MotionStatus::done) {
      recorder.write(sample, k, result);
    } else {  // the sample is that of the previous state, or empty
      result.time[k] = state.time;
      result.newton_iterations[k] = 0;
      for (const Quantity& quantity : list_sampled_quantities(result))
        (result.*quantity.member).row(k).setConstant(none);
      table.failures.push_back({k, std::move(outcome)});
    }
  }
  result.outcome.status = table.failures.empty() ? MotionStatus::done : table.failures.front().outcome.status;
  if (!table.failures.empty()) result.outcome.reason = table.failures.front().outcome.reason;
  result.outcome.notes = engine_->notes;
  return table;
}

Expected<MatrixX> InverseDynamics::mass_matrix(const VectorX& q) {
  check_state("q", q, engine_->independent);
  Expected<MatrixX> result;
  result.outcome = engine_->mass_matrix(q.data(), result.value);
  return result;
}

Expected<VectorX> InverseDynamics::bias(const VectorX& q, const VectorX& dq, double time) {
  check_state("q", q, engine_->independent);
  check_state("dq", dq, engine_->independent);
  check_time(time);
  const VectorX zero = VectorX::Zero(q.size());
  Expected<VectorX> result;
  result.outcome = engine_->bias({q.data(), dq.data(), zero.data(), time}, result.value);
  return result;
}

Expected<EffortRegressor> InverseDynamics::regressor(const VectorX& q, const VectorX& dq, const VectorX& ddq,
                                                     double time) {
  check_state("q", q, engine_->independent);
  check_state("dq", dq, engine_->independent);
  check_state("ddq", ddq, engine_->independent);
  check_time(time);
  Expected<EffortRegressor> result;
  result.outcome = engine_->regressor({q.data(), dq.data(), ddq.data(), time}, result.value);
  return result;
}

}  // namespace balance::dynamics
