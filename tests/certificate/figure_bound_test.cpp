// Figures along a motion over boxes of lengths. Intervals are compared with sampled values; the motion with the
// program's own; bounds with optima at sampled lengths, which come from the program's forces and a cone program, and
// with runs of random designs.

#include "linkage_specs.hpp"

#include "balance/foundation/base/interval_jet.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/certificate/figure_bound.hpp"
#include "balance/synthesis/design/assembly_continuation.hpp"
#include "balance/synthesis/design/figure_request.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <random>
#include <string>
#include <vector>

using namespace balance;
using namespace balance::certificate;
using linkage_specs::read_text;
using linkage_specs::replace_text;

namespace {

/// A design of `specs` that minimises a figure, with a few of its lengths and all masses and places free.
struct FigureCase {
  DesignSpace space;
  std::vector<ObjectiveTerm> terms;
  FigureProblem problem;
  std::unique_ptr<ForceRowModel> rows;

  /// @param part of the lengths' intervals about the start values
  FigureCase(const std::string& name, const std::string& before, const std::string& design,
             const std::vector<std::string>& lengths, double part) {
    const std::string text = replace_text(read_text(name), before, "design: {minimize: " + design + "}");
    DesignSpace all = read_design_space(text, name + ".yaml");
    std::vector<int> free;
    for (std::size_t i = 0; i < all.start.free_numbers.size(); ++i) {
      FreeNumber& number = all.start.free_numbers[i];
      const bool is_parameter = number.key_path.starts_with("parameters.");
      if (number.key_path.ends_with(".mass")) number.upper = 2;
      if (is_parameter) {
        number.lower = number.start + part * (number.lower - number.start);
        number.upper = number.start + part * (number.upper - number.start);
      }
      if (!is_parameter || std::count(lengths.begin(), lengths.end(), number.key_path.substr(11)) > 0)
        free.push_back(static_cast<int>(i));
    }
    space = design::follow_assembly_mode(all.fix_others(all.start_values(), free), true);
    terms = space.start.design.minimize;
    std::string reason;
    const FigureRequest request = design::read_figure_request(space, terms, reason);
    REQUIRE(reason.empty());
    problem = read_figure_problem(space, request);
    REQUIRE(problem.reason.empty());
    REQUIRE(problem.lengths.size() == lengths.size());
    rows = design::make_force_row_model(space, terms, problem);
  }

  std::optional<FigureDual> solve(const VectorX& x) const {
    const std::optional<ForceRows> at = rows->evaluate(x);
    return at ? solve_figure_dual(problem, space.instantiate(x).mechanism, *at, x) : std::nullopt;
  }

  LengthBox whole_box() const { return {problem.lower, problem.upper}; }

  template <class Random>
  LengthBox random_box(Random& random, double width) const {
    LengthBox box = whole_box();
    for (const int k : problem.lengths) {
      const double range = problem.upper[k] - problem.lower[k];
      const double centre = std::uniform_real_distribution<>(problem.lower[k], problem.upper[k])(random);
      box.lower[k] = std::max(problem.lower[k], centre - width * range / 2);
      box.upper[k] = std::min(problem.upper[k], centre + width * range / 2);
    }
    return box;
  }

  template <class Random>
  VectorX random_lengths(Random& random, const LengthBox& box) const {
    VectorX x = space.start_values();
    for (const int k : problem.lengths) x[k] = std::uniform_real_distribution<>(box.lower[k], box.upper[k])(random);
    return x;
  }

  VectorX middle(const LengthBox& box) const {
    VectorX x = space.start_values();
    for (const int k : problem.lengths) x[k] = box.middle()[k];
    return x;
  }

