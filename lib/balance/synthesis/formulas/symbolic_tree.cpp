#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/model/topology.hpp"
#include "balance/synthesis/formulas/mechanism_symbols.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <vector>

namespace balance::formulas {

// Construction of chains of frames.

/// A rotation about a coordinate axis by an angle that does not depend on the pose [rad].
struct FixedRotation {
  int axis = 0;
  Expression angle;
  int sign = 1;  ///< −1: in the opposite direction
};

/// Rotations to a frame in which coordinate axis `axis`, times `sign`, points along a unit vector.
struct Alignment {
  std::vector<FixedRotation> rotations;
  int axis = 0;
  int sign = 1;
};
/// If the spec lets the direction change, the rotations are those for a general direction.
Alignment find_alignment(const Vector3E& direction);
/// Successive rotations that compose a rotation matrix.
std::vector<FixedRotation> decompose_rotation(const Matrix3E& rotation);
std::vector<FixedRotation> reverse_rotations(std::vector<FixedRotation> rotations);

class FrameBuilder {
 public:
  FrameBuilder(Ring& ring, SymbolicTree& tree);

  /// The group of an angle about an axis there: a new one, or that of the last joint with a parallel axis.
  int group_of(const FramePoint& from, int axis);
  FramePoint rotate(const FramePoint& from, const std::vector<FixedRotation>& rotations);
  /// @param sign −1: in the opposite direction
  FramePoint apply_joint(const FramePoint& from, const Vector3E& direction, int variable, int sign);
  /// The same, but without rotating back: one axis of the resulting frame is the joint's.
  FramePoint apply_aligned_joint(const FramePoint& from, const Alignment& alignment, int variable, int sign);
  /// The index of a new variable; its angle gets a group when it is first used in a rotation.
  int add_variable(const std::string& name, bool is_angle);

 private:
  FramePoint rotate_once(const FramePoint& from, const FixedRotation& rotation);
  int fixed_angle(int group, const Expression& value);
  int add_frame(SymbolicFrame frame);

