#pragma once
/// What a run would hold at a moment at which a mechanism moves like this: one state of any mechanism, also of one whose rates are
/// bound, whose payloads come and go or whose actuators are too few.

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <vector>

namespace balance {

/// SI units.
struct SingleState {
  std::vector<CoordinateValue> configuration;         ///< of all coordinates, with the loops closed
  std::vector<CoordinateValue> rates, accelerations;  ///< of independent coordinates; those not named are 0
  double time = 0;                                    ///< of loads that change, of payloads that come and go [s]
};

/// What a state is looked at with: the moments' point and the length of time of a trajectory.
/// @param trajectory null: the origin, a second
InverseOptions make_state_options(const Trajectory* trajectory);

/// Values of coordinates in the order of the independent ones; 0 for those not named.
/// @param independent coordinates of the mechanism
/// @throws std::invalid_argument if another coordinate is named
VectorX independent_rates(const Mechanism& mechanism, const std::vector<CoordinateId>& independent,
                          const std::vector<CoordinateValue>& values);

/// The configuration's values of the independent coordinates, in their order.
VectorX independent_positions(const std::vector<CoordinateId>& independent,
                              const std::vector<CoordinateValue>& configuration);

/// @return one row at the state's time, without metrics; angles keep the whole turns of the configuration. Where the efforts cannot be
///         found (mismatch, actuation_singularity), the arrays of what depends on them are empty, a note tells why, and the outcome is
///         done. No row where there is no such state
/// @throws std::invalid_argument as InverseDynamics, which also says how the independent coordinates are chosen; for rates of others
RunResult evaluate_single_state(const Mechanism& mechanism, const SingleState& state,
                                const InverseOptions& options = {});

}  // namespace balance
