#include "balance/synthesis/design/force_regressor.hpp"

#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/results/quantities.hpp"

#include <algorithm>

namespace balance {

namespace {

/// A mechanism with the loads only.
Mechanism extract_loads(const Mechanism& mechanism) {
  Mechanism loads_only;
  loads_only.loads = mechanism.loads;
  return loads_only;
}

void write_energy_row(double w, const Vector2& v, double* out) {
  out[0] = 0.5 * v.squaredNorm();
  out[1] = w * v.y();  // v · (ω × r)
  out[2] = -w * v.x();
  out[3] = 0.5 * w * w;
}

void write_energy_row(const Vector3& w, const Vector3& v, double* out) {
  out[0] = 0.5 * v.squaredNorm();
  const Vector3 moment = cross(v, w);  // v · (ω × r) = r · (v × ω)
  for (int i = 0; i < 3; ++i) out[1 + i] = moment[i], out[4 + i] = 0.5 * w[i] * w[i];
  out[7] = w.x() * w.y();
  out[8] = w.x() * w.z();
  out[9] = w.y() * w.z();
}

}  // namespace

template <class S>
ForceRegressor<S>::ForceRegressor(const Mechanism& mechanism, const Tree<S>& tree, int freedoms, const Vector3& about,
                                  const FreeSprings& loose)
    : mechanism_(mechanism),
      tree_(tree),
      gravity_(to_vector<S>(mechanism.gravity)),
      about_(to_vector<S>(about)),
      inertial_(S::inertial_parameter_count * static_cast<Eigen::Index>(tree.mass_elements.size())),
      loads_mechanism_(extract_loads(mechanism)),
      loads_(loads_mechanism_, tree),
      springs_(mechanism, tree, loose),
      actuation_(mechanism, tree, freedoms),
      wrenches_(tree.nodes.size()) {}

template <class S>
bool ForceRegressor<S>::evaluate(MotionStepper<S>& stepper, const CostQuantity& quantity, MatrixX& rows) {
  using Kind = CostQuantity::Kind;
  if (quantity.of_actuators()) return torque(stepper, quantity, rows);
  if (quantity.kind == Kind::ground_force || quantity.kind == Kind::ground_moment) {
    ground_reaction(stepper, quantity.kind == Kind::ground_moment, rows);
    return true;
  }
  rows.setZero(quantity.kind == Kind::kinetic_energy  ? 1
               : quantity.kind == Kind::shaking_force ? S::dimension
                                                      : S::angular_dimension,
               columns());
  if (quantity.kind == Kind::kinetic_energy) {
    kinetic_energy(stepper.state(), rows);
    return true;
  }
  InertiaRegressor<S> momentum = compute_regressor(stepper, S::Vector::Zero());  // rate of momentum, without gravity
  if (quantity.kind == Kind::shaking_moment) shift_moment_point(momentum.force, momentum.moment);
  rows.leftCols(inertial_) = quantity.kind == Kind::shaking_force ? momentum.force : momentum.moment;
  return true;
}

template <class S>
InertiaRegressor<S> ForceRegressor<S>::compute_regressor(MotionStepper<S>& stepper,
                                                         const typename S::Vector& base) const {
  compute_accelerations<S>(tree_, stepper.dy(), stepper.ddy(), base, stepper.state());
  return balance::compute_regressor(tree_, stepper.state());
}

/// u = E (Y π + torques of springs, loads and friction). Power: multiplied by the actuator's rate.
template <class S>
bool ForceRegressor<S>::torque(MotionStepper<S>& stepper, const CostQuantity& quantity, MatrixX& rows) {
  if (!actuation_.project(stepper.equations(), projection_)) return false;
  tau_.resize(tree_.columns, columns());
  tau_.leftCols(inertial_) = compute_regressor(stepper, -gravity_).torque;
  springs_.evaluate(stepper.state(), stepper.y(), tau_.middleCols(inertial_, springs_.count()));
  constant_torque(stepper, tau_.rightCols(1).col(0));
  const Eigen::Index first = quantity.actuator.value_or(0), count = quantity.actuator ? 1 : projection_.rows();
  rows.noalias() = projection_.middleRows(first, count) * tau_;
  if (quantity.kind == CostQuantity::Kind::torque) return true;
  for (Eigen::Index a = 0; a < count; ++a) {
    const LinearQuantity& source =
        tree_.coordinate_expressions[mechanism_.actuators[static_cast<std::size_t>(first + a)]];
    rows.row(a) *= source.rate(stepper.dy());
  }
  return true;
}

/// Loads and friction, which depend only on the motion.
template <class S>
void ForceRegressor<S>::constant_torque(MotionStepper<S>& stepper, Eigen::Ref<VectorX> tau) {
  tau.setZero();
  if (!loads_.is_empty()) {
    for (auto& wrench : wrenches_) wrench = {};
    Wrench<S> total, loads;
    loads_.subtract(stepper.state(), stepper.time(), wrenches_, total, loads);
    compute_wrench_forces(tree_, stepper.state(), wrenches_, tau.data());
  }
  if (!mechanism_.friction.empty())
    add_friction_forces(mechanism_, tree_, stepper.dy(), stepper.duration(), tau.data());
}

/// Shifts moments from the origin of the world to the moment reference point.
template <class S>
void ForceRegressor<S>::shift_moment_point(const MatrixX& force, MatrixX& moment) const {
  for (Eigen::Index p = 0; p < force.cols(); ++p) {
    const typename S::Vector f = force.col(p);
    const Vector3 shift = angular_to_3d(cross(about_, f));
    for (int i = 0; i < S::angular_dimension; ++i) moment(i, p) -= shift[S::angular_dimension == 1 ? 2 : i];
  }
}

/// Force or moment on the ground: weight and loads minus the rate of momentum.
template <class S>
void ForceRegressor<S>::ground_reaction(MotionStepper<S>& stepper, bool moment, MatrixX& rows) {
  const InertiaRegressor<S> exerted = compute_regressor(stepper, -gravity_);
  MatrixX force = MatrixX::Zero(S::dimension, columns());
  force.leftCols(inertial_) = -exerted.force;
  for (auto& wrench : wrenches_) wrench = {};
  Wrench<S> total, loads;
  loads_.subtract(stepper.state(), stepper.time(), wrenches_, total, loads);
  force.rightCols(1) = loads.force;
  if (!moment) {
    rows = force;
    return;
  }
  rows.setZero(S::angular_dimension, columns());
  rows.leftCols(inertial_) = -exerted.moment;
  const Vector3 load_moment = angular_to_3d(loads.moment);
  for (int i = 0; i < S::angular_dimension; ++i)
    rows(i, columns() - 1) = load_moment[S::angular_dimension == 1 ? 2 : i];
  shift_moment_point(force, rows);
}

template <class S>
void ForceRegressor<S>::kinetic_energy(const TreeState<S>& state, MatrixX& rows) const {
  double out[S::inertial_parameter_count];
  for (std::size_t e = 0; e < tree_.mass_elements.size(); ++e) {
    const FixedFrame<S>& frame = tree_.mass_elements[e].frame;
    if (frame.node == 0) continue;
    const NodeState<S>& node = state[frame.node];
    const typename S::Angular w = node.angular_velocity;
    const typename S::Vector v = rotate_inverse(frame.R_N, typename S::Vector(node.velocity + cross(w, frame.p_N)));
    write_energy_row(rotate_inverse(frame.R_N, w), v, out);
    for (int k = 0; k < S::inertial_parameter_count; ++k)
      rows(0, static_cast<Eigen::Index>(e) * S::inertial_parameter_count + k) = out[k];
  }
}

template class ForceRegressor<Planar>;
template class ForceRegressor<Spatial>;

std::optional<CostQuantity> find_cost_quantity(const Mechanism& mechanism, const std::string& name) {
  using Kind = CostQuantity::Kind;
  if (name == "total_torque" && mechanism.actuators.size() > 1) {
    std::optional<CostQuantity> all = find_cost_quantity(mechanism, "torque");
    if (all) all->is_combined = true;
    return all;
  }
  const std::size_t bracket = name.find('[');
  const std::string stem = effort_array_name(name);
  if (stem == "torque" || stem == "power") {
    CostQuantity quantity{stem == "torque" ? Kind::torque : Kind::power, {}};
    const std::vector<CoordinateId>& actuators = mechanism.actuators;
    const auto kind = [&](CoordinateId coordinate) { return mechanism.coordinates[coordinate].kind; };
    if (bracket == std::string::npos) {  // the maximum over actuators requires equal units
      const bool has_equal_kinds = std::all_of(actuators.begin(), actuators.end(),
                                               [&](int c) { return stem == "power" || kind(c) == kind(actuators[0]); });
      return has_equal_kinds && !actuators.empty() ? std::optional(quantity) : std::nullopt;
    }
    for (std::size_t a = 0; a < actuators.size(); ++a)
      if (name.substr(bracket) == "[" + mechanism.coordinates[actuators[a]].name + "]") {
        quantity.actuator = static_cast<int>(a);
        return quantity;
      }
    return std::nullopt;
  }
  constexpr std::pair<const char*, Kind> named_cost_quantities[] = {{"shaking_force", Kind::shaking_force},
                                                                    {"shaking_moment", Kind::shaking_moment},
                                                                    {"ground_force", Kind::ground_force},
                                                                    {"ground_moment", Kind::ground_moment},
                                                                    {"kinetic_energy", Kind::kinetic_energy}};
  for (const auto& [text, kind] : named_cost_quantities)
    if (name == text) return CostQuantity{kind, {}};
  return std::nullopt;
}

namespace {

/// Number of end points at which loose springs are sampled: the origin and one on each axis.
template <class S>
constexpr int spring_end_points = S::dimension + 1;

/// End point number i, at the distance `length` from the origin.
Vector3 end_point(int i, double length) { return i == 0 ? Vector3(Vector3::Zero()) : length * Vector3::Unit(i - 1); }

}  // namespace

template <class S>
SpringRegressor<S>::SpringRegressor(const Mechanism& mechanism, const Tree<S>& tree, const FreeSprings& loose)
    : tree_(tree), mechanism_(mechanism), wrenches_(tree.nodes.size()) {
  constexpr Eigen::Index d = S::dimension;
  for (std::size_t s = 0; s < mechanism.springs.size(); ++s) {
    Spring spring = mechanism.springs[s];
    const bool free_ends = s < loose.size() && loose[s];
    kinds_.push_back(spring.is_joint_spring() ? SpringKind::in_joint
                     : free_ends              ? SpringKind::loose
                                              : SpringKind::fixed);
    spring.stiffness = 1;
    if (kinds_.back() == SpringKind::in_joint) {
      count_ += 2;
      continue;
    }
    if (kinds_.back() == SpringKind::fixed) {
      add(spring);
      ++count_;
      continue;
    }
    spring.free_length = 0;
    for (int i = 0; i < spring_end_points<S>; ++i)
      for (int j = 0; j < spring_end_points<S>; ++j) {
        spring.point_first = end_point(i, tree.characteristic_length);
        spring.point_second = end_point(j, tree.characteristic_length);
        add(spring);
      }
    count_ += 1 + 2 * d + d * d;
  }
}

template <class S>
void SpringRegressor<S>::add(const Spring& spring) {
  Mechanism single_spring;
  single_spring.springs.push_back(spring);
  unit_springs_.emplace_back(single_spring, tree_);
}

template <class S>
VectorX SpringRegressor<S>::torque_of(const UnitSpring& spring, const TreeState<S>& state) {
  for (auto& wrench : wrenches_) wrench = {};
  Wrench<S> total, loads;
  spring.subtract(state, 0, wrenches_, total, loads);
  VectorX torque(tree_.columns);
  compute_wrench_forces(tree_, state, wrenches_, torque.data());
  return torque;
}

template <class S>
void SpringRegressor<S>::evaluate(const TreeState<S>& state, const double* y, Eigen::Ref<MatrixX> torque) {
  constexpr Eigen::Index d = S::dimension;
  std::size_t unit = 0;
  Eigen::Index column = 0;
  for (std::size_t s = 0; s < kinds_.size(); ++s) {
    if (kinds_[s] == SpringKind::in_joint) {  // k q − preload
      const LinearQuantity& source = tree_.coordinate_expressions[mechanism_.springs[s].coordinate];
      torque.middleCols(column, 2).setZero();
      source.add_generalised_force(source.value(y), torque.col(column).data());
      source.add_generalised_force(-1, torque.col(column + 1).data());
      column += 2;
      continue;
    }
    if (kinds_[s] == SpringKind::fixed) {
      torque.col(column++) = torque_of(unit_springs_[unit++], state);
      continue;
    }
    const Eigen::Index width = 1 + 2 * d + d * d;
    loose_at(unit, state, torque.middleCols(column, width));
    unit += spring_end_points<S> * spring_end_points<S>;
    column += width;
  }
}

/// With zero free length, the torque is k T(a, b), where T is affine in each of the end points a and b (terms quadratic
/// in one end point are constant in the energy). Its coefficients are differences between unit end points.
template <class S>
void SpringRegressor<S>::loose_at(std::size_t first, const TreeState<S>& state, Eigen::Ref<MatrixX> torque) {
  constexpr Eigen::Index d = S::dimension;
  MatrixX T(tree_.columns, spring_end_points<S> * spring_end_points<S>);
  for (int i = 0; i < spring_end_points<S> * spring_end_points<S>; ++i)
    T.col(i) = torque_of(unit_springs_[first + static_cast<std::size_t>(i)], state);
  const auto at = [&](Eigen::Index i, Eigen::Index j) { return T.col(i * spring_end_points<S> + j); };
  const double L = tree_.characteristic_length;
  torque.col(0) = at(0, 0);
  for (Eigen::Index i = 1; i <= d; ++i) {
    torque.col(i) = (at(i, 0) - at(0, 0)) / L;
    torque.col(d + i) = (at(0, i) - at(0, 0)) / L;
    for (Eigen::Index j = 1; j <= d; ++j)
      torque.col(2 * d + (i - 1) * d + j) = (at(i, j) - at(i, 0) - at(0, j) + at(0, 0)) / (L * L);
  }
}

template class SpringRegressor<Planar>;
template class SpringRegressor<Spatial>;

}  // namespace balance
