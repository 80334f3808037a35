// The least added mass over all lengths: published optima, and laws of every bound. The bound of a box is compared with
// the least mass by conditions that are derived at sampled lengths, which share nothing with the closures' polynomials.

#include "exact_certificate.hpp"
#include "linkage_specs.hpp"

#include "../sampling.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/certificate/length_bound.hpp"
#include "balance/synthesis/certificate/linkage_check.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>

using namespace balance;
using namespace balance::certificate;
using linkage_specs::read_text;
using linkage_specs::replace_text;

namespace {

DesignSpace read(const std::string& name) {
  return read_design_space_file(std::string(BALANCE_TEST_DATA) + "/specs/" + name + ".yaml");
}

/// A spec with one text replaced by another.
DesignSpace read_changed(const std::string& name, const std::string& before, const std::string& after) {
  return read_design_space(replace_text(read_text(name), before, after), name + ".yaml");
}

LengthBound bound(const DesignSpace& space, long max_nodes, double gap_tolerance) {
  LengthBoundOptions options;
  options.max_nodes = max_nodes;
  options.gap_tolerance = gap_tolerance;
  options.required_trajectories = list_followed_trajectories(space);
  options.keeps_certificates = true;
  return bound_over_lengths(space, *make_length_design_judge(space, list_followed_trajectories(space)), options);
}

void check_proof(const DesignSpace& space, const LengthBound& result) {
  CHECK(result.proof.size() == result.geometries.size());
  for (const GeometryProof& proof : result.proof)
    CHECK_MESSAGE(find_flaw(proof, result.lower_bound).empty(), space.start.spec_file, ", ", proof.geometry.name, ": ",
                  find_flaw(proof, result.lower_bound));
}

}  // namespace

TEST_CASE("lengths: known optima are proved, with certificates that hold in rational arithmetic") {
  // the digits of the optima; `gap` is what the number of boxes allows
  struct Known {
    const char* spec;
    double value, value_tolerance, gap;
    long max_nodes;
  };
  for (const Known& known :
       {Known{"four_hi_4", 1.43994, 5e-6, 1e-9, 10}, Known{"four_box_1", 0.879082, 5e-7, 1e-9, 10},
        Known{"four_fix21", 1.62062, 5e-6, 1e-9, 10}, Known{"watt_box_1", 3.08961, 5e-5, 1e-4, 40},
        Known{"five_box_1", 7.34350, 5e-5, 1e-5, 200}, Known{"steph_box_1", 2.7836, 2e-3, 1e-3, 120}}) {
    const DesignSpace space = read(known.spec);
    const LengthBound result = bound(space, known.max_nodes, known.gap);
    INFO(std::string(known.spec));
    CHECK(result.reason == "");
    CHECK(result.gap() <= known.gap);
    CHECK(result.lower_bound <= result.best);
    CHECK(std::abs(result.best - known.value) <= known.value_tolerance);
    CHECK(make_length_design_judge(space, list_followed_trajectories(space))->accepts(result.design));
    check_proof(space, result);
  }
}

TEST_CASE("lengths: limits too small for any lengths are proved so") {
  for (const char* spec : {"five_hi_3", "watt_hi_3"}) {
    const DesignSpace space = read(spec);
    const LengthBound result = bound(space, 50, 1e-9);
    INFO(std::string(spec));
    CHECK(result.is_impossible());
    CHECK(result.design.size() == 0);
    check_proof(space, result);
  }
}

TEST_CASE("lengths: the parallelogram is a geometry of its own, lighter than all others or the only one") {
  const LengthBound result = bound(read("four_fix21"), 10, 1e-9);
  CHECK(result.geometries.size() == 2);
  CHECK(result.uncovered.empty());
  REQUIRE(result.design.size() > 2);
  CHECK(result.design[0] == doctest::Approx(0.115));  // the shortest that crank and rocker can both have
  CHECK(result.design[1] == doctest::Approx(0.4));    // the ground
  CHECK(result.design[0] == result.design[2]);
  // crank and rocker of four_box_1 have no length in common
  CHECK(bound(read("four_box_1"), 10, 1e-9).geometries.size() == 1);
}

