#pragma once
/// The equation of motion at single configurations as the matrices of the papers: in independent coordinates, before
/// the loops are eliminated, and with every effort as a sum of its parts.
///
///     balance::EquationTerms terms(mechanism);
///     const auto found = terms.independent_terms(q);
///     if (found) use(found.value.mass);

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace balance::dynamics {

/// Generalised forces that do not depend on rates, per coordinate [N m or N]: those that hold the mechanism at rest.
struct StaticTerms {
  VectorX weight, springs, loads;
  VectorX prescribed = {};  ///< of motion that constraints on speeds with a value cause; empty: there are none

  VectorX sum() const {
    const VectorX at_rest = weight + springs + loads;
    return prescribed.size() > 0 ? VectorX(at_rest + prescribed) : at_rest;
  }
};

/// Σ u = M′ q̈ + w′ + z′ with w′_k = Σ D′_krs q̇_r q̇_s + Σ B′_kr q̇_r in the d independent coordinates. Dry friction,
/// which is not polynomial in the rates, appears only in EffortBreakdown.
/// Source: P0 eq. 62, 63; P1 eq. 14–16, where D′_kr is D_kr, D′_krs is D_krs and z′_k is D_k.
struct IndependentTerms {
  MatrixX mass;                   ///< d×d: M′, symmetric
  std::vector<MatrixX> velocity;  ///< per coordinate k: D′_krs, d×d, symmetric in r and s
  MatrixX viscous;                ///< d×d: B′, of viscous friction and of constraints on speeds with a value
  StaticTerms static_terms;       ///< z′ is their sum
  MatrixX input;  ///< d×actuators: generalised forces per unit effort; the identity if they are the coordinates
};

/// The same before the loops are eliminated, in the n coordinates of the tree: Cᵀ (M ÿ + w + z) = Cᵀ S u with A ẏ = 0
/// and ẏ = C q̇. Source: P0 eq. 16–34, 51 as corrected.
struct RedundantTerms {
  MatrixX mass;                   ///< n×n
  std::vector<MatrixX> velocity;  ///< per coordinate: D, n×n, symmetric
  MatrixX viscous;                ///< n×n
  StaticTerms rest;
  MatrixX input;           ///< n×actuators: S
  MatrixX constraints;     ///< closure rows × n: A, redundant rows included
  MatrixX transformation;  ///< n×d: C; its rows of the independent coordinates form the identity; A C = 0
  /// Per tree coordinate c_rs, d×d, symmetric: ÿ = C q̈ + Σ c_rs q̇_r q̇_s, so that A ÿ + b = 0 with b = −A c
  /// (P1 eq. 12: Ċ q̇).
  std::vector<MatrixX> acceleration;
  /// disc_rows() × d: rates of the discs' absolute rotations about their own axes per independent rate: the rows that the
  /// discs add to C. Source: P1 eq. 24, 35, 45.
  MatrixX discs;
  // With constraints on speeds that have values: A ẏ = v, ẏ = C q̇ + c₀, ÿ = C q̈ + Σ c_rs q̇_r q̇_s + c₁ q̇ + c₂.
  VectorX constraint_speeds = {};    ///< v, per closure row; empty: zero, and so are the following
  VectorX rate_offset = {};          ///< n: c₀
  MatrixX acceleration_linear = {};  ///< n×d: c₁
  VectorX acceleration_offset = {};  ///< n: c₂
};

/// The same in user-defined speeds (quasi-velocities) instead of the rates of coordinates, with p constraints on rates
/// that need not be integrable (rolling): M σ̇ + w + z = Σ u. Constraint forces do work only on the speeds that are kept
/// at zero; constraint_equations yields them in the same way: λ = M σ̇ + w + z − input · u. Source: P0 eq. 1, 14, 17
/// (Kane's and the Boltzmann–Hamel equations).
///
/// The speeds π may be more than the s = d − p freedoms of the velocity (P0 eq. 68). Then the first s that determine
/// the motion are independent: the equations are in these, and π = C σ + c₀ and π̇ = C σ̇ + Σ c_rs σ_r σ_s + c₁ σ + c₂
/// give all.
struct SpeedTerms {
  MatrixX rows;                  ///< all speeds, then the p constrained ones, per rate of the independent coordinates
  std::vector<int> independent;  ///< s indices of speeds, increasing
  MatrixX rates;  ///< d×s: rates of the independent coordinates per independent speed, others being zero
  IndependentTerms speed_equations;       ///< s rows; velocity terms are quadratic forms in the independent speeds
  IndependentTerms constraint_equations;  ///< p rows of the same, in the same s speeds
  MatrixX transformation;                 ///< speeds × s: C; its rows of the independent speeds form the identity
  std::vector<MatrixX> acceleration;      ///< per speed: c_rs, s×s, symmetric
  // With constraints on speeds that have values; empty: zero.
  VectorX rate_offset = {};          ///< d: rates of the independent coordinates when the independent speeds are zero
  VectorX speed_offset = {};         ///< c₀, per speed
  MatrixX acceleration_linear = {};  ///< c₁, speeds × s
  VectorX acceleration_offset = {};  ///< c₂, per speed
};

/// The parts of an effort.
enum class EffortPart { inertia, velocity, friction, weight, spring, load };
inline constexpr std::array effort_part_names{"inertia", "velocity", "friction", "weight", "spring", "load"};

/// Inertia: due to the accelerations of the independent coordinates. Velocity: the remaining inertia forces, due to
/// rates.
struct EffortBreakdown {
  MatrixX parts;   ///< actuators × parts [N m or N]
  VectorX effort;  ///< per actuator: their sum, computed independently
};

/// Equation of motion of a mechanism, planar or spatial, with or without loops. States, assembly modes, failures and
/// thread safety as for InverseDynamics.
class EquationTerms {
 public:
  /// @throws std::invalid_argument as InverseDynamics
  explicit EquationTerms(const Mechanism& mechanism, const InverseOptions& options = {});
  ~EquationTerms();
  EquationTerms(EquationTerms&&) noexcept;
  EquationTerms& operator=(EquationTerms&&) noexcept;

  const Mechanism& mechanism() const;
  int degrees_of_freedom() const;
  /// Indices of the independent coordinates among the mechanism's, in the order of a state's entries.
  const std::vector<CoordinateId>& independent() const;
  /// Names of the tree's coordinates: that of the joint coordinate that equals each.
  const std::vector<std::string>& redundant() const;
  /// Per tree coordinate: whether it is a length.
  std::vector<bool> redundant_lengths() const;
  /// Per row of RedundantTerms::constraints: the joint that it closes, or the constraint on speeds.
  const std::vector<std::string>& closures() const;
  /// Per row of RedundantTerms::discs, as in model::GeneralisedSpeed: `disc.r` in the plane; `disc.p`, `disc.q`,
  /// `disc.r` in space, along the carrier's axes turned with the disc.
  const std::vector<std::string>& disc_rows() const;
  const std::vector<std::string>& notes() const;

  /// As InverseDynamics::assemble.
  /// @return all coordinates of the mechanism
  Expected<VectorX> assemble(const VectorX& q, const std::vector<CoordinateValue>& near = {});
  /// @param time for time-dependent loads [s]
  Expected<IndependentTerms> independent_terms(const VectorX& q, double time = 0);
  Expected<RedundantTerms> redundant_terms(const VectorX& q, double time = 0);
  /// @throws std::invalid_argument if speeds and constrained speeds together are fewer than the degrees of freedom, or
  ///        the constrained ones not fewer, or they refer to a body that does not exist or to the coordinate of a joint
  ///        that closes a loop
  /// @return drive_singularity if they do not determine the rates
  Expected<SpeedTerms> speed_terms(const VectorX& q, const model::SpeedChoice& choice, double time = 0);
  /// Fails if the actuators do not hold the mechanism (actuation_singularity) or are too few (mismatch).
  Expected<EffortBreakdown> split_efforts(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time = 0);

  class Implementation;

 private:
  std::unique_ptr<Implementation> engine_;
};

}  // namespace balance::dynamics
