#pragma once
/// The quantities of a run at one state of any mechanism, including mechanisms with constraints on rates, temporary
/// payloads or too few actuators.

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <vector>

namespace balance::dynamics {

/// SI units.
struct SingleState {
  std::vector<CoordinateValue> configuration;         ///< of all coordinates, with the loops closed
  std::vector<CoordinateValue> rates, accelerations;  ///< of independent coordinates; those not named are 0
  double time = 0;                                    ///< for time-dependent loads and temporary payloads [s]
};

/// Options for evaluating a state: the moment reference and the time scale of a trajectory.
/// @param trajectory null: the origin, one second
InverseOptions make_state_options(const Trajectory* trajectory);

/// Values of coordinates in the order of the independent ones; 0 for those not named.
/// @param independent coordinates of the mechanism
/// @throws std::invalid_argument if another coordinate is named
VectorX independent_rates(const Mechanism& mechanism, const std::vector<CoordinateId>& independent,
                          const std::vector<CoordinateValue>& values);

/// The configuration's values of the independent coordinates, in their order.
VectorX independent_positions(const std::vector<CoordinateId>& independent,
                              const std::vector<CoordinateValue>& configuration);

/// @return one row at the state's time, without metrics; angles keep the full turns of the configuration. If the
///        efforts cannot be determined (mismatch, actuation_singularity), the arrays that depend on them are empty, a
///        note says why, and the outcome is done. No row if there is no such state
/// @throws std::invalid_argument as InverseDynamics, where the choice of the independent coordinates is described, and
///        if rates of other coordinates are given
RunResult evaluate_single_state(const Mechanism& mechanism, const SingleState& state,
                                const InverseOptions& options = {});

}  // namespace balance::dynamics
