#pragma once
/// The equation of motion of a mechanism of which a trajectory drives or holds some coordinates and leaves others free.

#include "balance/mechanics/dynamics/forward_dynamics.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::simulation {

/// Whether wheels that roll in space and other constraints on speeds are accepted.
enum class RateConstraints { refused, accepted };

/// Of the free coordinates without the efforts: mass · f̈ + force = 0, with what the motion of the prescribed coordinates
/// contributes to the force.
struct FreeEquation {
  MatrixX mass;
  VectorX force;
};

/// Every coordinate is free: no actuator exerts anything.
struct AllFree {};

class PartlyDrivenMechanism {
 public:
  /// @param trajectory with a free motion
  /// @throws std::invalid_argument if something in the mechanism or the trajectory does not go with free coordinates. The
  ///         message is suitable for users.
  PartlyDrivenMechanism(const Mechanism& mechanism, const Trajectory& trajectory,
                        RateConstraints rate_constraints = RateConstraints::refused);
  /// With the start of a trajectory and, if it turns joints at constant speeds, with their rates. Free are the driven
  /// joints, otherwise independent coordinates, actuated ones first.
  /// @param trajectory nullptr: as the mechanism is assembled, at rest
  PartlyDrivenMechanism(const Mechanism& mechanism, const Trajectory* trajectory, AllFree);
  PartlyDrivenMechanism(const PartlyDrivenMechanism&) = delete;
  PartlyDrivenMechanism& operator=(const PartlyDrivenMechanism&) = delete;

  /// done, or why the motion cannot be followed from its start: mismatch if coordinates are neither driven, held nor
  /// free, or efforts are not determined
  const MotionOutcome& outcome() const { return outcome_; }

  /// With an actuator for every prescribed coordinate that needs one.
  const Mechanism& mechanism() const { return mechanism_; }
  /// With the free and held coordinates at rest at their start.
  const Trajectory& trajectory() const { return trajectory_; }
  const trajectory::FreeMotion& free_motion() const { return free_; }
  Eigen::Index count() const { return static_cast<Eigen::Index>(free_.free.size()); }  ///< of free coordinates
  const Coordinate& coordinate(Eigen::Index k) const { return mechanism_.coordinates[free_.free[k]]; }
  double duration() const { return duration_; }
  const trajectory::PrescribedMotion& driven_motion() const { return *motion_; }  ///< there is one unless all are free
  bool has_driven_motion() const { return motion_.has_value(); }
  /// That the components of the driven motion are: all that the trajectory prescribes, free coordinates included.
  const std::vector<CoordinateId>& driven_coordinates() const { return driven_; }
  /// All coordinates of the mechanism at the start.
  const VectorX& start() const { return start_; }
  VectorX free_start() const;                    ///< of the free coordinates
  VectorX free_rate() const;                     ///< stated rates of the free coordinates at the start
  const VectorX& unit() const { return unit_; }  ///< per free coordinate: the characteristic length or 1
  /// Prescribed coordinates that have got an actuator, as a note; empty: none.
  const std::string& note() const { return note_; }

  // States. All coordinates are sought near a guess, from which a state leaves the coordinates that it reaches.

  /// @param guess per coordinate of the mechanism; empty: the start. The next state is assembled there.
  void restart_near(const VectorX& guess);
  const VectorX& guess() const { return guess_; }
  /// Of later states, which still begin at the latest one.
  void set_guess(const VectorX& guess) { guess_ = guess; }

  enum class Driving { moving, at_rest };
  /// @param driving at_rest: the prescribed coordinates are at rest where they are at that time
  /// @return false if there is no such state: see stop_reason()
  bool set_state(double time, trajectory::Side side, const VectorX& position, const VectorX& rate,
                 Driving driving = Driving::moving);
  /// Of the free coordinates at the state last set. @return as set_state()
  bool find_accelerations(VectorX& acceleration);
  /// At the state last set. @return as set_state()
  bool find_equation(FreeEquation& equation);
  const dynamics::ForwardDynamics& dynamics() const { return *dynamics_; }

  /// Why the latest state or its accelerations do not exist.
  bool stop(double time, const std::string& reason);
  const std::string& stop_reason() const { return stop_reason_; }
  void clear_stop_reason() { stop_reason_.clear(); }
  MotionOutcome stop_outcome() const;

 private:
  bool compile();
  void begin();
  bool release();
  bool check_friction();
  bool release_actuators();
  bool choose_actuators();
  bool fail(MotionStatus status, const std::string& reason);
  void set_prescribed(double time, trajectory::Side side, Driving driving);
  bool move_near(double time);
  bool assemble(double time);
  bool check_independent(double time);
  MatrixX free_mass_columns(const MatrixX& mass) const;

  trajectory::FreeMotion free_;
  Mechanism mechanism_;
  Trajectory trajectory_;
  MotionOutcome outcome_;
  std::optional<trajectory::PrescribedMotion> motion_;
  std::vector<CoordinateId> driven_;
  VectorX start_, unit_;
  double duration_ = 1;
  std::string note_;

  std::optional<dynamics::ForwardDynamics> dynamics_;
  bool is_set_ = false;  ///< dynamics_ has a state near the guess
  trajectory::DriveSample sample_;
  VectorX guess_;  ///< at the latest state; empty: none yet
  VectorX position_, velocity_, prescribed_;
  double time_ = 0;
  bool is_mismatch_ = false;
  double stop_time_ = 0;
  std::string stop_reason_;
};

/// Why driven, held and free coordinates do not match the degrees of freedom: names those that the trajectory has
/// forgotten, or that depend on the others. Empty if they match, or if the mechanism cannot be assembled.
/// @param trajectory with drive joints; its start pose has values of all coordinates that it prescribes or leaves free
std::string explain_undriven_coordinates(const Mechanism& mechanism, const Trajectory& trajectory);

}  // namespace balance::simulation
