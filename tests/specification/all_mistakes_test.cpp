// Several mistakes in one spec: all of them are told, in parts, and nothing that only follows from them.

#include "specs.hpp"

#include "balance/interface/batch/suite.hpp"

#include <algorithm>
#include <optional>
#include <sstream>
#include <vector>

namespace {

using namespace balance;

std::optional<SpecError> error_of(const std::string& text, const ReadOptions& options = {}) {
  try {
    specs::read(text, options);
  } catch (const SpecError& error) {
    return error;
  }
  return std::nullopt;
}

/// Key paths of mistakes.
using Keys = std::vector<std::string>;

Keys keys_of(const std::vector<balance::Diagnostic>& mistakes) {
  Keys keys;
  for (const balance::Diagnostic& mistake : mistakes) keys.push_back(mistake.place.key);
  return keys;
}

/// Of all mistakes in a spec.
Keys keys_of(const std::string& text) {
  const auto error = error_of(text);
  return error ? keys_of(error->diagnostics()) : Keys{};
}

std::vector<balance::Diagnostic> suite_mistakes(const std::string& text) {
  try {
    batch::parse_suite(text, "suite.yaml");
  } catch (const SpecError& error) {
    return error.diagnostics();
  }
  FAIL("it was read");
  return {};
}

std::string replaced(std::string text, const std::vector<std::pair<std::string, std::string>>& changes) {
  for (const auto& [from, to] : changes) text = specs::with(text, from, to);
  return text;
}

}  // namespace

TEST_CASE("mistakes all over a spec are reported together in the document's order (D7)") {
  const std::string text = replaced(specs::planar, {{"length: m", "length: mile"},
                                                    {"mass: 1, com", "mass: -1, com"},
                                                    {"S: [0, 1]", "S: [0, 1, 2]"},
                                                    {"type: pin-slot", "type: pinslot"},
                                                    {"ratio: -1}", "ratio: 0}"},
                                                    {"actuators: [J1, J2, ", "actuators: [J1, J9, "},
                                                    {"law: cubic", "law: qubic"},
                                                    {"ramp: 0.2", "ramp: 2"},
                                                    {"mass: {free: [0, 10]}", "mass: {free: [10, 0]}"},
                                                    {"stiffness: 100", "stiffness: -100"},
                                                    {"viscous: 0.1", "viscus: 0.1"},
                                                    {"goal: static", "goal: statik"}});
  CHECK(keys_of(text) == Keys{"units.length", "ground.points.S", "bodies.lower.mass", "joints.D.type",
                              "couplings[0].ratio", "actuators[1]", "trajectories.line.law", "trajectories.swing.ramp",
                              "counterweights.cw.mass.free", "springs.s.stiffness", "friction.J1.viscus",
                              "design.goal"});
}

TEST_CASE("a mistake has its place and its parts (D7)") {
  const auto error = error_of(replaced(specs::planar, {{"mass: 1, com", "mass: -1, com"}, {"upper.A]", "uper.A]"}}));
  REQUIRE(error.has_value());
  REQUIRE(error->diagnostics().size() == 2);
  const balance::Diagnostic& first = error->diagnostics()[0];
  CHECK(first.place.file == "s.yaml");
  CHECK(first.place.line == 10);
  CHECK(first.place.column == 17);
  CHECK(first.place.key == "bodies.lower.mass");
  CHECK(first.message == "must be positive: expected a number > 0, found -1");
  CHECK(first.expected == "a number > 0");
  CHECK(first.found == "-1");
  CHECK(first.hint.empty());
  const balance::Diagnostic& second = error->diagnostics()[1];
  CHECK(second.place.key == "joints.J1.connects[1]");
  CHECK(second.expected == "a body (ground, upper, lower or wheel)");
  CHECK(second.found == "'uper'");
  CHECK(second.hint == "nearest is 'upper'");
  CHECK(std::string(error->what()) == first.text() + "\n" + second.text());
  CHECK(error->summary() == first.text() + " (and 1 more mistake)");
}

