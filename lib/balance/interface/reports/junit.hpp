#pragma once
/// Test reports as JUnit XML, which continuous-integration servers show.

#include <string>
#include <string_view>
#include <vector>

namespace balance {

struct JunitCase {
  enum class Status { passed, failed, error, skipped };
  std::string group;  ///< the attribute `classname`
  std::string name;
  Status status = Status::passed;
  std::string message;  ///< one line on why it did not pass
  std::string kind;     ///< of failure or error: "requirement", "mechanism", …
  std::string details;  ///< more on it, any number of lines
  std::string output;   ///< shown with the case whatever its status
  double seconds = 0;   ///< that it took; 0: it is no work of its own
};

struct JunitSuite {
  std::string name;
  std::vector<JunitCase> cases;
};

/// The whole document, ending with a line feed. The same cases give the same bytes: it holds no time of day and no host.
/// Texts are UTF-8; what XML cannot hold is replaced by U+FFFD.
/// @param name of the report
std::string junit_xml(const std::string& name, const std::vector<JunitSuite>& suites);

// Text as XML holds it.

/// Fit for an attribute or an element: marks escaped, line ends kept, what is not UTF-8 or no character of XML 1.0
/// replaced by U+FFFD.
std::string escape_xml(std::string_view text);

}  // namespace balance
