#pragma once
/// Conditions of mechanisms that differ a little from one whose conditions are known: what names of coefficients and their
/// dependence on lengths are found by.

#include "balance/synthesis/conditions/conditions.hpp"

#include <functional>
#include <memory>
#include <optional>

namespace balance {

/// Looks at the known mechanism's configurations, closed again, and solves for its pivots: no walk, no decision of rank.
class PerturbedConditions {
 public:
  /// @param conditions derive_conditions of the mechanism with these options
  PerturbedConditions(const Mechanism& mechanism, const Conditions& conditions, const ConditionOptions& options);
  ~PerturbedConditions();
  PerturbedConditions(PerturbedConditions&&) noexcept;
  PerturbedConditions& operator=(PerturbedConditions&&) noexcept;

  /// Status, parameters, pivots and matrix alone: done, or rank_unclear where there are more conditions than the known ones.
  /// @return nothing where the mechanism does not close there: then only derive_conditions knows
  std::optional<Conditions> derive(const Mechanism& mechanism) const;

  struct Implementation;

 private:
  std::unique_ptr<Implementation> implementation_;
};

/// derive, by way of the nearby conditions where these tell; not done where the rank is another one.
/// @param prepare done to every mechanism before its conditions are derived
std::function<Conditions(const Mechanism&)> make_perturbed_derivation(
    const std::function<Conditions(const Mechanism&)>& derive,
    const std::function<Mechanism(const Mechanism&)>& prepare, const Mechanism& mechanism, const Conditions& conditions,
    const ConditionOptions& options);

}  // namespace balance
