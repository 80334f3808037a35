#pragma once
/// The second formulation: a planar mechanism in natural coordinates (fully Cartesian coordinates), moved along a trajectory.
/// It shares with the first nothing below the Mechanism and the trajectory's values: basic points instead of a tree, a constant
/// mass matrix and quadratic constraints instead of recursions.
/// Source: P3 sections 2 and 3, with its mass matrices re-derived; docs/theory.md, Natural coordinates.

#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/synthesis/verification/natural_dynamics.hpp"
#include "balance/synthesis/verification/natural_equations.hpp"

#include <memory>
#include <optional>

namespace balance::natural {

/// From a trajectory as stated to something that natural coordinates can follow.
struct NaturalCompiledTrajectory {
  MotionOutcome outcome;  ///< done: can be followed
  int freedoms = 0;       ///< by rank
  DriveQuantities quantities;
  NaturalCoordinates start;  ///< at time 0
  std::optional<PrescribedMotion> schedule;
};

/// @param model with all coordinates and angles that the trajectory speaks of
NaturalCompiledTrajectory compile_natural_trajectory(const Mechanism& mechanism, const NaturalModel& model,
                                                     const Trajectory& trajectory);

/// The trajectory speaks of the tool's angle, or may come to do so.
bool has_tool_angle(const Mechanism& mechanism, const Trajectory& trajectory);

class NaturalSimulation {
 public:
  /// @param start a configuration near which the trajectory starts; only its assembly mode and whole turns matter
  /// @throws std::invalid_argument if the mechanism is spatial, the start has the wrong size, or trajectory and mechanism do
  ///         not fit (a drive on the tool without a tool, …)
  NaturalSimulation(const Mechanism& mechanism, const Trajectory& trajectory, const InitialCoordinates& start);
  ~NaturalSimulation();
  NaturalSimulation(const NaturalSimulation&) = delete;
  NaturalSimulation& operator=(const NaturalSimulation&) = delete;

  /// done: it can be followed; else why not, or why the last step failed.
  const MotionOutcome& outcome() const { return outcome_; }
  /// Of the plan; only if it is done.
  const PrescribedMotion& schedule() const;
  int freedoms() const;
  const std::vector<std::string>& notes() const;

  /// To time 0, and on. On false outcome() says why.
  bool begin();
  bool advance(double time);
  double time() const;
  /// Accelerations on one side of the present time (begin and advance leave those after it).
  void update_accelerations(Side side);
  /// From now on only what is there in a stretch has mass (at first everything has).
  void apply_payloads(const PayloadIntervals& stretches, int stretch);
  /// Speed of a place on a body [m/s] and how fast the body turns [rad/s], at the present moment.
  double speed_of(BodyId body, const Vector3& place) const;
  double angular_speed_of(BodyId body) const;
  /// The present moment. On false the actuators do not hold the mechanism, or did not somewhere since the last look.
  bool observe();
  const Sample& last() const;
  int iterations() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
  MotionOutcome outcome_;
};

}  // namespace balance::natural