  Ring& ring_;
  SymbolicTree& tree_;
  std::vector<std::string> names_;          ///< of variables
  std::vector<std::array<int, 3>> groups_;  ///< per frame and axis; −1: none yet
  std::vector<int> fixed_;                  ///< fixed angles of the ring
  int group_count_ = 0;
};

bool is_constant(const Vector3E& v) {
  return std::all_of(v.begin(), v.end(), [](const Expression& x) { return x.is_constant(); });
}

bool is_constant(const Matrix3E& m) {
  return is_constant(Vector3E(m.col(0))) && is_constant(Vector3E(m.col(1))) && is_constant(Vector3E(m.col(2)));
}

Vector3 to_values(const Vector3E& v) { return {v[0].value(), v[1].value(), v[2].value()}; }

Matrix3 to_values(const Matrix3E& m) {
  Matrix3 values;
  for (int column = 0; column < 3; ++column) values.col(column) = to_values(Vector3E(m.col(column)));
  return values;
}

ParametricModel::ParametricModel(const Mechanism& mechanism, const study::SpecNumberTexts& texts) {
  if (texts.recording == nullptr) {
    mechanism_ = model::convert_mechanism<Expression>(mechanism, [](double x) { return Expression(x); });
    return;
  }
  inputs_ = texts.recording->inputs;
  std::vector<Expression> inputs;
  for (const double value : inputs_) inputs.push_back(Expression::input(graph_, value));
  const study::RecordedValues<Expression> recorded(*texts.recording, inputs);
  mechanism_ = recorded.mechanism();
  for (const study::NamedExpression& parameter : texts.recording->parameters)
    parameters_.push_back({parameter.name, recorded(parameter.value), parameter.is_plain});
  // factors between 1.1 and 1.3, all of them different
  double fraction = 0;
  for (const double value : inputs_) {
    fraction = std::fmod(fraction + 0.6180339887498949, 1.0);
    perturbed_inputs_.push_back(value == 0 ? 0.1 + 0.2 * fraction : value * (1.1 + 0.2 * fraction));
  }
}

std::vector<double> ParametricModel::evaluate_nodes(const std::vector<double>& inputs) const {
  return evaluate(graph_, inputs, expression::ScalarAlgebra<double>());
}

Mechanism attach_payloads(const Mechanism& mechanism) {
  return mechanism_in_interval(mechanism, model::PayloadIntervals(), 0);
}

Mechanism ParametricModel::build_mechanism(const std::vector<double>& nodes) const {
  return attach_payloads(
      model::convert_mechanism<double>(mechanism_, [&](const Expression& x) { return node_value(x, nodes); }));
}

double ParametricModel::perturbed_value(const Expression& x) const {
  if (!x.is_constant() && static_cast<std::size_t>(x.node()) >= perturbed_nodes_.size())
    perturbed_nodes_ = evaluate_nodes(perturbed_inputs_);
  return node_value(x, perturbed_nodes_);
}

ParametricModel::SignedInput ParametricModel::input_of(const Expression& x) const {
  if (x.is_constant()) return {};
  const auto& nodes = graph_.nodes();
  SignedInput found;
  const expression::ExpressionNode* node = &nodes[static_cast<std::size_t>(x.node())];
  for (; node->operation == expression::Operation::negate; found.sign = -found.sign)
    node = &nodes[static_cast<std::size_t>(node->arguments[0])];
  if (node->operation == expression::Operation::input) found.index = node->input;
  return found;
}

bool ParametricModel::are_equal(const Vector3E& a, const Vector3E& b) const {
  for (int k = 0; k < 3; ++k)
    if (a[k].value() != b[k].value() || perturbed_value(a[k]) != perturbed_value(b[k])) return false;
  return true;
}

namespace {

constexpr double rotation_epsilon = 1e-12;

/// Whether an angle is a whole number of right angles; `count` is this number modulo 4.
bool has_quarter_turns(double angle, int& count) {
  const double quarters = angle / (std::numbers::pi / 2);
  count = static_cast<int>(std::lround(quarters)) & 3;
  return std::abs(quarters - std::round(quarters)) < rotation_epsilon;
}

}  // namespace

namespace {

Alignment find_fixed_alignment(const Vector3& u) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(std::abs(u[k]) - 1) < rotation_epsilon) return {{}, k, u[k] > 0 ? 1 : -1};
  if (std::abs(u.z()) < rotation_epsilon) return {{{2, elementary::atan2(u.y(), u.x())}}, 0, 1};
  if (std::abs(u.x()) < rotation_epsilon) return {{{0, elementary::atan2(u.z(), u.y())}}, 1, 1};
  if (std::abs(u.y()) < rotation_epsilon) return {{{1, -elementary::atan2(u.z(), u.x())}}, 0, 1};
  return {{{2, elementary::atan2(u.y(), u.x())}, {1, -elementary::asin(std::clamp(u.z(), -1.0, 1.0))}}, 0, 1};
}

std::vector<FixedRotation> decompose_fixed_rotation(const Matrix3& R) {
  std::vector<FixedRotation> rotations;
  const double pitch = elementary::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const bool is_gimbal_locked = std::hypot(R(0, 0), R(1, 0)) < rotation_epsilon;
  const double yaw = is_gimbal_locked ? elementary::atan2(-R(0, 1), R(1, 1)) : elementary::atan2(R(1, 0), R(0, 0));
  const double roll = is_gimbal_locked ? 0 : elementary::atan2(R(2, 1), R(2, 2));
  for (const auto& [axis, angle] : {std::pair{2, yaw}, {1, pitch}, {0, roll}})
    if (std::abs(angle) > rotation_epsilon) rotations.push_back({axis, angle});
  return rotations;
}

Expression hypotenuse(const Expression& a, const Expression& b) { return sqrt(a * a + b * b); }

bool is_constant_zero(const Expression& x) { return x.is_constant() && x.value() == 0; }

/// Removes rotations that are the identity for all numbers.
std::vector<FixedRotation> remove_identity_rotations(std::vector<FixedRotation> rotations) {
  std::erase_if(rotations, [](const FixedRotation& rotation) {
    return rotation.angle.is_constant() && rotation.angle.value() == 0;
  });
  return rotations;
}

}  // namespace

