#pragma once
/// The plane of a path's place s and its rate s', in which laws of motion are compared with what limits leave.

#include "balance/base/types.hpp"

namespace balance {

struct PhasePlane {
  VectorX time;            ///< of the law [s]
  VectorX path_parameter;  ///< s at these times, 0 to 1
  VectorX path_rate;       ///< s' [1/s]
  /// The maximum velocity curve: the largest s' at which the limits leave any s''; where friction jumps a place stands twice.
  VectorX mvc_path_parameter;
  VectorX mvc_path_rate;  ///< [1/s]; infinite: none at this place
};

}  // namespace balance
