#pragma once
/// Request for a mechanism's balance, by a command, the report or a user's program.

#include "balance/synthesis/conditions/conditions.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance::reports {

struct BalanceRequest {
  std::vector<Goal> goals;            ///< at least one for conditions
  bool is_modular = false;            ///< conditions chain by chain instead of the complete ones
  std::optional<std::uint64_t> seed;  ///< of random configurations and searches; std::nullopt: the default
  std::vector<std::string> excluded;  ///< what the goals exclude (ConditionOptions)
  std::vector<model::GeneralisedSpeed> speeds = {};  ///< of conditions (ConditionOptions); empty: none are chosen

  /// "complete" or "modular".
  const char* strategy() const { return is_modular ? "modular" : "complete"; }
};

/// Derives the conditions of a mechanism, always in the same way.
using DeriveConditions = std::function<Conditions(const Mechanism&)>;

/// @param start coordinates at which mechanisms are assembled
DeriveConditions make_conditions_deriver(const std::vector<Goal>& goals, bool modular, const ConditionOptions& options,
                                         const std::vector<CoordinateValue>& start);

/// The same for mechanisms that differ slightly from one with known conditions.
DeriveConditions make_perturbed_deriver(const DeriveConditions& derive, bool modular, const ConditionOptions& options,
                                        const std::vector<CoordinateValue>& start, const Mechanism& mechanism,
                                        const Conditions& conditions);

}  // namespace balance::reports
