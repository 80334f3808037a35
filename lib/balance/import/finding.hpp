#pragma once
/// What an importer has to say of a file.

#include "balance/base/error.hpp"

#include <string>
#include <vector>

namespace balance::foreign {

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
