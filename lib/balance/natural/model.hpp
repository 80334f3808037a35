#pragma once
/// A planar mechanism in natural coordinates: its unknowns, its constraints and its constant mass matrix. Private to natural.
///
/// Unknowns are the basic points, the angles of bodies whose rotation is counted by something (a motor, a gear, a disc,
/// friction, a prescribed angle) and the slides that are. All internal numbers have the characteristic length as unit of
/// length, kg and s otherwise.

#include "balance/natural/basic_points.hpp"
#include "balance/natural/inertia.hpp"

#include <string>
#include <vector>

namespace balance::natural {

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
