#pragma once
/// The samples behind each metric of a run.

#include "balance/result/result.hpp"

#include <string>
#include <vector>

namespace balance {

/// Columns of one of a Result's arrays that together are one quantity. Refers to the result, which must outlive it.
struct QuantitySeries {
  std::string quantity;  ///< as in Result::metrics: "torque[A1]", "shaking_force"; the worst of several is none
  const Samples* samples = nullptr;
  int first = 0, count = 1;  ///< columns
  double round_off = 0;      ///< of each of them (result/round_off.hpp)
};

/// Quantities without samples are left out.
std::vector<QuantitySeries> list_series(const RunResult& result);

}  // namespace balance
