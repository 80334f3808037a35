#include "balance/equations/engine.hpp"

#include "balance/dynamics/friction.hpp"
#include "balance/equations/polarised.hpp"
#include "balance/motion/configuration_text.hpp"
#include "balance/motion/wording.hpp"

#include <cmath>

namespace balance {

namespace {

/// The mechanism with no other outer forces than these.
Mechanism with_only(Mechanism mechanism, EffortPart part) {
  if (part != EffortPart::load) mechanism.loads.clear();
  if (part != EffortPart::spring) mechanism.springs.clear();
  return mechanism;
}

MotionOutcome finite_or(double time, bool finite, const char* what, const Mechanism& mechanism) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  return finite ? outcome : numbers_overflow(time, what, mechanism);
}

}  // namespace

template <class S>
TermsEngine<S>::TermsEngine(const Mechanism& given, const InverseOptions& wishes)
    : Engine(given, wishes),
      branch_(mechanism, choose_independent<S>(mechanism, options.independent)),
      actuation_(mechanism, branch_.tree(), branch_.freedoms()),
      only_loads_(with_only(mechanism, EffortPart::load)),
      only_springs_(with_only(mechanism, EffortPart::spring)),
      loads_(only_loads_, branch_.tree()),
      springs_(only_springs_, branch_.tree()),
      closure_system_(branch_.tree(), Drive<S>{}),
      gravity_(to_vector<S>(mechanism.gravity)),
      wrenches_(branch_.tree().nodes.size()),
      columns_(branch_.tree().columns),
      freedoms_(branch_.freedoms()) {
  independent = branch_.independent();
  name_tree();
  if (!branch_.note().empty()) notes.push_back(branch_.note());
  for (const std::string& note : actuation_.notes()) notes.push_back(note);
  for (const PassiveFreedom& spin : branch_.tree().locked_freedoms) notes.push_back(locked_freedom(mechanism, spin));
}

/// A column is called like the joint coordinate that it is; of several that are coupled, the leader.
template <class S>
void TermsEngine<S>::name_tree() {
  const Tree<S>& tree = branch_.tree();
  redundant.assign(static_cast<std::size_t>(columns_), "");
  for (int c = 0; c < columns_; ++c)
    redundant_lengths.push_back(tree.column_kind_length[static_cast<std::size_t>(c)] != 0);
  for (std::size_t c = mechanism.coordinates.size(); c-- > 0;) {
    if (tree.sources[c].is_column())
      redundant[static_cast<std::size_t>(tree.sources[c].terms[0].first)] = mechanism.coordinates[c].name;
  }
  for (std::size_t c = 0; c < redundant.size(); ++c)
    if (redundant[c].empty()) redundant[c] = "y" + std::to_string(c + 1);
  auto constraint = mechanism.constraints.begin();
  for (const Closure<S>& closure : tree.closures) {
    const std::string& name =
        closure.joint < 0 ? (constraint++)->name : mechanism.joints[static_cast<std::size_t>(closure.joint)].name;
    closures.insert(closures.end(), closure.rows.size(), name);
  }
}

template <class S>
MotionOutcome TermsEngine<S>::assemble(const double* q, const std::vector<CoordinateValue>& near,
                                       VectorX& coordinates) {
  MotionOutcome outcome = branch_.assemble(q, near);
  if (outcome.status == MotionStatus::done) coordinates = branch_.coordinates();
  return outcome;
}

/// Poses and C at a configuration.
template <class S>
MotionOutcome TermsEngine<S>::go(const double* q) {
  MotionOutcome outcome = branch_.go(q);
  if (outcome.status != MotionStatus::done) return outcome;
  poses(branch_.tree(), branch_.y(), branch_.state());
  branch_.fill_transformation(C_);
  return outcome;
}

/// What it takes to move the masses so, per tree coordinate.
template <class S>
VectorX TermsEngine<S>::inertial_forces(const VectorX& dy, const VectorX& ddy, bool weight) {
  const Tree<S>& tree = branch_.tree();
  State<S>& state = branch_.state();
  angular_velocities(tree, dy.data(), state);
  const typename S::Vector base = weight ? typename S::Vector(-gravity_) : typename S::Vector(S::Vector::Zero());
  accelerations<S>(tree, dy.data(), ddy.data(), base, state);
  for (auto& wrench : wrenches_) wrench = {};
  VectorX tau(columns_);
  inverse_dynamics(tree, state, wrenches_, tau.data());
  return tau;
}

