#include "balance/interface/reports/junit.hpp"

#include "balance/foundation/base/unicode_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace balance::reports {
namespace {

using Status = JunitCase::Status;

std::string attribute(const char* name, const std::string& value) {
  return fmt::format(" {}=\"{}\"", name, escape_xml(escape_lines_for_terminal(value)));
}

std::string attribute(const char* name, double seconds) { return fmt::format(" {}=\"{:.6f}\"", name, seconds); }

/// Number of cases of each kind, and their total time.
std::string totals(const std::vector<JunitCase>& cases, bool skipped) {
  const auto count = [&](Status status) {
    return std::to_string(
        std::count_if(cases.begin(), cases.end(), [&](const JunitCase& one) { return one.status == status; }));
  };
  double seconds = 0;
  for (const JunitCase& one : cases) seconds += one.seconds;
  return attribute("tests", std::to_string(cases.size())) + attribute("failures", count(Status::failed)) +
         attribute("errors", count(Status::error)) + (skipped ? attribute("skipped", count(Status::skipped)) : "") +
         attribute("time", seconds);
}

std::string failure_element(const char* element, const JunitCase& test_case) {
  const std::string start = fmt::format("      <{}{}{}", element, attribute("message", test_case.message),
                                        attribute("type", test_case.kind.empty() ? element : test_case.kind));
  return test_case.details.empty()
             ? start + "/>\n"
             : fmt::format("{}>{}</{}>\n", start, escape_xml(escape_lines_for_terminal(test_case.details)), element);
}

std::string content(const JunitCase& test_case) {
  std::string text;
  if (test_case.status == Status::failed) text += failure_element("failure", test_case);
  if (test_case.status == Status::error) text += failure_element("error", test_case);
  if (test_case.status == Status::skipped)
    text += fmt::format("      <skipped{}/>\n", attribute("message", test_case.message));
  if (!test_case.output.empty())
    text += fmt::format("      <system-out>{}</system-out>\n", escape_xml(escape_lines_for_terminal(test_case.output)));
  return text;
}

std::string case_xml(const JunitCase& test_case) {
  const std::string start = fmt::format("    <testcase{}{}{}", attribute("name", test_case.name),
                                        attribute("classname", test_case.group), attribute("time", test_case.seconds));
  const std::string children = content(test_case);
  return children.empty() ? start + "/>\n" : start + ">\n" + children + "    </testcase>\n";
}

}  // namespace

std::string junit_xml(const std::string& name, const std::vector<JunitSuite>& suites) {
  std::vector<JunitCase> cases;
  for (const JunitSuite& suite : suites) cases.insert(cases.end(), suite.cases.begin(), suite.cases.end());
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  // the schema in use has no number of skipped cases at the root
  text += fmt::format("<testsuites{}{}>\n", attribute("name", name), totals(cases, false));
  for (const JunitSuite& suite : suites) {
    text += fmt::format("  <testsuite{}{}>\n", attribute("name", suite.name), totals(suite.cases, true));
    for (const JunitCase& one : suite.cases) text += case_xml(one);
    text += "  </testsuite>\n";
  }
  return text + "</testsuites>\n";
}

namespace {

/// Whether a character is allowed by XML 1.0, section 2.2.
bool is_allowed(std::uint32_t code) {
  return code == '\t' || code == '\n' || code == '\r' || (code >= 0x20 && code <= 0xD7FF) ||
         (code >= 0xE000 && code <= 0xFFFD) || (code >= 0x10000 && code <= 0x10FFFF);
}

}  // namespace

std::string escape_xml(std::string_view text) {
  std::string xml;
  while (!text.empty()) {
    const Utf8CodePoint code_point = decode_utf8(text);
    const std::size_t bytes = std::max<std::size_t>(code_point.bytes, 1);
    if (code_point.bytes == 0 || !is_allowed(code_point.code)) {
      xml += "\xEF\xBF\xBD";
    } else {
      switch (code_point.code) {
        case '&': xml += "&amp;"; break;
        case '<': xml += "&lt;"; break;
        case '>': xml += "&gt;"; break;
        case '"': xml += "&quot;"; break;
        // unescaped, they would be read as spaces in attributes
        case '\t': xml += "&#9;"; break;
        case '\n': xml += "&#10;"; break;
        case '\r': xml += "&#13;"; break;
        default: xml += text.substr(0, bytes);
      }
    }
    text.remove_prefix(bytes);
  }
  return xml;
}

}  // namespace balance::reports
