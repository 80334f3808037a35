#pragma once
/// A mechanism for the recursions over any ring: a tree of frames that each turn about or slide along a coordinate axis, its
/// numbers polynomials of symbols, and the closures of its loops.

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
#include <string>
#include <utility>
#include <vector>

namespace balance::formulas {

// A mechanism's numbers as expressions over what its spec lets one change: parameters and free numbers.

using Vector3E = Vector3Of<Expression>;
using Matrix3E = Matrix3Of<Expression>;

bool is_constant(const Vector3E& v);
bool is_constant(const Matrix3E& m);
Vector3 to_values(const Vector3E& v);
Matrix3 to_values(const Matrix3E& m);

/// Symbols hold expressions over its graph: neither copied nor moved.
class ParametricModel {
 public:
  ParametricModel(const Mechanism& mechanism, const SpecNumberTexts& texts);
  ParametricModel(const ParametricModel&) = delete;
  ParametricModel& operator=(const ParametricModel&) = delete;

  const MechanismOf<Expression>& mechanism() const { return mechanism_; }
  const std::vector<NamedExpression>& parameters() const { return parameters_; }
  /// As the spec has them, in its units: parameters that are no expressions, and free numbers.
  const std::vector<double>& inputs() const { return inputs_; }

  /// The value of every node where the inputs have other values.
  std::vector<double> evaluate_nodes(const std::vector<double>& inputs) const;
  static double node_value(const Expression& x, const std::vector<double>& nodes) {
    return x.is_constant() ? x.value() : nodes[static_cast<std::size_t>(x.node())];
  }
  Mechanism build_mechanism(const std::vector<double>& nodes) const;

  /// Its value where every input is another number. What is equal here and at the spec's numbers is so for a reason.
  double perturbed_value(const Expression& x) const;
  bool is_zero(const Expression& x) const { return x.value() == 0 && perturbed_value(x) == 0; }
  bool are_equal(const Vector3E& a, const Vector3E& b) const;

 private:
  ExpressionGraph graph_;
  MechanismOf<Expression> mechanism_;
  std::vector<NamedExpression> parameters_;
  std::vector<double> inputs_, perturbed_inputs_;
  mutable std::vector<double> perturbed_nodes_;  ///< per node so far
};

using Vector = RingVector3<Polynomial>;
using Mass = RigidBodyInertia<Polynomial>;

/// An angle or a slide between two frames, and the independent coordinates that it follows: x = Σ ratio · y[column] + constant.
struct JointVariable {
  bool is_angle = true;
  int index = 0;  ///< of the ring's angle or symbol
  std::vector<std::pair<int, Polynomial>> follows;
  Polynomial offset;  ///< the constant [rad or m]
};

/// A frame on its parent. At `offset` in the parent's axes; from there it slides along or turns about one axis.
struct SymbolicFrame {
  int parent = -1;
  Vector offset;
  int axis = 0;
  int sign = 1;       ///< −1: against the axis
  int angle = -1;     ///< of the ring; −1: it does not turn by an angle
  int slide = -1;     ///< symbol of the ring; −1: it does not slide
  int variable = -1;  ///< −1: it does not move
  /// A turn by right angles: axis k of the frame is axis `axes[k]` of the parent, times `signs[k]`.
  std::array<int, 3> axes{0, 1, 2}, signs{1, 1, 1};
  Mass mass;  ///< of everything fixed to it, about its origin, in its axes
};

/// A place on a frame, with axes parallel to it.
struct FramePoint {
  int frame = 0;
  Vector at;
};

/// A joint that closes a loop.
struct LoopClosure {
  std::string joint;
  JointType type = JointType::revolute;
  FramePoint a, b;  ///< first and second body's
};

struct LinearSpring {
  FramePoint a, b;
  Polynomial stiffness, free_length;
  int length = -1;  ///< symbol of its length; −1 where the free length is zero: then nothing needs it
};

/// A spring in a joint: it drives the variable with preload − stiffness · symbol.
struct JointSpring {
  int variable = 0;
  int symbol = 0;  ///< of the ring, for the coordinate
  Polynomial stiffness, preload;
};

/// The angle of a joint that closes a loop: Σ multiple · angles of the tree.
struct AngleRelation {
  int angle = 0;
  std::map<int, int> multiples;
};

struct SymbolicTree {
  std::shared_ptr<const ParametricModel> model;  ///< what its symbols are made of
  bool is_planar = true;
  std::vector<SymbolicFrame> frames;  ///< frame 0 is the world; parents first
  std::vector<JointVariable> variables;
  std::vector<std::string> columns;      ///< names of the independent coordinates of the tree, as formulas write them
  std::vector<int> coordinates;          ///< per column: of the mechanism
  std::vector<int> coordinate_variable;  ///< per coordinate of the mechanism; −1: of a joint that closes a loop
  std::vector<LoopClosure> closures;
  std::vector<LinearSpring> springs;
  std::vector<JointSpring> joint_springs;
  Vector gravity;
  std::vector<int> inertial;  ///< symbols of inertial parameters, where the tree has them for each element
  std::vector<std::string> excluded_terms;  ///< what z does not contain: "friction", "loads"
  std::vector<AngleRelation> relations;
  std::optional<BasicPointModel> basic_points;  ///< where natural coordinates are wanted

  bool has_springs() const { return !springs.empty() || !joint_springs.empty(); }
};

enum class InertialParametrisation {
  about_com,     ///< m, lg, J about the centre of mass
  about_origin,  ///< m, mx, my, J about the body's origin: torques are linear in them
};

/// What becomes of parameters that are expressions of others: a symbol, or what the expression says. Ratios stay symbols.
enum class ParameterExpressions { symbols, inlined };

struct TreeOptions {
  InertialParametrisation inertial = InertialParametrisation::about_com;
  ParameterExpressions expressions = ParameterExpressions::symbols;
  bool natural = false;  ///< points and bodies for natural coordinates, too
};

/// @param mechanism without faults
/// @param texts what its spec says: parameters become symbols under their names
/// @throws FormulaError for what has no formula
SymbolicTree build_symbolic_tree(Ring& ring, const Mechanism& mechanism, const SpecNumberTexts& texts,
                                 const TreeOptions& options = {});

}  // namespace balance::formulas
