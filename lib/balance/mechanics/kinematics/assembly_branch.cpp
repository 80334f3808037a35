#include "balance/mechanics/kinematics/assembly_branch.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/kinematics/motion_stepper.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

namespace balance::kinematics {

namespace {

constexpr double max_correction = 0.1;  // of a prediction, in radians or characteristic lengths

template <class S>
Drive<S> make_independent_drive(const Mechanism& mechanism, const Tree<S>& tree,
                                const std::vector<CoordinateId>& coordinates) {
  Drive<S> drive;
  for (const int c : coordinates) drive.linear.push_back(find_coordinate_expression(mechanism, tree, c));
  return drive;
}

template <class S>
bool has_single_terms(const Tree<S>& tree, const std::vector<CoordinateId>& coordinates) {
  return std::all_of(coordinates.begin(), coordinates.end(),
                     [&](int c) { return tree.coordinate_expressions[static_cast<std::size_t>(c)].has_single_term(); });
}

}  // namespace

template <class S>
AssemblyBranch<S>::AssemblyBranch(const Mechanism& mechanism, IndependentCoordinates<S> choice)
    : mechanism_(mechanism),
      tree_(std::move(choice.tree)),
      required_coordinates_(std::move(choice.needed)),
      independent_(std::move(choice.coordinates)),
      note_(std::move(choice.note)),
      freedoms_(choice.freedoms),
      has_redundant_closures_(choice.redundant),
      is_explicit_(tree_.closures.empty() && has_single_terms(tree_, independent_)),
      drive_(make_independent_drive(mechanism, tree_, independent_)),
      equations_(tree_, drive_, has_redundant_closures_),
      residual_tolerance_(MotionStepper<S>::newton_residual_tolerance * ground_extent(mechanism)),
      state_(tree_.nodes.size()) {
  for (const LinearQuantity& quantity : drive_.linear)
    columns_.push_back({quantity.terms[0].first, 1 / quantity.terms[0].second, quantity.constant});
  has_identity_map_ = is_explicit_;
  for (std::size_t k = 0; k < columns_.size(); ++k)
    has_identity_map_ = has_identity_map_ && columns_[k].column == static_cast<int>(k) && columns_[k].inverse == 1 &&
                        columns_[k].offset == 0;
  std::set<ColumnId> matrix_columns;
  for (const Closure<S>& closure : tree_.closures)
    for (const PathStep& step : closure.path) matrix_columns.insert(tree_.nodes[step.node].column);
  matrix_columns_.assign(matrix_columns.begin(), matrix_columns.end());
  for (const NodeId spherical : tree_.spherical_joints) initial_references_.push_back(tree_.nodes[spherical].R_PF);
  for (VectorX* values : {&y_, &dy_, &ddy_, &predicted_, &trial_}) values->setZero(tree_.columns);
  for (VectorX* values : {&sample_.value, &sample_.rate, &sample_.acceleration}) values->setZero(freedoms_);
  q_.assign(static_cast<std::size_t>(freedoms_), 0);
  x_.assign(static_cast<std::size_t>(std::max(tree_.columns, equations_.rows())), 0);
}

template <class S>
bool AssemblyBranch<S>::newton(VectorX& y, const double* q) {
  has_current_equations_ = false;
  std::copy_n(q, freedoms_, sample_.value.data());
  double previous_residual = INFINITY;
  for (iterations_ = 0; iterations_ <= MotionStepper<S>::max_newton_iterations; ++iterations_) {
    compute_poses(tree_, y.data(), state_);
    equations_.evaluate(state_, y.data(), sample_, x_.data());
    double max_residual = 0;
    for (int r = 0; r < equations_.rows(); ++r) max_residual = std::max(max_residual, std::abs(x_[r]));
    if (!std::isfinite(max_residual) || !equations_.factorise()) return false;
    equations_.solve(x_.data());
    for (int c = 0; c < tree_.columns; ++c) y[c] -= x_[c];
    if (max_residual <= residual_tolerance_ ||
        (max_residual <= 10 * residual_tolerance_ && max_residual >= previous_residual))
      return true;
    previous_residual = max_residual;
  }
  return false;
}

/// Updates equations and poses to q_ and y_; may reset the references of spherical joints.
template <class S>
bool AssemblyBranch<S>::update_equations() {
  reset_spherical_references();
  if (!newton(y_, q_.data())) return false;
  equations_.store();
  has_current_equations_ = true;
  return true;
}

template <class S>
bool AssemblyBranch<S>::reset_spherical_references() {
  constexpr double max_middle_angle = 1;  // at a right angle a spherical joint's coordinates are singular
  bool was_reset = false;
  for (const NodeId spherical : tree_.spherical_joints) {
    const double middle = std::remainder(y_[tree_.nodes[spherical + 1].column], 2 * std::numbers::pi);
    if (std::abs(middle) < max_middle_angle) continue;
    reset_spherical_reference(tree_, spherical, y_.data());
    was_reset = true;
  }
  return was_reset;
}

/// Steps to a state near enough that neither the mode nor the sign of a determinant can have changed in between.
template <class S>
bool AssemblyBranch<S>::step(const double* q) {
  if (!has_current_equations_ && !update_equations()) return false;
  std::fill(x_.begin(), x_.end(), 0);
  for (int k = 0; k < freedoms_; ++k) {
    const int row = tree_.closure_rows + k;
    x_[row] = equations_.row_scale()[row] * (q[k] - q_[k]);
  }
  equations_.solve(x_.data());
  const std::vector<double>& scale = equations_.column_scale();
  for (int c = 0; c < tree_.columns; ++c) predicted_[c] = y_[c] + x_[c];
  trial_ = predicted_;
  if (!newton(trial_, q)) return false;
  for (int c = 0; c < tree_.columns; ++c)
    if (!(std::abs(trial_[c] - predicted_[c]) <= max_correction * scale[c])) return false;
  double distance = 0;
  for (const int c : matrix_columns_) distance = std::max(distance, std::abs(trial_[c] - y_[c]) / scale[c]);
  if (!(distance * distance <= numerics::max_matrix_curvature * equations_.regularity()) ||
      !equations_.is_near_stored(numerics::max_matrix_change))
    return false;
  std::swap(y_, trial_);
  std::copy_n(q, freedoms_, q_.begin());
  has_current_equations_ = true;
  if (reset_spherical_references()) return update_equations();
  equations_.store();
  return true;
}

template <class S>
void AssemblyBranch<S>::set_rates(const double* dq) {
  if (is_explicit_) return set_explicit(dq, 0, dy_.data());
  std::copy_n(dq, freedoms_, sample_.rate.data());
  equations_.velocity_rhs(sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, dy_.data());
  compute_angular_velocities(tree_, dy_.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, dy_.data(), state_);
}

template <class S>
void AssemblyBranch<S>::set_accelerations(const double* ddq) {
  if (is_explicit_) return set_explicit(ddq, 0, ddy_.data());
  std::copy_n(ddq, freedoms_, sample_.acceleration.data());
  compute_accelerations<S>(tree_, dy_.data(), nullptr, S::Vector::Zero(), state_);
  equations_.acceleration_rhs(state_, sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, ddy_.data());
}

template <class S>
void AssemblyBranch<S>::fill_transformation(MatrixX& C) {
  C.setZero(tree_.columns, freedoms_);
  for (int k = 0; k < freedoms_; ++k) {
    if (is_explicit_) {
      C(columns_[static_cast<std::size_t>(k)].column, k) = columns_[static_cast<std::size_t>(k)].inverse;
      continue;
    }
    std::fill(x_.begin(), x_.end(), 0);
    const int row = tree_.closure_rows + k;
    x_[row] = equations_.row_scale()[row];
    equations_.solve(x_.data());
    C.col(k) = Eigen::Map<const VectorX>(x_.data(), tree_.columns);
  }
}

template <class S>
VectorX AssemblyBranch<S>::coordinates() const {
  const std::vector<double> wrapped = compute_coordinates(mechanism_, tree_, y_);
  VectorX values = Eigen::Map<const VectorX>(wrapped.data(), static_cast<Eigen::Index>(wrapped.size()));
  for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
    const LinearQuantity& source = tree_.coordinate_expressions[c];
    if (source.has_terms() && !tree_.is_floating[c]) values[static_cast<Eigen::Index>(c)] = source.value(y_.data());
  }
  return values;
}

