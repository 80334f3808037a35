#pragma once
/// Objectives whose best values are known by hand.

#include "balance/synthesis/design/solve_design.hpp"

namespace design_tests {

using namespace balance;
using namespace balance::design;

/// A function of the parameters from a callable double(parameters, gradient).
template <class F>
class ParameterFunction final : public DesignFunction {
 public:
  explicit ParameterFunction(F function) : function_(std::move(function)) {}
  Domain domain() const override { return Domain::parameters; }
  double evaluate(const VectorX& at, VectorX* gradient) const override { return function_(at, gradient); }

 private:
  F function_;
};

/// A function of the free numbers from a callable double(x).
template <class F>
class VariableFunction final : public DesignFunction {
 public:
  explicit VariableFunction(F function, std::string failure_reason = "")
      : function_(std::move(function)), failure_reason_(std::move(failure_reason)) {}
  Domain domain() const override { return Domain::variables; }
  double evaluate(const VectorX& x, VectorX* /*gradient*/) const override { return function_(x); }
  std::string failure_reason(const VectorX& /*x*/) const override { return failure_reason_; }

 private:
  F function_;
  std::string failure_reason_;
};

template <class F>
std::shared_ptr<const DesignFunction> of_parameters(F function) {
  return std::make_shared<const ParameterFunction<F>>(std::move(function));
}

template <class F>
std::shared_ptr<const DesignFunction> of_variables(F function, const std::string& failure_reason = "") {
  return std::make_shared<const VariableFunction<F>>(std::move(function), failure_reason);
}

/// Σ wᵢ pᵢ, or with `squared` Σ wᵢ pᵢ², over the parameters of one symbol and kind of bearer.
inline Objective sum_of(const Mechanism& mechanism, dynamics::ParameterOwner bearer, const std::string& symbol,
                        bool squared = false) {
  VectorX weights = VectorX::Zero(dynamics::parameter_values(mechanism).size());
  const auto parameters = dynamics::list_parameters(mechanism);
  for (std::size_t p = 0; p < parameters.size(); ++p)
    if (parameters[p].owner_kind == bearer && parameters[p].symbol == symbol) weights[static_cast<Eigen::Index>(p)] = 1;
  Objective objective;
  objective.name = "sum";
  objective.is_convex = true;
  objective.is_secondary = !squared;
  objective.function = of_parameters([weights, squared](const VectorX& pi, VectorX* gradient) {
    if (gradient != nullptr) *gradient = squared ? VectorX(2 * weights.cwiseProduct(pi)) : weights;
    return squared ? weights.dot(pi.cwiseAbs2()) : weights.dot(pi);
  });
  return objective;
}

}  // namespace design_tests
