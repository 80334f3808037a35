#include "balance/mechanics/dynamics/equation_terms.hpp"

#include "balance/mechanics/dynamics/equation_terms_impl.hpp"
#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace balance::dynamics {

namespace {

/// The mechanism with no external forces but those of one part.
Mechanism with_only(Mechanism mechanism, EffortPart part) {
  if (part != EffortPart::load) mechanism.loads.clear();
  if (part != EffortPart::spring) mechanism.springs.clear();
  std::erase_if(mechanism.force_elements, [part](const ForceElement& element) {
    return part != (element.is_damper() ? EffortPart::friction : EffortPart::spring);
  });
  return mechanism;
}

MotionOutcome finite_outcome(double time, bool finite, const char* what, const Mechanism& mechanism) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  return finite ? outcome : trajectory::make_overflow_outcome(time, what, mechanism);
}

}  // namespace

template <class S>
EquationTermsOf<S>::EquationTermsOf(const Mechanism& source_mechanism, const InverseOptions& requested_options)
    : Implementation(source_mechanism, requested_options),
      branch_(mechanism, kinematics::choose_independent_coordinates<S>(mechanism, options.independent)),
      actuation_(mechanism, branch_.tree(), branch_.freedoms()),
      only_loads_(with_only(mechanism, EffortPart::load)),
      only_springs_(with_only(mechanism, EffortPart::spring)),
      only_dampers_(with_only(mechanism, EffortPart::friction)),
      loads_(only_loads_, branch_.tree()),
      springs_(only_springs_, branch_.tree()),
      dampers_(only_dampers_, branch_.tree()),
      closure_system_(branch_.tree(), kinematics::Drive<S>{}),
      gravity_(kinematics::to_vector<S>(mechanism.gravity)),
      wrenches_(branch_.tree().nodes.size()),
      columns_(branch_.tree().columns),
      freedoms_(branch_.freedoms()),
      has_prescribed_speeds_(has_prescribed_speeds(mechanism)) {
  independent = branch_.independent();
  name_tree_coordinates();
  if (!branch_.note().empty()) notes.push_back(branch_.note());
  for (const std::string& note : actuation_.notes()) notes.push_back(note);
  for (const model::PassiveFreedom& freedom : branch_.tree().locked_freedoms)
    notes.push_back(trajectory::describe_locked_freedom(mechanism, freedom));
}

/// Names each column after the joint coordinate that equals it; of several coupled ones, after the leader.
template <class S>
void EquationTermsOf<S>::name_tree_coordinates() {
  const kinematics::Tree<S>& tree = branch_.tree();
  redundant.assign(static_cast<std::size_t>(columns_), "");
  for (int c = 0; c < columns_; ++c)
    redundant_lengths.push_back(tree.is_length_column[static_cast<std::size_t>(c)] != 0);
  for (std::size_t c = mechanism.coordinates.size(); c-- > 0;) {
    if (tree.coordinate_expressions[c].is_column())
      redundant[static_cast<std::size_t>(tree.coordinate_expressions[c].terms[0].first)] =
          mechanism.coordinates[c].name;
  }
  for (std::size_t c = 0; c < redundant.size(); ++c)
    if (redundant[c].empty()) redundant[c] = "y" + std::to_string(c + 1);
  auto constraint = mechanism.constraints.begin();
  for (const kinematics::Closure<S>& closure : tree.closures) {
    const std::string& name =
        closure.joint < 0 ? (constraint++)->name : mechanism.joints[static_cast<std::size_t>(closure.joint)].name;
    closures.insert(closures.end(), closure.rows.size(), name);
  }
  for (const Disc& disc : mechanism.discs)
    for (const char* axis : {".p", ".q", ".r"})
      if (mechanism.space == SpaceKind::spatial || axis[1] == 'r') disc_rows.push_back(disc.name + axis);
}

template <class S>
MotionOutcome EquationTermsOf<S>::assemble(const double* q, const std::vector<CoordinateValue>& near,
                                           VectorX& coordinates) {
  MotionOutcome outcome = branch_.assemble(q, near);
  if (outcome.status == MotionStatus::done) coordinates = branch_.coordinates();
  return outcome;
}

