#include "balance/design/trial.hpp"

#include "balance/base/computing_time.hpp"
#include "balance/base/error.hpp"
#include "balance/base/extrema.hpp"
#include "balance/design/restricted.hpp"
#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::designing {

Trials::Trials(const Context& context, const Equations& equations, const FigureOfMerit* merit)
    : context_(context), equations_(equations), merit_(merit), others_(inertial_numbers(context)) {}

double Trials::cost(const Trial& trial) const {
  if (trial.balanced) return merit_ != nullptr ? trial.figure : 0;
  return wants_figure() ? trial.figure : trial.residual;
}

void Trials::improve(Trial& best, Trial trial) const {
  if (!trial.possible || !std::isfinite(cost(trial))) return;
  const bool better = !best.possible || (trial.balanced && !best.balanced) ||
                      (trial.balanced == best.balanced && cost(trial) < cost(best));
  if (better) best = std::move(trial);
}

Trial Trials::as_it_is(const VectorX& u) const {
  Trial trial;
  trial.u = u;
  trial.possible = context_.is_physical(u) && context_.obstacle(u).empty();
  if (!trial.possible) return trial;
  trial.balanced = is_balanced(u);
  measure(trial);
  return trial;
}

bool Trials::is_balanced(const VectorX& u) const {
  const Conditions conditions = context_.conditions_at(u);
  if (conditions.status != ConditionsStatus::done || !context_.allows(u)) return false;
  if (conditions.own_rows() == 0) return true;
  const VectorX residual =
      scaled_residuals(conditions, term_values(context_.mechanism(u), context_.options.loose_springs))
          .head(conditions.own_rows());
  return max_abs(residual) < met;
}

void Trials::measure(Trial& trial) const {
  if (merit_ != nullptr && !std::isfinite(trial.figure)) trial.figure = (*merit_)(trial.u, nullptr);
  VectorX values;
  trial.residual = equations_.conditions == 0                      ? 0
                   : equations_.evaluate(trial.u, values, nullptr) ? values.head(equations_.conditions).norm()
                                                                   : std::numeric_limits<double>::quiet_NaN();
}

Trial Trials::at(const VectorX& u) const {
  Trial trial;
  trial.u = u;
  if (!context_.obstacle(u).empty()) return trial;
  ++context_.budget.geometries;
  try {
    const VectorX x = context_.box.numbers(u);
    const DesignProblem inner = at_fixed_geometry(context_, x, context_.budget.left());
    const DesignOutcome outcome = solve(inner);
    if (outcome.status == DesignStatus::unsolved || outcome.status == DesignStatus::not_found) return trial;
    trial.balanced = outcome.status == DesignStatus::balanced || outcome.status == DesignStatus::not_asked;
    for (std::size_t k = 0; k < others_.size(); ++k) {
      const auto i = others_[k];
      const double half = context_.box.half()[i];
      trial.u[i] =
          half > 0 ? std::clamp((outcome.x[static_cast<Eigen::Index>(k)] - context_.box.centre()[i]) / half, -1.0, 1.0)
                   : 0;
    }
    trial.possible = context_.allows(trial.u);
    trial.figure = outcome.objective;
    measure(trial);
  } catch (const SpecError&) {
    trial.possible = false;  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    trial.possible = false;
  } catch (const OutOfTime&) {
    trial.possible = false;
  }
  return trial;
}

}  // namespace balance::designing