TEST_CASE("what only follows from another mistake is not reported (D7)") {
  const std::pair<std::vector<std::pair<std::string, std::string>>, Keys> cases[] = {
      // a parameter without a value, used in five places
      {{{"l: 0.5", "l: 1 +"}}, {"parameters.l"}},
      {{{"parameters:", "paramters:"}}, {"paramters"}},
      // a tool that is none
      {{{"tool: lower.H", "tool: lower.X"}}, {"tool"}},
      {{{"tool: lower.H", "tol: lower.H"}}, {"tol"}},
      // a body that has no right name, a joint of no type
      {{{"  wheel:", "  whe el:"}}, {"bodies.whe el"}},
      {{{"  D: {type: pin-slot", "  D: {type: sliding-pin"}}, {"joints.D.type"}},
      {{{"points: {B: [0, 0], H", "pionts: {B: [0, 0], H"}}, {"bodies.lower.pionts"}},
      // what a motion does not say
      {{{"duration: 1", "duration: -1"}}, {"motion.duration"}},
      {{{"duration: 1", "durtion: 1"}}, {"motion.durtion"}},
      {{{"from: {tool: [0.6, 0.1]", "from: {tool: [0.6]"}}, {"motion.from.tool"}},
      // a body that cannot be read is still the one that a weight is on
      {{{"  cw: {on: upper", "  cw: {on: uppr"}}, {"counterweights.cw.on"}},
      {{{"drive: tool}", "drive: tol}"},
        {"goal: static, minimize: added-mass", "minimize: {rms: shaking_force, along: line}"}},
       {"trajectories.line.drive"}},
  };
  for (const auto& [changes, keys] : cases) {
    CAPTURE(changes[0].second);
    CHECK(keys_of(replaced(specs::planar, changes)) == keys);
  }
}

TEST_CASE("at most 20 mistakes are reported, and the others are counted (D7)") {
  std::string bodies;
  for (int i = 0; i < 30; ++i) bodies += "  b" + std::to_string(i) + ": {mass: -1, com: [0, 0], inertia: 1}\n";
  const std::string text =
      "space: planar\nbodies:\n" + bodies + "joints: {J: {type: fixed, connects: [ground.origin, b0.origin]}}\n";
  const auto error = error_of(text);
  REQUIRE(error.has_value());
  CHECK(error->diagnostics().size() == 20);
  CHECK(error->diagnostics().back().place.line == 13);
  const std::string all = error->what();
  CHECK(std::count(all.begin(), all.end(), '\n') == 20);
  // 30 masses, and 29 bodies without a joint
  CHECK(error->unlisted_count() == 39);
  CHECK(all.ends_with("\nand 39 more mistakes"));
}

TEST_CASE("mistakes in options name the option as their file (D7)") {
  const auto error = error_of(specs::planar, {.set = {{"ll", "1"}, {"k", "1 +"}}});
  REQUIRE(error.has_value());
  REQUIRE(error->diagnostics().size() == 2);
  CHECK(error->diagnostics()[0].place.file == "--set ll");
  CHECK(error->diagnostics()[0].place.is_option());
  CHECK(error->diagnostics()[0].hint == "nearest is 'l'");
  CHECK(error->diagnostics()[1].place.file == "--set k");
}

TEST_CASE("all mistakes of a suite are reported, and none about names that mistakes hide (D7)") {
  const std::string text =
      "defaults: {spec: arm.yaml, samples: 1}\n"
      "cases:\n"
      "  a: {sett: {l: 1}}\n"
      "  b: {design: perhaps}\n"
      "  c: {}\n"
      "baseline: a\n"
      "require: ['peak(torque[J]) < base', 'peak(torque[J]) <', 'peak(power, b) < 1']\n";
  CHECK(keys_of(suite_mistakes(text)) == Keys{"defaults.samples", "cases.a.sett", "cases.b.design", "require[1]"});
}