/// Moves to a configuration and updates poses and C.
template <class S>
MotionOutcome EquationTermsOf<S>::move_to(const double* q, double time) {
  MotionOutcome outcome = branch_.move_to(q, time);
  if (outcome.status != MotionStatus::done) return outcome;
  compute_poses(branch_.tree(), branch_.y(), branch_.state());
  branch_.fill_transformation(C_);
  return outcome;
}

/// Generalised forces per tree coordinate that the masses require at these rates and accelerations.
template <class S>
VectorX EquationTermsOf<S>::inverse_dynamics_forces(const VectorX& dy, const VectorX& ddy, bool weight) {
  const kinematics::Tree<S>& tree = branch_.tree();
  kinematics::TreeState<S>& state = branch_.state();
  compute_angular_velocities(tree, dy.data(), state);
  const typename S::Vector base = weight ? typename S::Vector(-gravity_) : typename S::Vector(S::Vector::Zero());
  kinematics::compute_accelerations<S>(tree, dy.data(), ddy.data(), base, state);
  for (auto& wrench : wrenches_) wrench = {};
  VectorX tau(columns_);
  inverse_dynamics(tree, state, wrenches_, tau.data());
  return tau;
}

template <class S>
VectorX EquationTermsOf<S>::external_forces(const ExternalForces<S>& forces, double time) {
  VectorX tau = VectorX::Zero(columns_);
  if (forces.is_empty()) return tau;
  for (auto& wrench : wrenches_) wrench = {};
  Wrench<S> total, loads;
  forces.subtract(branch_.state(), branch_.y(), time, wrenches_, total, loads);
  compute_wrench_forces(branch_.tree(), branch_.state(), wrenches_, tau.data());
  forces.add_joint_springs(branch_.y(), tau.data());
  return tau;
}

/// Generalised forces that overcome friction and dampers.
template <class S>
VectorX EquationTermsOf<S>::friction_forces(const VectorX& dy, double time) {
  VectorX tau = VectorX::Zero(columns_);
  if (dampers_.has_dampers()) {
    compute_velocities(branch_.tree(), dy.data(), branch_.state());
    tau = external_forces(dampers_, time);
  }
  if (!mechanism.friction.empty())
    add_friction_forces(mechanism, branch_.tree(), dy.data(), options.time_scale, tau.data());
  return tau;
}

template <class S>
StaticTerms EquationTermsOf<S>::compute_static_terms(double time) {
  const VectorX zero = VectorX::Zero(columns_);
  return {
      inverse_dynamics_forces(zero, zero, true), external_forces(springs_, time), external_forces(loads_, time), {}};
}

template <class S>
MatrixX EquationTermsOf<S>::mass_matrix() {
  const VectorX zero = VectorX::Zero(columns_);
  MatrixX mass(columns_, columns_);
  for (int c = 0; c < columns_; ++c) mass.col(c) = inverse_dynamics_forces(zero, VectorX::Unit(columns_, c), false);
  return (mass + mass.transpose()) / 2;
}

/// Of joints and dampers: generalised forces per rate.
template <class S>
MatrixX EquationTermsOf<S>::viscous_friction() {
  MatrixX viscous = MatrixX::Zero(columns_, columns_);
  for (int c = 0; c < columns_ && dampers_.has_dampers(); ++c) {
    const VectorX unit = VectorX::Unit(columns_, c);
    compute_velocities(branch_.tree(), unit.data(), branch_.state());
    viscous.col(c) = external_forces(dampers_, 0);
  }
  for (const Friction& friction : mechanism.friction) {
    VectorX rates = VectorX::Zero(columns_);
    branch_.tree().coordinate_expressions[static_cast<std::size_t>(friction.coordinate)].add_generalised_force(
        1, rates.data());
    viscous += friction.viscous * rates * rates.transpose();
  }
  return viscous;
}

template <class S>
MatrixX EquationTermsOf<S>::input_matrix() const {
  MatrixX out = MatrixX::Zero(columns_, static_cast<Eigen::Index>(mechanism.actuators.size()));
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a) {
    const auto coordinate = static_cast<std::size_t>(mechanism.actuators[a]);
    branch_.tree().coordinate_expressions[coordinate].add_generalised_force(
        1, out.col(static_cast<Eigen::Index>(a)).data());
  }
  return out;
}

