#include "balance/interface/specification/balanced_spec.hpp"

#include "layouts.hpp"
#include "numbers_of.hpp"
#include "specs.hpp"

#include <filesystem>
#include <fstream>
#include <random>
#include <regex>
#include <sstream>

using namespace balance;
using namespace balance::specification;
using specs::numbers_of;

namespace {

/// A product of two numbers and of a number and a unit is off by no more than this.
constexpr double rounding = 1e-15;

std::string arm(const std::string& counterweights) {
  return "space: planar\n"
         "parameters: {l: 0.5}\n"
         "bodies: {a: {mass: 1, com: [0.1, 0], inertia: 0.1}}\n"
         "joints: {J: {type: revolute, connects: [ground.origin, a.origin]}}\n"
         "counterweights:\n" +
         counterweights;
}

VectorX values(const Study& study, double first) {
  VectorX x(static_cast<Eigen::Index>(study.free_numbers.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = first + static_cast<double>(i);
  return x;
}

/// The counterweights' text when the free numbers become 3.25, 4.25, …
std::string balanced(const std::string& counterweights, const ReadOptions& options = {}) {
  const Study study = specs::read(arm(counterweights), options);
  const std::string text = format_balanced_spec(study, values(study, 3.25));
  REQUIRE(text.rfind(arm("").substr(0, 20), 0) == 0);
  return text.substr(text.find("counterweights:\n") + 16);
}

/// Reads what is written and compares it with the mechanism that was meant.
void check_round_trip(const std::string& text, const std::string& file, const VectorX& x, const ReadOptions& options) {
  const DesignSpace space = read_design_space(text, file, options);
  const std::string written = format_balanced_spec(space.start, x);
  CAPTURE(text);
  CAPTURE(written);
  const Study meant = space.study_at(x);
  const Study read = read_spec(written, file);
  CHECK(read.free_numbers.empty());
  CHECK(specs::difference(numbers_of(read.mechanism), numbers_of(meant.mechanism)) <= rounding);
  CHECK(specs::difference(numbers_of(read.trajectories), numbers_of(meant.trajectories)) <= rounding);
}

std::vector<std::string> comments_of(const std::string& text) {
  std::vector<std::string> found;
  const std::regex comment("# ?c[0-9]+");
  for (auto i = std::sregex_iterator(text.begin(), text.end(), comment); i != std::sregex_iterator(); ++i)
    found.push_back(i->str());
  return found;
}

}  // namespace

TEST_CASE("numbers stand where free numbers stood, and everything else stays") {
  CHECK(balanced("  # first\n  cw: {on: a, at: [{free: [0, 9]}, 0 ] , mass: {free: [0, 9], start: 1}}  # last\n") ==
        "  # first\n  cw: {on: a, at: [3.25, 0 ] , mass: 4.25}  # last\n");
  CHECK(balanced("  cw: {on: a, at: [0, 0], mass: 1}") == "  cw: {on: a, at: [0, 0], mass: 1}");
}

TEST_CASE("a number goes up to its key, and comments stay") {
  const auto mass = [](const std::string& text) {
    const std::string found = balanced("  cw:\n    on: a\n    mass:" + text + "    at: [0, 0]  # end\n");
    const std::string head = "  cw:\n    on: a\n    mass:", tail = "    at: [0, 0]  # end\n";
    REQUIRE(found.rfind(head, 0) == 0);
    REQUIRE(found.substr(found.size() - tail.size()) == tail);
    return found.substr(head.size(), found.size() - head.size() - tail.size());
  };
  CHECK(mass("\n      free: [0, 9]   # comment\n      start: 2\n") == " 3.25   # comment\n");
  CHECK(mass("\n      free: [0, 9]\n      start: 2 # comment\n") == " 3.25 # comment\n");
  CHECK(mass(" \n\n      free:\n        - 0\n        - 9\n") == " 3.25\n");
  CHECK(mass("  # of lead\n      free: [0, 9]   # comment\n      start: 2\n") == " 3.25  # of lead\n      # comment\n");
  CHECK(mass("  # of lead\n      # or steel\n      free: [0, 9]\n      # comment\n      start: 2 # x\n") ==
        " 3.25  # of lead\n      # or steel\n      # comment\n      # x\n");
  CHECK(mass("\n      free: [0, # low\n        9] # high\n      start: 2 # x\n") ==
        " 3.25 # low\n      # high\n       # x\n");
  CHECK(mass(" {free: [0, # low\n        9]} # high\n") == " 3.25 # low\n         # high\n");
  CHECK(mass("\n      {free: [0, 9]}\n") == "\n      3.25\n");
}

TEST_CASE("a number keeps its distance from what stands beside it") {
  CHECK(balanced("  cw: {on: a, at: [0, 0], \"mass\":{free: [0, 9]}}\n") ==
        "  cw: {on: a, at: [0, 0], \"mass\": 3.25}\n");
  CHECK(balanced("  cw:\n    on: a\n    at: [0, 0]\n    mass: {free: [0, 9]}# close\n") ==
        "  cw:\n    on: a\n    at: [0, 0]\n    mass: 3.25 # close\n");
  CHECK(
      balanced(
          "  cw:\n    on: a\n    at:\n    - free: [0, 9]\n      start: 1\n    -\n      free: [0, 9]\n    mass: 1\n") ==
      "  cw:\n    on: a\n    at:\n    - 3.25\n    -\n      4.25\n    mass: 1\n");
}

TEST_CASE("an alias of a free number is a free number of its own") {
  CHECK(balanced("  cw: {on: a, at: [&x {free: [0, 9]}, *x], mass: 1}\n  c2: {on: a, at: [*x, 0], mass: *x }\n") ==
        "  cw: {on: a, at: [3.25, 4.25], mass: 1}\n  c2: {on: a, at: [5.25, 0], mass: 6.25 }\n");
}

TEST_CASE("an alias of what holds free numbers is written out") {
  CHECK(balanced("  cw: &w {on: a, at: [0, {free: [0, 9]}], mass: \"2 * l\"}  # one\n  c2: *w  # two\n") ==
        "  cw: &w {on: a, at: [0, 3.25], mass: \"2 * l\"}  # one\n"
        "  c2: {on: a, at: [0, 4.25], mass: \"2 * l\"}  # two\n");
  CHECK(balanced("  cw: {on: a, at: &p [{free: &b [0, 9]}, 1], mass: 1}\n  c2: {on: a, at: *p, mass: 2}\n"
                 "  c3: {on: a, at: *b, mass: 3}\n") ==
        "  cw: {on: a, at: &p [3.25, 1], mass: 1}\n  c2: {on: a, at: [4.25, 1], mass: 2}\n"
        "  c3: {on: a, at: [0, 9], mass: 3}\n");
}

TEST_CASE("an anchor goes with its free number, whatever characters it has") {
  CHECK(balanced("  cw: {on: a, at: [&a#b {free: [0, 9]}, *a#b ], mass: !<tag:x#y> 1}\n") ==
        "  cw: {on: a, at: [3.25, 4.25 ], mass: !<tag:x#y> 1}\n");
}

TEST_CASE("an alias that no change touches stays an alias") {
  const std::string text = "  cw: {on: a, at: &p [0, 1], mass: 1}\n  c2: {on: a, at: *p, mass: ";
  CHECK(balanced(text + "{free: [0, 9]}}\n") == text + "3.25}\n");
}

TEST_CASE("what --set said is written where the parameter is defined") {
  const auto with_set = [](const std::string& parameters, const ReadOptions& options) {
    const Study study = specs::read(
        specs::with(arm("  cw: {on: a, at: [0, 0], mass: {free: [0, 9]}}"), "parameters: {l: 0.5}\n", parameters),
        options);
    const std::string text = format_balanced_spec(study, values(study, 3.25));
    CHECK(text.find("mass: 3.25}") != std::string::npos);
    return text.substr(text.find("parameters"), text.find("bodies:") - text.find("parameters"));
  };
  const ReadOptions set{.set = {{"l", "9"}, {"l", " 0.75 "}}};
  CHECK(with_set("parameters: {l: 0.5, k: l}  # x\n", set) == "parameters: {l: 0.75, k: l}  # x\n");
  CHECK(with_set("parameters: {l: {free: [0, 1]}, k: l}\n", set) == "parameters: {l: 0.75, k: l}\n");
  CHECK(with_set("parameters:\n  l:  # length\n    free: [0, 1]\n  k: l\n", set) ==
        "parameters:\n  l: 0.75  # length\n  k: l\n");
  CHECK(with_set("parameters:\n  l: k +\n     1 # one\n  k: 2\n", set) == "parameters:\n  l: 0.75 # one\n  k: 2\n");
  CHECK(with_set("parameters:\n  l: >  # fold\n     k +\n     1\n\n  k: 2\n", set) ==
        "parameters:\n  l: 0.75  # fold\n\n  k: 2\n");
  CHECK(with_set("parameters: {l: 'it''s', k: 2}\n", set) == "parameters: {l: 0.75, k: 2}\n");
  CHECK(with_set("parameters: {l: \"a\\\" }\", k: 2}\n", set) == "parameters: {l: 0.75, k: 2}\n");
  CHECK(with_set("parameters: {l: &v 0.5, k: *v}\n", set) == "parameters: {l: 0.75, k: 0.5}\n");
  CHECK(with_set("parameters: {k: &v 0.5, l: *v}\n", set) == "parameters: {k: &v 0.5, l: 0.75}\n");
  CHECK(with_set("parameters: {l: , k: 2}\n", set) == "parameters: {l: 0.75 , k: 2}\n");
  CHECK(with_set("parameters: {l, k: 2}\n", set) == "parameters: {l: 0.75, k: 2}\n");
  CHECK(with_set("parameters:\n  l:\n  k: 2\n", set) == "parameters:\n  l: 0.75\n  k: 2\n");
  CHECK(with_set("parameters:\n  l: ~ # none\n  k: 2\n", set) == "parameters:\n  l: 0.75 # none\n  k: 2\n");
  CHECK(with_set("parameters:\n  l:\n    null\n  k: 2\n", set) == "parameters:\n  l: 0.75\n  k: 2\n");
  CHECK(with_set("parameters: {l: 1, k: 2}\n", {.set = {{"l", "min(k, 3)"}}}) ==
        "parameters: {l: \"min(k, 3)\", k: 2}\n");
}

TEST_CASE("numbers are written in the spec's units with as few digits as it takes") {
  const std::string text =
      "space: planar\n"
      "units: {length: mm, mass: g, angle: deg}\n"
      "bodies: {a: {mass: 1, com: [{free: [-1, 1000]}, 0], inertia: 0.1}}\n"
      "joints: {J: {type: revolute, connects: [ground.origin, a.origin], angle: {free: [0, 360]}}}\n"
      "counterweights: {c: {on: a, at: [0, 0], mass: {free: [0, 1e30]}}}\n";
  const Study study = specs::read(text);
  const auto written = [&](double com, double angle, double mass) {
    const std::string all = format_balanced_spec(study, (VectorX(3) << com, angle, mass).finished());
    std::string numbers;
    for (const char* before : {"com: [", "angle: ", "mass: "}) {
      const auto from = all.rfind(before) + std::string(before).size();
      numbers += all.substr(from, all.find_first_of(",}", from) - from) + " ";
    }
    return numbers;
  };
  const double degree = std::acos(-1.0) / 180;
  CHECK(written(0.123, 30 * degree, 0.0037) == "123 30 3.7 ");
  CHECK(written(-0.0, -72.5 * degree, 1e17) == "0 -72.5 1.0e+20 ");
  CHECK(written(1e-10, 0.1, 1.0 / 3).find("1.0e-07 5.729577951308") == 0);
}

TEST_CASE("values that are missing or not finite are refused") {
  const Study study = specs::read(arm("  cw: {on: a, at: [0, 0], mass: {free: [0, 9]}}"));
  CHECK_THROWS_AS(format_balanced_spec(study, VectorX(0)), std::invalid_argument);
  CHECK_THROWS_AS(format_balanced_spec(study, VectorX::Constant(1, NAN)), std::invalid_argument);
  CHECK_THROWS_AS(format_balanced_spec(study, VectorX::Constant(1, INFINITY)), std::invalid_argument);
}

TEST_CASE("every mechanism in configs is written as it was designed") {
  std::mt19937 random(1);
  int designed = 0;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS)) {
    if (entry.path().extension() != ".yaml") continue;
    std::ostringstream stream;
    stream << std::ifstream(entry.path()).rdbuf();
    if (stream.str().find("\nbodies:") == std::string::npos) continue;
    const std::string freed =
        std::regex_replace(stream.str(), std::regex("mass: ([0-9.]+)([,}])"), "mass: {free: [0, 1000], start: $1}$2");
    for (const std::string& text : {stream.str(), freed}) {
      const Study study = read_spec(text, entry.path().string());
      VectorX x(static_cast<Eigen::Index>(study.free_numbers.size()));
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        const FreeNumber& number = study.free_numbers[static_cast<std::size_t>(i)];
        const double part = static_cast<double>(random()) / 4294967296.0;
        // Near the start, where every spec makes sense.
        x[i] = number.start + 0.01 * part * (number.upper - number.start);
      }
      check_round_trip(text, entry.path().string(), x, {});
      designed += x.size() > 0 ? 1 : 0;
    }
  }
  CHECK(designed > 20);
}

TEST_CASE("whatever the layout, the spec that is written says what was designed, and no comment is lost") {
  int free = 0, changed = 0;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    layouts::Writer writer(seed);
    const std::string text = writer.spec();
    const ReadOptions options = writer.chance(4) ? ReadOptions{.set = {{"p1", "p0 / 4"}}} : ReadOptions{};
    CAPTURE(seed);
    CAPTURE(text);
    const Study study = specs::read(text, options);
    VectorX x(static_cast<Eigen::Index>(study.free_numbers.size()));
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = 0.001 * (1 + writer.number(9000));
    check_round_trip(text, "s.yaml", x, options);
    const std::string written = format_balanced_spec(study, x);
    CHECK(comments_of(written) == comments_of(text));
    CHECK(format_balanced_spec(specs::read(written), VectorX(0)) == written);
    free += static_cast<int>(x.size());
    changed += written != text ? 1 : 0;
  }
  CHECK(free > 3000);
  CHECK(changed > 800);
}
