#include "balance/mechanics/kinematics/assembly.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/random.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <string>

namespace balance::kinematics {

using trajectory::DriveSample;

namespace {

/// done; mismatch if the pose states too few values; drive_singularity if what it states does not determine the
/// configuration.
MotionOutcome check_pose_determinacy(int free_count, int stated_count, int freedoms) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (free_count == 0) return outcome;
  if (stated_count < freedoms) {
    outcome.status = MotionStatus::mismatch;
    outcome.reason = "the pose is incomplete: it states " + std::to_string(stated_count) + " of the " +
                     std::to_string(freedoms) + " numbers that determine the mechanism's configuration";
  } else {
    outcome.status = MotionStatus::drive_singularity;
    outcome.reason = "the pose does not determine the configuration: it leaves " + std::to_string(free_count) + " of " +
                     std::to_string(freedoms) + " degrees of freedom open there";
  }
  return outcome;
}

template <class S>
ConfigurationResult solve_configuration_in(const Mechanism& mechanism, const trajectory::PoseTarget& pose) {
  std::vector<CoordinateId> needed;
  for (const CoordinateValue& value : pose.joints) needed.push_back(value.coordinate);
  const Tree<S> tree = compile_tree<S>(mechanism, needed);
  const PoseEquations<S> pose_equations = make_pose_equations(mechanism, tree, pose);
  ConstraintSystem<S> system(tree, pose_equations.drive);
  const AssemblySolution solution = solve_pose(mechanism, tree, system, pose_equations.target);
  ConfigurationResult result;
  if (!solution.found) {
    result.outcome = explain_assembly_failure(mechanism, tree, solution, pose);
    return result;
  }
  VectorX residual;
  MatrixX jacobian;
  system.evaluate(solution.y, pose_equations.target, residual, jacobian);
  const int freedoms = tree.columns - find_generic_position_rank(tree, solution.y);
  const int free_count = jacobian.rows() == 0 ? tree.columns : tree.columns - decompose_rank(jacobian).rank;
  result.outcome = check_pose_determinacy(free_count, pose_equations.drive.row_count(), freedoms);
  const std::vector<double> coordinates = compute_coordinates(mechanism, tree, solution.y);
  for (std::size_t c = 0; c < coordinates.size(); ++c)
    result.coordinates.push_back({static_cast<int>(c), coordinates[c]});
  // stated coordinates keep their full turns
  for (const CoordinateValue& value : pose.joints)
    result.coordinates[static_cast<std::size_t>(value.coordinate)].value = value.value;
  return result;
}

}  // namespace

trajectory::PoseTarget actuators_as_assembled(const Mechanism& mechanism) {
  trajectory::PoseTarget pose;
  for (const CoordinateId actuator : mechanism.actuators) {
    double value = 0;
    for (const CoordinateValue& assembled : mechanism.assembly)
      if (assembled.coordinate == actuator) value = assembled.value;
    pose.joints.push_back({actuator, value});
  }
  return pose;
}

ConfigurationResult solve_configuration(const Mechanism& mechanism, const trajectory::PoseTarget& pose) {
  return dispatch_space(mechanism.space, [&]<class S>(S) { return solve_configuration_in<S>(mechanism, pose); });
}

namespace {

constexpr double mode_distance_tolerance = 1e-4;  // radians or characteristic lengths
constexpr int max_mode_iterations = 60;
constexpr std::uint64_t first_mode_seed = 1000;  // the first seeds belong to the search for the selected mode

/// @param scale unit of magnitude: one radian or the characteristic length
/// @param unit of the spec, in SI
std::string rounded_value_text(double value, double scale, double unit) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", std::abs(value) < 1e-6 * scale ? 0.0 : value / unit);
  return text;
}

template <class S>
bool is_given_by_pose(const Tree<S>& tree, const Drive<S>& drive, CoordinateId coordinate) {
  const LinearQuantity& source = tree.coordinate_expressions[coordinate];
  return std::any_of(drive.linear.begin(), drive.linear.end(), [&](const LinearQuantity& quantity) {
    return quantity.has_single_term() && source.has_single_term() && quantity.terms[0].first == source.terms[0].first;
  });
}

