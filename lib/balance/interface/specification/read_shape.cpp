#include "balance/interface/specification/read_shape.hpp"

#include "balance/foundation/base/spelling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numbers>

namespace balance::specification {

// Mass m, moments of inertia about the centre of mass and its place, for the density ρ. With D, d the diameters, R, r
// their halves, t the thickness and φ the opening of a sector:
//
// | solid    | m                  | I_z                 | I_x, I_y                                             |
// | cylinder | ρ π/4 D² t         | m D²/8              | m (D²/16 + t²/12)                                    |
// | ring     | ρ π/4 (D² − d²) t  | m (D² + d²)/8       | m ((D² + d²)/16 + t²/12)                             |
// | plate    | ρ l w t            | m (l² + w²)/12      | m (w² + t²)/12, m (l² + t²)/12                       |
// | sector   | ρ t φ/2 (R² − r²)  | A₊ + A₋ − m c²      | A₋ + m t²/12, A₊ − m c² + m t²/12                    |
//
// with A± = ρ t (R⁴ − r⁴)/8 (φ ± sin φ), the moments about the arcs' axis, and the distance of the centre of mass
// c = 4 sin(φ/2)/(3 φ) (R² + R r + r²)/(R + r).

const std::vector<Material>& list_materials() {
  static const std::vector<Material> materials{{"steel", 7850},     {"stainless-steel", 7930},
                                               {"cast-iron", 7200}, {"aluminium", 2700},
                                               {"brass", 8500},     {"bronze", 8800},
                                               {"copper", 8960},    {"lead", 11340},
                                               {"tungsten", 19250}, {"tungsten-alloy", 17000},
                                               {"titanium", 4510},  {"zinc", 7140},
                                               {"magnesium", 1740}, {"concrete", 2400},
                                               {"acrylic", 1190},   {"polyamide", 1140},
                                               {"pom", 1410},       {"abs", 1050},
                                               {"pla", 1240}};
  return materials;
}

void read_materials(const SpecCursor& section, StudyBuilder& draft) {
  const Dimension density = dimension::mass / (dimension::length * dimension::length * dimension::length);
  for (const Member& member :
       list_named_members(section, "a mapping of materials to their densities", NameForm::simple))
    draft.problems.collect(
        [&] { draft.materials[member.name] = read_number(member.value, draft, density, SignConstraint::positive); });
}

namespace {

constexpr Dimension density_dimension = dimension::mass / (dimension::length * dimension::length * dimension::length);

Expression find_density(const SpecCursor& at, const StudyBuilder& draft) {
  const std::string& name = at.read_word("a material");
  if (const auto own = draft.materials.find(name); own != draft.materials.end()) return own->second;
  std::vector<std::string> names;
  for (const auto& [own, density] : draft.materials) names.push_back(own);
  for (const Material& material : list_materials()) {
    if (name == material.name) return material.density;
    names.emplace_back(material.name);
  }
  if (draft.problems.is_uncertain("materials." + name)) throw CascadingError();
  at.fail({.expected = fmt::format("a material ({}), or one of 'materials'", join_alternatives(names)),
           .found = quote_for_message(name),
           .hint = format_nearest_name(name, names)});
}

/// Keys of one kind of solid.
struct ShapeKeys {
  std::map<std::string, SpecCursor> sizes;
  std::optional<SpecCursor> material, density, axis, direction;
};

class ShapeReader {
 public:
  ShapeReader(const SpecCursor& at, StudyBuilder& draft, const std::vector<std::pair<std::string, Expression>>& sizes)
      : at_(at), draft_(draft), catalogue_sizes_(sizes) {}

