#include "balance/synthesis/formulas/basic_point_model.hpp"

#include "balance/synthesis/formulas/mechanism_symbols.hpp"
#include "balance/synthesis/verification/natural_points.hpp"

#include <cmath>

namespace balance::formulas {

namespace {

constexpr double coincidence_tolerance = 1e-12;  // in characteristic lengths: as the second formulation has it

class BasicPointModelBuilder {
 public:
  BasicPointModelBuilder(Ring& ring, const Mechanism& mechanism, const ParametricModel& model,
                         MechanismSymbols& numbers)
      : ring_(ring),
        mechanism_(mechanism),
        model_(model),
        numbers_(numbers),
        chosen_(natural::choose_basic_points(mechanism)) {}

  BasicPointModel build() {
    tree_.moving = chosen_.moving;
    tree_.names = chosen_.names;
    for (const natural::Complex place : chosen_.fixed) tree_.fixed.push_back(*joint_position(ground, place));
    for (std::size_t b = 0; b < chosen_.bodies.size(); ++b) tree_.bodies.push_back(body(static_cast<int>(b)));
    for (std::size_t j = 0; j < mechanism_.joints.size(); ++j)
      if (mechanism_.joints[j].type != JointType::revolute) add_joint(static_cast<int>(j));
    return std::move(tree_);
  }

 private:
  /// Where a joint holds a body at this place; null if none does.
  std::optional<Vector> joint_position(int body, natural::Complex place) {
    for (std::size_t j = 0; j < mechanism_.joints.size(); ++j) {
      const Joint& joint = mechanism_.joints[j];
      if (joint.type != JointType::revolute && joint.type != JointType::fixed) continue;
      for (const bool first : {true, false}) {
        const Vector3& at = first ? joint.point_first : joint.point_second;
        const int owner = first ? joint.first : joint.second;
        if (owner == body && std::abs(natural::to_complex(at, chosen_.length) - place) <= coincidence_tolerance)
          return numbers_.joint_point(static_cast<int>(j), first);
      }
    }
    return std::nullopt;
  }

  /// An auxiliary point lies a characteristic length along x from the body's only joint, or from its origin.
  Vector auxiliary_position(int body, natural::Complex place) {
    if (std::abs(place) <= coincidence_tolerance) return {};
    Vector at = joint_position(body, place - 1.0).value_or(Vector{});
    if (tree_.length_symbol < 0) tree_.length_symbol = ring_.add_symbol("e", SymbolKind::length, chosen_.length);
    at[0] += Polynomial::of_symbol(ring_, tree_.length_symbol);
    return at;
  }

  BasicBody body(int b) {
    BasicBody found;
    if (b == ground) return found;
    const natural::BodyPoints& points = chosen_.bodies[static_cast<std::size_t>(b)];
    found.is_triangle = points.has_mass_triangle;
    for (const natural::BodyPoint& point : points.points) {
      const auto place = joint_position(b, point.position);
      found.points.push_back(point.point);
      found.positions.push_back(place ? *place : auxiliary_position(b, point.position));
    }
    found.mass = numbers_.body(b);
    for (std::size_t k = 0; k < mechanism_.attachments.size(); ++k)
      if (mechanism_.attachments[k].body == b) found.mass += numbers_.attachment(static_cast<int>(k));
    for (std::size_t d = 0; d < mechanism_.discs.size(); ++d) {
      if (mechanism_.discs[d].body != b) continue;
      Mass disc = numbers_.disc(static_cast<int>(d));
      disc.inertia = {};  // it turns by itself
      found.mass += shift_origin(disc, numbers_.disc_position(static_cast<int>(d)));
    }
    return found;
  }

  Vector direction(const std::string& joint, const char* letter, const Expression& x, const Expression& y) {
    const auto number = [&](const char* axis, const Expression& value) -> Polynomial {
      const double whole = std::round(value.value());
      if (value.is_constant() && value.value() == whole) return {static_cast<int>(whole)};
      return Polynomial::of_symbol(ring_, ring_.add_symbol(identifier_name(letter + std::string(axis) + "_" + joint),
                                                           SymbolKind::dimensionless, value));
    };
    return {number("x", x), number("y", y), {}};
  }

  void add_joint(int index) {
    const JointOf<Expression>& joint = model_.mechanism().joints[static_cast<std::size_t>(index)];
    if (joint.type != JointType::fixed && joint.type != JointType::prismatic && joint.type != JointType::pin_slot)
      throw FormulaError("joint " + joint.name + " says nothing about points alone");
    BasicJoint found{joint.type, joint.first, joint.second, {}, {}, {}, {}};
    found.p = numbers_.joint_point(index, true), found.q = numbers_.joint_point(index, false);
    if (joint.type != JointType::fixed) found.axis = direction(joint.name, "u", joint.axis.x(), joint.axis.y());
    if (joint.type != JointType::pin_slot)
      found.rotation = direction(joint.name, "r", joint.rotation(0, 0), joint.rotation(1, 0));
    tree_.joints.push_back(std::move(found));
  }

  Ring& ring_;
  const Mechanism& mechanism_;
  const ParametricModel& model_;
  MechanismSymbols& numbers_;
  natural::BasicPoints chosen_;
  BasicPointModel tree_;
};

}  // namespace

BasicPointModel build_basic_point_model(Ring& ring, const Mechanism& mechanism, const ParametricModel& model,
                                        MechanismSymbols& numbers) {
  if (mechanism.space != SpaceKind::planar) throw FormulaError("natural coordinates are for planar mechanisms");
  return BasicPointModelBuilder(ring, mechanism, model, numbers).build();
}

}  // namespace balance::formulas
