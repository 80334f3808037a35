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
  Vector3 direction;
  int coordinate;      ///< within the joint
  bool rises = false;  ///< then up by the radius of what rolls
};

std::vector<JointStep> steps_of(const Joint& joint) {
  const Vector3 &u = joint.axis, &v = joint.axis2;
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
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

class TreeBuilder {
 public:
  TreeBuilder(Ring& ring, const Mechanism& mechanism, const SpecTexts& texts, const TreeOptions& options)
      : ring_(ring),
        mechanism_(mechanism),
        numbers_(ring, mechanism, texts, options),
        frames_(ring, tree_),
        edges_(span(mechanism, {})),
        natural_(options.natural) {
    tree_.planar = mechanism.space == SpaceKind::planar;
    bodies_.resize(mechanism.bodies.size());
    bodies_[0] = {0, {}};
  }

  SymbolicTree build() {
    add_variables();
    for (const TreeEdge& edge : edges_.edges) walk(edge);
    for (const int joint : edges_.cut) cut(joint);
    add_masses();
    for (std::size_t d = 0; d < mechanism_.discs.size(); ++d) add_disc(static_cast<int>(d));
    for (std::size_t s = 0; s < mechanism_.springs.size(); ++s)
      mechanism_.springs[s].in_joint() ? add_joint_spring(s) : add_spring(s);
    tree_.gravity = numbers_.gravity();
    tree_.inertial = numbers_.inertial();
    if (natural_) tree_.basic = basic_tree(ring_, mechanism_, numbers_);
    if (!mechanism_.friction.empty()) tree_.left_out.emplace_back("friction");
    if (!mechanism_.loads.empty()) tree_.left_out.emplace_back("loads");
    return std::move(tree_);
  }

 private:
  std::size_t first_coordinate(int joint) const {
    const auto& all = mechanism_.coordinates;
    const auto at = std::find_if(all.begin(), all.end(), [&](const Coordinate& c) { return c.joint == joint; });
    return static_cast<std::size_t>(at - all.begin());
  }
  const Joint& joint(int index) const { return mechanism_.joints[static_cast<std::size_t>(index)]; }
  Place& body(int index) { return bodies_[static_cast<std::size_t>(index)]; }
  static Place beside(Place place, const Vector& d, int sign) {
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

  struct Root {
    std::vector<std::pair<int, Polynomial>> columns;
    double offset = 0;
  };
  /// What a coordinate is made of; each is made out once, since sums of sums meet again and again.
  const Root& roots(int coordinate, std::size_t depth) {
    const auto known = roots_.find(coordinate);
    if (known != roots_.end()) return known->second;
    return roots_[coordinate] = find_roots(coordinate, depth);
  }
  Root find_roots(int coordinate, std::size_t depth) {
    if (depth > mechanism_.couplings.size()) throw FormulaError("couplings follow each other in a circle");
    for (std::size_t k = 0; k < mechanism_.couplings.size(); ++k) {
      const Coupling& coupling = mechanism_.couplings[k];
      if (coupling.follower != coordinate) continue;
      Root sum;
      for (const CoordinateTerm& term : coupling.leader.terms)
        add(sum, roots(term.coordinate, depth + 1), numbers_.coupling_ratio(k) * numbers_.coupling_term(k, term),
            coupling.ratio * term.ratio);
      sum.offset += coupling.offset;
      return sum;
    }
    const auto column = std::find(tree_.coordinates.begin(), tree_.coordinates.end(), coordinate);
    return {{{static_cast<int>(column - tree_.coordinates.begin()), Polynomial(1)}}, 0};
  }
  /// Adds a multiple of what one of several leaders is made of.
  static void add(Root& sum, const Root& leader, const Polynomial& ratio, double value) {
    sum.offset += leader.offset * value;
    for (const auto& [column, factor] : leader.columns) {
      const auto same = std::find_if(sum.columns.begin(), sum.columns.end(),
                                     [&, wanted = column](const auto& entry) { return entry.first == wanted; });
      if (same == sum.columns.end())
        sum.columns.emplace_back(column, factor * ratio);
      else
        same->second += factor * ratio;
    }
  }
  static void follow(Variable& variable, Root root) {
    variable.follows = std::move(root.columns);
    variable.offset = root.offset;
  }

  /// From one end of a joint to the other.
  Place through(const Joint& joint, int index, const Place& from, bool forward) {
    std::vector<JointStep> steps = steps_of(joint);
    Place at = forward ? from : frames_.turned(from, reversed(turns_of(joint.rotation)));
    if (!forward) std::reverse(steps.begin(), steps.end());
    for (const JointStep& step : steps) {
      const int variable = variable_[first_coordinate(index) + static_cast<std::size_t>(step.coordinate)];
      if (step.rises && !forward) at = beside(at, numbers_.rise(index), -1);
      at = frames_.moved_by(at, step.direction, variable, forward ? 1 : -1);
      if (step.rises && forward) at = beside(at, numbers_.rise(index), 1);
    }
    return forward ? frames_.turned(at, turns_of(joint.rotation)) : at;
  }

  void walk(const TreeEdge& edge) {
    const Joint& at = joint(edge.joint);
    const Vector p = numbers_.point(at.first, at.point_first), q = numbers_.point(at.second, at.point_second);
    const Place start = beside(body(edge.parent), edge.forward ? p : q, 1);
    const Place end = beside(through(at, edge.joint, start, edge.forward), edge.forward ? q : p, -1);
    if (edge.split)
      tree_.closures.push_back({at.name, JointType::fixed, end, body(edge.forward ? at.second : at.first)});
    else
      body(edge.child) = end;
  }

  /// Axes of both frames as the closure's equations want them: planar slides along x, in space the axis is z.
  void cut(int index) {
    const Joint& at = joint(index);
    Place a = beside(body(at.first), numbers_.point(at.first, at.point_first), 1);
    Place b = beside(body(at.second), numbers_.point(at.second, at.point_second), 1);
    b = frames_.turned(b, reversed(turns_of(at.rotation)));
    Matrix3 axes = Matrix3::Identity();
    const bool slides = at.type == JointType::prismatic || at.type == JointType::pin_slot;
    if (tree_.planar) {
      if (slides) axes << at.axis.x(), -at.axis.y(), 0, at.axis.y(), at.axis.x(), 0, 0, 0, 1;
    } else if (at.type == JointType::universal || at.type == JointType::planar) {
      axes << at.axis2, at.axis.cross(at.axis2), at.axis;
    } else if (at.type != JointType::spherical && at.type != JointType::fixed) {
      axes = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), at.axis).toRotationMatrix();
    }
    const std::vector<FixedTurn> turns = turns_of(axes);
    a = frames_.turned(a, turns), b = frames_.turned(b, turns);
    tree_.closures.push_back({at.name, at.type, a, b});
    if (tree_.planar && at.type == JointType::revolute && at.rotation.isIdentity(0)) relate(index, a.frame, b.frame);
  }

  /// The angle of a loop's joint is the sum of the angles around the loop.
  void relate(int index, int a, int b) {
    Relation relation;
    for (const auto& [end, sign] : {std::pair{b, 1}, std::pair{a, -1}})
      for (int at = end; at > 0; at = tree_.frames[static_cast<std::size_t>(at)].parent) {
        const Frame& frame = tree_.frames[static_cast<std::size_t>(at)];
        if (frame.axes != std::array<int, 3>{0, 1, 2}) return;
        if (frame.angle >= 0) relation.multiples[frame.angle] += sign * frame.sign;
      }
    std::erase_if(relation.multiples, [](const auto& entry) { return entry.second == 0; });
    if (relation.multiples.empty()) return;
    const int run = ring_.angle(relation.multiples.begin()->first).run;
    relation.angle = ring_.add_angle(numbers_.coordinate_name(static_cast<int>(first_coordinate(index))), run);
    tree_.relations.push_back(relation);
  }

  void add_mass(const Place& place, const Mass& mass) {
    tree_.frames[static_cast<std::size_t>(place.frame)].mass += shifted(mass, place.at);
  }

  void add_masses() {
    for (std::size_t b = 1; b < bodies_.size(); ++b) add_mass(bodies_[b], numbers_.body(static_cast<int>(b)));
    for (std::size_t k = 0; k < mechanism_.attachments.size(); ++k)
      add_mass(body(mechanism_.attachments[k].body), numbers_.attachment(static_cast<int>(k)));
  }

  void add_disc(int index) {
    const Disc& disc = mechanism_.discs[static_cast<std::size_t>(index)];
    const Place centre = beside(body(disc.body), numbers_.disc_place(index), 1);
    const int variable = frames_.add_variable("phi_" + plain_name(disc.name), true);
    const Polynomial ratio = numbers_.ratio(index);
    Root sum;
    for (const CoordinateTerm& term : disc.follows.terms)
      add(sum, roots(term.coordinate, 0), ratio * numbers_.disc_term(index, term), disc.ratio * term.ratio);
    follow(tree_.variables.back(), std::move(sum));
    add_mass(frames_.moved_by(centre, disc.axis, variable, 1), numbers_.disc(index));
  }

  void add_spring(std::size_t s) {
    const Spring& spring = mechanism_.springs[s];
    LinearSpring found;
    found.a = beside(body(spring.first), numbers_.point(spring.first, spring.point_first), 1);
    found.b = beside(body(spring.second), numbers_.point(spring.second, spring.point_second), 1);
    found.stiffness = numbers_.stiffness(s), found.free_length = numbers_.free_length(s);
    if (!found.free_length.is_zero())
      found.length = ring_.add_symbol("L_" + plain_name(spring.name), SymbolKind::named, 1);
    tree_.springs.push_back(found);
  }

  void add_joint_spring(std::size_t s) {
    const Spring& spring = mechanism_.springs[s];
    const int variable = variable_[static_cast<std::size_t>(spring.coordinate)];
    if (variable < 0) throw FormulaError("spring " + spring.name + " is in a joint that closes a loop");
    const Variable& moving = tree_.variables[static_cast<std::size_t>(variable)];
    const int symbol = moving.is_angle ? ring_.symbol_of_angle(moving.index) : moving.index;
    tree_.joint_springs.push_back({variable, symbol, numbers_.stiffness(s), numbers_.preload(s)});
  }

  Ring& ring_;
  const Mechanism& mechanism_;
  SymbolicTree tree_;
  MechanismNumbers numbers_;
  FrameBuilder frames_;
  SpanningTree edges_;
  std::vector<Place> bodies_;
  std::map<int, Root> roots_;
  std::vector<int> variable_;  ///< per coordinate; −1: of a joint that closes a loop
  bool natural_;
};

}  // namespace

SymbolicTree symbolic_tree(Ring& ring, const Mechanism& mechanism, const SpecTexts& texts, const TreeOptions& options) {
  return TreeBuilder(ring, mechanism, texts, options).build();
}

}  // namespace balance::formulas