  SolidE read(model::ShapeKind kind, const std::vector<std::string>& sizes) {
    model::ShapeOf<Expression>& shape = solid_.shape;
    shape.kind = kind;
    read_keys(kind, sizes);
    if (kind == model::ShapeKind::plate) {
      shape.length = size("length"), shape.width = size("width");
    } else {
      shape.diameter = size("diameter");
      if (kind != model::ShapeKind::cylinder) shape.inner_diameter = size("inner_diameter", true);
    }
    shape.thickness = size("thickness");
    if (kind == model::ShapeKind::sector) read_opening();
    if (shape.inner_diameter.value() > shape.diameter.value())
      at_.fail({.expected = "an 'inner_diameter' of at most the 'diameter'",
                .found = fmt::format("{:.6g} m and {:.6g} m", shape.inner_diameter.value(), shape.diameter.value())});
    read_rotation();
    compute_mass(read_density());
    return std::move(solid_);
  }

 private:
  void read_keys(model::ShapeKind kind, const std::vector<std::string>& sizes) {
    std::vector<Field> fields;
    for (const std::string& name : sizes) {
      const bool is_given = find_catalogue_size(name) != nullptr;
      const bool is_optional = is_given || name == "inner_diameter";
      fields.push_back({name, is_optional ? Presence::optional : Presence::required,
                        [this, name](const SpecCursor& c) { keys_.sizes.emplace(name, c); }});
    }
    const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
    fields.push_back({"material", Presence::optional, store_in(keys_.material)});
    fields.push_back({"density", Presence::optional, store_in(keys_.density)});
    if (!draft_.planar()) fields.push_back({"axis", Presence::optional, store_in(keys_.axis)});
    if (kind == model::ShapeKind::plate || kind == model::ShapeKind::sector)
      fields.push_back({"direction", Presence::optional, store_in(keys_.direction)});
    std::string names;
    for (const std::string& name : sizes) names += name + ", ";
    if (!read_fields(at_, "a solid {" + names + "material}", fields)) throw CascadingError();
    if (keys_.material.has_value() == keys_.density.has_value())
      at_.fail({.message = fmt::format("expected one of: 'material', 'density'; found {}",
                                       keys_.material ? "both" : "neither"),
                .expected = "one of: 'material', 'density'",
                .found = keys_.material ? "both" : "neither"});
  }

  const Expression* find_catalogue_size(const std::string& name) const {
    for (const auto& [key, value] : catalogue_sizes_)
      if (key == name) return &value;
    return nullptr;
  }

  Expression size(const std::string& name, bool is_optional = false) {
    const auto key = keys_.sizes.find(name);
    if (const Expression* given = find_catalogue_size(name)) {
      if (key != keys_.sizes.end())
        key->second.fail(
            {.expected = fmt::format("{} from the catalogue or as a key", quote_for_message(name)), .found = "both"});
      return *given;
    }
    if (key == keys_.sizes.end() && is_optional) return 0;
    return read_number(key->second, draft_, dimension::length, SignConstraint::not_negative);
  }

  void read_opening() {
    const SpecCursor& at = keys_.sizes.at("opening");
    solid_.shape.opening = read_number(at, draft_, dimension::angle, SignConstraint::positive);
    if (solid_.shape.opening.value() > 2 * std::numbers::pi * (1 + 1e-12))
      at.fail(
          {.expected = "an angle of at most a turn", .found = fmt::format("{:.6g} rad", solid_.shape.opening.value())});
  }

  void read_rotation() {
    Vector3E z(0, 0, 1), x(1, 0, 0);
    if (keys_.axis) z = read_direction(*keys_.axis, draft_);
    if (keys_.direction) {
      x = read_direction(*keys_.direction, draft_);
      const Vector3 across = values_of(Vector3E(z.cross(x)));
      if (across.norm() < 1e-9) keys_.direction->fail({.expected = "a direction other than that of the axis"});
    } else if (std::abs(x.dot(z).value()) > 0.9) {
      x = Vector3E(0, 1, 0);
    }
    const Vector3E y = normalized(z.cross(x));
    solid_.shape.rotation.col(0) = y.cross(z);
    solid_.shape.rotation.col(1) = y;
    solid_.shape.rotation.col(2) = z;
  }

