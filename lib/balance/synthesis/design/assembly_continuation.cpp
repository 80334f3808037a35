#include "balance/synthesis/design/assembly_continuation.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/block_triangular.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/kinematics/space.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/synthesis/design/geometry_features.hpp"
#include "balance/synthesis/design/required_motions.hpp"
#include "balance/synthesis/design/trajectory_cost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance::design {

namespace {

/// Largest first Newton step, in radians or characteristic lengths, and largest ratio of the second to the first step,
/// with which the corrector stays in its mode. Source of the ratio: Deuflhard, Newton Methods for Nonlinear Problems,
/// Springer 2004, section 5.1 (affine covariant continuation, contraction at most 1/4).
constexpr double max_corrector_step = 0.4, max_contraction = 0.25;
/// Steps below these need no contraction, or are round-off.
constexpr double negligible_step = 1e-9, round_off_step = 1e-13;
/// Smallest part of the way that is tried in one step, and the number of steps.
constexpr double min_fraction = 1.0 / 512;
constexpr int max_steps = 400;
/// Numbers of configurations that are kept as starts.
constexpr std::size_t max_known_configurations = 400, max_tried_starts = 3;

/// Marks the inputs of a recording that some of its expressions depend on.
class InputDependence {
 public:
  explicit InputDependence(const study::Recording& recording)
      : recording_(recording), is_needed_(recording.graph.nodes().size(), false) {}

  void add(const Expression& expression) {
    if (!expression.is_constant()) is_needed_[static_cast<std::size_t>(expression.node())] = true;
  }

  /// In ascending order.
  std::vector<std::size_t> inputs() {
    std::vector<bool> is_input_needed(recording_.inputs.size(), false);
    const std::vector<expression::ExpressionNode>& nodes = recording_.graph.nodes();
    for (std::size_t k = nodes.size(); k-- > 0;) {  // arguments come before the nodes that use them
      if (!is_needed_[k]) continue;
      if (nodes[k].input >= 0) is_input_needed[static_cast<std::size_t>(nodes[k].input)] = true;
      for (const int argument : nodes[k].arguments)
        if (argument >= 0) is_needed_[static_cast<std::size_t>(argument)] = true;
    }
    std::vector<std::size_t> inputs;
    for (std::size_t i = 0; i < is_input_needed.size(); ++i)
      if (is_input_needed[i]) inputs.push_back(i);
    return inputs;
  }

 private:
  const study::Recording& recording_;
  std::vector<bool> is_needed_;
};

/// The inputs of lengths, ratios and motions: masses and stiffnesses do not change the configuration of a start pose,
/// unless it is given by the centre of mass.
std::vector<std::size_t> list_pose_inputs(const study::Recording& recording, const Trajectory& first_trajectory) {
  InputDependence dependence(recording);
  const auto add = [&](const Expression& expression) {
    dependence.add(expression);
    return 0.0;
  };
  model::convert_mechanism<double>(
      is_mass_dependent(first_trajectory) ? recording.mechanism : without_masses(recording.mechanism), add);
  for (const TrajectoryOf<Expression>& trajectory : recording.trajectories)
    trajectory::cast_scalar<double>(trajectory, add);
  return dependence.inputs();
}

/// A configuration of the start pose for some numbers.
struct KnownConfiguration {
  std::vector<double> inputs;
  bool is_assembled = false;                 ///< in the mode of the start values
  VectorX y;                                 ///< tree coordinates, if assembled
  int orientation = 0;                       ///< sign of the Jacobian's determinant; 0: unknown
  std::vector<CoordinateValue> coordinates;  ///< in any mode that is allowed; empty: none
};

template <class S>
class AssemblyContinuation final : public study::AssemblyModeSelector {
 public:
  AssemblyContinuation(const DesignSpace& space, bool keeps_mode)
      : recording_(space.recording),
        keeps_mode_(keeps_mode),
        pose_inputs_(list_pose_inputs(*space.recording, space.start.trajectories.front())),
        scale_(space.inputs.size(), 0),
        start_inputs_(space.inputs) {
    const VectorX start = space.start_values();
    for (std::size_t i = 0; i < space.free_inputs.size(); ++i) {
      const auto input = static_cast<std::size_t>(space.free_inputs[i]);
      const FreeNumber& number = space.start.free_numbers[i];
      start_inputs_[input] = start[static_cast<Eigen::Index>(i)];
      scale_[input] = number.upper - number.lower;
    }
    for (std::size_t i = 0; i < scale_.size(); ++i)
      if (!(scale_[i] > 0)) scale_[i] = std::max(std::abs(start_inputs_[i]), 1e-6);
  }

