#pragma once
/// What somebody wants to know of a mechanism's balance, whoever asks: a command, the report, a program of a user's own.

#include "balance/conditions/conditions.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance {

struct BalanceQuestion {
  std::vector<Goal> goals;            ///< at least one for conditions
  bool modular = false;               ///< the chains one by one instead of the complete conditions
  std::optional<std::uint64_t> seed;  ///< of random configurations and searches; nothing: the default
  std::vector<std::string> without;   ///< what the goals leave out (ConditionOptions)

  /// "complete" or "modular".
  const char* strategy() const { return modular ? "modular" : "complete"; }
};

/// Derives the conditions of a mechanism the same way again and again.
using Derive = std::function<Conditions(const Mechanism&)>;

/// @param start coordinates that mechanisms are assembled at
Derive make_derive(const std::vector<Goal>& goals, bool modular, const ConditionOptions& options,
                   const std::vector<CoordinateValue>& start);

/// The same for mechanisms that differ little from one whose conditions are known.
Derive make_derive_nearby(const Derive& derive, bool modular, const ConditionOptions& options,
                          const std::vector<CoordinateValue>& start, const Mechanism& mechanism,
                          const Conditions& conditions);

}  // namespace balance
