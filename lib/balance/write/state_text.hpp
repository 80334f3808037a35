#pragma once
/// The numbers of a single state (inverse/single_state.hpp) one by one, in words and as JSON.

#include "balance/result/result.hpp"
#include "balance/write/write_options.hpp"

#include <string>
#include <vector>

namespace balance {

/// One scalar or vector.
struct StateEntry {
  std::string quantity;  ///< as in Result::metrics: "torque[A1]", "joint_force[B1]"
  std::string unit;
  std::vector<double> value;  ///< round-off is 0; NaN where there is none
};

/// @param result with one row
std::vector<StateEntry> list_state_entries(const RunResult& result);

/// @param description whose `at` is not empty
std::string format_state(const RunResult& result, const Provenance& description);
std::string state_json(const RunResult& result, const Provenance& description, const std::vector<std::string>& files);

}  // namespace balance