  /// Of the whole bound of a box: corners solved anew.
  FigureBoxBound bound(const LengthBox& box) const {
    std::vector<std::optional<FigureDual>> duals;
    for (std::size_t c = 0; c < std::size_t(1) << problem.lengths.size(); ++c) {
      VectorX corner = middle(box);
      for (std::size_t k = 0; k < problem.lengths.size(); ++k)
        corner[problem.lengths[k]] = (c >> k & 1U ? box.upper : box.lower)[problem.lengths[k]];
      duals.push_back(solve(corner));
    }
    std::vector<const FigureDual*> corners;
    for (const std::optional<FigureDual>& dual : duals) corners.push_back(dual ? &*dual : nullptr);
    const VectorX weights = rows->evaluate(space.start_values())->figures.front().front().time_weights;
    return bound_figures(space, problem, box, sample_planar_motion(space, problem, middle(box)), corners, weights);
  }
};

const char* const crank_design = "design: {goal: force, minimize: added-mass}";
const char* const tool_design = "design: {goal: static, minimize: added-mass}";

std::deque<FigureCase> all_cases() {
  std::deque<FigureCase> cases;  // the models refer to their cases, which must not move
  cases.emplace_back("slider_crank", crank_design, "rms(shaking_force)", std::vector<std::string>{"a", "b"}, 0.5);
  cases.emplace_back("slider_crank", crank_design, "peak(torque)", std::vector<std::string>{"b"}, 0.5);
  cases.emplace_back("four_box_1", crank_design, "rms(shaking_moment)", std::vector<std::string>{"a"}, 0.5);
  cases.emplace_back("five_box_1", tool_design, "rms(torque)", std::vector<std::string>{"a11"}, 0.2);
  cases.emplace_back("five_box_1", tool_design, "peak(shaking_force)", std::vector<std::string>{"a12"}, 0.2);
  cases.emplace_back("watt_box_1", crank_design,
                     "[{rms: torque, along: go}, {peak: shaking_force, along: go, weight: 2}]",
                     std::vector<std::string>{"ex"}, 0.2);
  return cases;
}

}  // namespace

TEST_CASE("intervals contain what they are computed from, in extended precision") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-30, 30), unit(-1, 1);
  for (int trial = 0; trial < 4'000; ++trial) {
    const double a = unit(random) * std::exp(exponent(random)), b = unit(random) * std::exp(exponent(random));
    const auto contains = [](const Interval& x, long double value) { return x.lower <= value && value <= x.upper; };
    const long double la = a, lb = b;
    REQUIRE(contains(Interval(a) + Interval(b), la + lb));
    REQUIRE(contains(Interval(a) - Interval(b), la - lb));
    REQUIRE(contains(Interval(a) * Interval(b), la * lb));
    REQUIRE(contains(Interval(a) * b, la * lb));
    REQUIRE(contains(Interval(a) / Interval(b), la / lb));
    REQUIRE(contains(sqrt(Interval(std::abs(a))), std::sqrt(std::abs(la))));
    const double angle = 50 * unit(random);
    REQUIRE(contains(sin(Interval(angle)), std::sin(static_cast<long double>(angle))));
    const Interval wide(angle, angle + 4 * std::abs(unit(random)));
    for (int k = 0; k <= 20; ++k) {
      const long double x = wide.lower + (static_cast<long double>(wide.upper) - wide.lower) * k / 20;
      REQUIRE(contains(cos(wide), std::cos(x)));
      REQUIRE(contains(square(wide), x * x));
    }
  }
}

TEST_CASE("an interval without a value is refused") {
  CHECK_THROWS_AS(inverse(Interval(-1, 1)), EnclosureError);
  CHECK_THROWS_AS(sqrt(Interval(-1e-300, 1)), EnclosureError);
  CHECK_THROWS_AS(Interval(1e100) * Interval(1e100), EnclosureError);
  CHECK_THROWS_AS(intersect(Interval(0, 1), Interval(2, 3)), EnclosureError);
}

