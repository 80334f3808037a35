#pragma once
/// The equation of motion at one state as matrices, along the independent coordinates q of a mechanism with or without
/// loops: what can be measured is linear in masses, friction and efforts.
///
///     Y(q, q̇, q̈) π + known(q) + Jᵀ f = B u
///
/// π are the inertial parameters of all mass elements, f the friction in the joint coordinates s with ṡ = J q̇, u the
/// efforts of the actuators.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <memory>
#include <string>
#include <vector>

namespace balance::identification {

struct MotionEquation {
  MatrixX inertial;       ///< n × P: Y, in the order of dynamics::list_parameters without springs
  VectorX known;          ///< n: generalised forces of springs and loads [N m or N]
  MatrixX input;          ///< n × actuators: B
  MatrixX rate_map;       ///< coordinates × n: J; rows of joints that are cut and not linear are zero
  VectorX rates;          ///< per coordinate of the mechanism: ṡ [rad/s or m/s]
  VectorX accelerations;  ///< per coordinate of the mechanism: s̈
  /// Force and moment (about the world's origin) on the frame: axes and 1 or 3 rows × P, world axes, weight included.
  MatrixX frame;
  VectorX known_frame;  ///< the same of loads; springs act between frame and bodies
  MatrixX shaking;      ///< as `frame`, without weight: what the motion alone exerts on the frame
};

/// Moves a mechanism from state to state. Its assembly mode is kept, as by InverseDynamics.
class MotionEquations {
 public:
  /// @param mechanism its friction entries are not evaluated: they say which coordinates `rate_map` needs
  /// @param independent names of the coordinates that states are given in; empty: as InverseOptions::independent
  /// @throws std::invalid_argument if the loops cannot be closed, these coordinates do not determine the motion, or
  ///         rates are constrained
  explicit MotionEquations(const Mechanism& mechanism, const std::vector<std::string>& independent = {});
  ~MotionEquations();
  MotionEquations(MotionEquations&&) noexcept;
  MotionEquations& operator=(MotionEquations&&) noexcept;

  const Mechanism& mechanism() const;
  int degrees_of_freedom() const;
  /// Coordinates in the order of a state's entries.
  const std::vector<CoordinateId>& independent() const;
  /// P: inertial parameters of the mechanism's elements [SI].
  const VectorX& inertial_values() const;
  /// Rows of MotionEquation::frame: 3 in the plane (fx, fy, m), 6 in space (fx, fy, fz, mx, my, mz).
  int frame_rows() const;

  /// @param q,dq,ddq n independent coordinates, their rates and accelerations [SI] @param time of loads [s]
  /// @return why the state is impossible, unless done; then `equation` is unchanged
  MotionOutcome evaluate(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time,
                         MotionEquation& equation);

  /// Whether equations that close loops are solved at every state.
  bool has_loops() const;
  /// At the state last evaluated: smallest singular value of the scaled equations that close the loops, as in results;
  /// 1 without loops.
  double mobility();
  /// At that state: all coordinates of the mechanism; angles that are not tree coordinates in (−π, π] [rad or m].
  VectorX coordinates() const;

  class Implementation;

 private:
  std::unique_ptr<Implementation> engine_;
};

}  // namespace balance::identification
