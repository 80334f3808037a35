#include "balance/synthesis/conditions/goal_rows.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/dynamics/speed_probe.hpp"
#include "balance/mechanics/kinematics/closure.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/model/landmark.hpp"
#include "balance/mechanics/model/speed_units.hpp"

#include <algorithm>
#include <cmath>

namespace balance::conditions {

namespace {

/// Components of a load: force, then moment.
template <class S>
constexpr int load_components = S::dimension + S::angular_dimension;

}  // namespace

template <class S>
KnownTermColumns<S>::KnownTermColumns(const Mechanism& mechanism, const kinematics::Tree<S>& tree)
    : mechanism_(mechanism),
      tree_(tree),
      terms_(list_known_terms(mechanism)),
      tables_(mechanism.loads.begin(), mechanism.loads.end()) {
  if (const MatrixX changes = load_changes(mechanism, tree.characteristic_length); !changes.isZero(0))
    changes_ = changes;
  for (const ForceElement& element : mechanism.force_elements) {
    (element.is_damper() ? has_dampers_ : has_tables_) = true;
    laws_.push_back(element.is_damper() ? model::ForceLawOf<double>() : model::ForceLawOf<double>(element.table));
  }
}

/// Generalised forces that balance each unit component of each load: minus its power at unit rates of the coordinates.
template <class S>
MatrixX KnownTermColumns<S>::load_torques(kinematics::TreeState<S>& state) const {
  constexpr int size = load_components<S>;
  MatrixX torque(tree_.columns, size * static_cast<Eigen::Index>(mechanism_.loads.size()));
  VectorX unit = VectorX::Zero(tree_.columns);
  for (int c = 0; c < tree_.columns; ++c) {
    unit.setZero();
    unit[c] = 1;
    compute_velocities(tree_, unit.data(), state);
    Eigen::Index column = 0;
    for (const Load& load : mechanism_.loads) {
      const kinematics::FixedFrame<S>& body = tree_.bodies[static_cast<std::size_t>(load.body)];
      const kinematics::NodeState<S>& node = state[static_cast<std::size_t>(body.node)];
      typename S::Vector rate = kinematics::point_velocity<S>(
          node, typename S::Vector(body.p_N + body.R_N * kinematics::to_vector<S>(load.point)));
      typename S::Angular angular_rate = node.R_WN * node.angular_velocity;
      if (load.frame == model::Frame::body) {
        const typename S::Rotation R = node.R_WN * body.R_N;
        rate = rotate_inverse(R, rate);
        angular_rate = rotate_inverse(R, angular_rate);
      }
      for (int i = 0; i < S::dimension; ++i) torque(c, column++) = -rate[i];
      const Vector3 spin = kinematics::angular_to_3d(angular_rate);
      for (int i = 0; i < S::angular_dimension; ++i) torque(c, column++) = -spin[S::angular_dimension == 1 ? 2 : i];
    }
  }
  return torque;
}

template <class S>
kinematics::FixedFrame<S> place_point(const kinematics::Tree<S>& tree, BodyId body, const Vector3& point) {
  const kinematics::FixedFrame<S>& frame = tree.bodies[static_cast<std::size_t>(body)];
  return {frame.node, frame.R_N, frame.p_N + frame.R_N * kinematics::to_vector<S>(point)};
}

/// Derivatives of the length or the coordinate of every force element (columns) by the tree's coordinates; zero at a
/// length of zero, which has no direction.
template <class S>
MatrixX KnownTermColumns<S>::displacement_gradients(kinematics::TreeState<S>& state) const {
  MatrixX gradients = MatrixX::Zero(tree_.columns, static_cast<Eigen::Index>(mechanism_.force_elements.size()));
  for (int c = 0; c < tree_.columns; ++c) {
    const VectorX unit = VectorX::Unit(tree_.columns, c);
    compute_velocities(tree_, unit.data(), state);
    for (std::size_t e = 0; e < mechanism_.force_elements.size(); ++e) {
      const ForceElement& element = mechanism_.force_elements[e];
      double& gradient = gradients(c, static_cast<Eigen::Index>(e));
      if (element.is_in_joint()) {
        gradient = tree_.coordinate_expressions[static_cast<std::size_t>(element.coordinate)].rate(unit.data());
        continue;
      }
      const auto first = place_point(tree_, element.first, element.point_first),
                 second = place_point(tree_, element.second, element.point_second);
      const auto velocity = [&](const kinematics::FixedFrame<S>& frame) {
        return kinematics::point_velocity<S>(state[static_cast<std::size_t>(frame.node)], frame.p_N);
      };
      const typename S::Vector d = kinematics::position(state, second) - kinematics::position(state, first);
      if (const double length = d.norm(); length > 0) gradient = d.dot(velocity(second) - velocity(first)) / length;
    }
  }
  return gradients;
}

/// The force that the element's table resists with, at poses and coordinates.
template <class S>
double KnownTermColumns<S>::table_force(std::size_t index, const VectorX& y,
                                        const kinematics::TreeState<S>& state) const {
  const ForceElement& element = mechanism_.force_elements[index];
  const model::ForceLawOf<double>& law = laws_[index];
  if (element.is_in_joint())
    return -law.force(tree_.coordinate_expressions[static_cast<std::size_t>(element.coordinate)].value(y.data()));
  return law.force((kinematics::position(state, place_point(tree_, element.second, element.point_second)) -
                    kinematics::position(state, place_point(tree_, element.first, element.point_first)))
                       .norm());
}

template <class S>
void KnownTermColumns<S>::static_columns(const VectorX& y, kinematics::TreeState<S>& state, MatrixX& constant,
                                         MatrixX& changing) const {
  constant.setZero(tree_.columns, this->size());
  changing.setZero(tree_.columns, has_changes() ? this->size() : 0);
  const MatrixX torque = load_torques(state);
  const MatrixX coupled = has_changes() ? MatrixX(torque * changes_) : MatrixX();
  const MatrixX gradients = has_tables_ ? displacement_gradients(state) : MatrixX();
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const dynamics::Parameter& term = terms_[t];
    const auto column = static_cast<Eigen::Index>(t);
    if (term.kind == dynamics::ParameterKind::tabulated) {
      const auto index = static_cast<std::size_t>(term.index);
      if (const double largest = laws_[index].max_force(); largest > 0)
        constant.col(column) = gradients.col(term.index) * (table_force(index, y, state) / largest);
    }
    if (term.owner_kind != dynamics::ParameterOwner::load) continue;
    const Eigen::Index component = load_component(term, S::dimension == 2);
    const Load& load = mechanism_.loads[static_cast<std::size_t>(term.index)];
    if (load.is_over_coordinate()) {
      const double q = tree_.coordinate_expressions[static_cast<std::size_t>(load.coordinate)].value(y.data());
      constant.col(column) = relative_load(tables_[static_cast<std::size_t>(term.index)], term, q, S::dimension == 2) *
                             torque.col(component);
    } else if (!is_load_change(term)) {
      constant.col(column) = torque.col(component);
    }
    if (is_load_change(term) && has_changes()) changing.col(column) = coupled.col(component);
  }
}

