#pragma once
/// A robot file whose masses can be written. Private to import.

#include "balance/import/robot.hpp"
#include "balance/import/xml_document.hpp"
#include "balance/import/xml_edits.hpp"

#include <memory>

namespace balance::foreign {

/// Mass, centre of mass and inertia about it, in a body's axes [kg, m, kg m^2].
struct MassProperties {
  double mass = 0;
  Vector3 com = Vector3::Zero();
  Matrix3 inertia = Matrix3::Zero();
};

class MassPropertyWriter {
 public:
  virtual ~MassPropertyWriter() = default;

  virtual ForeignModel read() const = 0;
  /// What the format calls a body, and itself.
  virtual const char* body_term() const = 0;
  virtual const char* name() const = 0;
  /// Whether a body of what was read can be given mass properties.
  virtual bool can_set_mass(const ForeignBody& body) const = 0;
  /// @param body one that can take them
  /// @throws SpecError where the file keeps them from meaning anything
  virtual void write(const ForeignBody& body, const MassProperties& properties, XmlEdits& edits) const = 0;
};

/// @param document must outlive it
std::unique_ptr<MassPropertyWriter> make_urdf_mass_writer(const XmlDocument& document);
std::unique_ptr<MassPropertyWriter> make_mjcf_mass_writer(const XmlDocument& document);

}  // namespace balance::foreign
