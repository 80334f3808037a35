#pragma once
/// A planar mechanism in symbols, for natural coordinates: which points define which body, and where they are.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/synthesis/formulas/ring_vectors.hpp"
#include "balance/synthesis/formulas/symbolic_polynomial.hpp"

#include <string>
#include <vector>

namespace balance::formulas {

/// Points of a body in its own axes. The first two are its base; the first three may be a triangle that carries the
/// mass.
struct BasicBody {
  std::vector<int> points;
  std::vector<RingVector3<Polynomial>> positions;
  bool is_triangle = false;
  RigidBodyInertia<Polynomial> mass;  ///< of everything fixed to the body, about its origin
};

/// A joint that is more than a point shared by two bodies.
struct BasicJoint {
  JointType type = JointType::prismatic;
  int first = 0, second = 0;
  RingVector3<Polynomial> p, q;      ///< P on the first body, Q on the second
  RingVector3<Polynomial> axis;      ///< direction of sliding, in the first body's axes
  RingVector3<Polynomial> rotation;  ///< cos, sin of the second body's rotation relative to the first one's axes
};

struct BasicPointModel {
  int moving = 0;                              ///< number of moving points; the ground's points follow
  std::vector<std::string> names;              ///< per point: "crank1.B"
  std::vector<RingVector3<Polynomial>> fixed;  ///< positions of the ground's points
  std::vector<BasicBody> bodies;               ///< the ground's is empty
  std::vector<BasicJoint> joints;
  int length_symbol = -1;  ///< symbol of the characteristic length; −1 unless an auxiliary point needs one
};

class MechanismSymbols;
class ParametricModel;

/// Uses the points of the second formulation.
/// @param mechanism planar
/// @throws FormulaError if it is not
BasicPointModel build_basic_point_model(Ring& ring, const Mechanism& mechanism, const ParametricModel& model,
                                        MechanismSymbols& symbols);

}  // namespace balance::formulas
