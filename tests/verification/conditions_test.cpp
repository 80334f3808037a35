/// The conditions for a force balance read off from the coefficient matrices C_P against those from sampled momenta: the first
/// know points and lengths, the second a tree's recursions; they share the mechanism and its parameters.

#include "random_linkages.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/verification/formulation_check.hpp"
#include "balance/synthesis/verification/natural_momentum.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

using namespace balance;
using namespace balance::verification;
using namespace natural_tests;

namespace {

natural::ForceConditions read_off(const Mechanism& mechanism) {
  const NaturalStart start = find_natural_start(mechanism);
  REQUIRE(start.outcome.status == MotionStatus::done);
  return natural::force_conditions(mechanism, start.start);
}

ConditionsVerification compare(const Mechanism& mechanism) {
  Study study;
  study.mechanism = mechanism;
  return verify_conditions(study);
}

/// @return how many linkages could be compared
int check_crowd(const Recipe& recipe, std::uint32_t first, std::uint32_t count) {
  int compared = 0;
  for (std::uint32_t seed = first; seed < first + count; ++seed) {
    CAPTURE(seed);
    const Mechanism linkage = random_linkage(recipe, seed);
    const ConditionsVerification found = compare(linkage);
    if (!found.reason.empty()) continue;  // no room to move
    CHECK(found.sampled == found.coefficients);
    CHECK(found.subspace_angle_sine < 1e-9);
    CHECK(read_off(linkage).special_relations == 0);  // lengths are in general position
    ++compared;
  }
  return compared;
}

Mechanism load(const std::string& file) { return read_spec_file(std::string(BALANCE_CONFIGS "/") + file).mechanism; }

}  // namespace

TEST_CASE("C_P: random four-bars, with and without a slider, have the conditions that sampling finds") {
  CHECK(check_crowd({.cranks = 1, .dyads = 1}, 100, 6) >= 5);
  CHECK(check_crowd({.cranks = 1, .dyads = 1, .sliders = 1}, 200, 8) >= 6);
}

TEST_CASE(
    "C_P: random five-bars, geared five-bars and five-bars with sliders have the conditions that sampling finds") {
  CHECK(check_crowd({.cranks = 2, .dyads = 1}, 300, 5) >= 4);
  CHECK(check_crowd({.cranks = 2, .dyads = 1, .gears = true}, 400, 5) >= 4);
  CHECK(check_crowd({.cranks = 2, .dyads = 1, .sliders = 1}, 500, 5) >= 4);
}

TEST_CASE("C_P: random six-bars with ternary links and sliders have the conditions that sampling finds") {
  CHECK(check_crowd({.cranks = 1, .dyads = 2}, 600, 8) >= 6);
  CHECK(check_crowd({.cranks = 1, .dyads = 2, .sliders = 0.7}, 700, 10) >= 8);
}

TEST_CASE(
    "C_P: random eight-bars with ternary and quaternary links and sliders have the conditions that sampling finds") {
  CHECK(check_crowd({.cranks = 1, .dyads = 3}, 800, 8) >= 6);
  CHECK(check_crowd({.cranks = 1, .dyads = 3, .sliders = 0.6}, 900, 8) >= 6);
  CHECK(check_crowd({.cranks = 2, .dyads = 3, .sliders = 0.3}, 950, 4) >= 3);
}

TEST_CASE(
    "C_P: every moving joint between links of two or three joints gives two conditions, a third point of a link none") {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    CAPTURE(seed);
    const natural::ForceConditions found = read_off(random_linkage({.cranks = 1, .dyads = 2}, seed));
    REQUIRE(found.is_valid);
    CHECK(found.matrix.rows() == 2 * (found.points - found.relations));
  }
}

TEST_CASE("C_P: a parallelogram's coupler does not turn, which no general four-bar's does") {
  const natural::ForceConditions parallelogram = read_off(load("parallelogram.yaml"));
  CHECK(parallelogram.special_relations > 0);
  CHECK(parallelogram.matrix.rows() == 2);
  CHECK(read_off(load("four-bar.yaml")).special_relations == 0);
}

TEST_CASE("C_P: discs whose rim follows a link exactly are found to do so") {
  Mechanism arm = load("double-pendulum.yaml");
  // turns with the second link: carried by the first, ratio one
  arm.discs.push_back({.name = "d", .body = 1, .position = {0.1, 0.05, 0}, .follows = 1, .ratio = 1, .mass = 0.3});
  arm.discs.back().inertia(2, 2) = 0.001;
  const ConditionsVerification found = compare(arm);
  CHECK(found.reason.empty());
  CHECK(found.sampled == 4);
  CHECK(found.subspace_angle_sine < 1e-12);
}
