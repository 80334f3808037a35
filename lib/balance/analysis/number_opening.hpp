#pragma once
/// Numbers that no mechanism has off by themselves.

#include "balance/gradients/joint_opening.hpp"
#include "balance/model/mechanism.hpp"
#include "balance/study/tolerances.hpp"

#include <string>
#include <vector>

namespace balance {

/// A number whose change over-constrained loops cannot follow. It has no part in any deviation.
struct NumberOpening {
  std::size_t number = 0;  ///< among the tolerances
  std::string path;        ///< the number's
  std::string joint, unit;
  double gap =
      0;  ///< what the number's deviation opens the joint by where that is most, the rest being moved so that it is least [m or rad]
};

/// Adds what a number opens.
/// @param number index among the tolerances
void add_openings(const JointOpenings& found, std::size_t number, const std::string& path, double deviation,
                  const Mechanism& mechanism, std::vector<NumberOpening>& openings);

/// The numbers that open nothing, of which mechanisms can be drawn.
/// @throws std::invalid_argument if every number opens a joint
Tolerances without_openings(const Tolerances& numbers, const std::vector<NumberOpening>& openings);

/// "… cannot follow ground.points.A[2] by itself: its deviation would open D by 0.0001 m".
std::string opening_note(const NumberOpening& opening);

}  // namespace balance
