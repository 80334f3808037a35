#include "balance/mechanics/kinematics/compiled_trajectory.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"
#include "balance/mechanics/kinematics/constraint_system.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>

namespace balance::kinematics {

using trajectory::Component;

// Whether the centre of mass moves at all, so that it can drive a mechanism.

/// Examines the velocities that the loops allow at a few configurations around y.
/// @param y closes the loops
/// @param components world components of the centre of mass to be prescribed
/// @return why they cannot be: the mechanism is force balanced, wholly or in a direction; empty if they can
template <class S>
std::string check_com_mobility(const Tree<S>& tree, const VectorX& y, const std::vector<int>& components);

extern template std::string check_com_mobility<Planar>(const Tree<Planar>&, const VectorX&, const std::vector<int>&);
extern template std::string check_com_mobility<Spatial>(const Tree<Spatial>&, const VectorX&, const std::vector<int>&);

// The equations that a trajectory's drive stands for, on a mechanism with a given number of freedoms.

/// The driven quantities and their equations.
template <class S>
struct DriveChoice {
  Drive<S> drive;
  trajectory::DriveQuantities quantities;
};

/// @param y closes the loops; in space, if the trajectory names no components, those are taken that can be followed
///        around it
template <class S>
DriveChoice<S> choose_drive(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory,
                            const VectorX& y, int freedoms);

extern template DriveChoice<Planar> choose_drive<Planar>(const Mechanism&, const Tree<Planar>&, const Trajectory&,
                                                         const VectorX&, int);
extern template DriveChoice<Spatial> choose_drive<Spatial>(const Mechanism&, const Tree<Spatial>&, const Trajectory&,
                                                           const VectorX&, int);

namespace {

/// Displacement of the centre of mass, relative to that of the masses, up to which it counts as stationary. Below it
/// the equations count as singular anyway (singular_pivot_threshold), and designs rounded to a few digits stay below
/// it.
constexpr double static_com_tolerance = 1e-5;

constexpr const char* drive_hint = "; use drive tool or joints";

/// Rates of the centre of mass per unit of each freedom, relative to their size if the terms did not cancel.
template <class S>
class ScaledComJacobian {
 public:
  explicit ScaledComJacobian(const Tree<S>& tree) : tree_(tree), masses_(tree), state_(tree.nodes.size()) {}

  /// @param freedoms null space of the scaled closures, columns × freedoms
  MatrixX at(const VectorX& y, const MatrixX& freedoms) {
    compute_poses(tree_, y.data(), state_);
    masses_.update(tree_, state_);
    MatrixX gradient = MatrixX::Zero(S::dimension, tree_.columns);
    VectorX magnitude = VectorX::Zero(tree_.columns);
    for (std::size_t k = 1; k < tree_.nodes.size(); ++k) {
      const Node<S>& node = tree_.nodes[k];
      const int n = static_cast<int>(k);
      if (node.motion == NodeMotion::weld) continue;
      const double unit = tree_.is_length_column[node.column] ? tree_.characteristic_length : 1;
      gradient.col(node.column) += unit * masses_.com_gradient(node, state_[k], n);
      magnitude[node.column] += unit * std::abs(node.ratio) * mass_weighted_arm(n);
    }
    MatrixX rates = gradient * freedoms;
    const VectorX scale = freedoms.cwiseAbs().transpose() * magnitude;
    for (Eigen::Index f = 0; f < rates.cols(); ++f)
      rates.col(f) = scale[f] > 0 ? VectorX(rates.col(f) / scale[f]) : VectorX(VectorX::Zero(S::dimension));
    return rates;
  }

 private:
  /// Σ m |velocity of the carried mass| / Σ m, per unit rotation or displacement of a node.
  double mass_weighted_arm(NodeId moving) const {
    double sum = 0;
    for (std::size_t k = 1; k < tree_.nodes.size(); ++k) {
      if (!is_descendant_of(static_cast<int>(k), moving)) continue;
      const auto& inertia = tree_.nodes[k].inertia;
      sum += tree_.nodes[moving].motion == NodeMotion::prismatic
                 ? std::abs(inertia.mass)
                 : inertia.first_moment.norm() + std::abs(inertia.mass) * (state_[k].p_WN - state_[moving].p_WN).norm();
    }
    return sum / tree_.mass;
  }

