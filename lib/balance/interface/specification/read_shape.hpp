#pragma once
/// `shape: {cylinder: {diameter: 0.1, thickness: 0.02, material: steel}}`: homogeneous solids that have a mass, a centre
/// and an inertia.

#include "balance/interface/specification/study_builder.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::specification {

/// A material with its density at room temperature.
struct Material {
  const char* name;
  double density;  ///< [kg/m^3]
};
/// The materials that every spec knows: typical values of handbooks.
const std::vector<Material>& list_materials();

/// A solid with its mass properties.
struct SolidE {
  model::ShapeOf<Expression> shape;
  Expression mass;
  Vector3E centre = Vector3E::Zero();   ///< of mass, from the solid's place; only of a sector not zero
  Matrix3E inertia = Matrix3E::Zero();  ///< about its centre of mass, in the axes of the body that carries it
};

/// `materials: {name: density}`: adds to the materials of the spec, or replaces one.
void read_materials(const SpecCursor& section, StudyBuilder& draft);

/// @param sizes of the solid that a catalogue gives, by key; these keys must then be missing
SolidE read_shape(const SpecCursor& at, StudyBuilder& draft,
                  const std::vector<std::pair<std::string, Expression>>& sizes = {});

}  // namespace balance::specification
