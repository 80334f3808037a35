#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/mechanics/model/topology.hpp"
#include "balance/synthesis/formulas/mechanism_symbols.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

namespace balance::formulas {

// Puts frames behind each other.

/// A turn about a coordinate axis that does not depend on the pose [rad].
struct FixedRotation {
  int axis = 0;
  Expression angle;
  int sign = 1;  ///< −1: backwards
};

/// A coordinate axis k of a frame that the turns lead to, so that it points along a unit vector.
struct Alignment {
  std::vector<FixedRotation> turns;
  int axis = 0;
  int sign = 1;
};
/// Where the spec lets the direction change, the turns are those of any direction.
Alignment find_alignment(const Vector3E& direction);
/// Turns one after another that make a rotation.
std::vector<FixedRotation> decompose_rotation(const Matrix3E& rotation);
std::vector<FixedRotation> reverse_rotations(std::vector<FixedRotation> turns);

class FrameBuilder {
 public:
  FrameBuilder(Ring& ring, SymbolicTree& tree);

  /// The run of an angle that turns about an axis there: new, or that of the last joint with a parallel axis.
  int group_of(const FramePoint& from, int axis);
  FramePoint rotate(const FramePoint& from, const std::vector<FixedRotation>& turns);
  /// @param sign −1: backwards
  FramePoint apply_joint(const FramePoint& from, const Vector3E& direction, int variable, int sign);
  /// The same, left in axes of which `along` has one.
  FramePoint apply_aligned_joint(const FramePoint& from, const Alignment& along, int variable, int sign);
  /// The number of a new variable; its angle gets its run when it is first turned by.
  int add_variable(const std::string& name, bool is_angle);

 private:
  FramePoint rotate_once(const FramePoint& from, const FixedRotation& turn);
  int fixed_angle(int run, const Expression& value);
  int add_frame(SymbolicFrame frame);