/// A in SI units, without the scales that make its entries comparable.
template <class S>
MatrixX EquationTermsOf<S>::constraint_matrix() {
  const kinematics::Tree<S>& tree = branch_.tree();
  MatrixX A;
  closure_system_.velocity_jacobian(Eigen::Map<const VectorX>(branch_.y(), columns_), {}, A);
  const VectorX scale = column_scale(tree);
  A = A * scale.cwiseInverse().asDiagonal();
  Eigen::Index row = 0;
  for (const kinematics::Closure<S>& closure : tree.closures)
    for (const kinematics::ClosureRow& kind : closure.rows) A.row(row++) /= compute_row_scale(tree, closure, kind);
  return A;
}

/// The discs' angular velocities in their own axes for unit rates of the independent coordinates.
template <class S>
MatrixX EquationTermsOf<S>::disc_transformation() {
  const kinematics::Tree<S>& tree = branch_.tree();
  kinematics::TreeState<S>& state = branch_.state();
  const std::size_t first = mechanism.bodies.size() - 1 + mechanism.attachments.size();
  MatrixX rows(static_cast<Eigen::Index>(disc_rows.size()), freedoms_);
  const Eigen::Index components = mechanism.space == SpaceKind::spatial ? 3 : 1;
  for (int k = 0; k < freedoms_; ++k) {
    const VectorX dy = C_.col(k);
    compute_angular_velocities(tree, dy.data(), state);
    for (std::size_t d = 0; d < mechanism.discs.size(); ++d) {
      const kinematics::FixedFrame<S>& frame = tree.mass_elements[first + d].frame;
      const Vector3 w = to_matrix(frame.R_N).transpose() *
                        kinematics::angular_to_3d(state[static_cast<std::size_t>(frame.node)].angular_velocity);
      rows.col(k).segment(static_cast<Eigen::Index>(d) * components, components) = w.tail(components);
    }
  }
  return rows;
}

/// Tree accelerations due to the rates, with zero accelerations of the independent coordinates.
template <class S>
VectorX EquationTermsOf<S>::compute_velocity_product_acceleration(const VectorX& rates, VectorX& dy) {
  const VectorX zero = VectorX::Zero(freedoms_);
  branch_.set_rates(rates.data());
  branch_.set_accelerations(zero.data());
  dy = Eigen::Map<const VectorX>(branch_.dy(), columns_);
  return Eigen::Map<const VectorX>(branch_.ddy(), columns_);
}

template <class S>
MotionOutcome EquationTermsOf<S>::independent_terms(const double* q, double time, IndependentTerms& out) {
  if (MotionOutcome outcome = move_to(q, time); outcome.status != MotionStatus::done) return outcome;
  const StaticTerms static_terms = compute_static_terms(time);
  out.static_terms = {C_.transpose() * static_terms.weight,
                      C_.transpose() * static_terms.springs,
                      C_.transpose() * static_terms.loads,
                      {}};
  out.mass.resize(freedoms_, freedoms_);
  const VectorX zero = VectorX::Zero(columns_);
  for (int k = 0; k < freedoms_; ++k)
    out.mass.col(k) = C_.transpose() * inverse_dynamics_forces(zero, C_.col(k), false);
  out.mass = (out.mass + out.mass.transpose().eval()) / 2;
  const MatrixX viscous = viscous_friction();
  RateFunctions forces = expand_in_rates(freedoms_, !has_prescribed_speeds_, [&](const VectorX& rates) -> VectorX {
    VectorX dy;
    const VectorX ddy = compute_velocity_product_acceleration(rates, dy);
    return C_.transpose() * inverse_dynamics_forces(dy, ddy, false);
  });
  out.velocity = std::move(forces.quadratic);
  out.viscous = C_.transpose() * viscous * C_;
  if (has_prescribed_speeds_) {
    VectorX offset;
    compute_velocity_product_acceleration(VectorX::Zero(freedoms_), offset);
    out.viscous += forces.linear;
    out.static_terms.prescribed = forces.constant + C_.transpose() * (viscous * offset);
  }
  out.input = C_.transpose() * input_matrix();
  bool all_finite = out.mass.allFinite() && out.static_terms.sum().allFinite() && out.viscous.allFinite();
  for (const MatrixX& form : out.velocity) all_finite = all_finite && form.allFinite();
  return finite_outcome(time, all_finite, "the equation of motion", mechanism);
}

