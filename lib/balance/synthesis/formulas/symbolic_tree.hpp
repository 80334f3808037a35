#pragma once
/// A mechanism for the recursions over any ring: a tree of frames, each of which rotates about or slides along a
/// coordinate axis, numbers as polynomials of symbols, and the loop closures.

#include "balance/foundation/expression/expression_evaluation.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/model/mechanism_conversion.hpp"
#include "balance/motion/study/spec_expressions.hpp"
#include "balance/synthesis/formulas/basic_point_model.hpp"
#include "balance/synthesis/formulas/ring_vectors.hpp"
#include "balance/synthesis/formulas/symbolic_polynomial.hpp"

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::formulas {

// A mechanism's numbers as expressions over the numbers that can be changed in its spec: parameters and free numbers.

using Vector3E = Vector3Of<Expression>;
using Matrix3E = Matrix3Of<Expression>;

bool is_constant(const Vector3E& v);
bool is_constant(const Matrix3E& m);
Vector3 to_values(const Vector3E& v);
Matrix3 to_values(const Matrix3E& m);

/// With all payloads at all times: formulas have those that come and go, too.
Mechanism attach_payloads(const Mechanism& mechanism);

/// Symbols hold expressions over its graph, so it can be neither copied nor moved.
class ParametricModel {
 public:
  ParametricModel(const Mechanism& mechanism, const study::SpecNumberTexts& texts);
  ParametricModel(const ParametricModel&) = delete;
  ParametricModel& operator=(const ParametricModel&) = delete;

  const MechanismOf<Expression>& mechanism() const { return mechanism_; }
  const std::vector<study::NamedExpression>& parameters() const { return parameters_; }
  /// The spec's values in the spec's units: parameters that are not expressions, and free numbers.
  const std::vector<double>& inputs() const { return inputs_; }

  /// The value of every node at other inputs.
  std::vector<double> evaluate_nodes(const std::vector<double>& inputs) const;
  static double node_value(const Expression& x, const std::vector<double>& nodes) {
    return x.is_constant() ? x.value() : nodes[static_cast<std::size_t>(x.node())];
  }
  /// With all payloads at all times.
  Mechanism build_mechanism(const std::vector<double>& nodes) const;

  /// The value with every input perturbed. Numbers that agree both here and at the spec's values are identical.
  double perturbed_value(const Expression& x) const;
  /// The input that an expression is, up to its sign.
  struct SignedInput {
    int index = -1;  ///< −1: it is none
    int sign = 1;
  };
  SignedInput input_of(const Expression& x) const;
  bool is_zero(const Expression& x) const { return x.value() == 0 && perturbed_value(x) == 0; }
  bool are_equal(const Vector3E& a, const Vector3E& b) const;

 private:
  expression::ExpressionGraph graph_;
  MechanismOf<Expression> mechanism_;
  std::vector<study::NamedExpression> parameters_;
  std::vector<double> inputs_, perturbed_inputs_;
  mutable std::vector<double> perturbed_nodes_;  ///< of the nodes so far
};

class MechanismSymbols;

using Vector = RingVector3<Polynomial>;
using Mass = RigidBodyInertia<Polynomial>;

/// An angle or a slide between two frames as a function of independent coordinates: x = Σ ratio · y[column] + constant.
struct JointVariable {
  bool is_angle = true;
  int index = 0;  ///< of the ring's angle or symbol
  std::vector<std::pair<int, Polynomial>> follows;
  Polynomial offset;  ///< the constant [rad or m]
};

/// A frame on its parent: at `offset` in the parent's axes, it slides along or rotates about one axis.
struct SymbolicFrame {
  int parent = -1;
  Vector offset;
  int axis = 0;
  int sign = 1;       ///< −1: against the axis
  int angle = -1;     ///< in the ring; −1: it does not rotate by an angle
  int slide = -1;     ///< symbol in the ring; −1: it does not slide
  int variable = -1;  ///< −1: it does not move
  /// A rotation by right angles: axis k of the frame is axis `axes[k]` of the parent, times `signs[k]`.
  std::array<int, 3> axes{0, 1, 2}, signs{1, 1, 1};
  Mass mass;  ///< of everything fixed to it, about its origin, in its axes
};

/// A point on a frame, with axes parallel to the frame's.
struct FramePoint {
  int frame = 0;
  Vector at;
};

/// A joint that closes a loop.
struct LoopClosure {
  std::string joint;
  JointType type = JointType::revolute;
  FramePoint a, b;  ///< on the first and the second body
};

struct LinearSpring {
  FramePoint a, b;
  Polynomial stiffness, free_length;
  int length = -1;  ///< symbol of its length; −1 for zero free length, which does not need it
};

/// A joint spring: it drives the variable with preload − stiffness · symbol.
struct JointSpring {
  int variable = 0;
  int symbol = 0;  ///< in the ring, of the coordinate
  Polynomial stiffness, preload;
};

/// The angle of a joint that closes a loop: Σ multiple · angles of the tree.
struct AngleRelation {
  int angle = 0;
  std::map<int, int> multiples;
};

/// A disc's frame, whose axes are the carrier's, turned by the disc's angle.
struct DiscFrame {
  std::string name;
  int frame = 0;
  int variable = 0;  ///< the angle
};

struct SymbolicTree {
  std::shared_ptr<const ParametricModel> model;  ///< source of its symbols' values
  std::shared_ptr<MechanismSymbols> numbers;     ///< the mechanism's numbers; refers to the texts of the spec's numbers
  bool is_planar = true;
  std::vector<SymbolicFrame> frames;  ///< frame 0 is the world; parents come first
  std::vector<FramePoint> bodies;     ///< per body of the mechanism: its origin, on a frame with the body's axes
  std::vector<JointVariable> variables;
  std::vector<std::string> columns;      ///< names of the tree's independent coordinates in formulas
  std::vector<int> coordinates;          ///< per column: coordinate of the mechanism
  std::vector<int> coordinate_variable;  ///< per coordinate of the mechanism; −1 if its joint closes a loop
  std::vector<LoopClosure> closures;
  std::vector<DiscFrame> discs;
  std::vector<LinearSpring> springs;
  std::vector<JointSpring> joint_springs;
  Vector gravity;
  std::vector<int> inertial;                ///< symbols of inertial parameters; empty unless they are about_origin
  std::vector<std::string> excluded_terms;  ///< not contained in z: "friction", "loads"
  std::vector<AngleRelation> relations;
  std::optional<BasicPointModel> basic_points;  ///< if natural coordinates are requested

  bool has_springs() const { return !springs.empty() || !joint_springs.empty(); }
};

enum class InertialParametrisation {
  about_com,     ///< m, lg, J about the centre of mass
  about_origin,  ///< m, mx, my, J about the body's origin: torques are linear in them
};

/// How parameters that are expressions of others appear: as symbols, or as their expressions. Ratios stay symbols.
enum class ParameterExpressions { symbols, inlined };

struct TreeOptions {
  InertialParametrisation inertial = InertialParametrisation::about_com;
  ParameterExpressions expressions = ParameterExpressions::symbols;
  bool natural = false;                   ///< also build points and bodies for natural coordinates
  std::vector<CoordinateId> needed = {};  ///< must not close loops
  std::set<std::string> inlined = {};     ///< parameters that are inlined in any case, in ratios, too
};

/// @throws FormulaError for a name that is no coordinate
std::vector<CoordinateId> find_coordinates(const Mechanism& mechanism, const std::vector<std::string>& names);

/// Names of the mechanism's coordinates that columns are. @param columns any integers
template <class Columns>
std::vector<std::string> coordinate_names(const Mechanism& mechanism, const SymbolicTree& tree,
                                          const Columns& columns) {
  std::vector<std::string> names;
  for (const auto column : columns) {
    const int coordinate = tree.coordinates[static_cast<std::size_t>(column)];
    names.push_back(mechanism.coordinates[static_cast<std::size_t>(coordinate)].name);
  }
  return names;
}
/// Of all columns.
std::vector<std::string> coordinate_names(const Mechanism& mechanism, const SymbolicTree& tree);

/// @param mechanism must be valid
/// @param texts of the spec's numbers: parameters become symbols under their names
/// @throws FormulaError for anything that has no formula
SymbolicTree build_symbolic_tree(Ring& ring, const Mechanism& mechanism, const study::SpecNumberTexts& texts,
                                 const TreeOptions& options = {});

}  // namespace balance::formulas
