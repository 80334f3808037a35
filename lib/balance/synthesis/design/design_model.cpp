#include "balance/synthesis/design/design_model.hpp"

#include "balance/foundation/numerics/extrema.hpp"

#include <stdexcept>

namespace balance::design {

namespace {

[[noreturn]] void reject_call(const char* what) {
  throw std::logic_error(std::string("the design model has no ") + what + ", as its capabilities say");
}

}  // namespace

std::optional<std::vector<MaxTerm>> DesignFunction::max_terms(const VectorX& /*x*/) const {
  throw std::logic_error("the function is not known as a sum of maxima");
}

std::optional<VectorX> DesignFunction::gradient(const VectorX& x) const {
  return has_max_terms() ? max_term_gradient(max_terms(x), x.size()) : std::nullopt;
}

std::string DesignFunction::failure_reason(const VectorX& /*x*/) const { return ""; }

std::optional<VectorX> max_term_gradient(const std::optional<std::vector<MaxTerm>>& terms, Eigen::Index variables) {
  if (!terms) return std::nullopt;
  VectorX gradient = VectorX::Zero(variables);
  for (const MaxTerm& term : *terms)
    gradient += term.weight * term.jacobian.row(numerics::max_index(term.values)).transpose();
  if (!gradient.allFinite()) return std::nullopt;
  return gradient;
}

std::string DesignModel::invalidity_reason(const VectorX& /*x*/) const { return ""; }

std::string DesignModel::infeasibility_reason(const VectorX& /*x*/) const { return ""; }

Conditions DesignModel::derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                                          const ConditionOptions& options) const {
  return balance::derive_conditions(mechanism, goals, options);
}

std::optional<std::vector<AffineFigure>> DesignModel::convex_terms(const VectorX& /*x*/,
                                                                   FigureSampling /*sampling*/) const {
  reject_call("convex terms");
}

std::optional<std::vector<ConvexLimit>> DesignModel::convex_limits(const VectorX& /*x*/) const {
  reject_call("convex limits");
}

Objective DesignModel::objective_at_geometry(const VectorX& /*x*/, const std::vector<int>& /*free*/,
                                             const dynamics::FreeSprings& /*loose*/) const {
  reject_call("objective of one geometry");
}

std::vector<DesignLimit> DesignModel::limits_at_geometry(const VectorX& /*x*/, const std::vector<int>& /*free*/,
                                                         const dynamics::FreeSprings& /*loose*/) const {
  reject_call("limits of one geometry");
}

}  // namespace balance::design
