#include "balance/interface/files/result_summary.hpp"

#include "../files/sample.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/sha256.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/interface/files/text_table.hpp"
#include "balance/interface/reports/check_sections.hpp"

#include <nlohmann/json.hpp>

#include <doctest/doctest.h>

#include <numbers>

using namespace balance;
using namespace balance::files;
using namespace balance::reports;
using namespace balance::specification;

namespace {

Mechanism mechanism() {
  Mechanism m;
  m.name = "crank";
  m.coordinates = {{"A", 0, 0, CoordinateKind::angle}, {"S", 1, 0, CoordinateKind::length}};
  return m;
}

CheckReport report() {
  CheckReport r;
  r.outcome.status = MotionStatus::done;
  r.bodies = 2;
  r.joints = 3;
  r.tree_joints = {"A", "S"};
  r.loops = {{"weld", {"crank", "ground", "slider"}, 3}};
  r.tree_coordinates = 4;
  r.closure_equations = 3;
  r.closure_rank = 2;
  r.degrees_of_freedom = 2;
  r.gruebler_degrees_of_freedom = 1;
  r.redundant = {"weld: moment about x"};
  r.total_mass = 2.5;
  r.com = Vector3(0.25, -0.5, 0);
  r.start = {0.5, 0.125};
  r.modes = {{{0.5, 0.125}, "assembly: {A: 0.5}", true}, {{-0.5, 0.125}, "assembly: {A: -0.5}", false}};
  return r;
}

}  // namespace

TEST_CASE("columns are as wide as their widest cell, counted in characters") {
  const TextTable table{{"name", "n"}, {Align::left, Align::right}, {{"ä", "10"}, {"longer", "9"}}};
  CHECK(format_table(table) == "name     n\nä       10\nlonger   9\n");
  CHECK_THROWS_AS(format_table({{"a"}, {Align::left}, {{"1", "2"}}}), std::invalid_argument);
}

TEST_CASE("a table that is too wide keeps numbers, names and the words of its headings whole") {
  TextTable table{{"quantity", "unit", "peak", "rms"}, {Align::left, Align::left, Align::right, Align::right}, {}, 2};
  table.rows = {{"joint_force[the_long_name_of_a_joint]", "N", "1.23456e-10", "123456"}, {"torque", "N m", "1", "2"}};
  CHECK(format_table(table, 50) ==
        "quantity                 unit         peak     rms\n"
        "joint_force[the_long_name_of_a_joint]\n"
        "                         N     1.23456e-10  123456\n"
        "torque                   N m             1       2\n");
  table.rows = {{"torque", "N", "1.23456e-10", "123456"}};
  CHECK(format_table(table, 30) ==
        "quantity  unit         peak\n"
        "torque    N     1.23456e-10\n"
        "\n"
        "quantity  unit     rms\n"
        "torque    N     123456\n");
  const TextTable narrow{{"number", "conditions met"}, {Align::left, Align::right}, {{"counterweights.w11.mass", "4"}}};
  CHECK(format_table(narrow, 35) ==
        "number                   conditions\n"
        "                                met\n"
        "counterweights.w11.mass           4\n");
}

TEST_CASE("long lines are broken at blanks, rather after a comma, and words are whole") {
  CHECK(wrap_lines("short\n", 20) == "short\n");
  CHECK(wrap_lines("  one two, three four five\n", 20) == "  one two, three\n    four five\n");
  CHECK(wrap_lines("where a = 1 mm, b = 2 mm", 18) == "where a = 1 mm,\n  b = 2 mm");
  CHECK(wrap_lines("/a/very/long/path/without/blanks and more", 20) == "/a/very/long/path/without/blanks\n  and more");
}

TEST_CASE("an SI unit is displayed factor by factor in the units of a spec") {
  const SpecUnits mm = read_display_units("units: {length: mm, mass: g, angle: deg}\n"),
                  inch = read_display_units("units: {length: in, mass: lb, angle: deg}\n");
  const auto check = [](const char* si, const SpecUnits& units, const char* name, double factor) {
    const DisplayUnit unit = find_display_unit(si, units);
    CHECK(unit.name == name);
    CHECK(unit.factor == doctest::Approx(factor).epsilon(1e-14));
  };
  const double degree = std::numbers::pi / 180, inches = 0.0254, pounds = 0.45359237, pound_force = 4.4482216152605;
  check("N m", mm, "N mm", 1e-3);
  check("kg m^2", mm, "g mm^2", 1e-9);
  check("rad/s^2", mm, "deg/s^2", degree);
  check("N m s/rad", mm, "N mm s/deg", 1e-3 / degree);
  check("J", mm, "J", 1);
  check("N m", inch, "lbf in", pound_force * inches);
  check("W", inch, "lbf in/s", pound_force * inches);
  check("kg m^2", inch, "lb in^2", pounds * inches * inches);
  check("1", inch, "", 1);
  check("", inch, "", 1);
  for (const char* si : {"N m", "kg m^2", "rad/s", "J", "W", "N m/rad", "m/s^2", "N m s"}) check(si, {}, si, 1);
  // a force that the spec names, also with lengths in inches
  check("N m", read_display_units("units: {length: in, force: N}\n"), "N in", inches);
  CHECK(!has_other_units(read_display_units("name: no units here\n")));
}