TEST_CASE("lengths: a linkage that is a parallelogram for all lengths is bounded as one") {
  std::string text = read_text("four_fix21");
  // the rocker is as long as the crank, the coupler as the ground
  for (const auto& [before, after] :
       {std::pair<std::string, std::string>{"points: {O: [0, 0], E: [c, 0]}", "points: {O: [0, 0], E: [a, 0]}"},
        {"points: {O: [0, 0], E: [b, 0]}", "points: {O: [0, 0], E: [d, 0]}"},
        {"a: {free: [0.03732, 0.1493]", "a: {free: [0.115, 0.1493]"},
        {"start: 0.0933", "start: 0.13"}})
    text = replace_text(text, before, after);
  const LengthBound result = bound(read_design_space(text, "parallelogram.yaml"), 30, 1e-9);
  CHECK(result.reason == "");
  CHECK(result.geometries == std::vector<std::string>{"ground–crank–coupler–rocker as a parallelogram"});
  CHECK(std::isfinite(result.best));
  CHECK(result.gap() <= 1e-6);
}

TEST_CASE("lengths: total mass is the added mass and the links' own") {
  const DesignSpace space = read_changed("four_box_1", "minimize: added-mass", "minimize: total-mass");
  const LengthBound total = bound(space, 10, 1e-9), added = bound(read("four_box_1"), 10, 1e-9);
  CHECK(total.gap() <= 1e-9);
  check_proof(space, total);
  // both are least where all links are shortest
  const double links = 0.2275 + 2.3854 * 0.05561 + 0.1469 + 0.8907 * 0.231 + 0.1011 + 2.2252 * 0.1769;
  CHECK(total.best == doctest::Approx(added.best + links).epsilon(1e-9));
}

/// The law that no box has a bound above the least mass at any of its lengths.
struct BoxLaw {
  std::mt19937 random;
  int compared = 0, sharp = 0;

  /// @param boxes and those of them whose certificates are checked in rational arithmetic
  void check(const DesignSpace& space, int boxes, int exact_boxes) {
    // both solvers' tolerance, 1e-10, with a margin
    constexpr double relative_tolerance = 1e-8;
    std::uniform_real_distribution<double> unit(0, 1);
    const LengthGeometries listed = list_length_geometries(space, list_followed_trajectories(space));
    REQUIRE_MESSAGE(listed.reason.empty(), listed.reason);
    const LengthGeometry& geometry = listed.geometries[0];
    const BoxProgram unconditional(geometry.linkage, geometry.dual, {});
    const BoxProgram conditional(geometry.linkage, geometry.dual, geometry.conditions);
    for (int trial = 0; trial < boxes; ++trial) {
      const bool has_conditions = trial % 8 >= 6;
      const BoxProgram& program = has_conditions ? conditional : unconditional;
      LengthBox box = geometry.box;
      const double width = std::array{1.0, 0.3, 0.03, 0.001}[static_cast<std::size_t>(trial % 4)];
      std::vector<int> affine;
      for (const int length : program.lengths()) {
        const double whole = box.upper[length] - box.lower[length];
        box.lower[length] += unit(random) * (1 - width) * whole;
        box.upper[length] = box.lower[length] + width * whole;
        if (affine.size() < static_cast<std::size_t>(trial % 3) && unit(random) < 0.6) affine.push_back(length);
      }
      std::vector<MassLimits> limits = list_mass_limits(geometry.linkage);
      for (MassLimits& limit : limits) limit.is_upper_used = trial % 2 == 0;
      const BoxBound result = program.bound(box, affine, limits);
      if (trial < exact_boxes) CHECK(find_flaw(box, result.bound, result.certificate, geometry) == "");
      std::vector<int> numbers = program.lengths();
      for (const int ratio : list_free_ratios(geometry.linkage)) numbers.push_back(ratio);
      for (int sample = 0; sample < 4; ++sample) {
        VectorX x = space.start_values();
        for (const int length : numbers) {
          const double part = sample == 0 ? std::round(unit(random)) : unit(random);
          x[length] = box.lower[length] + part * (box.upper[length] - box.lower[length]);
        }
        const auto is_met = [&](const LengthCondition& condition) {
          return condition.polynomial.evaluate(x).real() >= 0;
        };
        if (has_conditions && !std::all_of(geometry.conditions.begin(), geometry.conditions.end(), is_met)) continue;
        const std::optional<double> value = compute_min_mass(space, geometry.linkage, x);
        if (!value) continue;
        compared += std::isfinite(*value) ? 1 : 0;
        CHECK_MESSAGE(result.bound <= *value * (1 + relative_tolerance), space.start.spec_file, " ", trial);
        sharp += result.bound >= *value * (1 - 1e-3) ? 1 : 0;
      }
    }
  }
};

