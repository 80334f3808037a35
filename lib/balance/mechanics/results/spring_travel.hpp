#pragma once
/// Whether springs stay within the lengths for which they are made.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

#include <string>
#include <vector>

namespace balance::results {

/// The worst sample at which a spring is longer, or shorter, than its travel.
struct TravelExcess {
  int spring = 0;        ///< index into Mechanism::springs
  double excess = 0;     ///< beyond the travel, > 0 [m]
  double length = 0;     ///< of the spring then [m]
  bool is_long = false;  ///< longer than its longest length; else shorter than its shortest, or slack
  double time = 0;       ///< [s]
  VectorX position;      ///< joint coordinates then
};

/// One for each end of its travel beyond which a spring is.
/// @param result a run of this mechanism
std::vector<TravelExcess> find_travel_excesses(const Mechanism& mechanism, const RunResult& result);

/// "spring s is 12.3 mm longer than its longest length 220 mm at 0.35 s (J 12 deg): …".
std::string describe_travel_excess(const Mechanism& mechanism, const TravelExcess& excess);

/// Adds a note on each of them to the outcome of a run.
void add_travel_notes(const Mechanism& mechanism, RunResult& result);

}  // namespace balance::results