template <class S>
MatrixX KnownTermColumns<S>::friction_columns(const VectorX& dy, kinematics::TreeState<S>& state) const {
  MatrixX torque = MatrixX::Zero(tree_.columns, size());
  const MatrixX gradients = has_dampers_ ? displacement_gradients(state) : MatrixX();
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const dynamics::Parameter& term = terms_[t];
    if (term.owner_kind == dynamics::ParameterOwner::force_element && term.kind == dynamics::ParameterKind::viscous)
      torque.col(static_cast<Eigen::Index>(t)) = gradients.col(term.index) * gradients.col(term.index).dot(dy);
    if (term.owner_kind != dynamics::ParameterOwner::friction) continue;
    const Friction& friction = mechanism_.friction[static_cast<std::size_t>(term.index)];
    const kinematics::LinearQuantity& source =
        tree_.coordinate_expressions[static_cast<std::size_t>(friction.coordinate)];
    source.add_generalised_force(friction_resistance(term, source.rate(dy.data())),
                                 torque.col(static_cast<Eigen::Index>(t)).data());
  }
  return torque;
}

template class KnownTermColumns<kinematics::Planar>;
template class KnownTermColumns<kinematics::Spatial>;

namespace {

/// A parameter's unit without its power of length, for forces in kg times the acceleration.
double parameter_unit_without_length(const dynamics::Parameter& parameter, double acceleration, double length) {
  if (parameter.kind == dynamics::ParameterKind::tabulated) return acceleration;
  switch (parameter.owner_kind) {
    case dynamics::ParameterOwner::spring: return acceleration / length;
    case dynamics::ParameterOwner::load: return acceleration;
    default: return 1;  // velocity terms are measured at rates of 1/s
  }
}

/// Number of the tool body's axes in the goal `affine`: in the plane, one axis determines the other.
template <class S>
constexpr int tool_axis_count = S::angular_dimension;

}  // namespace

NaturalUnits::NaturalUnits(const Mechanism& mechanism, const std::vector<dynamics::Parameter>& parameters)
    : length(characteristic_length(mechanism)), mass(total_mass(mechanism)) {
  if (const double g = mechanism.gravity.norm(); g > 0) acceleration = g;
  parameter.resize(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    parameter[static_cast<Eigen::Index>(p)] = elementary::pow(length, parameters[p].length_power) *
                                              parameter_unit_without_length(parameters[p], acceleration, length);
}

void MomentumComponents::add(const Goal& goal) {
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const bool is_wanted = goal.component < 0 || goal.component == static_cast<int>(i);
    linear[i] = linear[i] || (is_wanted && goal.kind != GoalKind::moment);
    angular[i] = angular[i] || (is_wanted && goal.kind != GoalKind::force);
  }
}

