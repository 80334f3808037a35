#pragma once
/// A controller at work: efforts from what it measures, what it should do and what it believes of the mechanism.
/// P0 section 1.3; derivations and what they prove are in docs/control.md.

#include "balance/mechanics/dynamics/forward_dynamics.hpp"
#include "balance/motion/study/controller_spec.hpp"

#include <array>
#include <optional>
#include <vector>

namespace balance {

/// Efforts that are stated over time and act at every moment: cubics from knot to knot, cut by the actuators' limits.
class EffortProfile {
 public:
  /// @param limit largest magnitude per actuator [N m or N]; empty: none
  /// @throws std::invalid_argument for a table without rows, or a spline through fewer than four
  EffortProfile(const EffortTable& table, const VectorX& limit);

  /// @param effort one per actuator [N m or N]
  void evaluate(double time, VectorX& effort) const;
  VectorX evaluate(double time) const;
  /// 1 where the limit cuts, else 0.
  VectorX saturation(double time) const;
  /// Σ |changes| of each effort between two times.
  VectorX total_variation(double from, double to) const;

  /// Where the efforts are not smooth: those of the table, and where limits begin and cease to cut. Increasing [s].
  const std::vector<double>& knots() const { return knots_; }

 private:
  /// c0 + c1 x + c2 x² + c3 x³ in the time x from the piece's start.
  using Cubic = std::array<double, 4>;
  struct Piece {
    double begin, end;
    std::vector<Cubic> efforts;
  };

  void make_pieces(const EffortTable& table);
  void add_saturation_knots();
  const Piece& find_piece(double time) const;
  double evaluate_unsaturated(const Piece& piece, std::size_t actuator, double time) const;
  double saturate(std::size_t actuator, double effort) const;
  static std::vector<double> find_monotone_intervals(const Cubic& cubic, double begin, double end);

  std::vector<Piece> pieces_;
  VectorX effort_limit_;
  std::vector<double> knots_;
};

/// What the mechanism should do at one moment, per coordinate of the mechanism.
struct DesiredState {
  VectorX position, velocity, acceleration;
};

/// What the gains follow from where the controller does not state them.
struct GainDesignMotion {
  VectorX peak_acceleration;        ///< per actuator: largest desired magnitude along the motion
  std::vector<DesiredState> along;  ///< the motion, at some of its moments
};

/// Whether the controller makes efforts of what it wants of the mechanism, which singular configurations do not allow.
bool is_inverse_dynamics_based(const Controller& controller);

/// Whether the controller does anything with a desired motion: free motion and stated efforts do not.
bool needs_desired_motion(const Controller& controller);

class ControlLaw {
 public:
  /// @param truth the mechanism that is controlled; with the controller, it must outlive the law. What the controller believes has
  ///        the same coordinates and actuators
  /// @throws std::invalid_argument if gains and actuators differ in number
  ControlLaw(const Mechanism& truth, const Controller& controller);

  /// Assembles the model where the mechanism starts and settles the gains.
  /// @param position, velocity per coordinate of the mechanism
  /// @return mismatch if this type of controller needs more actuators than there are
  MotionOutcome start(const VectorX& position, const VectorX& velocity, const GainDesignMotion& basis);

  /// @param position, velocity measured, per actuator
  /// @return done, or why the law has no answer at this state: a singular configuration of the model
  MotionOutcome compute_efforts(double time, const DesiredState& desired, const VectorX& position,
                                const VectorX& velocity);

  const VectorX& efforts() const { return efforts_; }      ///< per actuator, limited [N m or N]
  const VectorX& saturation() const { return at_limit_; }  ///< 1 where the limit cut, else 0

  /// The coordinates that have a sliding variable s = −(ė + λ e), and their λ; none for laws without one.
  const std::vector<CoordinateId>& sliding_coordinates() const { return sliding_; }
  const VectorX& sliding_lambda() const { return lambda_; }

  /// What a user should know of the gains.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  struct TrackingErrors {
    VectorX position, rate, acceleration;  ///< e, ė, and the desired second rate
  };

  MotionOutcome set_gains(const GainDesignMotion& basis);
  void compute_coupling_map();
  MotionOutcome update_model(double time, const VectorX& position, const VectorX& velocity);
  TrackingErrors actuated_errors(const DesiredState& desired, const VectorX& position, const VectorX& velocity) const;
  TrackingErrors tree_errors(const DesiredState& desired, const Transformation& tree) const;
  bool add_acceleration_efforts(const VectorX& actuated);
  bool add_generalised_forces(const VectorX& generalised);
  bool compensate_gravity(double time, const VectorX& position);
  bool apply_computed_torque(double time, const DesiredState& desired, const VectorX& position,
                             const VectorX& velocity);
  bool apply_sliding_mode(const DesiredState& desired, const VectorX& position, const VectorX& velocity);
  bool apply_extended_sliding_mode(const DesiredState& desired);
  bool open_loop(double time, const DesiredState& desired);
  double switching(double s, Eigen::Index layer, double unit) const;
  void saturate_efforts();

  const Mechanism& mechanism_;
  const Controller& controller_;
  const Mechanism& model_mechanism_;
  std::optional<EffortProfile> effort_profile_;  ///< of an open loop, without limits
  ForwardDynamics model_;
  double length_;          ///< characteristic [m]
  VectorX state_, rates_;  ///< of the model, per coordinate
  MatrixX coupling_map_;   ///< how all coordinates move with the actuated ones to which belts and gears tie them
  VectorX kp_, kd_, lambda_, k_;
  std::vector<CoordinateId> sliding_;
  std::vector<bool>
      is_assembly_independent_;  ///< per coordinate: its value means the same in every assembly of the mechanism
  VectorX efforts_, at_limit_;
  MotionOutcome failure_;
  std::vector<std::string> notes_;
};

}  // namespace balance
