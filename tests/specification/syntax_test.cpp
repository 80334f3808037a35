// Errors of YAML's syntax, which a parser notices later than where they are, and lists of which several entries are wrong.

#include "specs.hpp"

#include <vector>

namespace {

using Changes = std::vector<std::pair<std::string, std::string>>;
using KeyPaths = std::vector<std::string>;

std::string changed(std::string text, const Changes& changes) {
  for (const auto& [from, to] : changes) text = specs::with(text, from, to);
  return text;
}

KeyPaths key_paths_of(const std::string& text) {
  KeyPaths keys;
  try {
    specs::read(text, {});
  } catch (const balance::SpecError& error) {
    for (const balance::Diagnostic& mistake : error.diagnostics()) keys.push_back(mistake.place.key);
  }
  return keys;
}

}  // namespace

TEST_CASE("a syntax error is reported at its place (D7)") {
  const std::pair<const char*, const char*> cases[] = {
      {"space: planar\nbodies: {a: {mass: 1}\njoints: {}\n", "2:9: '{' is not closed"},
      {"space: planar\nbodies: {a: [1, 2}}\n", "2:18: '}' where the '[' of line 2, column 13 needs a ']'"},
      {"space: planar\nbodies: {a: 3}}\n", "2:15: '}' without an opening bracket"},
      {"name: 'a\nspace: planar\n", "1:7: the quote ' is not closed"},
      {"name: &n 'it''s\nspace: planar\n", "1:10: the quote ' is not closed"},
      {"name: \"a\nspace: \"planar\"\n", "1:7: the quote \" is not closed before line 2"},
      {"name: \"a\" b\nspace: planar\n", "1:11: text after a closing quote"},
      {"name: a\n# no: key\nspace:planar\ngravity: [0, 0]\n",
       "3:1: a line that is not 'key: value'; put a space after the colon"},
      {"name: a\nbodies\n  b: {mass: 1}\n", "2:1: a line that is not 'key: value'; put a colon after the key"},
      {"name: a: b\n", "1:8: illegal map value; put text that contains ': ' in quotes"},
      {"name: @a\n", "1:7: unknown token; put text that begins with '@' in quotes"},
      {"name: a\n  space: planar\n",
       "2:8: illegal map value; this line or the one above is not indented like its neighbours"},
  };
  for (const auto& [text, wrong] : cases) {
    INFO(text);
    std::string expected = std::string("s.yaml:") + wrong;
    expected.insert(expected.find(": ") + 2, "expected YAML, found a syntax error: ");
    CHECK(specs::complaint(text) == expected);
  }
  CHECK(specs::complaint("name: a\rspace: planar\r") ==
        "s.yaml:1:8: expected lines that end with a line feed, found carriage returns only");
}

TEST_CASE("quotes and brackets inside of texts are none (D7)") {
  for (const char* name :
       {"it's", "5\" [a", "'it''s'", "\"a\\\"b\"", "|\n  a ' [ \"\n  b", "a # 'b", "a]}", "&a 'b'"}) {
    INFO(name);
    const std::string named = changed(specs::planar, {{"name: test arm", std::string("name: ") + name}});
    CHECK(key_paths_of(named).empty());
    CHECK(specs::complaint(changed(named, {{"tool: lower.H", "tool: a: b"}})).find("text that contains ': '") !=
          std::string::npos);
  }
}

TEST_CASE("every wrong entry of a list is reported, and every wrong part of a free number (D7)") {
  const std::string text =
      changed(specs::planar, {{"com: [k, 0], inertia: 0.02", "com: [x1, x2], inertia: {fre: [0, 1]}"},
                              {"from: {tool: [0.6, 0.1]", "from: {tool: [x3, [0]]"},
                              {"mass: {free: [0, 10]}", "mass: {free: [x5, x6], start: x7}"},
                              {"table: [[0, 1, 2], [1, 3, 4]]", "table: [[0, x8, 2], [1, 3], [2, x9, xa]]"},
                              {"tool: lower.H", "tool: lower.none"}});
  CHECK(key_paths_of(text) == KeyPaths{"bodies.upper.com[0]", "bodies.upper.com[1]", "bodies.upper.inertia.fre", "tool",
                                       "motion.from.tool[0]", "motion.from.tool[1]", "counterweights.cw.mass.free[0]",
                                       "counterweights.cw.mass.free[1]", "counterweights.cw.mass.start",
                                       "loads.tide.table[0][1]", "loads.tide.table[1]", "loads.tide.table[2][1]",
                                       "loads.tide.table[2][2]"});
}

TEST_CASE("a number that cannot be read makes no body impossible (D7)") {
  const std::string text =
      changed(specs::spatial, {{"inertia: [0.02, 0.02, 0.01], points", "inertia: [{fre: 1}, 0.02, 0.01], points"}});
  CHECK(key_paths_of(text) == KeyPaths{"bodies.a.inertia[0].fre"});
}

TEST_CASE("numbers are looked at even where what they belong to is wrong (D7)") {
  const std::string led = specs::planar + R"(controllers:
  a: {type: pdd, kp: [1, no], kd: ""}
  b: {type: pd, kp: {J1: no}, torque_limit: no}
)";
  CHECK(key_paths_of(changed(led, {{"actuators: [J1, J2, ", "actuators: [J1, J9, "}})) ==
        KeyPaths{"actuators[1]", "controllers.a.type", "controllers.a.kp[1]", "controllers.a.kd", "controllers.b.kp.J1",
                 "controllers.b.torque_limit"});
}

TEST_CASE("a value that an alias puts in a wrong place is reported where the alias stands (D7)") {
  const std::string text = changed(specs::planar, {{"l: 0.5,", "l: &n 0.5,"}, {"tool: lower.H", "tool: *n"}});
  CHECK(specs::complaint(text).find("s.yaml:18:7: tool: ") == 0);
}
