#pragma once
/// Sentences about how runs end and what users should know of them, in the same words whoever finds it out.

#include "balance/model/mechanism.hpp"
#include "balance/model/spanning_tree.hpp"
#include "balance/motion/motion.hpp"

#include <string>
#include <vector>

namespace balance {

/// How a reason begins: "at t = 0.03 s: ".
std::string at_time(double time);

/// The end of a run whose actuators no longer hold the mechanism.
/// @param time [s]
/// @param configuration see configuration_text(); may be empty
MotionOutcome no_longer_held(double time, const std::string& configuration);

enum class NearWhat { motion, actuation };
/// @param mobility least there: smallest singular value of the matrix that becomes singular
std::string passes_near(NearWhat what, double mobility, double time);

/// @param loop names of its joints @param times at which it loses rank on its own [s], not empty
std::string passes_change_point(const std::string& loop, const std::vector<double>& times);
/// @param actuator without which the others would not hold the mechanism
std::string passes_without(const std::string& actuator, const std::vector<double>& times);

/// The end of a run whose numbers grew too large to be computed with. @param time [s] @param what grew: "torque[A1]"
MotionOutcome numbers_overflow(double time, const std::string& what);
/// The same, or that the mechanism has no mass.
MotionOutcome numbers_overflow(double time, const std::string& what, const Mechanism& mechanism);

/// "the disc of L lies flat on its plane": where rates grow without bound; empty if none does.
/// @param coordinates all of the mechanism's
std::string flat_disc(const Mechanism& mechanism, const std::vector<double>& coordinates);

std::string under_actuated(int motors, int freedoms);
std::string over_actuated(int motors, int freedoms);
std::string over_constrained();
std::string locked_freedom(const Mechanism& mechanism, const PassiveFreedom& spin);

}  // namespace balance