template class AssemblyBranch<Planar>;
template class AssemblyBranch<Spatial>;

// Finding a branch, and following it between states that are far from each other.

namespace {

constexpr double min_path_fraction = 1.0 / 4096;  // of the path to the next state
constexpr double max_tracking_distance = 1000;    // to follow at most, in radians or characteristic lengths

/// A stepper's message without the time, which is meaningless between two states.
std::string strip_time_prefix(const MotionOutcome& outcome) {
  const std::string::size_type end = outcome.reason.find("s: ");
  return outcome.reason.rfind("at t = ", 0) == 0 && end != std::string::npos ? outcome.reason.substr(end + 3)
                                                                             : outcome.reason;
}

}  // namespace

/// Steps to q in as many steps as needed.
template <class S>
bool AssemblyBranch<S>::step_repeatedly(const double* q) {
  const std::vector<double> from = q_;
  std::vector<double> next(q_.size());
  double reached_fraction = 0, step_size = 0.5;
  while (reached_fraction < 1) {
    const double fraction = std::min(1.0, reached_fraction + step_size);
    for (std::size_t k = 0; k < next.size(); ++k)
      next[k] = fraction == 1 ? q[k] : (1 - fraction) * from[k] + fraction * q[k];
    if (step(next.data())) {
      reached_fraction = fraction;
      step_size = std::min(2 * step_size, 0.5);
    } else if ((step_size /= 2) < min_path_fraction) {
      return false;
    }
  }
  return true;
}