  bool is_descendant_of(NodeId node, NodeId moving) const {
    while (node > moving) node = tree_.nodes[node].parent;
    return node == moving;
  }

  const Tree<S>& tree_;
  MassDistribution<S> masses_;
  TreeState<S> state_;
};

bool has_full_row_rank(const MatrixX& rates) {
  if (rates.cols() < rates.rows()) return false;
  return numerics::singular_values(rates)[rates.rows() - 1] > static_com_tolerance;
}

std::string direction_text(const std::vector<int>& components, VectorX direction) {
  const Eigen::Index dominant = numerics::max_index(direction.cwiseAbs());
  if (std::abs(direction[dominant]) > 1 - 1e-9)
    return std::string(1, "xyz"[components[static_cast<std::size_t>(dominant)]]);
  direction *= direction[dominant] > 0 ? 1 : -1;
  Vector3 vector = Vector3::Zero();
  for (Eigen::Index k = 0; k < direction.size(); ++k) vector[components[static_cast<std::size_t>(k)]] = direction[k];
  char text[80];
  std::snprintf(text, sizeof text, "[%.4g, %.4g, %.4g]", vector[0], vector[1], vector[2]);
  return text;
}

}  // namespace

template <class S>
std::string check_com_mobility(const Tree<S>& tree, const VectorX& y, const std::vector<int>& components) {
  if (components.empty() || tree.columns == 0) return "";
  ConstraintSystem<S> closures(tree, Drive<S>{});
  const VectorX scale = column_scale(tree);
  ScaledComJacobian<S> com(tree);
  const auto select_components = [&](const MatrixX& rates) {
    MatrixX rows(static_cast<Eigen::Index>(components.size()), rates.cols());
    for (Eigen::Index k = 0; k < rows.rows(); ++k) rows.row(k) = rates.row(components[static_cast<std::size_t>(k)]);
    return rows;
  };
  MatrixX rates(S::dimension, 0), jacobian;
  bool has_independent_rates = false;
  VectorX current_y = y;
  const int generic_rank = find_generic_closure_rank(tree, y);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    closures.velocity_jacobian(current_y, {}, jacobian);
    const RankDecomposition loops = decompose_rank(jacobian);
    if (loops.null_space.cols() == 0) break;
    if (loops.rank == generic_rank) {  // elsewhere the null space is larger than the possible motions
      const MatrixX com_rates = com.at(current_y, loops.null_space);
      rates.conservativeResize(Eigen::NoChange, rates.cols() + com_rates.cols());
      rates.rightCols(com_rates.cols()) = com_rates;
      has_independent_rates = has_independent_rates || has_full_row_rank(select_components(com_rates));
    }
    const VectorX random = random_coordinates(tree, seed).cwiseQuotient(scale);
    const VectorX direction = loops.null_space * (loops.null_space.transpose() * random);
    const AssemblySolution neighbour = solve_assembly(
        closures, current_y + scale.cwiseProduct(0.2 / std::max(1e-12, direction.norm()) * direction), {});
    if (neighbour.found) current_y = neighbour.y;
  }
  if (rates.cols() == 0) return "";
  if (numerics::max_abs(rates) <= static_com_tolerance)
    return std::string("the mechanism is force balanced: its centre of mass stands still and cannot drive it") +
           drive_hint;
  if (has_independent_rates) return "";
  if (has_full_row_rank(select_components(rates)))
    return std::string(
               "the centre of mass moves in fewer independent directions than are prescribed and cannot drive the "
               "mechanism") +
           drive_hint;
  const numerics::SingularValueDecomposition directions(select_components(rates), Eigen::ComputeFullU);
  return "the mechanism is force balanced along " + direction_text(components, directions.matrixU().rightCols<1>()) +
         ": its centre of mass does not move in that direction and cannot drive it" + drive_hint;
}

template std::string check_com_mobility<Planar>(const Tree<Planar>&, const VectorX&, const std::vector<int>&);
template std::string check_com_mobility<Spatial>(const Tree<Spatial>&, const VectorX&, const std::vector<int>&);