RateFunctions RateFunctions::substitute(const MatrixX& V, const VectorX& offset) const {
  RateFunctions out;
  for (const MatrixX& form : quadratic) out.quadratic.push_back(V.transpose() * form * V);
  if (linear.size() == 0 && offset.size() == 0) return out;
  const auto count = static_cast<Eigen::Index>(quadratic.size());
  out.linear = linear.size() > 0 ? MatrixX(linear * V) : MatrixX(MatrixX::Zero(count, V.cols()));
  out.constant = linear.size() > 0 ? constant : VectorX(VectorX::Zero(count));
  if (offset.size() == 0) return out;
  if (linear.size() > 0) out.constant += linear * offset;
  for (Eigen::Index k = 0; k < count; ++k) {
    const VectorX slope = quadratic[static_cast<std::size_t>(k)] * offset;
    out.linear.row(k) += 2 * slope.transpose() * V;
    out.constant[k] += offset.dot(slope);
  }
  return out;
}

template <class S>
std::vector<MatrixX> EquationTermsOf<S>::tree_velocity_terms() {
  const VectorX zero = VectorX::Zero(columns_);
  return polarise_quadratic_form(columns_, [&](const VectorX& dy) { return inverse_dynamics_forces(dy, zero, false); });
}

template <class S>
MotionOutcome EquationTermsOf<S>::redundant_terms(const double* q, double time, RedundantTerms& out) {
  if (MotionOutcome outcome = move_to(q, time); outcome.status != MotionStatus::done) return outcome;
  out.rest = compute_static_terms(time);
  out.mass = mass_matrix();
  out.velocity = tree_velocity_terms();
  out.viscous = viscous_friction();
  out.input = input_matrix();
  out.constraints = constraint_matrix();
  out.transformation = C_;
  out.discs = disc_transformation();
  RateFunctions accelerations = expand_in_rates(freedoms_, !has_prescribed_speeds_, [&](const VectorX& rates) {
    VectorX dy;
    return compute_velocity_product_acceleration(rates, dy);
  });
  out.acceleration = std::move(accelerations.quadratic);
  if (has_prescribed_speeds_) {
    out.acceleration_linear = std::move(accelerations.linear);
    out.acceleration_offset = std::move(accelerations.constant);
    compute_velocity_product_acceleration(VectorX::Zero(freedoms_), out.rate_offset);
    out.constraint_speeds = out.constraints * out.rate_offset;
  }
  if (freedoms_ == 0) out.acceleration.assign(static_cast<std::size_t>(columns_), MatrixX(0, 0));
  bool all_finite = out.mass.allFinite() && out.rest.sum().allFinite() && out.constraints.allFinite();
  for (const MatrixX& form : out.velocity) all_finite = all_finite && form.allFinite();
  return finite_outcome(time, all_finite, "the equation of motion", mechanism);
}

/// Efforts per unit of the tree's generalised forces.
template <class S>
MotionOutcome EquationTermsOf<S>::projection(double time, MatrixX& matrix) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (!actuation_.mismatch().empty()) return {MotionStatus::mismatch, time, actuation_.mismatch(), {}};
  if (!actuation_.has_linear_projection())
    return {MotionStatus::mismatch, time, trajectory::describe_nonlinear_efforts("parts"), {}};
  if (!actuation_.project(branch_.equations(), matrix))
    return {MotionStatus::actuation_singularity,
            time,
            "actuation singularity: the actuators do not hold the mechanism there; configuration: " +
                format_configuration(mechanism, branch_.tree(), branch_.y()),
            {}};
  return outcome;
}

template <class S>
MotionOutcome EquationTermsOf<S>::split(const double* q, const double* dq, const double* ddq, double time,
                                        EffortBreakdown& out) {
  if (MotionOutcome outcome = move_to(q, time); outcome.status != MotionStatus::done) return outcome;
  MatrixX P;
  if (MotionOutcome outcome = projection(time, P); outcome.status != MotionStatus::done) return outcome;
  const Eigen::Map<const VectorX> rates(dq, freedoms_), accelerations(ddq, freedoms_);
  const VectorX zero = VectorX::Zero(columns_);
  VectorX dy;
  const VectorX c = compute_velocity_product_acceleration(rates, dy), C_ddq = C_ * accelerations;
  const VectorX friction = friction_forces(dy, time);
  const StaticTerms static_terms = compute_static_terms(time);
  MatrixX tau(columns_, static_cast<Eigen::Index>(effort_part_names.size()));
  tau << inverse_dynamics_forces(zero, C_ddq, false), inverse_dynamics_forces(dy, c, false), friction,
      static_terms.weight, static_terms.springs, static_terms.loads;
  out.parts = P * tau;
  // the total, with the multipliers of the loops
  const VectorX total =
      inverse_dynamics_forces(dy, C_ddq + c, true) + friction + static_terms.springs + static_terms.loads;
  actuation_.solve(branch_.equations(), total.data());
  out.effort =
      Eigen::Map<const VectorX>(actuation_.efforts().data(), static_cast<Eigen::Index>(actuation_.efforts().size()));
  return finite_outcome(time, out.parts.allFinite() && out.effort.allFinite(), "torque", mechanism);
}

