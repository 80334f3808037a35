#include "balance/present/junit.hpp"

#include "balance/base/plain_text.hpp"
#include "balance/present/xml_text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance {
namespace {

using Status = TestCase::Status;

std::string attribute(const char* name, const std::string& value) {
  return fmt::format(" {}=\"{}\"", name, xml_text(visible_lines(value)));
}

std::string attribute(const char* name, double seconds) { return fmt::format(" {}=\"{:.6f}\"", name, seconds); }

/// How many there are of each kind, and the time that they took.
std::string totals(const std::vector<TestCase>& cases, bool skipped) {
  const auto count = [&](Status status) {
    return std::to_string(
        std::count_if(cases.begin(), cases.end(), [&](const TestCase& one) { return one.status == status; }));
  };
  double seconds = 0;
  for (const TestCase& one : cases) seconds += one.seconds;
  return attribute("tests", std::to_string(cases.size())) + attribute("failures", count(Status::failed)) +
         attribute("errors", count(Status::error)) + (skipped ? attribute("skipped", count(Status::skipped)) : "") +
         attribute("time", seconds);
}

std::string trouble(const char* element, const TestCase& one) {
  const std::string start = fmt::format("      <{}{}{}", element, attribute("message", one.message),
                                        attribute("type", one.kind.empty() ? element : one.kind));
  return one.details.empty() ? start + "/>\n"
                             : fmt::format("{}>{}</{}>\n", start, xml_text(visible_lines(one.details)), element);
}

std::string content(const TestCase& one) {
  std::string text;
  if (one.status == Status::failed) text += trouble("failure", one);
  if (one.status == Status::error) text += trouble("error", one);
  if (one.status == Status::skipped) text += fmt::format("      <skipped{}/>\n", attribute("message", one.message));
  if (!one.output.empty())
    text += fmt::format("      <system-out>{}</system-out>\n", xml_text(visible_lines(one.output)));
  return text;
}

std::string case_xml(const TestCase& one) {
  const std::string start = fmt::format("    <testcase{}{}{}", attribute("name", one.name),
                                        attribute("classname", one.group), attribute("time", one.seconds));
  const std::string inside = content(one);
  return inside.empty() ? start + "/>\n" : start + ">\n" + inside + "    </testcase>\n";
}

}  // namespace

std::string junit_xml(const std::string& name, const std::vector<TestSuite>& suites) {
  std::vector<TestCase> all;
  for (const TestSuite& suite : suites) all.insert(all.end(), suite.cases.begin(), suite.cases.end());
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  // The schema in use has no number of skipped cases at the root.
  text += fmt::format("<testsuites{}{}>\n", attribute("name", name), totals(all, false));
  for (const TestSuite& suite : suites) {
    text += fmt::format("  <testsuite{}{}>\n", attribute("name", suite.name), totals(suite.cases, true));
    for (const TestCase& one : suite.cases) text += case_xml(one);
    text += "  </testsuite>\n";
  }
  return text + "</testsuites>\n";
}

}  // namespace balance
