#pragma once
/// The equation of motion in speeds of one's own choice.

#include "balance/model/speed.hpp"

#include <vector>

namespace balance {

/// What is called the motion's speeds, and what is kept at zero besides the mechanism's own constraints.
struct SpeedChoice {
  std::vector<GeneralisedSpeed> speeds, constrained;
};

}  // namespace balance
