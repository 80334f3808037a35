#include "balance/synthesis/verification/formulation_check.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/verification/natural_momentum.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance {

namespace {

/// A force that is zero, or nearly so, is measured by what it is the small sum of: by this part of energy / length.
constexpr double min_relative_force_scale = 1e-3;

/// With a mobility below this, what round-off leaves in positions is magnified: by its inverse in them, by its square in rates.
constexpr double mobility_threshold = 0.02;

/// Sizes that the run as a whole suggests. Positions are measured by the characteristic length, rates and accelerations by the
/// largest of any joint: what does not move in all the motion is no less accurate than that.
struct QuantityScales {
  double length = 1, duration = 1, energy = 0, rate = 0, acceleration = 0;

  QuantityScales(const Mechanism& mechanism, const RunResult& r) : length(characteristic_length(mechanism)) {
    duration = r.time[r.time.size() - 1] - r.time[0];
    for (std::size_t c = 0; c < r.coordinate_units.size(); ++c) {
      const double unit = r.coordinate_units[c] == "m" ? length : 1;
      const auto column = static_cast<Eigen::Index>(c);
      rate = std::max(rate, max_abs(r.joint_velocity.col(column)) / unit);
      acceleration = std::max(acceleration, max_abs(r.joint_acceleration.col(column)) / unit);
    }
    acceleration = std::max(acceleration, rate * rate);
    const auto span = [](const Samples& s) { return s.size() == 0 ? 0.0 : max_coefficient(s) - min_coefficient(s); };
    energy = std::max({max_coefficient(r.kinetic_energy), span(r.potential_energy),
                       total_mass(mechanism) * mechanism.gravity.norm() * length});
    for (Eigen::Index a = 0; a < r.torque.cols(); ++a)
      energy = std::max(energy,
                        max_abs(r.torque.col(a)) * (r.actuator_units[static_cast<std::size_t>(a)] == "N" ? length : 1));
  }

  /// Of a unit such as "m/s^2".
  double of(const std::string& unit) const {
    if (unit == "rad") return 1;
    if (unit == "m") return length;
    if (unit == "rad/s") return rate;
    if (unit == "m/s") return length * rate;
    if (unit == "rad/s^2") return acceleration;
    if (unit == "m/s^2") return length * acceleration;
    if (unit == "N") return min_relative_force_scale * energy / length;
    if (unit == "W") return min_relative_force_scale * energy * std::max(rate, 1 / duration);
    return min_relative_force_scale * energy;  // N m, J
  }
};

/// Samples at which friction's sign is anybody's guess: the velocity of a coordinate with dry friction is round-off.
std::vector<bool> find_friction_reversals(const Mechanism& mechanism, const RunResult& r) {
  std::vector<bool> dead(static_cast<std::size_t>(r.time.size()), false);
  for (const Friction& friction : mechanism.friction) {
    if (friction.dry_friction(1) == 0 && friction.dry_friction(-1) == 0) continue;
    const auto rate = r.joint_velocity.col(friction.coordinate);
    const double least = 1e-9 * max_abs(rate);
    for (Eigen::Index k = 0; k < rate.size(); ++k)
      if (std::abs(rate[k]) <= least) dead[static_cast<std::size_t>(k)] = true;
  }
  return dead;
}

class FormulationComparison {
 public:
  FormulationComparison(const Mechanism& mechanism, const RunResult& tree, const RunResult& natural)
      : tree_(tree), natural_(natural), scales_(mechanism, tree), dead_(find_friction_reversals(mechanism, tree)) {}

  std::vector<QuantityDifference> run() {
    for (const Quantity& quantity : list_sampled_quantities(tree_)) {
      if ((natural_.*quantity.member).size() == 0) continue;
      const std::string unit = common_unit(quantity.units);
      if (unit != "mixed") {
        compare(quantity, quantity.name, unit);
        continue;
      }
      const bool efforts = quantity.name == "torque";
      compare(quantity, quantity.name + (efforts ? " (motors that turn)" : " (angles)"), quantity.units, true);
      compare(quantity, quantity.name + (efforts ? " (motors that push)" : " (slides)"), quantity.units, false);
    }
    return std::move(all_);
  }

 private:
  void compare(const Quantity& quantity, const std::string& name, const std::vector<std::string>& units, bool turning) {
    std::vector<Eigen::Index> columns;
    std::string unit;
    for (std::size_t c = 0; c < units.size(); ++c) {
      if ((units[c].starts_with("rad") || units[c] == "N m") != turning) continue;
      columns.push_back(static_cast<Eigen::Index>(c));
      unit = units[c];
    }
    compare(quantity, name, unit, columns);
  }

  void compare(const Quantity& quantity, const std::string& name, const std::string& unit) {
    std::vector<Eigen::Index> columns;
    for (Eigen::Index c = 0; c < quantity.samples->cols(); ++c) columns.push_back(c);
    compare(quantity, name, unit, columns);
  }

