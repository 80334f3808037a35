#include "balance/base/rotation.hpp"
#include "balance/import/element_reader.hpp"
#include "balance/import/mass_file.hpp"
#include "balance/import/urdf.hpp"

#include <fmt/format.h>

#include <tuple>

namespace balance::foreign {

namespace {

class UrdfMasses : public MassPropertyWriter {
 public:
  explicit UrdfMasses(const XmlDocument& document) : document_(document) {}

  ForeignModel read() const override { return read_urdf(document_); }
  const char* body_term() const override { return "link"; }
  const char* name() const override { return "URDF"; }
  bool can_set_mass(const ForeignBody& body) const override { return body.has_inertial; }

  void write(const ForeignBody& body, const MassProperties& properties, XmlEdits& edits) const override {
    const XmlElement& inertial = *find_link(body.body.name)->child("inertial");
    const XmlElement* origin = inertial.child("origin");
    Matrix3 axes = Matrix3::Identity();
    if (origin != nullptr && origin->attribute("rpy") != nullptr) {
      const auto v =
          parse_number_list(*origin->attribute("rpy")).value_or(std::vector<double>(3));  // the reader has checked it
      axes = rotation_from_rpy({v[0], v[1], v[2]});
    }
    const Matrix3 I = axes.transpose() * properties.inertia * axes;
    edits.set(*inertial.child("mass"), "value", {properties.mass});
    write_place(inertial, origin, properties.com, edits);
    if (const XmlElement* inertia = inertial.child("inertia"))
      for (const auto& [key, i, j] :
           {std::tuple{"ixx", 0, 0}, {"ixy", 0, 1}, {"ixz", 0, 2}, {"iyy", 1, 1}, {"iyz", 1, 2}, {"izz", 2, 2}})
        edits.set(*inertia, key, {I(i, j)});
  }

 private:
  const XmlElement* find_link(const std::string& name) const {
    for (const XmlElement& part : document_.root.children)
      if (part.name == "link" && part.attribute("name") != nullptr && *part.attribute("name") == name) return &part;
    return nullptr;
  }

  static void write_place(const XmlElement& inertial, const XmlElement* origin, const Vector3& place, XmlEdits& edits) {
    const std::vector<double> xyz{place.x(), place.y(), place.z()};
    if (origin != nullptr && origin->attribute("xyz") != nullptr) return edits.set(*origin, "xyz", xyz);
    if (place.isZero(0)) return;
    if (origin != nullptr) return edits.set(*origin, "xyz", xyz);
    edits.insert_before(*inertial.child("mass"), fmt::format("<origin xyz=\"{}\"/>", numbers_text(xyz)));
  }

  const XmlDocument& document_;
};

}  // namespace

std::unique_ptr<MassPropertyWriter> make_urdf_mass_writer(const XmlDocument& document) {
  return std::make_unique<UrdfMasses>(document);
}

}  // namespace balance::foreign