// per spec; the whole has 20,000 lengths and 200 certificates
int box_count() { return sampling::is_whole() ? 1200 : 8; }
int exact_box_count() { return sampling::is_whole() ? 40 : 8; }

TEST_CASE("lengths: no box has a bound above the least mass at any of its lengths") {
  BoxLaw law{sampling::generator("boxes of lengths")};
  for (const char* spec : {"four_hi_4", "four_box_1", "five_box_1", "watt_box_1", "steph_box_1"})
    law.check(read(spec), box_count(), exact_box_count());
  MESSAGE(law.compared, " lengths compared, ", law.sharp, " bounds within 0.1 % of the least mass");
  CHECK(law.compared >= 60);
  CHECK(law.sharp >= 5);  // the law is tested where it is tight
}

TEST_CASE("lengths: nor with slides along the ground or a lever, pins in slots, gears and discs, forces or statics") {
  BoxLaw law{sampling::generator("boxes of lengths of slides and gears")};
  for (const char* spec : {"slider_crank", "quick_return", "two_yokes", "geared_arm"}) {
    law.check(read(spec), box_count(), exact_box_count());
    std::string text = replace_text(read_text(spec), "goal: force", "goal: static");
    law.check(read_design_space(replace_text(text, "[0, -9.81]", "[3, -9]"), std::string(spec) + ".yaml"), box_count(),
              exact_box_count());
  }
  CHECK(law.compared >= 150);
  CHECK(law.sharp >= 30);
}

TEST_CASE("lengths: with slides, yokes and gears the least mass is that of a hand calculation") {
  struct Known {
    const char *spec, *goal;
    double value;
  };
  const double a = 0.06, b = 0.25;  // all are least where crank and rod are shortest
  for (const Known& known :
       {// the rod's counterweight at -0.1 carries the slider to the pin, the crank's all of it to the bearing
        Known{"slider_crank", "goal: force", 6.2 * b + 10 * a * (0.1 + 0.3 + 0.5 + 6.2 * b)},
        // the guide carries the slider, and a part of the rod: what is left of it hangs on the pin
        Known{"slider_crank", "goal: static", 10 * a * (0.1 + 0.3 - 0.12)},
        // the block hangs on the crank; the lever has its own counterweight at -0.15
        Known{"quick_return", "goal: force", 10 * a * (0.1 + 0.3) + 0.9 * 0.2 / 0.15},
        // both yokes have the same product of mass and crank: 1.5 kg at 0.04 m, 1.2 kg and the rest at 0.04 m
        Known{"two_yokes", "goal: force", 1 * 0.02 / 0.1 + (1.5 - 1.2)}}) {
    const DesignSpace space = read_changed(known.spec, "goal: force", known.goal);
    const LengthBound result = bound(space, 10, 1e-9);
    INFO(std::string(known.spec), " ", known.goal);
    CHECK(result.reason == "");
    CHECK(result.uncovered.empty());
    CHECK(result.best == doctest::Approx(known.value).epsilon(1e-9));
    CHECK(result.gap() <= 1e-9);
    check_proof(space, result);
  }
  // the forearm does not turn and the hand turns with the upper arm: the conditions derived at the best length know
  const DesignSpace arm = read("geared_arm");
  const LengthBound result = bound(arm, 10, 1e-9);
  CHECK(result.gap() <= 1e-9);
  const LengthGeometry geometry = list_length_geometries(arm, {}).geometries[0];
  REQUIRE(result.design.size() > 0);
  CHECK(result.design[0] == 0.2);
  CHECK(compute_min_mass(arm, geometry.linkage, result.design).value() == doctest::Approx(result.best).epsilon(1e-9));
}

