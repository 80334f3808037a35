#pragma once
/// Writes a foreign model as the text of a spec.

#include "balance/interface/import/foreign_model.hpp"

#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

/// Names of a robot's bodies, joints and points in its spec.
struct GeneratedNames {
  std::vector<std::string> bodies, joints;                ///< by index in the robot
  std::vector<std::vector<model::NamedPoint>> points;     ///< of every body: ends of joints and springs, then frames
  std::vector<std::pair<std::string, std::string>> ends;  ///< `body.point` of both ends of every joint
  std::vector<std::pair<std::string, std::string>> spring_ends;  ///< the same for springs
  std::vector<std::pair<std::string, std::string>> renamed;      ///< `joint 'a b'` and its new name
};

GeneratedNames spec_names(const ForeignModel& robot);

// A robot as the text of a spec that people read and edit.

/// Approximate value of a coordinate, by its name in the spec.
using AssemblyValue = std::pair<std::string, double>;

struct GeneratedSpec {
  std::string text;
  std::vector<std::pair<std::string, std::string>> renamed;  ///< `joint 'a b'` and its name in the spec
};

/// @param assembly values for the `assembly` section, which is omitted if there are none
GeneratedSpec generate_spec(const ForeignModel& robot, const std::vector<AssemblyValue>& assembly);

/// Whether no body can have this inertia about its centre of mass, by the same criterion as in the spec reader.
bool violates_triangle_inequality(const Matrix3& inertia, SpaceKind space);

struct SpecWriterPage {
  SpecWriterPage(const ForeignModel& its_robot, const std::vector<AssemblyValue>& its_assembly)
      : robot(its_robot), assembly(its_assembly), names(spec_names(its_robot)) {}

  const ForeignModel& robot;
  const std::vector<AssemblyValue>& assembly;
  const GeneratedNames names;
  std::string text;

  bool planar() const { return robot.space == SpaceKind::planar; }
  /// Whether anything besides its joint is attached to the body.
  bool carries(int body) const;
  /// `[x, y]` or `[x, y, z]`.
  std::string vector(const Vector3& v) const;
  /// Appends a line and an optional comment; without content the line is a comment alone.
  void line(int indent, const std::string& content, const std::string& comment = {});
};

/// Shortest number that reads back the same; no negative zero.
std::string format_yaml_number(double value);
/// `[a, b, c]`.
std::string format_yaml_list(const std::vector<double>& values);
/// In double quotes, on one line.
std::string quote_yaml_text(const std::string& text);

/// Writes payloads, springs, armatures, friction, and hints for a simulation.
void write_optional_sections(SpecWriterPage& page);

}  // namespace balance::foreign