Alignment find_alignment(const Vector3E& u) {
  if (is_constant(u)) return find_fixed_alignment(to_values(u));
  if (is_constant_zero(u.z())) return {remove_identity_rotations({{2, atan2(u.y(), u.x())}}), 0, 1};
  return {remove_identity_rotations({{2, atan2(u.y(), u.x())}, {1, atan2(u.z(), hypotenuse(u.x(), u.y())), -1}}), 0, 1};
}

std::vector<FixedRotation> decompose_rotation(const Matrix3E& R) {
  if (is_constant(R)) return decompose_fixed_rotation(to_values(R));
  if (is_constant_zero(R(2, 0)) && is_constant_zero(R(2, 1)) &&
      is_constant_zero(R(2, 2) - 1))  // about z, as everything in the plane
    return remove_identity_rotations({{2, atan2(R(1, 0), R(0, 0))}});
  return remove_identity_rotations({{2, atan2(R(1, 0), R(0, 0))},
                                    {1, atan2(R(2, 0), hypotenuse(R(0, 0), R(1, 0))), -1},
                                    {0, atan2(R(2, 1), R(2, 2))}});
}

std::vector<FixedRotation> reverse_rotations(std::vector<FixedRotation> rotations) {
  std::reverse(rotations.begin(), rotations.end());
  for (FixedRotation& rotation : rotations) rotation.sign = -rotation.sign;
  return rotations;
}

FrameBuilder::FrameBuilder(Ring& ring, SymbolicTree& tree) : ring_(ring), tree_(tree) {
  tree_.frames.assign(1, {});
  groups_.assign(1, {-1, -1, -1});
}

int FrameBuilder::group_of(const FramePoint& from, int axis) {
  int& group = groups_[static_cast<std::size_t>(from.frame)][static_cast<std::size_t>(axis)];
  if (group < 0) group = group_count_++;
  return group;
}

int FrameBuilder::add_frame(SymbolicFrame frame) {
  tree_.frames.push_back(std::move(frame));
  groups_.push_back({-1, -1, -1});
  return static_cast<int>(tree_.frames.size()) - 1;
}

int FrameBuilder::fixed_angle(int group, const Expression& value) {
  for (const int angle : fixed_) {
    const Angle& known = ring_.angle(angle);
    const bool is_same = value.is_constant() && known.source.is_constant()
                             ? std::abs(known.value - value.value()) < rotation_epsilon
                             : known.source.node() == value.node();
    if (known.group == group && is_same) return angle;
  }
  fixed_.push_back(ring_.add_fixed_angle("alpha" + std::to_string(fixed_.size() + 1), group, value));
  return fixed_.back();
}

FramePoint FrameBuilder::rotate(const FramePoint& from, const std::vector<FixedRotation>& rotations) {
  FramePoint point = from;
  for (const FixedRotation& rotation : rotations) point = rotate_once(point, rotation);
  return point;
}

FramePoint FrameBuilder::rotate_once(const FramePoint& from, const FixedRotation& rotation) {
  SymbolicFrame frame;
  frame.parent = from.frame, frame.offset = from.at, frame.axis = rotation.axis;
  const auto k = static_cast<std::size_t>(rotation.axis), i = (k + 1) % 3, j = (k + 2) % 3;
  int quarters = 0;
  const double value = rotation.angle.value();
  if (!rotation.angle.is_constant() || !has_quarter_turns(rotation.sign * value, quarters)) {
    const int group = group_of(from, rotation.axis);
    const bool negative = rotation.angle.is_constant() && value < 0;
    frame.sign = negative ? -rotation.sign : rotation.sign;
    frame.angle = fixed_angle(group, negative ? Expression(-value) : rotation.angle);
    const int frame_id = add_frame(frame);
    groups_.back()[k] = group;
    return {frame_id, {}};
  }
  // each quarter turn moves axis i to j
  for (int q = 0; q < quarters; ++q) {
    const int axis = frame.axes[i], sign = frame.signs[i];
    frame.axes[i] = frame.axes[j], frame.signs[i] = frame.signs[j];
    frame.axes[j] = axis, frame.signs[j] = -sign;
  }
  const int frame_id = add_frame(frame);
  const auto& axes = tree_.frames.back().axes;
  for (std::size_t a = 0; a < 3; ++a) groups_.back()[a] = group_of(from, axes[a]);
  return {frame_id, {}};
}

