#pragma once
/// The loads that one design is made for: numbers of the spec that differ from case to case.

#include "balance/base/types.hpp"

#include <string>
#include <vector>

namespace balance {

/// A number that the load changes: a parameter or any number of the mechanism.
struct LoadParameter {
  std::string name;    ///< as `design: for` says it: "cargo.mass"
  std::string path;    ///< "payloads.cargo.mass", "parameters.mp"
  double nominal = 0;  ///< as the spec has it [SI, parameters as written]
  double unit = 1;     ///< SI value of the spec's unit here; 1 for parameters
  int input = -1;      ///< of the study's recording
};

/// What becomes of a figure that has a value in every case.
enum class CaseAggregation { worst, mean };

struct LoadCases {
  std::vector<LoadParameter> numbers;  ///< empty: there is one load, the spec's own
  MatrixX values;                      ///< cases × numbers [SI, parameters as written]
  CaseAggregation aggregation = CaseAggregation::worst;
  std::vector<int> adapted;  ///< free numbers that may differ from case to case, increasing

  Eigen::Index size() const { return values.rows(); }
};

}  // namespace balance
