#include "balance/mechanics/dynamics/force_regressor.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/dynamics/sample_quantities.hpp"
#include "balance/mechanics/model/landmark.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/run_quantities.hpp"

#include <algorithm>

namespace balance::dynamics {

using kinematics::MotionStepper;

namespace {

/// A mechanism with the forces that are not linear in parameters of the design.
Mechanism extract_known_forces(const Mechanism& mechanism) {
  Mechanism forces_only;
  forces_only.loads = mechanism.loads;
  forces_only.force_elements = mechanism.force_elements;
  return forces_only;
}

/// A mechanism whose efforts are linear in the forces.
Mechanism replace_nonlinear_distribution(Mechanism mechanism) {
  if (!has_linear_efforts(mechanism)) mechanism.torque_distribution.reset();
  return mechanism;
}

/// Below it, relative to the largest, choices of actuators have internal efforts of their own.
constexpr double internal_rank_threshold = 1e-9;

Eigen::Index count_choices(Eigen::Index of, Eigen::Index size) {
  Eigen::Index choices = 1;
  for (Eigen::Index k = 1; k <= size; ++k) choices = choices * (of - size + k) / k;
  return choices;
}

void write_energy_row(double w, const Vector2& v, double* out) {
  out[0] = 0.5 * v.squaredNorm();
  out[1] = w * v.y();  // v · (ω × r)
  out[2] = -w * v.x();
  out[3] = 0.5 * w * w;
}

void write_energy_row(const Vector3& w, const Vector3& v, double* out) {
  out[0] = 0.5 * v.squaredNorm();
  const Vector3 moment = kinematics::cross(v, w);  // v · (ω × r) = r · (v × ω)
  for (int i = 0; i < 3; ++i) out[1 + i] = moment[i], out[4 + i] = 0.5 * w[i] * w[i];
  out[7] = w.x() * w.y();
  out[8] = w.x() * w.z();
  out[9] = w.y() * w.z();
}

}  // namespace

template <class S>
ForceRegressor<S>::ForceRegressor(const Mechanism& mechanism, const kinematics::Tree<S>& tree, int freedoms,
                                  const Vector3& about, const FreeSprings& loose)
    : mechanism_(mechanism),
      tree_(tree),
      gravity_(kinematics::to_vector<S>(mechanism.gravity)),
      about_(kinematics::to_vector<S>(about)),
      inertial_(S::inertial_parameter_count * static_cast<Eigen::Index>(tree.mass_elements.size())),
      freedoms_(freedoms),
      known_forces_mechanism_(extract_known_forces(mechanism)),
      min_norm_mechanism_(replace_nonlinear_distribution(mechanism)),
      known_forces_(known_forces_mechanism_, tree),
      springs_(mechanism, tree, loose),
      actuation_(min_norm_mechanism_, tree, freedoms),
      wrenches_(tree.nodes.size()) {
  reactions_.constraint_force.setZero(static_cast<Eigen::Index>(mechanism.constraints.size()));
}

template <class S>
bool ForceRegressor<S>::evaluate(MotionStepper<S>& stepper, const AffineQuantity& quantity, MatrixX& rows) {
  if (!evaluate_vector(stepper, quantity, rows)) return false;
  if (quantity.component) rows = MatrixX(rows.row(*quantity.component));
  return true;
}

template <class S>
bool ForceRegressor<S>::evaluate_vector(MotionStepper<S>& stepper, const AffineQuantity& quantity, MatrixX& rows) {
  using Kind = AffineQuantity::Kind;
  if (quantity.of_actuators()) return torque(stepper, quantity, rows);
  if (quantity.of_joints()) return joint_reaction(stepper, quantity, rows);
  if (quantity.kind == Kind::ground_force || quantity.kind == Kind::ground_moment) {
    ground_reaction(stepper, quantity, rows);
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
  if (quantity.kind == Kind::shaking_moment) shift_moment_point(quantity, momentum.force, momentum.moment);
  rows.leftCols(inertial_) = quantity.kind == Kind::shaking_force ? momentum.force : momentum.moment;
  return true;
}

template <class S>
InertiaRegressor<S> ForceRegressor<S>::compute_regressor(MotionStepper<S>& stepper,
                                                         const typename S::Vector& base) const {
  kinematics::compute_accelerations<S>(tree_, stepper.dy(), stepper.ddy(), base, stepper.state());
  return dynamics::compute_regressor(tree_, stepper.state());
}

/// The tree's generalised forces: Y π + torques of springs, loads and friction.
template <class S>
void ForceRegressor<S>::evaluate_generalised_forces(MotionStepper<S>& stepper) {
  tau_.resize(tree_.columns, columns());
  tau_.leftCols(inertial_) = compute_regressor(stepper, -gravity_).torque;
  springs_.evaluate(stepper.state(), stepper.y(), tau_.middleCols(inertial_, springs_.count()));
  constant_torque(stepper, tau_.rightCols(1).col(0));
}

/// u = E τ. Power: multiplied by the actuator's rate.
template <class S>
bool ForceRegressor<S>::torque(MotionStepper<S>& stepper, const AffineQuantity& quantity, MatrixX& rows) {
  if (!actuation_.project(stepper.equations(), projection_)) return false;
  evaluate_generalised_forces(stepper);
  if (quantity.is_min_peak) {
    rows.noalias() = min_peak_combinations() * (projection_ * tau_);
    return true;
  }
  const Eigen::Index first = quantity.member.value_or(0), count = quantity.member ? 1 : projection_.rows();
  rows.noalias() = projection_.middleRows(first, count) * tau_;
  if (quantity.kind == AffineQuantity::Kind::torque) return true;
  for (Eigen::Index a = 0; a < count; ++a) {
    const kinematics::LinearQuantity& source =
        tree_.coordinate_expressions[mechanism_.actuators[static_cast<std::size_t>(first + a)]];
    rows.row(a) *= source.rate(stepper.dy());
  }
  return true;
}

/// The least peak of efforts u = u0 + N λ, with u0 = E τ and N the internal efforts, is by duality the largest y·u0 with
/// Nᵀ y = 0 and Σ |y| = 1. Its vertices have at most one component more than there are internal efforts: every choice of
/// so many actuators gives one, and the least peak is the largest of these |y·u0|.
/// @return one y per row; 0 where a choice of actuators has more than one
template <class S>
MatrixX ForceRegressor<S>::min_peak_combinations() const {
  const Eigen::Index actuators = projection_.rows(), support = actuators - freedoms_ + 1;
  if (support == 1) return MatrixX::Identity(actuators, actuators);
  const MatrixX Q = numerics::ColumnPivotingQr(projection_).householderQ();  // E reaches what N does not
  const MatrixX internal = Q.rightCols(support - 1);
  std::vector<bool> is_chosen(static_cast<std::size_t>(actuators), false);
  std::fill(is_chosen.begin(), is_chosen.begin() + support, true);
  MatrixX combinations = MatrixX::Zero(static_cast<Eigen::Index>(count_choices(actuators, support)), actuators);
  for (Eigen::Index row = 0; row < combinations.rows(); ++row) {
    std::vector<Eigen::Index> chosen;
    for (Eigen::Index a = 0; a < actuators; ++a)
      if (is_chosen[static_cast<std::size_t>(a)]) chosen.push_back(a);
    numerics::ColumnPivotingQr factors;
    factors.setThreshold(internal_rank_threshold);
    factors.compute(MatrixX(internal(chosen, Eigen::all)));
    if (factors.rank() == support - 1) {
      const MatrixX complement = factors.householderQ();
      const VectorX y = complement.rightCols(1);
      for (std::size_t k = 0; k < chosen.size(); ++k)
        combinations(row, chosen[k]) = y[static_cast<Eigen::Index>(k)] / y.lpNorm<1>();
    }
    std::prev_permutation(is_chosen.begin(), is_chosen.end());
  }
  return combinations;
}

/// Minus the wrenches of loads, dampers and springs with a table, which depend only on the motion.
/// @return the resultant of the loads
template <class S>
Wrench<S> ForceRegressor<S>::set_known_wrenches(MotionStepper<S>& stepper) {
  for (auto& wrench : wrenches_) wrench = {};
  Wrench<S> total, loads;
  if (known_forces_.has_dampers()) kinematics::compute_velocities(tree_, stepper.dy(), stepper.state());
  known_forces_.subtract(stepper.state(), stepper.y(), stepper.time(), wrenches_, total, loads);
  return loads;
}

/// Known forces and friction, which depend only on the motion.
template <class S>
void ForceRegressor<S>::constant_torque(MotionStepper<S>& stepper, Eigen::Ref<VectorX> tau) {
  tau.setZero();
  if (!known_forces_.is_empty()) {
    set_known_wrenches(stepper);
    compute_wrench_forces(tree_, stepper.state(), wrenches_, tau.data());
    known_forces_.add_joint_springs(stepper.y(), tau.data());
  }
  if (!mechanism_.friction.empty())
    add_friction_forces(mechanism_, tree_, stepper.dy(), stepper.duration(), tau.data());
}

/// The reactions that wrenches on the nodes cause without loops, and those that closures have exerted already.
/// @param wrenches minus the wrenches on the nodes; overwritten
template <class S>
VectorX ForceRegressor<S>::read_reactions(const kinematics::TreeState<S>& state, const AffineQuantity& quantity,
                                          std::vector<Wrench<S>>& wrenches) {
  VectorX unused(tree_.columns);
  compute_wrench_forces(tree_, state, wrenches, unused.data());
  compute_joint_reactions(mechanism_, tree_, state, wrenches, reactions_);
  const bool is_force = quantity.kind == AffineQuantity::Kind::joint_force;
  const std::vector<Vector3>& all = is_force ? reactions_.joint_force : reactions_.joint_moment;
  const int width = is_force ? S::dimension : S::angular_dimension;
  const int count = quantity.member ? 1 : static_cast<int>(all.size());
  const auto first = all.begin() + quantity.member.value_or(0);
  VectorX values(count * width);
  for (int j = 0; j < count; ++j)
    for (int i = 0; i < width; ++i) values[j * width + i] = first[j][width == 1 ? 2 : i];
  return values;
}

/// The reactions per unit multiplier of each closure row.
template <class S>
MatrixX ForceRegressor<S>::multiplier_reactions(MotionStepper<S>& stepper, const AffineQuantity& quantity) {
  MatrixX reactions;
  std::vector<double> multipliers(static_cast<std::size_t>(tree_.closure_rows), 0);
  for (std::size_t r = 0; r < multipliers.size(); ++r) {
    for (auto& wrench : wrenches_) wrench = {};
    reactions_.joint_force.assign(mechanism_.joints.size(), Vector3::Zero());
    reactions_.joint_moment = reactions_.joint_force;
    multipliers[r] = 1;
    add_closure_wrenches(tree_, stepper.state(), multipliers, wrenches_, reactions_);
    multipliers[r] = 0;
    const VectorX column = read_reactions(stepper.state(), quantity, wrenches_);
    if (r == 0) reactions.resize(column.size(), tree_.closure_rows);
    reactions.col(static_cast<Eigen::Index>(r)) = column;
  }
  return reactions;
}

/// Reactions without loops, plus those of the closures' multipliers, which are a matrix times the generalised forces. In
/// over-constrained loops they are the multipliers of least norm, a linear function of the generalised forces as well.
template <class S>
bool ForceRegressor<S>::joint_reaction(MotionStepper<S>& stepper, const AffineQuantity& quantity, MatrixX& rows) {
  evaluate_generalised_forces(stepper);
  const kinematics::TreeState<S>& state = stepper.state();
  const auto read = [&](std::vector<Wrench<S>>& wrenches) {
    reactions_.joint_force.assign(mechanism_.joints.size(), Vector3::Zero());
    reactions_.joint_moment = reactions_.joint_force;
    return read_reactions(state, quantity, wrenches);
  };
  set_known_wrenches(stepper);
  const VectorX constant = read(wrenches_);
  rows.setZero(constant.size(), columns());
  rows.rightCols(1) = constant;
  const UnitWrenches<S> unit_wrenches = compute_unit_wrenches(tree_, state);
  for (std::size_t p = 0; p < unit_wrenches.size(); ++p) {
    const kinematics::NodeId node = tree_.mass_elements[p / S::inertial_parameter_count].frame.node;
    if (node == 0) continue;
    for (auto& wrench : wrenches_) wrench = {};
    wrenches_[node] = unit_wrenches[p];
    rows.col(static_cast<Eigen::Index>(p)) = read(wrenches_);
  }
  springs_.evaluate(state, read, rows.middleCols(inertial_, springs_.count()));
  if (tree_.closure_rows == 0) return true;
  MatrixX multipliers(tree_.closure_rows, tree_.columns);
  for (int c = 0; c < tree_.columns; ++c) {
    const VectorX unit = VectorX::Unit(tree_.columns, c);
    if (!actuation_.solve(stepper.equations(), unit.data())) return false;
    multipliers.col(c) = Eigen::Map<const VectorX>(actuation_.multipliers().data(), tree_.closure_rows);
  }
  rows += multiplier_reactions(stepper, quantity) * multipliers * tau_;
  return true;
}

/// Shifts moments from the origin of the world to the moment reference point.
template <class S>
void ForceRegressor<S>::shift_moment_point(const AffineQuantity& quantity, const MatrixX& force,
                                           MatrixX& moment) const {
  const typename S::Vector about = quantity.about ? kinematics::to_vector<S>(*quantity.about) : about_;
  for (Eigen::Index p = 0; p < force.cols(); ++p) {
    const typename S::Vector f = force.col(p);
    const Vector3 shift = kinematics::angular_to_3d(kinematics::cross(about, f));
    for (int i = 0; i < S::angular_dimension; ++i) moment(i, p) -= shift[S::angular_dimension == 1 ? 2 : i];
  }
}

/// Force or moment on the ground: weight and loads minus the rate of momentum.
template <class S>
void ForceRegressor<S>::ground_reaction(MotionStepper<S>& stepper, const AffineQuantity& quantity, MatrixX& rows) {
  const InertiaRegressor<S> exerted = compute_regressor(stepper, -gravity_);
  MatrixX force = MatrixX::Zero(S::dimension, columns());
  force.leftCols(inertial_) = -exerted.force;
  const Wrench<S> loads = set_known_wrenches(stepper);
  force.rightCols(1) = loads.force;
  if (quantity.kind == AffineQuantity::Kind::ground_force) {
    rows = force;
    return;
  }
  rows.setZero(S::angular_dimension, columns());
  rows.leftCols(inertial_) = -exerted.moment;
  const Vector3 load_moment = kinematics::angular_to_3d(loads.moment);
  for (int i = 0; i < S::angular_dimension; ++i)
    rows(i, columns() - 1) = load_moment[S::angular_dimension == 1 ? 2 : i];
  shift_moment_point(quantity, force, rows);
}

template <class S>
void ForceRegressor<S>::kinetic_energy(const kinematics::TreeState<S>& state, MatrixX& rows) const {
  double out[S::inertial_parameter_count];
  for (std::size_t e = 0; e < tree_.mass_elements.size(); ++e) {
    const kinematics::FixedFrame<S>& frame = tree_.mass_elements[e].frame;
    if (frame.node == 0) continue;
    const kinematics::NodeState<S>& node = state[frame.node];
    const typename S::Angular w = node.angular_velocity;
    const typename S::Vector v =
        rotate_inverse(frame.R_N, typename S::Vector(node.velocity + kinematics::cross(w, frame.p_N)));
    write_energy_row(rotate_inverse(frame.R_N, w), v, out);
    for (int k = 0; k < S::inertial_parameter_count; ++k)
      rows(0, static_cast<Eigen::Index>(e) * S::inertial_parameter_count + k) = out[k];
  }
}

template class ForceRegressor<kinematics::Planar>;
template class ForceRegressor<kinematics::Spatial>;

namespace {

std::optional<AffineQuantity> find_actuator_quantity(const Mechanism& mechanism, const std::string& name) {
  const AffineQuantity::Kind kind =
      results::effort_array_name(name) == "power" ? AffineQuantity::Kind::power : AffineQuantity::Kind::torque;
  const std::vector<CoordinateId>& actuators = mechanism.actuators;
  const auto kind_of = [&](CoordinateId coordinate) { return mechanism.coordinates[coordinate].kind; };
  const std::size_t bracket = name.find('[');
  if (bracket == std::string::npos) {  // the maximum over actuators requires equal units
    const bool has_equal_kinds = std::all_of(actuators.begin(), actuators.end(), [&](int c) {
      return kind == AffineQuantity::Kind::power || kind_of(c) == kind_of(actuators[0]);
    });
    return has_equal_kinds && !actuators.empty() ? std::optional(AffineQuantity{.kind = kind}) : std::nullopt;
  }
  for (std::size_t a = 0; a < actuators.size(); ++a)
    if (name.substr(bracket) == "[" + mechanism.coordinates[actuators[a]].name + "]")
      return AffineQuantity{.kind = kind, .member = static_cast<int>(a)};
  return std::nullopt;
}

/// A quantity without component or point.
std::optional<AffineQuantity> find_whole_quantity(const Mechanism& mechanism, const std::string& name) {
  using Kind = AffineQuantity::Kind;
  if (name == "total_torque" && mechanism.actuators.size() > 1) {
    std::optional<AffineQuantity> all = find_actuator_quantity(mechanism, "torque");
    if (all) all->is_combined = true;
    return all;
  }
  if (const std::string stem = results::effort_array_name(name); stem == "torque" || stem == "power")
    return find_actuator_quantity(mechanism, name);
  constexpr std::pair<const char*, Kind> named_quantities[] = {
      {"shaking_force", Kind::shaking_force},  {"shaking_moment", Kind::shaking_moment},
      {"ground_force", Kind::ground_force},    {"ground_moment", Kind::ground_moment},
      {"joint_force", Kind::joint_force},      {"joint_moment", Kind::joint_moment},
      {"kinetic_energy", Kind::kinetic_energy}};
  for (const auto& [text, kind] : named_quantities) {
    AffineQuantity quantity{.kind = kind};
    if (name == text) return quantity;
    for (std::size_t j = 0; quantity.of_joints() && j < mechanism.joints.size(); ++j) {
      if (name != std::string(text) + "[" + mechanism.joints[j].name + "]") continue;
      quantity.member = static_cast<int>(j);
      return quantity;
    }
  }
  return std::nullopt;
}

/// Names of the components of a vector; empty for a scalar.
std::vector<std::string> list_components(const Mechanism& mechanism, const AffineQuantity& quantity) {
  using Kind = AffineQuantity::Kind;
  const bool is_planar = mechanism.space == SpaceKind::planar;
  switch (quantity.kind) {
    case Kind::torque:
    case Kind::power:
    case Kind::kinetic_energy: return {};
    case Kind::shaking_force:
    case Kind::ground_force:
    case Kind::joint_force: return results::axis_labels(is_planar ? 2 : 3);
    case Kind::shaking_moment:
    case Kind::ground_moment:
    case Kind::joint_moment: return is_planar ? std::vector<std::string>{"z"} : results::axis_labels(3);
  }
  return {};
}

}  // namespace

namespace {

/// In the names of quantities.
constexpr const char* min_peak_torque = "least peak torque";
/// More parts than this are not worth a proof.
constexpr Eigen::Index max_actuator_choices = 200;

/// Whether all actuators count alike and only their peak matters.
bool has_plain_min_peak(const Mechanism& mechanism) {
  const auto& distribution = mechanism.torque_distribution;
  const auto size = static_cast<Eigen::Index>(mechanism.actuators.size());
  return distribution && distribution->method == model::DistributionMethod::min_peak && !distribution->is_weighted() &&
         !distribution->has_limits() && !distribution->has_preload() && find_actuator_quantity(mechanism, "torque") &&
         count_choices(size, size / 2) <= max_actuator_choices;
}

}  // namespace

std::string name_cost_quantity(const Mechanism& mechanism, Statistic figure, const std::string& name) {
  const bool is_min_peak = figure == Statistic::peak && name == "torque" && has_plain_min_peak(mechanism);
  return is_min_peak ? min_peak_torque : name;
}

std::size_t count_parts(const Mechanism& mechanism, const AffineQuantity& quantity, int freedoms) {
  if (quantity.member || quantity.is_combined) return 1;
  const auto actuators = static_cast<Eigen::Index>(mechanism.actuators.size());
  if (quantity.is_min_peak) return static_cast<std::size_t>(count_choices(actuators, actuators - freedoms + 1));
  return quantity.of_actuators() ? mechanism.actuators.size() : quantity.of_joints() ? mechanism.joints.size() : 1;
}

std::optional<AffineQuantity> find_affine_quantity(const Mechanism& mechanism, const std::string& name) {
  using Kind = AffineQuantity::Kind;
  if (name == min_peak_torque) {
    if (!has_plain_min_peak(mechanism)) return std::nullopt;
    return AffineQuantity{.kind = Kind::torque, .is_min_peak = true};
  }
  const auto [moment, point] = results::split_moment_point(name);
  std::optional<AffineQuantity> quantity = find_whole_quantity(mechanism, moment);
  if (const auto [stem, label] = results::split_component(moment); !quantity && !stem.empty()) {
    quantity = find_whole_quantity(mechanism, stem);
    if (!quantity || (quantity->of_joints() && !quantity->member)) return std::nullopt;
    const std::vector<std::string> components = list_components(mechanism, *quantity);
    const auto component = std::find(components.begin(), components.end(), label);
    if (component == components.end()) return std::nullopt;
    quantity->component = static_cast<int>(component - components.begin());
  }
  if (quantity && (quantity->of_actuators() || quantity->of_joints()) && !has_linear_efforts(mechanism))
    return std::nullopt;
  if (!quantity || point.empty()) return quantity;
  const std::optional<model::Landmark> landmark = find_landmark(mechanism, point);
  if (!landmark || (quantity->kind != Kind::shaking_moment && quantity->kind != Kind::ground_moment))
    return std::nullopt;
  const model::BodyPoint about = locate_landmark(mechanism, *landmark);
  if (about.body != model::ground) return std::nullopt;
  quantity->about = about.position;
  return quantity;
}

std::vector<std::string> list_row_names(const Mechanism& mechanism, const AffineQuantity& quantity,
                                        const std::string& name) {
  const auto [stem, point] = results::split_moment_point(name);
  const std::string about = point.empty() ? "" : " about " + point;
  const std::vector<std::string> components =
      quantity.component ? std::vector<std::string>() : list_components(mechanism, quantity);
  std::vector<std::string> members{stem};
  if (quantity.of_actuators() && !quantity.member) {
    members.clear();
    const std::string array = quantity.kind == AffineQuantity::Kind::power ? "power" : "torque";
    for (const CoordinateId actuator : mechanism.actuators)
      members.push_back(array + "[" + mechanism.coordinates[static_cast<std::size_t>(actuator)].name + "]");
  } else if (quantity.of_joints() && !quantity.member) {
    members.clear();
    for (const Joint& joint : mechanism.joints) members.push_back(stem + "[" + joint.name + "]");
  }
  std::vector<std::string> names;
  for (std::string& member : members) {
    std::string mistake;
    if (const auto described = results::describe_quantity(mechanism, member, mistake)) member = described->name;
    if (components.size() < 2) names.push_back(member + about);
    for (std::size_t c = 0; c < components.size() && components.size() > 1; ++c)
      names.push_back(member + "[" + components[c] + "]" + about);
  }
  return names;
}

namespace {

/// Number of end points at which loose springs are sampled: the origin and one on each axis.
template <class S>
constexpr int spring_end_points = S::dimension + 1;

/// End point number i, at the distance `length` from the origin.
Vector3 end_point(int i, double length) { return i == 0 ? Vector3(Vector3::Zero()) : length * Vector3::Unit(i - 1); }

}  // namespace

template <class S>
SpringRegressor<S>::SpringRegressor(const Mechanism& mechanism, const kinematics::Tree<S>& tree,
                                    const FreeSprings& loose)
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
    spring.slack_length.reset();
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
VectorX SpringRegressor<S>::value_of(const UnitSpring& spring, const kinematics::TreeState<S>& state,
                                     const WrenchFunction& function) {
  for (auto& wrench : wrenches_) wrench = {};
  Wrench<S> total, loads;
  spring.subtract(state, nullptr, 0, wrenches_, total, loads);
  return function(wrenches_);
}

template <class S>
void SpringRegressor<S>::evaluate(const kinematics::TreeState<S>& state, const double* y, Eigen::Ref<MatrixX> torque) {
  evaluate(
      state,
      [&](std::vector<Wrench<S>>& wrenches) {
        VectorX forces(tree_.columns);
        compute_wrench_forces(tree_, state, wrenches, forces.data());
        return forces;
      },
      torque);
  constexpr Eigen::Index d = S::dimension;
  Eigen::Index column = 0;
  for (std::size_t s = 0; s < kinds_.size(); ++s) {
    if (kinds_[s] == SpringKind::in_joint) {  // k q − preload
      const kinematics::LinearQuantity& source = tree_.coordinate_expressions[mechanism_.springs[s].coordinate];
      source.add_generalised_force(source.value(y), torque.col(column).data());
      source.add_generalised_force(-1, torque.col(column + 1).data());
    }
    column += kinds_[s] == SpringKind::in_joint ? 2 : kinds_[s] == SpringKind::fixed ? 1 : 1 + 2 * d + d * d;
  }
}

template <class S>
void SpringRegressor<S>::evaluate(const kinematics::TreeState<S>& state, const WrenchFunction& function,
                                  Eigen::Ref<MatrixX> values) {
  constexpr Eigen::Index d = S::dimension;
  std::size_t unit = 0;
  Eigen::Index column = 0;
  values.setZero();
  for (const SpringKind kind : kinds_) {
    if (kind == SpringKind::in_joint) {
      column += 2;
      continue;
    }
    if (kind == SpringKind::fixed) {
      values.col(column++) = value_of(unit_springs_[unit++], state, function);
      continue;
    }
    const Eigen::Index width = 1 + 2 * d + d * d;
    loose_at(unit, state, function, values.middleCols(column, width));
    unit += spring_end_points<S> * spring_end_points<S>;
    column += width;
  }
}

/// With zero free length, the value is k T(a, b), where T is affine in each of the end points a and b (terms quadratic
/// in one end point are constant in the energy). Its coefficients are differences between unit end points.
template <class S>
void SpringRegressor<S>::loose_at(std::size_t first, const kinematics::TreeState<S>& state,
                                  const WrenchFunction& function, Eigen::Ref<MatrixX> values) {
  constexpr Eigen::Index d = S::dimension;
  MatrixX T(values.rows(), spring_end_points<S> * spring_end_points<S>);
  for (int i = 0; i < spring_end_points<S> * spring_end_points<S>; ++i)
    T.col(i) = value_of(unit_springs_[first + static_cast<std::size_t>(i)], state, function);
  const auto at = [&](Eigen::Index i, Eigen::Index j) { return T.col(i * spring_end_points<S> + j); };
  const double L = tree_.characteristic_length;
  values.col(0) = at(0, 0);
  for (Eigen::Index i = 1; i <= d; ++i) {
    values.col(i) = (at(i, 0) - at(0, 0)) / L;
    values.col(d + i) = (at(0, i) - at(0, 0)) / L;
    for (Eigen::Index j = 1; j <= d; ++j)
      values.col(2 * d + (i - 1) * d + j) = (at(i, j) - at(i, 0) - at(0, j) + at(0, 0)) / (L * L);
  }
}

template class SpringRegressor<kinematics::Planar>;
template class SpringRegressor<kinematics::Spatial>;

}  // namespace balance::dynamics
