// Sizes and choices in the tree of lengths: known numbers of counterweights, and laws that compare the tree with the
// enumeration of subsets and sizes.

#include "exact_certificate.hpp"
#include "linkage_specs.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/certificate/linkage_check.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

using namespace balance;
using namespace balance::certificate;

namespace discrete_bound_test {
namespace {

using linkage_specs::can_move;
using linkage_specs::read_text;
using linkage_specs::replace_text;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string without_lines(const std::string& text, const std::vector<std::string>& words) {
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    const std::string line = text.substr(begin, end - begin);
    if (std::none_of(words.begin(), words.end(),
                     [&](const std::string& word) { return line.find(word) != std::string::npos; }))
      result += line;
    begin = end;
  }
  return result;
}

DesignSpace parse(const std::string& text) { return read_design_space(text, "test.yaml"); }

/// The spec's counterweights, of which a design keeps at most so many; −1: as few as possible.
ElementChoice counterweights_of(const DesignSpace& space, int max_count) {
  ElementChoice choice{{}, max_count};
  const auto& numbers = space.start.free_numbers;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::string& path = numbers[i].key_path;
    if (path.rfind("counterweights.", 0) != 0 || path.find(".mass") == std::string::npos) continue;
    ElementChoice::Element element{{static_cast<int>(i)}, {}};
    const std::string own = path.substr(0, path.find(".mass")) + ".at";
    for (std::size_t j = 0; j < numbers.size(); ++j)
      if (numbers[j].key_path.rfind(own, 0) == 0) element.own_numbers.push_back(static_cast<int>(j));
    choice.elements.push_back(element);
  }
  return choice;
}

int count_kept(const ElementChoice& choice, const VectorX& x) {
  return static_cast<int>(std::count_if(choice.elements.begin(), choice.elements.end(),
                                        [&](const auto& element) { return x[element.numbers.front()] != 0; }));
}

LengthBound bound(const DesignSpace& space, long max_nodes, double gap_tolerance, std::optional<int> max_count = {}) {
  LengthBoundOptions options;
  options.max_nodes = max_nodes;
  options.gap_tolerance = gap_tolerance;
  options.required_trajectories = list_followed_trajectories(space);
  options.keeps_certificates = true;
  if (max_count) options.choices = {counterweights_of(space, *max_count)};
  LengthBound result =
      bound_over_lengths(space, *make_length_design_judge(space, options.required_trajectories), options);
  const LengthGeometries listed = list_length_geometries(space, options.required_trajectories);
  for (const LengthCertificate& one : result.certificates)
    CHECK(find_flaw(one, listed.geometries[static_cast<std::size_t>(one.geometry)]) == "");
  return result;
}

/// Calls visit for all combinations of values.
template <class Visit>
void visit_combinations(const std::vector<std::vector<double>>& values, const Visit& visit) {
  std::vector<std::size_t> index(values.size(), 0);
  for (;;) {
    std::vector<double> combination;
    for (std::size_t i = 0; i < values.size(); ++i) combination.push_back(values[i][index[i]]);
    visit(combination);
    std::size_t i = 0;
    while (i < values.size() && ++index[i] == values[i].size()) index[i++] = 0;
    if (i == values.size()) return;
  }
}

}  // namespace

TEST_CASE("lengths: the least number of counterweights is proved, and a parallelogram's counts") {
  struct Known {
    const char* spec;
    int count;
    double value, gap;
  };
  for (const Known& known : {Known{"four_box_1", 2, 0.879082, 1e-9}, Known{"five_box_1", 3, 7.3435, 1e-4},
                             Known{"ch_watt_box_1_least", 2, 3.602205, 1e-4}}) {
    INFO(std::string(known.spec));
    std::string text = read_text(known.spec);
    if (text.find("choose") == std::string::npos)
      text = replace_text(text, "minimize: added-mass", "minimize: added-mass, choose: {counterweights: least}");
    const DesignSpace space = parse(text);
    const LengthBound result = bound(space, 200, known.gap, -1);
    CHECK(result.reason == "");
    CHECK(result.count == known.count);
    CHECK(result.is_count_proved);
    CHECK(result.gap() <= known.gap);
    CHECK(std::abs(result.best - known.value) <= 1e-4 * known.value);
    REQUIRE(result.design.size() > 0);
    CHECK(count_kept(counterweights_of(space, -1), result.design) == known.count);
    CHECK(make_length_design_judge(space, list_followed_trajectories(space))->accepts(result.design));
  }
}

