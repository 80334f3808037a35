#include "balance/design/trial.hpp"

#include "balance/base/computing_time.hpp"
#include "balance/base/error.hpp"
#include "balance/base/extrema.hpp"
#include "balance/design/restricted.hpp"
#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::design {

TrialEvaluator::TrialEvaluator(const SolverContext& context, const NonlinearSystem& equations,
                               const ScaledObjective* merit)
    : context_(context), equations_(equations), objective_(merit), others_(inertial_variables(context)) {}

double TrialEvaluator::cost(const TrialDesign& trial) const {
  if (trial.is_balanced) return objective_ != nullptr ? trial.figure : 0;
  return is_figure_first() ? trial.figure : trial.residual;
}

void TrialEvaluator::update_best(TrialDesign& best, TrialDesign trial) const {
  if (!trial.is_feasible || !std::isfinite(cost(trial))) return;
  const bool better = !best.is_feasible || (trial.is_balanced && !best.is_balanced) ||
                      (trial.is_balanced == best.is_balanced && cost(trial) < cost(best));
  if (better) best = std::move(trial);
}

TrialDesign TrialEvaluator::evaluate(const VectorX& u) const {
  TrialDesign trial;
  trial.u = u;
  trial.is_feasible = context_.is_physical(u) && context_.infeasibility_reason(u).empty();
  if (!trial.is_feasible) return trial;
  trial.is_balanced = is_balanced(u);
  evaluate_figures(trial);
  return trial;
}

bool TrialEvaluator::is_balanced(const VectorX& u) const {
  const Conditions conditions = context_.conditions_at(u);
  if (conditions.status != ConditionsStatus::done || !context_.is_admissible(u)) return false;
  if (conditions.parameter_rows() == 0) return true;
  const VectorX residual =
      scaled_residuals(conditions, term_values(context_.mechanism(u), context_.options.loose_springs))
          .head(conditions.parameter_rows());
  return max_abs(residual) < condition_tolerance;
}

void TrialEvaluator::evaluate_figures(TrialDesign& trial) const {
  if (objective_ != nullptr && !std::isfinite(trial.figure)) trial.figure = (*objective_)(trial.u, nullptr);
  VectorX values;
  trial.residual = equations_.primary_rows == 0                    ? 0
                   : equations_.evaluate(trial.u, values, nullptr) ? values.head(equations_.primary_rows).norm()
                                                                   : std::numeric_limits<double>::quiet_NaN();
}

TrialDesign TrialEvaluator::solve_at_geometry(const VectorX& u) const {
  TrialDesign trial;
  trial.u = u;
  if (!context_.infeasibility_reason(u).empty()) return trial;
  ++context_.budget.geometries;
  try {
    const VectorX x = context_.scaling.to_variables(u);
    const DesignProblem inner = make_fixed_geometry_problem(context_, x, context_.budget.remaining_time());
    const DesignOutcome outcome = solve_design(inner);
    if (outcome.status == DesignStatus::unsolved || outcome.status == DesignStatus::no_feasible_start) return trial;
    trial.is_balanced = outcome.status == DesignStatus::balanced || outcome.status == DesignStatus::no_goal;
    for (std::size_t k = 0; k < others_.size(); ++k) {
      const auto i = others_[k];
      const double half = context_.scaling.half_width()[i];
      trial.u[i] =
          half > 0
              ? std::clamp((outcome.x[static_cast<Eigen::Index>(k)] - context_.scaling.centre()[i]) / half, -1.0, 1.0)
              : 0;
    }
    trial.is_feasible = context_.is_admissible(trial.u);
    trial.figure = outcome.objective;
    evaluate_figures(trial);
  } catch (const SpecError&) {
    trial.is_feasible = false;  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    trial.is_feasible = false;
  } catch (const DeadlineExceeded&) {
    trial.is_feasible = false;
  }
  return trial;
}

}  // namespace balance::design
