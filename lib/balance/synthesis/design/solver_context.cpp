#include "balance/synthesis/design/solver_context.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/synthesis/design/problem_functions.hpp"

namespace balance::design {

namespace {

constexpr const char* time_limit_message = "the time ran out";

}  // namespace

SolverContext::SolverContext(const DesignProblem& p, SearchBudget& b)
    : problem(p),
      budget(b),
      scaling(p.variables),
      classification(design::classify_variables(scaling, p)),
      options(p.options),
      features(scaling, p, classification),
      physical_constraints(features, classification, features.evaluate_from_mechanism(scaling.start())) {
  options.loose_springs = classification.loose_springs;
  const Eigen::Index parameter_count =
                         dynamics::parameter_values(classification.base_mechanism, classification.loose_springs).size(),
                     known_count = conditions::known_term_values(classification.base_mechanism).size();
  options.variable_terms.assign(static_cast<std::size_t>(known_count), false);
  for (int variable = 0; variable < scaling.size(); ++variable)
    for (Eigen::Index k = 0; k < known_count; ++k)
      if (classification.has_effect(variable, static_cast<int>(parameter_count + k)))
        options.variable_terms[static_cast<std::size_t>(k)] = true;
  limits = std::make_unique<const DesignLimits>(*this);
}

SolverContext::~SolverContext() = default;

std::string SolverContext::invalidity_reason(const VectorX& u) const {
  try {
    return problem.model->invalidity_reason(scaling.to_variables(u));
  } catch (const SpecError& error) {
    return error.what();
  }
}

bool SolverContext::is_physical(const VectorX& u) const {
  return physical_constraints.is_satisfied(features.evaluate_from_mechanism(u)) && invalidity_reason(u).empty();
}

bool SolverContext::is_admissible(const VectorX& u) const { return is_physical(u) && limits->is_satisfied(u); }

int SolverContext::inequality_count() const { return physical_constraints.size() + limits->size(); }

bool SolverContext::is_convex() const { return physical_constraints.is_convex() && limits->is_convex(); }

void SolverContext::evaluate_inequalities(const VectorX& u, VectorX& g, MatrixX* jacobian) const {
  VectorX features, bodies, figures;
  MatrixX slopes, by_body, by_figure;
  this->features.evaluate(u, features, jacobian != nullptr ? &slopes : nullptr);
  physical_constraints.evaluate(features, &slopes, bodies, jacobian != nullptr ? &by_body : nullptr);
  limits->evaluate(u, figures, jacobian != nullptr ? &by_figure : nullptr);
  g.resize(bodies.size() + figures.size());
  g << bodies, figures;
  if (jacobian == nullptr) return;
  jacobian->resize(g.size(), u.size());
  jacobian->topRows(bodies.size()) = by_body;
  jacobian->bottomRows(figures.size()) = by_figure;
}

Conditions SolverContext::derive_conditions(const Mechanism& mechanism) const {
  if (!problem.goals.empty()) return problem.model->derive_conditions(mechanism, problem.goals, options);
  Conditions none;
  none.status = ConditionsStatus::done;
  none.parameters = conditions::list_terms(mechanism, options.loose_springs);
  none.matrix.resize(0, static_cast<Eigen::Index>(none.parameters.size()));
  return none;
}

Conditions SolverContext::conditions_at(const VectorX& u) const {
  Conditions none;
  if (budget.is_past_deadline()) {
    none.status = ConditionsStatus::not_assembled;
    none.reason = time_limit_message;
    return none;
  }
  try {
    return derive_conditions(mechanism(u));
  } catch (const SpecError& error) {
    none.status = ConditionsStatus::not_assembled;
    none.reason = error.what();
  } catch (const DeadlineExceeded&) {
    none.status = ConditionsStatus::not_assembled;
    none.reason = time_limit_message;
  }
  return none;
}

namespace {

template <class Evaluate>
auto evaluate_or_none(const Evaluate& evaluate) -> decltype(evaluate()) {
  try {
    return evaluate();
  } catch (const SpecError&) {
    return std::nullopt;  // an expression of the spec has no value here
  } catch (const DeadlineExceeded&) {
    return std::nullopt;
  }
}

}  // namespace

std::optional<std::vector<AffineFigure>> SolverContext::convex_terms(const VectorX& u, FigureSampling sampling) const {
  return evaluate_or_none([&] { return problem.model->convex_terms(scaling.to_variables(u), sampling); });
}

std::optional<std::vector<ConvexLimit>> SolverContext::convex_limits(const VectorX& u) const {
  return evaluate_or_none([&] { return problem.model->convex_limits(scaling.to_variables(u)); });
}

std::string SolverContext::infeasibility_reason(const VectorX& u) const {
  if (budget.is_past_deadline()) return time_limit_message;
  try {
    return problem.model->infeasibility_reason(scaling.to_variables(u));
  } catch (const SpecError& error) {
    return error.what();
  } catch (const DeadlineExceeded&) {
    return time_limit_message;
  }
}

}  // namespace balance::design
