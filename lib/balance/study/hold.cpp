#include "balance/study/hold.hpp"

#include "balance/motion/wording.hpp"

namespace balance {

bool Hold::keeps(bool held, int determinant_sign) {
  if (!held || (sign_ != 0 && determinant_sign != sign_)) return false;
  sign_ = determinant_sign;
  return true;
}

MotionOutcome Hold::lost(double time, const std::string& configuration) {
  MotionOutcome outcome = no_longer_held(time);
  outcome.reason += "; configuration: " + configuration;
  return outcome;
}

}  // namespace balance
