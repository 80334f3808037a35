#pragma once
/// What must be known before an MJCF's bodies can be read: included files, default classes, the compiler's settings.

#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/xml_document.hpp"

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace balance::foreign {

/// The document with included ones put in place. Elements point into the documents, which live as long as this.
struct ExpandedMjcf {
  XmlElement root;
  std::vector<std::unique_ptr<const XmlDocument>> included;
};
/// @throws SpecError for included files that cannot be read, that include each other or are too many
ExpandedMjcf expand_mjcf_includes(const XmlDocument& document);

/// `<default class="…">`: what elements of a class say unless they say otherwise.
class MjcfDefaults {
 public:
  /// @param root of the document
  MjcfDefaults(const XmlElement& root, ForeignDiagnostics& faults);

  /// The element with what its class adds: its own class, else the one that holds for its body's children. The defaults must outlive it.
  XmlElement apply(const XmlElement& element, const std::string& child_class) const;

 private:
  void read(const XmlElement& element, const std::string& above, const std::string& name);

  struct Class {
    std::string parent;                             ///< empty: none
    std::map<std::string, XmlDefaults> attributes;  ///< by element
  };
  std::map<std::string, Class> classes_;
  ForeignDiagnostics& faults_;
};

/// `<compiler>`: how angles and orientations are written.
class MjcfCompilerAngles {
 public:
  MjcfCompilerAngles(const XmlElement& root, const XmlAttributeReader& read, ForeignDiagnostics& faults);

  double unit() const { return unit_; }  ///< of angles [rad]
  /// Of quat, axisangle, euler, xyaxes or zaxis; the identity where there is none.
  Matrix3 orientation(const XmlElement& at) const;

 private:
  const XmlAttributeReader& read_;
  double unit_ = 1;
  std::string sequence_ = "xyz";
};

// Masses that follow from shapes, as MuJoCo computes them: solid bodies of a density.

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
