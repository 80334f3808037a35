#include "balance/study/hold.hpp"

#include <cstdio>

namespace balance {

bool Hold::keeps(bool held, int determinant_sign) {
  if (!held || (sign_ != 0 && determinant_sign != sign_)) return false;
  sign_ = determinant_sign;
  return true;
}

MotionOutcome Hold::lost(double time, const std::string& configuration) {
  char text[160];
  std::snprintf(text, sizeof text,
                "at t = %.9g s: actuation singularity: the actuators do not hold the mechanism in a configuration "
                "reached there",
                time);
  return {MotionStatus::actuation_singularity, time, text + ("; configuration: " + configuration), {}};
}

}  // namespace balance
