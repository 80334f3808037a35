#include "specs.hpp"

#include <algorithm>
#include <clocale>
#include <cmath>
#include <numbers>

namespace parameters_test {

using namespace balance;

namespace {

/// The value of an expression, by way of a counterweight's mass.
double value_of(const std::string& expression, const ReadOptions& options = {}) {
  const std::string text = specs::with(specs::planar, "mass: {free: [0, 10]}", "mass: " + expression);
  return specs::read(text, options).mechanism.attachments[0].mass;
}

const double rounding = 1e-14;  // a few operations

}  // namespace

TEST_CASE("a number may be an expression over parameters") {
  CHECK(value_of("3") == 3);
  CHECK(value_of("+3.5e-1") == 0.35);
  CHECK(value_of("l") == 0.5);
  CHECK(value_of("\"2 * (l + k) ^ 2\"") == doctest::Approx(2 * 0.75 * 0.75).epsilon(rounding));
  CHECK(value_of("sqrt(2) * sin(pi / 6)") == doctest::Approx(std::sqrt(2) / 2).epsilon(rounding));
  CHECK(value_of("\"atan2(1, 1) + max(1, 2, l)\"") == doctest::Approx(std::numbers::pi / 4 + 2).epsilon(rounding));
  CHECK(value_of("2e1 + 1e-1") == doctest::Approx(20.1).epsilon(rounding));
}

TEST_CASE("parameters may use each other in any order") {
  const std::string text =
      specs::with(specs::planar, "{l: 0.5, m: 2, k: \"l / 2\"}", "{k: \"l / n\", l: \"1 / n\", m: k, n: 2}");
  const Study study = specs::read(text);
  CHECK(study.mechanism.bodies[1].com.x() == 0.25);
  CHECK(study.mechanism.bodies[1].mass == 0.25);
}

TEST_CASE("--set overrides a parameter and everything that depends on it") {
  CHECK(value_of("k", {.set = {{"l", "3"}}}) == 1.5);
  CHECK(value_of("k", {.set = {{"k", "l * 10"}}}) == 5);
  CHECK(value_of("k", {.set = {{"l", "1"}, {"l", "4"}}}) == 2);
}

TEST_CASE("--set complains about unknown names, bad values and circles") {
  const auto complaint = [](const char* name, const char* value) {
    return specs::complaint(specs::planar, {.set = {{name, value}}});
  };
  CHECK(complaint("kk", "1") == "--set kk: expected a parameter (l, m or k), found 'kk'; nearest is 'k'");
  CHECK(complaint("k", "1 +").find("--set k: expected a number or an expression, found '1 +'") == 0);
  CHECK(complaint("k", "x").find("--set k: expected a number or an expression, found 'x': there is no parameter 'x'") ==
        0);
  CHECK(complaint("l", "k") ==
        "--set l: expected a parameter that does not depend on itself, found the cycle l → k → l");
  CHECK(complaint("l", "").find("--set l: expected a number") == 0);
}

TEST_CASE("numbers are read with a decimal point whatever the locale") {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "C.UTF-8"}) {
    if (std::setlocale(LC_ALL, name) == nullptr) continue;
    CHECK(value_of("1.5") == 1.5);
    CHECK(value_of("\"1.5 + 0.25\"") == 1.75);
  }
  std::setlocale(LC_ALL, before.c_str());
}

TEST_CASE("free numbers hold their start value and are listed with their bounds") {
  const std::string text = specs::with(specs::with(specs::planar, "com: [0, 0], inertia: 0.001}",
                                                   "com: [{free: [-0.5, 0.5], start: 0.1}, 0], inertia: 0.001}"),
                                       "m: 2", "m: {free: [1, \"2 + 3\"]}");
  const Study study = specs::read(text);
  CHECK(study.mechanism.bodies[1].mass == 3);
  CHECK(study.mechanism.bodies[3].com.x() == 0.1);
  REQUIRE(study.free_numbers.size() == 3);
  CHECK(study.free_numbers[0].key_path == "parameters.m");
  CHECK(study.free_numbers[0].lower == 1);
  CHECK(study.free_numbers[0].upper == 5);
  CHECK(study.free_numbers[0].start == 3);
  CHECK(study.free_numbers[1].key_path == "bodies.wheel.com[0]");
  CHECK(study.free_numbers[1].start == 0.1);
  CHECK(study.free_numbers[2].key_path == "counterweights.cw.mass");
  CHECK(study.free_numbers[2].upper == 10);
}