TEST_CASE("requirements are read although no case and no baseline is right, and have their parts (D7)") {
  const std::string text =
      "cases: {a: {spec: a.yaml, samples: x}, b c: {spec: a.yaml}}\n"
      "baseline: z\n"
      "require: ['peak(torque) < base', 'peak(torque) <']\n";
  const std::vector<balance::Diagnostic> mistakes = suite_mistakes(text);
  REQUIRE(keys_of(mistakes) == Keys{"cases.a.samples", "cases.b c", "baseline", "require[1]"});
  const balance::Diagnostic& last = mistakes.back();
  CHECK(last.expected == "a requirement such as 'peak(shaking_force) <= 0.9 * base'");
  CHECK(last.found == "'peak(torque) <'");
  CHECK(last.hint.find("column 15: ") == 0);
}

TEST_CASE("'body' and 'on' are the same, but not both at once (D8)") {
  const std::string by_body = replaced(specs::planar, {{"{on: upper, at: [", "{body: upper, at: ["},
                                                       {"{on: lower, at: H, mass", "{body: lower, at: H, mass"},
                                                       {"{on: upper, at: A", "{body: upper, at: A"},
                                                       {"{on: lower, at: H, force", "{body: lower, at: H, force"}});
  CHECK(specs::complaint(by_body).empty());
  CHECK(specs::complaint(replaced(specs::planar, {{"{on: upper, at: [", "{on: upper, body: upper, at: ["}})) ==
        "s.yaml:26:8: counterweights.cw.on: expected 'body' or 'on', found both");
  for (const char* key : {"true", "True", "\"true\""})
    CHECK(specs::complaint(replaced(specs::planar, {{"{on: upper, at: [", std::string("{") + key + ": upper, at: ["}}))
              .find("use 'body'") != std::string::npos);
}

TEST_CASE("names are letters, digits, '_' and '-' after a letter, in every section (C8)") {
  for (const std::string name : {"\"a\\x1b[31m\"", "\"a\\u202Eb\"", "\"a\\0b\"", "\"\\a\"", "1a", "_a", "=1+1",
                                 "\"a b\"", ".a", "a..b", "a.1", "a\\nb"}) {
    CAPTURE(name);
    for (const char* old : {"  upper:", "  J1:", "  cw:", "  cargo:", "  disc:", "  cut:", "  s:", "  line:"}) {
      CAPTURE(old);
      const auto error = error_of(replaced(specs::planar, {{old, "  " + name + ":"}}));
      REQUIRE(error.has_value());
      const auto& all = error->diagnostics();
      CHECK(std::any_of(all.begin(), all.end(), [](const balance::Diagnostic& one) {
        return one.expected == "a name of letters, digits, '_' and '-'";
      }));
      for (const char c : std::string(error->what())) CHECK((c == '\n' || static_cast<unsigned char>(c) >= 0x20));
    }
  }
  CHECK(specs::complaint(replaced(specs::planar, {{"  cargo:", "  K\xC3\xB6rper-2:"}})).empty());
  CHECK(specs::complaint(replaced(specs::planar, {{"  cargo:", "  \xE8\xB4\x9F\xE8\xBD\xBD:"}})).empty());
}

TEST_CASE("text that is no UTF-8 is refused where it begins (C8)") {
  CHECK(specs::complaint("name: a\nspace: \xED\xA0\x80\n")
            .find("s.yaml:2:8: expected text (UTF-8), found the byte 0xed") == 0);
  CHECK(specs::complaint("name: \xC0\xAF\n").find("s.yaml:1:7: expected text (UTF-8)") == 0);
  CHECK(specs::complaint("name: \xF4\x90\x80\x80\n").find("s.yaml:1:7: expected text (UTF-8)") == 0);
}

TEST_CASE("a title keeps its text, and what cannot be seen in it is spelt out (C8)") {
  CHECK(specs::read(replaced(specs::planar, {{"name: test arm", "name: \"Pr\\u00fcfstand <1> \\e[31m\\u202e\""}}))
            .mechanism.name ==
        "Pr\xC3\xBC"
        "fstand <1> \\x1b[31m<U+202E>");
}