template <class S>
GoalRows<S>::GoalRows(const Mechanism& mechanism, const kinematics::Tree<S>& tree, const NaturalUnits& units,
                      std::vector<Goal> goals, const ConditionOptions& options, int freedoms)
    : mechanism_(mechanism),
      tree_(tree),
      units_(units),
      goals_(std::move(goals)),
      options_(options),
      parameters_(static_cast<int>(units.parameter.size())),
      inertial_count_(S::inertial_parameter_count * static_cast<int>(tree.mass_elements.size())),
      scale_(column_scale(tree)),
      known_terms_(mechanism, tree),
      state_(tree.nodes.size()) {
  mask_excluded_terms();
  if (has_goal(GoalKind::proportional)) extra_count_ += S::dimension * S::dimension;
  if (has_goal(GoalKind::affine)) extra_count_ += S::dimension * (S::dimension + S::dimension * tool_axis_count<S>);
  is_fully_ = std::any_of(goals_.begin(), goals_.end(), [](const Goal& goal) { return goal.is_fully; });
  needs_actuators_ = is_fully_ || has_goal(GoalKind::decoupled) ||
                     (has_goal(GoalKind::gyroscopic_independent) && options_.speeds.empty());
  if (needs_actuators_ || has_goal(GoalKind::gyroscopic) || has_goal(GoalKind::gyroscopic_independent))
    speeds_ = options_.speeds.in(mechanism);
  speed_units_.resize(static_cast<Eigen::Index>(speeds_.size()));
  for (std::size_t k = 0; k < speeds_.size(); ++k)
    speed_units_[static_cast<Eigen::Index>(k)] =
        is_length_speed(mechanism, speeds_[k]) ? tree.characteristic_length : 1;
  check_goals(freedoms);
}

/// Known terms that are zero require nothing; others may be left out on purpose.
template <class S>
void GoalRows<S>::mask_excluded_terms() {
  term_mask_.setOnes(parameters_);
  const std::vector<dynamics::Parameter> terms = list_terms(mechanism_, options_.loose_springs);
  const VectorX known = known_term_values(mechanism_);
  const Eigen::Index first = parameters_ - known.size();
  for (Eigen::Index p = 0; p < parameters_; ++p) {
    const Eigen::Index k = p - first;
    const bool is_variable = k >= 0 && static_cast<std::size_t>(k) < options_.variable_terms.size() &&
                             options_.variable_terms[static_cast<std::size_t>(k)];
    if ((k >= 0 && known[k] == 0 && !is_variable) ||
        is_excluded(mechanism_, terms[static_cast<std::size_t>(p)], options_.excluded))
      term_mask_[p] = 0;
  }
}

template <class S>
bool GoalRows<S>::has_goal(GoalKind kind) const {
  return std::any_of(goals_.begin(), goals_.end(), [&](const Goal& goal) { return goal.kind == kind; });
}

/// Goals with the same reference point and the same coordinates at constant speed are evaluated together.
template <class S>
void GoalRows<S>::list_momentum_components() {
  for (const Goal& goal : goals_) {
    if (goal.kind != GoalKind::force && goal.kind != GoalKind::moment && goal.kind != GoalKind::dynamic) continue;
    const std::vector<CoordinateId> coordinates = study::list_constant_speed_coordinates(goal, mechanism_);
    const auto known = std::find_if(momentum_components_.begin(), momentum_components_.end(),
                                    [&](const MomentumComponents& components) {
                                      return components.is_at_constant_speed == goal.is_at_constant_speed &&
                                             components.coordinates == coordinates && components.about == goal.about;
                                    });
    if (known != momentum_components_.end()) {
      known->add(goal);
      continue;
    }
    MomentumComponents components{.is_at_constant_speed = goal.is_at_constant_speed,
                                  .coordinates = coordinates,
                                  .held_rows = coordinate_rows(coordinates),
                                  .about = goal.about};
    for (Eigen::Index row = 0; row < components.held_rows.rows(); ++row)
      components.held_rows.row(row).stableNormalize();
    components.add(goal);
    momentum_components_.push_back(std::move(components));
  }
}

/// Without actuators and loops, all coordinates are at constant speed.
template <class S>
void GoalRows<S>::check_constant_speeds(int freedoms) {
  for (MomentumComponents& components : momentum_components_) {
    if (!components.is_at_constant_speed) continue;
    if (components.coordinates.empty()) {
      if (freedoms != tree_.columns) {
        mismatch_ =
            "without actuators, a goal at constant speed of a mechanism with loops or constraints needs names of "
            "coordinates, as in constant-speed-force of " +
            (mechanism_.coordinates.empty() ? std::string("A") : mechanism_.coordinates.front().name);
        return;
      }
      components.held_rows = MatrixX::Identity(tree_.columns, tree_.columns);
    }
    const auto count = static_cast<int>(components.held_rows.rows());
    if (count <= freedoms) continue;
    mismatch_ = std::to_string(count) + " coordinates cannot all be at constant speed, because there " +
                (freedoms == 1 ? "is 1 degree" : "are " + std::to_string(freedoms) + " degrees") +
                " of freedom: the goal needs names of fewer, as in constant-speed-force of " +
                mechanism_.coordinates[static_cast<std::size_t>(components.coordinates.front())].name;
    return;
  }
}

