#include "balance/mechanics/kinematics/assembly.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

namespace balance {

namespace {

/// Where a pose says too little, or what determines nothing there.
MotionOutcome check_pose_determinacy(int open, int stated, int freedoms) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (open == 0) return outcome;
  if (stated < freedoms) {
    outcome.status = MotionStatus::mismatch;
    outcome.reason = "the pose says too little: it states " + std::to_string(stated) + " of the " +
                     std::to_string(freedoms) + " numbers that determine the mechanism's configuration";
  } else {
    outcome.status = MotionStatus::drive_singularity;
    outcome.reason = "the pose does not determine the configuration: what it states leaves " + std::to_string(open) +
                     " of " + std::to_string(freedoms) + " degrees of freedom open there";
  }
  return outcome;
}

template <class S>
ConfigurationResult solve_configuration_in(const Mechanism& mechanism, const PoseTarget& pose) {
  std::vector<CoordinateId> needed;
  for (const CoordinateValue& value : pose.joints) needed.push_back(value.coordinate);
  const Tree<S> tree = compile_tree<S>(mechanism, needed);
  const PoseEquations<S> stated = make_pose_equations(mechanism, tree, pose);
  ConstraintSystem<S> system(tree, stated.drive);
  const AssemblySolution solution = solve_pose(mechanism, tree, system, stated.target);
  ConfigurationResult found;
  if (!solution.found) {
    found.outcome = explain_assembly_failure(mechanism, tree, solution, pose);
    return found;
  }
  VectorX residual;
  MatrixX jacobian;
  system.evaluate(solution.y, stated.target, residual, jacobian);
  const int freedoms = tree.columns - find_generic_position_rank(tree, solution.y);
  const int open = jacobian.rows() == 0 ? tree.columns : tree.columns - decompose_rank(jacobian).rank;
  found.outcome = check_pose_determinacy(open, stated.drive.row_count(), freedoms);
  const std::vector<double> coordinates = compute_coordinates(mechanism, tree, solution.y);
  for (std::size_t c = 0; c < coordinates.size(); ++c)
    found.coordinates.push_back({static_cast<int>(c), coordinates[c]});
  // the stated ones with their whole turns
  for (const CoordinateValue& value : pose.joints)
    found.coordinates[static_cast<std::size_t>(value.coordinate)].value = value.value;
  return found;
}

}  // namespace

ConfigurationResult solve_configuration(const Mechanism& mechanism, const PoseTarget& pose) {
  return dispatch_space(mechanism.space, [&]<class S>(S) { return solve_configuration_in<S>(mechanism, pose); });
}

namespace {

constexpr double mode_distance_tolerance = 1e-4;  // radians or characteristic lengths
constexpr int max_mode_iterations = 60;
constexpr std::uint64_t first_mode_seed = 1000;  // the first seeds are those of the search for the selected mode

/// @param scale what counts as one: a radian, the characteristic length
/// @param unit what the spec tells it in
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
  const AssemblySolution other =
      solve_assembly(system_, random_coordinates(tree_, first_mode_seed + start), target_, max_mode_iterations);
  if (other.found) {
    std::vector<double> mode = compute_coordinates(mechanism_, tree_, other.y);
    if (std::none_of(modes_.begin(), modes_.end(), [&](const auto& known) { return is_same_mode(known, mode); }))
      modes_.push_back(std::move(mode));
  }
  return static_cast<long>(other.iterations) * tree_.columns;
}