  /// @return whether the start values can be assembled, and every trajectory begins in the mode of the first
  bool begin(const Study& start) {
    KnownConfiguration first{start_inputs_, true, {}, 0, {}};
    Mechanism mechanism = start.mechanism;
    {
      const Pose pose(mechanism, start.trajectories.front());
      if (pose.tree.closure_rows == 0 || pose.tree.columns > numerics::max_dense_columns) return false;
      kinematics::ConstraintSystem<S> system(pose.tree, pose.equations.drive);
      const kinematics::AssemblySolution solution = solve_pose(mechanism, pose.tree, system, pose.equations.target);
      if (!solution.found || !is_determinate(system, solution.y, pose.equations.target)) return false;
      first.y = solution.y;
      first.orientation = orientation(system, first.y, pose.equations.target);
      first.coordinates = coordinates_of(mechanism, pose.tree, first.y);
    }
    mechanism.assembly = first.coordinates;
    for (const Trajectory& trajectory : start.trajectories)
      if (!has_same_mode(start.mechanism, mechanism, trajectory)) return false;
    known_.push_back(std::move(first));
    return true;
  }

  void select(const std::vector<double>& inputs, study::DesignInstance& instance) const override {
    const KnownConfiguration& known = find(inputs, instance);
    if (known.coordinates.empty())
      instance.mode_issue = "the assembly mode of the start values ends on the way to these lengths";
    else
      instance.mechanism.assembly = known.coordinates;
    instance.is_other_mode = !known.is_assembled && !known.coordinates.empty();
  }

 private:
  /// The equations of the start pose.
  struct Pose {
    Pose(const Mechanism& mechanism, const Trajectory& trajectory)
        : tree(kinematics::compile_tree<S>(mechanism, prescribed_coordinates(trajectory))),
          equations(make_pose_equations(mechanism, tree, trajectory.from)) {}

    kinematics::Tree<S> tree;
    kinematics::PoseEquations<S> equations;
  };

  static std::vector<CoordinateValue> coordinates_of(const Mechanism& mechanism, const kinematics::Tree<S>& tree,
                                                     const VectorX& y) {
    const std::vector<double> values = compute_coordinates(mechanism, tree, y);
    std::vector<CoordinateValue> coordinates;
    for (std::size_t c = 0; c < values.size(); ++c) coordinates.push_back({static_cast<int>(c), values[c]});
    return coordinates;
  }

  /// Whether a trajectory begins in the same configuration with both assembly values.
  static bool has_same_mode(const Mechanism& a, const Mechanism& b, const Trajectory& trajectory) {
    const Pose pose(a, trajectory);
    kinematics::ConstraintSystem<S> system(pose.tree, pose.equations.drive);
    const kinematics::AssemblySolution p = solve_pose(a, pose.tree, system, pose.equations.target);
    const kinematics::AssemblySolution q = solve_pose(b, pose.tree, system, pose.equations.target);
    if (!p.found || !q.found) return p.found == q.found;
    constexpr double mode_tolerance = 1e-6;
    const std::vector<CoordinateValue> u = coordinates_of(a, pose.tree, p.y), v = coordinates_of(a, pose.tree, q.y);
    for (std::size_t c = 0; c < u.size(); ++c) {
      const bool is_angle = a.coordinates[c].kind == CoordinateKind::angle;
      const double deviation = is_angle ? kinematics::unwrap_angle(u[c].value, v[c].value) - v[c].value
                                        : (u[c].value - v[c].value) / pose.tree.characteristic_length;
      if (std::abs(deviation) > mode_tolerance) return false;
    }
    return true;
  }

  /// Whether the pose determines all coordinates near y.
  static bool is_determinate(kinematics::ConstraintSystem<S>& system, const VectorX& y,
                             const trajectory::DriveSample& target) {
    VectorX residual;
    MatrixX jacobian;
    system.evaluate(y, target, residual, jacobian);
    return kinematics::decompose_rank(jacobian).rank == system.columns();
  }

  /// Sign of the Jacobian's determinant, which changes only at singular configurations; 0 if it is not square.
  static int orientation(kinematics::ConstraintSystem<S>& system, const VectorX& y,
                         const trajectory::DriveSample& target) {
    VectorX residual;
    MatrixX jacobian;
    system.evaluate(y, target, residual, jacobian);
    if (jacobian.rows() != jacobian.cols()) return 0;
    const double determinant = Eigen::PartialPivLU<MatrixX>(jacobian).determinant();
    return determinant > 0 ? 1 : determinant < 0 ? -1 : 0;
  }

