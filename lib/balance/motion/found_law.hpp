#pragma once
/// What is told of a law of motion that was searched for.

#include <string>
#include <vector>

namespace balance {

/// A part of the motion at one limit.
struct LawStretch {
  double begin = 0, end = 0;  ///< [s]
  double from = 0, to = 0;    ///< parts of the path, 0 to 1
  std::string limit;          ///< the quantity that is at its limit: "torque[A1]"
};

struct FoundLaw {
  double duration = 0;           ///< [s]
  std::vector<double> switches;  ///< times at which the path's acceleration jumps [s]
  std::vector<LawStretch> stretches;
  std::string of;   ///< law gentlest: the quantity whose peak is least
  double peak = 0;  ///< and that peak [SI]
  std::string unit;
  double momentum = 0;  ///< law steady-momentum: the angular momentum that is kept [N m s]; else 0
};

}  // namespace balance
