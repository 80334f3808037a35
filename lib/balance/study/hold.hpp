#pragma once
/// Whether the actuators hold the mechanism all along a walk.

#include "balance/motion/motion.hpp"

#include <string>

namespace balance {

class Hold {
 public:
  /// @param held the actuators hold the mechanism at this stop
  /// @param determinant_sign changes where a singularity of actuation is passed; 0: not watched
  /// @return false if they do not, or did not somewhere since the last stop
  bool keeps(bool held, int determinant_sign);

  /// What to tell the user of a run that lost it at a time [s].
  /// @param configuration see configuration_text()
  static MotionOutcome lost(double time, const std::string& configuration);

 private:
  int sign_ = 0;
};

}  // namespace balance