namespace {

template <class S>
DriveChoice<S> make_drive_choice(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory,
                                 int freedoms) {
  DriveChoice<S> choice;
  choice.quantities = choose_drive_quantities(mechanism, trajectory, freedoms);
  choice.drive = make_drive(mechanism, tree, choice.quantities);
  return choice;
}

/// Rates of the drive's quantities per unit of each velocity that the loops allow.
MatrixX compute_reduced_drive_jacobian(const Tree<Spatial>& tree, const Drive<Spatial>& drive, const VectorX& y,
                                       const MatrixX& null_space) {
  ConstraintSystem<Spatial> system(tree, drive);
  trajectory::DriveSample target;
  target.value.setZero(drive.value_count());
  VectorX residual;
  MatrixX jacobian;
  system.evaluate(y, target, residual, jacobian);  // measure() refers to the configuration last evaluated
  system.evaluate(y, system.measure(y), residual, jacobian);
  return jacobian.bottomRows(drive.row_count()) * null_space;
}

bool has_independent_rows(const MatrixX& rates) {
  constexpr double min_independent_rate = 1e-6;  // in characteristic lengths or radians per unit of all coordinates
  if (rates.rows() == 0 || rates.rows() > rates.cols()) return rates.rows() == 0;
  return numerics::singular_values(rates)[rates.rows() - 1] > min_independent_rate;
}

/// The first components, positions before rotations, that the tool or the centre of mass can follow together with the
/// remaining coordinates.
/// @return `count` components; empty if there are fewer
std::vector<Component> select_drivable_components(const Mechanism& mechanism, const Tree<Spatial>& tree,
                                                  Trajectory trajectory, const VectorX& y, const MatrixX& null_space,
                                                  int count) {
  std::vector<Component> chosen;
  for (const Component component :
       {Component::x, Component::y, Component::z, Component::rx, Component::ry, Component::rz}) {
    if (static_cast<int>(chosen.size()) == count || (component > Component::z && !mechanism.tool)) break;
    chosen.push_back(component);
    trajectory.components = chosen;
    const Drive<Spatial> drive = make_drive_choice(mechanism, tree, trajectory, 0).drive;
    if (!has_independent_rows(compute_reduced_drive_jacobian(tree, drive, y, null_space))) chosen.pop_back();
  }
  if (static_cast<int>(chosen.size()) < count) chosen.clear();
  return chosen;
}

/// The default components of a tool or a centre of mass in space are those of its position. If it cannot move along one
/// of them, as in a planar linkage modelled in space, others are chosen.
Trajectory complete_components(const Mechanism& mechanism, const Tree<Spatial>& tree, Trajectory trajectory,
                               const VectorX& y, int freedoms) {
  if (trajectory.drive == DriveKind::joints || !trajectory.components.empty() ||
      std::holds_alternative<trajectory::TablePath>(trajectory.path))  // a table has columns for the default ones
    return trajectory;
  const DriveChoice<Spatial> default_choice = make_drive_choice(mechanism, tree, trajectory, freedoms);
  if (!default_choice.quantities.mismatch.empty()) return trajectory;
  ConstraintSystem<Spatial> closures(tree, Drive<Spatial>{});
  const VectorX scale = column_scale(tree);
  const int component_count = freedoms - count_remaining_quantities(trajectory);
  std::vector<Component> chosen_components;
  VectorX current_y = y;
  MatrixX jacobian;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    closures.velocity_jacobian(current_y, {}, jacobian);
    const RankDecomposition loops = decompose_rank(jacobian);
    if (loops.null_space.cols() == freedoms) {  // elsewhere it is larger than the possible motions
      if (has_independent_rows(compute_reduced_drive_jacobian(tree, default_choice.drive, current_y, loops.null_space)))
        return trajectory;
      const auto drivable =
          select_drivable_components(mechanism, tree, trajectory, current_y, loops.null_space, component_count);
      if (chosen_components.empty()) chosen_components = drivable;
    }
    const VectorX random = random_coordinates(tree, seed).cwiseQuotient(scale);
    const VectorX direction = loops.null_space * (loops.null_space.transpose() * random);
    const AssemblySolution neighbour = solve_assembly(
        closures, current_y + scale.cwiseProduct(0.2 / std::max(1e-12, direction.norm()) * direction), {});
    if (neighbour.found) current_y = neighbour.y;
  }
  trajectory.components = chosen_components;
  return trajectory;
}

}  // namespace

