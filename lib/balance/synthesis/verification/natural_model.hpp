#pragma once
/// A planar mechanism in natural coordinates: its unknowns, its constraints and its constant mass matrix.
///
/// The unknowns are the basic points, the angles of bodies whose rotation is counted (because of a motor, a gear, a
/// disc, friction or a prescribed angle), and counted slides. Internally, the unit of length is the characteristic
/// length; all else is in kg and s.

#include "balance/synthesis/verification/natural_points.hpp"

#include <string>
#include <vector>

namespace balance::verification::natural {

// A body's inertia distributed over its points: kinetic energy ½ żᴴ M ż with constant M, re-derived from M = ∫ Nᴴ N dm
// (P3 eq. 1–14 have misprints).

/// Inertia about the origin of the body's frame.
struct NaturalInertia {
  double mass = 0;
  Complex first_moment;      ///< ∫ r dm
  double second_moment = 0;  ///< ∫ |r|² dm

  NaturalInertia& operator+=(const NaturalInertia& other);
};

/// Mass matrix for two points that interpolate every place of the body: r ↦ (1 − κ) A + κ B with κ = (r − a) / (b − a).
/// This is a similarity, so M is exact for any planar body.
/// Source: P3 eq. 1–5 (2×2 real blocks [Re −Im; Im Re]).
/// @param a, b positions of the points, different
Eigen::Matrix2cd two_point_mass(const NaturalInertia& inertia, Complex a, Complex b);

/// ∫ [1 x y]ᵀ [1 x y] dm, as needed for an affine interpolation. Rigid motions depend on Sxx + Syy alone, so all bodies
/// with this trace are equivalent. The one returned has the same second moments about every axis through its CoM.
Matrix3 isotropic_moments(const NaturalInertia& inertia);

/// Mass matrix for three points whose interpolation weights are linear in x and y, one at their own point and zero at
/// the others (barycentric). M is a real 3×3 matrix whose entries multiply 2×2 identities, P3 eq. 6–14 as corrected.
/// @param a, b, c corners of a triangle
Matrix3 three_point_mass(const Matrix3& moments, Complex a, Complex b, Complex c);

/// Start of a run: every joint coordinate [rad or m] and the tool's angle [rad], including whole turns.
struct InitialCoordinates {
  std::vector<double> coordinates;
  double tool_angle = 0;
};

/// A body's frame as affine forms of the basic points.
struct BodyModel {
  AffineForm origin, direction;  ///< direction: the body's x axis, of unit length
  int angle = -1;                ///< scalar; −1: not counted, or the ground

  AffineForm place(Complex r) const { return origin + r * direction; }
};

/// Σ coefficient · scalar + constant.
struct ScalarAffineForm {
  std::vector<ScalarTerm> terms;
  double constant = 0;

  double at(const std::vector<double>& scalars) const;
  double rate(const std::vector<double>& rates) const;
};

/// A joint coordinate in SI: linear in the scalars if they include it, otherwise computed from directions or places.
struct JointCoordinate {
  bool angle = true;
  bool linear = false;
  ScalarAffineForm form;      ///< if linear
  int first = 0, second = 0;  ///< bodies of an angle
  double offset = 0;          ///< angle = angle of the second body − angle of the first − offset
  ConstraintRow slide;        ///< its value is a slide's length in units of length
};

/// An inertia J [kg length²] that rotates at the rate of a scalar form.
struct Rotor {
  double inertia = 0;
  ScalarAffineForm angle;
};

struct MassEntry {
  int row = 0, column = 0;  ///< points
  Complex value;            ///< [kg]
};

struct NaturalModel {
  BasicPoints basic;
  int scalars = 0;
  std::vector<BodyModel> bodies;
  std::vector<double> body_angles;  ///< at the start [rad]
  std::vector<JointCoordinate> coordinates;
  std::vector<ConstraintRow> constraints;
  std::vector<MassEntry> mass;   ///< of all points, including fixed ones: Hermitian
  std::vector<Rotor> rotors;     ///< discs
  double total_mass = 0;         ///< of everything that moves, including discs on the ground
  Complex ground_disc_moment;    ///< mass times position of the discs on the ground
  double tool_angle_offset = 0;  ///< tool's angle = angle of its body − this
  NaturalCoordinates start;      ///< with the bodies at the caller's joint coordinates

  int unknowns() const { return 2 * basic.moving + scalars; }
  double length() const { return basic.length; }
};

/// @param needed coordinates to be scalars, besides those of couplings, actuators, friction, joint springs and discs
/// @param tool_angle whether the tool's angle must be a scalar
NaturalModel build_model(const Mechanism& mechanism, const std::vector<CoordinateId>& needed, bool tool_angle,
                         const InitialCoordinates& start);

/// Sets the mass matrix and the rotors. Called by build_model.
void add_masses(const Mechanism& mechanism, NaturalModel& model);

/// Position and angle of every body at given joint coordinates, found by walking from joint to joint.
struct BodyPose {
  Complex origin;
  double angle = 0;
};
std::vector<BodyPose> compute_body_poses(const Mechanism& mechanism, const std::vector<double>& coordinates,
                                         double length);

/// First coordinate of a joint.
CoordinateId first_coordinate(const Mechanism& mechanism, JointId joint);

/// The angle of the joint's second body in the first one's axes at coordinate zero.
double compute_zero_angle(const Joint& joint);

}  // namespace balance::verification::natural