TEST_CASE("lengths: special geometries of slides are named where the lengths allow them") {
  const auto uncovered = [](const std::string& spec, const std::string& before, const std::string& after) {
    return list_length_geometries(read_changed(spec, before, after), {}).uncovered;
  };
  // crank and rod as long as each other turn as one
  CHECK(uncovered("slider_crank", "b: {free: [0.25, 0.5]", "b: {free: [0.1, 0.5]") ==
        std::vector<std::string>{"crank and rod of one length, in line with S"});
  // the pin reaches the lever's bearing
  CHECK(uncovered("quick_return", "d: {free: [0.2, 0.3]", "d: {free: [0.1, 0.3]") ==
        std::vector<std::string>{"the slide S through the bearing of lever"});
}

TEST_CASE("lengths: dynamic balance with discs is proved by the conditions of forces and moments") {
  const DesignSpace space = read("four_with_discs");
  const LengthBound result = bound(space, 60, 1e-9);
  CHECK(result.reason == "");
  CHECK(result.gap() <= 1e-9);
  REQUIRE(result.design.size() > 0);
  CHECK(make_length_design_judge(space, list_followed_trajectories(space))->accepts(result.design));
  check_proof(space, result);
  // the discs are on the bearings: with forces alone, their least masses are added to those of the counterweights
  const LengthBound forces = bound(read("four_box_1"), 10, 1e-9);
  CHECK(result.lower_bound > 1.1 * (forces.best + 0.3 + 0.1));
  // the bound of the conditions of moments alone is lower
  const DesignSpace moment =
      read_design_space(replace_text(read_text("four_with_discs"), "goal: dynamic", "goal: moment"), "discs.yaml");
  const LengthBound moments = bound(moment, 20, 1e-9);
  CHECK(moments.gap() <= 1e-8);
  CHECK(moments.lower_bound < result.lower_bound);
  check_proof(moment, moments);
}

TEST_CASE("lengths: a disc against a link has the least mass of a hand calculation") {
  // the counterweight at -0.1 has 2 a / 0.1, and the disc in the ratio -10 the inertia of both
  const double a = 0.1, counterweight = 2 * a / 0.1, inertia = 0.01 + 2 * a * a + counterweight * 0.1 * 0.1;
  const LengthBound dynamic = bound(read("link_with_disc"), 5, 1e-9);
  CHECK(dynamic.best == doctest::Approx(counterweight + inertia / 10 / 0.02).epsilon(1e-9));
  CHECK(dynamic.gap() <= 1e-9);
  // moments about the bearing ask for no counterweight
  const std::string about = replace_text(read_text("link_with_disc"), "goal: dynamic", "goal: moment");
  const DesignSpace space =
      read_design_space(replace_text(about, "drive: joints", "drive: joints, about: [0.3, 0.1]"), "link.yaml");
  const LengthBound moment = bound(space, 5, 1e-9);
  CHECK(moment.best == doctest::Approx((0.01 + 2 * a * a) / 10 / 0.02).epsilon(1e-9));
  CHECK(moment.gap() <= 1e-9);
}

TEST_CASE("lengths: slider-cranks and five-bars with discs are proved, too") {
  for (const char* spec : {"slider_with_discs", "five_with_discs"}) {
    INFO(std::string(spec));
    const DesignSpace space = read(spec);
    const LengthBound result = bound(space, 20, 1e-8);
    CHECK(result.gap() <= 1e-7);
    CHECK(result.uncovered.empty());
    check_proof(space, result);
  }
}

