#pragma once
/// A control law: efforts from measurements, the desired motion and the controller's model of the mechanism. P0 section
/// 1.3; derivations and proofs are in docs/control.md.

#include "balance/mechanics/dynamics/forward_dynamics.hpp"
#include "balance/mechanics/model/torque_distribution.hpp"
#include "balance/motion/control/task_speeds.hpp"
#include "balance/motion/study/controller_spec.hpp"

#include <array>
#include <optional>
#include <vector>

namespace balance::control {

/// Efforts given over time that act continuously: cubics between knots, limited by the actuators.
class EffortProfile {
 public:
  /// @param limit maximum magnitude per actuator [N m or N]; empty: none
  /// @throws std::invalid_argument if a table has no rows, or a spline fewer than four
  EffortProfile(const study::EffortTable& table, const VectorX& limit);

  /// @param effort one per actuator [N m or N]
  void evaluate(double time, VectorX& effort) const;
  VectorX evaluate(double time) const;
  /// 1 where the limit is active, else 0.
  VectorX saturation(double time) const;
  /// Σ |changes| of each effort between two times.
  VectorX total_variation(double from, double to) const;

  /// Times at which the efforts are not smooth: those of the table, and where limits become active or inactive.
  /// Increasing [s].
  const std::vector<double>& knots() const { return knots_; }

 private:
  /// c0 + c1 x + c2 x² + c3 x³ in the time x from the beginning of the piece.
  using Cubic = std::array<double, 4>;
  struct Piece {
    double begin, end;
    std::vector<Cubic> efforts;
  };

  void make_pieces(const study::EffortTable& table);
  void add_saturation_knots();
  const Piece& find_piece(double time) const;
  double evaluate_unsaturated(const Piece& piece, std::size_t actuator, double time) const;
  double saturate(std::size_t actuator, double effort) const;
  static std::vector<double> find_monotone_intervals(const Cubic& cubic, double begin, double end);

  std::vector<Piece> pieces_;
  VectorX effort_limit_;
  std::vector<double> knots_;
};

/// Desired state of the mechanism at one time, per coordinate of the mechanism.
struct DesiredState {
  VectorX position, velocity, acceleration;
};

/// Basis for gains that the controller does not specify.
struct GainDesignMotion {
  VectorX peak_acceleration;        ///< per actuator: maximum desired magnitude along the motion
  std::vector<DesiredState> along;  ///< the motion at some of its times
};

/// Has a sliding variable.
struct SlidingQuantity {
  std::string name;
  bool is_length = false;
};

/// Whether the controller computes efforts by inverse dynamics, which fails in singular configurations.
bool is_inverse_dynamics_based(const Controller& controller);

/// Whether the controller uses a desired motion: free motion and given efforts do not.
bool needs_desired_motion(const Controller& controller);

class ControlLaw {
 public:
  /// @param truth the controlled mechanism; like the controller and the model, it must outlive the law
  /// @param model the mechanism with which the law computes, of the same coordinates and actuators
  /// @throws std::invalid_argument if gains and actuators differ in number
  ControlLaw(const Mechanism& truth, const Controller& controller, const Mechanism& model);

  /// Computes with another model from now on, as when a payload is taken up. Gains stay.
  /// @param model with the coordinates and actuators of the mechanism; must outlive the law
  void change_model(double time, const Mechanism& model);

  /// Assembles the model at the start of the mechanism and sets the gains.
  /// @param position, velocity per coordinate of the mechanism
  /// @return mismatch if this type of controller needs more actuators than there are
  MotionOutcome start(const VectorX& position, const VectorX& velocity, const GainDesignMotion& basis);

  /// @param position, velocity measured, per actuator
  /// @return done, or why there are no efforts at this state: a singular configuration of the model
  MotionOutcome compute_efforts(double time, const DesiredState& desired, const VectorX& position,
                                const VectorX& velocity);

  const VectorX& efforts() const { return efforts_; }        ///< per actuator, limited [N m or N]
  const VectorX& saturation() const { return saturation_; }  ///< 1 where the limit was active, else 0

  /// The coordinates or speeds that have a sliding variable s = −(ė + λ e); empty for laws without one.
  std::vector<SlidingQuantity> sliding_quantities() const;
  /// Their s at a state of the mechanism. The centre of mass in a speed is that of the model.
  /// @param position, velocity per coordinate of the mechanism
  VectorX sliding_variables(const DesiredState& desired, const VectorX& position, const VectorX& velocity) const;
  /// Round-off of these, for that of coordinates and their rates.
  VectorX sliding_round_off(const VectorX& position, const VectorX& velocity) const;

  /// Notes on the gains for the user.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  struct TrackingErrors {
    VectorX position, rate, acceleration;  ///< e, ė, and the desired acceleration
  };

  MotionOutcome set_gains(const GainDesignMotion& basis);
  VectorX default_switching_gains(const GainDesignMotion& basis) const;
  VectorX default_task_switching_gains(const GainDesignMotion& basis) const;
  double coordinate_error(CoordinateId c, double difference) const;
  void compute_coupling_map();
  MotionOutcome update_model(double time, const VectorX& position, const VectorX& velocity);
  TrackingErrors actuated_errors(const DesiredState& desired, const VectorX& position, const VectorX& velocity) const;
  TrackingErrors tree_errors(const DesiredState& desired, const dynamics::Transformation& tree) const;
  bool add_acceleration_efforts(const VectorX& actuated);
  bool add_independent_acceleration_efforts(const VectorX& independent);
  MatrixX task_directions();
  TrackingErrors task_errors(const DesiredState& desired) const;
  bool add_task_acceleration_efforts(double time, const VectorX& accelerations);
  bool apply_pd(double time, const DesiredState& desired, const VectorX& position, const VectorX& velocity);
  bool add_generalised_forces(const VectorX& generalised);
  bool distribute(const MatrixX& input, const VectorX& forces);
  bool compensate_gravity(double time, const VectorX& position);
  bool apply_computed_torque(double time, const DesiredState& desired, const VectorX& position,
                             const VectorX& velocity);
  bool apply_sliding_mode(double time, const DesiredState& desired, const VectorX& position, const VectorX& velocity);
  bool apply_extended_sliding_mode(const DesiredState& desired);
  bool apply_open_loop(double time, const DesiredState& desired);
  double switching_function(double s, Eigen::Index layer, double unit) const;
  void saturate_efforts();

  const Mechanism& mechanism_;
  const Controller& controller_;
  const Mechanism* model_mechanism_;
  std::optional<EffortProfile> effort_profile_;  ///< for an open loop, without limits
  dynamics::ForwardDynamics model_;
  std::optional<TaskSpeeds> task_;                                 ///< of a controller with speeds
  double length_;                                                  ///< characteristic [m]
  std::optional<model::ScaledDistribution<double>> distribution_;  ///< of the model's efforts; none: least norm
  VectorX state_, rates_;                                          ///< of the model, per coordinate
  MatrixX coupling_map_;  ///< maps motions of the actuated coordinates to all coordinates coupled to them
  VectorX kp_, kd_, lambda_, k_;
  std::vector<CoordinateId> sliding_;
  std::vector<bool>
      is_assembly_independent_;  ///< per coordinate: its value has the same meaning in every assembly of the mechanism
  VectorX efforts_, saturation_;
  MotionOutcome failure_;
  std::vector<std::string> notes_;
};

}  // namespace balance::control
