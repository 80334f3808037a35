#pragma once
/// Mechanisms to time, built without the reader so that the benchmarks need nothing but the library.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

namespace balance::bench {

/// P3 Table 1 with the tool's straight line of P3 section 4.
Mechanism three_rrr();
Trajectory three_rrr_cycloid(long samples);

/// Three revolute joints in the plane under gravity.
Mechanism planar_rrr();
Trajectory planar_rrr_cycloid(long samples);

/// Seven revolute joints in space with full inertias, axes turned by a quarter from link to link.
Mechanism seven_joint_arm();

}  // namespace balance::bench
