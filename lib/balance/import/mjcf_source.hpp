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
struct MjcfTree {
  XmlElement root;
  std::vector<std::unique_ptr<const XmlDocument>> included;
};
/// @throws SpecError for included files that cannot be read, that include each other or are too many
MjcfTree include_all(const XmlDocument& document);

/// `<default class="…">`: what elements of a class say unless they say otherwise.
class MjcfDefaults {
 public:
  /// @param root of the document
  MjcfDefaults(const XmlElement& root, Faults& faults);

  /// The element with what its class adds: its own class, else the one that holds for its body's children. The defaults must outlive it.
  XmlElement resolved(const XmlElement& element, const std::string& child_class) const;

 private:
  void read(const XmlElement& element, const std::string& above, const std::string& name);

  struct Class {
    std::string above;                        ///< empty: none
    std::map<std::string, XmlDefaults> said;  ///< by element
  };
  std::map<std::string, Class> classes_;
  Faults& faults_;
};

/// `<compiler>`: how angles and orientations are written.
class MjcfAngles {
 public:
  MjcfAngles(const XmlElement& root, const ElementReader& read, Faults& faults);

  double unit() const { return unit_; }  ///< of angles [rad]
  /// Of quat, axisangle, euler, xyaxes or zaxis; the identity where there is none.
  Matrix3 orientation(const XmlElement& at) const;

 private:
  const ElementReader& read_;
  double unit_ = 1;
  std::string sequence_ = "xyz";
};

}  // namespace balance::foreign
