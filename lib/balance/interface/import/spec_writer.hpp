#pragma once
/// The page that a spec is written on.

#include "balance/interface/import/foreign_model.hpp"

#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

/// What bodies, joints and points of a robot are called in its spec.
struct GeneratedNames {
  std::vector<std::string> bodies, joints;                ///< by index in the robot
  std::vector<std::vector<NamedPoint>> points;            ///< of every body: ends of joints and springs, then frames
  std::vector<std::pair<std::string, std::string>> ends;  ///< `body.point` of every joint on both sides
  std::vector<std::pair<std::string, std::string>> spring_ends;  ///< the same of springs
  std::vector<std::pair<std::string, std::string>> renamed;      ///< `joint 'a b'` and its new name
};

GeneratedNames spec_names(const ForeignModel& robot);

// A robot as the text of a spec that people read and change.

/// A rough value of a coordinate, by its name in the spec.
using AssemblyValue = std::pair<std::string, double>;

struct GeneratedSpec {
  std::string text;
  std::vector<std::pair<std::string, std::string>> renamed;  ///< `link 'a b'` and what it is called in the spec
};

/// @param assembly empty: none is written
GeneratedSpec generate_spec(const ForeignModel& robot, const std::vector<AssemblyValue>& assembly);

/// Whether no body can have this inertia about its centre of mass, as the spec's reader judges it.
bool violates_triangle_inequality(const Matrix3& inertia, SpaceKind space);

struct SpecWriterPage {
  SpecWriterPage(const ForeignModel& its_robot, const std::vector<AssemblyValue>& its_assembly)
      : robot(its_robot), assembly(its_assembly), names(spec_names(its_robot)) {}

  const ForeignModel& robot;
  const std::vector<AssemblyValue>& assembly;
  const GeneratedNames names;
  std::string text;

  bool planar() const { return robot.space == SpaceKind::planar; }
  /// Something besides its joint needs a body.
  bool carries(int body) const;
  /// `[x, y]` or `[x, y, z]`.
  std::string vector(const Vector3& v) const;
  /// A line with a comment, which may be empty; a line without text is a comment alone.
  void line(int indent, const std::string& content, const std::string& comment = {});
};

/// As few digits as read back the same number; no negative zero.
std::string format_yaml_number(double value);
/// `[a, b, c]`.
std::string format_yaml_list(const std::vector<double>& values);
/// In double quotes, on one line.
std::string quote_yaml_text(const std::string& text);

/// Payloads, springs, armatures, friction, and what to add to simulate.
void write_optional_sections(SpecWriterPage& page);

}  // namespace balance::foreign
