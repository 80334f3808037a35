#pragma once
/// Results of one run along one trajectory. Row k of every Samples belongs to time[k]. World axes, SI.
/// At a jump of the acceleration, and where a payload is taken up or set down, a row holds the value just after the
/// jump; at the end of the run, the value just before.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/results/term_magnitudes.hpp"
#include "balance/mechanics/results/torque_distribution_record.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/optimised_law.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace balance::results {

/// Statistic of a quantity over a whole run. Minimum and maximum are signed.
enum class Statistic { peak, rms, mean, range, minimum, maximum };  ///< members of Metric with the same names

/// A payload taken up or set down during the motion, with the jump of the actuator efforts.
struct PayloadEvent {
  std::string payload;
  bool taken_up = true;      ///< else set down
  double time = 0;           ///< [s]
  double speed = 0;          ///< speed of its CoM when moving with the mechanism [m/s]; nonzero speeds cause an impact
  double angular_speed = 0;  ///< angular velocity of its body [rad/s]; 0 if it has no moment of inertia
  VectorX effort_before, effort_after;  ///< per actuator, just before and after [N m or N]
  std::optional<double> impact_loss;    ///< energy that the impact takes; none where it is not in the motion [J]
};

/// "taken up" or "set down".
inline const char* describe_payload_event(const PayloadEvent& change) {
  return change.taken_up ? "taken up" : "set down";
}

/// A move of a counterweight along its body, by a motor of its own (mechanics/trajectory/adaptation.hpp).
struct AdaptationMove {
  std::string counterweight;  ///< also the name of its actuator
  double start = 0, end = 0;  ///< as prescribed [s]
  double from = 0, to = 0;    ///< its coordinate there, the distance from its place in the mechanism [m]
  double work = 0;            ///< ∫ force · speed dt of its actuator [J]
  double energy = 0;          ///< ∫ |force · speed| dt [J]
  VectorX peak_effort;        ///< per actuator: largest magnitude from start to end [N m or N]
};

/// Figures of the magnitude of one quantity. Values up to `round_off` are set to 0.
struct Metric {
  std::string
      quantity;  ///< "torque[A1]", "torque" (worst of all actuators), "shaking_force", "shaking_moment", "power", …
  std::string unit;      ///< "N", "N m", "W", …
  double peak = 0;       ///< largest magnitude; both sides of every jump count
  double peak_time = 0;  ///< [s]
  double rms = 0;        ///< root of the time average of the squared magnitude (trapezoidal rule, jumps honoured)
  double mean = 0;       ///< time average of the magnitude
  double range = 0;      ///< maximum minus minimum: of the signed value for scalars, of the magnitude for vectors
  double minimum = 0, maximum = 0;  ///< of the signed value for scalars, of the magnitude for vectors; not in files
  double round_off = 0;             ///< threshold below which figures are round-off (mechanics/results/round_off.hpp)
};

struct IntermediateSamples;
struct OrderAnalysis;

struct RunResult {
  MotionOutcome outcome;
  std::optional<trajectory::OptimisedLaw> optimised_law;  ///< if the law was optimised
  trajectory::PhasePlane phase_plane;                     ///< empty under control; the ceiling is empty without limits

  // names and units of the columns
  std::vector<std::string> coordinate_names;  ///< C columns of joint_position
  std::vector<std::string> coordinate_units;  ///< "rad" or "m"
  std::vector<std::string> joint_names;       ///< J joints; joint_force has axes() columns for each
  std::vector<std::string> actuator_names;    ///< A
  std::vector<std::string> actuator_units;    ///< "N m" or "N"
  std::vector<std::string> constraint_names,
      constraint_units;                        ///< "N" if the speed contains velocities of points or slides, else "N m"
  int axes = 2;                                ///< 2 planar, 3 spatial: columns of a vector
  int moment_axes = 1;                         ///< 1 planar (about z), 3 spatial
  Vector3 moment_reference = Vector3::Zero();  ///< reference point of moments

