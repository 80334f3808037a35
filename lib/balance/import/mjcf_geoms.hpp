#pragma once
/// Masses that follow from shapes, as MuJoCo computes them: solid bodies of a density. Private to the reader of MJCF.

#include "balance/import/mjcf_source.hpp"

#include <string>

namespace balance::foreign {

/// Of all geoms of a body, about their common centre of mass, in the body's axes.
struct GeomInertia {
  int geoms = 0;  ///< that have mass
  double mass = 0;
  Vector3 com = Vector3::Zero();
  Matrix3 inertia = Matrix3::Zero();
  std::string unsupported_shape;  ///< what cannot be weighed: "a mesh"; empty: nothing
};

class MjcfGeomInertia {
 public:
  /// @param root of the document, for `<compiler>`
  MjcfGeomInertia(const XmlElement& root, const XmlAttributeReader& read, const MjcfDefaults& defaults,
                  const MjcfCompilerAngles& angles);

  /// `inertiafromgeom`: whether geoms hold even where there is an `<inertial>`, and whether they are asked at all.
  bool overrides_inertial() const { return rule_ == "true"; }
  bool is_used() const { return rule_ != "false"; }

  /// @param body element, with frames in it
  /// @param child_class that holds in it
  GeomInertia compute(const XmlElement& body, const std::string& child_class) const;

 private:
  struct Sum;
  void add_all(const XmlElement& parent, const Pose& frame, const std::string& child_class, Sum& sum) const;
  void add(const XmlElement& geom, const Pose& frame, Sum& sum) const;

  const XmlAttributeReader& read_;
  const MjcfDefaults& defaults_;
  const MjcfCompilerAngles& angles_;
  std::string rule_ = "auto";
  double first_group_ = 0, last_group_ = 5;
};

}  // namespace balance::foreign