template <class S>
CompiledTrajectory<S> AssemblyBranch<S>::compile_path_to(const double* q) const {
  CompiledTrajectory<S> plan;
  plan.outcome.status = MotionStatus::done;
  plan.drive = drive_;
  plan.start = y_;
  plan.freedoms = freedoms_;
  plan.has_redundant_closures = has_redundant_closures_;
  trajectory::PrescribedMotion::Request request;
  request.law.kind = MotionLawKind::cubic;
  request.has_real_time = false;
  request.from.value = Eigen::Map<const VectorX>(q_.data(), freedoms_);
  request.to.value = Eigen::Map<const VectorX>(q, freedoms_);
  plan.prescribed_motion.emplace(request);
  return plan;
}

/// Moves by a MotionStepper, which comes nearer to singular configurations and diagnoses them.
template <class S>
MotionOutcome AssemblyBranch<S>::track_with_stepper(const double* q, const char* reason_prefix) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (freedoms_ == 0) {  // nowhere to go
    outcome.status = update_equations() ? MotionStatus::done : MotionStatus::constraint_singularity;
    outcome.reason = has_current_equations_ ? "" : "constraint singularity: the loop closures lose rank";
    return outcome;
  }
  const CompiledTrajectory<S> plan = compile_path_to(q);
  MotionStepper<S> stepper(mechanism_, tree_, plan);
  const bool is_reached = stepper.begin() && stepper.advance(plan.prescribed_motion->duration());
  if (is_reached) {
    y_ = Eigen::Map<const VectorX>(stepper.y(), tree_.columns);
    std::copy_n(q, freedoms_, q_.begin());
    if (update_equations()) return outcome;
  }
  outcome.status = is_reached ? MotionStatus::drive_singularity : stepper.outcome().status;
  outcome.reason = is_reached ? "drive singularity: the independent coordinates no longer determine the motion"
                              : strip_time_prefix(stepper.outcome());
  outcome.reason.insert(0, reason_prefix);
  return outcome;
}

template <class S>
typename AssemblyBranch<S>::Snapshot AssemblyBranch<S>::snapshot() const {
  Snapshot saved{y_, q_, {}};
  for (const NodeId spherical : tree_.spherical_joints) saved.references.push_back(tree_.nodes[spherical].R_PF);
  return saved;
}

template <class S>
void AssemblyBranch<S>::restore(const Snapshot& saved) {
  y_ = saved.y;
  q_ = saved.q;
  for (std::size_t b = 0; b < tree_.spherical_joints.size(); ++b)
    tree_.nodes[tree_.spherical_joints[b]].R_PF = saved.references[b];
  has_current_equations_ = false;
}

