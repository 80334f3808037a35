#include "balance/synthesis/verification/formulation_check.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/verification/natural_momentum.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance::verification {

namespace {

/// Minimum scale of efforts relative to the energy: a force near zero is compared with the terms that cancel in it.
constexpr double min_relative_force_scale = 1e-3;

/// Below this mobility, round-off is amplified: by the inverse mobility in positions, by its square in rates.
constexpr double mobility_threshold = 0.02;

/// Scales of the run as a whole. Positions are compared with the characteristic length, rates and accelerations with
/// the largest of any joint: coordinates that never move are no less accurate than that.
struct QuantityScales {
  double length = 1, duration = 1, energy = 0, rate = 0, acceleration = 0;

  QuantityScales(const Mechanism& mechanism, const RunResult& r) : length(characteristic_length(mechanism)) {
    duration = r.time[r.time.size() - 1] - r.time[0];
    for (std::size_t c = 0; c < r.coordinate_units.size(); ++c) {
      const double unit = r.coordinate_units[c] == "m" ? length : 1;
      const auto column = static_cast<Eigen::Index>(c);
      rate = std::max(rate, numerics::max_abs(r.joint_velocity.col(column)) / unit);
      acceleration = std::max(acceleration, numerics::max_abs(r.joint_acceleration.col(column)) / unit);
    }
    acceleration = std::max(acceleration, rate * rate);
    const auto span = [](const Samples& s) {
      return s.size() == 0 ? 0.0 : numerics::max_coefficient(s) - numerics::min_coefficient(s);
    };
    energy = std::max({numerics::max_coefficient(r.kinetic_energy), span(r.potential_energy),
                       total_mass(mechanism) * mechanism.gravity.norm() * length});
    for (Eigen::Index a = 0; a < r.torque.cols(); ++a)
      energy = std::max(energy, numerics::max_abs(r.torque.col(a)) *
                                    (r.actuator_units[static_cast<std::size_t>(a)] == "N" ? length : 1));
  }