FramePoint FrameBuilder::apply_joint(const FramePoint& from, const Vector3E& direction, int variable, int sign) {
  const Alignment alignment = find_alignment(direction);
  return rotate(apply_aligned_joint(from, alignment, variable, sign), reverse_rotations(alignment.rotations));
}

FramePoint FrameBuilder::apply_aligned_joint(const FramePoint& from, const Alignment& alignment, int variable,
                                             int sign) {
  const FramePoint base = rotate(from, alignment.rotations);
  SymbolicFrame frame;
  frame.parent = base.frame, frame.offset = base.at, frame.variable = variable;
  frame.axis = alignment.axis, frame.sign = sign * alignment.sign;
  JointVariable& joint_variable = tree_.variables[static_cast<std::size_t>(variable)];
  if (joint_variable.is_angle) {
    const int group = group_of(base, alignment.axis);
    if (joint_variable.index < 0)
      joint_variable.index = ring_.add_angle(names_[static_cast<std::size_t>(variable)], group);
    frame.angle = joint_variable.index;
    const int frame_id = add_frame(frame);
    groups_.back()[static_cast<std::size_t>(alignment.axis)] = group;
    return {frame_id, {}};
  }
  frame.slide = joint_variable.index;
  const int frame_id = add_frame(frame);
  for (int axis = 0; axis < 3; ++axis) groups_.back()[static_cast<std::size_t>(axis)] = group_of(base, axis);
  return {frame_id, {}};
}

int FrameBuilder::add_variable(const std::string& name, bool is_angle) {
  JointVariable variable;
  variable.is_angle = is_angle;
  variable.index = is_angle ? -1 : ring_.add_symbol(name, SymbolKind::slide, 0);
  tree_.variables.push_back(variable);
  names_.push_back(name);
  return static_cast<int>(tree_.variables.size()) - 1;
}

namespace {

struct JointStep {
  bool is_rotation;
  Vector3E direction;
  int coordinate;                  ///< within the joint
  bool offsets_by_radius = false;  ///< then offset by the rolling radius along the normal
};

std::vector<JointStep> list_joint_steps(const model::JointOf<Expression>& joint) {
  const Vector3E &u = joint.axis, &v = joint.axis2;
  const Vector3E x = Vector3E::UnitX(), y = Vector3E::UnitY(), z = Vector3E::UnitZ();
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {{true, u, 0}};
    case JointType::prismatic: return {{false, u, 0}};
    case JointType::pin_slot: return {{false, u, 0}, {true, z, 1}};
    case JointType::cylindrical: return {{false, u, 1}, {true, u, 0}};
    case JointType::universal: return {{true, u, 0}, {true, v, 1}};
    case JointType::spherical: return {{true, x, 0}, {true, y, 1}, {true, z, 2}};
    case JointType::planar: return {{false, v, 0}, {false, u.cross(v), 1}, {true, u, 2}};
    case JointType::free:
      return {{false, x, 0}, {false, y, 1}, {false, z, 2}, {true, x, 3}, {true, y, 4}, {true, z, 5}};
    case JointType::rolling_disc:
      return {{false, v, 0}, {false, u.cross(v), 1}, {true, u, 2}, {true, v, 3, true}, {true, u.cross(v), 4}};
    case JointType::rolling_sphere:
      return {{false, v, 0}, {false, u.cross(v), 1, true}, {true, x, 2}, {true, y, 3}, {true, z, 4}};
  }
  return {};
}