bool is_follower(const Mechanism& mechanism, CoordinateId coordinate) {
  return std::any_of(mechanism.couplings.begin(), mechanism.couplings.end(),
                     [&](const Coupling& coupling) { return coupling.follower == coordinate; });
}

}  // namespace

template <class S>
AssemblyModes<S>::AssemblyModes(const Mechanism& mechanism, const Tree<S>& tree, ConstraintSystem<S>& system,
                                const DriveSample& target, const VectorX& selected)
    : mechanism_(mechanism),
      tree_(tree),
      system_(system),
      target_(target),
      modes_{compute_coordinates(mechanism, tree, selected)} {}

template <class S>
long AssemblyModes<S>::search_from(std::uint64_t start) {
  const AssemblySolution solution =
      solve_assembly(system_, random_coordinates(tree_, first_mode_seed + start), target_, max_mode_iterations);
  if (solution.found) {
    std::vector<double> mode = compute_coordinates(mechanism_, tree_, solution.y);
    if (std::none_of(modes_.begin(), modes_.end(), [&](const auto& known) { return is_same_mode(known, mode); }))
      modes_.push_back(std::move(mode));
  }
  return static_cast<long>(solution.iterations) * tree_.columns;
}

template <class S>
bool AssemblyModes<S>::is_same_mode(const std::vector<double>& a, const std::vector<double>& b) const {
  for (std::size_t c = 0; c < a.size(); ++c) {
    const bool is_angle = mechanism_.coordinates[c].kind == CoordinateKind::angle;
    const double deviation = is_angle ? unwrap_angle(a[c], b[c]) - b[c] : (a[c] - b[c]) / tree_.characteristic_length;
    if (std::abs(deviation) > mode_distance_tolerance) return false;
  }
  return true;
}

template <class S>
std::string format_assembly_line(const Mechanism& mechanism, const Tree<S>& tree, const Drive<S>& drive,
                                 const std::vector<double>& mode) {
  std::string line;
  for (std::size_t c = 0; c < mode.size(); ++c) {
    const auto coordinate = static_cast<int>(c);
    if (!tree.coordinate_expressions[c].has_terms() || is_given_by_pose(tree, drive, coordinate) ||
        is_follower(mechanism, coordinate))
      continue;
    const bool is_length = mechanism.coordinates[c].kind == CoordinateKind::length;
    line += (line.empty() ? "" : ", ") + mechanism.coordinates[c].name + ": " +
            rounded_value_text(mode[c], is_length ? tree.characteristic_length : 1,
                               is_length ? mechanism.units.length : mechanism.units.angle);
  }
  return "assembly: {" + line + "}";
}

#define BALANCE_DEFINE(S)                                                                         \
  template class AssemblyModes<S>;                                                                \
  template std::string format_assembly_line<S>(const Mechanism&, const Tree<S>&, const Drive<S>&, \
                                               const std::vector<double>&);
BALANCE_DEFINE(Planar)
BALANCE_DEFINE(Spatial)
#undef BALANCE_DEFINE

template <class S>
VectorX column_scale(const Tree<S>& tree) {
  VectorX scale = VectorX::Ones(tree.columns);
  for (int c = 0; c < tree.columns; ++c)
    if (tree.is_length_column[c]) scale[c] = tree.characteristic_length;
  return scale;
}

