#pragma once
/// How far the numbers of a mechanism may be off when it is made.

#include <cmath>
#include <string>
#include <vector>

namespace balance {

/// How a number is spread about what the spec says: independently of all others.
enum class Distribution { normal, uniform };

/// A parameter or any number of the spec, and how far it may be off.
struct TolerancedParameter {
  std::string path;  ///< "counterweights.cw1.mass", "parameters.l1"
  double value = 0;  ///< what the spec says [SI, parameters as written]
  double width = 0;  ///< normal: the standard deviation; uniform: half of the interval [as the value]
  Distribution distribution = Distribution::normal;
  double unit = 1;            ///< SI value of the spec's unit here; 1 for parameters
  int input = -1;             ///< of the spec's recording: changes the number by as much as itself
  bool is_positive = false;   ///< a value below zero makes no sense
  double relative_width = 0;  ///< the width is so large a part of the value's size, and follows it; 0: it is what it is
  int recording_index = -1;   ///< among the recording's toleranced numbers: what the value is of

  double deviation() const { return distribution == Distribution::normal ? width : width / std::sqrt(3.0); }
};

using Tolerances = std::vector<TolerancedParameter>;

}  // namespace balance