  Ring& ring_;
  SymbolicTree& tree_;
  std::vector<std::string> names_;          ///< of variables
  std::vector<std::array<int, 3>> groups_;  ///< per frame and axis; −1: none yet
  std::vector<int> fixed_;                  ///< angles of the ring that do not change
  int run_count_ = 0;
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

ParametricModel::ParametricModel(const Mechanism& mechanism, const SpecNumberTexts& texts) {
  if (texts.recording == nullptr) {
    mechanism_ = convert_mechanism<Expression>(mechanism, [](double x) { return Expression(x); });
    return;
  }
  inputs_ = texts.recording->inputs;
  std::vector<Expression> inputs;
  for (const double value : inputs_) inputs.push_back(Expression::input(graph_, value));
  const RecordedValues<Expression> recorded(*texts.recording, inputs);
  mechanism_ = recorded.mechanism();
  for (const NamedExpression& parameter : texts.recording->parameters)
    parameters_.push_back({parameter.name, recorded(parameter.value), parameter.is_plain});
  // factors between 1.1 and 1.3 that nothing else has
  double turn = 0;
  for (const double value : inputs_) {
    turn = std::fmod(turn + 0.6180339887498949, 1.0);
    perturbed_inputs_.push_back(value == 0 ? 0.1 + 0.2 * turn : value * (1.1 + 0.2 * turn));
  }
}

std::vector<double> ParametricModel::evaluate_nodes(const std::vector<double>& inputs) const {
  return evaluate(graph_, inputs, ScalarAlgebra<double>());
}

Mechanism ParametricModel::build_mechanism(const std::vector<double>& nodes) const {
  return convert_mechanism<double>(mechanism_, [&](const Expression& x) { return node_value(x, nodes); });
}

double ParametricModel::perturbed_value(const Expression& x) const {
  if (!x.is_constant() && static_cast<std::size_t>(x.node()) >= perturbed_nodes_.size())
    perturbed_nodes_ = evaluate_nodes(perturbed_inputs_);
  return node_value(x, perturbed_nodes_);
}

bool ParametricModel::are_equal(const Vector3E& a, const Vector3E& b) const {
  for (int k = 0; k < 3; ++k)
    if (a[k].value() != b[k].value() || perturbed_value(a[k]) != perturbed_value(b[k])) return false;
  return true;
}

namespace {

constexpr double rotation_epsilon = 1e-12;

/// Whole right angles in a turn, or none.
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
  std::vector<FixedRotation> turns;
  const double pitch = elementary::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const bool locked = std::hypot(R(0, 0), R(1, 0)) < rotation_epsilon;
  const double yaw = locked ? elementary::atan2(-R(0, 1), R(1, 1)) : elementary::atan2(R(1, 0), R(0, 0));
  const double roll = locked ? 0 : elementary::atan2(R(2, 1), R(2, 2));
  for (const auto& [axis, angle] : {std::pair{2, yaw}, {1, pitch}, {0, roll}})
    if (std::abs(angle) > rotation_epsilon) turns.push_back({axis, angle});
  return turns;
}

Expression hypotenuse(const Expression& a, const Expression& b) { return sqrt(a * a + b * b); }

/// Turns that are none whatever the numbers are, left out.
std::vector<FixedRotation> remove_identity_rotations(std::vector<FixedRotation> turns) {
  std::erase_if(turns, [](const FixedRotation& turn) { return turn.angle.is_constant() && turn.angle.value() == 0; });
  return turns;
}

}  // namespace

Alignment find_alignment(const Vector3E& u) {
  if (is_constant(u)) return find_fixed_alignment(to_values(u));
  return {remove_identity_rotations({{2, atan2(u.y(), u.x())}, {1, atan2(u.z(), hypotenuse(u.x(), u.y())), -1}}), 0, 1};
}

std::vector<FixedRotation> decompose_rotation(const Matrix3E& R) {
  if (is_constant(R)) return decompose_fixed_rotation(to_values(R));
  return remove_identity_rotations({{2, atan2(R(1, 0), R(0, 0))},
                                    {1, atan2(R(2, 0), hypotenuse(R(0, 0), R(1, 0))), -1},
                                    {0, atan2(R(2, 1), R(2, 2))}});
}

std::vector<FixedRotation> reverse_rotations(std::vector<FixedRotation> turns) {
  std::reverse(turns.begin(), turns.end());
  for (FixedRotation& turn : turns) turn.sign = -turn.sign;
  return turns;
}

FrameBuilder::FrameBuilder(Ring& ring, SymbolicTree& tree) : ring_(ring), tree_(tree) {
  tree_.frames.assign(1, {});
  groups_.assign(1, {-1, -1, -1});
}

int FrameBuilder::group_of(const FramePoint& from, int axis) {
  int& run = groups_[static_cast<std::size_t>(from.frame)][static_cast<std::size_t>(axis)];
  if (run < 0) run = run_count_++;
  return run;
}

int FrameBuilder::add_frame(SymbolicFrame frame) {
  tree_.frames.push_back(std::move(frame));
  groups_.push_back({-1, -1, -1});
  return static_cast<int>(tree_.frames.size()) - 1;
}

int FrameBuilder::fixed_angle(int run, const Expression& value) {
  for (const int angle : fixed_) {
    const Angle& known = ring_.angle(angle);
    const bool same = value.is_constant() && known.source.is_constant()
                          ? std::abs(known.value - value.value()) < rotation_epsilon
                          : known.source.node() == value.node();
    if (known.group == run && same) return angle;
  }
  fixed_.push_back(ring_.add_fixed_angle("alpha" + std::to_string(fixed_.size() + 1), run, value));
  return fixed_.back();
}

FramePoint FrameBuilder::rotate(const FramePoint& from, const std::vector<FixedRotation>& turns) {
  FramePoint at = from;
  for (const FixedRotation& turn : turns) at = rotate_once(at, turn);
  return at;
}

FramePoint FrameBuilder::rotate_once(const FramePoint& from, const FixedRotation& turn) {
  SymbolicFrame frame;
  frame.parent = from.frame, frame.offset = from.at, frame.axis = turn.axis;
  const auto k = static_cast<std::size_t>(turn.axis), i = (k + 1) % 3, j = (k + 2) % 3;
  int quarters = 0;
  const double value = turn.angle.value();
  if (!turn.angle.is_constant() || !has_quarter_turns(turn.sign * value, quarters)) {
    const int run = group_of(from, turn.axis);
    const bool negative = turn.angle.is_constant() && value < 0;
    frame.sign = negative ? -turn.sign : turn.sign;
    frame.angle = fixed_angle(run, negative ? Expression(-value) : turn.angle);
    const int turned = add_frame(frame);
    groups_.back()[k] = run;
    return {turned, {}};
  }
  // axis i comes to lie along j after one quarter
  for (int q = 0; q < quarters; ++q) {
    const int axis = frame.axes[i], sign = frame.signs[i];
    frame.axes[i] = frame.axes[j], frame.signs[i] = frame.signs[j];
    frame.axes[j] = axis, frame.signs[j] = -sign;
  }
  const int turned = add_frame(frame);
  const auto& axes = tree_.frames.back().axes;
  for (std::size_t a = 0; a < 3; ++a) groups_.back()[a] = group_of(from, axes[a]);
  return {turned, {}};
}

FramePoint FrameBuilder::apply_joint(const FramePoint& from, const Vector3E& direction, int variable, int sign) {
  const Alignment along = find_alignment(direction);
  return rotate(apply_aligned_joint(from, along, variable, sign), reverse_rotations(along.turns));
}

FramePoint FrameBuilder::apply_aligned_joint(const FramePoint& from, const Alignment& along, int variable, int sign) {
  const FramePoint base = rotate(from, along.turns);
  SymbolicFrame frame;
  frame.parent = base.frame, frame.offset = base.at, frame.variable = variable;
  frame.axis = along.axis, frame.sign = sign * along.sign;
  JointVariable& moving = tree_.variables[static_cast<std::size_t>(variable)];
  if (moving.is_angle) {
    const int run = group_of(base, along.axis);
    if (moving.index < 0) moving.index = ring_.add_angle(names_[static_cast<std::size_t>(variable)], run);
    frame.angle = moving.index;
    const int turned_to = add_frame(frame);
    groups_.back()[static_cast<std::size_t>(along.axis)] = run;
    return {turned_to, {}};
  }
  frame.slide = moving.index;
  const int slid = add_frame(frame);
  for (int axis = 0; axis < 3; ++axis) groups_.back()[static_cast<std::size_t>(axis)] = group_of(base, axis);
  return {slid, {}};
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
  bool turns;
  Vector3E direction;
  int coordinate;      ///< within the joint
  bool rises = false;  ///< then up by the radius of what rolls
};

std::vector<JointStep> steps_of(const JointOf<Expression>& joint) {
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
    case JointType::rolling_disc:
      return {{false, v, 0}, {false, u.cross(v), 1}, {true, u, 2}, {true, v, 3, true}, {true, u.cross(v), 4}};
    case JointType::rolling_sphere:
      return {{false, v, 0}, {false, u.cross(v), 1, true}, {true, x, 2}, {true, y, 3}, {true, z, 4}};
  }
  return {};
}