  Expression read_density() {
    if (keys_.material) return find_density(*keys_.material, draft_);
    return read_number(*keys_.density, draft_, density_dimension, SignConstraint::positive);
  }

  void compute_mass(const Expression& density) {
    const model::ShapeOf<Expression>& s = solid_.shape;
    const Expression t = s.thickness, flat = t * t / 12;
    Expression &m = solid_.mass, moment[3]{0, 0, 0};
    switch (s.kind) {
      case model::ShapeKind::cylinder:
      case model::ShapeKind::ring: {
        const Expression D2 = s.diameter * s.diameter, d2 = s.inner_diameter * s.inner_diameter;
        m = density * (std::numbers::pi / 4) * (D2 - d2) * t;
        moment[2] = m * (D2 + d2) / 8;
        moment[0] = moment[1] = m * ((D2 + d2) / 16 + flat);
        break;
      }
      case model::ShapeKind::plate: {
        const Expression l2 = s.length * s.length / 12, w2 = s.width * s.width / 12;
        m = density * s.length * s.width * t;
        moment[0] = m * (w2 + flat), moment[1] = m * (l2 + flat), moment[2] = m * (l2 + w2);
        break;
      }
      case model::ShapeKind::sector: {
        const Expression R = s.diameter / 2, r = s.inner_diameter / 2, phi = s.opening;
        const Expression difference = R * R - r * r, sum = R * R + r * r;
        m = density * t * phi / 2 * difference;
        const Expression factor = density * t * difference * sum / 8;
        const Expression along = factor * (phi + sin(phi)), across = factor * (phi - sin(phi));
        // no sector of zero size divides by zero
        const Expression size = expression::select(expression::equal(R + r, 0), 1, R + r);
        const Expression c = 4 * sin(phi / 2) / (3 * phi) * (R * R + R * r + r * r) / size;
        solid_.shape.axis_distance = c;
        solid_.centre = c * solid_.shape.rotation.col(0);
        moment[0] = across + m * flat, moment[1] = along - m * c * c + m * flat;
        moment[2] = along + across - m * c * c;
        break;
      }
    }
    if (draft_.planar()) {
      solid_.inertia(2, 2) = moment[2];
      return;
    }
    for (int k = 0; k < 3; ++k) {
      const Vector3E axis = s.rotation.col(k);
      solid_.inertia += moment[k] * (axis * axis.transpose());
    }
  }

  const SpecCursor& at_;
  StudyBuilder& draft_;
  const std::vector<std::pair<std::string, Expression>>& catalogue_sizes_;
  ShapeKeys keys_;
  SolidE solid_;
};

}  // namespace

SolidE read_shape(const SpecCursor& at, StudyBuilder& draft,
                  const std::vector<std::pair<std::string, Expression>>& sizes) {
  struct Kind {
    const char* name;
    model::ShapeKind kind;
    std::vector<std::string> sizes;
  };
  static const std::vector<Kind> kinds{
      {"cylinder", model::ShapeKind::cylinder, {"diameter", "thickness"}},
      {"ring", model::ShapeKind::ring, {"diameter", "inner_diameter", "thickness"}},
      {"sector", model::ShapeKind::sector, {"diameter", "inner_diameter", "thickness", "opening"}},
      {"plate", model::ShapeKind::plate, {"length", "width", "thickness"}}};
  std::optional<SolidE> solid;
  std::vector<Field> fields;
  for (const Kind& kind : kinds)
    fields.push_back({kind.name, Presence::optional, [&](const SpecCursor& c) {
                        if (solid) c.fail({.expected = "one solid", .found = "several"});
                        solid = ShapeReader(c, draft, sizes).read(kind.kind, kind.sizes);
                      }});
  if (!read_fields(at, "a shape {cylinder, ring, sector or plate}", fields)) throw CascadingError();
  if (!solid) at.fail_missing({"cylinder", "ring", "sector", "plate"});
  return *solid;
}

}  // namespace balance::specification
