#pragma once
/// What is told of a law of motion, or a way within a corridor, that was searched for.

#include "balance/foundation/base/types.hpp"

#include <string>
#include <vector>

namespace balance {

/// A part of the motion at one limit.
struct ActiveLimitInterval {
  double begin = 0, end = 0;            ///< [s]
  double path_begin = 0, path_end = 0;  ///< parts of the path, 0 to 1
  std::string limit;                    ///< the quantity that is at its limit: "torque[A1]"
};

struct OptimisedLaw {
  double duration = 0;               ///< [s]
  std::vector<double> switch_times;  ///< times at which the path's acceleration jumps [s]
  std::vector<ActiveLimitInterval> active_limits;
  std::string objective;       ///< law gentlest: the quantity whose peak is least
  double objective_value = 0;  ///< and that peak [SI]
  std::string unit;
  double momentum = 0;  ///< law steady-momentum: the angular momentum that is kept [N m s]; else 0
};

struct CorridorResult {
  double width = 0, max_offset = 0;  ///< how far the path may be left, and how far it is at most [m or rad]
  std::string width_unit;            ///< "m" or "rad"
  std::string objective;             ///< the quantity whose peak is least; law fastest: "duration"
  double objective_value = 0;        ///< what was reached [SI]
  double centreline_value = 0;       ///< what the path itself would need [SI]
  std::string unit;
  int starts = 0;           ///< of the search
  int agreeing_starts = 0;  ///< how many of them ended in the same place, up to 1e-5 of the figure
};

/// The plane of a path's place s and its rate s', in which laws of motion are compared with what limits leave.
struct PhasePlane {
  VectorX time;            ///< of the law [s]
  VectorX path_parameter;  ///< s at these times, 0 to 1
  VectorX path_rate;       ///< s' [1/s]
  /// The maximum velocity curve: the largest s' at which the limits leave any s''; where friction jumps a place stands twice.
  VectorX mvc_path_parameter;
  VectorX mvc_path_rate;  ///< [1/s]; infinite: none at this place
};

}  // namespace balance
