#include "balance/conditions/rows.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/kinematics/closure.hpp"
#include "balance/motion/plan.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// What a parameter's unit is besides a power of the length, when forces are in kg times the acceleration.
double unit_of(ParameterOwner bearer, double acceleration, double length) {
  switch (bearer) {
    case ParameterOwner::spring: return acceleration / length;
    case ParameterOwner::load: return acceleration;
    default: return 1;  // velocity terms are measured at rates of 1/s
  }
}

/// Axes of the tool's body that the goal `affine` looks at: in the plane one tells where the other is.
template <class S>
constexpr int tool_axis_count = S::angular_dimension;

}  // namespace

NaturalUnits::NaturalUnits(const Mechanism& mechanism, const std::vector<Parameter>& parameters)
    : length(characteristic_length(mechanism)), mass(total_mass(mechanism)) {
  if (const double g = mechanism.gravity.norm(); g > 0) acceleration = g;
  parameter.resize(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    parameter[static_cast<Eigen::Index>(p)] =
        elementary::pow(length, parameters[p].length_power) * unit_of(parameters[p].owner_kind, acceleration, length);
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
      inertial_(S::inertial_parameter_count * static_cast<int>(tree.mass_elements.size())),
      scale_(column_scale(tree)),
      known_(mechanism, tree),
      state_(tree.nodes.size()) {
  mask_excluded_terms();
  if (has_goal(GoalKind::proportional)) extra_ += S::dimension * S::dimension;
  if (has_goal(GoalKind::affine)) extra_ += S::dimension * (S::dimension + S::dimension * tool_axis_count<S>);
  is_fully_ = std::any_of(goals_.begin(), goals_.end(), [](const Goal& goal) { return goal.is_fully; });
  needs_actuators_ = is_fully_ || has_goal(GoalKind::decoupled) || has_goal(GoalKind::gyroscopic_independent);
  check_goals(freedoms);
}

/// Known terms that are zero ask for nothing; others may be left out on purpose.
template <class S>
void GoalRows<S>::mask_excluded_terms() {
  term_mask_.setOnes(parameters_);
  const std::vector<Parameter> terms = list_terms(mechanism_, options_.loose_springs);
  const VectorX known = known_term_values(mechanism_);
  const Eigen::Index first = parameters_ - known.size();
  for (Eigen::Index p = 0; p < parameters_; ++p) {
    const Eigen::Index k = p - first;
    const bool open = k >= 0 && static_cast<std::size_t>(k) < options_.variable_terms.size() &&
                      options_.variable_terms[static_cast<std::size_t>(k)];
    if ((k >= 0 && known[k] == 0 && !open) ||
        is_excluded(mechanism_, terms[static_cast<std::size_t>(p)], options_.excluded))
      term_mask_[p] = 0;
  }
}

template <class S>
bool GoalRows<S>::has_goal(GoalKind kind) const {
  return std::any_of(goals_.begin(), goals_.end(), [&](const Goal& goal) { return goal.kind == kind; });
}

template <class S>
void GoalRows<S>::check_goals(int freedoms) {
  if (extra_ > 0) {
    if (!mechanism_.tool) {
      mismatch_ = std::string("the goal ") + (has_goal(GoalKind::affine) ? "affine" : "proportional") +
                  " compares the centre of mass with the tool, and the mechanism has none";
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
    const CoordinateId coordinate = mechanism_.actuators[static_cast<std::size_t>(a)];
    const LinearQuantity& source = tree_.coordinate_expressions[static_cast<std::size_t>(coordinate)];
    for (const auto& [column, ratio] : source.terms)
      selection_(a, column) = ratio * scale_[column] / (source.is_length ? tree_.characteristic_length : 1);
  }
}

template <class S>
bool GoalRows<S>::evaluate(const SampledConfiguration& configuration, const VelocityProbe& probe, MatrixX& rows) {
  rows.resize(0, parameters_ + extra_);
  out_.resize(0, parameters_ + extra_);
  filled_ = 0;
  y_ = configuration.y;
  compute_poses(tree_, y_.data(), state_);
  if (needs_actuators_ && !set_actuated(configuration.null_space)) return false;
  add_efforts(probe);
  add_inertia();
  add_momentum(probe);
  rows = out_.topRows(filled_);
  return true;
}

template <class S>
void GoalRows<S>::set_motion(const VectorX& velocity, const VectorX& acceleration, bool weight) {
  const VectorX dy = scale_.cwiseProduct(velocity), ddy = scale_.cwiseProduct(acceleration);
  compute_angular_velocities(tree_, dy.data(), state_);
  const typename S::Vector base =
      weight ? typename S::Vector(-to_vector<S>(mechanism_.gravity)) : typename S::Vector(S::Vector::Zero());
  compute_accelerations(tree_, dy.data(), ddy.data(), base, state_);
}

template <class S>
InertiaRegressor<S> GoalRows<S>::compute_regressor(const VectorX& velocity, const VectorX& acceleration, bool weight) {
  set_motion(velocity, acceleration, weight);
  return balance::compute_regressor(tree_, state_);
}

/// Appends rows per unit of the inertial parameters, or of all parameters and extra unknowns, in natural units.
template <class S>
void GoalRows<S>::append_rows(const MatrixX& rows, double unit) {
  const Eigen::Index count = rows.rows(), width = std::min<Eigen::Index>(rows.cols(), parameters_);
  if (filled_ + count > out_.rows())
    out_.conservativeResize(std::max(2 * out_.rows(), filled_ + count), Eigen::NoChange);
  auto place = out_.middleRows(filled_, count);
  place.setZero();
  place.leftCols(width) =
      rows.leftCols(width) * (units_.parameter.head(width).cwiseProduct(term_mask_.head(width)) / unit).asDiagonal();
  if (rows.cols() > parameters_) place.rightCols(extra_) = rows.rightCols(extra_) / unit;
  filled_ += count;
}

/// Weight, springs and loads. What loads change by over time must vanish by itself.
template <class S>
void GoalRows<S>::add_static_efforts(const MatrixX& projection) {
  const bool weight = mechanism_.gravity.norm() > 0, springs = !mechanism_.springs.empty();
  if (!weight && !springs && !known_.has_loads()) return;
  const VectorX rest = VectorX::Zero(tree_.columns);
  MatrixX torque = MatrixX::Zero(tree_.columns, parameters_), constant, changing;
  if (weight) torque.leftCols(inertial_) = compute_regressor(rest, rest, true).torque;
  if (springs) torque.middleCols(inertial_, parameters_ - inertial_ - known_.size()) = spring_torques();
  if (known_.has_loads()) {
    known_.load_columns(state_, constant, changing);
    torque.rightCols(known_.size()) = constant;
  }
  append_rows(projection * torque, units_.acceleration * units_.length);
  if (known_.has_loads() && known_.has_changes())
    append_known_rows(projection, changing, units_.acceleration * units_.length);
}

/// Rows of known terms alone, if any of them is asked for.
template <class S>
void GoalRows<S>::append_known_rows(const MatrixX& projection, const MatrixX& torque, double unit) {
  if (term_mask_.tail(known_.size()).isZero(0)) return;
  MatrixX rows = MatrixX::Zero(projection.rows(), parameters_);
  rows.rightCols(known_.size()) = projection * torque;
  append_rows(rows, unit);
}

/// static, gyroscopic, gyroscopic-independent: generalised forces projected on the allowed velocities.
template <class S>
void GoalRows<S>::add_efforts(const VelocityProbe& probe) {
  const bool gyroscopic = has_goal(GoalKind::gyroscopic) || has_goal(GoalKind::decoupled);
  const bool independent = has_goal(GoalKind::gyroscopic_independent);
  if (!gyroscopic && !independent && !has_goal(GoalKind::statics)) return;
  const VectorX rest = VectorX::Zero(tree_.columns);
  const MatrixX project = probe.directions.transpose() * scale_.asDiagonal();
  const double L = units_.length;
  add_static_efforts(project);
  // odd in the velocities, where those of masses are even: neither can make up for the other
  if ((gyroscopic || independent) && known_.has_friction())
    append_known_rows(project, known_.friction_columns(scale_.cwiseProduct(probe.velocity)), L * L);
  if (gyroscopic) append_rows(project * compute_regressor(probe.velocity, rest, false).torque, L * L);
  if (independent)
    append_rows(project * compute_regressor(probe.velocity, actuated_bias(probe.velocity), false).torque, L * L);
}

/// decoupled: what one actuator's acceleration asks of another; fully-: changes of the inertia that the actuators feel.
template <class S>
void GoalRows<S>::add_inertia() {
  const bool decoupled = has_goal(GoalKind::decoupled);
  if (!decoupled && !is_fully_) return;
  const VectorX rest = VectorX::Zero(tree_.columns);
  const Eigen::Index n = actuated_.cols();
  MatrixX apparent(n * (n + 1) / 2, inertial_), coupling(n * (n - 1) / 2, inertial_);
  Eigen::Index f = 0, c = 0;
  for (Eigen::Index s = 0; s < n; ++s) {
    const MatrixX column =
        actuated_.transpose() * scale_.asDiagonal() * compute_regressor(rest, actuated_.col(s), false).torque;
    for (Eigen::Index r = 0; r <= s; ++r) {
      apparent.row(f++) = column.row(r);
      if (r < s) coupling.row(c++) = column.row(r) / (actuated_.col(r).norm() * actuated_.col(s).norm());
    }
  }
  const double unit = units_.length * units_.length;
  if (decoupled && n > 1) append_rows(coupling, unit);
  if (!is_fully_) return;
  if (inertia_reference_.size() == 0) inertia_reference_ = apparent;
  append_rows(apparent - inertia_reference_, unit);
}

/// force, moment, dynamic, proportional, affine: momenta per unit of the allowed velocities.
template <class S>
void GoalRows<S>::add_momentum(const VelocityProbe& probe) {
  const bool both = has_goal(GoalKind::dynamic), following = extra_ > 0;
  const bool linear = both || has_goal(GoalKind::force), angular = both || has_goal(GoalKind::moment);
  if (!linear && !angular && !following) return;
  const VectorX rest = VectorX::Zero(tree_.columns);
  const double L = units_.length;
  const Vector3 about = options_.about;
  for (Eigen::Index k = 0; k < probe.directions.cols(); ++k) {
    set_motion(rest, probe.directions.col(k), false);
    const InertiaRegressor<S> momentum = compute_momentum_rate_regressor(tree_, state_);
    if (linear) append_rows(momentum.force, L);
    if (angular) {
      MatrixX rows = momentum.moment;
      if constexpr (S::angular_dimension == 1)
        rows -= about.x() * momentum.force.row(1) - about.y() * momentum.force.row(0);
      else
        for (Eigen::Index p = 0; p < rows.cols(); ++p) rows.col(p) -= about.cross(Vector3(momentum.force.col(p)));
      append_rows(rows, L * L);
    }
    if (following) append_com_tool_rows(momentum.force);
  }
}

/// proportional: momentum − A · tool velocity; affine: less B · the rates of the tool body's axes, too. The state has the
/// velocities as accelerations from rest.
template <class S>
void GoalRows<S>::append_com_tool_rows(const MatrixX& momentum) {
  constexpr int d = S::dimension;
  const NodeState<S>& node = state_[static_cast<std::size_t>(tool_.node)];
  const typename S::Vector tool = point_acceleration<S>(node, tool_.p_N);
  const typename S::Angular spin = node.R_WN * node.angular_acceleration;
  const typename S::Rotation R = node.R_WN * tool_.R_N;
  Eigen::Index first = parameters_;
  for (const GoalKind kind : {GoalKind::proportional, GoalKind::affine}) {
    if (!has_goal(kind)) continue;
    VectorX rates(d + (kind == GoalKind::affine ? d * tool_axis_count<S> : 0));
    rates.head(d) = tool;
    for (int k = 0; d * (k + 1) < rates.size(); ++k)
      rates.segment(d * (k + 1), d) = units_.length * typename S::Vector(cross(spin, typename S::Vector(axis(R, k))));
    MatrixX rows = MatrixX::Zero(d, parameters_ + extra_);
    rows.leftCols(inertial_) = momentum;
    for (int i = 0; i < d; ++i, first += rates.size()) rows.row(i).segment(first, rates.size()) = -rates.transpose();
    append_rows(rows, units_.length);
  }
}

template class GoalRows<Planar>;
template class GoalRows<Spatial>;

}  // namespace balance
