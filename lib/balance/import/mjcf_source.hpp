#pragma once
/// What must be known before an MJCF's bodies can be read: included files, default classes, the compiler's settings. Private to
/// the reader of MJCF.

#include "balance/import/element_reader.hpp"
#include "balance/import/robot.hpp"
#include "balance/import/xml_document.hpp"

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

}  // namespace balance::foreign