/// Rates of coordinates per scaled rate of the tree's coordinates, in natural units.
template <class S>
MatrixX GoalRows<S>::coordinate_rows(const std::vector<CoordinateId>& coordinates) const {
  MatrixX rows = MatrixX::Zero(static_cast<Eigen::Index>(coordinates.size()), tree_.columns);
  Eigen::Index row = 0;
  for (const CoordinateId coordinate : coordinates) {
    const kinematics::LinearQuantity& source = tree_.coordinate_expressions[static_cast<std::size_t>(coordinate)];
    for (const auto& [column, ratio] : source.terms)
      rows(row, column) = ratio * scale_[column] / (source.is_length ? tree_.characteristic_length : 1);
    ++row;
  }
  return rows;
}

template <class S>
bool GoalRows<S>::has_constant_speeds() const {
  return std::any_of(momentum_components_.begin(), momentum_components_.end(),
                     [](const MomentumComponents& components) { return components.is_at_constant_speed; });
}

template <class S>
void GoalRows<S>::check_goals(int freedoms) {
  if (has_prescribed_speeds(mechanism_)) {
    mismatch_ =
        "a constraint on speeds has a value: balancing conditions are those of motions without such constraints";
    return;
  }
  if (!speeds_.empty()) {
    if (static_cast<int>(speeds_.size()) < freedoms)
      mismatch_ = "the speeds, " + std::to_string(speeds_.size()) + ", are fewer than the degrees of freedom, " +
                  std::to_string(freedoms);
    if (!mismatch_.empty()) return;
    dynamics::check_speeds(mechanism_, tree_, speeds_);
  }
  for (const Goal& goal : goals_)
    if (const std::optional<study::GoalMistake> mistake = study::find_goal_mistake(goal, mechanism_)) {
      mismatch_ = "the goal " + goal_name(goal) + ": " + mistake->sentence();
      return;
    }
  list_momentum_components();
  check_constant_speeds(freedoms);
  if (!mismatch_.empty()) return;
  if (extra_count_ > 0) {
    if (!mechanism_.tool) {
      mismatch_ = std::string("the goal ") + (has_goal(GoalKind::affine) ? "affine" : "proportional") +
                  " compares the centre of mass with the tool, but the mechanism has none";
      return;
    }
    const kinematics::FixedFrame<S>& body = tree_.bodies[static_cast<std::size_t>(mechanism_.tool->body)];
    tool_ = {body.node, body.R_N, body.p_N + body.R_N * kinematics::to_vector<S>(mechanism_.tool->position)};
  }
  if (!needs_actuators_) return;
  const auto count = static_cast<int>(mechanism_.actuators.size());
  if (count != freedoms) {
    mismatch_ = "the goal uses the actuators' accelerations and needs one actuator per degree of freedom: there are " +
                std::to_string(count) + " actuators and " + std::to_string(freedoms) + " degrees of freedom";
    return;
  }
  selection_ = coordinate_rows(mechanism_.actuators);
}

namespace {

/// Minimum singular value of rows for the actuators, or for coordinates at constant speed, on the admissible velocities:
/// below it, these are far from independent, and rows are ill-conditioned.
constexpr double min_actuator_regularity = 0.02;

/// Whether rates of coordinates can be chosen independently. @param rows unit vectors
bool are_independent(const MatrixX& rows, const MatrixX& null_space) {
  if (rows.rows() == 0) return true;
  const VectorX values = numerics::singular_values(rows * null_space);
  return values.size() == rows.rows() && values.tail(1)[0] > min_actuator_regularity;
}

}  // namespace

template <class S>
bool GoalRows<S>::evaluate(const SampledConfiguration& configuration, const VelocityProbe& probe, MatrixX& rows) {
  rows.resize(0, parameters_ + extra_count_);
  out_.resize(0, parameters_ + extra_count_);
  row_count_ = 0;
  y_ = configuration.y;
  compute_poses(tree_, y_.data(), state_);
  if (needs_actuators_ && !set_actuated(configuration.null_space)) return false;
  if (!speeds_.empty() && !set_speeds(configuration.null_space)) return false;
  for (const MomentumComponents& components : momentum_components_)
    if (components.is_at_constant_speed && !are_independent(components.held_rows, configuration.null_space))
      return false;
  add_efforts(probe);
  add_inertia();
  add_momentum(probe);
  add_momentum_rates(probe, configuration.null_space);
  rows = out_.topRows(row_count_);
  return true;
}

template <class S>
void GoalRows<S>::set_motion(const VectorX& velocity, const VectorX& acceleration, bool weight) {
  const VectorX dy = scale_.cwiseProduct(velocity), ddy = scale_.cwiseProduct(acceleration);
  compute_angular_velocities(tree_, dy.data(), state_);
  const typename S::Vector base = weight ? typename S::Vector(-kinematics::to_vector<S>(mechanism_.gravity))
                                         : typename S::Vector(S::Vector::Zero());
  compute_accelerations(tree_, dy.data(), ddy.data(), base, state_);
}

template <class S>
dynamics::InertiaRegressor<S> GoalRows<S>::compute_regressor(const VectorX& velocity, const VectorX& acceleration,
                                                             bool weight) {
  set_motion(velocity, acceleration, weight);
  return dynamics::compute_regressor(tree_, state_);
}

