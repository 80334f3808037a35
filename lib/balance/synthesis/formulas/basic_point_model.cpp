#include "balance/synthesis/formulas/basic_point_model.hpp"

#include "balance/synthesis/formulas/mechanism_symbols.hpp"
#include "balance/synthesis/verification/natural_points.hpp"

#include <cmath>

namespace balance::formulas {

namespace {

constexpr double coincidence_tolerance = 1e-12;  // in characteristic lengths, as in the second formulation

class BasicPointModelBuilder {
 public:
  BasicPointModelBuilder(Ring& ring, const Mechanism& mechanism, const ParametricModel& model,
                         MechanismSymbols& symbols)
      : ring_(ring),
        mechanism_(mechanism),
        model_(model),
        symbols_(symbols),
        basic_points_(verification::natural::choose_basic_points(mechanism)) {}

  BasicPointModel build() {
    point_model_.moving = basic_points_.moving;
    point_model_.names = basic_points_.names;
    for (const verification::natural::Complex position : basic_points_.fixed)
      point_model_.fixed.push_back(*joint_position(model::ground, position));
    for (std::size_t b = 0; b < basic_points_.bodies.size(); ++b)
      point_model_.bodies.push_back(body(static_cast<int>(b)));
    for (std::size_t j = 0; j < mechanism_.joints.size(); ++j)
      if (mechanism_.joints[j].type != JointType::revolute) add_joint(static_cast<int>(j));
    return std::move(point_model_);
  }

 private:
  /// Position of the joint that holds a body at this place; std::nullopt if none does.
  std::optional<Vector> joint_position(int body, verification::natural::Complex position) {
    for (std::size_t j = 0; j < mechanism_.joints.size(); ++j) {
      const Joint& joint = mechanism_.joints[j];
      if (joint.type != JointType::revolute && joint.type != JointType::fixed) continue;
      for (const bool first : {true, false}) {
        const Vector3& point = first ? joint.point_first : joint.point_second;
        const int owner = first ? joint.first : joint.second;
        if (owner == body && std::abs(verification::natural::to_complex(point, basic_points_.length) - position) <=
                                 coincidence_tolerance)
          return symbols_.joint_point(static_cast<int>(j), first);
      }
    }
    return std::nullopt;
  }

  /// An auxiliary point is one characteristic length along x away from the body's only joint, or from its origin.
  Vector auxiliary_position(int body, verification::natural::Complex position) {
    if (std::abs(position) <= coincidence_tolerance) return {};
    Vector auxiliary = joint_position(body, position - 1.0).value_or(Vector{});
    if (point_model_.length_symbol < 0)
      point_model_.length_symbol = ring_.add_symbol("e", SymbolKind::length, basic_points_.length);
    auxiliary[0] += Polynomial::of_symbol(ring_, point_model_.length_symbol);
    return auxiliary;
  }

  BasicBody body(int b) {
    BasicBody basic_body;
    if (b == model::ground) return basic_body;
    const verification::natural::BodyPoints& points = basic_points_.bodies[static_cast<std::size_t>(b)];
    basic_body.is_triangle = points.has_mass_triangle;
    for (const verification::natural::BodyPoint& point : points.points) {
      const auto at_joint = joint_position(b, point.position);
      basic_body.points.push_back(point.point);
      basic_body.positions.push_back(at_joint ? *at_joint : auxiliary_position(b, point.position));
    }
    basic_body.mass = symbols_.body(b);
    for (std::size_t k = 0; k < mechanism_.attachments.size(); ++k)
      if (mechanism_.attachments[k].body == b) basic_body.mass += symbols_.attachment(static_cast<int>(k));
    for (std::size_t d = 0; d < mechanism_.discs.size(); ++d) {
      if (mechanism_.discs[d].body != b) continue;
      Mass disc = symbols_.disc(static_cast<int>(d));
      disc.inertia = {};  // its rotation does not depend on the body's
      basic_body.mass += shift_origin(disc, symbols_.disc_position(static_cast<int>(d)));
    }
    return basic_body;
  }

  Vector direction(const std::string& joint, const char* letter, const Expression& x, const Expression& y) {
    const auto component = [&](const char* axis, const Expression& value) -> Polynomial {
      const double rounded = std::round(value.value());
      if (value.is_constant() && value.value() == rounded) return {static_cast<int>(rounded)};
      return Polynomial::of_symbol(ring_, ring_.add_symbol(identifier_name(letter + std::string(axis) + "_" + joint),
                                                           SymbolKind::dimensionless, value));
    };
    return {component("x", x), component("y", y), {}};
  }

  void add_joint(int index) {
    const model::JointOf<Expression>& joint = model_.mechanism().joints[static_cast<std::size_t>(index)];
    if (joint.type == JointType::planar) return;
    if (joint.type != JointType::fixed && joint.type != JointType::prismatic && joint.type != JointType::pin_slot)
      throw FormulaError("joint " + joint.name + " does not constrain points alone");
    BasicJoint basic_joint{joint.type, joint.first, joint.second, {}, {}, {}, {}};
    basic_joint.p = symbols_.joint_point(index, true), basic_joint.q = symbols_.joint_point(index, false);
    if (joint.type != JointType::fixed) basic_joint.axis = direction(joint.name, "u", joint.axis.x(), joint.axis.y());
    if (joint.type != JointType::pin_slot)
      basic_joint.rotation = direction(joint.name, "r", joint.rotation(0, 0), joint.rotation(1, 0));
    point_model_.joints.push_back(std::move(basic_joint));
  }

  Ring& ring_;
  const Mechanism& mechanism_;
  const ParametricModel& model_;
  MechanismSymbols& symbols_;
  verification::natural::BasicPoints basic_points_;
  BasicPointModel point_model_;
};

}  // namespace

BasicPointModel build_basic_point_model(Ring& ring, const Mechanism& mechanism, const ParametricModel& model,
                                        MechanismSymbols& symbols) {
  if (mechanism.space != SpaceKind::planar) throw FormulaError("natural coordinates are for planar mechanisms");
  return BasicPointModelBuilder(ring, mechanism, model, symbols).build();
}

}  // namespace balance::formulas