class SymbolicTreeBuilder {
 public:
  SymbolicTreeBuilder(Ring& ring, const Mechanism& mechanism, const study::SpecNumberTexts& texts,
                      const TreeOptions& options)
      : ring_(ring),
        mechanism_(mechanism),
        model_(std::make_shared<ParametricModel>(mechanism, texts)),
        symbols_(ring, *model_, texts, options),
        frames_(ring, tree_),
        spanning_tree_(model::build_spanning_tree(mechanism, options.needed)),
        has_natural_(options.natural) {
    tree_.model = model_;
    tree_.is_planar = mechanism.space == SpaceKind::planar;
    bodies_.resize(mechanism.bodies.size());
    bodies_[0] = {0, {}};
  }

  SymbolicTree build() {
    add_variables();
    for (const model::TreeEdge& edge : spanning_tree_.edges) add_edge(edge);
    for (const int joint : spanning_tree_.cut) add_closure(joint);
    add_masses();
    for (std::size_t d = 0; d < mechanism_.discs.size(); ++d) add_disc(static_cast<int>(d));
    for (std::size_t s = 0; s < mechanism_.springs.size(); ++s)
      mechanism_.springs[s].is_joint_spring() ? add_joint_spring(s) : add_spring(s);
    tree_.gravity = symbols_.gravity();
    tree_.inertial = symbols_.inertial();
    tree_.numbers = std::make_shared<MechanismSymbols>(symbols_);
    tree_.bodies = bodies_;
    if (has_natural_) tree_.basic_points = build_basic_point_model(ring_, mechanism_, *model_, symbols_);
    if (!mechanism_.friction.empty()) tree_.excluded_terms.emplace_back("friction");
    if (!mechanism_.loads.empty()) tree_.excluded_terms.emplace_back("loads");
    const auto is_damper = [](const ForceElement& element) { return element.is_damper(); };
    const std::vector<ForceElement>& elements = mechanism_.force_elements;
    if (std::any_of(elements.begin(), elements.end(), is_damper)) tree_.excluded_terms.emplace_back("dampers");
    if (!std::all_of(elements.begin(), elements.end(), is_damper))
      tree_.excluded_terms.emplace_back("springs with a table");
    return std::move(tree_);
  }

 private:
  std::size_t first_coordinate(int joint) const {
    const auto& coordinates = mechanism_.coordinates;
    const auto first =
        std::find_if(coordinates.begin(), coordinates.end(), [&](const Coordinate& c) { return c.joint == joint; });
    return static_cast<std::size_t>(first - coordinates.begin());
  }
  const model::JointOf<Expression>& joint(int index) const {
    return model_->mechanism().joints[static_cast<std::size_t>(index)];
  }
  FramePoint& body(int index) { return bodies_[static_cast<std::size_t>(index)]; }
  static FramePoint offset_point(FramePoint point, const Vector& d, int sign) {
    point.at = sign > 0 ? point.at + d : point.at - d;
    return point;
  }

  /// Coordinates that do not follow others become columns.
  void add_variables() {
    variable_.assign(mechanism_.coordinates.size(), -1);
    std::vector<bool> is_cut(mechanism_.joints.size(), false);
    for (const int joint : spanning_tree_.cut) is_cut[static_cast<std::size_t>(joint)] = true;
    for (std::size_t c = 0; c < variable_.size(); ++c) {
      const Coordinate& coordinate = mechanism_.coordinates[c];
      if (is_cut[static_cast<std::size_t>(coordinate.joint)]) continue;
      const std::string name = symbols_.coordinate_name(static_cast<int>(c));
      variable_[c] = frames_.add_variable(name, coordinate.kind == CoordinateKind::angle);
      const bool follows = std::any_of(mechanism_.couplings.begin(), mechanism_.couplings.end(),
                                       [&](const Coupling& p) { return p.follower == static_cast<int>(c); });
      if (follows) continue;
      tree_.columns.push_back(name);
      tree_.coordinates.push_back(static_cast<int>(c));
    }
    tree_.coordinate_variable = variable_;
    for (std::size_t c = 0; c < variable_.size(); ++c)
      if (variable_[c] >= 0)
        set_dependence(tree_.variables[static_cast<std::size_t>(variable_[c])],
                       independent_sum(static_cast<int>(c), 0));
  }