/// Appends rows per unit of the inertial parameters, or of all parameters and extra unknowns, in natural units.
template <class S>
void GoalRows<S>::append_rows(const MatrixX& rows, double unit) {
  const Eigen::Index count = rows.rows(), width = std::min<Eigen::Index>(rows.cols(), parameters_);
  if (row_count_ + count > out_.rows())
    out_.conservativeResize(std::max(2 * out_.rows(), row_count_ + count), Eigen::NoChange);
  auto block = out_.middleRows(row_count_, count);
  block.setZero();
  block.leftCols(width) =
      rows.leftCols(width) * (units_.parameter.head(width).cwiseProduct(term_mask_.head(width)) / unit).asDiagonal();
  if (rows.cols() > parameters_) block.rightCols(extra_count_) = rows.rightCols(extra_count_) / unit;
  row_count_ += count;
}

/// Weight, springs and loads. Changes of loads over time must vanish by themselves.
template <class S>
void GoalRows<S>::add_static_efforts(const MatrixX& projection) {
  const bool has_weight = mechanism_.gravity.norm() > 0, has_springs = !mechanism_.springs.empty();
  if (!has_weight && !has_springs && !known_terms_.has_static_terms()) return;
  const VectorX zero_rate = VectorX::Zero(tree_.columns);
  MatrixX torque = MatrixX::Zero(tree_.columns, parameters_), constant, changing;
  if (has_weight) torque.leftCols(inertial_count_) = compute_regressor(zero_rate, zero_rate, true).torque;
  if (has_springs)
    torque.middleCols(inertial_count_, parameters_ - inertial_count_ - known_terms_.size()) = spring_torques();
  if (known_terms_.has_static_terms()) {
    known_terms_.static_columns(y_, state_, constant, changing);
    torque.rightCols(known_terms_.size()) = constant;
  }
  append_rows(projection * torque, units_.acceleration * units_.length);
  if (known_terms_.has_static_terms() && known_terms_.has_changes())
    append_known_rows(projection, changing, units_.acceleration * units_.length);
}

/// Appends rows of known terms alone, unless all of these are masked.
template <class S>
void GoalRows<S>::append_known_rows(const MatrixX& projection, const MatrixX& torque, double unit) {
  if (term_mask_.tail(known_terms_.size()).isZero(0)) return;
  MatrixX rows = MatrixX::Zero(projection.rows(), parameters_);
  rows.rightCols(known_terms_.size()) = projection * torque;
  append_rows(rows, unit);
}

/// static, gyroscopic, gyroscopic-independent: generalised forces projected onto the admissible velocities.
template <class S>
void GoalRows<S>::add_efforts(const VelocityProbe& probe) {
  const bool has_gyroscopic = has_goal(GoalKind::gyroscopic) || has_goal(GoalKind::decoupled);
  const bool has_independent = has_goal(GoalKind::gyroscopic_independent) || (has_gyroscopic && !speeds_.empty());
  if (!has_gyroscopic && !has_independent && !has_goal(GoalKind::statics)) return;
  const VectorX zero_rate = VectorX::Zero(tree_.columns);
  const MatrixX projection = probe.directions.transpose() * scale_.asDiagonal();
  const double L = units_.length;
  add_static_efforts(projection);
  // friction is odd in the velocities, terms of masses are even: neither can compensate for the other
  if ((has_gyroscopic || has_independent) && known_terms_.has_friction())
    append_known_rows(projection, known_terms_.friction_columns(scale_.cwiseProduct(probe.velocity), state_), L * L);
  if (has_gyroscopic && speeds_.empty())
    append_rows(projection * compute_regressor(probe.velocity, zero_rate, false).torque, L * L);
  if (has_independent) {
    const VectorX bias = held_bias(probe.velocity, speeds_.empty() ? selection_ : speed_rows_, !speeds_.empty());
    append_rows(projection * compute_regressor(probe.velocity, bias, false).torque, L * L);
  }
}

/// decoupled: the effort that one actuator's acceleration requires of another; fully-: changes of the actuators'
/// inertia.
template <class S>
void GoalRows<S>::add_inertia() {
  const bool decoupled = has_goal(GoalKind::decoupled);
  if (!decoupled && !is_fully_) return;
  const VectorX zero_rate = VectorX::Zero(tree_.columns);
  const Eigen::Index n = actuated_.cols();
  const bool is_symmetric = speeds_.empty();  // efforts and accelerations belong to the same coordinates
  const MatrixX& accelerations = is_symmetric ? actuated_ : speed_directions_;
  MatrixX inertia_rows(is_symmetric ? n * (n + 1) / 2 : n * n, inertial_count_),
      coupling_rows(is_symmetric ? n * (n - 1) / 2 : n * (n - 1), inertial_count_);
  Eigen::Index f = 0, c = 0;
  for (Eigen::Index s = 0; s < n; ++s) {
    const MatrixX column =
        actuated_.transpose() * scale_.asDiagonal() * compute_regressor(zero_rate, accelerations.col(s), false).torque;
    for (Eigen::Index r = 0; r < (is_symmetric ? s + 1 : n); ++r) {
      inertia_rows.row(f++) = column.row(r);
      if (r != s) coupling_rows.row(c++) = column.row(r) / (actuated_.col(r).norm() * accelerations.col(s).norm());
    }
  }
  const double unit = units_.length * units_.length;
  if (decoupled && n > 1) append_rows(coupling_rows, unit);
  if (!is_fully_) return;
  if (inertia_reference_.size() == 0) inertia_reference_ = inertia_rows;
  append_rows(inertia_rows - inertia_reference_, unit);
}