template <class S>
MotionOutcome AssemblyBranch<S>::move_closed_to(const double* q) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::done;
  if (!assembled_) return assemble(q, {});
  if (has_current_equations_ && std::equal(q_.begin(), q_.end(), q)) return outcome;
  if (step(q)) return outcome;
  for (int k = 0; k < freedoms_; ++k) {
    const double unit = drive_.linear[static_cast<std::size_t>(k)].is_length ? tree_.characteristic_length : 1;
    if (std::abs(q[k] - q_[static_cast<std::size_t>(k)]) <= max_tracking_distance * unit) continue;
    outcome.status = MotionStatus::unreachable;
    outcome.reason = mechanism_.coordinates[independent_[static_cast<std::size_t>(k)]].name +
                     " is too far from the previous state to be tracked";
    return outcome;
  }
  const Snapshot saved_state = snapshot();
  if (step_repeatedly(q)) return outcome;
  has_current_equations_ = false;
  outcome = track_with_stepper(q, "on the straight path from the previous state: ");
  if (outcome.status != MotionStatus::done) restore(saved_state);
  return outcome;
}

template <class S>
MotionOutcome AssemblyBranch<S>::assemble(const double* q, const std::vector<CoordinateValue>& near) {
  if (is_explicit_) return move_to(q, 0);
  const Snapshot saved_state = snapshot();
  for (std::size_t b = 0; b < tree_.spherical_joints.size(); ++b)
    tree_.nodes[tree_.spherical_joints[b]].R_PF = initial_references_[b];
  Mechanism guided_mechanism = mechanism_;
  const auto set_assembly_value = [&](const CoordinateValue& value, bool is_required) {
    const auto is_same_coordinate = [&](const CoordinateValue& other) { return other.coordinate == value.coordinate; };
    const bool was_present = std::erase_if(guided_mechanism.assembly, is_same_coordinate) > 0;
    if (was_present || is_required) guided_mechanism.assembly.push_back(value);
  };
  for (const CoordinateValue& value : near) set_assembly_value(value, true);
  for (int k = 0; k < freedoms_; ++k) set_assembly_value({independent_[static_cast<std::size_t>(k)], q[k]}, false);
  ConstraintSystem<S> system(tree_, drive_);
  trajectory::DriveSample target;
  target.value = Eigen::Map<const VectorX>(q, freedoms_);
  const AssemblySolution solution = solve_pose(guided_mechanism, tree_, system, target);
  MotionOutcome outcome;
  if (solution.found) {
    y_ = solution.y;
    std::copy_n(q, freedoms_, q_.begin());
    outcome = track_with_stepper(q, "");
    assembled_ = assembled_ || outcome.status == MotionStatus::done;
  } else {
    trajectory::PoseTarget pose;
    for (int k = 0; k < freedoms_; ++k) pose.joints.push_back({independent_[static_cast<std::size_t>(k)], q[k]});
    outcome = explain_assembly_failure(guided_mechanism, tree_, solution, pose);
    if (outcome.status == MotionStatus::unreachable)
      outcome.reason = "the loops cannot be closed with these independent coordinates: " +
                       outcome.reason.substr(std::min(outcome.reason.size(), outcome.reason.find(": ") + 2));
  }
  if (outcome.status != MotionStatus::done) restore(saved_state);
  return outcome;
}

#define BALANCE_INSTANTIATE(S)                                                              \
  template bool AssemblyBranch<S>::step_repeatedly(const double*);                          \
  template CompiledTrajectory<S> AssemblyBranch<S>::compile_path_to(const double*) const;   \
  template MotionOutcome AssemblyBranch<S>::track_with_stepper(const double*, const char*); \
  template AssemblyBranch<S>::Snapshot AssemblyBranch<S>::snapshot() const;                 \
  template void AssemblyBranch<S>::restore(const AssemblyBranch<S>::Snapshot&);             \
  template MotionOutcome AssemblyBranch<S>::move_closed_to(const double*);                  \
  template MotionOutcome AssemblyBranch<S>::assemble(const double*, const std::vector<CoordinateValue>&);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

int require_coordinate(const Mechanism& mechanism, const std::string& name, const char* what) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    names.push_back(mechanism.coordinates[c].name);
    if (names.back() == name) return static_cast<int>(c);
  }
  const std::string hint = format_nearest_name(name, names);
  throw std::invalid_argument(std::string(what) + ": there is no coordinate '" + name + "'" +
                              (hint.empty() ? "" : "; " + hint));
}

