#include "balance/formulas/basic_tree.hpp"

#include "balance/formulas/mechanism_numbers.hpp"
#include "balance/natural/basic_points.hpp"

#include <cmath>

namespace balance::formulas {

namespace {

constexpr double one_place = 1e-12;  // in characteristic lengths: as the second formulation has it

class BasicBuilder {
 public:
  BasicBuilder(Ring& ring, const Mechanism& mechanism, MechanismNumbers& numbers)
      : ring_(ring), mechanism_(mechanism), numbers_(numbers), chosen_(natural::choose_points(mechanism)) {}

  BasicTree build() {
    tree_.moving = chosen_.moving;
    tree_.names = chosen_.names;
    for (const natural::Complex place : chosen_.fixed) tree_.fixed.push_back(*joint_place(ground, place));
    for (std::size_t b = 0; b < chosen_.bodies.size(); ++b) tree_.bodies.push_back(body(static_cast<int>(b)));
    for (const Joint& joint : mechanism_.joints)
      if (joint.type != JointType::revolute) add_joint(joint);
    return std::move(tree_);
  }

 private:
  /// Where a joint holds a body at this place; null if none does.
  std::optional<Vector> joint_place(int body, natural::Complex place) {
    for (const Joint& joint : mechanism_.joints) {
      if (joint.type != JointType::revolute && joint.type != JointType::fixed) continue;
      for (const auto& [owner, at] : {std::pair{joint.first, joint.point_first}, {joint.second, joint.point_second}})
        if (owner == body && std::abs(natural::planar(at, chosen_.length) - place) <= one_place)
          return numbers_.point(body, at);
    }
    return std::nullopt;
  }

  /// An auxiliary point lies a characteristic length along x from the body's only joint, or from its origin.
  Vector auxiliary_place(int body, natural::Complex place) {
    if (std::abs(place) <= one_place) return {};
    Vector at = joint_place(body, place - 1.0).value_or(Vector{});
    if (unit_ < 0) unit_ = ring_.add_symbol("e", SymbolKind::length, chosen_.length);
    at[0] += Polynomial::of_symbol(ring_, unit_);
    return at;
  }

  BasicBody body(int b) {
    BasicBody found;
    if (b == ground) return found;
    const natural::BodyPoints& points = chosen_.bodies[static_cast<std::size_t>(b)];
    found.triangle = points.triangle;
    for (const natural::BodyPoint& point : points.points) {
      const auto place = joint_place(b, point.place);
      found.points.push_back(point.point);
      found.places.push_back(place ? *place : auxiliary_place(b, point.place));
    }
    found.mass = numbers_.body(b);
    for (std::size_t k = 0; k < mechanism_.attachments.size(); ++k)
      if (mechanism_.attachments[k].body == b) found.mass += numbers_.attachment(static_cast<int>(k));
    for (std::size_t d = 0; d < mechanism_.discs.size(); ++d) {
      if (mechanism_.discs[d].body != b) continue;
      Mass disc = numbers_.disc(static_cast<int>(d));
      disc.inertia = {};  // it turns by itself
      found.mass += shifted(disc, numbers_.disc_place(static_cast<int>(d)));
    }
    return found;
  }

  Vector direction(const std::string& joint, const char* letter, double x, double y) {
    const auto number = [&](const char* axis, double value) -> Polynomial {
      if (value == std::round(value)) return {static_cast<int>(value)};
      return Polynomial::of_symbol(
          ring_, ring_.add_symbol(plain_name(letter + std::string(axis) + "_" + joint), SymbolKind::number, value));
    };
    return {number("x", x), number("y", y), {}};
  }

  void add_joint(const Joint& joint) {
    if (joint.type != JointType::fixed && joint.type != JointType::prismatic && joint.type != JointType::pin_slot)
      throw FormulaError("joint " + joint.name + " says nothing about points alone");
    BasicJoint found{joint.type, joint.first, joint.second, {}, {}, {}, {}};
    found.p = numbers_.point(joint.first, joint.point_first),
    found.q = numbers_.point(joint.second, joint.point_second);
    if (joint.type != JointType::fixed) found.axis = direction(joint.name, "u", joint.axis.x(), joint.axis.y());
    if (joint.type != JointType::pin_slot)
      found.turn = direction(joint.name, "r", joint.rotation(0, 0), joint.rotation(1, 0));
    tree_.joints.push_back(std::move(found));
  }

  Ring& ring_;
  const Mechanism& mechanism_;
  MechanismNumbers& numbers_;
  natural::BasicPoints chosen_;
  BasicTree tree_;
  int unit_ = -1;
};

}  // namespace

BasicTree basic_tree(Ring& ring, const Mechanism& mechanism, MechanismNumbers& numbers) {
  if (mechanism.space != SpaceKind::planar) throw FormulaError("natural coordinates are for planar mechanisms");
  return BasicBuilder(ring, mechanism, numbers).build();
}

}  // namespace balance::formulas