/// force, moment, dynamic, proportional, affine: momenta per unit of the admissible velocities.
template <class S>
void GoalRows<S>::add_momentum(const VelocityProbe& probe) {
  const bool has_momentum = std::any_of(momentum_components_.begin(), momentum_components_.end(),
                                        [](const auto& components) { return !components.is_at_constant_speed; });
  if (!has_momentum && extra_count_ == 0) return;
  const VectorX zero_rate = VectorX::Zero(tree_.columns);
  for (Eigen::Index k = 0; k < probe.directions.cols(); ++k) {
    set_motion(zero_rate, probe.directions.col(k), false);
    const dynamics::InertiaRegressor<S> momentum = dynamics::compute_momentum_rate_regressor(tree_, state_);
    for (const MomentumComponents& components : momentum_components_)
      if (!components.is_at_constant_speed) append_momentum(momentum, components);
    if (extra_count_ > 0) append_com_tool_rows(momentum.force);
  }
}

/// force, moment, dynamic at constant speed: rates of the momenta at a velocity while the held coordinates H ẏ have no
/// acceleration, and per unit of the accelerations N (1 − (H N)⁺ H N) that this leaves free.
template <class S>
void GoalRows<S>::add_momentum_rates(const VelocityProbe& probe, const MatrixX& null_space) {
  const VectorX zero_rate = VectorX::Zero(tree_.columns);
  for (const MomentumComponents& components : momentum_components_) {
    if (!components.is_at_constant_speed) continue;
    set_motion(probe.velocity, held_bias(probe.velocity, components.held_rows, false), false);
    append_momentum(dynamics::compute_momentum_rate_regressor(tree_, state_), components);
    const MatrixX held = components.held_rows * null_space;
    if (held.rows() == null_space.cols()) continue;
    MatrixX directions = probe.directions;
    if (held.rows() > 0) {
      numerics::CompleteOrthogonalDecomposition qr;
      directions -= null_space * qr.compute(held).solve(components.held_rows * probe.directions);
    }
    for (Eigen::Index k = 0; k < directions.cols(); ++k) {
      set_motion(zero_rate, directions.col(k), false);
      append_momentum(dynamics::compute_momentum_rate_regressor(tree_, state_), components);
    }
  }
}

template <class S>
void GoalRows<S>::append_momentum(const dynamics::InertiaRegressor<S>& momentum, const MomentumComponents& components) {
  const double L = units_.length;
  const auto append_components = [&](const MatrixX& rows, const std::array<bool, 3>& is_wanted, double unit) {
    std::vector<int> wanted;
    for (int i = 0; i < static_cast<int>(rows.rows()); ++i)
      if (is_wanted[static_cast<std::size_t>(rows.rows() == 1 ? 2 : i)]) wanted.push_back(i);
    if (!wanted.empty()) append_rows(rows(wanted, Eigen::all), unit);
  };
  append_components(momentum.force, components.linear, L);
  if (components.angular == std::array<bool, 3>{}) return;
  Vector3 about = options_.about;
  if (!components.about.empty())
    about = locate_landmark(mechanism_, model::find_landmark(mechanism_, components.about).value()).position;
  MatrixX rows = momentum.moment;
  if constexpr (S::angular_dimension == 1)
    rows -= about.x() * momentum.force.row(1) - about.y() * momentum.force.row(0);
  else
    for (Eigen::Index p = 0; p < rows.cols(); ++p) rows.col(p) -= about.cross(Vector3(momentum.force.col(p)));
  append_components(rows, components.angular, L * L);
}

/// proportional: momentum − A · tool velocity; affine: also minus B · the rates of the tool body's axes. The state
/// holds the velocities as accelerations from rest.
template <class S>
void GoalRows<S>::append_com_tool_rows(const MatrixX& momentum) {
  constexpr int d = S::dimension;
  const kinematics::NodeState<S>& node = state_[static_cast<std::size_t>(tool_.node)];
  const typename S::Vector tool = kinematics::point_acceleration<S>(node, tool_.p_N);
  const typename S::Angular spin = node.R_WN * node.angular_acceleration;
  const typename S::Rotation R = node.R_WN * tool_.R_N;
  Eigen::Index first = parameters_;
  for (const GoalKind kind : {GoalKind::proportional, GoalKind::affine}) {
    if (!has_goal(kind)) continue;
    VectorX rates(d + (kind == GoalKind::affine ? d * tool_axis_count<S> : 0));
    rates.head(d) = tool;
    for (int k = 0; d * (k + 1) < rates.size(); ++k)
      rates.segment(d * (k + 1), d) =
          units_.length * typename S::Vector(kinematics::cross(spin, typename S::Vector(axis(R, k))));
    MatrixX rows = MatrixX::Zero(d, parameters_ + extra_count_);
    rows.leftCols(inertial_count_) = momentum;
    for (int i = 0; i < d; ++i, first += rates.size()) rows.row(i).segment(first, rates.size()) = -rates.transpose();
    append_rows(rows, units_.length);
  }
}