  struct IndependentSum {
    std::vector<std::pair<int, Polynomial>> columns;
    Polynomial offset;
  };
  /// A coordinate as a sum of columns; cached, since sums of sums recur many times.
  const IndependentSum& independent_sum(int coordinate, std::size_t depth) {
    const auto known = independent_sums_.find(coordinate);
    if (known != independent_sums_.end()) return known->second;
    return independent_sums_[coordinate] = compute_independent_sum(coordinate, depth);
  }
  IndependentSum compute_independent_sum(int coordinate, std::size_t depth) {
    if (depth > mechanism_.couplings.size()) throw FormulaError("couplings form a cycle");
    for (std::size_t k = 0; k < mechanism_.couplings.size(); ++k) {
      const Coupling& coupling = mechanism_.couplings[k];
      if (coupling.follower != coordinate) continue;
      IndependentSum sum;
      for (std::size_t t = 0; t < coupling.leader.terms.size(); ++t)
        add(sum, independent_sum(coupling.leader.terms[t].coordinate, depth + 1),
            symbols_.coupling_ratio(k) * symbols_.coupling_term(k, t));
      sum.offset += symbols_.coupling_offset(k);
      return sum;
    }
    const auto column = std::find(tree_.coordinates.begin(), tree_.coordinates.end(), coordinate);
    return {{{static_cast<int>(column - tree_.coordinates.begin()), Polynomial(1)}}, {}};
  }
  /// Adds a multiple of the sum of one of several leaders.
  static void add(IndependentSum& sum, const IndependentSum& leader, const Polynomial& ratio) {
    sum.offset += leader.offset * ratio;
    for (const auto& [column, factor] : leader.columns) {
      const auto entry_of_column =
          std::find_if(sum.columns.begin(), sum.columns.end(),
                       [&, target = column](const auto& entry) { return entry.first == target; });
      if (entry_of_column == sum.columns.end())
        sum.columns.emplace_back(column, factor * ratio);
      else
        entry_of_column->second += factor * ratio;
    }
  }
  static void set_dependence(JointVariable& variable, IndependentSum sum) {
    variable.follows = std::move(sum.columns);
    variable.offset = std::move(sum.offset);
  }

  /// From one end of a joint to the other.
  FramePoint cross_joint(const model::JointOf<Expression>& joint, int index, const FramePoint& from, bool forward) {
    std::vector<JointStep> steps = list_joint_steps(joint);
    FramePoint point = forward ? from : frames_.rotate(from, reverse_rotations(decompose_rotation(joint.rotation)));
    if (!forward) std::reverse(steps.begin(), steps.end());
    for (const JointStep& step : steps) {
      const int variable = variable_[first_coordinate(index) + static_cast<std::size_t>(step.coordinate)];
      if (step.offsets_by_radius && !forward) point = offset_point(point, symbols_.wheel_centre_offset(index), -1);
      point = frames_.apply_joint(point, step.direction, variable, forward ? 1 : -1);
      if (step.offsets_by_radius && forward) point = offset_point(point, symbols_.wheel_centre_offset(index), 1);
    }
    return forward ? frames_.rotate(point, decompose_rotation(joint.rotation)) : point;
  }

  void add_edge(const model::TreeEdge& edge) {
    const model::JointOf<Expression>& edge_joint = joint(edge.joint);
    const Vector p = symbols_.joint_point(edge.joint, true), q = symbols_.joint_point(edge.joint, false);
    const FramePoint start = offset_point(body(edge.parent), edge.forward ? p : q, 1);
    const FramePoint end =
        offset_point(cross_joint(edge_joint, edge.joint, start, edge.forward), edge.forward ? q : p, -1);
    if (edge.split)
      tree_.closures.push_back(
          {edge_joint.name, JointType::fixed, end, body(edge.forward ? edge_joint.second : edge_joint.first)});
    else
      body(edge.child) = end;
  }

