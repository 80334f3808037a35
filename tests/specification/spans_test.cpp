#include "specs.hpp"

#include <vector>

namespace spans_test {

using namespace balance;

namespace {

/// An arm whose counterweight's mass and place are written so.
std::string arm(const std::string& counterweight) {
  return "space: planar\n"
         "bodies: {a: {mass: 1, com: [0.1, 0], inertia: 0.1}}\n"
         "joints: {J: {type: revolute, connects: [ground.origin, a.origin]}}\n"
         "counterweights:\n" +
         counterweight;
}

/// What free numbers of an arm take up in the text.
std::vector<std::string> spans(const std::string& counterweight) {
  const Study study = specs::read(arm(counterweight));
  std::vector<std::string> found;
  for (const FreeNumber& number : study.free_numbers)
    found.push_back(study.spec_text.substr(number.begin, number.end - number.begin));
  return found;
}

using Texts = std::vector<std::string>;

}  // namespace

TEST_CASE("a free number in braces takes up its braces and what is between them") {
  CHECK(spans("  cw: {on: a, at: [0, 0], mass: {free: [0, 1]}}") == Texts{"{free: [0, 1]}"});
  CHECK(spans("  cw: {on: a, at: [{free: [0, 1], start: 0.5},{ free: [ 0,2 ] }], mass: 1}") ==
        Texts{"{free: [0, 1], start: 0.5}", "{ free: [ 0,2 ] }"});
  CHECK(spans("  cw: {on: a, at: [0, 0], mass: {\n  start: \"1/2\"\n , # }\n free: [0,\n 1,] ,\n }\n}") ==
        Texts{"{\n  start: \"1/2\"\n , # }\n free: [0,\n 1,] ,\n }"});
  CHECK(spans("  cw: {on: a, at: [0, 0], \"mass\":{\"free\":[0,'1 + 1']}}") == Texts{"{\"free\":[0,'1 + 1']}"});
  CHECK(spans("  cw: {on: a, at: [free: [0, 1], 0], mass: 1}") == Texts{"free: [0, 1]"});
}

TEST_CASE("a free number on lines of its own takes up those lines from its first key to its last value") {
  CHECK(spans("  cw:\n    on: a\n    at: [0, 0]\n    mass:   # ours\n      free: [0, 10]   # comment\n      start: 2  "
              "# x\n") == Texts{"free: [0, 10]   # comment\n      start: 2"});
  CHECK(spans("  cw:\n    on: a\n    mass:\n      start: 1 +\n        1\n      free:\n      - 0\n      - '9' \n    at: "
              "[0, 0]\n") == Texts{"start: 1 +\n        1\n      free:\n      - 0\n      - '9'"});
}

TEST_CASE("a free number takes up its anchor and tag too, and an alias itself") {
  CHECK(spans("  cw: {on: a, at: [&x {free: [0, 1]}, *x], mass: !!map &y {free: [0, 1]}}\n"
              "  c2: {on: a, at: [*x , 0], mass: *y}\n") ==
        Texts{"&x {free: [0, 1]}", "*x", "!!map &y {free: [0, 1]}", "*x", "*y"});
  CHECK(spans("  cw: &all {on: a, at: [0, {free: [0, 1]}], mass: {free: [0, 1]}}\n  c2: *all # again\n") ==
        Texts{"{free: [0, 1]}", "{free: [0, 1]}", "*all", "*all"});
}

TEST_CASE("spans count bytes, whatever the characters and line breaks") {
  const std::string text = arm("  # Gegengewicht: 10 € – ½\r\n  cw: {on: a, at: [0, 0], mass: {free: [0, 1]}}\r\n");
  const std::string marked = "\xEF\xBB\xBF" + text;
  for (const std::string& spec : {text, marked}) {
    const FreeNumber number = specs::read(spec).free_numbers.at(0);
    CHECK(spec.substr(number.begin, number.end - number.begin) == "{free: [0, 1]}");
  }
}

TEST_CASE("a free parameter is found where it is defined") {
  const Study study = specs::read(specs::with(specs::planar, "m: 2", "m: {free: [1, \"2 + 3\"]}"));
  CHECK(study.spec_text.substr(study.free_numbers[0].begin, study.free_numbers[0].end - study.free_numbers[0].begin) ==
        "{free: [1, \"2 + 3\"]}");
  CHECK(study.free_numbers[0].unit == 1);
}

TEST_CASE("a free number knows the unit that it is written in") {
  const Study study = specs::read(specs::with(specs::planar, "{length: m, angle: rad}", "{mass: g}"));
  CHECK(study.free_numbers[0].key_path == "counterweights.cw.mass");
  CHECK(study.free_numbers[0].unit == 1e-3);
  CHECK(study.free_numbers[0].upper == 1e-2);
}

}  // namespace spans_test