template class GoalRows<kinematics::Planar>;
template class GoalRows<kinematics::Spatial>;

// Velocities and accelerations as functions of the actuators' ones.

namespace {

/// Minimum singular value of the speeds' rows on the admissible velocities, relative to the largest one, with normalised
/// rows.
bool is_well_conditioned(MatrixX rows) {
  for (Eigen::Index r = 0; r < rows.rows(); ++r) rows.row(r).stableNormalize();
  if (!rows.allFinite()) return false;
  const VectorX values = numerics::singular_values(rows);
  return values.size() == 0 || values.tail(1)[0] > min_actuator_regularity * values[0];
}

/// The first rows that determine a motion; fewer than columns if they do not.
std::vector<int> choose_independent_rows(const MatrixX& rows) {
  std::vector<int> chosen;
  for (int r = 0; r < static_cast<int>(rows.rows()) && static_cast<Eigen::Index>(chosen.size()) < rows.cols(); ++r) {
    chosen.push_back(r);
    if (!is_well_conditioned(rows(chosen, Eigen::all))) chosen.pop_back();
  }
  return chosen;
}

}  // namespace

/// C = N (S N)⁻¹: its actuated rows are the identity.
template <class S>
bool GoalRows<S>::set_actuated(const MatrixX& null_space) {
  const MatrixX actuator_jacobian = selection_ * null_space;
  if (actuator_jacobian.rows() != actuator_jacobian.cols()) return false;
  if (actuator_jacobian.size() > 0 && numerics::singular_values(actuator_jacobian).tail(1)[0] < min_actuator_regularity)
    return false;
  actuated_ = null_space * actuator_jacobian.partialPivLu().inverse();
  return true;
}

template <class S>
MatrixX GoalRows<S>::speed_rows() {
  MatrixX rows(static_cast<Eigen::Index>(speeds_.size()), tree_.columns);
  for (int c = 0; c < tree_.columns; ++c) {
    const VectorX dy = scale_[c] * VectorX::Unit(tree_.columns, c);
    compute_velocities(tree_, dy.data(), state_);
    const dynamics::SpeedProbe<S> probe{tree_, state_, y_.data(), dy.data(), nullptr};
    rows.col(c) = probe.evaluate_speeds(speeds_, false).cwiseQuotient(speed_units_);
  }
  return rows;
}

/// The state holds accelerations with ddy = 0.
template <class S>
VectorX GoalRows<S>::speed_products(const VectorX& dy) {
  const VectorX zero = VectorX::Zero(tree_.columns);
  const dynamics::SpeedProbe<S> probe{tree_, state_, y_.data(), dy.data(), zero.data()};
  return probe.evaluate_speeds(speeds_, true).cwiseQuotient(speed_units_)(independent_speeds_);
}

/// As for the actuators, with the speeds' rows. The independent speeds stay those of the first configuration.
template <class S>
bool GoalRows<S>::set_speeds(const MatrixX& null_space) {
  const MatrixX all_rows = speed_rows(), on_motions = all_rows * null_space;
  if (independent_speeds_.empty()) {
    const std::vector<int> chosen = choose_independent_rows(on_motions);
    if (static_cast<Eigen::Index>(chosen.size()) < null_space.cols()) return false;
    independent_speeds_ = chosen;
  }
  speed_rows_ = all_rows(independent_speeds_, Eigen::all);
  const MatrixX jacobian = on_motions(independent_speeds_, Eigen::all);
  if (!is_well_conditioned(jacobian)) return false;
  speed_directions_ = null_space * jacobian.partialPivLu().inverse();
  return true;
}

/// The accelerations caused by a velocity while those of coordinates, or the derivatives of the speeds, are zero; the
/// least ones, if these do not determine the motion.
template <class S>
VectorX GoalRows<S>::held_bias(const VectorX& velocity, const MatrixX& held_rows, bool holds_speeds) {
  const VectorX dy = scale_.cwiseProduct(velocity);
  compute_velocities(tree_, dy.data(), state_);
  kinematics::compute_accelerations<S>(tree_, dy.data(), nullptr, S::Vector::Zero(), state_);
  const Eigen::Index closures = tree_.closure_rows, held = held_rows.rows();
  VectorX bias = VectorX::Zero(closures + held);
  if (holds_speeds) bias.tail(held) = -speed_products(dy);
  kinematics::ConstraintSystem<S> system(tree_, kinematics::Drive<S>{});
  MatrixX jacobian;
  system.velocity_jacobian(y_, {}, jacobian);
  double* next = bias.data();
  for (const kinematics::Closure<S>& closure : tree_.closures) {
    closure_bias(state_, closure, closure_pose(state_, closure), next);
    for (const kinematics::ClosureRow& row : closure.rows) *next++ *= -compute_row_scale(tree_, closure, row);
  }
  MatrixX stacked(closures + held, tree_.columns);
  stacked << jacobian, held_rows;
  numerics::CompleteOrthogonalDecomposition qr;
  qr.setThreshold(1e-9);  // redundant closures leave rows of round-off
  return qr.compute(stacked).solve(bias);
}