TEST_CASE("jets contain the derivatives of functions at all points of a box") {
  // f = sin(x y) / sqrt(1 + x² y) by hand
  const auto f = [](const auto& x, const auto& y) { return sin(x * y) / sqrt(1.0 + x * x * y); };
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> place(0.2, 2), unit(0, 1);
  for (int trial = 0; trial < 300; ++trial) {
    const double width = trial % 3 == 0 ? 0 : 0.2 * unit(random);
    const Interval X(place(random)), Y(place(random));
    const Interval box_x(X.lower, X.lower + width), box_y(Y.lower, Y.lower + width);
    const IntervalJet jet = f(IntervalJet::variable(box_x, 0, 2, 2), IntervalJet::variable(box_y, 1, 2, 2));
    const double x = X.lower + width * unit(random), y = Y.lower + width * unit(random);
    const auto value = [&](double p, double q) { return std::sin(p * q) / std::sqrt(1 + p * p * q); };
    // central differences: errors of 1e-9 in slopes, 1e-6 in curvatures
    const double h = 1e-5, k = 1e-4;
    const auto near = [](const Interval& interval, double v, double error) {
      return interval.lower - error <= v && v <= interval.upper + error;
    };
    CHECK(near(jet.value, value(x, y), 1e-15));
    CHECK(near(jet.gradient(0), (value(x + h, y) - value(x - h, y)) / (2 * h), 1e-8));
    CHECK(near(jet.gradient(1), (value(x, y + h) - value(x, y - h)) / (2 * h), 1e-8));
    CHECK(near(jet.hessian(0, 0), (value(x + k, y) - 2 * value(x, y) + value(x - k, y)) / (k * k), 1e-5));
    CHECK(near(jet.hessian(1, 0),
               (value(x + k, y + k) - value(x + k, y - k) - value(x - k, y + k) + value(x - k, y - k)) / (4 * k * k),
               1e-5));
    if (width == 0) CHECK(jet.hessian(0, 0).width() < 1e-11);
  }
}

TEST_CASE("the enclosed motion contains the program's own at all lengths of a box, and its derivatives differences") {
  std::mt19937_64 random(3);
  for (const FigureCase& one : all_cases()) {
    CAPTURE(one.terms.front().quantity);
    int shown = 0;
    for (const double width : {0.3, 0.02}) {
      const LengthBox box = one.random_box(random, width);
      LengthBox middle = box;
      std::vector<Interval> steps;
      for (const int k : one.problem.lengths) {
        middle.lower[k] = middle.upper[k] = box.middle()[k];
        steps.push_back(Interval(box.lower[k], box.upper[k]) - box.middle()[k]);
      }
      const auto linkage = [&](const LengthBox& of, int order) {
        return enclose_linkage(one.space, one.problem, of, order).linkage;
      };
      const BoxLinkages linkages{linkage(middle, 0), linkage(box, 0), linkage(box, 1), linkage(box, 2), steps, 2};
      MotionEnclosure enclosure(linkages, one.problem.drive);
      const SampledMotion reference = sample_planar_motion(one.space, one.problem, one.middle(box));
      const VectorX x = one.random_lengths(random, box);
      VectorX ahead = x, behind = x;
      const int first = one.problem.lengths.front();
      const double h = 1e-5 * x[first];
      ahead[first] += h;
      behind[first] -= h;
      const SampledMotion sampled = sample_planar_motion(one.space, one.problem, x),
                          later = sample_planar_motion(one.space, one.problem, ahead),
                          earlier = sample_planar_motion(one.space, one.problem, behind);
      for (std::size_t s = 0; s < std::min(reference.points.size(), sampled.points.size()); s += 40) {
        if (!enclosure.enclose(reference.points[s])) continue;
        ++shown;
        for (Eigen::Index c = 0; c < sampled.points[s].y.size(); ++c) {
          const IntervalJet& y = enclosure.coordinates()[static_cast<std::size_t>(c)];
          // the program's coordinates have errors of 1e-12, central differences of 1e-6
          CHECK(y.value.lower - 1e-11 <= sampled.points[s].y[c]);
          CHECK(sampled.points[s].y[c] <= y.value.upper + 1e-11);
          if (std::min(later.points.size(), earlier.points.size()) <= s) continue;
          const double slope = (later.points[s].y[c] - earlier.points[s].y[c]) / (2 * h);
          const double error = 1e-5 * (1 + std::abs(slope));
          CHECK(y.gradient(0).lower - error <= slope);
          CHECK(slope <= y.gradient(0).upper + error);
        }
      }
    }
    CHECK(shown > 0);
  }
}