  /// Between the numbers that change the pose; zero only if they are equal.
  double distance(const std::vector<double>& a, const std::vector<double>& b) const {
    double sum = 0;
    bool is_equal = true;
    for (const std::size_t i : pose_inputs_) {
      const double deviation = (a[i] - b[i]) / scale_[i];
      sum += deviation * deviation;
      is_equal = is_equal && a[i] == b[i];
    }
    return is_equal ? 0 : std::max(sum, std::numeric_limits<double>::min());
  }

  const KnownConfiguration& find(const std::vector<double>& inputs, const study::DesignInstance& instance) const {
    std::vector<std::pair<double, std::size_t>> starts;
    for (std::size_t k = 0; k < known_.size(); ++k) {
      const double separation = distance(known_[k].inputs, inputs);
      if (separation == 0) return known_[k];
      if (known_[k].is_assembled) starts.emplace_back(separation, k);
    }
    std::sort(starts.begin(), starts.end());
    if (starts.size() > max_tried_starts) starts.resize(max_tried_starts);
    starts.emplace_back(0, 0);  // the start values themselves
    KnownConfiguration result{inputs, false, {}, 0, {}};
    for (const auto& [separation, k] : starts)
      if (follow(known_[k], instance, result)) break;
    if (!result.is_assembled && !keeps_mode_) result.coordinates = assemble_nearby(instance);
    if (known_.size() < max_known_configurations) {
      known_.push_back(std::move(result));
      return known_.back();
    }
    next_replaced_ = 1 + next_replaced_ % (max_known_configurations - 1);  // the start values stay
    return known_[next_replaced_] = std::move(result);
  }

  /// Moves all numbers along the straight line from those of a known configuration to those of the result.
  bool follow(const KnownConfiguration& from, const study::DesignInstance& instance, KnownConfiguration& result) const {
    VectorX y = from.y;
    double done = 0, fraction = 1;
    for (int step = 0; step < max_steps && fraction >= min_fraction; ++step) {
      const double next = std::min(1.0, done + fraction);
      std::optional<VectorX> moved;
      if (next == 1) {
        moved = correct(instance.mechanism, instance.trajectories.front(), y, from.orientation);
      } else {
        std::vector<double> inputs = result.inputs;
        for (std::size_t i = 0; i < inputs.size(); ++i)
          inputs[i] = from.inputs[i] + next * (result.inputs[i] - from.inputs[i]);
        const study::RecordedValues<double> values(*recording_, inputs);
        moved = correct(values.mechanism(), values.trajectories().front(), y, from.orientation);
      }
      if (!moved) {
        fraction /= 4;
        continue;
      }
      y = std::move(*moved);
      done = next;
      fraction = std::min(2 * fraction, 1 - done);
      if (done < 1) continue;
      const kinematics::Tree<S> tree =
          kinematics::compile_tree<S>(instance.mechanism, prescribed_coordinates(instance.trajectories.front()));
      result.coordinates = coordinates_of(instance.mechanism, tree, y);
      result.y = std::move(y);
      result.orientation = from.orientation;
      return result.is_assembled = true;
    }
    return false;
  }

  /// The configuration nearest to the spec's `assembly`, or else to that of the start values; empty without one.
  std::vector<CoordinateValue> assemble_nearby(const study::DesignInstance& instance) const {
    Mechanism mechanism = instance.mechanism;
    for (const std::vector<CoordinateValue>& guess : {instance.mechanism.assembly, known_.front().coordinates}) {
      mechanism.assembly = guess;
      const Pose pose(mechanism, instance.trajectories.front());
      kinematics::ConstraintSystem<S> system(pose.tree, pose.equations.drive);
      const kinematics::AssemblySolution solution = solve_pose(mechanism, pose.tree, system, pose.equations.target);
      if (solution.found) return coordinates_of(mechanism, pose.tree, solution.y);
    }
    return {};
  }

