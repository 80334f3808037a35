#pragma once
/// The numbers of a single state (inverse/single_state.hpp) one by one, in words and as JSON.

#include "balance/result/result.hpp"
#include "balance/write/write_options.hpp"

#include <string>
#include <vector>

namespace balance {

/// One scalar or vector.
struct StateNumber {
  std::string quantity;  ///< as in Result::metrics: "torque[A1]", "joint_force[B1]"
  std::string unit;
  std::vector<double> value;  ///< round-off is 0; NaN where there is none
};

/// @param result with one row
std::vector<StateNumber> list_state(const Result& result);

/// @param description whose `at` is not empty
std::string state_text(const Result& result, const FileDescription& description);
std::string state_json(const Result& result, const FileDescription& description, const std::vector<std::string>& files);

}  // namespace balance
