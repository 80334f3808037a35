#include "balance/synthesis/design/required_motions.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/mechanics/model/mechanism_conversion.hpp"
#include "balance/mechanics/model/validation.hpp"
#include "balance/mechanics/trajectory/trajectory_conversion.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/geometry_features.hpp"
#include "balance/synthesis/design/trajectory_cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace balance::design {

namespace {

/// Limits the number of samples to what a search needs.
Trajectory reduce_samples(Trajectory trajectory) {
  constexpr long max_feasibility_samples = 201;
  trajectory.samples = std::min(trajectory.samples, max_feasibility_samples);
  return trajectory;
}

std::string motion_failure_reason(const Mechanism& mechanism, const Trajectory& trajectory) {
  try {
    const RunResult result = simulate(mechanism, trajectory);
    return result.outcome.status == MotionStatus::done ? "" : result.outcome.reason;
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

}  // namespace

RequiredMotions::RequiredMotions(const Study& start) : coordinates_(simulation::start_coordinates(start)) {
  std::vector<Trajectory> candidates;
  for (const Trajectory& trajectory : start.trajectories) {
    if (is_mass_dependent(trajectory)) continue;
    candidates.push_back(reduce_samples(trajectory));
    if (motion_failure_reason(start.mechanism, candidates.back()).empty()) motions_.push_back(candidates.back().name);
  }
  if (coordinates_.empty())
    for (const Trajectory& trajectory : candidates) motions_.push_back(trajectory.name);
}

VectorX RequiredMotions::numbers(const study::DesignInstance& instance) const {
  std::vector<double> all;
  for (const Trajectory& trajectory : instance.trajectories) {
    const VectorX one = collect_motion_numbers(instance.mechanism, trajectory);
    all.insert(all.end(), one.begin(), one.end());
  }
  return Eigen::Map<const VectorX>(all.data(), static_cast<Eigen::Index>(all.size()));
}

std::string RequiredMotions::infeasibility_reason(const study::DesignInstance& instance) const {
  constexpr std::size_t max_known_reasons = 128;
  if (!instance.mode_issue.empty()) return instance.mode_issue;
  VectorX motion_numbers = numbers(instance);
  for (const auto& [known_numbers, reason] : known_reasons_)
    if (known_numbers == motion_numbers) return reason;
  std::string reason = simulate_motions(instance);
  known_reasons_.emplace_front(std::move(motion_numbers), reason);
  if (known_reasons_.size() > max_known_reasons) known_reasons_.pop_back();
  return reason;
}

/// Why the first of the motions cannot be performed.
std::string RequiredMotions::simulate_motions(const study::DesignInstance& instance) const {
  for (const Trajectory& trajectory : instance.trajectories) {
    if (std::find(motions_.begin(), motions_.end(), trajectory.name) == motions_.end()) continue;
    const std::string why = motion_failure_reason(instance.mechanism, reduce_samples(trajectory));
    if (!why.empty()) return fmt::format("'{}' cannot be followed: {}", trajectory.name, why);
  }
  return "";
}

Mechanism RequiredMotions::assembled_mechanism(study::DesignInstance instance, bool is_mode_followed) const {
  if (is_mode_followed && instance.mode_issue.empty()) return std::move(instance.mechanism);
  return simulation::assembled_at(std::move(instance.mechanism), coordinates_);
}

study::DesignInstance instantiate_checked(const DesignSpace& space, const VectorX& x) {
  study::DesignInstance instance = space.instantiate(x);
  const Mechanism& m = instance.mechanism;
  const auto fail = [&](const char* message) {
    Diagnostic diagnostic;
    diagnostic.place.file = space.start.spec_file;
    diagnostic.message = message;
    throw SpecError(diagnostic);
  };
  const bool finite = compute_features(m, {}).allFinite() && collect_geometry(m, {}).allFinite() &&
                      std::all_of(m.assembly.begin(), m.assembly.end(),
                                  [](const CoordinateValue& given) { return std::isfinite(given.value); });
  if (!finite) fail("an expression in the spec has no value for these numbers");
  if (std::any_of(m.friction.begin(), m.friction.end(), [](const Friction& friction) {
        return friction.static_limit(1) < friction.dry_friction(1) ||
               friction.static_limit(-1) < friction.dry_friction(-1);
      }))
    fail("static friction is less than dry friction with these numbers");
  return instance;
}

VectorX collect_motion_numbers(const Mechanism& mechanism, const Trajectory& trajectory) {
  const Mechanism massless = without_masses(mechanism);
  std::vector<double> numbers;
  const auto collect = [&](double x) {
    numbers.push_back(x);
    return x;
  };
  model::convert_mechanism<double>(massless, collect);
  trajectory::cast_scalar<double>(trajectory, collect);
  return Eigen::Map<const VectorX>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

std::string find_validation_issue(const Mechanism& mechanism) {
  const std::vector<ValidationIssue> issues = validate(mechanism);
  return issues.empty() ? "" : issues.front().message;
}

}  // namespace balance::design
