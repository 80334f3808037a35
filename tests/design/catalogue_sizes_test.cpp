// Numbers that come in sizes, against all of their combinations.

#include "balance/synthesis/design/objective_builder.hpp"
#include "load_cases.hpp"

#include <fmt/format.h>

using namespace load_cases;
using balance::MatrixX;

namespace {

/// A chain of links with a counterweight each, whose masses come in sizes.
std::string chain(std::mt19937& random, int links, bool spatial) {
  std::uniform_real_distribution<double> length(0.2, 0.5), mass(0.5, 2);
  std::string bodies = "bodies:\n", joints = "joints:\n", weights = "counterweights:\n", actuators, at, from, to;
  for (int k = 1; k <= links; ++k) {
    const double l = length(random), m = mass(random);
    const char* zero = spatial ? ", 0" : "";
    bodies += fmt::format("  b{}: {{mass: {}, com: [{}, 0{}], inertia: {}, points: {{A: [0, 0{}], B: [{}, 0{}]}}}}\n",
                          k, m, l / 2, zero, spatial ? "[0.01, 0.02, 0.02]" : "0.02", zero, l, zero);
    joints += fmt::format("  J{}: {{type: revolute, connects: [{}, b{}.A]{}}}\n", k,
                          k == 1 ? "ground.origin" : fmt::format("b{}.B", k - 1), k,
                          !spatial     ? ""
                          : k % 2 == 1 ? ", axis: [0, 0, 1]"
                                       : ", axis: [0, 1, 0]");
    weights += fmt::format("  c{}: {{body: b{}, at: [-0.2, 0{}], mass: {{free: [0, {}], step: {}}}}}\n", k, k, zero,
                           k == links ? 4 : 12, k == links ? 0.7 : 1.5);
    actuators += fmt::format("{}J{}", k == 1 ? "" : ", ", k);
    from += fmt::format("{}J{}: {}", k == 1 ? "" : ", ", k, 0.3 * k);
    to += fmt::format("{}J{}: {}", k == 1 ? "" : ", ", k, 0.3 * k + 0.9);
  }
  return fmt::format(
      "space: {}\ngravity: [{}]\n{}{}{}actuators: [{}]\nmotion: {{duration: 0.8, samples: 21, from: {{joints: "
      "{{{}}}}}, to: "
      "{{joints: {{{}}}}}}}\ndesign: {{goal: static}}\n",
      spatial ? "spatial" : "planar", spatial ? "0, 0, -9.81" : "0, -9.81", bodies, joints, weights, actuators, from,
      to);
}

/// Calls `visit` for all combinations of sizes.
template <class Visit>
void for_all(const DesignSpace& space, const Visit& visit) {
  const auto& free = space.start.free_numbers;
  std::vector<std::size_t> at(free.size(), 0);
  for (;;) {
    VectorX x(static_cast<Eigen::Index>(free.size()));
    for (std::size_t i = 0; i < free.size(); ++i) x[static_cast<Eigen::Index>(i)] = free[i].discrete_values[at[i]];
    visit(x);
    std::size_t k = 0;
    while (k < at.size() && ++at[k] == free[k].discrete_values.size()) at[k++] = 0;
    if (k == at.size()) return;
  }
}

bool is_a_size(const DesignSpace& space, const VectorX& x) {
  for (std::size_t i = 0; i < space.start.free_numbers.size(); ++i) {
    const auto& sizes = space.start.free_numbers[i].discrete_values;
    if (std::find(sizes.begin(), sizes.end(), x[static_cast<Eigen::Index>(i)]) == sizes.end()) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("sizes leave as little of the conditions as any combination of them") {
  std::mt19937 random(11);
  for (const bool spatial : {false, true})
    for (int seed = 0; seed < 3; ++seed) {
      const DesignSpace space = read(chain(random, 3, spatial));
      const DesignReport report = find_design(space);
      REQUIRE(report.outcome.status == DesignStatus::infeasible);
      CHECK(report.outcome.is_proved_infeasible);
      CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
      CHECK(is_a_size(space, report.outcome.x));
      const auto conditions = balance::derive_conditions(space.start.mechanism, space.start.design.goals);
      double min_value = 1e9;
      for_all(space, [&](const VectorX& x) {
        min_value = std::min(
            min_value,
            scaled_residuals(conditions, balance::conditions::term_values(space.instantiate(x).mechanism)).norm());
      });
      const double found =
          scaled_residuals(conditions, balance::conditions::term_values(space.instantiate(report.outcome.x).mechanism))
              .norm();
      CHECK(found == doctest::Approx(min_value).epsilon(1e-9));
    }
}

TEST_CASE("sizes have the least figure of all combinations, and the bound says so") {
  std::mt19937 random(5);
  for (const char* figure :
       {"{rms: torque, along: cycloid}", "{peak: torque, along: cycloid}", "{rms: shaking_force, along: cycloid}"}) {
    const DesignSpace space =
        read(replaced(chain(random, 3, false), "goal: static", fmt::format("minimize: {}", figure)));
    const DesignReport report = find_design(space);
    const balance::design::Objective objective =
        balance::design::build_objective(space, space.start.design.minimize, space.start_values(), {});
    double min_value = 1e9;
    for_all(space, [&](const VectorX& x) {
      min_value = std::min(
          min_value,
          objective.function->evaluate(balance::dynamics::parameter_values(space.instantiate(x).mechanism), nullptr));
    });
    CHECK(report.outcome.objective == doctest::Approx(min_value).epsilon(1e-9));
    CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
    CHECK(report.outcome.lower_bound <= report.outcome.objective);
    CHECK(report.outcome.lower_bound == doctest::Approx(min_value).epsilon(1e-5));
  }
}

TEST_CASE("sizes within limits have the least figure of all combinations that keep them") {
  std::mt19937 random(23);
  for (int seed = 0; seed < 3; ++seed) {
    const std::string text = chain(random, 3, false);
    const DesignSpace peaks = read(replaced(text, "goal: static", "minimize: {peak: torque, along: cycloid}"));
    const balance::design::Objective peak =
        balance::design::build_objective(peaks, peaks.start.design.minimize, peaks.start_values(), {});
    const auto peak_at = [&](const VectorX& x) {
      return peak.function->evaluate(balance::dynamics::parameter_values(peaks.instantiate(x).mechanism), nullptr);
    };
    const auto added_mass = [](const VectorX& x) { return x.sum(); };
    double min_peak = 1e9;
    for_all(peaks, [&](const VectorX& x) { min_peak = std::min(min_peak, peak_at(x)); });
    const double start_peak = peak_at(peaks.start_values());
    REQUIRE(min_peak < start_peak);
    for (const double bound : {start_peak * (1 + 1e-6), 0.5 * (min_peak + start_peak), min_peak * (1 + 1e-6)}) {
      double min_mass = 1e9;
      for_all(peaks, [&](const VectorX& x) {
        if (peak_at(x) <= bound) min_mass = std::min(min_mass, added_mass(x));
      });
      const DesignSpace space = read(
          replaced(text, "goal: static",
                   fmt::format("minimize: added-mass, subject_to: [\"peak(torque, cycloid) <= {:.15g}\"]", bound)));
      const DesignReport report = find_design(space);
      CHECK(report.outcome.within_limits);
      CHECK(added_mass(report.outcome.x) == doctest::Approx(min_mass).epsilon(1e-12));
      CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
    }
    const DesignSpace space = read(replaced(
        text, "goal: static",
        fmt::format("minimize: added-mass, subject_to: [\"peak(torque, cycloid) <= {:.15g}\"]", min_peak * 0.9)));
    const DesignReport report = find_design(space);
    CHECK_FALSE(report.outcome.within_limits);
    CHECK(report.outcome.is_proved_infeasible);
    CHECK(peak_at(report.outcome.x) == doctest::Approx(min_peak).epsilon(1e-6));
  }
}

TEST_CASE("sizes that balance exactly are found among those that do not") {
  // 0.5 kg m of the link and 0.5 m for the counterweight: 1 kg
  const DesignSpace space = read(replaced(replaced(pendulum, "free: [0, 5]", "free: {values: [0, 0.4, 1, 2.5]}"),
                                          ", for: {p: [0, 0.25, 1]}", ", minimize: added-mass"));
  const DesignReport report = find_design(space);
  CHECK(report.outcome.status == DesignStatus::balanced);
  CHECK(report.outcome.x[0] == 1);
  CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
}

TEST_CASE("lengths in sizes are all tried") {
  std::string text = replaced(pendulum, "at: [-0.5, 0], mass: {free: [0, 5]}", "at: [\"-r\", 0], mass: {free: [0, 5]}");
  text = replaced(text, "{p: 0}", "{p: 0, l: {free: {values: [0.3, 0.5, 0.7]}}, r: 0.5}");
  text = replaced(text, "points: {E: [0.5, 0]}", "points: {E: [l, 0]}");
  text = replaced(replaced(text, "mass: p", "mass: 1"), ", for: {p: [0, 0.25, 1]}", ", minimize: added-mass");
  const DesignReport report = find_design(read(text));
  CHECK(report.outcome.status == DesignStatus::balanced);
  CHECK(report.outcome.x[0] == 0.3);  // the load hangs nearest to the joint
  CHECK(report.outcome.x[1] == doctest::Approx((0.5 + 0.3) / 0.5).epsilon(1e-9));
}

TEST_CASE("a free place and mass in a box have the least mass that first moments allow") {
  std::string text = replaced(pendulum, "at: [-0.5, 0]", "at: [{free: [-0.3, 0.2]}, {free: [-0.1, 0.1]}]");
  text = replaced(text, ", for: {p: [0, 0.25, 1]}", ", minimize: added-mass");
  const DesignReport report = find_design(read(text));
  CHECK(report.outcome.objective == doctest::Approx(0.5 / 0.3).epsilon(1e-9));
  CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
  CHECK(report.outcome.lower_bound == doctest::Approx(0.5 / 0.3).epsilon(1e-6));
}

namespace {

/// A chain whose counterweights must have different masses. @param request further entries of `design`
std::string chain_of_different(unsigned seed, int links, const std::string& request) {
  std::mt19937 random(seed);
  return replaced(chain(random, links, false), "goal: static",
                  "all_different: [\"counterweights.*.mass\"], " + request);
}

/// Whether no two numbers are equal; @param counts_zero whether two zeros are
bool are_different(const VectorX& x, bool counts_zero = true) {
  for (Eigen::Index i = 0; i < x.size(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      if (x[i] == x[j] && (counts_zero || x[i] != 0)) return false;
  return true;
}

/// The least figure of all combinations that the predicate accepts.
template <class Predicate>
double min_figure(const DesignSpace& space, const Predicate& is_accepted) {
  const balance::design::Objective objective =
      balance::design::build_objective(space, space.start.design.minimize, space.start_values(), {});
  double min_value = 1e9;
  for_all(space, [&](const VectorX& x) {
    if (is_accepted(x))
      min_value = std::min(
          min_value,
          objective.function->evaluate(balance::dynamics::parameter_values(space.instantiate(x).mechanism), nullptr));
  });
  return min_value;
}

}  // namespace

TEST_CASE("sizes that must differ have the least figure of all combinations that do") {
  // 3 links: all combinations are tried; 4 links: branch and bound
  for (const int links : {3, 4})
    for (const char* figure : {"{rms: torque, along: cycloid}", "{peak: shaking_force, along: cycloid}"})
      for (const unsigned seed : {1U, 2U}) {
        CAPTURE(links);
        CAPTURE(figure);
        CAPTURE(seed);
        const DesignSpace space = read(chain_of_different(seed, links, fmt::format("minimize: {}", figure)));
        const DesignReport report = find_design(space);
        CHECK(is_a_size(space, report.outcome.x));
        CHECK(are_different(report.outcome.x));
        const double min_value = min_figure(space, [](const VectorX& x) { return are_different(x); });
        CHECK(report.outcome.objective == doctest::Approx(min_value).epsilon(1e-9));
        CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
        CHECK(report.outcome.lower_bound == doctest::Approx(min_value).epsilon(1e-5));
        const double any = min_figure(space, [](const VectorX&) { return true; });
        if (any < min_value * (1 - 1e-9)) continue;
        DesignSpace unrestricted = space;
        unrestricted.start.design.all_different.clear();
        CHECK(find_design(unrestricted).outcome.objective == doctest::Approx(report.outcome.objective).epsilon(1e-9));
      }
}

TEST_CASE("sizes of elements that are left out need not differ") {
  for (const unsigned seed : {1U, 2U, 3U}) {
    CAPTURE(seed);
    const DesignSpace space =
        read(chain_of_different(seed, 3, "choose: {counterweights: 1}, minimize: {rms: torque, along: cycloid}"));
    const DesignReport report = find_design(space);
    const double min_value =
        min_figure(space, [](const VectorX& x) { return (x.array() != 0).count() <= 1 && are_different(x, false); });
    CHECK(report.outcome.objective == doctest::Approx(min_value).epsilon(1e-9));
    CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
  }
}

TEST_CASE("sizes that must differ are decided beside numbers without sizes") {
  for (const unsigned seed : {1U, 2U, 3U}) {
    CAPTURE(seed);
    const std::string free = replaced(chain_of_different(seed, 3, "minimize: {rms: torque, along: cycloid}"),
                                      "[\"counterweights.*.mass\"]", "[c1.mass, c2.mass]");
    const std::string text = replaced(free, "mass: {free: [0, 4], step: 0.7}", "mass: {free: [0, 4]}");
    const DesignSpace space = read(text);
    const DesignReport report = find_design(space);
    double min_value = 1e9;
    for (int first = 0; first <= 8; ++first)
      for (int second = 0; second <= 8; ++second) {
        if (first == second) continue;
        DesignSpace fixed = space.fix_others(Eigen::Vector3d(1.5 * first, 1.5 * second, 1), {2});
        CHECK(fixed.start.design.all_different.front().numbers.empty());
        min_value = std::min(min_value, find_design(fixed).outcome.objective);
      }
    CHECK(report.outcome.x[0] != report.outcome.x[1]);
    CHECK(report.outcome.objective == doctest::Approx(min_value).epsilon(1e-9));
    CHECK(report.outcome.optimality == balance::design::Optimality::proved_global);
  }
}

TEST_CASE("a fixed number keeps its size from those that must differ from it") {
  const DesignSpace space = read(chain_of_different(1, 3, "minimize: {rms: torque, along: cycloid}"));
  const double taken = find_design(space).outcome.x[1];
  DesignSpace fixed = space.fix_others(Eigen::Vector3d(taken, 0, 0), {1, 2});
  const DesignReport report = find_design(fixed);
  CHECK(report.outcome.x[0] != taken);
  const double min_value =
      min_figure(fixed, [&](const VectorX& x) { return x[0] != taken && x[1] != taken && x[0] != x[1]; });
  CHECK(report.outcome.objective == doctest::Approx(min_value).epsilon(1e-9));
}

TEST_CASE("sizes that balance only if two are equal are proved to be impossible if they must differ") {
  // 0.5 kg m of the link; two counterweights at 0.5 m: together 1 kg
  const std::string two =
      replaced(replaced(pendulum, "counterweights: {cw: {body: link, at: [-0.5, 0], mass: {free: [0, 5]}}}",
                        "counterweights: {a: {body: link, at: [-0.5, 0], mass: {free: {values: [0.5, 2]}}},\n"
                        "                 b: {body: link, at: [-0.5, 0], mass: {free: {values: [0.5, 3]}}}}"),
               ", for: {p: [0, 0.25, 1]}", "");
  CHECK(find_design(read(two)).outcome.status == DesignStatus::balanced);
  const DesignReport report =
      find_design(read(replaced(two, "goal: static", "goal: static, all_different: [a.mass, b.mass]")));
  CHECK(report.outcome.status == DesignStatus::infeasible);
  CHECK(report.outcome.is_proved_infeasible);
  CHECK(are_different(report.outcome.x));
}
