#include "balance/interface/reports/junit.hpp"

#include <doctest/doctest.h>

namespace balance {
namespace {

using Status = reports::JunitCase::Status;

TEST_CASE("a report counts what became of its cases") {
  const std::string xml = reports::junit_xml(
      "suite",
      {{"first",
        {{"g", "a", Status::passed, "", "", "", "", 0.5},
         {"g", "b", Status::failed, "missed by 3 %", "requirement", "3 < 2", "", 0.25}}},
       {"second", {{"g", "c", Status::error, "singular", "mechanism"}, {"g", "d", Status::skipped, "no figures"}}}});
  CHECK(xml ==
        R"(<?xml version="1.0" encoding="UTF-8"?>
<testsuites name="suite" tests="4" failures="1" errors="1" time="0.750000">
  <testsuite name="first" tests="2" failures="1" errors="0" skipped="0" time="0.750000">
    <testcase name="a" classname="g" time="0.500000"/>
    <testcase name="b" classname="g" time="0.250000">
      <failure message="missed by 3 %" type="requirement">3 &lt; 2</failure>
    </testcase>
  </testsuite>
  <testsuite name="second" tests="2" failures="0" errors="1" skipped="1" time="0.000000">
    <testcase name="c" classname="g" time="0.000000">
      <error message="singular" type="mechanism"/>
    </testcase>
    <testcase name="d" classname="g" time="0.000000">
      <skipped message="no figures"/>
    </testcase>
  </testsuite>
</testsuites>
)");
}

TEST_CASE("nothing in a file of results turns the direction of writing (C8)") {
  reports::JunitCase one;
  one.name = "a\u202Eb";
  one.output = "two\nlines\u2066\x1b";
  const std::string xml = reports::junit_xml("s\u200Fs", {{"suite\u061C", {one}}});
  CHECK(xml.find("name=\"a&lt;U+202E&gt;b\"") != std::string::npos);
  CHECK(xml.find("lines&lt;U+2066&gt;\\x1b") != std::string::npos);
  CHECK(xml.find("s&lt;U+200F&gt;s") != std::string::npos);
  CHECK(xml.find("suite&lt;U+061C&gt;") != std::string::npos);
}

TEST_CASE("texts become what XML can hold") {
  CHECK(reports::escape_xml("a < b && c > \"d\"") == "a &lt; b &amp;&amp; c &gt; &quot;d&quot;");
  CHECK(reports::escape_xml("two\nlines\t\r") == "two&#10;lines&#9;&#13;");
  CHECK(reports::escape_xml("Schüttelkraft ≤ 1 𝛼") == "Schüttelkraft ≤ 1 𝛼");
  const std::string replaced = "\xEF\xBF\xBD";
  CHECK(reports::escape_xml(std::string("a\0b\x1f", 4)) == "a" + replaced + "b" + replaced);
  CHECK(reports::escape_xml("\xff") == replaced);
  CHECK(reports::escape_xml("\xc3") == replaced);                 // cut off
  CHECK(reports::escape_xml("\xc0\xaf") == replaced + replaced);  // a slash in two bytes
  CHECK(reports::escape_xml("\xed\xa0\x80") ==
        replaced + replaced + replaced);                   // half of a pair is no UTF-8: byte by byte
  CHECK(reports::escape_xml("\xef\xbf\xbf") == replaced);  // no character
  CHECK(reports::escape_xml("\xf4\x90\x80\x80") == replaced + replaced + replaced + replaced);  // beyond the last
  CHECK(reports::escape_xml("\xe2\x82(") == replaced + replaced + "(");
}

}  // namespace
}  // namespace balance