#define BALANCE_INSTANTIATE(S)                                  \
  template bool GoalRows<S>::set_actuated(const MatrixX&);      \
  template bool GoalRows<S>::set_speeds(const MatrixX&);        \
  template MatrixX GoalRows<S>::speed_rows();                   \
  template VectorX GoalRows<S>::speed_products(const VectorX&); \
  template VectorX GoalRows<S>::held_bias(const VectorX&, const MatrixX&, bool);
BALANCE_INSTANTIATE(kinematics::Planar)
BALANCE_INSTANTIATE(kinematics::Spatial)
#undef BALANCE_INSTANTIATE

// Efforts that springs require at rest.

/// Generalised forces that balance the springs, per unit of each of their parameters: ∂U/∂y, where U is linear in k, k
/// a, k b, k a bᵀ; for joint springs, in k and the preload.
template <class S>
MatrixX GoalRows<S>::spring_torques() {
  MatrixX torque = MatrixX::Zero(tree_.columns, parameters_ - inertial_count_ - known_terms_.size());
  VectorX unit = VectorX::Zero(tree_.columns);
  for (int c = 0; c < tree_.columns; ++c) {
    unit.setZero();
    unit[c] = 1;
    compute_velocities(tree_, unit.data(), state_);
    Eigen::Index column = 0;
    for (std::size_t s = 0; s < mechanism_.springs.size(); ++s) {
      const Spring& spring = mechanism_.springs[s];
      if (spring.is_joint_spring()) {  // k q − preload
        const kinematics::LinearQuantity& source =
            tree_.coordinate_expressions[static_cast<std::size_t>(spring.coordinate)];
        const double ratio = source.rate(unit.data());
        torque(c, column++) = ratio * source.value(y_.data());
        torque(c, column++) = -ratio;
        continue;
      }
      const kinematics::FixedFrame<S>&A = tree_.bodies[static_cast<std::size_t>(spring.first)],
            &B = tree_.bodies[static_cast<std::size_t>(spring.second)];
      const kinematics::NodeState<S>&a = state_[static_cast<std::size_t>(A.node)],
            &b = state_[static_cast<std::size_t>(B.node)];
      const bool is_loose = s < options_.loose_springs.size() && options_.loose_springs[s];
      const typename S::Vector end_a =
          is_loose ? typename S::Vector(S::Vector::Zero()) : kinematics::to_vector<S>(spring.point_first);
      const typename S::Vector end_b =
          is_loose ? typename S::Vector(S::Vector::Zero()) : kinematics::to_vector<S>(spring.point_second);
      const typename S::Vector p_A = A.p_N + A.R_N * end_a, p_B = B.p_N + B.R_N * end_b;
      const typename S::Vector d =
          kinematics::position(state_, {A.node, A.R_N, p_A}) - kinematics::position(state_, {B.node, B.R_N, p_B});
      const typename S::Vector rate = kinematics::point_velocity<S>(a, p_A) - kinematics::point_velocity<S>(b, p_B);
      const double length = d.norm();
      const bool has_zero_free_length = is_loose || spring.free_length == 0;
      torque(c, column++) = d.dot(rate) * (has_zero_free_length ? 1 : length > 0 ? 1 - spring.free_length / length : 0);
      if (!is_loose) continue;
      const typename S::Rotation R_A = a.R_WN * A.R_N, R_B = b.R_WN * B.R_N;
      const typename S::Angular w_A = a.R_WN * a.angular_velocity, w_B = b.R_WN * b.angular_velocity;
      const auto turned_rate = [](const typename S::Angular& w, const typename S::Vector& e) {
        return typename S::Vector(kinematics::cross(w, e));
      };
      for (int i = 0; i < S::dimension; ++i)
        torque(c, column++) = rate.dot(axis(R_A, i)) + d.dot(turned_rate(w_A, axis(R_A, i)));
      for (int j = 0; j < S::dimension; ++j)
        torque(c, column++) = -rate.dot(axis(R_B, j)) - d.dot(turned_rate(w_B, axis(R_B, j)));
      for (int i = 0; i < S::dimension; ++i)
        for (int j = 0; j < S::dimension; ++j)
          torque(c, column++) =
              -turned_rate(w_A, axis(R_A, i)).dot(axis(R_B, j)) - axis(R_A, i).dot(turned_rate(w_B, axis(R_B, j)));
    }
  }
  return torque;
}

template MatrixX GoalRows<kinematics::Planar>::spring_torques();
template MatrixX GoalRows<kinematics::Spatial>::spring_torques();

}  // namespace balance::conditions