TEST_CASE("lengths: with moments, no box has a bound above the least mass at any of its lengths and ratios") {
  BoxLaw law{sampling::generator("boxes of lengths with discs")};
  law.check(read("four_with_discs"), box_count(), exact_box_count() / 2);
  law.check(
      read_design_space(replace_text(read_text("four_with_discs"), "goal: dynamic", "goal: moment"), "discs.yaml"),
      box_count(), exact_box_count() / 2);
  for (const char* spec : {"link_with_disc", "slider_with_discs", "five_with_discs"})
    law.check(read(spec), box_count(), exact_box_count() / 4);
  // moments without forces depend on the point that they are about
  std::string about = replace_text(read_text("four_with_discs"), "goal: dynamic", "goal: moment");
  about = replace_text(about, "drive: joints", "drive: joints, about: [0.05, 0.02]");
  law.check(read_design_space(about, "about.yaml"), box_count(), exact_box_count() / 4);
  MESSAGE(law.compared, " lengths compared, ", law.sharp, " bounds within 0.1 % of the least mass");
  CHECK(law.compared >= 100);
  CHECK(law.sharp >= 10);
}

/// A four-bar without counterweights or discs.
Mechanism four_bar(double a, double b, double c, double d, const char* assembly) {
  const auto with_lengths = [&](std::string text) {
    for (const auto& [name, value] :
         {std::pair{"a: {free: [0.05561, 0.1298], start: 0.09269}", a},
          std::pair{"b: {free: [0.231, 0.539], start: 0.385}", b},
          std::pair{"c: {free: [0.1769, 0.4127], start: 0.2948}", c}, std::pair{"d: 0.4", d}})
      text = replace_text(text, name, name[0] + (": " + std::to_string(value)));
    return replace_text(text, "{A: 0.5, B: 0.1, D: 1.8}", assembly);
  };
  return read_design_space(with_lengths(read_text("four_box_1")), "four.yaml").start.mechanism;
}

TEST_CASE("lengths: only parallelograms and kites have fewer conditions of moments than other four-bars") {
  const auto rank = [](double a, double b, double c, double d, const char* assembly = "{A: 0.5, B: 0.1, D: 1.8}") {
    return derive_conditions(four_bar(a, b, c, d, assembly), {Goal{GoalKind::dynamic}}).rank;
  };
  const int general = rank(0.1, 0.4, 0.3, 0.37);
  CHECK(rank(0.1, 0.4, 0.25, 0.25) == general);  // one pair of equal sides
  CHECK(rank(0.1, 0.4, 0.2, 0.3) == general);    // can be flattened
  CHECK(rank(0.1, 0.2, std::sqrt(0.0725), 0.15, "{A: 1.5, B: -0.5, D: 1.5}") == general);
  CHECK(rank(0.1, 0.4, 0.1, 0.4, "{A: 0.5, B: -0.3, D: -0.7}") < general);  // an antiparallelogram
  CHECK(rank(0.1, 0.1, 0.3, 0.3, "{A: 1.5, B: 1.0, D: 1.8}") < general);    // a kite
}

TEST_CASE("lengths: what special geometries may do without discs is not called impossible") {
  const auto goal = [](const std::string& text) { return replace_text(text, "goal: force", "goal: dynamic"); };
  // no general lengths are balanced dynamically without discs, but parallelograms by their forces may be
  const LengthBound parallelogram = bound(read_design_space(goal(read_text("four_fix21")), "four.yaml"), 20, 1e-9);
  CHECK(parallelogram.geometries.size() == 2);
  CHECK(!parallelogram.is_impossible());
  const std::string kite = replace_text(goal(read_text("four_box_1")), "d: 0.4", "d: {free: [0.08, 0.4], start: 0.39}");
  const LengthBound kites = bound(read_design_space(kite, "four.yaml"), 20, 1e-9);
  CHECK(kites.geometries == std::vector<std::string>{"general lengths", "ground–crank–coupler–rocker as a kite"});
  CHECK(!kites.is_impossible());
  CHECK(bound(read_design_space(goal(read_text("four_box_1")), "four.yaml"), 20, 1e-9).is_impossible());
}

