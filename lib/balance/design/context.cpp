#include "balance/design/context.hpp"

#include "balance/base/error.hpp"
#include "balance/design/limits.hpp"

namespace balance::designing {

namespace {

constexpr const char* out_of_time = "the time ran out";

}  // namespace

Context::Context(const DesignProblem& p, Budget& b)
    : problem(p),
      budget(b),
      box(p.variables),
      survey(designing::survey(box, p)),
      options(p.options),
      map(box, p, survey),
      physical(map, survey, map.exact(box.start())) {
  options.loose_springs = survey.loose;
  const Eigen::Index own = parameter_values(survey.at_base, survey.loose).size(),
                     known = known_values(survey.at_base).size();
  options.open_terms.assign(static_cast<std::size_t>(known), false);
  for (int variable = 0; variable < box.size(); ++variable)
    for (Eigen::Index k = 0; k < known; ++k)
      if (survey.touches(variable, static_cast<int>(own + k))) options.open_terms[static_cast<std::size_t>(k)] = true;
  limits = std::make_unique<const Limits>(*this);
}

Context::~Context() = default;

std::string Context::fault(const VectorX& u) const {
  if (!problem.fault) return "";
  try {
    return problem.fault(box.numbers(u));
  } catch (const SpecError& error) {
    return error.what();
  }
}

bool Context::is_physical(const VectorX& u) const { return physical.holds(map.exact(u)) && fault(u).empty(); }

bool Context::allows(const VectorX& u) const { return is_physical(u) && limits->hold(u); }

int Context::inequalities() const { return physical.size() + limits->size(); }

bool Context::convex() const { return physical.convex() && limits->convex(); }

void Context::evaluate_inequalities(const VectorX& u, VectorX& g, MatrixX* jacobian) const {
  VectorX features, bodies, figures;
  MatrixX slopes, by_body, by_figure;
  map.evaluate(u, features, jacobian != nullptr ? &slopes : nullptr);
  physical.evaluate(features, &slopes, bodies, jacobian != nullptr ? &by_body : nullptr);
  limits->evaluate(u, figures, jacobian != nullptr ? &by_figure : nullptr);
  g.resize(bodies.size() + figures.size());
  g << bodies, figures;
  if (jacobian == nullptr) return;
  jacobian->resize(g.size(), u.size());
  jacobian->topRows(bodies.size()) = by_body;
  jacobian->bottomRows(figures.size()) = by_figure;
}

Conditions Context::derive(const Mechanism& mechanism) const {
  if (!problem.goals.empty()) return problem.derive(mechanism, problem.goals, options);
  Conditions none;
  none.status = ConditionsStatus::done;
  none.parameters = list_terms(mechanism, options.loose_springs);
  none.matrix.resize(0, static_cast<Eigen::Index>(none.parameters.size()));
  return none;
}

Conditions Context::conditions_at(const VectorX& u) const {
  Conditions none;
  if (budget.over()) {
    none.status = ConditionsStatus::not_assembled;
    none.reason = out_of_time;
    return none;
  }
  try {
    return derive(mechanism(u));
  } catch (const SpecError& error) {
    none.status = ConditionsStatus::not_assembled;
    none.reason = error.what();
  }
  return none;
}

std::string Context::obstacle(const VectorX& u) const {
  if (!problem.obstacle) return "";
  if (budget.over()) return out_of_time;
  try {
    return problem.obstacle(box.numbers(u));
  } catch (const SpecError& error) {
    return error.what();
  } catch (const OutOfTime&) {
    return out_of_time;
  }
}

}  // namespace balance::designing