namespace {

constexpr double min_independent_rate = 1e-6;  // in radians or characteristic lengths, per unit of all coordinates

/// The loops of a compiled mechanism, and the velocities that they allow at some of its configurations.
template <class S>
struct SampledLoopVelocities {
  Tree<S> tree;
  std::vector<CoordinateId> needed;  ///< coordinates that the tree was compiled with
  int freedoms = 0;
  std::vector<MatrixX>
      velocities;  ///< scaled columns × freedoms; the first at the assembled configuration, if that is generic
};

/// Samples nearby configurations, too: the first one may be singular by accident.
template <class S>
void sample_configurations(const VectorX& start, SampledLoopVelocities<S>& loops) {
  ConstraintSystem<S> closures(loops.tree, Drive<S>{});
  const VectorX scale = column_scale(loops.tree);
  VectorX y = start;
  MatrixX jacobian;
  for (std::uint64_t seed = 0; seed <= 4; ++seed) {
    closures.velocity_jacobian(y, {}, jacobian);
    const MatrixX null_space = decompose_rank(jacobian).null_space;
    if (null_space.cols() == loops.freedoms) loops.velocities.push_back(null_space);
    const VectorX random = random_coordinates(loops.tree, seed + 1).cwiseQuotient(scale);
    const VectorX direction = null_space * (null_space.transpose() * random);
    if (direction.norm() < 1e-12) return;
    const AssemblySolution neighbour =
        solve_assembly(closures, y + scale.cwiseProduct(0.2 / direction.norm() * direction), {});
    if (neighbour.found) y = neighbour.y;
  }
}

template <class S>
SampledLoopVelocities<S> sample_loop_velocities(const Mechanism& mechanism, const std::vector<CoordinateId>& needed) {
  SampledLoopVelocities<S> loops{compile_tree<S>(mechanism, needed), needed, 0, {}};
  ConstraintSystem<S> closures(loops.tree, Drive<S>{});
  const AssemblySolution start = solve_pose(mechanism, loops.tree, closures, {});
  if (!start.found) throw UnsolvableMechanism(explain_assembly_failure(mechanism, loops.tree, start, {}));
  loops.freedoms = loops.tree.columns - find_generic_closure_rank(loops.tree, start.y);
  sample_configurations(start.y, loops);
  return loops;
}

/// Rates of coordinates, in their units, per unit of each allowed velocity; zero for coordinates outside the tree.
template <class S>
MatrixX compute_coordinate_rates(const Tree<S>& tree, const std::vector<CoordinateId>& coordinates,
                                 const MatrixX& velocities) {
  MatrixX rates = MatrixX::Zero(static_cast<Eigen::Index>(coordinates.size()), velocities.cols());
  const VectorX scale = column_scale(tree);
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    const LinearQuantity& source = tree.coordinate_expressions[coordinates[k]];
    for (const auto& [column, ratio] : source.terms)
      rates.row(static_cast<Eigen::Index>(k)) +=
          ratio * scale[column] / (source.is_length ? tree.characteristic_length : 1) * velocities.row(column);
  }
  return rates;
}

template <class S>
bool can_determine_motion(const SampledLoopVelocities<S>& loops, const std::vector<CoordinateId>& coordinates) {
  if (static_cast<int>(coordinates.size()) != loops.freedoms) return false;
  if (loops.freedoms == 0) return true;
  return std::any_of(loops.velocities.begin(), loops.velocities.end(), [&](const MatrixX& velocities) {
    const MatrixX rates = compute_coordinate_rates(loops.tree, coordinates, velocities);
    return numerics::singular_values(rates)[loops.freedoms - 1] > min_independent_rate;
  });
}

/// Removes the remaining independent rates of one coordinate from those of all coordinates.
void project_out(MatrixX& rates, Eigen::Index row) {
  const VectorX direction = rates.row(row).transpose().normalized();
  rates -= rates * direction * direction.transpose();
}

/// Actuated coordinates in their order, then those with the largest rates; floating ones only if there are no others.
template <class S>
std::vector<CoordinateId> pick_independent(const Mechanism& mechanism, const SampledLoopVelocities<S>& loops) {
  std::vector<CoordinateId> coordinates(mechanism.coordinates.size()), independent;
  for (std::size_t c = 0; c < coordinates.size(); ++c) coordinates[c] = static_cast<int>(c);
  if (loops.velocities.empty()) return independent;
  MatrixX rates = compute_coordinate_rates(loops.tree, coordinates, loops.velocities.front());
  const auto select = [&](CoordinateId coordinate) {
    project_out(rates, coordinate);
    independent.push_back(coordinate);
  };
  const auto is_incomplete = [&] { return static_cast<int>(independent.size()) < loops.freedoms; };
  for (const CoordinateId coordinate : mechanism.actuators)
    if (is_incomplete() && rates.row(coordinate).norm() > min_independent_rate) select(coordinate);
  for (const bool floating : {false, true})
    while (is_incomplete()) {
      int best = -1;
      for (const int c : coordinates)
        if (loops.tree.is_floating[c] == floating && rates.row(c).norm() > min_independent_rate &&
            (best < 0 || rates.row(c).norm() > (1 + 1e-9) * rates.row(best).norm()))
          best = c;
      if (best < 0) break;
      select(best);
    }
  return independent;
}