TEST_CASE("lengths: before the least number is known, the bound is one of all that it may be, and never falls") {
  for (const auto& [spec, value] : {std::pair{"five_box_1", 7.3435}, std::pair{"ch_watt_box_1_least", 3.602205}}) {
    std::string text = read_text(spec);
    if (text.find("choose") == std::string::npos)
      text = replace_text(text, "minimize: added-mass", "minimize: added-mass, choose: {counterweights: least}");
    const DesignSpace space = parse(text);
    LengthBoundOptions options;
    options.required_trajectories = list_followed_trajectories(space);
    options.choices = {counterweights_of(space, -1)};
    const auto judge = make_length_design_judge(space, options.required_trajectories);
    LengthBoundSearch search(space, *judge, options);
    double before = 0;
    bool was_undecided = false;
    for (int stop = 0; stop < 120; ++stop) {
      const LengthBound known = search.result();
      INFO(std::string(spec), ", ", stop);
      CHECK(known.lower_bound >= before);
      CHECK(known.lower_bound <= value * (1 + 1e-5));
      was_undecided = was_undecided || known.design.size() == 0;
      before = known.lower_bound;
      int boxes = 0;
      search.run([&] { return ++boxes > 1; });
    }
    CHECK(was_undecided);
    CHECK(before > 0);
  }
}

TEST_CASE("lengths: a choice of n counterweights is as good as the best of all subsets of n") {
  const std::string text = read_text("four_box_1");
  const std::vector<std::string> names{"w_crank:", "w_coupler:", "w_rocker:"};
  for (int count = 1; count <= 3; ++count) {
    double best = infinity, lower = infinity;
    for (unsigned set = 0; set < 8; ++set) {
      std::vector<std::string> others;
      for (std::size_t i = 0; i < 3; ++i)
        if (((set >> i) & 1U) == 0) others.push_back(names[i]);
      if (static_cast<int>(others.size()) != 3 - count) continue;
      const LengthBound subset = bound(parse(without_lines(text, others)), 50, 1e-9);
      CHECK(subset.reason == "");
      best = std::min(best, subset.best);
      lower = std::min(lower, subset.lower_bound);
    }
    const LengthBound chosen = bound(parse(text), 50, 1e-9, count);
    INFO(count);
    CHECK(chosen.count == -1);
    if (std::isinf(lower)) {
      CHECK(chosen.is_impossible());
      continue;
    }
    CHECK(chosen.best == doctest::Approx(best).epsilon(1e-8));
    CHECK(chosen.lower_bound == doctest::Approx(lower).epsilon(1e-8));
  }
}

TEST_CASE("lengths: no box without some counterweights has a bound above the least mass without them") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  int compared = 0;
  for (const char* spec : {"four_box_1", "five_box_1", "watt_box_1"}) {
    const DesignSpace space = parse(read_text(spec));
    const LengthGeometry geometry = list_length_geometries(space, {}).geometries[0];
    const BoxProgram program(geometry.linkage, geometry.dual, {});
    for (int trial = 0; trial < 6; ++trial) {
      LengthBox box = geometry.box;
      const double width = trial % 2 == 0 ? 0.3 : 0.03;
      for (const int length : program.lengths()) {
        const double whole = box.upper[length] - box.lower[length];
        box.lower[length] += unit(random) * (1 - width) * whole;
        box.upper[length] = box.lower[length] + width * whole;
      }
      PlanarLinkage linkage = geometry.linkage;
      std::vector<MassLimits> limits = list_mass_limits(linkage);
      const auto left_out = static_cast<std::size_t>(trial) % limits.size();
      linkage.counterweights[left_out].upper = limits[left_out].upper = 0;
      const BoxBound result = program.bound(box, {}, limits);
      CHECK(find_flaw({0, box, result.bound, result.certificate}, geometry) == "");
      for (int sample = 0; sample < 4; ++sample) {
        VectorX x = space.start_values();
        for (const int length : program.lengths())
          x[length] = box.lower[length] + unit(random) * (box.upper[length] - box.lower[length]);
        const std::optional<double> value = compute_min_mass(space, linkage, x);
        if (!value || std::isinf(*value)) continue;
        ++compared;
        CHECK(result.bound <= *value * (1 + 1e-8));  // the tolerance of both solvers is 1e-10
      }
    }
  }
  CHECK(compared >= 20);
}