template class EquationTermsOf<kinematics::Planar>;
template class EquationTermsOf<kinematics::Spatial>;

namespace {

std::unique_ptr<EquationTerms::Implementation> make_equation_terms(const Mechanism& mechanism,
                                                                   const InverseOptions& options) {
  require_valid(mechanism);
  if (!(options.time_scale > 0) || !std::isfinite(options.time_scale))
    throw std::invalid_argument("time_scale: expected a positive number");
  return kinematics::dispatch_space(mechanism.space, [&]<class S>(S) -> std::unique_ptr<EquationTerms::Implementation> {
    return std::make_unique<EquationTermsOf<S>>(mechanism, options);
  });
}

void check_vector(const char* what, const VectorX& values, const std::vector<CoordinateId>& independent) {
  if (values.size() != static_cast<Eigen::Index>(independent.size()))
    throw std::invalid_argument(std::string(what) + ": expected " + std::to_string(independent.size()) +
                                " numbers; got " + std::to_string(values.size()));
  if (!values.allFinite()) throw std::invalid_argument(std::string(what) + ": expected finite numbers");
}

}  // namespace

EquationTerms::EquationTerms(const Mechanism& mechanism, const InverseOptions& options)
    : engine_(make_equation_terms(mechanism, options)) {}
EquationTerms::~EquationTerms() = default;
EquationTerms::EquationTerms(EquationTerms&&) noexcept = default;
EquationTerms& EquationTerms::operator=(EquationTerms&&) noexcept = default;

const Mechanism& EquationTerms::mechanism() const { return engine_->mechanism; }
int EquationTerms::degrees_of_freedom() const { return static_cast<int>(engine_->independent.size()); }
const std::vector<CoordinateId>& EquationTerms::independent() const { return engine_->independent; }
const std::vector<std::string>& EquationTerms::redundant() const { return engine_->redundant; }
std::vector<bool> EquationTerms::redundant_lengths() const { return engine_->redundant_lengths; }
const std::vector<std::string>& EquationTerms::closures() const { return engine_->closures; }
const std::vector<std::string>& EquationTerms::disc_rows() const { return engine_->disc_rows; }
const std::vector<std::string>& EquationTerms::notes() const { return engine_->notes; }

Expected<VectorX> EquationTerms::assemble(const VectorX& q, const std::vector<CoordinateValue>& near) {
  check_vector("q", q, engine_->independent);
  Expected<VectorX> result;
  result.outcome = engine_->assemble(q.data(), near, result.value);
  return result;
}

Expected<IndependentTerms> EquationTerms::independent_terms(const VectorX& q, double time) {
  check_vector("q", q, engine_->independent);
  Expected<IndependentTerms> result;
  result.outcome = engine_->independent_terms(q.data(), time, result.value);
  return result;
}

Expected<RedundantTerms> EquationTerms::redundant_terms(const VectorX& q, double time) {
  check_vector("q", q, engine_->independent);
  Expected<RedundantTerms> result;
  result.outcome = engine_->redundant_terms(q.data(), time, result.value);
  return result;
}

Expected<EffortBreakdown> EquationTerms::split_efforts(const VectorX& q, const VectorX& dq, const VectorX& ddq,
                                                       double time) {
  check_vector("q", q, engine_->independent);
  check_vector("dq", dq, engine_->independent);
  check_vector("ddq", ddq, engine_->independent);
  Expected<EffortBreakdown> result;
  result.outcome = engine_->split(q.data(), dq.data(), ddq.data(), time, result.value);
  return result;
}

}  // namespace balance::dynamics
