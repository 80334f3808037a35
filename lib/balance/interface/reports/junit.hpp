#pragma once
/// Test reports as JUnit XML for continuous-integration servers.

#include <string>
#include <string_view>
#include <vector>

namespace balance::reports {

struct JunitCase {
  enum class Status { passed, failed, error, skipped };
  std::string group;  ///< the attribute `classname`
  std::string name;
  Status status = Status::passed;
  std::string message;  ///< one line on why it did not pass
  std::string kind;     ///< of failure or error: "requirement", "mechanism", …
  std::string details;  ///< further information, any number of lines
  std::string output;   ///< shown with the case regardless of its status
  double seconds = 0;   ///< run time [s]; 0: no work of its own
};

struct JunitSuite {
  std::string name;
  std::vector<JunitCase> cases;
};

/// The complete document, ending with a line feed. The same cases give the same bytes: it contains no time of day and
/// no host name. Texts are UTF-8; characters that XML cannot contain are replaced by U+FFFD.
/// @param name of the report
std::string junit_xml(const std::string& name, const std::vector<JunitSuite>& suites);

// Text in XML.

/// Escapes text for an attribute or an element. Keeps line ends; replaces invalid UTF-8 and characters that XML
/// 1.0 does not allow by U+FFFD.
std::string escape_xml(std::string_view text);

}  // namespace balance::reports
