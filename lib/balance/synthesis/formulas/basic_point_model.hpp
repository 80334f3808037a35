#pragma once
/// What natural coordinates need of a planar mechanism, with symbols: which points carry which body, and where.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/synthesis/formulas/ring_vectors.hpp"
#include "balance/synthesis/formulas/symbolic_polynomial.hpp"

#include <string>
#include <vector>

namespace balance::formulas {

/// Points of a body in its own axes. The first two are its base; the first three a triangle where that carries the mass.
struct BasicBody {
  std::vector<int> points;
  std::vector<RingVector3<Polynomial>> positions;
  bool is_triangle = false;
  RigidBodyInertia<Polynomial> mass;  ///< of everything fixed to it, about its origin
};

/// A joint that says more than that two bodies share a point.
struct BasicJoint {
  JointType type = JointType::prismatic;
  int first = 0, second = 0;
  RingVector3<Polynomial> p, q;      ///< P on the first body, Q on the second
  RingVector3<Polynomial> axis;      ///< of the slide, in the first body's axes
  RingVector3<Polynomial> rotation;  ///< cos, sin of what the second body is turned by in the first one's axes
};

struct BasicPointModel {
  int moving = 0;                              ///< points 0 … moving − 1; behind them those of the ground
  std::vector<std::string> names;              ///< per point: "crank1.B"
  std::vector<RingVector3<Polynomial>> fixed;  ///< places of the ground's points
  std::vector<BasicBody> bodies;               ///< the ground's is empty
  std::vector<BasicJoint> joints;
  int length_symbol = -1;  ///< symbol of the characteristic length, where an auxiliary point needs one
};

class MechanismSymbols;
class ParametricModel;

/// The points are those of the second formulation. @param mechanism planar
/// @throws FormulaError if it is not
BasicPointModel build_basic_point_model(Ring& ring, const Mechanism& mechanism, const ParametricModel& model,
                                        MechanismSymbols& numbers);

}  // namespace balance::formulas
