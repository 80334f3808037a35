#include "balance/present/junit.hpp"

#include "balance/base/plain_text.hpp"
#include "balance/present/xml_text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance {
namespace {

using Status = JunitCase::Status;

std::string attribute(const char* name, const std::string& value) {
  return fmt::format(" {}=\"{}\"", name, escape_xml(escape_lines_for_terminal(value)));
}

std::string attribute(const char* name, double seconds) { return fmt::format(" {}=\"{:.6f}\"", name, seconds); }

/// How many there are of each kind, and the time that they took.
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

std::string failure_element(const char* element, const JunitCase& one) {
  const std::string start = fmt::format("      <{}{}{}", element, attribute("message", one.message),
                                        attribute("type", one.kind.empty() ? element : one.kind));
  return one.details.empty()
             ? start + "/>\n"
             : fmt::format("{}>{}</{}>\n", start, escape_xml(escape_lines_for_terminal(one.details)), element);
}

std::string content(const JunitCase& one) {
  std::string text;
  if (one.status == Status::failed) text += failure_element("failure", one);
  if (one.status == Status::error) text += failure_element("error", one);
  if (one.status == Status::skipped) text += fmt::format("      <skipped{}/>\n", attribute("message", one.message));
  if (!one.output.empty())
    text += fmt::format("      <system-out>{}</system-out>\n", escape_xml(escape_lines_for_terminal(one.output)));
  return text;
}

std::string case_xml(const JunitCase& one) {
  const std::string start = fmt::format("    <testcase{}{}{}", attribute("name", one.name),
                                        attribute("classname", one.group), attribute("time", one.seconds));
  const std::string inside = content(one);
  return inside.empty() ? start + "/>\n" : start + ">\n" + inside + "    </testcase>\n";
}

}  // namespace

std::string junit_xml(const std::string& name, const std::vector<JunitSuite>& suites) {
  std::vector<JunitCase> all;
  for (const JunitSuite& suite : suites) all.insert(all.end(), suite.cases.begin(), suite.cases.end());
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  // The schema in use has no number of skipped cases at the root.
  text += fmt::format("<testsuites{}{}>\n", attribute("name", name), totals(all, false));
  for (const JunitSuite& suite : suites) {
    text += fmt::format("  <testsuite{}{}>\n", attribute("name", suite.name), totals(suite.cases, true));
    for (const JunitCase& one : suite.cases) text += case_xml(one);
    text += "  </testsuite>\n";
  }
  return text + "</testsuites>\n";
}

}  // namespace balance