template <class S>
bool has_floating(const Tree<S>& tree, const std::vector<CoordinateId>& coordinates) {
  return std::any_of(coordinates.begin(), coordinates.end(), [&](int c) { return tree.is_floating[c]; });
}

std::string list_names(const Mechanism& mechanism, const std::vector<CoordinateId>& coordinates) {
  std::string text;
  for (const int c : coordinates) text += (text.empty() ? "" : ", ") + mechanism.coordinates[c].name;
  return text;
}

std::vector<CoordinateId> find_named_coordinates(const Mechanism& mechanism, const std::vector<std::string>& names) {
  std::vector<CoordinateId> coordinates;
  for (const std::string& name : names) {
    coordinates.push_back(require_coordinate(mechanism, name, "independent"));
    if (std::count(coordinates.begin(), coordinates.end(), coordinates.back()) > 1)
      throw std::invalid_argument("independent: '" + name + "' is named twice");
  }
  return coordinates;
}

template <class S>
IndependentCoordinates<S> make_independent_coordinates(SampledLoopVelocities<S>&& loops,
                                                       std::vector<CoordinateId> coordinates, std::string note) {
  const bool redundant = loops.tree.closure_rows > loops.tree.columns - loops.freedoms;
  return {std::move(loops.tree), std::move(loops.needed), std::move(coordinates), loops.freedoms, redundant,
          std::move(note)};
}

template <class S>
IndependentCoordinates<S> use_named_coordinates(const Mechanism& mechanism,
                                                const std::vector<CoordinateId>& coordinates) {
  SampledLoopVelocities<S> loops = sample_loop_velocities<S>(mechanism, coordinates);
  const std::string list = list_names(mechanism, coordinates);
  if (static_cast<int>(coordinates.size()) != loops.freedoms)
    throw std::invalid_argument("independent: " + std::to_string(coordinates.size()) + " coordinates (" + list +
                                ") for " + std::to_string(loops.freedoms) + " degrees of freedom");
  if (!can_determine_motion(loops, coordinates))
    throw std::invalid_argument("independent: " + list + " do not determine the other coordinates");
  return make_independent_coordinates(std::move(loops), coordinates, "");
}

}  // namespace

template <class S>
IndependentCoordinates<S> choose_independent_coordinates(const Mechanism& mechanism,
                                                         const std::vector<std::string>& names) {
  if (!names.empty()) return use_named_coordinates<S>(mechanism, find_named_coordinates(mechanism, names));
  std::vector<CoordinateId> coordinates;
  for (int attempt = 0; attempt < 4; ++attempt) {
    SampledLoopVelocities<S> loops = sample_loop_velocities<S>(mechanism, coordinates);
    if (attempt == 0 && can_determine_motion(loops, mechanism.actuators))
      return make_independent_coordinates(std::move(loops), mechanism.actuators, "");
    coordinates = pick_independent(mechanism, loops);
    // needed coordinates do not float; compiling with them may release a locked passive freedom
    const bool has_no_floating = !has_floating(loops.tree, coordinates);
    if (has_no_floating && can_determine_motion(loops, coordinates)) {
      const std::string note = "independent coordinates: " + list_names(mechanism, coordinates);
      return make_independent_coordinates(std::move(loops), coordinates, note);
    }
  }
  throw UnsolvableMechanism({MotionStatus::mismatch, 0, "no joint coordinates determine the motion", {}});
}

template IndependentCoordinates<Planar> choose_independent_coordinates<Planar>(const Mechanism&,
                                                                               const std::vector<std::string>&);
template IndependentCoordinates<Spatial> choose_independent_coordinates<Spatial>(const Mechanism&,
                                                                                 const std::vector<std::string>&);

}  // namespace balance::kinematics
