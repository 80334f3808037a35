#pragma once
/// Imports a foreign file as the text of a spec.

#include "balance/foundation/base/error.hpp"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

// Findings of an importer.

/// `note`: what the importer did; `warning`: what the user should check.
enum class Severity { note, warning };

struct Finding {
  Severity level = Severity::note;
  SourceLocation place;
  std::string code;     ///< one word, machine-readable: "triangle"
  std::string subject;  ///< "link 'forearm'"
  std::string message;

  /// `robot.urdf:12: warning: link 'forearm': …`
  std::string text() const;
};

struct ImportOptions {
  std::string loops;                 ///< file with loop closures; empty: none
  bool fixed_base = false;           ///< fix floating bodies to the ground
  std::vector<std::string> actuate;  ///< joints with motors, by their names in the file; empty: as the file says
};

struct ImportResult {
  std::string format;                                        ///< "URDF", "MJCF", "MBSE", "Chrono"
  std::string spec;                                          ///< text of the spec
  std::vector<Finding> findings;                             ///< in the order of the file
  std::map<std::string, int> ignored;                        ///< number of elements left out, by kind
  std::vector<std::pair<std::string, std::string>> renamed;  ///< `joint 'a b'` and its name in the spec

  int bodies = 0, joints = 0, loops = 0;                 ///< moving bodies, joints of the spec
  double total_mass = 0;                                 ///< of the moving bodies [kg]
  std::optional<int> degrees_of_freedom;                 ///< std::nullopt if the assembly failed
  std::vector<std::string> actuators;                    ///< names of the actuated coordinates
  std::vector<std::pair<std::string, double>> assembly;  ///< approximate values that close the loops [rad or m]
  std::string assembly_failure_reason;                   ///< why the assembly failed; empty if it succeeded

  bool has_warnings() const;
};

/// @param text of the file: URDF, MJCF, MBSE or Chrono YAML; its content decides which
/// @param file name for messages; referenced files are looked for in its folder
/// @throws SpecError listing everything that is wrong with a file; SystemError if a referenced file cannot be read
ImportResult import_text(const std::string& text, const std::string& file, const ImportOptions& options);

/// @throws SystemError if the file cannot be read; SpecError as above
ImportResult import_file(const std::string& path, const ImportOptions& options);

}  // namespace balance::foreign
