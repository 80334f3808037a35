#include "balance/base/nearest.hpp"
#include "balance/import/element_reader.hpp"
#include "balance/import/mass_file.hpp"
#include "balance/import/mjcf.hpp"
#include "balance/import/mjcf_source.hpp"

#include <fmt/format.h>

namespace balance::foreign {

namespace {

bool same_place(const SourceLocation& a, const SourceLocation& b) {
  return a.file == b.file && a.line == b.line && a.column == b.column;
}

class MjcfMasses : public MassPropertyWriter {
 public:
  explicit MjcfMasses(const XmlDocument& document) : document_(document), tree_(expand_mjcf_includes(document)) {}

  ForeignModel read() const override { return read_mjcf(document_); }
  const char* body_term() const override { return "body"; }
  const char* name() const override { return "MJCF"; }
  /// Of a chain of joints the last body alone stands in the file.
  bool can_set_mass(const ForeignBody& body) const override { return find_body(tree_.root, body.place) != nullptr; }

  void write(const ForeignBody& body, const MassProperties& properties, XmlEdits& edits) const override {
    const XmlElement& element = *find_body(tree_.root, body.place);
    if (element.document != &document_)
      throw SpecError({.place = body.place,
                       .message = fmt::format("body {}: stands in an included file, which is not written",
                                              quote_for_message(body.body.name))});
    if (weighs_shapes())
      throw SpecError({.place = body.place,
                       .message = fmt::format("body {}: its mass follows from its shapes (inertiafromgeom=\"true\")",
                                              quote_for_message(body.body.name))});
    if (const XmlElement* inertial = element.child("inertial"))
      change(*inertial, properties, edits);
    else
      add(element, properties, edits);
  }

 private:
  static const XmlElement* find_body(const XmlElement& parent, const SourceLocation& place) {
    for (const XmlElement& child : parent.children) {
      if (child.name == "body" && same_place(place_of(child), place)) return &child;
      if (const XmlElement* inside = find_body(child, place)) return inside;
    }
    return nullptr;
  }

  bool weighs_shapes() const {
    bool weighs = false;
    for (const XmlElement& child : tree_.root.children)
      if (const std::string* rule = child.name == "compiler" ? child.attribute("inertiafromgeom") : nullptr)
        weighs = *rule == "true";
    return weighs;
  }

  static std::vector<double> six(const Matrix3& I) { return {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)}; }

  /// A full inertia is one in the body's axes: MuJoCo takes no orientation beside it.
  void change(const XmlElement& at, const MassProperties& properties, XmlEdits& edits) const {
    edits.set(at, "pos", {properties.com.x(), properties.com.y(), properties.com.z()});
    edits.set(at, "mass", {properties.mass});
    ForeignDiagnostics faults;
    const XmlAttributeReader reader(faults);
    const Matrix3 R = MjcfCompilerAngles(tree_.root, reader, faults).orientation(at);
    const Matrix3 I = R.transpose() * properties.inertia * R;
    const Vector3 diagonal = I.diagonal();
    const bool is_diagonal = (I - Matrix3(diagonal.asDiagonal())).norm() <= 1e-14 * I.norm();
    if (at.attribute("fullinertia") != nullptr) return edits.set(at, "fullinertia", six(I));
    if (is_diagonal) return edits.set(at, "diaginertia", {diagonal.x(), diagonal.y(), diagonal.z()});
    if (at.attribute("diaginertia") != nullptr)
      edits.replace(at, "diaginertia", "fullinertia", six(properties.inertia));
    else
      edits.set(at, "fullinertia", six(properties.inertia));
    for (const char* attribute : {"quat", "axisangle", "euler", "xyaxes", "zaxis"})
      if (at.attribute(attribute) != nullptr) edits.remove(at, attribute);
  }

  static void add(const XmlElement& body, const MassProperties& properties, XmlEdits& edits) {
    const std::vector<double> place{properties.com.x(), properties.com.y(), properties.com.z()};
    edits.insert_inside(body, fmt::format("<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>", numbers_text(place),
                                          numbers_text({properties.mass}), numbers_text(six(properties.inertia))));
  }

  const XmlDocument& document_;
  ExpandedMjcf tree_;
};

}  // namespace

std::unique_ptr<MassPropertyWriter> make_mjcf_mass_writer(const XmlDocument& document) {
  return std::make_unique<MjcfMasses>(document);
}

}  // namespace balance::foreign
