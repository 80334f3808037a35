#pragma once
/// What a command, the report or a user's program asks about a mechanism's balance.

#include "balance/synthesis/conditions/conditions.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance {

struct BalanceRequest {
  std::vector<Goal> goals;            ///< at least one for conditions
  bool is_modular = false;            ///< the chains one by one instead of the complete conditions
  std::optional<std::uint64_t> seed;  ///< of random configurations and searches; nothing: the default
  std::vector<std::string> excluded;  ///< what the goals leave out (ConditionOptions)

  /// "complete" or "modular".
  const char* strategy() const { return is_modular ? "modular" : "complete"; }
};

/// Derives the conditions of a mechanism the same way again and again.
using DeriveConditions = std::function<Conditions(const Mechanism&)>;

/// @param start coordinates that mechanisms are assembled at
DeriveConditions make_conditions_deriver(const std::vector<Goal>& goals, bool modular, const ConditionOptions& options,
                                         const std::vector<CoordinateValue>& start);

/// The same for mechanisms that differ little from one whose conditions are known.
DeriveConditions make_perturbed_deriver(const DeriveConditions& derive, bool modular, const ConditionOptions& options,
                                        const std::vector<CoordinateValue>& start, const Mechanism& mechanism,
                                        const Conditions& conditions);

}  // namespace balance