  /// Axes of both frames as the closure's equations expect them: planar slides are along x, spatial joint axes along z.
  std::vector<FixedRotation> closure_rotations(const model::JointOf<Expression>& joint) const {
    const bool has_slide = joint.type == JointType::prismatic || joint.type == JointType::pin_slot;
    if (tree_.is_planar && !has_slide) return {};
    Matrix3E axes = Matrix3E::Identity();
    if (tree_.is_planar) {
      axes(0, 0) = axes(1, 1) = joint.axis.x();
      axes(1, 0) = joint.axis.y(), axes(0, 1) = -joint.axis.y();
      return decompose_rotation(axes);
    }
    if (joint.type == JointType::spherical || joint.type == JointType::fixed || joint.type == JointType::free)
      return {};
    if (joint.type == JointType::universal || joint.type == JointType::planar) {
      axes << joint.axis2, joint.axis.cross(joint.axis2), joint.axis;
      return decompose_rotation(axes);
    }
    if (!is_constant(joint.axis))
      return {{2, atan2(joint.axis.y(), joint.axis.x())},
              {1, atan2(sqrt(joint.axis.x() * joint.axis.x() + joint.axis.y() * joint.axis.y()), joint.axis.z())}};
    const Matrix3 R = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), to_values(joint.axis)).toRotationMatrix();
    return decompose_rotation(Matrix3E(R.cast<Expression>()));
  }

  void add_closure(int index) {
    const model::JointOf<Expression>& cut_joint = joint(index);
    FramePoint a = offset_point(body(cut_joint.first), symbols_.joint_point(index, true), 1);
    FramePoint b = offset_point(body(cut_joint.second), symbols_.joint_point(index, false), 1);
    b = frames_.rotate(b, reverse_rotations(decompose_rotation(cut_joint.rotation)));
    const std::vector<FixedRotation> rotations = closure_rotations(cut_joint);
    a = frames_.rotate(a, rotations), b = frames_.rotate(b, rotations);
    tree_.closures.push_back({cut_joint.name, cut_joint.type, a, b});
    const bool is_unrotated = is_constant(cut_joint.rotation) && to_values(cut_joint.rotation).isIdentity(0);
    if (tree_.is_planar && cut_joint.type == JointType::revolute && is_unrotated)
      add_angle_relation(index, a.frame, b.frame);
  }

  /// The angle of a joint that closes a loop is the sum of the angles around the loop.
  void add_angle_relation(int index, int a, int b) {
    AngleRelation relation;
    for (const auto& [end, sign] : {std::pair{b, 1}, std::pair{a, -1}})
      for (int frame_id = end; frame_id > 0; frame_id = tree_.frames[static_cast<std::size_t>(frame_id)].parent) {
        const SymbolicFrame& frame = tree_.frames[static_cast<std::size_t>(frame_id)];
        if (frame.axes != std::array<int, 3>{0, 1, 2}) return;
        if (frame.angle >= 0) relation.multiples[frame.angle] += sign * frame.sign;
      }
    std::erase_if(relation.multiples, [](const auto& entry) { return entry.second == 0; });
    if (relation.multiples.empty()) return;
    const int group = ring_.angle(relation.multiples.begin()->first).group;
    relation.angle = ring_.add_angle(symbols_.coordinate_name(static_cast<int>(first_coordinate(index))), group);
    tree_.relations.push_back(relation);
  }

  void add_mass(const FramePoint& point, const Mass& mass) {
    tree_.frames[static_cast<std::size_t>(point.frame)].mass += shift_origin(mass, point.at);
  }

  void add_masses() {
    for (std::size_t b = 1; b < bodies_.size(); ++b) add_mass(bodies_[b], symbols_.body(static_cast<int>(b)));
    for (std::size_t k = 0; k < mechanism_.attachments.size(); ++k)
      add_mass(body(mechanism_.attachments[k].body), symbols_.attachment(static_cast<int>(k)));
  }

  void add_disc(int index) {
    const Disc& disc = mechanism_.discs[static_cast<std::size_t>(index)];
    const FramePoint centre = offset_point(body(disc.body), symbols_.disc_position(index), 1);
    const int variable = frames_.add_variable("phi_" + identifier_name(disc.name), true);
    const Polynomial ratio = symbols_.ratio(index);
    IndependentSum sum;
    for (std::size_t t = 0; t < disc.follows.terms.size(); ++t)
      add(sum, independent_sum(disc.follows.terms[t].coordinate, 0), ratio * symbols_.disc_term(index, t));
    set_dependence(tree_.variables.back(), std::move(sum));
    const Vector3E& axis = model_->mechanism().discs[static_cast<std::size_t>(index)].axis;
    if (!symbols_.is_rotor(index)) {
      const FramePoint turned = frames_.apply_joint(centre, axis, variable, 1);
      add_mass(turned, symbols_.disc(index));
      tree_.discs.push_back({disc.name, turned.frame, variable});
      return;
    }
    // its moments of inertia are about its axis and across it, which may be oblique to its carrier's axes
    const Alignment alignment = find_alignment(axis);
    const FramePoint aligned = frames_.apply_aligned_joint(centre, alignment, variable, 1);
    add_mass(aligned, symbols_.rotor(index, alignment.axis));
    tree_.discs.push_back({disc.name, frames_.rotate(aligned, reverse_rotations(alignment.rotations)).frame, variable});
  }

  void add_spring(std::size_t s) {
    const Spring& spring = mechanism_.springs[s];
    LinearSpring linear_spring;
    linear_spring.a = offset_point(body(spring.first), symbols_.spring_point(s, true), 1);
    linear_spring.b = offset_point(body(spring.second), symbols_.spring_point(s, false), 1);
    linear_spring.stiffness = symbols_.stiffness(s), linear_spring.free_length = symbols_.free_length(s);
    if (!linear_spring.free_length.is_zero())
      linear_spring.length = ring_.add_symbol("L_" + identifier_name(spring.name), SymbolKind::alias, 1);
    tree_.springs.push_back(linear_spring);
  }

  void add_joint_spring(std::size_t s) {
    const Spring& spring = mechanism_.springs[s];
    const int variable = variable_[static_cast<std::size_t>(spring.coordinate)];
    if (variable < 0) throw FormulaError("spring " + spring.name + " is in a joint that closes a loop");
    const JointVariable& joint_variable = tree_.variables[static_cast<std::size_t>(variable)];
    const int symbol = joint_variable.is_angle ? ring_.symbol_of_angle(joint_variable.index) : joint_variable.index;
    tree_.joint_springs.push_back({variable, symbol, symbols_.stiffness(s), symbols_.preload(s)});
  }

  Ring& ring_;
  const Mechanism& mechanism_;
  std::shared_ptr<const ParametricModel> model_;
  SymbolicTree tree_;
  MechanismSymbols symbols_;
  FrameBuilder frames_;
  model::SpanningTree spanning_tree_;
  std::vector<FramePoint> bodies_;
  std::map<int, IndependentSum> independent_sums_;
  std::vector<int> variable_;  ///< per coordinate; −1 if its joint closes a loop
  bool has_natural_;
};

}  // namespace

std::vector<CoordinateId> find_coordinates(const Mechanism& mechanism, const std::vector<std::string>& names) {
  std::vector<CoordinateId> coordinates;
  for (const std::string& name : names) {
    const auto& list = mechanism.coordinates;
    const auto found = std::find_if(list.begin(), list.end(), [&](const Coordinate& c) { return c.name == name; });
    if (found == list.end()) throw FormulaError("'" + name + "' is no coordinate of the mechanism");
    coordinates.emplace_back(static_cast<int>(found - list.begin()));
  }
  return coordinates;
}

std::vector<std::string> coordinate_names(const Mechanism& mechanism, const SymbolicTree& tree) {
  std::vector<int> columns(tree.columns.size());
  std::iota(columns.begin(), columns.end(), 0);
  return coordinate_names(mechanism, tree, columns);
}

SymbolicTree build_symbolic_tree(Ring& ring, const Mechanism& mechanism, const study::SpecNumberTexts& texts,
                                 const TreeOptions& options) {
  return SymbolicTreeBuilder(ring, mechanism, texts, options).build();
}

}  // namespace balance::formulas