TEST_CASE("numbers for people have six significant digits") {
  CHECK(format_number(869.7458473278) == "869.746");
  CHECK(format_number(-0.07505) == "-0.0750500");
  CHECK(format_number(1.5e-13) == "1.50000e-13");
  CHECK(format_number(0) == "0.00000");
}

TEST_CASE("the summary shows every metric with its unit in aligned columns") {
  const std::string text =
      format_result_summary(sample::result(SpaceKind::planar), sample::description(), {.width = 100});
  CHECK(text ==
        "Kurbel-Schwinge für Tests: trajectory cycloid (cycloidal, drive tool), 0.1 s, 5 samples\n"
        "\n"
        "quantity       unit     peak  at time [s]      rms     mean\n"
        "torque[A]      N m   103.243    0.0300000  50.5000  40.2500\n"
        "shaking_force  N     869.746    0.0750500  500.000  400.000\n"
        "\n"
        "energy moved by the actuators: 12.5000 J\n");
}

TEST_CASE("the check names degrees of freedom, redundant constraints and the line that picks each assembly mode") {
  const std::string text = check_text(report(), mechanism(), {.width = 100});
  for (const std::string part :
       {"degrees of freedom  2 (4 coordinates - 2 independent of 3 closure equations); by counting 1",
        "redundant           weld: moment about x", "total mass          2.5 kg", "(0.25, -0.5) m",
        "A = 0.5 rad, S = 0.125 m", "  * assembly: {A: 0.5}", "    assembly: {A: -0.5}"}) {
    CHECK_MESSAGE(text.find(part) != std::string::npos, part, "\n", text);
  }
}

TEST_CASE("the line of an assembly mode is continued after a comma") {
  CheckReport r = report();
  r.modes.resize(1);
  r.modes[0].assembly_line = "assembly: {first_joint: 0.123456, second_joint: -1.23456, third_joint: 2.5}";
  TextOptions options;
  options.width = 48;
  const std::string text = check_text(r, mechanism(), options);
  CHECK_MESSAGE(text.find("  * assembly: {first_joint: 0.123456,\n"
                          "      second_joint: -1.23456, third_joint: 2.5}\n"
                          "      # selected by the spec\n") != std::string::npos,
                text);
}

TEST_CASE("a mechanism that cannot be assembled has no degrees of freedom to show") {
  CheckReport r = report();
  r.outcome = {MotionStatus::not_assembled, 0, "the loop at weld stays open", {}};
  CHECK(check_text(r, mechanism()).find("degrees of freedom") == std::string::npos);
}

TEST_CASE("JSON holds the same figures, unrounded") {
  const RunResult r = sample::result(SpaceKind::planar);
  const auto json = nlohmann::json::parse(format_result_json(r, sample::description(), {"out.h5"}));
  CHECK(json["outcome"]["status"] == "done");
  CHECK(json["metrics"][0]["quantity"] == "torque[A]");
  CHECK(json["metrics"][0]["peak"] == 103.24281233);
  CHECK(json["metrics"][1]["peak_time"] == 0.07505);
  CHECK(json["about"] == std::vector<double>{0.5, -0.25});
  CHECK(json["samples"] == 5);
  CHECK(json["files"] == std::vector<std::string>{"out.h5"});
  const auto checked = nlohmann::json::parse(files::format_json(check_json(report(), mechanism(), {"odd"})));
  CHECK(checked["degrees_of_freedom"] == 2);
  CHECK(checked["loops"][0]["closure_equations"] == 3);
  CHECK(checked["start"]["S"] == 0.125);
  CHECK(checked["modes"][1]["coordinates"]["A"] == -0.5);
  CHECK(checked["warnings"] == std::vector<std::string>{"odd"});
}

TEST_CASE("an error in JSON says its kind, and a motion that stopped its status and time") {
  const auto spec = nlohmann::json::parse(format_error_json("spec", "a.yaml:1:1: \"x\"\n\xff"));
  CHECK(spec["error"]["kind"] == "spec");
  CHECK(spec["error"]["message"] == "a.yaml:1:1: \"x\"\n\uFFFD");  // what is no UTF-8 is shown as such
  const auto motion =
      nlohmann::json::parse(format_error_json("mechanism", {MotionStatus::drive_singularity, 0.03, "stuck", {}}));
  CHECK(motion["error"]["status"] == "drive-singularity");
  CHECK(motion["error"]["time"] == 0.03);
  CHECK(motion["error"]["message"] == "stuck");
}

TEST_CASE("SHA-256 agrees with the standard's examples") {
  // FIPS 180-4, and the empty message
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}
