#pragma once
/// Speeds that are no rates of coordinates: sums of rates of joint coordinates and components of the tool's motion.

#include <string>
#include <vector>

namespace balance {

/// factor · (what it is of). Own: in the axes of the tool's body, which move.
struct SpeedTerm {
  enum class Of { coordinate, tool_velocity, tool_velocity_own, tool_turning, tool_turning_own };
  Of of = Of::coordinate;
  int index = 0;      ///< coordinate of the mechanism, or component 0 to 2
  double factor = 1;  ///< SI
};

/// φ or ψ of P0 eq. 1 with constant factors.
struct Speed {
  std::string name;
  std::vector<SpeedTerm> terms;
};

/// What is called the motion's speeds, and what the mechanism's constraints on rates keep at zero.
struct SpeedChoice {
  std::vector<Speed> speeds, zero;
};

}  // namespace balance
