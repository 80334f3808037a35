#pragma once
/// The equation of motion at single configurations as the matrices that the papers print: in independent coordinates, before the
/// loops are eliminated, and every effort as a sum of its parts.
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

namespace balance {

/// Generalised forces that do not depend on rates, per coordinate [N m or N]: what it takes to hold the mechanism at rest.
struct StaticTerms {
  VectorX weight, springs, loads;

  VectorX sum() const { return weight + springs + loads; }
};

/// Σ u = M′ q̈ + w′ + z′ with w′_k = Σ D′_krs q̇_r q̇_s + Σ B′_kr q̇_r in the d independent coordinates. Dry friction, which no power of
/// the rates describes, is in EffortBreakdown alone.
/// Source: P0 eq. 62, 63; P1 eq. 14–16, where D′_kr is D_kr, D′_krs is D_krs and z′_k is D_k.
struct IndependentTerms {
  MatrixX mass;                   ///< d×d: M′, symmetric
  std::vector<MatrixX> velocity;  ///< per coordinate k: D′_krs, d×d, symmetric in r and s
  MatrixX viscous;                ///< d×d: B′, of viscous friction
  StaticTerms static_terms;       ///< z′ is their sum
  MatrixX input;  ///< d×actuators: generalised forces per unit effort; the identity where they are the coordinates
};

/// The same before the loops are eliminated, in the n coordinates of the tree: Cᵀ (M ÿ + w + z) = Cᵀ S u with A ẏ = 0 and ẏ = C q̇.
/// Source: P0 eq. 16–34, 51 as corrected.
struct RedundantTerms {
  MatrixX mass;                   ///< n×n
  std::vector<MatrixX> velocity;  ///< per coordinate: D, n×n, symmetric
  MatrixX viscous;                ///< n×n
  StaticTerms rest;
  MatrixX input;           ///< n×actuators: S
  MatrixX constraints;     ///< closure rows × n: A, redundant rows included
  MatrixX transformation;  ///< n×d: C, whose rows of the independent coordinates are the identity; A C = 0
  /// Per tree coordinate c_rs, d×d, symmetric: ÿ = C q̈ + Σ c_rs q̇_r q̇_s, so that A ÿ + b = 0 with b = −A c (P1 eq. 12: Ċ q̇).
  std::vector<MatrixX> acceleration;
};

/// The same in s speeds of the user's choice instead of the rates of coordinates, with p constraints on rates that need not be integrable
/// (rolling): M σ̇ + w + z = Σ u. Work on what is zero is done by the constraints alone, whose forces `held` gives in the same way:
/// λ = M σ̇ + w + z − input · u. Source: P0 eq. 1, 14, 17 (Kane's and Boltzmann and Hamel's equations).
struct SpeedTerms {
  MatrixX rows;   ///< (s + p)×d: speeds, below them what is zero, per rate of the independent coordinates
  MatrixX rates;  ///< d×s: rates of the independent coordinates per speed, nothing else moving
  IndependentTerms speed_equations;       ///< s rows; velocity terms are forms in the speeds
  IndependentTerms constraint_equations;  ///< p rows of the same, in the same s speeds
};

/// What an effort is made of.
enum class EffortPart { inertia, velocity, friction, weight, spring, load };
inline constexpr std::array effort_part_names{"inertia", "velocity", "friction", "weight", "spring", "load"};

/// Inertia: of the independent coordinates' accelerations. Velocity: the rest of what rates do to masses.
struct EffortBreakdown {
  MatrixX parts;   ///< actuators × parts [N m or N]
  VectorX effort;  ///< per actuator: their sum, found by itself
};

/// Of a mechanism, planar or in space, with or without loops. States, assembly modes, failures and threads as of InverseDynamics.
class EquationTerms {
 public:
  /// @throws std::invalid_argument as InverseDynamics
  explicit EquationTerms(const Mechanism& mechanism, const InverseOptions& options = {});
  ~EquationTerms();
  EquationTerms(EquationTerms&&) noexcept;
  EquationTerms& operator=(EquationTerms&&) noexcept;

  const Mechanism& mechanism() const;
  int degrees_of_freedom() const;
  /// Indices of the mechanism's coordinates that are the independent ones, in the order of a state's numbers.
  const std::vector<CoordinateId>& independent() const;
  /// Names of the tree's coordinates: of the joint coordinate that moves with each at the same rate.
  const std::vector<std::string>& redundant() const;
  /// Per tree coordinate: whether it is a length.
  std::vector<bool> redundant_lengths() const;
  /// Per row of RedundantTerms::constraints: the joint that it closes.
  const std::vector<std::string>& closures() const;
  const std::vector<std::string>& notes() const;

  /// As InverseDynamics::assemble.
  /// @return all coordinates of the mechanism
  Expected<VectorX> assemble(const VectorX& q, const std::vector<CoordinateValue>& near = {});
  /// @param time of loads that change with it [s]
  Expected<IndependentTerms> independent_terms(const VectorX& q, double time = 0);
  Expected<RedundantTerms> redundant_terms(const VectorX& q, double time = 0);
  /// @throws std::invalid_argument if speeds and zeros together are not as many as degrees of freedom, or name a tool that is not there or
  ///         the coordinate of a joint that closes a loop
  /// @return no answer (drive_singularity) where they do not determine the rates
  Expected<SpeedTerms> speed_terms(const VectorX& q, const SpeedChoice& choice, double time = 0);
  /// No answer where the actuators do not hold the mechanism (actuation_singularity) or are too few (mismatch).
  Expected<EffortBreakdown> split_efforts(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time = 0);

  class Implementation;

 private:
  std::unique_ptr<Implementation> engine_;
};

}  // namespace balance