TEST_CASE("a free number that the motion shares among trajectories is one free number") {
  const std::string text =
      specs::with(specs::planar, "from: {tool: [0.6, 0.1]", "from: {tool: [{free: [0.5, 0.7]}, 0.1]");
  CHECK(specs::read(text).free_numbers.size() == 2);
}

TEST_CASE("units scale every number by its dimension") {
  const std::string text = R"(
space: planar
units: {length: mm, mass: g, angle: deg, time: ms, force: kN}
gravity: [0, -9810]
ground: {points: {S: [1000, 0]}}
bodies:
  a: {mass: 2000, com: [100, 0], inertia: 3.0e+9, points: {P: [500, 0]}}
  b: {mass: 1000, com: [{free: [0, 100]}, 0], inertia: 1.0e+6}
joints:
  J: {type: revolute, connects: [ground.origin, a.origin], angle: 90}
  S: {type: prismatic, connects: [a.P, b.origin]}
couplings: [{joint: S, follows: J, ratio: 10, offset: 5}]
discs: {d: {on: a, at: [0, 0], follows: S, ratio: 180, inertia: 1000}}
loads: {l: {on: b, force: [1, 0], moment: 2}}
springs: {s: {between: [ground.S, a.P], stiffness: 3, free_length: 200}}
friction: {J: {viscous: 1, coulomb: 4}, S: {viscous: 2}}
tool: b.origin
assembly: {J: 180, S: 20}
motion: {duration: 500, from: {joints: {J: 0}}, to: {joints: {J: 360}}, about: [10, 20]}
)";
  const Study study = specs::read(text);
  const Mechanism& m = study.mechanism;
  const double pi = std::numbers::pi;
  const auto same = [](double value, double expected) { return value == doctest::Approx(expected).epsilon(rounding); };
  CHECK(same(m.gravity.y(), -9810 * 1e-3 / 1e-6));
  CHECK(same(m.bodies[1].mass, 2));
  CHECK(same(m.bodies[1].com.x(), 0.1));
  CHECK(same(m.bodies[1].inertia(2, 2), 3));
  CHECK(same(m.joints[0].rotation(1, 0), 1));
  CHECK(same(m.couplings[0].ratio, 10 * 1e-3 / (pi / 180)));
  CHECK(same(m.couplings[0].offset, 0.005));
  CHECK(same(m.discs[0].ratio, pi / 1e-3));
  CHECK(same(m.discs[0].inertia(2, 2), 1e-6));
  CHECK(same(m.loads[0].force[0].x(), 1000));
  CHECK(same(m.loads[0].moment[0].z(), 2));
  CHECK(same(m.springs[0].stiffness, 3e6));
  CHECK(same(m.springs[0].free_length, 0.2));
  CHECK(same(m.friction[0].viscous, 1e3 * 1e-3 * 1e-3 / (pi / 180)));
  CHECK(same(m.friction[0].coulomb, 4));
  CHECK(same(m.friction[1].viscous, 2 * 1e3 * 1e-3 / 1e-3));
  CHECK(same(m.assembly[0].value, pi));
  CHECK(same(m.assembly[1].value, 0.02));
  CHECK(same(study.free_numbers[0].upper, 0.1));
  CHECK(same(study.trajectories[0].duration, 0.5));
  CHECK(same(study.trajectories[0].to.joints[0].value, 2 * pi));
  CHECK(same(study.trajectories[0].about.y(), 0.02));
}

TEST_CASE("without a unit of its own a force is measured in mass times length by time squared") {
  const std::string text = specs::with(specs::planar, "{length: m, angle: rad}", "{length: mm, mass: t}");
  const Mechanism m = specs::read(text).mechanism;
  CHECK(m.loads[0].force[0].x() == doctest::Approx(5).epsilon(rounding));
  CHECK(m.springs[0].stiffness == doctest::Approx(100 * 1e3).epsilon(rounding));
}

TEST_CASE("the earth's gravity in metres is suspicious where lengths are in millimetres") {
  const auto warnings = specs::read(specs::with(specs::planar, "{length: m, angle: rad}", "{length: mm}")).warnings;
  CHECK(std::count_if(warnings.begin(), warnings.end(), [](const std::string& warning) {
          return warning.find("gravity: 9.81 in the spec's units is not the earth's") != std::string::npos;
        }) == 1);
}

}  // namespace parameters_test