  /// Scale of a unit such as "m/s^2".
  double scale_of(const std::string& unit) const {
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

/// Samples at which the sign of friction is undetermined: the velocity of a coordinate with dry friction is round-off.
std::vector<bool> find_friction_reversals(const Mechanism& mechanism, const RunResult& r) {
  std::vector<bool> at_reversal(static_cast<std::size_t>(r.time.size()), false);
  for (const Friction& friction : mechanism.friction) {
    if (friction.dry_friction(1) == 0 && friction.dry_friction(-1) == 0) continue;
    const auto rate = r.joint_velocity.col(friction.coordinate);
    const double rest_rate = 1e-9 * numerics::max_abs(rate);
    for (Eigen::Index k = 0; k < rate.size(); ++k)
      if (std::abs(rate[k]) <= rest_rate) at_reversal[static_cast<std::size_t>(k)] = true;
  }
  return at_reversal;
}

class FormulationComparison {
 public:
  FormulationComparison(const Mechanism& mechanism, const RunResult& tree, const RunResult& natural)
      : tree_(tree),
        natural_(natural),
        scales_(mechanism, tree),
        at_friction_reversal_(find_friction_reversals(mechanism, tree)) {}

  std::vector<QuantityDifference> run() {
    for (const Quantity& quantity : list_sampled_quantities(tree_)) {
      if ((natural_.*quantity.member).size() == 0) continue;
      const std::string unit = results::common_unit(quantity.units);
      if (unit != "mixed") {
        compare(quantity, quantity.name, unit);
        continue;
      }
      const bool efforts = quantity.name == "torque";
      compare(quantity, quantity.name + (efforts ? " (motors that turn)" : " (angles)"), quantity.units, true);
      compare(quantity, quantity.name + (efforts ? " (motors that push)" : " (slides)"), quantity.units, false);
    }
    return std::move(differences_);
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
    QuantityDifference worst{name, unit, 0, tree_.time[0], scales_.scale_of(unit)};
    const bool friction = quantity.name == "torque" || quantity.name == "power";
    for (const Eigen::Index c : columns) {
      // A sum whose terms cancel is compared with these terms, anywhere along the motion.
      worst.scale = std::max(worst.scale, column_term_magnitude(tree_, tree_.term_magnitudes, quantity.member, c));
      double full_turns = 0;  // whole turns of a tool at the start depend on the counting
      if (quantity.name == "tool_orientation")
        full_turns = 2 * std::numbers::pi * std::round((a(0, c) - b(0, c)) / (2 * std::numbers::pi));
      for (Eigen::Index k = 0; k < a.rows(); ++k) {
        if (friction && at_friction_reversal_[static_cast<std::size_t>(k)]) continue;
        const double difference = std::abs(a(k, c) - b(k, c) - full_turns);
        if (unit != "rad" && unit != "m") worst.scale = std::max(worst.scale, std::abs(a(k, c)));
        if (difference <= worst.difference) continue;
        worst.difference = difference == difference ? difference : INFINITY;
        worst.time = tree_.time[k];
      }
    }
    differences_.push_back(worst);
  }

  const RunResult &tree_, &natural_;
  QuantityScales scales_;
  std::vector<bool> at_friction_reversal_;
  std::vector<QuantityDifference> differences_;
};

/// Orthonormal basis of the row space, in comparable units.
MatrixX row_space(const MatrixX& rows, const VectorX& unit) {
  const numerics::SingularValueDecomposition svd(rows * unit.asDiagonal(), Eigen::ComputeThinV);
  return svd.matrixV().leftCols(rows.rows());
}

}  // namespace

TrajectoryVerification verify_trajectory(const Mechanism& mechanism, const Trajectory& trajectory) {
  TrajectoryVerification result;
  result.trajectory = trajectory.name;
  const RunResult tree = simulate(mechanism, trajectory), natural = simulate_natural(mechanism, trajectory);
  result.tree = tree.outcome;
  result.natural = natural.outcome;
  const bool is_done = tree.outcome.status == MotionStatus::done;
  result.is_consistent = is_done == (natural.outcome.status == MotionStatus::done);
  if (!result.is_consistent || !is_done) return result;
  result.samples = static_cast<long>(tree.time.size());
  result.differences = FormulationComparison(mechanism, tree, natural).run();
  const double amplification = mobility_threshold / std::max(1e-6, numerics::min_coefficient(tree.mobility));
  result.tolerance = verify_tolerance * std::max(1.0, amplification * amplification);
  for (const QuantityDifference& difference : result.differences)
    result.is_consistent = result.is_consistent && difference.relative() <= result.tolerance;
  return result;
}

ConditionsVerification verify_conditions(const Study& study) {
  ConditionsVerification result;
  const auto skip = [&](std::string reason) {
    result.reason = std::move(reason);
    result.is_consistent = true;
    return result;
  };
  if (!study.temporary_payloads.empty()) return skip("payloads are picked up or set down");
  const Mechanism mechanism = simulation::assembled_at(study.mechanism, simulation::start_coordinates(study));
  NaturalStart start;
  if (!study.trajectories.empty()) {
    const time_optimal::ResolvedTrajectory first =
        time_optimal::resolve_trajectory(mechanism, study.trajectories.front());
    start.outcome = first.outcome;
    if (first.outcome.status == MotionStatus::done)
      start = first.trajectory.free_motion ? find_natural_start(mechanism)
                                           : find_natural_start(mechanism, first.trajectory);
  }
  if (start.outcome.status != MotionStatus::done) start = find_natural_start(mechanism);  // conditions need no drive
  if (start.outcome.status != MotionStatus::done) return skip(start.outcome.reason);
  const Conditions sampled = derive_conditions(mechanism, {{GoalKind::force}});
  if (sampled.status != ConditionsStatus::done) return skip(sampled.reason);
  const natural::ForceConditions from_coefficients = natural::force_conditions(mechanism, start.start);
  if (!from_coefficients.is_valid) return skip(from_coefficients.reason);
  result.sampled = sampled.rank;
  result.coefficients = static_cast<int>(from_coefficients.matrix.rows());
  const Eigen::Index parameter_count = from_coefficients.matrix.cols();
  VectorX unit(parameter_count);
  for (Eigen::Index p = 0; p < parameter_count; ++p)
    unit[p] =
        elementary::pow(characteristic_length(mechanism), sampled.parameters[static_cast<std::size_t>(p)].length_power);
  result.subspace_angle_sine = result.sampled == result.coefficients ? 0 : 1;
  if (result.sampled > 0 && result.sampled == result.coefficients) {
    const MatrixX a = row_space(sampled.matrix.leftCols(parameter_count), unit),
                  b = row_space(from_coefficients.matrix, unit);
    result.subspace_angle_sine = (b - a * (a.transpose() * b)).norm();
  }
  result.is_consistent = result.subspace_angle_sine <= verify_tolerance;
  return result;
}

VerifyReport verify_formulations(const Study& study) {
  if (study.mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("there is no second formulation for spatial mechanisms");
  if (has_velocity_constraints(study.mechanism))
    throw std::invalid_argument("there is no second formulation for mechanisms with constraints on speeds");
  VerifyReport report;
  // Laws and paths that depend on the mechanism are found once: both formulations run the same motion.
  Study resolved_study = study;
  for (Trajectory& trajectory : resolved_study.trajectories) {
    check_timing(trajectory);
    time_optimal::ResolvedTrajectory resolved = time_optimal::resolve_trajectory(study.mechanism, trajectory);
    if (resolved.outcome.status == MotionStatus::done) trajectory = std::move(resolved.trajectory);
  }
  report.conditions = verify_conditions(resolved_study);
  report.is_consistent = report.conditions.is_consistent;
  for (const Trajectory& trajectory : resolved_study.trajectories) {
    report.trajectories.push_back(verify_trajectory(study.mechanism, trajectory));
    const TrajectoryVerification& last = report.trajectories.back();
    report.is_consistent = report.is_consistent && last.is_consistent;
    if (report.failed_outcome.status == MotionStatus::done && last.tree.status != MotionStatus::done &&
        last.natural.status != MotionStatus::done)
      report.failed_outcome = last.tree;
  }
  return report;
}

}  // namespace balance::verification