template <class S>
bool AssemblyModes<S>::is_same_mode(const std::vector<double>& a, const std::vector<double>& b) const {
  for (std::size_t c = 0; c < a.size(); ++c) {
    const bool angle = mechanism_.coordinates[c].kind == CoordinateKind::angle;
    const double off = angle ? unwrap_angle(a[c], b[c]) - b[c] : (a[c] - b[c]) / tree_.characteristic_length;
    if (std::abs(off) > mode_distance_tolerance) return false;
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
    const bool length = mechanism.coordinates[c].kind == CoordinateKind::length;
    line += (line.empty() ? "" : ", ") + mechanism.coordinates[c].name + ": " +
            rounded_value_text(mode[c], length ? tree.characteristic_length : 1,
                               length ? mechanism.units.length : mechanism.units.angle);
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

/// The least-norm solution of J x = r, as far as there is one.
VectorX solve_least_norm_step(const MatrixX& jacobian, const VectorX& residual) {
  CompleteOrthogonalDecomposition qr;
  qr.setThreshold(1e-9);
  qr.compute(jacobian);
  return qr.solve(residual);
}

/// What the damping leaves is made up for by the second step and, in an iteration, by the next ones.
VectorX solve_least_norm_step(const SparseMatrix& jacobian, const VectorX& residual) {
  const double shift = 1e-12 * jacobian.squaredNorm() / static_cast<double>(jacobian.cols());
  const VectorX first = solve_damped_least_squares(jacobian, residual, shift);
  return first + solve_damped_least_squares(jacobian, residual - jacobian * first, shift);
}

/// Quadratic end game: least-norm Newton steps as long as they help.
template <class Matrix, class S>
void polish_by_newton(ConstraintSystem<S>& system, const VectorX& scale, const DriveSample& target,
                      AssemblySolution& solution) {
  VectorX residual, trial;
  Matrix jacobian;
  system.evaluate(solution.y, target, residual, jacobian);
  for (int k = 0; k < 8 && residual.size() > 0; ++k) {
    const double before = residual.template lpNorm<Eigen::Infinity>();
    solution.residual = before;
    if (before < 1e-15) break;
    trial = solution.y - scale.cwiseProduct(solve_least_norm_step(jacobian, residual));
    system.evaluate(trial, target, residual, jacobian);
    if (!(residual.template lpNorm<Eigen::Infinity>() < before)) break;
    solution.y = trial;
    solution.residual = residual.template lpNorm<Eigen::Infinity>();
  }
  system.evaluate(solution.y, target, residual, jacobian);
}

/// Levenberg and Marquardt's steps, of any damping, from one configuration.
class DampedNormalEquations {
 public:
  DampedNormalEquations(const MatrixX& jacobian, const VectorX& residual)
      : normal_(jacobian.transpose() * jacobian),
        gradient_(jacobian.transpose() * residual),
        largest_(max_coefficient(normal_.diagonal())) {}
  VectorX step(double damping) const {
    MatrixX damped = normal_;
    damped.diagonal().array() += damping * std::max(1e-6, largest_);
    return damped.ldlt().solve(gradient_);
  }

 private:
  MatrixX normal_;
  VectorX gradient_;
  double largest_;
};

class SparseDampedNormalEquations {
 public:
  SparseDampedNormalEquations(const SparseMatrix& jacobian, const VectorX& residual)
      : jacobian_(jacobian), residual_(residual) {
    for (Eigen::Index c = 0; c < jacobian.cols(); ++c) largest_ = std::max(largest_, jacobian.col(c).squaredNorm());
  }
  VectorX step(double damping) const {
    return solve_damped_least_squares(jacobian_, residual_, damping * std::max(1e-6, largest_));
  }

 private:
  const SparseMatrix& jacobian_;
  const VectorX& residual_;
  double largest_ = 0;
};

template <class Matrix, class StepsOf, class S>
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
    const StepsOf steps(jacobian, residual);
    bool better = false;
    for (int tries = 0; tries < 12 && !better; ++tries) {
      VectorX step = steps.step(damping);
      const double longest = step.template lpNorm<Eigen::Infinity>();
      if (longest > 1) step /= longest;  // no more than one radian or one length at a time
      const VectorX trial = solution.y - scale.cwiseProduct(step);
      system.evaluate(trial, target, trial_residual, trial_jacobian);
      const double trial_cost = trial_residual.squaredNorm();
      better = trial_cost < cost;
      if (better) {
        const bool stalled = cost - trial_cost < 1e-10 * cost;
        solution.y = trial, cost = trial_cost;
        residual.swap(trial_residual), jacobian.swap(trial_jacobian);
        damping = std::max(1e-12, damping / 5);
        if (stalled) better = false, tries = 12;
      } else {
        damping *= 4;
      }
    }
    if (!better) break;
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
  return system.columns() > max_dense_columns
             ? search_levenberg_marquardt<SparseMatrix, SparseDampedNormalEquations>(system, guess, target, iterations)
             : search_levenberg_marquardt<MatrixX, DampedNormalEquations>(system, guess, target, iterations);
}

template <class S>
VectorX random_coordinates(const Tree<S>& tree, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  VectorX y(tree.columns);
  for (int c = 0; c < tree.columns; ++c) {
    // written out: the standard's distributions differ between libraries
    const double unit = 2 * (static_cast<double>(random() >> 11) * 0x1.0p-53) - 1;
    y[c] = unit * (tree.is_length_column[c] ? tree.characteristic_length : std::numbers::pi);
  }
  return y;
}

RankDecomposition decompose_rank(const MatrixX& jacobian, double tolerance) {
  RankDecomposition report;
  const Eigen::Index columns = jacobian.cols();
  if (jacobian.rows() == 0 || columns == 0) {
    report.null_space = MatrixX::Identity(columns, columns);
    return report;
  }
  const SingularValueDecomposition svd(jacobian, Eigen::ComputeFullV);
  const VectorX& values = svd.singularValues();
  const double largest = values[0];
  while (report.rank < values.size() && values[report.rank] > tolerance * largest && largest > 0) ++report.rank;
  report.null_space = svd.matrixV().rightCols(columns - report.rank);
  return report;
}

namespace {

/// There is no larger rank: no singular value is anywhere near the limit of rank_of().
template <class S>
bool has_proven_full_rank(ConstraintSystem<S>& closures, const VectorX& y) {
  VectorX residual;
  SparseMatrix jacobian;
  closures.evaluate(y, {}, residual, jacobian);
  return min_singular_value(jacobian).has_value();
}

/// @param rates the rows of closures of rates count, too
template <class S>
int find_generic_rank(const Tree<S>& tree, const VectorX& y, bool rates) {
  ConstraintSystem<S> closures(tree, Drive<S>{});
  const int rows = rates ? closures.closure_rows() : closures.place_rows(), full = std::min(rows, closures.columns());
  if (full == 0 || (full > max_dense_columns && rows == closures.place_rows() && has_proven_full_rank(closures, y)))
    return full;
  const VectorX scale = column_scale(tree);
  VectorX here = y;
  MatrixX jacobian;
  closures.velocity_jacobian(here, {}, jacobian);
  RankDecomposition last = decompose_rank(jacobian.topRows(rows));
  int best = last.rank;
  for (std::uint64_t seed = 1; seed <= 4 && best < full && last.null_space.cols() > 0; ++seed) {
    const VectorX random = random_coordinates(tree, seed).cwiseQuotient(scale);
    VectorX direction = last.null_space * (last.null_space.transpose() * random);
    if (direction.norm() < 1e-12) break;
    direction *= 0.15 / direction.norm();
    const AssemblySolution moved = solve_assembly(closures, here + scale.cwiseProduct(direction), {});
    if (!moved.found || (moved.y - here).cwiseQuotient(scale).norm() < 1e-6) continue;
    here = moved.y;
    closures.velocity_jacobian(here, {}, jacobian);
    last = decompose_rank(jacobian.topRows(rows));
    best = std::max(best, last.rank);
  }
  return best;
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
  AssemblySolution here{true, y, 0, 0};
  const Vector3 turn = rotation_vector_of(to.rotation * from.rotation.transpose());
  const VectorX scale = column_scale(system.tree());
  double done = 0, step = 1.0 / 32;
  VectorX slope = VectorX::Zero(y.size());
  while (done < 1) {
    const double next = std::min(1.0, done + step);
    DriveSample target;
    target.value = (1 - next) * from.value + next * to.value;
    target.rotation = next == 1 ? to.rotation : Matrix3(rotation_from_rotation_vector(next * turn) * from.rotation);
    const AssemblySolution trial = solve_assembly(system, here.y + (next - done) * slope, target, 30);
    const double change = (trial.y - here.y).cwiseQuotient(scale).template lpNorm<Eigen::Infinity>();
    if (trial.found && change < 0.5) {
      slope = (trial.y - here.y) / (next - done);
      here = trial;
      done = next;
      step = std::min(2 * step, 1.0 / 16);
    } else {
      step /= 2;
      slope.setZero();
      if (step < 1e-6) return {false, here.y, trial.residual, 0};
    }
  }
  return here;
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
  Matrix3 all = Matrix3::Identity(), fixed = Matrix3::Identity();
  for (int n = spherical; n < spherical + 3; ++n) {
    const Node<S>& node = tree.nodes[n];
    const bool turns = node.motion == NodeMotion::revolute;  // the last of a held spin does not
    const double x = turns ? node.ratio * y[node.column] + node.offset : 0;
    all *= to_matrix(rotate_about_joint_axis(node.R_PF, elementary::cos(x), elementary::sin(x)));
    if (n > spherical) fixed *= to_matrix(node.R_PF);
    if (turns) y[node.column] = -node.offset / node.ratio;
  }
  // products of rotations drift; the nearest rotation does not
  const Eigen::Quaterniond exact = Eigen::Quaterniond(Matrix3(all * fixed.transpose())).normalized();
  tree.nodes[spherical].R_PF = to_rotation<S>(exact.toRotationMatrix());
}

template void reset_spherical_reference<Planar>(Tree<Planar>&, NodeId, double*);
template void reset_spherical_reference<Spatial>(Tree<Spatial>&, NodeId, double*);

template <class S>
std::string format_configuration(const Mechanism& mechanism, const Tree<S>& tree, const double* y) {
  constexpr std::size_t max_listed_coordinates = 12;  // a sentence is to be read
  std::string out;
  for (std::size_t c = 0; c < tree.coordinate_expressions.size() && c < max_listed_coordinates; ++c) {
    const LinearQuantity& source = tree.coordinate_expressions[c];
    if (!source.has_terms() || tree.is_floating[c]) continue;
    const double value = source.value(y);
    const auto coordinate = static_cast<int>(c);
    const double round_off =
        pose_round_off * (is_length_coordinate(mechanism, coordinate) ? tree.characteristic_length : 1);
    out += (out.empty() ? "" : ", ") + mechanism.coordinates[c].name + " " +
           format_coordinate(mechanism, coordinate, value, round_off);
  }
  return out;
}

template std::string format_configuration<Planar>(const Mechanism&, const Tree<Planar>&, const double*);
template std::string format_configuration<Spatial>(const Mechanism&, const Tree<Spatial>&, const double*);

namespace {

/// First guess of y from the assembly values of tree coordinates.
template <class S>
VectorX make_initial_guess(const Mechanism& mechanism, const Tree<S>& tree) {
  VectorX y = VectorX::Zero(tree.columns);
  for (const CoordinateValue& rough : mechanism.assembly) {
    const LinearQuantity& source = tree.coordinate_expressions[rough.coordinate];
    if (!source.has_single_term() || source.terms[0].second == 0) continue;  // a sum says nothing of its parts
    y[source.terms[0].first] = (rough.value - source.constant) / source.terms[0].second;
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
  for (const CoordinateValue& rough : mechanism.assembly) {
    const Coordinate& coordinate = mechanism.coordinates[rough.coordinate];
    const LinearQuantity& source = tree.coordinate_expressions[rough.coordinate];
    double value;
    if (source.has_terms() && !tree.is_floating[rough.coordinate]) {
      value = source.value(y.data());
    } else {
      const Joint& joint = mechanism.joints[coordinate.joint];
      value = compute_joint_motion(joint, relative_motion(tree, state, joint)).position[coordinate.index];
    }
    const double off = coordinate.kind == CoordinateKind::angle ? rough.value - unwrap_angle(value, rough.value)
                                                                : (rough.value - value) / tree.characteristic_length;
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(mechanism.assembly.size()));
}

template <class S>
AssemblySolution solve_pose(const Mechanism& mechanism, const Tree<S>& tree, ConstraintSystem<S>& system,
                            const DriveSample& target) {
  // At the assembly values the first solution is the one; near them a few tries tell whether there is a nearer one, since one joint's
  // other mode need not be far on the mean of many; elsewhere the nearest of many is taken.
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
    const double off = distance_from_assembly(mechanism, tree, trial.y);
    if (!best.found || off < distance) best = trial, distance = off;
  }
  return best;
}

#define BALANCE_INSTANTIATE(S)                                                                 \
  template double distance_from_assembly<S>(const Mechanism&, const Tree<S>&, const VectorX&); \
  template AssemblySolution solve_pose<S>(const Mechanism&, const Tree<S>&, ConstraintSystem<S>&, const DriveSample&);

BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