namespace {

/// The minimum-norm least-squares solution of J x = r.
VectorX solve_least_norm_step(const MatrixX& jacobian, const VectorX& residual) {
  numerics::CompleteOrthogonalDecomposition qr;
  qr.setThreshold(1e-9);
  qr.compute(jacobian);
  return qr.solve(residual);
}

/// The second solve corrects the error due to the damping; in an iteration, so do the next steps.
VectorX solve_least_norm_step(const numerics::SparseMatrix& jacobian, const VectorX& residual) {
  const double shift = 1e-12 * jacobian.squaredNorm() / static_cast<double>(jacobian.cols());
  const VectorX first = numerics::solve_damped_least_squares(jacobian, residual, shift);
  return first + numerics::solve_damped_least_squares(jacobian, residual - jacobian * first, shift);
}

/// Final phase with quadratic convergence: minimum-norm Newton steps as long as they reduce the residual.
template <class Matrix, class S>
void polish_by_newton(ConstraintSystem<S>& system, const VectorX& scale, const DriveSample& target,
                      AssemblySolution& solution) {
  VectorX residual, trial;
  Matrix jacobian;
  system.evaluate(solution.y, target, residual, jacobian);
  for (int k = 0; k < 8 && residual.size() > 0; ++k) {
    const double previous_norm = residual.template lpNorm<Eigen::Infinity>();
    solution.residual = previous_norm;
    if (previous_norm < 1e-15) break;
    trial = solution.y - scale.cwiseProduct(solve_least_norm_step(jacobian, residual));
    system.evaluate(trial, target, residual, jacobian);
    if (!(residual.template lpNorm<Eigen::Infinity>() < previous_norm)) break;
    solution.y = trial;
    solution.residual = residual.template lpNorm<Eigen::Infinity>();
  }
  system.evaluate(solution.y, target, residual, jacobian);
}

/// Levenberg–Marquardt steps of any damping from one configuration.
class DampedNormalEquations {
 public:
  DampedNormalEquations(const MatrixX& jacobian, const VectorX& residual)
      : normal_(jacobian.transpose() * jacobian),
        gradient_(jacobian.transpose() * residual),
        max_diagonal_(numerics::max_coefficient(normal_.diagonal())) {}
  VectorX step(double damping) const {
    MatrixX damped = normal_;
    damped.diagonal().array() += damping * std::max(1e-6, max_diagonal_);
    return damped.ldlt().solve(gradient_);
  }

 private:
  MatrixX normal_;
  VectorX gradient_;
  double max_diagonal_;
};

class SparseDampedNormalEquations {
 public:
  SparseDampedNormalEquations(const numerics::SparseMatrix& jacobian, const VectorX& residual)
      : jacobian_(jacobian), residual_(residual) {
    for (Eigen::Index c = 0; c < jacobian.cols(); ++c)
      max_diagonal_ = std::max(max_diagonal_, jacobian.col(c).squaredNorm());
  }
  VectorX step(double damping) const {
    return numerics::solve_damped_least_squares(jacobian_, residual_, damping * std::max(1e-6, max_diagonal_));
  }

 private:
  const numerics::SparseMatrix& jacobian_;
  const VectorX& residual_;
  double max_diagonal_ = 0;
};

template <class Matrix, class NormalEquations, class S>
AssemblySolution search_levenberg_marquardt(ConstraintSystem<S>& system, const VectorX& guess,
                                            const DriveSample& target, int iterations) {
  AssemblySolution solution;
  solution.y = guess;
  const VectorX scale = column_scale(system.tree());
  VectorX residual, trial_residual;
  Matrix jacobian, trial_jacobian;
  system.evaluate(solution.y, target, residual, jacobian);
  double cost = residual.squaredNorm(), damping = 1e-3;
  for (; solution.iterations < iterations && cost > 1e-18; ++solution.iterations) {
    const NormalEquations normal_equations(jacobian, residual);
    bool is_improved = false;
    for (int attempt = 0; attempt < 12 && !is_improved; ++attempt) {
      VectorX step = normal_equations.step(damping);
      const double max_component = step.template lpNorm<Eigen::Infinity>();
      if (max_component > 1) step /= max_component;  // no more than one radian or one characteristic length at a time
      const VectorX trial = solution.y - scale.cwiseProduct(step);
      system.evaluate(trial, target, trial_residual, trial_jacobian);
      const double trial_cost = trial_residual.squaredNorm();
      is_improved = trial_cost < cost;
      if (is_improved) {
        const bool is_stagnant = cost - trial_cost < 1e-10 * cost;
        solution.y = trial, cost = trial_cost;
        residual.swap(trial_residual), jacobian.swap(trial_jacobian);
        damping = std::max(1e-12, damping / 5);
        if (is_stagnant) is_improved = false, attempt = 12;
      } else {
        damping *= 4;
      }
    }
    if (!is_improved) break;
  }
  solution.residual = residual.size() > 0 ? residual.template lpNorm<Eigen::Infinity>() : 0;
  if (solution.residual < 1e-4) polish_by_newton<Matrix>(system, scale, target, solution);
  solution.found = solution.residual < closure_tolerance && system.is_aligned();
  return solution;
}

}  // namespace

