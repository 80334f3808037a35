#include "balance/synthesis/design/unbalanced_remainder.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace balance {

namespace {

constexpr long max_remainder_samples = 1001;

/// The mechanism without what stays of an element; nothing if masses could help with all of it.
std::optional<Mechanism> remove_element(const Mechanism& mechanism, const UnbalanceableElement& remainder,
                                        const Conditions& conditions) {
  Mechanism other = mechanism;
  bool changed = false;
  const auto i = static_cast<std::size_t>(remainder.index);
  for (const int t : remainder.terms) {
    const Parameter& term = conditions.parameters[static_cast<std::size_t>(t)];
    if (!is_load_change(term) && !conditions.matrix.col(t).head(conditions.parameter_rows()).isZero(0)) continue;
    changed = true;
    if (term.owner_kind == ParameterOwner::friction) {
      friction_coefficient(other.friction[i], term) = 0;
    } else if (is_load_change(term)) {
      other.loads[i].time.clear();
      other.loads[i].force.resize(1);
      other.loads[i].moment.resize(1);
    } else {
      const bool couple = term.kind == ParameterKind::couple;
      const int axis = term.symbol == "m" ? 2 : term.symbol[1] - 'x';
      for (Vector3& value : couple ? other.loads[i].moment : other.loads[i].force) value[axis] = 0;
    }
  }
  return changed ? std::optional(other) : std::nullopt;
}

RunResult simulate_samples(const Mechanism& mechanism, const Trajectory& trajectory) {
  try {
    return simulate(mechanism, trajectory);
  } catch (const std::invalid_argument& error) {
    RunResult result;
    result.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
    return result;
  }
}

void add_efforts(const RunResult& with, const RunResult& less, const std::string& trajectory,
                 UnbalancedRemainder& staying) {
  const Samples difference = with.torque - less.torque;
  for (Eigen::Index a = 0; a < difference.cols(); ++a) {
    const double size = max_abs(difference.col(a));
    if (!(size > 1e-12 * max_abs(with.torque.col(a)))) continue;
    const auto actuator = static_cast<std::size_t>(a);
    staying.efforts.push_back({trajectory, with.actuator_names[actuator], with.actuator_units[actuator], size});
  }
}

/// A spring has no fixed part to take away: its stiffness is a parameter.
bool is_removable(const UnbalancedRemainder& staying) { return staying.element.bearer != ParameterOwner::spring; }

}  // namespace

std::vector<UnbalancedRemainder> list_unbalanced_remainders(const Mechanism& mechanism,
                                                            const std::vector<Trajectory>& trajectories,
                                                            const Conditions& conditions,
                                                            const ConditionOptions& options) {
  const VectorX values = term_values(mechanism, options.loose_springs);
  std::vector<UnbalancedRemainder> all;
  for (const UnbalanceableElement& remainder :
       list_unbalanceable_elements(conditions, values, mechanism, condition_tolerance)) {
    UnbalancedRemainder staying{
        remainder, unbalanceable_element_text(remainder, conditions, values, mechanism), {}, {}};
    for (const PeakEffort& effort : find_peak_static_efforts(mechanism, conditions, remainder, options)) {
      const Coordinate& coordinate = mechanism.coordinates[static_cast<std::size_t>(effort.actuator)];
      if (!std::isfinite(effort.magnitude)) {
        staying.failed_trajectories.push_back(
            {"", "the effort of " + coordinate.name + " grows too large to be computed with"});
        continue;
      }
      staying.efforts.push_back(
          {"", coordinate.name, coordinate.kind == CoordinateKind::length ? "N" : "N m", effort.magnitude});
    }
    all.push_back(std::move(staying));
  }
  if (std::none_of(all.begin(), all.end(), is_removable) || mechanism.actuators.empty()) return all;
  for (Trajectory trajectory : trajectories) {
    trajectory.samples = std::min(trajectory.samples, max_remainder_samples);
    const RunResult with = simulate_samples(mechanism, trajectory);
    for (UnbalancedRemainder& staying : all) {
      const auto other =
          is_removable(staying) ? remove_element(mechanism, staying.element, conditions) : std::optional<Mechanism>();
      if (!other) continue;
      const RunResult less = with.outcome.status == MotionStatus::done ? simulate_samples(*other, trajectory) : with;
      if (less.outcome.status == MotionStatus::done)
        add_efforts(with, less, trajectory.name, staying);
      else
        staying.failed_trajectories.push_back({trajectory.name, less.outcome.reason});
    }
  }
  return all;
}

}  // namespace balance
