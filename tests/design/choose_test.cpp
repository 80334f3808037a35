// Elements that are needed at all: how many a mechanism cannot do without is known from its linearly independent vectors.

#include "balance/interface/specification/read_spec.hpp"
#include "load_cases.hpp"

using namespace load_cases;

namespace {

std::string with(const std::string& config, const std::string& more, const std::string& choice) {
  const std::string text = replaced(file_text(config), "counterweights:\n", "counterweights:\n" + more);
  return replaced(text, "goal: force", "goal: force, minimize: added-mass, choose: " + choice);
}

int kept(const DesignReport& report) {
  int count = 0;
  for (const auto& choice : report.outcome.selection->kept)
    count += static_cast<int>(std::count(choice.begin(), choice.end(), true));
  return count;
}

void check_fewest(const DesignReport& report, int count) {
  CHECK(report.outcome.status == DesignStatus::balanced);
  REQUIRE(report.outcome.selection);
  CHECK(report.outcome.selection->min_count == count);
  CHECK(report.outcome.selection->is_min_count_proved);
  CHECK(kept(report) == count);
  CHECK(report.outcome.optimality == balance::Optimality::proved_global);
}

constexpr const char* for_four_bar =
    "  cw3: {body: coupler, at: [-0.05, -0.02], mass: {free: [0, 10]}}\n"
    "  cw4: {body: coupler, at: [0.4, 0.02], mass: {free: [0, 10]}}\n";
constexpr const char* for_five_bar = "  cw12: {body: coupler1, at: [-0.12, 0], mass: {free: [0, 30]}}\n";
constexpr const char* for_3rrr =
    "  cw_p: {body: platform, at: [0.05, 0.1], mass: {free: [0, 20]}}\n"
    "  cw_q: {body: coupler2, at: [0.28, 0], mass: {free: [0, 20]}}\n";

}  // namespace

TEST_CASE("a four-bar needs two counterweights, a five-bar three, a 3RRR six") {
  check_fewest(find_design(read(with("four-bar-force-balance.yaml", for_four_bar, "{counterweights: least}"))), 2);
  check_fewest(find_design(read(with("5r-force-balance.yaml", for_five_bar, "{counterweights: least}"))), 3);
  check_fewest(find_design(read(with("3rrr-force-balance.yaml", for_3rrr, "{counterweights: least}"))), 6);
}

TEST_CASE("a count that is not enough is impossible, with the one that is") {
  const DesignReport report = find_design(read(with("5r-force-balance.yaml", for_five_bar, "{counterweights: 2}")));
  CHECK(report.outcome.status == DesignStatus::infeasible);
  CHECK(report.outcome.is_proved_infeasible);
  CHECK(report.outcome.selection->min_count == 3);
  CHECK(report.outcome.selection->is_min_count_proved);
  CHECK(kept(report) <= 2);
}

TEST_CASE("among equal counts the least figure counts, as among all pairs") {
  const std::string offered = "{counterweights: {from: [cw11, cw12, cw21, cw22], most: 2}}";
  const std::string text = replaced(with("5r-force-balance.yaml", for_five_bar, offered),
                                    "goal: force, minimize: added-mass", "minimize: {rms: torque, along: cycloid}");
  const DesignReport best = find_design(read(text));
  CHECK(best.outcome.optimality == balance::Optimality::proved_global);
  double least = 1e9;
  const std::vector<std::string> names = {"cw11", "cw12", "cw21", "cw22"};
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const DesignReport pair = find_design(
          read(replaced(text, "[cw11, cw12, cw21, cw22], most: 2", "[" + names[i] + ", " + names[k] + "], most: 0")));
      least = std::min(least, pair.outcome.objective);  // the other pair
    }
  CHECK(best.outcome.objective == doctest::Approx(least).epsilon(1e-6));
}

TEST_CASE("what cannot vanish cannot be left out") {
  const std::string text =
      replaced(with("5r-force-balance.yaml", "  heavy: {body: crank1, at: [0, 0], mass: {free: [1, 2]}}\n",
                    "{counterweights: {from: [heavy]}}"),
               "minimize: added-mass, ", "");
  CHECK_THROWS_AS(find_design(read(text)), std::invalid_argument);
}