template <class S>
AssemblySolution solve_assembly(ConstraintSystem<S>& system, const VectorX& guess, const DriveSample& target,
                                int iterations) {
  return system.columns() > numerics::max_dense_columns
             ? search_levenberg_marquardt<numerics::SparseMatrix, SparseDampedNormalEquations>(system, guess, target,
                                                                                               iterations)
             : search_levenberg_marquardt<MatrixX, DampedNormalEquations>(system, guess, target, iterations);
}

template <class S>
VectorX random_coordinates(const Tree<S>& tree, std::uint64_t seed) {
  numerics::UniformRandom random(seed);
  VectorX y(tree.columns);
  for (int c = 0; c < tree.columns; ++c)
    y[c] = random(-1, 1) * (tree.is_length_column[c] ? tree.characteristic_length : std::numbers::pi);
  return y;
}

RankDecomposition decompose_rank(const MatrixX& jacobian, double tolerance) {
  RankDecomposition decomposition;
  const Eigen::Index columns = jacobian.cols();
  if (jacobian.rows() == 0 || columns == 0) {
    decomposition.null_space = MatrixX::Identity(columns, columns);
    return decomposition;
  }
  const numerics::SingularValueDecomposition svd(jacobian, Eigen::ComputeFullV);
  const VectorX& values = svd.singularValues();
  const double max_singular_value = values[0];
  while (decomposition.rank < values.size() && values[decomposition.rank] > tolerance * max_singular_value &&
         max_singular_value > 0)
    ++decomposition.rank;
  decomposition.null_space = svd.matrixV().rightCols(columns - decomposition.rank);
  return decomposition;
}

namespace {

/// Whether the rank is proven to be full: no singular value is anywhere near the tolerance of decompose_rank().
template <class S>
bool has_proven_full_rank(ConstraintSystem<S>& closures, const VectorX& y) {
  VectorX residual;
  numerics::SparseMatrix jacobian;
  closures.evaluate(y, {}, residual, jacobian);
  return numerics::min_singular_value(jacobian).has_value();
}

/// @param with_velocity_rows whether the rows of velocity-level closures count, too
template <class S>
int find_generic_rank(const Tree<S>& tree, const VectorX& y, bool with_velocity_rows) {
  ConstraintSystem<S> closures(tree, Drive<S>{});
  const int rows = with_velocity_rows ? closures.closure_rows() : closures.place_rows(),
            full_rank = std::min(rows, closures.columns());
  if (full_rank == 0 ||
      (full_rank > numerics::max_dense_columns && rows == closures.place_rows() && has_proven_full_rank(closures, y)))
    return full_rank;
  const VectorX scale = column_scale(tree);
  VectorX current_y = y;
  MatrixX jacobian;
  closures.velocity_jacobian(current_y, {}, jacobian);
  RankDecomposition decomposition = decompose_rank(jacobian.topRows(rows));
  int generic_rank = decomposition.rank;
  for (std::uint64_t seed = 1; seed <= 4 && generic_rank < full_rank && decomposition.null_space.cols() > 0; ++seed) {
    const VectorX random = random_coordinates(tree, seed).cwiseQuotient(scale);
    VectorX direction = decomposition.null_space * (decomposition.null_space.transpose() * random);
    if (direction.norm() < 1e-12) break;
    direction *= 0.15 / direction.norm();
    const AssemblySolution neighbour = solve_assembly(closures, current_y + scale.cwiseProduct(direction), {});
    if (!neighbour.found || (neighbour.y - current_y).cwiseQuotient(scale).norm() < 1e-6) continue;
    current_y = neighbour.y;
    closures.velocity_jacobian(current_y, {}, jacobian);
    decomposition = decompose_rank(jacobian.topRows(rows));
    generic_rank = std::max(generic_rank, decomposition.rank);
  }
  return generic_rank;
}

}  // namespace

