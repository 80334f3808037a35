#pragma once
/// Sentences about how runs end and what users should know of them, in the same words whoever finds it out.

#include "balance/model/mechanism.hpp"
#include "balance/model/spanning_tree.hpp"
#include "balance/motion/motion.hpp"

#include <string>

namespace balance {

/// How a reason begins: "at t = 0.03 s: ".
std::string at_time(double time);

/// The end of a run whose actuators no longer hold the mechanism.
/// @param time [s]
/// @param configuration see configuration_text(); may be empty
MotionOutcome no_longer_held(double time, const std::string& configuration);

/// @param distance smallest pivot of the matrix that becomes singular
std::string passes_near(const std::string& what, double distance, double time);

/// The end of a run whose numbers grew too large to be computed with. @param time [s] @param what grew: "torque[A1]"
MotionOutcome numbers_overflow(double time, const std::string& what);

std::string under_actuated(int motors, int freedoms);
std::string over_actuated(int motors, int freedoms);
std::string over_constrained();
std::string held_spin(const Mechanism& mechanism, const IdleSpin& spin);

}  // namespace balance
