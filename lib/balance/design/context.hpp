#pragma once
/// What every step of a design needs to know about its problem. Private to design.

#include "balance/design/gauss_newton.hpp"
#include "balance/design/physical.hpp"

namespace balance::designing {

struct Context {
  explicit Context(const DesignProblem& problem);
  Context(const Context&) = delete;

  Mechanism mechanism(const VectorX& u) const { return problem.mechanism_at(box.numbers(u)); }
  /// All bodies are physical, judged by the mechanism itself.
  bool is_physical(const VectorX& u) const { return physical.holds(map.exact(u)); }
  Conditions derive(const Mechanism& mechanism) const { return problem.derive(mechanism, problem.goals, options); }

  const DesignProblem& problem;
  Box box;
  Survey survey;
  ConditionOptions options;  ///< with the springs that the free numbers make loose
  ParameterMap map;
  Physical physical;
};

}  // namespace balance::designing