  /// Newton's method from a neighbouring configuration. @return std::nullopt if it does not contract clearly, so that it
  /// might end in another mode
  std::optional<VectorX> correct(const Mechanism& mechanism, const Trajectory& trajectory, const VectorX& from,
                                 int expected_orientation) const {
    const Pose pose(mechanism, trajectory);
    if (pose.tree.columns != from.size()) return std::nullopt;
    kinematics::ConstraintSystem<S> system(pose.tree, pose.equations.drive);
    const trajectory::DriveSample& target = pose.equations.target;
    const VectorX scale = column_scale(pose.tree);
    VectorX y = from, residual;
    MatrixX jacobian;
    numerics::CompleteOrthogonalDecomposition qr;
    qr.setThreshold(1e-9);
    double previous = max_corrector_step / max_contraction;
    for (int iteration = 0; iteration < 2; ++iteration) {
      system.evaluate(y, target, residual, jacobian);
      if (!residual.allFinite() || !jacobian.allFinite()) return std::nullopt;
      const VectorX step = qr.compute(jacobian).solve(residual);
      const double size = numerics::max_abs(step);
      if (iteration == 0 && size <= round_off_step) return from;  // only masses differ
      if (!(size <= std::max(max_contraction * previous, negligible_step))) return std::nullopt;
      y -= scale.cwiseProduct(step);
      previous = size;
    }
    const kinematics::AssemblySolution closed = solve_assembly(system, y, target, 20);
    if (!closed.found) return std::nullopt;
    const double correction = numerics::max_abs((closed.y - y).cwiseQuotient(scale));
    if (!(correction <= std::max(previous, negligible_step))) return std::nullopt;
    if (expected_orientation != 0 && orientation(system, closed.y, target) != expected_orientation) return std::nullopt;
    return closed.y;
  }

  std::shared_ptr<const study::Recording> recording_;
  bool keeps_mode_;
  std::vector<std::size_t> pose_inputs_;
  std::vector<double> scale_;  ///< per input, for distances
  std::vector<double> start_inputs_;
  mutable std::vector<KnownConfiguration> known_;  ///< the first is that of the start values
  mutable std::size_t next_replaced_ = 0;
};

/// Whether some free number changes lengths, ratios, or the start pose of the first trajectory.
bool has_variable_geometry(const DesignSpace& space) {
  const VectorX start = space.start_values();
  const VectorX lengths = collect_geometry(space.start.mechanism, {});
  const auto pose_of = [](const study::DesignInstance& instance) {
    std::vector<double> values;
    const trajectory::PoseTarget& from = instance.trajectories.front().from;
    for (const CoordinateValue& one : from.joints) values.push_back(one.value);
    if (from.tool) values.insert(values.end(), from.tool->begin(), from.tool->end());
    if (from.angle) values.push_back(*from.angle);
    if (from.orientation)
      for (const double entry : from.orientation->reshaped()) values.push_back(entry);
    return values;
  };
  const std::vector<double> start_pose = pose_of(space.instantiate(start));
  for (std::size_t i = 0; i < space.start.free_numbers.size(); ++i) {
    const FreeNumber& number = space.start.free_numbers[i];
    const auto k = static_cast<Eigen::Index>(i);
    VectorX x = start;
    x[k] = start[k] - number.lower > number.upper - start[k] ? (start[k] + number.lower) / 2
                                                             : (start[k] + number.upper) / 2;
    const study::DesignInstance changed = space.instantiate(x);
    if (!is_equal_to_rounding(collect_geometry(changed.mechanism, {}), lengths) || pose_of(changed) != start_pose)
      return true;
  }
  return false;
}

}  // namespace

bool keeps_assembly_mode(const study::DesignRequest& request, const std::vector<ObjectiveTerm>& terms) {
  if (request.keeps_assembly_mode) return *request.keeps_assembly_mode;
  const auto has_run = [](const std::vector<ObjectiveTerm>& all) {
    return std::any_of(all.begin(), all.end(),
                       [](const ObjectiveTerm& term) { return term.size == ObjectiveTerm::Size::none; });
  };
  return has_run(terms) || std::any_of(request.front.figures.begin(), request.front.figures.end(), has_run) ||
         std::any_of(request.subject_to.begin(), request.subject_to.end(),
                     [&](const study::FigureLimit& limit) { return has_run(limit.terms); });
}

DesignSpace follow_assembly_mode(DesignSpace space, bool keeps_mode) {
  if (space.assembly_mode || space.start.trajectories.empty() || !space.recording) return space;
  try {
    if (!has_variable_geometry(space)) return space;
    kinematics::dispatch_space(space.start.mechanism.space, [&]<class S>(S) {
      auto mode = std::make_shared<AssemblyContinuation<S>>(space, keeps_mode);
      if (mode->begin(space.start)) space.assembly_mode = std::move(mode);
    });
  } catch (const SpecError&) {
    // an expression of the spec has no value at some point
  } catch (const std::invalid_argument&) {
    // there is no motion
  }
  return space;
}

}  // namespace balance::design
