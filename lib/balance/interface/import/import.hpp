#pragma once
/// A foreign file becomes the text of a spec.

#include "balance/foundation/base/error.hpp"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

// What an importer has to say of a file.

/// `note`: what was done; `warning`: what somebody should look at.
enum class Severity { note, warning };

struct Finding {
  Severity level = Severity::note;
  SourceLocation place;
  std::string code;     ///< one word for programs: "triangle"
  std::string subject;  ///< "link 'forearm'"
  std::string message;

  /// `robot.urdf:12: warning: link 'forearm': …`
  std::string text() const;
};

}  // namespace balance::foreign

namespace balance {

struct ImportOptions {
  std::string loops;                 ///< a file with closures; empty: none
  bool fixed_base = false;           ///< what floats is held still
  std::vector<std::string> actuate;  ///< joints with motors, by the file's names; empty: as the file says
};

/// What became of a file.
struct ImportResult {
  std::string format;                                        ///< "URDF", "MJCF", "MBSE", "Chrono"
  std::string spec;                                          ///< text, readable as a spec
  std::vector<foreign::Finding> findings;                    ///< in the order of the file
  std::map<std::string, int> ignored;                        ///< what was left out, counted
  std::vector<std::pair<std::string, std::string>> renamed;  ///< `joint 'a b'` and its name in the spec

  int bodies = 0, joints = 0, loops = 0;                 ///< moving bodies, joints of the spec
  double total_mass = 0;                                 ///< that moves [kg]
  std::optional<int> degrees_of_freedom;                 ///< none if it could not be assembled
  std::vector<std::string> actuators;                    ///< coordinates
  std::vector<std::pair<std::string, double>> assembly;  ///< rough values that close the loops [rad or m]
  std::string assembly_failure_reason;                   ///< why not; empty if it was

  bool has_warnings() const;
};

/// @param text of the file: URDF, MJCF, MBSE or Chrono YAML, told apart by what it says
/// @param file what messages call it; files that it names are looked for in its folder
/// @throws SpecError with everything that is wrong with a file; SystemError if a file that is named cannot be read
ImportResult import_text(const std::string& text, const std::string& file, const ImportOptions& options);

/// @throws SystemError if the file cannot be read; SpecError as above
ImportResult import_file(const std::string& path, const ImportOptions& options);

}  // namespace balance
