#include "balance/synthesis/design/unbalanced_remainder.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace balance::design {

namespace {

constexpr long max_remainder_samples = 1001;

/// The mechanism without the unbalanceable part of an element; std::nullopt if masses can influence all of it.
std::optional<Mechanism> remove_element(const Mechanism& mechanism, const conditions::UnbalanceableElement& remainder,
                                        const Conditions& conditions) {
  Mechanism reduced_mechanism = mechanism;
  bool changed = false;
  const auto i = static_cast<std::size_t>(remainder.index);
  for (const int t : remainder.terms) {
    const dynamics::Parameter& term = conditions.parameters[static_cast<std::size_t>(t)];
    if (!conditions::is_load_change(term) && !conditions.matrix.col(t).head(conditions.parameter_rows()).isZero(0))
      continue;
    changed = true;
    if (term.owner_kind == dynamics::ParameterOwner::force_element) {
      ForceElement& element = reduced_mechanism.force_elements[i];
      element.damping = 0;
      std::fill(element.table.force.begin(), element.table.force.end(), 0.0);
    } else if (term.owner_kind == dynamics::ParameterOwner::friction) {
      conditions::friction_coefficient(reduced_mechanism.friction[i], term) = 0;
    } else if (conditions::is_load_change(term)) {
      reduced_mechanism.loads[i].arguments.clear();
      reduced_mechanism.loads[i].force.resize(1);
      reduced_mechanism.loads[i].moment.resize(1);
    } else {
      const bool couple = term.kind == dynamics::ParameterKind::couple;
      const int axis = term.symbol.starts_with("m") && mechanism.space == SpaceKind::planar ? 2 : term.symbol[1] - 'x';
      for (Vector3& value : couple ? reduced_mechanism.loads[i].moment : reduced_mechanism.loads[i].force)
        value[axis] = 0;
    }
  }
  return changed ? std::optional(reduced_mechanism) : std::nullopt;
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

void add_efforts(const RunResult& complete_run, const RunResult& reduced_run, const std::string& trajectory,
                 UnbalancedRemainder& entry) {
  const Samples difference = complete_run.torque - reduced_run.torque;
  for (Eigen::Index a = 0; a < difference.cols(); ++a) {
    const double size = numerics::max_abs(difference.col(a));
    if (!(size > 1e-12 * numerics::max_abs(complete_run.torque.col(a)))) continue;
    const auto actuator = static_cast<std::size_t>(a);
    entry.efforts.push_back(
        {trajectory, complete_run.actuator_names[actuator], complete_run.actuator_units[actuator], size});
  }
}

/// A spring has no constant part that could be removed: its stiffness is a parameter.
bool is_removable(const UnbalancedRemainder& entry) { return entry.element.bearer != dynamics::ParameterOwner::spring; }

}  // namespace

std::vector<UnbalancedRemainder> list_unbalanced_remainders(const Mechanism& mechanism,
                                                            const std::vector<Trajectory>& trajectories,
                                                            const Conditions& conditions,
                                                            const ConditionOptions& options) {
  const VectorX values = conditions::term_values(mechanism, options.loose_springs);
  std::vector<UnbalancedRemainder> all;
  for (const conditions::UnbalanceableElement& remainder :
       list_unbalanceable_elements(conditions, values, mechanism, condition_tolerance)) {
    UnbalancedRemainder entry{remainder, unbalanceable_element_text(remainder, conditions, values), {}, {}};
    for (const conditions::PeakEffort& effort : find_peak_static_efforts(mechanism, conditions, remainder, options)) {
      const Coordinate& coordinate = mechanism.coordinates[static_cast<std::size_t>(effort.actuator)];
      if (!std::isfinite(effort.magnitude)) {
        entry.failed_trajectories.push_back(
            {"", "the effort of " + coordinate.name + " becomes too large to represent"});
        continue;
      }
      entry.efforts.push_back(
          {"", coordinate.name, coordinate.kind == CoordinateKind::length ? "N" : "N m", effort.magnitude});
    }
    all.push_back(std::move(entry));
  }
  if (std::none_of(all.begin(), all.end(), is_removable) || mechanism.actuators.empty()) return all;
  for (Trajectory trajectory : trajectories) {
    trajectory.samples = std::min(trajectory.samples, max_remainder_samples);
    const RunResult complete_run = simulate_samples(mechanism, trajectory);
    for (UnbalancedRemainder& entry : all) {
      const auto reduced_mechanism =
          is_removable(entry) ? remove_element(mechanism, entry.element, conditions) : std::optional<Mechanism>();
      if (!reduced_mechanism) continue;
      const RunResult reduced_run = complete_run.outcome.status == MotionStatus::done
                                        ? simulate_samples(*reduced_mechanism, trajectory)
                                        : complete_run;
      if (reduced_run.outcome.status == MotionStatus::done)
        add_efforts(complete_run, reduced_run, trajectory.name, entry);
      else
        entry.failed_trajectories.push_back({trajectory.name, reduced_run.outcome.reason});
    }
  }
  return all;
}

}  // namespace balance::design