TEST_CASE("at given lengths the bound is the least figure, and no run of a random design is below it") {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const FigureCase& one : all_cases()) {
    CAPTURE(one.terms.front().quantity);
    const VectorX x = one.random_lengths(random, one.whole_box());
    const std::optional<FigureDual> dual = one.solve(x);
    REQUIRE(dual);
    const FigureBoxBound point = one.bound({x, x});
    LengthBox box{one.problem.lower, one.problem.upper};
    for (const int k : one.problem.lengths) box.lower[k] = box.upper[k] = x[k];
    const double bound = one.bound(box).bound;
    // the cone program is solved to 1e-9, and the bound has a margin of 1e-9
    CHECK(bound == doctest::Approx(dual->value).epsilon(1e-6));
    CHECK(bound <= dual->value * (1 + 1e-8));
    for (int trial = 0; trial < 5; ++trial) {
      VectorX design = trial == 0 ? dual->x : x;
      for (Eigen::Index i = 0; trial > 0 && i < design.size(); ++i)
        if (std::count(one.problem.lengths.begin(), one.problem.lengths.end(), static_cast<int>(i)) == 0)
          design[i] = one.problem.lower[i] + unit(random) * (one.problem.upper[i] - one.problem.lower[i]);
      const study::DesignInstance instance = one.space.instantiate(design);
      double objective = 0;
      for (const ObjectiveTerm& term : one.terms) {
        const RunResult run = simulate(instance.mechanism, instance.trajectories.front());
        REQUIRE(run.outcome.status == MotionStatus::done);
        double worst = 0;
        for (const Metric& metric : run.metrics)
          if (metric.quantity == term.quantity || metric.quantity.starts_with(term.quantity + "["))
            if (metric.quantity.find("[x]") == std::string::npos && metric.quantity.find("[y]") == std::string::npos)
              worst = std::max(worst, term.figure == Statistic::peak ? metric.peak : metric.rms);
        objective += term.weight * worst;
      }
      CHECK(bound <= objective * (1 + 1e-8));
    }
  }
}

TEST_CASE("a box's bound is below the least figure at all of its lengths") {
  std::mt19937_64 random(5);
  for (const FigureCase& one : all_cases()) {
    CAPTURE(one.terms.front().quantity);
    for (const double width : {1.0, 0.1, 0.003}) {
      const LengthBox box = one.random_box(random, width);
      const FigureBoxBound bound = one.bound(box);
      if (width < 0.01) CHECK(bound.bound > 0);
      for (int trial = 0; trial < 4; ++trial)
        if (const std::optional<FigureDual> dual = one.solve(one.random_lengths(random, box)))
          CHECK(bound.bound <= dual->value * (1 + 1e-8));
    }
  }
}

TEST_CASE("the bound over all lengths never falls, and closes") {
  const FigureCase one("slider_crank", crank_design, "rms(shaking_force)", {"b"}, 0.5);
  FigureBoundSearch search(one.space, one.problem, *one.rows, {});
  double before = 0;
  search.run([&] {
    const LengthBound known = search.result();
    CHECK(known.lower_bound >= before);
    before = known.lower_bound;
    return known.lower_bound >= search.promised_value() * (1 - 1e-3) || known.nodes > 100;
  });
  const LengthBound last = search.result();
  CHECK(last.reason.empty());
  CHECK(last.lower_bound >= search.promised_value() * (1 - 1e-3));
  CHECK(last.lower_bound <= search.promised_value());
}

TEST_CASE("what has no bound is refused in words") {
  const auto reason_of = [](const std::string& name, const std::string& before, const std::string& after,
                            const std::string& design) {
    std::string text = replace_text(read_text(name), crank_design, "design: {minimize: " + design + "}");
    if (!before.empty()) text = replace_text(text, before, after);
    const DesignSpace space = design::follow_assembly_mode(read_design_space(text, name + ".yaml"), true);
    std::string reason;
    const FigureRequest request = design::read_figure_request(space, space.start.design.minimize, reason);
    return reason.empty() ? read_figure_problem(space, request).reason : reason;
  };
  const auto names = [](const std::string& reason, const std::string& part) {
    return reason.find(part) != std::string::npos;
  };
  CHECK(names(reason_of("slider_crank", "", "", "mean(torque)"), "rms and peak"));
  CHECK(names(reason_of("slider_crank", "", "", "rms(joint_force)"), "joint_force"));
  CHECK(names(reason_of("slider_crank", "actuators: [A]", "friction: {A: {coulomb: 1}}\nactuators: [A]", "rms(torque)"),
              "friction"));
  CHECK(reason_of("slider_crank", "actuators: [A]", "friction: {A: {coulomb: 1}}\nactuators: [A]", "rms(shaking_force)")
            .empty());
  CHECK(names(reason_of("slider_crank", "from: {joints: {A: 0.5}}", "from: {joints: {A: a}}", "rms(torque)"),
              "trajectory depends"));
}
