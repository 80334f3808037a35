#include "balance/analysis/load_case_runs.hpp"

#include "balance/analysis/start_pose.hpp"
#include "balance/base/extrema.hpp"
#include "balance/result/effort_names.hpp"
#include "balance/simulation/simulate.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace balance {

namespace {

Mechanism assembled_mechanism(const Study& study) { return assembled_at(study.mechanism, start_coordinates(study)); }

/// What the weights and springs of a mechanism of this size leave of zero [N m].
double static_effort_round_off(const Mechanism& mechanism) {
  constexpr double static_effort_tolerance = 1e-13;
  const double length = characteristic_length(mechanism);
  double force = total_mass(mechanism) * mechanism.gravity.norm();
  for (const Spring& spring : mechanism.springs) {
    const bool turns = spring.is_joint_spring() &&
                       mechanism.coordinates[static_cast<std::size_t>(spring.coordinate)].kind == CoordinateKind::angle;
    force += turns ? spring.stiffness / length : spring.stiffness * length;
  }
  return static_effort_tolerance * force * length;
}

/// Efforts of everything that weighs, pulls or pushes, over random poses.
std::vector<PeakEffort> static_efforts(const Mechanism& mechanism, const ConditionOptions& given) {
  ConditionOptions options = given;
  options.loose_springs.clear();
  Conditions all;  // no row: nothing takes anything away
  all.parameters = list_terms(mechanism);
  all.known_term_values = known_term_values(mechanism);
  all.matrix.resize(0, static_cast<Eigen::Index>(all.parameters.size()));
  UnbalanceableElement everything{ParameterOwner::body, 0, "", {}, {}};
  everything.terms.resize(all.parameters.size());
  std::iota(everything.terms.begin(), everything.terms.end(), 0);
  std::vector<PeakEffort> efforts = find_peak_static_efforts(mechanism, all, everything, options);
  std::erase_if(efforts,
                [least = static_effort_round_off(mechanism)](const PeakEffort& one) { return one.magnitude <= least; });
  return efforts;
}

LoadCaseRun run_load_case(const Mechanism& mechanism, const Trajectory& trajectory) {
  LoadCaseRun run;
  run.trajectory = trajectory.name;
  try {
    RunResult result = simulate(mechanism, trajectory);
    run.outcome = std::move(result.outcome);
    for (Metric& metric : result.metrics)
      if (effort_array_name(metric.quantity).starts_with("torque") || metric.quantity.starts_with("shaking_"))
        run.metrics.push_back(std::move(metric));
  } catch (const std::invalid_argument& error) {
    run.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
  }
  return run;
}

}  // namespace

Conditions LoadCaseEvaluator::derive_conditions(const Study& loaded) const {
  return derive_conditions(assembled_mechanism(loaded));
}

Conditions LoadCaseEvaluator::derive_conditions(const Mechanism& mechanism) const {
  if (!problem_.goals.empty()) return problem_.derive_conditions(mechanism, problem_.goals, problem_.options);
  Conditions undefined_deviation;
  undefined_deviation.status = ConditionsStatus::done;
  undefined_deviation.parameters = list_terms(mechanism);
  undefined_deviation.matrix.resize(0, static_cast<Eigen::Index>(undefined_deviation.parameters.size()));
  return undefined_deviation;
}

double LoadCaseEvaluator::max_residual(const Study& loaded) const {
  const Conditions found = derive_conditions(loaded);
  if (found.status != ConditionsStatus::done) return std::numeric_limits<double>::quiet_NaN();
  if (found.matrix.rows() == 0) return 0;
  return max_abs(scaled_residuals(found, term_values(loaded.mechanism, problem_.options.loose_springs)));
}

LoadCaseReport LoadCaseEvaluator::report(const DesignSpace& space, const VectorX& loads, const VectorX& x) const {
  const Study loaded = space.study_at(x);
  LoadCaseReport report;
  report.loads = loads;
  report.x = x;
  report.residual = max_residual(loaded);
  report.static_efforts = static_efforts(assembled_mechanism(loaded), problem_.options);
  if (!trajectories_) return report;
  for (const Trajectory& trajectory : loaded.trajectories)
    report.runs.push_back(run_load_case(loaded.mechanism, trajectory));
  return report;
}

}  // namespace balance