TEST_CASE("lengths: with sizes of lengths the bound is reached by the best of all combinations") {
  std::string text = read_text("four_hi_4");
  const std::vector<std::vector<double>> sizes{
      {0.06, 0.08, 0.1, 0.12}, {0.2, 0.25, 0.3, 0.4, 0.5}, {0.18, 0.2, 0.25, 0.35}};
  // the coordinates of the mechanism follow from the parameters
  const std::size_t begin = text.find("parameters:"), end = text.find('\n', begin);
  text = text.substr(0, begin) +
         "parameters: {a: {free: {values: [0.06, 0.08, 0.1, 0.12]}, start: 0.1}, b: {free: {values: [0.2, 0.25, 0.3, "
         "0.4, 0.5]}, start: 0.4}, c: {free: {values: [0.18, 0.2, 0.25, 0.35]}, start: 0.25}, d: 0.4}" +
         text.substr(end);
  const DesignSpace space = parse(text);
  const PlanarLinkage linkage = list_length_geometries(space, {}).geometries[0].linkage;
  double best = infinity;
  visit_combinations(sizes, [&](const std::vector<double>& lengths) {
    VectorX x = space.start_values();
    for (std::size_t i = 0; i < 3; ++i) x[static_cast<Eigen::Index>(i)] = lengths[i];
    if (!can_move(space, x)) return;
    best = std::min(best, compute_min_mass(space, linkage, x).value_or(infinity));
  });
  const LengthBound result = bound(space, 400, 1e-9);
  CHECK(result.reason == "");
  CHECK(std::isfinite(best));
  CHECK(result.best == doctest::Approx(best).epsilon(1e-8));
  CHECK(result.gap() <= 1e-9);
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(std::find(sizes[i].begin(), sizes[i].end(), result.design[static_cast<Eigen::Index>(i)]) != sizes[i].end());
}

TEST_CASE("lengths: masses with sizes are as light as the best of all combinations") {
  std::string text = read_text("four_box_1");
  const std::size_t begin = text.find("parameters:"), end = text.find('\n', begin);
  text = text.substr(0, begin) +
         "parameters: {a: {free: {values: [0.06, 0.1]}, start: 0.1}, b: {free: {values: [0.25, 0.4]}, start: 0.4}, c: "
         "{free: {values: [0.2, 0.3]}, start: 0.3}, d: 0.4}" +
         text.substr(end);
  for (int i = 0; i < 3; ++i) text = replace_text(text, "mass: {free: [0, 40]}", "mass: {free: [0, 3], step: 0.3}");
  const DesignSpace space = parse(text);
  const PlanarLinkage linkage = list_length_geometries(space, {}).geometries[0].linkage;
  std::vector<double> masses;
  for (int k = 0; k <= 10; ++k) masses.push_back(0.3 * k);
  double best = infinity;
  visit_combinations({{0.06, 0.1}, {0.25, 0.4}, {0.2, 0.3}}, [&](const std::vector<double>& lengths) {
    VectorX x = space.start_values();
    for (std::size_t i = 0; i < 3; ++i) x[static_cast<Eigen::Index>(i)] = lengths[i];
    if (!can_move(space, x)) return;
    visit_combinations({masses, masses, masses}, [&](const std::vector<double>& combination) {
      const double sum = combination[0] + combination[1] + combination[2];
      if (!(sum < best)) return;
      PlanarLinkage fixed = linkage;
      for (std::size_t i = 0; i < 3; ++i)
        fixed.counterweights[i].lower = fixed.counterweights[i].upper = combination[i];
      if (std::isfinite(compute_min_mass(space, fixed, x).value_or(infinity))) best = sum;
    });
  });
  const LengthBound result = bound(space, 400, 1e-9);
  CHECK(result.reason == "");
  CHECK(std::isfinite(best));
  CHECK(result.best == doctest::Approx(best).epsilon(1e-8));
  CHECK(result.gap() <= 1e-9);
}

TEST_CASE("lengths: crank and rocker of a parallelogram have common sizes") {
  const std::string text = read_text("four_fix21");
  const auto with_sizes = [&](const std::string& crank, const std::string& rocker) {
    const std::string a =
        replace_text(text, "a: {free: [0.03732, 0.1493], start: 0.0933}", "a: {free: {values: " + crank + "}}");
    return parse(replace_text(a, "c: {free: [0.115, 0.4601], start: 0.2876}", "c: {free: {values: " + rocker + "}}"));
  };
  const LengthBound common = bound(with_sizes("[0.08, 0.12, 0.13, 0.14]", "[0.125, 0.13, 0.14, 0.2]"), 50, 1e-9);
  REQUIRE(common.design.size() > 2);
  CHECK(common.design[0] == 0.13);
  CHECK(common.design[2] == 0.13);
  CHECK(common.gap() <= 1e-9);
  CHECK(bound(with_sizes("[0.08, 0.12, 0.14]", "[0.125, 0.13, 0.2]"), 50, 1e-9).is_impossible());
}

TEST_CASE("lengths: a spec's choices must be stated to its bound") {
  const DesignSpace space = parse(read_text("ch_watt_box_1_least"));
  CHECK(bound(space, 5, 1e-9).reason == "elements may be left out");
}

}  // namespace discrete_bound_test
