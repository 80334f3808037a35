#pragma once
/// Conditions of mechanisms that differ slightly from one whose conditions are known. Used to find names of
/// coefficients and their dependence on lengths.

#include "balance/synthesis/conditions/conditions.hpp"

#include <functional>
#include <memory>
#include <optional>

namespace balance::conditions {

/// Evaluates the rows at the known mechanism's configurations, with the loops closed again, and solves for the known
/// pivots: no random walk, no rank decision.
class PerturbedConditions {
 public:
  /// @param conditions result of derive_conditions for the mechanism with these options
  PerturbedConditions(const Mechanism& mechanism, const Conditions& conditions, const ConditionOptions& options);
  ~PerturbedConditions();
  PerturbedConditions(PerturbedConditions&&) noexcept;
  PerturbedConditions& operator=(PerturbedConditions&&) noexcept;

  /// Sets status, parameters, pivots and matrix alone. The status is done, or rank_unclear if there are further
  /// conditions.
  /// @return std::nullopt if this does not decide, e.g. because the loops do not close there: use derive_conditions
  std::optional<Conditions> derive(const Mechanism& mechanism) const;

  struct Implementation;

 private:
  std::unique_ptr<Implementation> implementation_;
};

/// Returns a function that uses PerturbedConditions where these decide, and `derive` otherwise. Its status is not done
/// if the rank has changed.
/// @param prepare applied to mechanisms before PerturbedConditions, but not before `derive`
std::function<Conditions(const Mechanism&)> make_perturbed_derivation(
    const std::function<Conditions(const Mechanism&)>& derive,
    const std::function<Mechanism(const Mechanism&)>& prepare, const Mechanism& mechanism, const Conditions& conditions,
    const ConditionOptions& options);

}  // namespace balance::conditions
