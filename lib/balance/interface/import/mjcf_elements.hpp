#pragma once
/// What must be known before the bodies of an MJCF can be read: included files, default classes, compiler settings.

#include "balance/interface/import/foreign_model.hpp"
#include "balance/interface/import/xml_document.hpp"

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace balance::foreign {

/// The document with its includes expanded. Elements point into the document and the included
/// ones; this owns the latter.
struct ExpandedMjcf {
  XmlElement root;
  std::vector<std::unique_ptr<const XmlDocument>> included;
};
/// @throws SpecError if included files are wrong, include each other or are too many; SystemError if one cannot be read
ExpandedMjcf expand_mjcf_includes(const XmlDocument& document);

/// `<default class="…">`: attribute values of elements that do not set them themselves.
class MjcfDefaults {
 public:
  /// @param root of the document
  MjcfDefaults(const XmlElement& root, ForeignDiagnostics& diagnostics);

  /// Returns the element with the defaults of its own class or, if it names none, of `child_class`, the class for its
  /// body's children. The defaults must outlive it.
  XmlElement apply(const XmlElement& element, const std::string& child_class) const;

 private:
  void read(const XmlElement& element, const std::string& parent_name, const std::string& name);

  struct Class {
    std::string parent;                             ///< empty: none
    std::map<std::string, XmlDefaults> attributes;  ///< by element name
  };
  std::map<std::string, Class> classes_;
  ForeignDiagnostics& diagnostics_;
};

/// `<compiler>`: how angles and orientations are written.
class MjcfCompilerAngles {
 public:
  MjcfCompilerAngles(const XmlElement& root, const XmlAttributeReader& reader, ForeignDiagnostics& diagnostics);

  double unit() const { return unit_; }  ///< of angles [rad]
  /// Rotation given by quat, axisangle, euler, xyaxes or zaxis; the identity if there is none.
  Matrix3 orientation(const XmlElement& at) const;

 private:
  const XmlAttributeReader& reader_;
  double unit_ = 1;
  std::string sequence_ = "xyz";
};

// Masses that follow from shapes, computed as in MuJoCo: solids of a given density.

/// Mass properties of all geoms of a body, about their common centre of mass, in the body's axes.
struct GeomInertia {
  int geoms = 0;  ///< number of geoms with mass
  double mass = 0;
  Vector3 com = Vector3::Zero();
  Matrix3 inertia = Matrix3::Zero();
  std::string unsupported_shape;  ///< shape whose mass cannot be computed: "a mesh"; empty: none
};

class MjcfGeomInertia {
 public:
  /// @param root of the document, for `<compiler>`
  MjcfGeomInertia(const XmlElement& root, const XmlAttributeReader& reader, const MjcfDefaults& defaults,
                  const MjcfCompilerAngles& angles);

  /// `inertiafromgeom`: whether geoms take precedence over an `<inertial>`, and whether they are used at all.
  bool overrides_inertial() const { return rule_ == "true"; }
  bool is_used() const { return rule_ != "false"; }

  /// @param body element; geoms in its frames count too
  /// @param child_class default class that applies in it
  GeomInertia compute(const XmlElement& body, const std::string& child_class) const;

 private:
  struct Sum;
  void add_all(const XmlElement& parent, const Pose& frame, const std::string& child_class, Sum& sum) const;
  void add(const XmlElement& geom, const Pose& frame, Sum& sum) const;

  const XmlAttributeReader& reader_;
  const MjcfDefaults& defaults_;
  const MjcfCompilerAngles& angles_;
  std::string rule_ = "auto";
  double first_group_ = 0, last_group_ = 5;
};

}  // namespace balance::foreign
