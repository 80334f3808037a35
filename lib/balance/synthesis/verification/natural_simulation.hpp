#pragma once
/// The second formulation: a planar mechanism in natural coordinates (fully Cartesian coordinates), moved along a
/// trajectory. It shares with the first one only the Mechanism and the trajectory's values: it has basic points instead
/// of a tree, and a constant mass matrix and quadratic constraints instead of recursions.
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

/// A trajectory in a form that natural coordinates can follow.
struct NaturalCompiledTrajectory {
  MotionOutcome outcome;  ///< done if it can be followed
  int freedoms = 0;       ///< by rank
  DriveQuantities quantities;
  NaturalCoordinates start;  ///< at time 0
  std::optional<PrescribedMotion> schedule;
};

/// @param model must have all coordinates and angles to which the trajectory refers
NaturalCompiledTrajectory compile_natural_trajectory(const Mechanism& mechanism, const NaturalModel& model,
                                                     const Trajectory& trajectory);

/// Whether the trajectory refers to the tool's angle, or may do so.
bool has_tool_angle(const Mechanism& mechanism, const Trajectory& trajectory);

class NaturalSimulation {
 public:
  /// @param start a configuration near the trajectory's start; only its assembly mode and whole turns matter
  /// @throws std::invalid_argument if the mechanism is spatial, the start has the wrong size, or trajectory and
  /// mechanism do not match (a drive on the tool without a tool, …)
  NaturalSimulation(const Mechanism& mechanism, const Trajectory& trajectory, const InitialCoordinates& start);
  ~NaturalSimulation();
  NaturalSimulation(const NaturalSimulation&) = delete;
  NaturalSimulation& operator=(const NaturalSimulation&) = delete;

  /// done if the trajectory can be followed; otherwise why not, or why the last step failed.
  const MotionOutcome& outcome() const { return outcome_; }
  /// Requires that the trajectory can be followed.
  const PrescribedMotion& schedule() const;
  int freedoms() const;
  const std::vector<std::string>& notes() const;

  /// Go to time 0, and to later times. If they return false, outcome() says why.
  bool begin();
  bool advance(double time);
  double time() const;
  /// Computes accelerations on one side of the current time (begin and advance leave those after it).
  void update_accelerations(Side side);
  /// From now on, only payloads that are present in an interval have mass (initially, all have).
  void apply_payloads(const PayloadIntervals& intervals, int interval);
  /// Speed of a place on a body [m/s] and angular speed of the body [rad/s], at the current time.
  double speed_of(BodyId body, const Vector3& point) const;
  double angular_speed_of(BodyId body) const;
  /// Evaluates the current time. Returns false if the actuators do not hold the mechanism.
  bool observe();
  const Sample& last() const;
  int iterations() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
  MotionOutcome outcome_;
};

}  // namespace balance::natural