class SymbolicTreeBuilder {
 public:
  SymbolicTreeBuilder(Ring& ring, const Mechanism& mechanism, const SpecNumberTexts& texts, const TreeOptions& options)
      : ring_(ring),
        mechanism_(mechanism),
        model_(std::make_shared<ParametricModel>(mechanism, texts)),
        numbers_(ring, *model_, texts, options),
        frames_(ring, tree_),
        edges_(build_spanning_tree(mechanism, {})),
        natural_(options.natural) {
    tree_.model = model_;
    tree_.is_planar = mechanism.space == SpaceKind::planar;
    bodies_.resize(mechanism.bodies.size());
    bodies_[0] = {0, {}};
  }

  SymbolicTree build() {
    add_variables();
    for (const TreeEdge& edge : edges_.edges) add_edge(edge);
    for (const int joint : edges_.cut) add_closure(joint);
    add_masses();
    for (std::size_t d = 0; d < mechanism_.discs.size(); ++d) add_disc(static_cast<int>(d));
    for (std::size_t s = 0; s < mechanism_.springs.size(); ++s)
      mechanism_.springs[s].is_joint_spring() ? add_joint_spring(s) : add_spring(s);
    tree_.gravity = numbers_.gravity();
    tree_.inertial = numbers_.inertial();
    if (natural_) tree_.basic_points = build_basic_point_model(ring_, mechanism_, *model_, numbers_);
    if (!mechanism_.friction.empty()) tree_.excluded_terms.emplace_back("friction");
    if (!mechanism_.loads.empty()) tree_.excluded_terms.emplace_back("loads");
    return std::move(tree_);
  }