template <class S>
VectorX TermsEngine<S>::external_forces(const ExternalForces<S>& forces, double time) {
  VectorX tau = VectorX::Zero(columns_);
  if (forces.none()) return tau;
  for (auto& wrench : wrenches_) wrench = {};
  Wrench<S> total, loads;
  forces.subtract(branch_.state(), time, wrenches_, total, loads);
  wrench_torques(branch_.tree(), branch_.state(), wrenches_, tau.data());
  forces.add_joint_springs(branch_.y(), tau.data());
  return tau;
}

template <class S>
RestTerms TermsEngine<S>::rest_terms(double time) {
  const VectorX rest = VectorX::Zero(columns_);
  return {inertial_forces(rest, rest, true), external_forces(springs_, time), external_forces(loads_, time)};
}

template <class S>
MatrixX TermsEngine<S>::mass_matrix() {
  const VectorX rest = VectorX::Zero(columns_);
  MatrixX mass(columns_, columns_);
  for (int c = 0; c < columns_; ++c) mass.col(c) = inertial_forces(rest, VectorX::Unit(columns_, c), false);
  return (mass + mass.transpose()) / 2;
}

template <class S>
MatrixX TermsEngine<S>::viscous_friction() const {
  MatrixX viscous = MatrixX::Zero(columns_, columns_);
  for (const Friction& friction : mechanism.friction) {
    VectorX rates = VectorX::Zero(columns_);
    branch_.tree().sources[static_cast<std::size_t>(friction.coordinate)].load(1, rates.data());
    viscous += friction.viscous * rates * rates.transpose();
  }
  return viscous;
}

template <class S>
MatrixX TermsEngine<S>::input() const {
  MatrixX out = MatrixX::Zero(columns_, static_cast<Eigen::Index>(mechanism.actuators.size()));
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a) {
    const auto coordinate = static_cast<std::size_t>(mechanism.actuators[a]);
    branch_.tree().sources[coordinate].load(1, out.col(static_cast<Eigen::Index>(a)).data());
  }
  return out;
}

/// A in SI: without the scales that make the entries comparable.
template <class S>
MatrixX TermsEngine<S>::constraints() {
  const Tree<S>& tree = branch_.tree();
  MatrixX A;
  closure_system_.rates(Eigen::Map<const VectorX>(branch_.y(), columns_), {}, A);
  const VectorX scale = column_scale(tree);
  A = A * scale.cwiseInverse().asDiagonal();
  Eigen::Index row = 0;
  for (const Closure<S>& closure : tree.closures)
    for (const ClosureRow& kind : closure.rows) A.row(row++) /= row_unit(tree, closure, kind);
  return A;
}

/// Tree accelerations that rates cause while the independent coordinates do not accelerate.
template <class S>
VectorX TermsEngine<S>::acceleration_at(const VectorX& rates, VectorX& dy) {
  const VectorX still = VectorX::Zero(freedoms_);
  branch_.set_rates(rates.data());
  branch_.set_accelerations(still.data());
  dy = Eigen::Map<const VectorX>(branch_.dy(), columns_);
  return Eigen::Map<const VectorX>(branch_.ddy(), columns_);
}

template <class S>
MotionOutcome TermsEngine<S>::independent_terms(const double* q, double time, IndependentTerms& out) {
  if (MotionOutcome outcome = go(q); outcome.status != MotionStatus::done) return outcome;
  const RestTerms rest = rest_terms(time);
  out.rest = {C_.transpose() * rest.weight, C_.transpose() * rest.springs, C_.transpose() * rest.loads};
  out.mass.resize(freedoms_, freedoms_);
  const VectorX still = VectorX::Zero(columns_);
  for (int k = 0; k < freedoms_; ++k) out.mass.col(k) = C_.transpose() * inertial_forces(still, C_.col(k), false);
  out.mass = (out.mass + out.mass.transpose().eval()) / 2;
  out.velocity = polarised(freedoms_, [&](const VectorX& rates) -> VectorX {
    VectorX dy;
    const VectorX ddy = acceleration_at(rates, dy);
    return C_.transpose() * inertial_forces(dy, ddy, false);
  });
  out.viscous = C_.transpose() * viscous_friction() * C_;
  out.input = C_.transpose() * input();
  bool finite = out.mass.allFinite() && out.rest.sum().allFinite() && out.viscous.allFinite();
  for (const MatrixX& form : out.velocity) finite = finite && form.allFinite();
  return finite_or(time, finite, "the equation of motion", mechanism);
}

