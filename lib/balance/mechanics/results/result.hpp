#pragma once
/// Everything that one run along one trajectory found. Row k of every Samples belongs to time[k]. World axes, SI.
/// At a jump of the acceleration, and where a payload is taken up or set down, the row holds the value just after it; at the end just
/// before.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/results/term_magnitudes.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/optimised_law.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

/// Which number stands for a quantity over a whole run.
enum class Statistic { peak, rms, mean, range };  ///< of the same names in Metric

/// A payload taken up or set down on the way, with the jump of what the actuators must do.
struct PayloadEvent {
  std::string payload;
  bool taken_up = true;      ///< else set down
  double time = 0;           ///< [s]
  double speed = 0;          ///< of its CoM, where the mechanism has it [m/s]: what moves then meets in an impact
  double angular_speed = 0;  ///< angular velocity of its body [rad/s]; 0 where it has no moment of inertia
  VectorX effort_before, effort_after;  ///< per actuator, just before and after [N m or N]
};

/// "taken up" or "set down".
inline const char* describe_payload_event(const PayloadEvent& change) {
  return change.taken_up ? "taken up" : "set down";
}

/// The figures of one quantity's magnitude. What is no larger than round-off is 0.
struct Metric {
  std::string
      quantity;  ///< "torque[A1]", "torque" (worst actuator: the largest of them), "shaking_force", "shaking_moment", "power", …
  std::string unit;      ///< "N", "N m", "W", …
  double peak = 0;       ///< largest magnitude; both sides of every jump count
  double peak_time = 0;  ///< [s]
  double rms = 0;        ///< root of the time average of the squared magnitude (trapezoidal rule, jumps honoured)
  double mean = 0;       ///< time average of the magnitude
  double range = 0;      ///< largest minus smallest: of the signed value for scalars, of the magnitude for vectors
  double round_off = 0;  ///< what is no larger was computed but means 0 (mechanics/results/round_off.hpp)
};

struct RunResult {
  MotionOutcome outcome;
  std::optional<OptimisedLaw> optimised_law;  ///< of a law that was searched for
  PhasePlane phase_plane;                     ///< empty under control; the ceiling is empty where no limits are stated

  // what the columns are called
  std::vector<std::string> coordinate_names;  ///< C columns of joint_position
  std::vector<std::string> coordinate_units;  ///< "rad" or "m"
  std::vector<std::string> joint_names;       ///< J joints; joint_force has axes() columns for each
  std::vector<std::string> actuator_names;    ///< A
  std::vector<std::string> actuator_units;    ///< "N m" or "N"
  std::vector<std::string> constraint_names,
      constraint_units;                        ///< "N" where the speed is one of points or slides, else "N m"
  int axes = 2;                                ///< 2 planar, 3 spatial: columns of a vector
  int moment_axes = 1;                         ///< 1 planar (about z), 3 spatial
  Vector3 moment_reference = Vector3::Zero();  ///< the point that moments are about

  VectorX time;                                                ///< N [s]
  Samples joint_position, joint_velocity, joint_acceleration;  ///< N×C [rad or m, …/s, …/s^2]; angles run on past ±π
  Samples torque, power;                                       ///< N×A [N m or N; W]
  Samples total_torque;  ///< N×1: root of the sum of the squared torques; empty for one actuator or several units
  Samples com_position, com_velocity, com_acceleration;  ///< N×axes [m, m/s, m/s^2]
  Samples tool_position;                                 ///< N×axes [m]; empty without a tool
  Samples tool_orientation;  ///< planar N×1 angle [rad], spatial N×4 quaternion w x y z; empty without a tool
  Samples shaking_force,
      shaking_moment;          ///< N×axes [N], N×moment_axes [N m]: rate of momentum; the frame feels the opposite
  Samples shaking_moment_com;  ///< N×moment_axes [N m]: the same about the moving centre of mass
  Samples ground_force, ground_moment;  ///< what the frame feels, weight included; moment about `about`
  Samples joint_force,
      joint_moment;  ///< N×(J axes), N×(J moment_axes): on the second body, moment about the joint's point on it
  Samples
      constraint_force;  ///< N×Q, Q constraints on speeds: generalised forces, whose power is theirs times the speed [N or N m]
  Samples kinetic_energy, potential_energy;  ///< N×1 [J]
  Samples mobility;                          ///< N×1: smallest singular value of the scaled drive Jacobian
  Eigen::VectorXi newton_iterations;         ///< N

  // where asked for; empty else
  std::vector<std::string> body_names;  ///< B moving bodies
  Samples body_position;                ///< N×(B axes): their origins [m]
  Samples body_orientation;             ///< planar N×B angles [rad], spatial N×(B 4) quaternions w x y z

  // what the torques add up from (mechanics/dynamics/effort_breakdown.hpp), where asked for; empty else
  Samples torque_inertia, torque_velocity, torque_friction, torque_weight, torque_spring,
      torque_load;  ///< N×A [N m or N]

  // of a run under control; empty else
  std::vector<std::string> sliding_names;     ///< K coordinates that the controller has a sliding variable for
  std::vector<std::string> sliding_units;     ///< "rad/s" or "m/s"
  Samples desired_position, tracking_error;   ///< N×C: of the joint coordinates; desired − actual [rad or m]
  Samples desired_tool_position, tool_error;  ///< N×axes: desired − actual [m]
  Samples tool_angle_error;  ///< N×1: planar desired − actual; spatial: the angle between them [rad]
  Samples sliding_variable;  ///< N×K: −(ė + λ e) of the true motion [rad/s or m/s]
  Samples torque_variation;  ///< N×A: Σ |changes of the torque| so far [N m or N]
  Samples saturation;        ///< N×A: 1 while the torque is cut by its limit, else 0

  std::vector<Metric> metrics;
  std::vector<PayloadEvent> payload_events;       ///< in the order of time; no file is read for them
  double energy = 0;                              ///< ∫ Σ|power| dt: what the actuators move back and forth [J]
  std::optional<CorridorResult> corridor_result;  ///< of a way that was searched for; no file is read for it

  TermMagnitudes term_magnitudes;  ///< largest in the run; not in files
  TermMagnitudes round_off;  ///< what samples that ought to be zero may be; the samples themselves are as computed
};

}  // namespace balance
