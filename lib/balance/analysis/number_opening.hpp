#pragma once
/// Numbers that no mechanism has off by themselves.

#include "balance/gradients/joint_opening.hpp"
#include "balance/model/mechanism.hpp"
#include "balance/study/tolerances.hpp"

#include <string>
#include <vector>

namespace balance {

/// A number whose change over-constrained loops cannot follow. It has no part in any deviation.
struct IncompatibleParameter {
  std::size_t index = 0;  ///< among the tolerances
  std::string key_path;   ///< the number's
  std::string joint, unit;
  double gap =
      0;  ///< what the number's deviation opens the joint by where that is most, the rest being moved so that it is least [m or rad]
};

/// Adds what a number opens.
/// @param number index among the tolerances
void add_incompatible_parameters(const ClosureGaps& found, std::size_t number, const std::string& path,
                                 double deviation, const Mechanism& mechanism,
                                 std::vector<IncompatibleParameter>& openings);

/// The numbers that open nothing, of which mechanisms can be drawn.
/// @throws std::invalid_argument if every number opens a joint
Tolerances remove_incompatible_parameters(const Tolerances& numbers,
                                          const std::vector<IncompatibleParameter>& openings);

/// "… cannot follow ground.points.A[2] by itself: its deviation would open D by 0.0001 m".
std::string format_incompatibility_note(const IncompatibleParameter& opening);

}  // namespace balance