template <class S>
int find_generic_closure_rank(const Tree<S>& tree, const VectorX& y) {
  return find_generic_rank(tree, y, true);
}

template <class S>
int find_generic_position_rank(const Tree<S>& tree, const VectorX& y) {
  return find_generic_rank(tree, y, false);
}

template <class S>
AssemblySolution track_to(ConstraintSystem<S>& system, const VectorX& y, const DriveSample& from,
                          const DriveSample& to) {
  AssemblySolution current{true, y, 0, 0};
  const Vector3 rotation = rotation_vector_of(to.rotation * from.rotation.transpose());
  const VectorX scale = column_scale(system.tree());
  double fraction = 0, step = 1.0 / 32;
  VectorX tangent = VectorX::Zero(y.size());
  while (fraction < 1) {
    const double next_fraction = std::min(1.0, fraction + step);
    DriveSample target;
    target.value = (1 - next_fraction) * from.value + next_fraction * to.value;
    target.rotation = next_fraction == 1
                          ? to.rotation
                          : Matrix3(rotation_from_rotation_vector(next_fraction * rotation) * from.rotation);
    const AssemblySolution trial = solve_assembly(system, current.y + (next_fraction - fraction) * tangent, target, 30);
    const double change = (trial.y - current.y).cwiseQuotient(scale).template lpNorm<Eigen::Infinity>();
    if (trial.found && change < 0.5) {
      tangent = (trial.y - current.y) / (next_fraction - fraction);
      current = trial;
      fraction = next_fraction;
      step = std::min(2 * step, 1.0 / 16);
    } else {
      step /= 2;
      tangent.setZero();
      if (step < 1e-6) return {false, current.y, trial.residual, 0};
    }
  }
  return current;
}

#define BALANCE_INSTANTIATE(S)                                                                                \
  template VectorX column_scale<S>(const Tree<S>&);                                                           \
  template AssemblySolution solve_assembly<S>(ConstraintSystem<S>&, const VectorX&, const DriveSample&, int); \
  template VectorX random_coordinates<S>(const Tree<S>&, std::uint64_t);                                      \
  template int find_generic_closure_rank<S>(const Tree<S>&, const VectorX&);                                  \
  template int find_generic_position_rank<S>(const Tree<S>&, const VectorX&);                                 \
  template AssemblySolution track_to<S>(ConstraintSystem<S>&, const VectorX&, const DriveSample&, const DriveSample&);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

template <class S>
void reset_spherical_reference(Tree<S>& tree, NodeId spherical, typename S::Scalar* y) {
  Matrix3 total_rotation = Matrix3::Identity(), fixed = Matrix3::Identity();
  for (int n = spherical; n < spherical + 3; ++n) {
    const Node<S>& node = tree.nodes[n];
    const bool is_revolute = node.motion == NodeMotion::revolute;  // the last one of a locked joint is not
    const double x = is_revolute ? node.ratio * y[node.column] + node.offset : 0;
    total_rotation *= to_matrix(rotate_about_joint_axis(node.R_PF, elementary::cos(x), elementary::sin(x)));
    if (n > spherical) fixed *= to_matrix(node.R_PF);
    if (is_revolute) y[node.column] = -node.offset / node.ratio;
  }
  // products of rotations drift off the rotation group: take the nearest rotation
  const Eigen::Quaterniond nearest = Eigen::Quaterniond(Matrix3(total_rotation * fixed.transpose())).normalized();
  tree.nodes[spherical].R_PF = to_rotation<S>(nearest.toRotationMatrix());
}

template void reset_spherical_reference<Planar>(Tree<Planar>&, NodeId, double*);
template void reset_spherical_reference<Spatial>(Tree<Spatial>&, NodeId, double*);