 private:
  std::size_t first_coordinate(int joint) const {
    const auto& all = mechanism_.coordinates;
    const auto at = std::find_if(all.begin(), all.end(), [&](const Coordinate& c) { return c.joint == joint; });
    return static_cast<std::size_t>(at - all.begin());
  }
  const JointOf<Expression>& joint(int index) const {
    return model_->mechanism().joints[static_cast<std::size_t>(index)];
  }
  FramePoint& body(int index) { return bodies_[static_cast<std::size_t>(index)]; }
  static FramePoint offset_point(FramePoint place, const Vector& d, int sign) {
    place.at = sign > 0 ? place.at + d : place.at - d;
    return place;
  }

  /// Coordinates that follow no other become columns.
  void add_variables() {
    variable_.assign(mechanism_.coordinates.size(), -1);
    std::vector<bool> is_cut(mechanism_.joints.size(), false);
    for (const int joint : edges_.cut) is_cut[static_cast<std::size_t>(joint)] = true;
    for (std::size_t c = 0; c < variable_.size(); ++c) {
      const Coordinate& coordinate = mechanism_.coordinates[c];
      if (is_cut[static_cast<std::size_t>(coordinate.joint)]) continue;
      const std::string name = numbers_.coordinate_name(static_cast<int>(c));
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
        follow(tree_.variables[static_cast<std::size_t>(variable_[c])], roots(static_cast<int>(c), 0));
  }

  struct IndependentSum {
    std::vector<std::pair<int, Polynomial>> columns;
    Polynomial offset;
  };
  /// What a coordinate is made of; each is made out once, since sums of sums meet again and again.
  const IndependentSum& roots(int coordinate, std::size_t depth) {
    const auto known = roots_.find(coordinate);
    if (known != roots_.end()) return known->second;
    return roots_[coordinate] = find_roots(coordinate, depth);
  }
  IndependentSum find_roots(int coordinate, std::size_t depth) {
    if (depth > mechanism_.couplings.size()) throw FormulaError("couplings follow each other in a circle");
    for (std::size_t k = 0; k < mechanism_.couplings.size(); ++k) {
      const Coupling& coupling = mechanism_.couplings[k];
      if (coupling.follower != coordinate) continue;
      IndependentSum sum;
      for (std::size_t t = 0; t < coupling.leader.terms.size(); ++t)
        add(sum, roots(coupling.leader.terms[t].coordinate, depth + 1),
            numbers_.coupling_ratio(k) * numbers_.coupling_term(k, t));
      sum.offset += numbers_.coupling_offset(k);
      return sum;
    }
    const auto column = std::find(tree_.coordinates.begin(), tree_.coordinates.end(), coordinate);
    return {{{static_cast<int>(column - tree_.coordinates.begin()), Polynomial(1)}}, {}};
  }
  /// Adds a multiple of what one of several leaders is made of.
  static void add(IndependentSum& sum, const IndependentSum& leader, const Polynomial& ratio) {
    sum.offset += leader.offset * ratio;
    for (const auto& [column, factor] : leader.columns) {
      const auto same = std::find_if(sum.columns.begin(), sum.columns.end(),
                                     [&, wanted = column](const auto& entry) { return entry.first == wanted; });
      if (same == sum.columns.end())
        sum.columns.emplace_back(column, factor * ratio);
      else
        same->second += factor * ratio;
    }
  }
  static void follow(JointVariable& variable, IndependentSum root) {
    variable.follows = std::move(root.columns);
    variable.offset = std::move(root.offset);
  }

  /// From one end of a joint to the other.
  FramePoint cross_joint(const JointOf<Expression>& joint, int index, const FramePoint& from, bool forward) {
    std::vector<JointStep> steps = steps_of(joint);
    FramePoint at = forward ? from : frames_.rotate(from, reverse_rotations(decompose_rotation(joint.rotation)));
    if (!forward) std::reverse(steps.begin(), steps.end());
    for (const JointStep& step : steps) {
      const int variable = variable_[first_coordinate(index) + static_cast<std::size_t>(step.coordinate)];
      if (step.rises && !forward) at = offset_point(at, numbers_.wheel_centre_offset(index), -1);
      at = frames_.apply_joint(at, step.direction, variable, forward ? 1 : -1);
      if (step.rises && forward) at = offset_point(at, numbers_.wheel_centre_offset(index), 1);
    }
    return forward ? frames_.rotate(at, decompose_rotation(joint.rotation)) : at;
  }

  void add_edge(const TreeEdge& edge) {
    const JointOf<Expression>& at = joint(edge.joint);
    const Vector p = numbers_.joint_point(edge.joint, true), q = numbers_.joint_point(edge.joint, false);
    const FramePoint start = offset_point(body(edge.parent), edge.forward ? p : q, 1);
    const FramePoint end = offset_point(cross_joint(at, edge.joint, start, edge.forward), edge.forward ? q : p, -1);
    if (edge.split)
      tree_.closures.push_back({at.name, JointType::fixed, end, body(edge.forward ? at.second : at.first)});
    else
      body(edge.child) = end;
  }

  /// Axes of both frames as the closure's equations want them: planar slides along x, in space the axis is z.
  std::vector<FixedRotation> closure_rotations(const JointOf<Expression>& at) const {
    const bool slides = at.type == JointType::prismatic || at.type == JointType::pin_slot;
    if (tree_.is_planar && !slides) return {};
    Matrix3E axes = Matrix3E::Identity();
    if (tree_.is_planar) {
      axes(0, 0) = axes(1, 1) = at.axis.x();
      axes(1, 0) = at.axis.y(), axes(0, 1) = -at.axis.y();
      return decompose_rotation(axes);
    }
    if (at.type == JointType::spherical || at.type == JointType::fixed) return {};
    if (at.type == JointType::universal || at.type == JointType::planar) {
      axes << at.axis2, at.axis.cross(at.axis2), at.axis;
      return decompose_rotation(axes);
    }
    if (!is_constant(at.axis))
      return {{2, atan2(at.axis.y(), at.axis.x())},
              {1, atan2(sqrt(at.axis.x() * at.axis.x() + at.axis.y() * at.axis.y()), at.axis.z())}};
    const Matrix3 R = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), to_values(at.axis)).toRotationMatrix();
    return decompose_rotation(Matrix3E(R.cast<Expression>()));
  }

  void add_closure(int index) {
    const JointOf<Expression>& at = joint(index);
    FramePoint a = offset_point(body(at.first), numbers_.joint_point(index, true), 1);
    FramePoint b = offset_point(body(at.second), numbers_.joint_point(index, false), 1);
    b = frames_.rotate(b, reverse_rotations(decompose_rotation(at.rotation)));
    const std::vector<FixedRotation> turns = closure_rotations(at);
    a = frames_.rotate(a, turns), b = frames_.rotate(b, turns);
    tree_.closures.push_back({at.name, at.type, a, b});
    const bool straight = is_constant(at.rotation) && to_values(at.rotation).isIdentity(0);
    if (tree_.is_planar && at.type == JointType::revolute && straight) add_angle_relation(index, a.frame, b.frame);
  }

  /// The angle of a loop's joint is the sum of the angles around the loop.
  void add_angle_relation(int index, int a, int b) {
    AngleRelation relation;
    for (const auto& [end, sign] : {std::pair{b, 1}, std::pair{a, -1}})
      for (int at = end; at > 0; at = tree_.frames[static_cast<std::size_t>(at)].parent) {
        const SymbolicFrame& frame = tree_.frames[static_cast<std::size_t>(at)];
        if (frame.axes != std::array<int, 3>{0, 1, 2}) return;
        if (frame.angle >= 0) relation.multiples[frame.angle] += sign * frame.sign;
      }
    std::erase_if(relation.multiples, [](const auto& entry) { return entry.second == 0; });
    if (relation.multiples.empty()) return;
    const int run = ring_.angle(relation.multiples.begin()->first).group;
    relation.angle = ring_.add_angle(numbers_.coordinate_name(static_cast<int>(first_coordinate(index))), run);
    tree_.relations.push_back(relation);
  }

  void add_mass(const FramePoint& place, const Mass& mass) {
    tree_.frames[static_cast<std::size_t>(place.frame)].mass += shift_origin(mass, place.at);
  }

  void add_masses() {
    for (std::size_t b = 1; b < bodies_.size(); ++b) add_mass(bodies_[b], numbers_.body(static_cast<int>(b)));
    for (std::size_t k = 0; k < mechanism_.attachments.size(); ++k)
      add_mass(body(mechanism_.attachments[k].body), numbers_.attachment(static_cast<int>(k)));
  }

  void add_disc(int index) {
    const Disc& disc = mechanism_.discs[static_cast<std::size_t>(index)];
    const FramePoint centre = offset_point(body(disc.body), numbers_.disc_position(index), 1);
    const int variable = frames_.add_variable("phi_" + identifier_name(disc.name), true);
    const Polynomial ratio = numbers_.ratio(index);
    IndependentSum sum;
    for (std::size_t t = 0; t < disc.follows.terms.size(); ++t)
      add(sum, roots(disc.follows.terms[t].coordinate, 0), ratio * numbers_.disc_term(index, t));
    follow(tree_.variables.back(), std::move(sum));
    const Vector3E& axis = model_->mechanism().discs[static_cast<std::size_t>(index)].axis;
    if (!numbers_.is_rotor(index))
      return add_mass(frames_.apply_joint(centre, axis, variable, 1), numbers_.disc(index));
    // its moments of inertia are those along and across its axis, which may be oblique to its carrier
    const Alignment along = find_alignment(axis);
    add_mass(frames_.apply_aligned_joint(centre, along, variable, 1), numbers_.rotor(index, along.axis));
  }

  void add_spring(std::size_t s) {
    const Spring& spring = mechanism_.springs[s];
    LinearSpring found;
    found.a = offset_point(body(spring.first), numbers_.spring_point(s, true), 1);
    found.b = offset_point(body(spring.second), numbers_.spring_point(s, false), 1);
    found.stiffness = numbers_.stiffness(s), found.free_length = numbers_.free_length(s);
    if (!found.free_length.is_zero())
      found.length = ring_.add_symbol("L_" + identifier_name(spring.name), SymbolKind::alias, 1);
    tree_.springs.push_back(found);
  }

  void add_joint_spring(std::size_t s) {
    const Spring& spring = mechanism_.springs[s];
    const int variable = variable_[static_cast<std::size_t>(spring.coordinate)];
    if (variable < 0) throw FormulaError("spring " + spring.name + " is in a joint that closes a loop");
    const JointVariable& moving = tree_.variables[static_cast<std::size_t>(variable)];
    const int symbol = moving.is_angle ? ring_.symbol_of_angle(moving.index) : moving.index;
    tree_.joint_springs.push_back({variable, symbol, numbers_.stiffness(s), numbers_.preload(s)});
  }

  Ring& ring_;
  const Mechanism& mechanism_;
  std::shared_ptr<const ParametricModel> model_;
  SymbolicTree tree_;
  MechanismSymbols numbers_;
  FrameBuilder frames_;
  SpanningTree edges_;
  std::vector<FramePoint> bodies_;
  std::map<int, IndependentSum> roots_;
  std::vector<int> variable_;  ///< per coordinate; −1: of a joint that closes a loop
  bool natural_;
};

}  // namespace

SymbolicTree build_symbolic_tree(Ring& ring, const Mechanism& mechanism, const SpecNumberTexts& texts,
                                 const TreeOptions& options) {
  return SymbolicTreeBuilder(ring, mechanism, texts, options).build();
}

}  // namespace balance::formulas