TEST_CASE("types of joints in other vocabularies get a hint at their name here (D6)") {
  const auto complaint = [](const std::string& type) {
    return specs::complaint(replaced(specs::planar, {{"J2: {type: revolute", "J2: {type: " + type}}));
  };
  for (const char* type : {"hinge", "pin", "Hinge", "pin joint", "rotational", "revolute_joint"})
    CHECK(complaint(type).ends_with("; its name here is 'revolute'"));
  for (const char* type : {"slider", "sliding", "linear"})
    CHECK(complaint(type).ends_with("; its name here is 'prismatic'"));
  CHECK(complaint("weld").ends_with("; its name here is 'fixed'"));
  const auto in_space = [](const std::string& type) {
    return specs::complaint(replaced(specs::spatial, {{"type: revolute", "type: " + type}}));
  };
  for (const char* type : {"ball", "ball-and-socket"})
    CHECK(in_space(type).find("; its name here is 'spherical'") != std::string::npos);
  for (const char* type : {"cardan", "hooke", "u-joint"})
    CHECK(in_space(type).find("; its name here is 'universal'") != std::string::npos);
}

TEST_CASE("a number with a unit behind it is reported where units are stated (D6)") {
  for (const char* number : {"360deg", "5 mm", "90\xC2\xB0", "3kg", "2 N/m"}) {
    CAPTURE(number);
    const std::string found =
        specs::complaint(replaced(specs::planar, {{"com: [0, 0]", std::string("com: [0, \"") + number + "\"]"}}));
    CHECK(found.find("'units:' sets the units of all numbers") != std::string::npos);
    CHECK(found.find("nearest is") == std::string::npos);
  }
  CHECK(specs::complaint(replaced(specs::planar, {{"com: [0, 0]", "com: [0, 2e3]"}})).empty());
}

TEST_CASE("a decimal comma is explained, in a block and between braces") {
  const std::string block = specs::complaint(replaced(specs::planar, {{"com: [0, 0]", "com: [\"0,4\", 0]"}}));
  CHECK(block.find("found '0,4': use a decimal point: 0.4") != std::string::npos);
  const std::string flow = specs::complaint(replaced(specs::planar, {{"com: [0, 0]", "mass: 0,4, com: [0, 0]"}}));
  CHECK(flow.find("use a decimal point: 0.4") != std::string::npos);
}

TEST_CASE("a tab where YAML wants blanks is shown (D6)") {
  const std::string expected = ": expected YAML, found a tab in the indentation; indent with spaces";
  CHECK(specs::complaint("space: planar\nbodies:\n\ta: {mass: 1}\n") == "s.yaml:3:1" + expected);
  CHECK(specs::complaint("space: planar\nbodies:\n  a:\n  \tmass: 1\n  \tcom: [0, 0]\njoints: {}\n") ==
        "s.yaml:4:3" + expected);
  CHECK(specs::complaint("space: planar\nbodies:\n  a:\n    mass: 1\n\t  com: [0, 0]\n") == "s.yaml:5:1" + expected);
  CHECK(specs::complaint("a: [1, 2\n").find("tab") == std::string::npos);
}

TEST_CASE("a motion takes a time that can be counted (A8)") {
  for (const char* duration : {"5e-324", "1e-12", "1e12"}) {
    CAPTURE(duration);
    const std::string text =
        replaced(specs::planar, {{"motion: {duration: 1,", std::string("motion: {duration: ") + duration + ","}});
    CHECK(specs::complaint(text).find("motion.duration: expected a duration from 1e-09 s to 1e+09 s, found") !=
          std::string::npos);
  }
  const std::string table =
      replaced(specs::planar,
               {{"line: {law: cubic, drive: tool}",
                 "line: {drive: tool, path: {table: [[0, 0, 0], [1e-320, 0, 1], [2e-320, 1, 0], [3e-320, 0, 0]]}}"}});
  CHECK(specs::complaint(table).find("expected a duration from") != std::string::npos);
}