template <class S>
DriveChoice<S> choose_drive(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory,
                            const VectorX& y, int freedoms) {
  if constexpr (std::is_same_v<S, Spatial>)
    return make_drive_choice(mechanism, tree, complete_components(mechanism, tree, trajectory, y, freedoms), freedoms);
  else
    return make_drive_choice(mechanism, tree, trajectory, freedoms);
}

template DriveChoice<Planar> choose_drive<Planar>(const Mechanism&, const Tree<Planar>&, const Trajectory&,
                                                  const VectorX&, int);
template DriveChoice<Spatial> choose_drive<Spatial>(const Mechanism&, const Tree<Spatial>&, const Trajectory&,
                                                    const VectorX&, int);

namespace {

MotionOutcome make_failure(MotionStatus status, std::string reason) { return {status, 0, std::move(reason), {}}; }

template <class S>
class TrajectoryCompiler {
 public:
  TrajectoryCompiler(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory)
      : mechanism_(mechanism), tree_(tree), trajectory_(trajectory) {}

  CompiledTrajectory<S> run() {
    if (check_com() && start_pose() && choose_drive() && find_end_values() && compile_prescribed_motion())
      plan_.outcome.status = MotionStatus::done;
    return std::move(plan_);
  }

 private:
  bool fail(const MotionOutcome& outcome) {
    plan_.outcome = outcome;
    return false;
  }

  /// Checked before the search for a start pose, which would fail if the centre of mass is stationary.
  bool check_com() {
    if (trajectory_.drive != DriveKind::com) return true;
    ConstraintSystem<S> closures(tree_, Drive<S>{});
    const AssemblySolution assembled = solve_pose(mechanism_, tree_, closures, {});
    if (!assembled.found) return true;
    const int freedoms = tree_.columns - find_generic_closure_rank(tree_, assembled.y);
    const trajectory::DriveQuantities quantities =
        kinematics::choose_drive(mechanism_, tree_, trajectory_, assembled.y, freedoms).quantities;
    if (!quantities.mismatch.empty()) return true;
    const std::string reason = check_com_mobility(tree_, assembled.y, quantities.com);
    return reason.empty() || fail(make_failure(MotionStatus::mismatch, reason));
  }

  bool start_pose() {
    const PoseEquations<S> from = make_pose_equations(mechanism_, tree_, trajectory_.from);
    ConstraintSystem<S> system(tree_, from.drive);
    const AssemblySolution start = solve_pose(mechanism_, tree_, system, from.target);
    if (!start.found) return fail(explain_assembly_failure(mechanism_, tree_, start, trajectory_.from));
    plan_.start = start.y;
    const int rank = find_generic_closure_rank(tree_, start.y);
    plan_.freedoms = tree_.columns - rank;
    plan_.has_redundant_closures = tree_.closure_rows > rank;
    configuration_freedoms_ = tree_.columns - find_generic_position_rank(tree_, start.y);
    if (from.drive.row_count() < plan_.freedoms && !std::holds_alternative<trajectory::TablePath>(trajectory_.path))
      return fail(make_failure(MotionStatus::mismatch,
                               "the start pose (from) states " + count_noun(from.drive.row_count(), "value", "values") +
                                   ", but the mechanism has " + count_noun(plan_.freedoms, "degree", "degrees") +
                                   " of freedom"));
    return true;
  }

  bool choose_drive() {
    choice_ = kinematics::choose_drive(mechanism_, tree_, trajectory_, plan_.start, plan_.freedoms);
    const std::string& mismatch = choice_.quantities.mismatch;
    if (!mismatch.empty()) return fail(make_failure(MotionStatus::mismatch, mismatch));
    plan_.drive = choice_.drive;
    plan_.quantities = choice_.quantities;
    return true;
  }