TEST_CASE("lengths: conditions of assembly remove no lengths that the mechanism can be assembled with") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  int assembled = 0, removed = 0;
  // the tool goes farther than some lengths reach
  for (const char* target : {"[0.32, 0.42]", "[0.4, 0.6]"}) {
    const DesignSpace space = read_changed("five_box_1", "[0.32, 0.42]", target);
    const LengthGeometry geometry = list_length_geometries(space, list_followed_trajectories(space)).geometries[0];
    CHECK(!geometry.conditions.empty());
    for (int trial = 0; trial < 60; ++trial) {
      VectorX x = space.start_values();
      LengthBox box = geometry.box;
      for (int i = 0; i < 4 && i < x.size(); ++i) {
        if (space.start.free_numbers[static_cast<std::size_t>(i)].key_path.rfind("parameters.", 0) != 0) continue;
        x[i] = box.lower[i] + unit(random) * (box.upper[i] - box.lower[i]);
        const double half_width = trial % 2 == 0 ? 0.02 : 0.001;
        box.lower[i] = std::max(box.lower[i], x[i] - half_width);
        box.upper[i] = std::min(box.upper[i], x[i] + half_width);
      }
      const LengthBox before = box;
      const bool is_left = contract(geometry.conditions, box);
      removed += !is_left || box.lower != before.lower || box.upper != before.upper ? 1 : 0;
      if (!linkage_specs::can_move(space, x)) continue;
      ++assembled;
      CHECK(is_left);
      CHECK((x.array() >= box.lower.array()).all());
      CHECK((x.array() <= box.upper.array()).all());
    }
  }
  CHECK(assembled >= 10);
  CHECK(removed >= 10);
}

TEST_CASE("lengths: more boxes never lower the bound nor raise the best design") {
  std::vector<std::string> specs{"five_box_1"};
  if (sampling::is_whole()) specs.insert(specs.end(), {"four_hi_4", "four_fix21", "watt_box_1", "steph_box_1"});
  for (const std::string& spec : specs) {
    const DesignSpace space = read(spec);
    double bound_before = 0, best_before = std::numeric_limits<double>::infinity();
    for (const long nodes : {1, 5, 20, 60}) {
      const LengthBound result = bound(space, nodes, 1e-9);
      INFO(spec, ", ", nodes);
      CHECK(result.lower_bound >= bound_before);
      CHECK(result.best <= best_before);
      bound_before = result.lower_bound;
      best_before = result.best;
    }
  }
}

TEST_CASE("lengths: what is no polynomial, or no planar linkage, has no certificate and says why") {
  const auto reason = [](const std::string& before, const std::string& after) {
    return bound(read_changed("four_box_1", before, after), 5, 1e-9).reason;
  };
  CHECK(reason("0.5925 * b + 0.0046", "0.5925 * sin(b)") ==
        "coupler's centre of mass is not a polynomial of the free numbers");
  CHECK(reason("0.1469 + 0.8907 * b", "0.2 / (1 + b)") == "coupler's mass is not a polynomial of the free numbers");
  CHECK(reason("minimize: added-mass", "minimize: rms(torque)") ==
        "the objective is neither the added mass nor the total mass");
  CHECK(reason("goal: force", "goal: gyroscopic") ==
        "the goals require neither balanced forces nor balanced statics or moments");
  CHECK(reason("[0, -9.81]", "[0, 0]") == "");  // shaking forces do not ask for gravity
  CHECK(bound(read_changed("five_box_1", "[0, -9.81]", "[0, 0]"), 5, 1e-9).reason == "there is no gravity");
  CHECK(reason("0.1469 + 0.8907 * b", "0.1469 + 0.8907 * b^2") == "");
  const auto gear_reason = [](const std::string& before, const std::string& after) {
    return list_length_geometries(read_changed("geared_arm", before, after), {}).reason;
  };
  CHECK(gear_reason("ratio: 1}", "ratio: {free: [0.5, 2]}}") == "the ratio of C is free");
  CHECK(gear_reason("ratio: 1}", "ratio: 0.4}") == "");
}
