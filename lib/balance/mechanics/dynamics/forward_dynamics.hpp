#pragma once
/// Forward dynamics: the equation of motion of any mechanism in independent coordinates, evaluated at one state. Closed
/// loops are solved for at every evaluation, and the independent coordinates are chosen again when the present ones no
/// longer determine the others well. Evaluates the models of controllers as well as the plant on which they act.
///
/// Tree coordinates y, loop closures Φ(y) = 0, J = ∂Φ/∂y; ν are the rates of the independent coordinates, ẏ = C ν with
/// J C = 0, ÿ = C ν̇ + c. Then (P0 eq. 11–19, 29–34) M = Cᵀ H C with H the tree's mass matrix, and
///
///     M(q) ν̇ + bias(q, ν, t) = input(q) u
///
/// with the bias of inertia, weight, springs, loads and friction, and u the actuators' efforts.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <memory>
#include <vector>

namespace balance::dynamics {

struct ForwardOptions {
  /// Regularisation of the Coulomb friction that a controller compensates: it grows smoothly from zero to its full
  /// value over speeds up to this one [rad/s, for slides characteristic lengths per second], as coulomb · x (3 − x²)/2
  /// with x = speed/width; beyond it, it is exactly coulomb · sign(speed). Not negative. A Plant does not smooth.
  double friction_regularisation_speed = 1e-3;
  /// Mechanism coordinates to be used as independent ones, usually the actuated ones, as long as they determine the
  /// others; of more than there are freedoms, those that do so best. If empty, or fewer than freedoms: any coordinates
  /// that determine the others best.
  std::vector<CoordinateId> preferred;

  /// @throws std::invalid_argument if a value is out of range
  void validate() const;
};

/// mass · ν̇ + bias = input · efforts, d freedoms, A actuators. SI.
struct EquationOfMotion {
  MatrixX mass;   ///< d×d, symmetric, positive definite
  VectorX bias;   ///< d: everything that does not depend on ν̇ or the efforts
  MatrixX input;  ///< d×A
};

/// The same before the loops are eliminated, in n tree coordinates: mass · ÿ + bias = input · efforts + jacobianᵀ · λ
/// with jacobian · ÿ + jacobian_bias = 0. Rows of the jacobian that are lengths are divided by the characteristic
/// length.
struct TreeEquation {
  MatrixX mass;           ///< n×n
  VectorX bias;           ///< n
  MatrixX input;          ///< n×A
  MatrixX jacobian;       ///< closure rows × n, redundant ones included
  VectorX jacobian_bias;  ///< closure rows
};

/// Rates and accelerations of coordinates x from the independent ones: ẋ = matrix · ν, ẍ = matrix · ν̇ + bias.
struct Transformation {
  MatrixX matrix;
  VectorX bias;
};

class ForwardDynamics {
 public:
  /// @param mechanism must outlive this object
  /// @throws std::invalid_argument for options out of range
  explicit ForwardDynamics(const Mechanism& mechanism, const ForwardOptions& options = {});
  ~ForwardDynamics();
  ForwardDynamics(ForwardDynamics&&) noexcept;
  ForwardDynamics& operator=(ForwardDynamics&&) noexcept;

  /// Sets joint coordinates and rates. Chooses the independent ones, which are kept as given; all others are moved
  /// until they satisfy the closures. The first call also determines the degrees of freedom.
  /// @param position, velocity per mechanism coordinate (those of cut joints do not matter)
  /// @return done; not_assembled if the loops do not close there; constraint_singularity
  MotionOutcome set_state(double time, const VectorX& position, const VectorX& velocity);

  /// Moves to a state near the last one, with the same independent coordinates: quicker than set_state().
  /// @param position, rate per independent coordinate
  /// @return false if the others cannot follow; set_state() must be the next call then
  bool move_to(double time, const VectorX& position, const VectorX& rate);

  int freedoms() const;  ///< d; −1 before the first successful set_state()
  /// The mechanism coordinates whose rates are ν, one per freedom. Chosen again only by set_state(). The coordinate of
  /// a spherical joint that is not driven is an angle from a reference orientation that the program chooses.
  const std::vector<CoordinateId>& independent() const;
  /// The coordinates of TreeEquation and tree_transformation(), in the same sense. Constant.
  const std::vector<CoordinateId>& tree() const;

  // At the state last set:
  const VectorX& position() const;  ///< per mechanism coordinate, loops closed; angles of cut joints in (−π, π]
  const VectorX& velocity() const;
  VectorX rates() const;  ///< ν

  EquationOfMotion equation();
  TreeEquation tree_equation();
  /// From ν to all mechanism coordinates, cut ones included (rows in the mechanism's order).
  Transformation transformation();
  Transformation tree_transformation();
  /// q̈ of all mechanism coordinates under these efforts (one per actuator).
  VectorX acceleration(const VectorX& efforts);

  class Implementation;  ///< planar or spatial; internal

 private:
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace balance::dynamics