  void compare(const Quantity& quantity, const std::string& name, const std::string& unit,
               const std::vector<Eigen::Index>& columns) {
    const Samples &a = tree_.*quantity.member, &b = natural_.*quantity.member;
    QuantityDifference worst{name, unit, 0, tree_.time[0], scales_.of(unit)};
    const bool friction = quantity.name == "torque" || quantity.name == "power";
    for (const Eigen::Index c : columns) {
      // What cancels is measured by what it is the sum of, anywhere along the motion.
      worst.scale = std::max(worst.scale, column_term_magnitude(tree_, tree_.term_magnitudes, quantity.member, c));
      double turns = 0;  // a tool's whole turns at the start are a matter of counting
      if (quantity.name == "tool_orientation")
        turns = 2 * std::numbers::pi * std::round((a(0, c) - b(0, c)) / (2 * std::numbers::pi));
      for (Eigen::Index k = 0; k < a.rows(); ++k) {
        if (friction && dead_[static_cast<std::size_t>(k)]) continue;
        const double off = std::abs(a(k, c) - b(k, c) - turns);
        if (unit != "rad" && unit != "m") worst.scale = std::max(worst.scale, std::abs(a(k, c)));
        if (off <= worst.difference) continue;
        worst.difference = off == off ? off : INFINITY;
        worst.time = tree_.time[k];
      }
    }
    all_.push_back(worst);
  }

  const RunResult &tree_, &natural_;
  QuantityScales scales_;
  std::vector<bool> dead_;
  std::vector<QuantityDifference> all_;
};

/// Orthonormal basis of the row space, in comparable units.
MatrixX row_space(const MatrixX& rows, const VectorX& unit) {
  const SingularValueDecomposition svd(rows * unit.asDiagonal(), Eigen::ComputeThinV);
  return svd.matrixV().leftCols(rows.rows());
}

}  // namespace

TrajectoryVerification verify_trajectory(const Mechanism& mechanism, const Trajectory& trajectory) {
  TrajectoryVerification found;
  found.trajectory = trajectory.name;
  const RunResult tree = simulate(mechanism, trajectory), natural = simulate_natural(mechanism, trajectory);
  found.tree = tree.outcome;
  found.natural = natural.outcome;
  const bool moved = tree.outcome.status == MotionStatus::done;
  found.is_consistent = moved == (natural.outcome.status == MotionStatus::done);
  if (!found.is_consistent || !moved) return found;
  found.samples = static_cast<long>(tree.time.size());
  found.differences = FormulationComparison(mechanism, tree, natural).run();
  const double hard = mobility_threshold / std::max(1e-6, min_coefficient(tree.mobility));
  found.tolerance = verify_tolerance * std::max(1.0, hard * hard);
  for (const QuantityDifference& difference : found.differences)
    found.is_consistent = found.is_consistent && difference.relative() <= found.tolerance;
  return found;
}

ConditionsVerification verify_conditions(const Study& study) {
  ConditionsVerification found;
  const auto nothing = [&](std::string reason) {
    found.reason = std::move(reason);
    found.is_consistent = true;
    return found;
  };
  if (!study.temporary_payloads.empty()) return nothing("payloads come and go");
  const Mechanism mechanism = assembled_at(study.mechanism, start_coordinates(study));
  NaturalStart start;
  if (!study.trajectories.empty()) start = find_natural_start(mechanism, study.trajectories.front());
  if (start.outcome.status != MotionStatus::done) start = find_natural_start(mechanism);  // conditions need no drive
  if (start.outcome.status != MotionStatus::done) return nothing(start.outcome.reason);
  const Conditions sampled = derive_conditions(mechanism, {{GoalKind::force}});
  if (sampled.status != ConditionsStatus::done) return nothing(sampled.reason);
  const natural::ForceConditions read_off = natural::force_conditions(mechanism, start.start);
  if (!read_off.is_valid) return nothing(read_off.reason);
  found.sampled = sampled.rank;
  found.coefficients = static_cast<int>(read_off.matrix.rows());
  const Eigen::Index inertial = read_off.matrix.cols();
  VectorX unit(inertial);
  for (Eigen::Index p = 0; p < inertial; ++p)
    unit[p] =
        elementary::pow(characteristic_length(mechanism), sampled.parameters[static_cast<std::size_t>(p)].length_power);
  found.subspace_angle_sine = found.sampled == found.coefficients ? 0 : 1;
  if (found.sampled > 0 && found.sampled == found.coefficients) {
    const MatrixX a = row_space(sampled.matrix.leftCols(inertial), unit), b = row_space(read_off.matrix, unit);
    found.subspace_angle_sine = (b - a * (a.transpose() * b)).norm();
  }
  found.is_consistent = found.subspace_angle_sine <= verify_tolerance;
  return found;
}

VerifyReport verify_formulations(const Study& study) {
  if (study.mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("there is no second formulation for spatial mechanisms");
  if (has_velocity_constraints(study.mechanism))
    throw std::invalid_argument("there is no second formulation for mechanisms with constraints on speeds");
  VerifyReport report;
  report.conditions = verify_conditions(study);
  report.is_consistent = report.conditions.is_consistent;
  for (const Trajectory& trajectory : study.trajectories) {
    report.trajectories.push_back(verify_trajectory(study.mechanism, trajectory));
    const TrajectoryVerification& last = report.trajectories.back();
    report.is_consistent = report.is_consistent && last.is_consistent;
    if (report.failed_outcome.status == MotionStatus::done && last.tree.status != MotionStatus::done &&
        last.natural.status != MotionStatus::done)
      report.failed_outcome = last.tree;
  }
  return report;
}

}  // namespace balance
