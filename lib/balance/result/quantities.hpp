#pragma once
/// Which quantities of a Result a file holds, under which names and in which order: one list for every format.

#include "balance/result/result.hpp"

#include <string>
#include <vector>

namespace balance {

/// What the columns of a quantity belong to.
enum class Columns { single, coordinate, actuator, axis, quaternion, joint, joint_axis, sliding };

/// The sampled quantities that one Result may hold. Refers to the result, which must outlive it.
struct Quantity {
  std::string name;        ///< of the dataset: "joint_position"
  std::string short_name;  ///< behind the name of a coordinate, actuator or joint: "position"
  std::string long_name;
  std::vector<std::string> units;  ///< one per column; one for all if they are alike
  Columns columns = Columns::single;
  bool about = false;  ///< a moment about Result::about
  Samples Result::*member = nullptr;
  const Samples* samples = nullptr;  ///< that member of the result
};

/// All that there are for mechanisms of the result's space, with or without samples.
std::vector<Quantity> all_quantities(const Result& result);

/// Quantities without columns (no tool, no actuator) are left out.
std::vector<Quantity> list_quantities(const Result& result);

/// "rad" if all are alike, else "mixed"; "1" for none.
std::string common_unit(const std::vector<std::string>& units);

/// The first of "x", "y", "z".
std::vector<std::string> axis_labels(int axes);

std::vector<std::string> quaternion_labels();

}  // namespace balance