  trajectory::DriveValue measure_drive_at(const VectorX& y) const {
    ConstraintSystem<S> system(tree_, choice_.drive);
    VectorX residual;
    numerics::SparseMatrix jacobian;
    trajectory::DriveSample zero;
    zero.value.setZero(choice_.drive.value_count());
    system.evaluate(y, zero, residual, jacobian);
    const trajectory::DriveSample sample = system.measure(y);
    return {sample.value, sample.rotation};
  }

  bool find_end_values() {
    plan_.request.from = read_pose_values(choice_.quantities, trajectory_.from, measure_drive_at(plan_.start));
    plan_.request.to = plan_.request.from;
    if (is_end_prescribed(choice_.quantities, trajectory_)) {
      plan_.request.to = read_pose_values(choice_.quantities, trajectory_.to, plan_.request.from);
      return true;
    }
    if (configuration_freedoms_ > plan_.freedoms)
      return fail(make_failure(MotionStatus::mismatch,
                               "the end pose (to) must state the driven quantities: with constraints on speeds, all "
                               "others depend on the path"));
    // `to` is stated in quantities other than the driven ones: track to it and measure them there
    const PoseEquations<S> to = make_pose_equations(mechanism_, tree_, trajectory_.to);
    ConstraintSystem<S> system(tree_, to.drive);
    VectorX residual;
    numerics::SparseMatrix jacobian;
    system.evaluate(plan_.start, to.target, residual, jacobian);
    const AssemblySolution end = track_to(system, plan_.start, system.measure(plan_.start), to.target);
    if (!end.found)
      return fail({MotionStatus::unreachable,
                   trajectory_.duration,
                   "the end pose (to) cannot be reached from the start pose without leaving the assembly mode",
                   {}});
    plan_.request.to = measure_drive_at(end.y);
    plan_.end = end.y;
    return true;
  }

  bool compile_prescribed_motion() {
    plan_.request =
        make_prescribed_motion_request(trajectory_, choice_.quantities, plan_.request.from, plan_.request.to);
    const std::vector<double> payload_times = payload_switch_times(mechanism_);
    plan_.request.switch_times.insert(plan_.request.switch_times.end(), payload_times.begin(), payload_times.end());
    plan_.prescribed_motion.emplace(plan_.request);
    trajectory::DriveSample first_sample;
    plan_.prescribed_motion->at(0, trajectory::Side::after, first_sample);
    ConstraintSystem<S> system(tree_, choice_.drive);
    AssemblySolution start = solve_assembly(system, plan_.start, first_sample);
    if (!start.found && std::holds_alternative<trajectory::TablePath>(trajectory_.path))
      start = solve_pose(mechanism_, tree_, system, first_sample);
    if (!start.found)
      return fail(
          make_failure(MotionStatus::unreachable, "the first prescribed values cannot be reached from the start pose"));
    plan_.start = start.y;
    return true;
  }

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  const Trajectory& trajectory_;
  CompiledTrajectory<S> plan_;
  int configuration_freedoms_ = 0;  ///< freedoms of the configuration: more than those of the rates if something rolls
  DriveChoice<S> choice_;
};

}  // namespace

template <class S>
CompiledTrajectory<S> compile_trajectory(const Mechanism& mechanism, const Tree<S>& tree,
                                         const Trajectory& trajectory) {
  if (!trajectory.adaptations.empty())
    throw std::invalid_argument("the counterweights that trajectory '" + trajectory.name +
                                "' moves are not modelled here (model_adaptations)");
  if (trajectory.free_motion)
    throw std::invalid_argument("the trajectory '" + trajectory.name +
                                "' leaves coordinates free: only runs with prescribed motion ('simulate') find their "
                                "motion");
  return TrajectoryCompiler<S>(mechanism, tree, trajectory).run();
}

template CompiledTrajectory<Planar> compile_trajectory<Planar>(const Mechanism&, const Tree<Planar>&,
                                                               const Trajectory&);
template CompiledTrajectory<Spatial> compile_trajectory<Spatial>(const Mechanism&, const Tree<Spatial>&,
                                                                 const Trajectory&);

}  // namespace balance::kinematics
