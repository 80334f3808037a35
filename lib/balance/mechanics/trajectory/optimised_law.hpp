#pragma once
/// Results of the search for a motion law or for a path within a corridor.

#include "balance/foundation/base/types.hpp"

#include <string>
#include <vector>

namespace balance::trajectory {

/// A part of the motion during which a limit is active.
struct ActiveLimitInterval {
  double begin = 0, end = 0;            ///< [s]
  double path_begin = 0, path_end = 0;  ///< path parameters, 0 to 1
  std::string limit;                    ///< the quantity at its limit: "torque[A1]"
};

struct OptimisedLaw {
  double duration = 0;               ///< [s]
  std::vector<double> switch_times;  ///< times at which the path's acceleration jumps [s]
  std::vector<ActiveLimitInterval> active_limits;
  std::string objective;       ///< law gentlest: the quantity whose peak is minimised
  double objective_value = 0;  ///< its peak [SI]
  std::string unit;
  double momentum = 0;  ///< law steady-momentum: the constant angular momentum [N m s]; otherwise 0
};

struct CorridorResult {
  double width = 0, max_offset = 0;  ///< allowed and actual maximum offset from the path [m or rad]
  std::string width_unit;            ///< "m" or "rad"
  std::string objective;             ///< the quantity whose peak is minimised; law fastest: "duration"
  double objective_value = 0;        ///< achieved value [SI]
  double centreline_value = 0;       ///< value on the path without offset [SI]
  std::string unit;
  int starts = 0;           ///< number of starts of the search
  int agreeing_starts = 0;  ///< number of starts whose result is within 1e-5 of the best
};

/// The phase plane of path parameter s and rate s', for comparing motion laws with the limits.
struct PhasePlane {
  VectorX time;            ///< of the law [s]
  VectorX path_parameter;  ///< s at these times, 0 to 1
  VectorX path_rate;       ///< s' [1/s]
  /// The maximum velocity curve: the largest s' at which the limits admit any s''. A place occurs twice if friction
  /// jumps there.
  VectorX mvc_path_parameter;
  VectorX mvc_path_rate;  ///< [1/s]; infinite: no limit at this place
};

}  // namespace balance::trajectory
