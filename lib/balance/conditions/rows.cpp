#include "balance/conditions/rows.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/kinematics/closure.hpp"
#include "balance/motion/plan.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// Smallest singular value of the actuated rows of the null space: below it C is large and the rows are ill-conditioned.
constexpr double well_held = 0.02;

bool is_inertial(const Parameter& parameter) { return parameter.bearer != Bearer::spring; }

}  // namespace

NaturalUnits::NaturalUnits(const Mechanism& mechanism, const std::vector<Parameter>& parameters)
    : length(characteristic_length(mechanism)), mass(total_mass(mechanism)) {
  if (const double g = mechanism.gravity.norm(); g > 0) acceleration = g;
  parameter.resize(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    parameter[static_cast<Eigen::Index>(p)] =
        std::pow(length, parameters[p].length_power) * (is_inertial(parameters[p]) ? 1 : acceleration / length);
}

template <class S>
GoalRows<S>::GoalRows(const Mechanism& mechanism, const Tree<S>& tree, const NaturalUnits& units,
                      std::vector<Goal> goals, const ConditionOptions& options, int freedoms)
    : mechanism_(mechanism),
      tree_(tree),
      units_(units),
      goals_(std::move(goals)),
      options_(options),
      parameters_(static_cast<int>(units.parameter.size())),
      inertial_(S::parameters * static_cast<int>(tree.elements.size())),
      scale_(column_scale(tree)),
      state_(tree.nodes.size()) {
  if (wants(GoalKind::proportional)) extra_ = S::dimension * S::dimension;
  fully_ = std::any_of(goals_.begin(), goals_.end(), [](const Goal& goal) { return goal.fully; });
  needs_actuators_ = fully_ || wants(GoalKind::decoupled) || wants(GoalKind::gyroscopic_independent);
  check(freedoms);
}

template <class S>
bool GoalRows<S>::wants(GoalKind kind) const {
  return std::any_of(goals_.begin(), goals_.end(), [&](const Goal& goal) { return goal.kind == kind; });
}

template <class S>
void GoalRows<S>::check(int freedoms) {
  if (extra_ > 0) {
    if (!mechanism_.tool) {
      mismatch_ = "the goal proportional compares the centre of mass with the tool, and the mechanism has none";
      return;
    }
    const FixedFrame<S>& body = tree_.bodies[static_cast<std::size_t>(mechanism_.tool->body)];
    tool_ = {body.node, body.R_N, body.p_N + body.R_N * to_vector<S>(mechanism_.tool->position)};
  }
  if (!needs_actuators_) return;
  const auto count = static_cast<int>(mechanism_.actuators.size());
  if (count != freedoms) {
    mismatch_ =
        "the goal speaks of the actuators' accelerations and asks for one actuator per degree of freedom: there are " +
        std::to_string(count) + " actuators and " + std::to_string(freedoms) + " degrees of freedom";
    return;
  }
  selection_ = MatrixX::Zero(count, tree_.columns);
  for (int a = 0; a < count; ++a) {
    const int coordinate = mechanism_.actuators[static_cast<std::size_t>(a)];
    const CoordinateSource& source = tree_.sources[static_cast<std::size_t>(coordinate)];
    const bool length = mechanism_.coordinates[static_cast<std::size_t>(coordinate)].kind == CoordinateKind::length;
    selection_(a, source.column) = source.ratio * scale_[source.column] / (length ? tree_.length : 1);
  }
}

template <class S>
bool GoalRows<S>::at(const Configuration& configuration, const Probe& probe, MatrixX& rows) {
  rows.resize(0, parameters_ + extra_);
  out_.resize(0, parameters_ + extra_);
  filled_ = 0;
  y_ = configuration.y;
  poses(tree_, y_.data(), state_);
  if (needs_actuators_ && !set_actuated(configuration.null_space)) return false;
  add_efforts(probe);
  add_inertia();
  add_momentum(probe);
  rows = out_.topRows(filled_);
  return true;
}

/// C = N (S N)⁻¹: its actuated rows are the identity.
template <class S>
bool GoalRows<S>::set_actuated(const MatrixX& null_space) {
  const MatrixX held = selection_ * null_space;
  const Eigen::JacobiSVD<MatrixX> svd(held);
  if (svd.singularValues().tail(1)[0] < well_held) return false;
  actuated_ = null_space * held.partialPivLu().inverse();
  return true;
}

template <class S>
Regressor<S> GoalRows<S>::regress(const VectorX& velocity, const VectorX& acceleration, bool weight) {
  const VectorX dy = scale_.cwiseProduct(velocity), ddy = scale_.cwiseProduct(acceleration);
  angular_velocities(tree_, dy.data(), state_);
  const typename S::Vector base =
      weight ? typename S::Vector(-to_vector<S>(mechanism_.gravity)) : typename S::Vector(S::Vector::Zero());
  accelerations(tree_, dy.data(), ddy.data(), base, state_);
  return regressor(tree_, state_);
}

/// Appends rows per unit of the inertial parameters, or of all parameters and extra unknowns, in natural units.
template <class S>
void GoalRows<S>::add(const MatrixX& rows, double unit) {
  const Eigen::Index count = rows.rows(), width = std::min<Eigen::Index>(rows.cols(), parameters_);
  out_.conservativeResize(filled_ + count, Eigen::NoChange);
  auto place = out_.middleRows(filled_, count);
  place.setZero();
  place.leftCols(width) = rows.leftCols(width) * units_.parameter.head(width).asDiagonal() / unit;
  if (rows.cols() > parameters_) place.rightCols(extra_) = rows.rightCols(extra_) / unit;
  filled_ += count;
}

/// static, gyroscopic, gyroscopic-independent: generalised forces projected on the allowed velocities.
template <class S>
void GoalRows<S>::add_efforts(const Probe& probe) {
  const bool gyroscopic = wants(GoalKind::gyroscopic) || wants(GoalKind::decoupled);
  const bool independent = wants(GoalKind::gyroscopic_independent);
  if (!gyroscopic && !independent && !wants(GoalKind::statics)) return;
  const VectorX rest = VectorX::Zero(tree_.columns);
  const MatrixX project = probe.directions.transpose() * scale_.asDiagonal();
  const double L = units_.length;
  const bool weight = mechanism_.gravity.norm() > 0;
  if (weight || !mechanism_.springs.empty()) {
    MatrixX torque = MatrixX::Zero(tree_.columns, parameters_);
    if (weight) torque.leftCols(inertial_) = regress(rest, rest, true).torque;
    if (!mechanism_.springs.empty()) torque.rightCols(parameters_ - inertial_) = spring_torques();
    add(project * torque, units_.acceleration * L);
  }
  if (gyroscopic) add(project * regress(probe.velocity, rest, false).torque, L * L);
  if (independent) add(project * regress(probe.velocity, actuated_bias(probe.velocity), false).torque, L * L);
}

/// The accelerations that a velocity causes while the actuators' own are zero.
template <class S>
VectorX GoalRows<S>::actuated_bias(const VectorX& velocity) {
  const VectorX dy = scale_.cwiseProduct(velocity);
  velocities(tree_, dy.data(), state_);
  accelerations<S>(tree_, dy.data(), nullptr, S::Vector::Zero(), state_);
  const Eigen::Index closures = tree_.closure_rows, actuated = selection_.rows();
  VectorX bias = VectorX::Zero(closures + actuated), residual;
  System<S> system(tree_, Drive<S>{});
  MatrixX jacobian;
  system.evaluate(y_, {}, residual, jacobian);
  double* next = bias.data();
  for (const Closure<S>& closure : tree_.closures) {
    closure_bias(state_, closure, closure_pose(state_, closure), next);
    for (const ClosureRow& row : closure.rows) *next++ *= row.kind == ClosureRow::Kind::along ? -1 / tree_.length : -1;
  }
  MatrixX all(closures + actuated, tree_.columns);
  all << jacobian, selection_;
  Eigen::CompleteOrthogonalDecomposition<MatrixX> qr;
  qr.setThreshold(1e-9);  // redundant closures have rows of round-off
  return qr.compute(all).solve(bias);
}

/// decoupled: what one actuator's acceleration asks of another; fully-: changes of the inertia that the actuators feel.
template <class S>
void GoalRows<S>::add_inertia() {
  const bool decoupled = wants(GoalKind::decoupled);
  if (!decoupled && !fully_) return;
  const VectorX rest = VectorX::Zero(tree_.columns);
  const Eigen::Index n = actuated_.cols();
  MatrixX felt(n * (n + 1) / 2, inertial_), coupling(n * (n - 1) / 2, inertial_);
  Eigen::Index f = 0, c = 0;
  for (Eigen::Index s = 0; s < n; ++s) {
    const MatrixX column = actuated_.transpose() * scale_.asDiagonal() * regress(rest, actuated_.col(s), false).torque;
    for (Eigen::Index r = 0; r <= s; ++r) {
      felt.row(f++) = column.row(r);
      if (r < s) coupling.row(c++) = column.row(r) / (actuated_.col(r).norm() * actuated_.col(s).norm());
    }
  }
  const double unit = units_.length * units_.length;
  if (decoupled && n > 1) add(coupling, unit);
  if (!fully_) return;
  if (inertia_reference_.size() == 0) inertia_reference_ = felt;
  add(felt - inertia_reference_, unit);
}

/// force, moment, dynamic, proportional: momenta per unit of the allowed velocities.
template <class S>
void GoalRows<S>::add_momentum(const Probe& probe) {
  const bool both = wants(GoalKind::dynamic), proportional = extra_ > 0;
  const bool linear = both || wants(GoalKind::force), angular = both || wants(GoalKind::moment);
  if (!linear && !angular && !proportional) return;
  const VectorX rest = VectorX::Zero(tree_.columns);
  const double L = units_.length;
  const Vector3 about = options_.about;
  for (Eigen::Index k = 0; k < probe.directions.cols(); ++k) {
    const Regressor<S> momentum = regress(rest, probe.directions.col(k), false);
    if (linear) add(momentum.force, L);
    if (angular) {
      MatrixX rows = momentum.moment;
      if constexpr (S::angular == 1)
        rows -= about.x() * momentum.force.row(1) - about.y() * momentum.force.row(0);
      else
        for (Eigen::Index p = 0; p < rows.cols(); ++p) rows.col(p) -= about.cross(Vector3(momentum.force.col(p)));
      add(rows, L * L);
    }
    if (!proportional) continue;
    const typename S::Vector tool = point_acceleration<S>(state_[static_cast<std::size_t>(tool_.node)], tool_.p_N);
    MatrixX rows = MatrixX::Zero(S::dimension, parameters_ + extra_);
    rows.leftCols(inertial_) = momentum.force;
    for (int i = 0; i < S::dimension; ++i)
      for (int j = 0; j < S::dimension; ++j) rows(i, parameters_ + i * S::dimension + j) = -tool[j];
    add(rows, L);
  }
}

/// Generalised forces that hold the springs, per unit of each of their parameters: ∂U/∂y with U linear in k, k a, k b, k a bᵀ.
template <class S>
MatrixX GoalRows<S>::spring_torques() {
  MatrixX torque = MatrixX::Zero(tree_.columns, parameters_ - inertial_);
  VectorX unit = VectorX::Zero(tree_.columns);
  for (int c = 0; c < tree_.columns; ++c) {
    unit.setZero();
    unit[c] = 1;
    velocities(tree_, unit.data(), state_);
    Eigen::Index at = 0;
    for (std::size_t s = 0; s < mechanism_.springs.size(); ++s) {
      const Spring& spring = mechanism_.springs[s];
      const FixedFrame<S>&A = tree_.bodies[static_cast<std::size_t>(spring.first)],
            &B = tree_.bodies[static_cast<std::size_t>(spring.second)];
      const NodeState<S>&a = state_[static_cast<std::size_t>(A.node)], &b = state_[static_cast<std::size_t>(B.node)];
      const bool loose = s < options_.loose_springs.size() && options_.loose_springs[s];
      const typename S::Vector end_a = loose ? typename S::Vector(S::Vector::Zero()) : to_vector<S>(spring.point_first);
      const typename S::Vector end_b =
          loose ? typename S::Vector(S::Vector::Zero()) : to_vector<S>(spring.point_second);
      const typename S::Vector p_A = A.p_N + A.R_N * end_a, p_B = B.p_N + B.R_N * end_b;
      const typename S::Vector d = position(state_, {A.node, A.R_N, p_A}) - position(state_, {B.node, B.R_N, p_B});
      const typename S::Vector rate = point_velocity<S>(a, p_A) - point_velocity<S>(b, p_B);
      const double length = d.norm();
      const bool taut = loose || spring.free_length == 0;
      torque(c, at++) = d.dot(rate) * (taut ? 1 : length > 0 ? 1 - spring.free_length / length : 0);
      if (!loose) continue;
      const typename S::Rotation R_A = a.R_WN * A.R_N, R_B = b.R_WN * B.R_N;
      const typename S::Angular w_A = a.R_WN * a.angular_velocity, w_B = b.R_WN * b.angular_velocity;
      const auto turned_rate = [](const typename S::Angular& w, const typename S::Vector& e) {
        return typename S::Vector(cross(w, e));
      };
      for (int i = 0; i < S::dimension; ++i)
        torque(c, at++) = rate.dot(axis(R_A, i)) + d.dot(turned_rate(w_A, axis(R_A, i)));
      for (int j = 0; j < S::dimension; ++j)
        torque(c, at++) = -rate.dot(axis(R_B, j)) - d.dot(turned_rate(w_B, axis(R_B, j)));
      for (int i = 0; i < S::dimension; ++i)
        for (int j = 0; j < S::dimension; ++j)
          torque(c, at++) =
              -turned_rate(w_A, axis(R_A, i)).dot(axis(R_B, j)) - axis(R_A, i).dot(turned_rate(w_B, axis(R_B, j)));
    }
  }
  return torque;
}

template class GoalRows<Planar>;
template class GoalRows<Spatial>;

}  // namespace balance