template <class S>
std::vector<MatrixX> TermsEngine<S>::tree_velocity_terms() {
  const VectorX still = VectorX::Zero(columns_);
  return polarised(columns_, [&](const VectorX& dy) { return inertial_forces(dy, still, false); });
}

template <class S>
MotionOutcome TermsEngine<S>::redundant_terms(const double* q, double time, RedundantTerms& out) {
  if (MotionOutcome outcome = go(q); outcome.status != MotionStatus::done) return outcome;
  out.rest = rest_terms(time);
  out.mass = mass_matrix();
  out.velocity = tree_velocity_terms();
  out.viscous = viscous_friction();
  out.input = input();
  out.constraints = constraints();
  out.transformation = C_;
  out.acceleration = polarised(freedoms_, [&](const VectorX& rates) {
    VectorX dy;
    return acceleration_at(rates, dy);
  });
  if (freedoms_ == 0) out.acceleration.assign(static_cast<std::size_t>(columns_), MatrixX(0, 0));
  bool finite = out.mass.allFinite() && out.rest.sum().allFinite() && out.constraints.allFinite();
  for (const MatrixX& form : out.velocity) finite = finite && form.allFinite();
  return finite_or(time, finite, "the equation of motion", mechanism);
}

/// Efforts per unit of the tree's generalised forces.
template <class S>
MotionOutcome TermsEngine<S>::projection(double time, MatrixX& matrix) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (!actuation_.mismatch().empty()) return {MotionStatus::mismatch, time, actuation_.mismatch(), {}};
  if (!actuation_.project(branch_.equations(), matrix))
    return {MotionStatus::actuation_singularity,
            time,
            "actuation singularity: the actuators do not hold the mechanism there; configuration: " +
                configuration_text(mechanism, branch_.tree(), branch_.y()),
            {}};
  return outcome;
}

template <class S>
MotionOutcome TermsEngine<S>::split(const double* q, const double* dq, const double* ddq, double time,
                                    EffortSplit& out) {
  if (MotionOutcome outcome = go(q); outcome.status != MotionStatus::done) return outcome;
  MatrixX P;
  if (MotionOutcome outcome = projection(time, P); outcome.status != MotionStatus::done) return outcome;
  const Eigen::Map<const VectorX> rates(dq, freedoms_), accelerations(ddq, freedoms_);
  const VectorX still = VectorX::Zero(columns_);
  VectorX dy, friction = still;
  const VectorX c = acceleration_at(rates, dy), C_ddq = C_ * accelerations;
  if (!mechanism.friction.empty())
    add_friction(mechanism, branch_.tree(), dy.data(), options.time_scale, friction.data());
  const RestTerms rest = rest_terms(time);
  MatrixX tau(columns_, static_cast<Eigen::Index>(effort_part_names.size()));
  tau << inertial_forces(still, C_ddq, false), inertial_forces(dy, c, false), friction, rest.weight, rest.springs,
      rest.loads;
  out.parts = P * tau;
  // all at once, by the loops' multipliers
  const VectorX all = inertial_forces(dy, C_ddq + c, true) + friction + rest.springs + rest.loads;
  actuation_.solve(branch_.equations(), all.data());
  out.effort =
      Eigen::Map<const VectorX>(actuation_.efforts().data(), static_cast<Eigen::Index>(actuation_.efforts().size()));
  return finite_or(time, out.parts.allFinite() && out.effort.allFinite(), "torque", mechanism);
}

template class TermsEngine<Planar>;
template class TermsEngine<Spatial>;

}  // namespace balance
