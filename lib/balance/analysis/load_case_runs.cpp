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

Mechanism assembled(const Study& study) { return assembled_at(study.mechanism, start_coordinates(study)); }

/// What the weights and springs of a mechanism of this size leave of zero [N m].
double rounded_away(const Mechanism& mechanism) {
  constexpr double round_off = 1e-13;
  const double length = characteristic_length(mechanism);
  double force = total_mass(mechanism) * mechanism.gravity.norm();
  for (const Spring& spring : mechanism.springs) {
    const bool turns = spring.in_joint() &&
                       mechanism.coordinates[static_cast<std::size_t>(spring.coordinate)].kind == CoordinateKind::angle;
    force += turns ? spring.stiffness / length : spring.stiffness * length;
  }
  return round_off * force * length;
}

/// Efforts of everything that weighs, pulls or pushes, over random poses.
std::vector<LargestEffort> resting(const Mechanism& mechanism, const ConditionOptions& given) {
  ConditionOptions options = given;
  options.loose_springs.clear();
  Conditions all;  // no row: nothing takes anything away
  all.parameters = list_terms(mechanism);
  all.known = known_values(mechanism);
  all.matrix.resize(0, static_cast<Eigen::Index>(all.parameters.size()));
  Remainder everything{Bearer::body, 0, "", {}, {}};
  everything.terms.resize(all.parameters.size());
  std::iota(everything.terms.begin(), everything.terms.end(), 0);
  std::vector<LargestEffort> efforts = efforts_at_rest(mechanism, all, everything, options);
  std::erase_if(efforts, [least = rounded_away(mechanism)](const LargestEffort& one) { return one.size <= least; });
  return efforts;
}

LoadCaseRun run(const Mechanism& mechanism, const Trajectory& trajectory) {
  LoadCaseRun run;
  run.trajectory = trajectory.name;
  try {
    Result result = simulate(mechanism, trajectory);
    run.outcome = std::move(result.outcome);
    for (Metric& metric : result.metrics)
      if (array_name(metric.quantity).starts_with("torque") || metric.quantity.starts_with("shaking_"))
        run.metrics.push_back(std::move(metric));
  } catch (const std::invalid_argument& error) {
    run.outcome = {MotionStatus::mismatch, 0, error.what(), {}};
  }
  return run;
}

}  // namespace

Conditions LoadJudge::conditions(const Study& loaded) const { return conditions(assembled(loaded)); }

Conditions LoadJudge::conditions(const Mechanism& mechanism) const {
  if (!problem_.goals.empty()) return problem_.derive(mechanism, problem_.goals, problem_.options);
  Conditions none;
  none.status = ConditionsStatus::done;
  none.parameters = list_terms(mechanism);
  none.matrix.resize(0, static_cast<Eigen::Index>(none.parameters.size()));
  return none;
}

double LoadJudge::residual(const Study& loaded) const {
  const Conditions found = conditions(loaded);
  if (found.status != ConditionsStatus::done) return std::numeric_limits<double>::quiet_NaN();
  if (found.matrix.rows() == 0) return 0;
  return max_abs(scaled_residuals(found, term_values(loaded.mechanism, problem_.options.loose_springs)));
}

LoadCaseReport LoadJudge::report(const DesignSpace& space, const VectorX& loads, const VectorX& x) const {
  const Study loaded = space.at(x);
  LoadCaseReport report;
  report.loads = loads;
  report.x = x;
  report.residual = residual(loaded);
  report.at_rest = resting(assembled(loaded), problem_.options);
  if (!trajectories_) return report;
  for (const Trajectory& trajectory : loaded.trajectories) report.runs.push_back(run(loaded.mechanism, trajectory));
  return report;
}

}  // namespace balance