  VectorX time;                                                ///< N [s]
  Samples joint_position, joint_velocity, joint_acceleration;  ///< N×C [rad or m, …/s, …/s^2]; angles unwrapped
  Samples torque, power;                                       ///< N×A [N m or N; W]
  Samples total_torque;  ///< N×1: root of the sum of the squared torques; empty for one actuator or different units
  Samples com_position, com_velocity, com_acceleration;  ///< N×axes [m, m/s, m/s^2]
  Samples tool_position;                                 ///< N×axes [m]; empty without a tool
  Samples tool_orientation;  ///< planar N×1 angle [rad], spatial N×4 quaternion w x y z; empty without a tool
  Samples shaking_force,
      shaking_moment;          ///< N×axes [N], N×moment_axes [N m]: rate of momentum; opposite sign on the frame
  Samples shaking_moment_com;  ///< N×moment_axes [N m]: the same about the moving centre of mass
  Samples ground_force, ground_moment;  ///< on the frame, weight included; moment about `moment_reference`
  Samples joint_force,
      joint_moment;  ///< N×(J axes), N×(J moment_axes): on the second body, moment about the joint's point on it
  Samples constraint_force;  ///< N×Q, Q constraints on speeds: generalised forces conjugate to these speeds [N or N m]
  Samples constraint_power;  ///< N×Q: power of these forces [W]; empty if all constrained speeds are zero
  Samples kinetic_energy, potential_energy;  ///< N×1 [J]
  Samples mobility;                          ///< N×1: smallest singular value of the scaled drive Jacobian
  Eigen::VectorXi newton_iterations;         ///< N

  // on request, otherwise empty
  std::vector<std::string> body_names;  ///< B moving bodies
  Samples body_position;                ///< N×(B axes): their origins [m]
  Samples body_orientation;             ///< planar N×B angles [rad], spatial N×(B 4) quaternions w x y z

  // contributions to the torques (mechanics/dynamics/effort_breakdown.hpp), on request, otherwise empty
  Samples torque_inertia, torque_velocity, torque_friction, torque_weight, torque_spring,
      torque_load;  ///< N×A [N m or N]

  // along a record of the machine (motion/simulation/prediction.hpp), otherwise empty
  Samples torque_measured, torque_residual;  ///< N×A: low-passed; measured − computed, both low-passed [N m or N]

  // under control, otherwise empty
  std::vector<std::string> sliding_names;     ///< K coordinates with a sliding variable of the controller
  std::vector<std::string> sliding_units;     ///< "rad/s" or "m/s"
  Samples desired_position, tracking_error;   ///< N×C: of the joint coordinates; desired − actual [rad or m]
  Samples desired_tool_position, tool_error;  ///< N×axes: desired − actual [m]
  Samples tool_angle_error;  ///< N×1: planar: desired − actual; spatial: angle between the two [rad]
  Samples sliding_variable;  ///< N×K: −(ė + λ e) of the true motion [rad/s or m/s]
  Samples torque_variation;  ///< N×A: Σ |changes of the torque| so far [N m or N]
  Samples saturation;        ///< N×A: 1 while the torque is limited, else 0

  std::vector<Metric> metrics;
  std::vector<PayloadEvent> payload_events;      ///< in order of time; not read from files
  std::vector<AdaptationMove> adaptation_moves;  ///< counterweight by counterweight; not read from files
  double energy = 0;  ///< ∫ Σ|power| dt: energy moved by the actuators, back and forth [J]
  std::optional<trajectory::CorridorResult>
      corridor_result;  ///< if the path was optimised in a corridor; not read from files
  std::optional<TorqueDistributionRecord> torque_distribution;  ///< if the mechanism states one; not read from files

  std::shared_ptr<const OrderAnalysis> orders;  ///< on request (mechanics/results/orders.hpp); not read from files

  /// The samples besides the rows that the metrics rest on: both sides of every jump; not in files. Null: unknown.
  std::shared_ptr<const IntermediateSamples> intermediate;

  TermMagnitudes term_magnitudes;  ///< maxima over the run; not in files
  TermMagnitudes round_off;  ///< thresholds below which samples are round-off; the samples themselves are unchanged
};

}  // namespace balance::results

namespace balance {

using results::Metric;
using results::RunResult;
using results::Statistic;

}  // namespace balance
