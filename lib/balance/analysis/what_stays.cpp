#include "balance/analysis/what_stays.hpp"

#include "balance/base/extrema.hpp"
#include "balance/design/solve.hpp"
#include "balance/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace balance {

namespace {

constexpr long most_samples_watched = 1001;

/// The mechanism without what stays of an element; nothing if masses could help with all of it.
std::optional<Mechanism> without(const Mechanism& mechanism, const Remainder& remainder, const Conditions& conditions) {
  Mechanism other = mechanism;
  bool changed = false;
  const auto i = static_cast<std::size_t>(remainder.index);
  for (const int t : remainder.terms) {
    const Parameter& term = conditions.parameters[static_cast<std::size_t>(t)];
    if (!is_change(term) && !conditions.matrix.col(t).head(conditions.own_rows()).isZero(0)) continue;
    changed = true;
    if (term.bearer == Bearer::friction) {
      friction_number(other.friction[i], term) = 0;
    } else if (is_change(term)) {
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

Result moved(const Mechanism& mechanism, const Trajectory& trajectory) {
  try {
    return simulate(mechanism, trajectory);
  } catch (const std::invalid_argument& error) {
    Result result;
    result.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
    return result;
  }
}

void add_efforts(const Result& with, const Result& less, const std::string& trajectory, Staying& staying) {
  const Samples difference = with.torque - less.torque;
  for (Eigen::Index a = 0; a < difference.cols(); ++a) {
    const double size = max_abs(difference.col(a));
    if (!(size > 1e-12 * max_abs(with.torque.col(a)))) continue;
    const auto actuator = static_cast<std::size_t>(a);
    staying.efforts.push_back({trajectory, with.actuator_names[actuator], with.actuator_units[actuator], size});
  }
}

/// A spring has no fixed part to take away: its stiffness is a parameter.
bool is_fixed(const Staying& staying) { return staying.remainder.bearer != Bearer::spring; }

}  // namespace

std::vector<Staying> list_staying(const Mechanism& mechanism, const std::vector<Trajectory>& trajectories,
                                  const Conditions& conditions, const ConditionOptions& options) {
  const VectorX values = term_values(mechanism, options.loose_springs);
  std::vector<Staying> all;
  for (const Remainder& remainder : list_remainders(conditions, values, mechanism, met)) {
    Staying staying{remainder, remainder_text(remainder, conditions, values, mechanism), {}, {}};
    for (const LargestEffort& effort : efforts_at_rest(mechanism, conditions, remainder, options)) {
      const Coordinate& coordinate = mechanism.coordinates[static_cast<std::size_t>(effort.actuator)];
      if (!std::isfinite(effort.size)) {
        staying.unknown.push_back({"", "the effort of " + coordinate.name + " grows too large to be computed with"});
        continue;
      }
      staying.efforts.push_back(
          {"", coordinate.name, coordinate.kind == CoordinateKind::length ? "N" : "N m", effort.size});
    }
    all.push_back(std::move(staying));
  }
  if (std::none_of(all.begin(), all.end(), is_fixed) || mechanism.actuators.empty()) return all;
  for (Trajectory trajectory : trajectories) {
    trajectory.samples = std::min(trajectory.samples, most_samples_watched);
    const Result with = moved(mechanism, trajectory);
    for (Staying& staying : all) {
      const auto other =
          is_fixed(staying) ? without(mechanism, staying.remainder, conditions) : std::optional<Mechanism>();
      if (!other) continue;
      const Result less = with.outcome.status == MotionStatus::done ? moved(*other, trajectory) : with;
      if (less.outcome.status == MotionStatus::done)
        add_efforts(with, less, trajectory.name, staying);
      else
        staying.unknown.push_back({trajectory.name, less.outcome.reason});
    }
  }
  return all;
}

}  // namespace balance
