#include "balance/formulas/symbolic_tree.hpp"

#include "balance/formulas/frame_builder.hpp"
#include "balance/formulas/mechanism_numbers.hpp"
#include "balance/model/spanning_tree.hpp"

#include <algorithm>
#include <map>

namespace balance::formulas {

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
