#pragma once
/// Controllers as specified: plain values, per actuator in the mechanism's order. SI; angles in rad. The laws are those
/// of P0 section 1.3; docs/control.md derives them.

#include "balance/mechanics/model/mechanism.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace balance::study {

enum class ControllerType {
  none,                   ///< zero efforts: free motion
  open_loop,              ///< efforts over time, independent of the motion
  pd,                     ///< u = Kp e + Kd ė, optionally with efforts that hold the mechanism at rest
  computed_torque,        ///< u = M′(q̈d + Kd ė + Kp e) + w′ + z′
  sliding_mode,           ///< P0 eq. 47 in the actuated coordinates
  extended_sliding_mode,  ///< P0 eq. 61 in the coordinates of the spanning tree
};

/// Whether a PD controller adds the efforts that hold the model at rest (weight, springs, loads).
enum class GravityCompensation { compensated, ignored };

/// Norm that defines the admissible acceleration nearest to the desired one in redundant coordinates: kinetic energy of
/// the difference (P0 eq. 57), or its length, in rad and characteristic lengths.
enum class AccelerationProjection { inertia, identity };

enum class VelocitySource {
  measured,    ///< true rates plus noise
  difference,  ///< difference of the last two measured positions over the period
};

/// Measurement of the actuated coordinates: true value + noise, rounded to whole steps. Empty: none.
struct Measurement {
  VectorX position_step;   ///< resolution [rad or m]
  VectorX position_noise;  ///< standard deviation [rad or m]
  VectorX velocity_noise;  ///< standard deviation of a measured rate [rad/s or m/s]
  VelocitySource velocity = VelocitySource::measured;
  std::uint64_t seed = 1;
};

/// Efforts of an open loop, constant before the first and after the last time. Without times, the efforts that the
/// model needs along the desired motion.
struct EffortTable {
  enum class Interpolation {
    linear,
    spline  ///< C² cubic spline (not-a-knot) through at least four rows
  };

  std::vector<double> time;     ///< increasing [s]
  std::vector<VectorX> effort;  ///< one per time [N m or N]
  Interpolation interpolation = Interpolation::linear;
  bool is_held = false;  ///< held between the controller's samples; false: they act continuously
};

/// Deviation of the start from the desired motion. The rates of the actuated coordinates are the desired ones.
struct InitialError {
  std::vector<CoordinateValue> joints;  ///< added to the desired coordinates [rad or m]
  std::optional<Vector3> tool;          ///< added to the tool's desired position [m]
  double angle = 0;                     ///< planar: added to the tool's desired angle, with `tool` [rad]
};

struct Controller {
  std::string name;
  ControllerType type = ControllerType::computed_torque;
  double period = 1e-3;             ///< between two samples, if is_sampled(); efforts are held in between [s]
  std::optional<double> bandwidth;  ///< natural frequency for default gains [Hz]; none: a hundredth of the sample rate
  double damping = 1;               ///< damping ratio for default gains

  /// Rates of the quantities whose errors pd, computed torque and sliding mode control, instead of the actuated
  /// coordinates; empty: none.
  std::vector<model::GeneralisedSpeed> speeds;
  VectorX kp;  ///< pd [N m/rad or N/m], computed torque [1/s²], per actuator or speed; empty: from bandwidth
  VectorX kd;  ///< pd [N m s/rad or N s/m], computed torque [1/s], likewise; empty: from bandwidth and damping
  GravityCompensation gravity = GravityCompensation::compensated;

  VectorX lambda;  ///< λ [1/s], per actuator or speed; one entry for extended sliding mode; empty: 2π bandwidth
  VectorX
      switching_gain;  ///< [rad/s² or m/s²]; extended: one entry [rad/s²], per characteristic length for slides; empty:
                       ///< from the motion
  VectorX boundary_layer;  ///< |s| below which it is linear, sized as the gain [rad/s or m/s]; empty: sign(s)
  AccelerationProjection projection = AccelerationProjection::inertia;

  EffortTable efforts;
  VectorX torque_limit;  ///< maximum magnitude [N m or N]; empty: none
  Measurement measurement;
  InitialError initial_error;
  std::optional<Mechanism> model;  ///< the controller's model of the mechanism; none: the mechanism itself

  double natural_frequency() const;  ///< [rad/s]
  /// Efforts given over time that act continuously.
  bool is_continuous() const { return type == ControllerType::open_loop && !efforts.time.empty() && !efforts.is_held; }
  bool is_sampled() const { return type != ControllerType::none && !is_continuous(); }
};

/// Controllers that need no declaration: `none`, `open-loop`, `pd`, `computed-torque`, `sliding-mode`,
/// `extended-sliding-mode`, each with default values.
std::vector<Controller> built_in_controllers();

/// Name of a type in the spec language: "computed-torque".
const char* controller_type_name(ControllerType type);

/// Why a speed is not the rate of a quantity whose errors a controller can follow, such as the position of a point;
/// empty if it is.
std::string why_not_a_rate(const model::GeneralisedSpeed& speed, SpaceKind space);

/// Why controllers of a type have no speeds; empty if they have.
std::string why_no_speeds(ControllerType type);

/// All types in the order of the enumeration.
std::vector<std::string> controller_type_names();

}  // namespace balance::study

namespace balance {

using study::Controller;

}  // namespace balance
