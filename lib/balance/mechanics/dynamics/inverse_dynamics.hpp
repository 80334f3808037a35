#pragma once
/// Inverse dynamics at single states: actuator efforts and ground wrench for given coordinates, rates and
/// accelerations. For callers with states of their own instead of a trajectory.
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

namespace balance::dynamics {

struct InverseOptions {
  /// Names of the coordinates that a state is given in, as many as the mechanism has degrees of freedom. Empty: the
  /// actuated ones if they are that many and determine all others; otherwise an automatic choice, actuated ones first,
  /// which independent() and notes() report.
  std::vector<std::string> independent;
  Vector3 about = Vector3::Zero();  ///< world point about which moments are taken [m]
  /// Typical duration of the motions to which the states belong [s], positive: dry friction is zero at rates below
  /// 1e-11 rad (or characteristic lengths) in this time.
  double time_scale = 1;
};

/// A rough value of a coordinate, by its name [rad or m].
struct CoordinateGuess {
  std::string coordinate;
  double value = 0;
};

/// A result and its outcome: `value` is valid only if the outcome is done, unless stated otherwise. MotionStatus says
/// why a state is impossible: not_assembled, unreachable (the loops do not close with these coordinates),
/// drive_singularity (the independent coordinates do not determine the others there), constraint_singularity,
/// actuation_singularity (the actuators do not hold the mechanism), assembly_jump, mismatch (fewer actuators than
/// degrees of freedom), overflow.
template <class T>
struct Expected {
  MotionOutcome outcome;
  T value;

  explicit operator bool() const { return outcome.status == MotionStatus::done; }
};

/// Efforts and shaking as matrices times the inertial parameters π of all mass elements: effort = Y π +
/// constant_effort. The matrices of the shaking are valid even if the efforts cannot be determined (mismatch,
/// actuation_singularity).
struct EffortRegressor {
  std::vector<Parameter> parameters;  ///< P: one per column, see list_parameters
  VectorX values;                     ///< P: π of the mechanism [SI]
  MatrixX effort;                     ///< actuators × P
  MatrixX shaking_force;              ///< axes × P, world axes: rate of the linear momentum
  MatrixX shaking_moment;   ///< 1 (planar, about z) or 3 × P: rate of the angular momentum about InverseOptions::about
  VectorX constant_effort;  ///< per actuator: due to springs, loads and friction [N m or N]
};

/// A row of an array without a result.
struct FailedRow {
  Eigen::Index row = 0;
  MotionOutcome outcome;
};

/// Results for an array of states. Rows without a result are NaN and listed in `failures`.
struct EffortBatch {
  Samples efforts;  ///< N × actuators [N m or N]
  std::vector<FailedRow> failures;
};
struct SampleBatch {
  RunResult result;  ///< every quantity, row k for state k; without metrics
  std::vector<FailedRow> failures;
};

/// Inverse dynamics of a mechanism, planar or spatial, with or without loops. A state is the n = degrees_of_freedom()
/// independent coordinates with their rates and accelerations, in SI units.
///
/// Mechanisms with loops have several assembly modes. The first state is assembled near Mechanism::assembly (or see
/// assemble()); from then on every state is reached along the straight line from the previous one, which preserves the
/// mode. If a singularity lies on that line, the outcome says so, and the previous state remains the starting point.
///
/// Not thread-safe: use one object per thread. Movable, not copyable. Wrong sizes and non-finite numbers throw
/// std::invalid_argument.
class InverseDynamics {
 public:
  /// @throws std::invalid_argument if the mechanism is invalid (validate), its loops cannot be closed, the options name
  ///        coordinates that do not exist or do not determine the motion, rates are constrained, or a payload is
  ///        temporary
  explicit InverseDynamics(const Mechanism& mechanism, const InverseOptions& options = {});
  ~InverseDynamics();
  InverseDynamics(InverseDynamics&&) noexcept;
  InverseDynamics& operator=(InverseDynamics&&) noexcept;

  const Mechanism& mechanism() const;
  int degrees_of_freedom() const;
  /// Names of the independent coordinates, in the order of a state's entries.
  const std::vector<std::string>& independent() const;
  std::vector<std::string> actuators() const;
  /// Notes for the user: coordinates chosen automatically, efforts or reactions of minimum norm, locked passive
  /// freedoms.
  const std::vector<std::string>& notes() const;

  /// Finds the configuration that closes the loops with these independent coordinates, in the assembly mode nearest to
  /// `near`, which overrides the mechanism's own `assembly` for the coordinates that it names. Later states start from
  /// it.
  /// @return all coordinates of the mechanism, angles of loop joints in (−π, π]
  Expected<VectorX> assemble(const VectorX& q, const std::vector<CoordinateGuess>& near = {});

  /// Evaluates all quantities of one state. If the efforts cannot be determined (mismatch, actuation_singularity), the
  /// quantities that depend on them are NaN, the others valid.
  /// @param time for time-dependent loads [s]
  Expected<Sample> at(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time = 0);

  /// Computes only the efforts, at minimum cost. Does not allocate unless the state has no result.
  /// @param effort per actuator [N m or N]; meaningless without a result
  MotionOutcome efforts(const VectorX& q, const VectorX& dq, const VectorX& ddq, VectorX& effort, double time = 0);

  /// The same for N states, one per row. Row-major matrices (Samples) are used in place, others are copied.
  /// @param time per state; empty: 0 for all
  EffortBatch effort_rows(const Eigen::Ref<const Samples>& q, const Eigen::Ref<const Samples>& dq,
                          const Eigen::Ref<const Samples>& ddq, const VectorX& time = {});
  SampleBatch at_rows(const Eigen::Ref<const Samples>& q, const Eigen::Ref<const Samples>& dq,
                      const Eigen::Ref<const Samples>& ddq, const VectorX& time = {});

  /// M of M(q) q̈ + h(q, q̇) = Sᵀ u in the independent coordinates: n×n, symmetric. Kinetic energy is ½ q̇ᵀ M q̇.
  Expected<MatrixX> mass_matrix(const VectorX& q);
  /// h: velocity terms, weight, springs, loads, friction; generalised forces along the independent coordinates [N m or
  /// N].
  Expected<VectorX> bias(const VectorX& q, const VectorX& dq, double time = 0);
  Expected<EffortRegressor> regressor(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time = 0);

  class Implementation;
  /// For other rooms of the library.
  const Implementation& implementation() const { return *engine_; }

 private:
  std::unique_ptr<Implementation> engine_;
};

}  // namespace balance::dynamics

namespace balance {

using dynamics::EffortBatch;
using dynamics::Expected;
using dynamics::InverseDynamics;
using dynamics::InverseOptions;
using dynamics::SampleBatch;

}  // namespace balance
