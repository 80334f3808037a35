#pragma once
/// A planar mechanism in natural coordinates: its unknowns, its constraints and its constant mass matrix.
///
/// Unknowns are the basic points, the angles of bodies whose rotation is counted by something (a motor, a gear, a disc,
/// friction, a prescribed angle) and the slides that are. All internal numbers have the characteristic length as unit of
/// length, kg and s otherwise.

#include "balance/synthesis/verification/natural_points.hpp"

#include <string>
#include <vector>

namespace balance::natural {

// A body's inertia distributed over points of it: kinetic energy ½ żᴴ M ż with M constant, re-derived from M = ∫ Nᴴ N dm
// (P3 eq. 1–14 have misprints).

/// About the origin of the body's frame.
struct NaturalInertia {
  double mass = 0;
  Complex first_moment;      ///< ∫ r dm
  double second_moment = 0;  ///< ∫ |r|² dm

  NaturalInertia& operator+=(const NaturalInertia& other);
};

/// Weights of two points for a place of the body: r ↦ (1 − κ) A + κ B with κ = (r − a) / (b − a). A similarity: exact for any
/// planar body, whose inertia M carries whole. The 2×2 complex matrix is P3 eq. 1–5 (2×2 real blocks [Re −Im; Im Re]).
/// @param a, b places of the points, different
Eigen::Matrix2cd two_point_mass(const NaturalInertia& inertia, Complex a, Complex b);

/// ∫ [1 x y]ᵀ [1 x y] dm: what an affine distribution needs. A rigid motion shows only Sxx + Syy, so any body with the given
/// trace is as good as the real one: this one has the same second moments about every axis through its centre of mass.
Matrix3 isotropic_moments(const NaturalInertia& inertia);

/// Weights linear in x and y that are one at their own point and zero at the others (barycentric); M is the real 3×3 matrix
/// whose entries multiply 2×2 identities, P3 eq. 6–14 as corrected.
/// @param a, b, c corners of a triangle
Matrix3 three_point_mass(const Matrix3& moments, Complex a, Complex b, Complex c);

/// Where a run starts: every joint coordinate with its whole turns [rad or m], and the tool's angle with its [rad].
struct InitialCoordinates {
  std::vector<double> coordinates;
  double tool_angle = 0;
};

/// A body's frame as forms of the basic points.
struct BodyModel {
  AffineForm origin, direction;  ///< direction: of the body's x axis, of length one
  int angle = -1;                ///< scalar, −1: nobody counts it, or the ground

  AffineForm place(Complex r) const { return origin + r * direction; }
};

/// Σ coefficient · scalar + constant.
struct ScalarAffineForm {
  std::vector<ScalarTerm> terms;
  double constant = 0;

  double at(const std::vector<double>& scalars) const;
  double rate(const std::vector<double>& rates) const;
};

/// A joint coordinate in SI: linear in the scalars where they have it; else read off the bodies' directions or places.
struct JointCoordinate {
  bool angle = true;
  bool linear = false;
  ScalarAffineForm form;      ///< if linear
  int first = 0, second = 0;  ///< an angle's bodies
  double offset = 0;          ///< angle = angle of the second body − that of the first − offset
  ConstraintRow slide;        ///< a slide's length in units of length, less nothing
};

/// An inertia J [kg length²] that turns with the rate of a scalar form.
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
  std::vector<MassEntry> mass;   ///< of all points, fixed ones included: Hermitian
  std::vector<Rotor> rotors;     ///< discs
  double total_mass = 0;         ///< of everything that moves; discs turn on the ground, too
  Complex ground_disc_moment;    ///< mass times place of the discs on the ground
  double tool_angle_offset = 0;  ///< tool's angle = angle of its body − this
  NaturalCoordinates start;      ///< as the caller's joint coordinates place the bodies

  int unknowns() const { return 2 * basic.moving + scalars; }
  double length() const { return basic.length; }
};

/// @param needed coordinates that must be scalars, besides those of couplings, actuators, friction and discs
/// @param tool_angle the tool's angle must be one
NaturalModel build_model(const Mechanism& mechanism, const std::vector<CoordinateId>& needed, bool tool_angle,
                         const InitialCoordinates& start);

/// Mass matrix and rotors. Called by build_model.
void add_masses(const Mechanism& mechanism, NaturalModel& model);

/// Place and angle of every body when the joints have these coordinates, by walking from joint to joint.
struct BodyPose {
  Complex origin;
  double angle = 0;
};
std::vector<BodyPose> compute_body_poses(const Mechanism& mechanism, const std::vector<double>& coordinates,
                                         double length);

/// First coordinate of a joint.
CoordinateId first_coordinate(const Mechanism& mechanism, JointId joint);

/// The angle that the joint's second body has in the first one's axes at coordinate zero.
double compute_zero_angle(const Joint& joint);

}  // namespace balance::natural
