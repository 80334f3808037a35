#pragma once
/// The page that a spec is written on. Private to the writer of specs.

#include "balance/import/spec_names.hpp"
#include "balance/import/spec_text.hpp"

#include <string>
#include <vector>

namespace balance::foreign {

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