template <class S>
std::string format_configuration(const Mechanism& mechanism, const Tree<S>& tree, const double* y) {
  constexpr std::size_t max_listed_coordinates = 12;  // keeps the sentence readable
  std::string out;
  for (std::size_t c = 0; c < tree.coordinate_expressions.size() && c < max_listed_coordinates; ++c) {
    const LinearQuantity& source = tree.coordinate_expressions[c];
    if (!source.has_terms() || tree.is_floating[c]) continue;
    const double value = source.value(y);
    const auto coordinate = static_cast<int>(c);
    const double round_off =
        model::pose_round_off * (is_length_coordinate(mechanism, coordinate) ? tree.characteristic_length : 1);
    out += (out.empty() ? "" : ", ") + mechanism.coordinates[c].name + " " +
           format_coordinate(mechanism, coordinate, value, round_off);
  }
  return out;
}

template std::string format_configuration<Planar>(const Mechanism&, const Tree<Planar>&, const double*);
template std::string format_configuration<Spatial>(const Mechanism&, const Tree<Spatial>&, const double*);

namespace {

bool may_wind_coordinate(const Mechanism& mechanism, CoordinateId coordinate) {
  const auto is_leader = [coordinate](const model::CoordinateCombination& sum) {
    return std::any_of(sum.terms.begin(), sum.terms.end(),
                       [coordinate](const model::CoordinateTerm& term) { return term.coordinate == coordinate; });
  };
  return std::none_of(mechanism.couplings.begin(), mechanism.couplings.end(),
                      [&](const Coupling& one) { return one.follower == coordinate || is_leader(one.leader); }) &&
         std::none_of(mechanism.discs.begin(), mechanism.discs.end(),
                      [&](const Disc& disc) { return is_leader(disc.follows); }) &&
         std::none_of(mechanism.springs.begin(), mechanism.springs.end(),
                      [&](const Spring& one) { return one.is_joint_spring() && one.coordinate == coordinate; }) &&
         std::none_of(mechanism.loads.begin(), mechanism.loads.end(),
                      [&](const Load& load) { return load.is_over_coordinate() && load.coordinate == coordinate; }) &&
         std::none_of(mechanism.force_elements.begin(), mechanism.force_elements.end(),
                      [&](const ForceElement& one) { return one.is_in_joint() && one.coordinate == coordinate; }) &&
         std::none_of(mechanism.assembly.begin(), mechanism.assembly.end(), [&](const CoordinateValue& given) {
           return given.coordinate == coordinate &&
                  !(given.value > -std::numbers::pi && given.value <= std::numbers::pi);
         });
}

/// First guess of y from the assembly values of tree coordinates.
template <class S>
VectorX make_initial_guess(const Mechanism& mechanism, const Tree<S>& tree) {
  VectorX y = VectorX::Zero(tree.columns);
  for (const CoordinateValue& assembly_value : mechanism.assembly) {
    const LinearQuantity& source = tree.coordinate_expressions[assembly_value.coordinate];
    if (!source.has_single_term() || source.terms[0].second == 0) continue;  // a sum does not determine its terms
    y[source.terms[0].first] = (assembly_value.value - source.constant) / source.terms[0].second;
  }
  return y;
}

}  // namespace

template <class S>
double distance_from_assembly(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y) {
  if (mechanism.assembly.empty()) return 0;
  TreeState<S> state(tree.nodes.size());
  compute_poses(tree, y.data(), state);
  double sum = 0;
  for (const CoordinateValue& assembly_value : mechanism.assembly) {
    const Coordinate& coordinate = mechanism.coordinates[assembly_value.coordinate];
    const LinearQuantity& source = tree.coordinate_expressions[assembly_value.coordinate];
    double value;
    if (source.has_terms() && !tree.is_floating[assembly_value.coordinate]) {
      value = source.value(y.data());
    } else {
      const Joint& joint = mechanism.joints[coordinate.joint];
      value = compute_joint_motion(joint, relative_motion(tree, state, joint)).position[coordinate.index];
    }
    const double deviation = coordinate.kind == CoordinateKind::angle
                                 ? assembly_value.value - unwrap_angle(value, assembly_value.value)
                                 : (assembly_value.value - value) / tree.characteristic_length;
    sum += deviation * deviation;
  }
  return std::sqrt(sum / static_cast<double>(mechanism.assembly.size()));
}

