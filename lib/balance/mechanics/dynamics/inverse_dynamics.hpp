#pragma once
/// Inverse dynamics at single states: what the actuators must do, and what the frame feels, where a mechanism has these coordinates,
/// rates and accelerations. For callers with states of their own instead of a trajectory.
///
///     balance::InverseDynamics arm(mechanism);
///     const auto found = arm.at(q, dq, ddq);
///     if (found) use(found.value.effort);

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/model/validation.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

#include <memory>
#include <string>
#include <vector>

namespace balance {

struct InverseOptions {
  /// Names of the coordinates that a state is given in, as many as the mechanism has degrees of freedom. Empty: the actuated ones
  /// if they are so many and determine all others; else a choice of ours, actuated ones first, named by independent() and notes().
  std::vector<std::string> independent;
  Vector3 about = Vector3::Zero();  ///< world point that moments are about [m]
  /// Typical duration of the motions that states are taken from [s], positive: dry friction has no sign below 1e-11 rad (or
  /// characteristic lengths) in this time.
  double time_scale = 1;
};

/// A rough value of a coordinate, by its name [rad or m].
struct CoordinateGuess {
  std::string coordinate;
  double value = 0;
};

/// What was asked for, and whether it could be found: `value` means something only where the outcome is done, unless said otherwise.
/// MotionStatus says in which way a state is impossible: not_assembled, unreachable (the loops do not close with these coordinates),
/// drive_singularity (the independent coordinates do not determine the others there), constraint_singularity,
/// actuation_singularity (the actuators do not hold the mechanism), assembly_jump, mismatch (fewer actuators than degrees of
/// freedom), overflow.
template <class T>
struct Expected {
  MotionOutcome outcome;
  T value;

  explicit operator bool() const { return outcome.status == MotionStatus::done; }
};

/// Efforts and shaking as matrices times the inertial parameters π of everything that has mass: effort = Y π + other. Where the efforts
/// cannot be found (mismatch, actuation_singularity) those of the shaking are there all the same.
struct EffortRegressor {
  std::vector<Parameter> parameters;  ///< P: what the columns are, see list_parameters
  VectorX values;                     ///< P: π of the mechanism [SI]
  MatrixX effort;                     ///< actuators × P
  MatrixX shaking_force;              ///< axes × P, world axes: rate of the linear momentum
  MatrixX shaking_moment;   ///< 1 (planar, about z) or 3 × P: rate of the angular momentum about InverseOptions::about
  VectorX constant_effort;  ///< per actuator: what springs, loads and friction ask for [N m or N]
};

/// A row of an array that has no answer.
struct FailedRow {
  Eigen::Index row = 0;
  MotionOutcome outcome;
};

/// Answers to an array of states. Rows that have none are NaN and stand in `failures`.
struct EffortBatch {
  Samples efforts;  ///< N × actuators [N m or N]
  std::vector<FailedRow> failures;
};
struct SampleBatch {
  RunResult result;  ///< every quantity, row k for state k; without metrics
  std::vector<FailedRow> failures;
};

/// Of a mechanism, planar or in space, with or without loops. A state is the n = degrees_of_freedom() independent coordinates with
/// their rates and accelerations, in SI units.
///
/// Mechanisms with loops have several assembly modes. The first state is assembled near Mechanism::assembly (or see assemble());
/// from then on every state is reached on the straight way from the state before, so that the mode stays. Where this way meets a
/// singularity the answer says so, and the state before stays the one to go on from.
///
/// One thread at a time may use an object; several threads take one each. Movable, not copyable. Sizes that do not fit and numbers
/// that are not finite throw std::invalid_argument.
class InverseDynamics {
 public:
  /// @throws std::invalid_argument if the mechanism has faults (validate), its loops cannot be closed anywhere, or the options ask for
  ///         coordinates that do not exist or do not determine the motion, or a payload is not always there
  explicit InverseDynamics(const Mechanism& mechanism, const InverseOptions& options = {});
  ~InverseDynamics();
  InverseDynamics(InverseDynamics&&) noexcept;
  InverseDynamics& operator=(InverseDynamics&&) noexcept;

  const Mechanism& mechanism() const;
  int degrees_of_freedom() const;
  /// Names of the independent coordinates, in the order of a state's numbers.
  const std::vector<std::string>& independent() const;
  std::vector<std::string> actuators() const;
  /// What a user should know: which coordinates were chosen, efforts or reactions of least norm, spins that are held.
  const std::vector<std::string>& notes() const;

  /// The configuration that closes the loops with these independent coordinates, in the assembly mode nearest to `near`, which takes
  /// the place of the mechanism's own `assembly` for the coordinates that it names. States go on from it.
  /// @return all coordinates of the mechanism, angles of loop joints in (−π, π]
  Expected<VectorX> assemble(const VectorX& q, const std::vector<CoordinateGuess>& near = {});

  /// Everything about one state. Where the efforts cannot be found (mismatch, actuation_singularity) what does not depend on them is
  /// there, the rest NaN.
  /// @param time of loads that change with it [s]
  Expected<Sample> at(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time = 0);

  /// Only the efforts, at the least cost; takes nothing from the heap unless the state has no answer.
  /// @param effort per actuator [N m or N]; means nothing where there is no answer
  MotionOutcome efforts(const VectorX& q, const VectorX& dq, const VectorX& ddq, VectorX& effort, double time = 0);

  /// The same for N states, one a row. Matrices stored by rows (Samples) are taken as they are, others are copied.
  /// @param time per state; empty: 0 for all
  EffortBatch effort_rows(const Eigen::Ref<const Samples>& q, const Eigen::Ref<const Samples>& dq,
                          const Eigen::Ref<const Samples>& ddq, const VectorX& time = {});
  SampleBatch at_rows(const Eigen::Ref<const Samples>& q, const Eigen::Ref<const Samples>& dq,
                      const Eigen::Ref<const Samples>& ddq, const VectorX& time = {});

  /// M of M(q) q̈ + h(q, q̇) = Sᵀ u in the independent coordinates: n×n, symmetric. Kinetic energy is ½ q̇ᵀ M q̇.
  Expected<MatrixX> mass_matrix(const VectorX& q);
  /// h: velocity terms, weight, springs, loads and friction: generalised forces along the independent coordinates [N m or N].
  Expected<VectorX> bias(const VectorX& q, const VectorX& dq, double time = 0);
  Expected<EffortRegressor> regressor(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time = 0);

  class Implementation;
  /// For the library's own rooms.
  const Implementation& implementation() const { return *engine_; }

 private:
  std::unique_ptr<Implementation> engine_;
};

}  // namespace balance