namespace {

/// Brings angles that were found outside (−π, π] into it, if full turns make no difference: not those that the pose or
/// a coupling refers to, that a joint spring winds up, that a load depends on, or that the spec gives outside it.
template <class S>
void wind_angles(const Mechanism& mechanism, const Tree<S>& tree, ConstraintSystem<S>& system,
                 const DriveSample& target, VectorX& y) {
  constexpr double two_pi = 2 * std::numbers::pi;
  const auto is_outside = [](double angle) { return !(angle > -std::numbers::pi && angle <= std::numbers::pi); };
  VectorX wound = y;
  for (int column = 0; column < tree.columns; ++column) {
    if (tree.is_length_column[column] || !is_outside(y[column])) continue;
    const auto refers_to_column = [&](const LinearQuantity& quantity) {
      return std::any_of(quantity.terms.begin(), quantity.terms.end(),
                         [&](const auto& term) { return term.first == column; });
    };
    int users = 0;
    bool may_wind = std::none_of(system.drive().linear.begin(), system.drive().linear.end(), refers_to_column);
    for (std::size_t c = 0; c < tree.coordinate_expressions.size(); ++c) {
      if (!refers_to_column(tree.coordinate_expressions[c])) continue;
      ++users;
      may_wind = may_wind && tree.coordinate_expressions[c].is_column() &&
                 mechanism.coordinates[c].kind == CoordinateKind::angle &&
                 may_wind_coordinate(mechanism, static_cast<int>(c));
    }
    if (may_wind && users == 1) wound[column] -= two_pi * std::ceil((y[column] - std::numbers::pi) / two_pi);
  }
  if (wound == y) return;
  VectorX residual;
  numerics::SparseMatrix jacobian;
  system.evaluate(wound, target, residual, jacobian);
  if (residual.size() == 0 || numerics::max_abs(residual) < closure_tolerance) y = wound;
  system.evaluate(y, target, residual, jacobian);
}

}  // namespace

template <class S>
AssemblySolution solve_pose(const Mechanism& mechanism, const Tree<S>& tree, ConstraintSystem<S>& system,
                            const DriveSample& target) {
  // A solution at the assembly values is accepted at once. Near them a few restarts look for a nearer one, since
  // another mode of one joint need not be far off in the mean over many. Elsewhere the nearest of many restarts is
  // taken.
  constexpr double accepted_distance = 0.1, near_distance = 0.4;
  constexpr std::uint64_t min_restarts = 20, max_restarts = 200;
  const VectorX guess = make_initial_guess(mechanism, tree);
  AssemblySolution best = solve_assembly(system, guess, target);
  double distance = best.found ? distance_from_assembly(mechanism, tree, best.y) : INFINITY;
  for (std::uint64_t seed = 1;
       seed <= (distance > near_distance ? max_restarts : min_restarts) && distance > accepted_distance; ++seed) {
    const VectorX random = random_coordinates(tree, seed);
    // the first restarts stay near the guess, later ones go anywhere
    const double spread = seed <= 60 ? 0.1 + 0.01 * static_cast<double>(seed) : 1;
    const AssemblySolution trial =
        solve_assembly(system, spread < 1 ? VectorX(guess + spread * random) : random, target);
    if (!trial.found) {
      if (!best.found && trial.residual < best.residual) best = trial;
      continue;
    }
    const double trial_distance = distance_from_assembly(mechanism, tree, trial.y);
    if (!best.found || trial_distance < distance) best = trial, distance = trial_distance;
  }
  if (best.found) wind_angles(mechanism, tree, system, target, best.y);
  return best;
}

#define BALANCE_INSTANTIATE(S)                                                                 \
  template double distance_from_assembly<S>(const Mechanism&, const Tree<S>&, const VectorX&); \
  template AssemblySolution solve_pose<S>(const Mechanism&, const Tree<S>&, ConstraintSystem<S>&, const DriveSample&);

BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance::kinematics
