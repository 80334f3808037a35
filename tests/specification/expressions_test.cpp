// What a spec says as a graph of expressions: the same numbers as its text, and their derivatives.

#include "../sampling.hpp"
#include "numbers_of.hpp"
#include "specs.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/expression/expression_parser.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

using namespace balance;
using namespace balance::expression;
using specs::numbers_of;

namespace {

std::vector<std::string> config_files() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

VectorX somewhere(const Study& study, std::mt19937& random) {
  VectorX x(static_cast<Eigen::Index>(study.free_numbers.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& number = study.free_numbers[static_cast<std::size_t>(i)];
    x[i] = std::uniform_real_distribution(number.lower, number.upper)(random);
  }
  return x;
}

/// The text with numbers in place of the free ones, to the last bit.
std::string with_numbers(const Study& study, const VectorX& x) {
  std::string text = study.spec_text;
  for (std::size_t i = study.free_numbers.size(); i-- > 0;) {
    const FreeNumber& free = study.free_numbers[i];
    text.replace(free.begin, free.end - free.begin, fmt::format("{}", x[static_cast<Eigen::Index>(i)] / free.unit));
  }
  return text;
}

double value_at(const std::string& expression, double x = 0) {
  return parse_expression(expression, [&](const std::string&) { return Expression(x); }).value();
}

/// The derivative by x of an expression through its graph.
double slope_at(const std::string& expression, double x) {
  ExpressionGraph graph;
  const Expression input = Expression::input(graph, x);
  const Expression y = parse_expression(expression, [&](const std::string&) { return input; });
  if (y.is_constant()) return 0;
  return evaluate(graph, {Dual<1>::variable(x, 0)}, ScalarAlgebra<Dual<1>>())[static_cast<std::size_t>(y.node())].d[0];
}

}  // namespace

TEST_CASE("operators bind as in mathematics") {
  const std::pair<const char*, double> cases[] = {
      {"-2^2", -4},         {"2^3^2", 512},           {"2^-2", 0.25},     {"2^-2^2", 0.0625},   {"8 / 4 / 2", 1},
      {"4 - 3 - 2", -1},    {"2 * -3", -6},           {"1 + 2 * 3", 7},   {"(1 + 2) * 3", 9},   {"1 < 2 == 1", 1},
      {"1 ? 2 : 3 + 4", 2}, {"0 ? 1 : 0 ? 2 : 3", 3}, {"1 || 0 && 0", 1}, {"1 + 1 ? 3 : 4", 3}, {"3 != 3", 0},
      {"max(1, -2, 5)", 5}, {"avg(1, 2, 6)", 3},      {"rint(-1.5)", -1}, {"sign(-3)", -1},     {"min(2, 1) >= 1", 1}};
  for (const auto& [text, value] : cases) {
    INFO(text);
    CHECK(value_at(text) == value);
  }
}

TEST_CASE("every function's derivative is its central difference") {
  for (const std::string& name : function_names()) {
    const std::string text = name == "atan2"   ? "atan2(2 * x, x ^ 2 + 1)"
                             : name == "acosh" ? "acosh(x + 2)"
                                               : name + "(x) * x^1.5 + 2^x";
    for (const double x : {0.3, 0.7}) {
      INFO(text << " at " << x);
      const double h = 1e-6, difference = (value_at(text, x + h) - value_at(text, x - h)) / (2 * h);
      // rounding of the difference is 1e-16 / h, its truncation h²
      CHECK(slope_at(text, x) == doctest::Approx(difference).epsilon(1e-8));
    }
  }
}

TEST_CASE("the graph of every config gives the numbers that its text would with other values in it") {
  std::mt19937 random(3);
  int read = 0;
  for (const std::string& file : config_files()) {
    std::ifstream in(file);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const DesignSpace space = read_design_space(text, file);
    if (space.start.free_numbers.empty()) continue;
    for (int trial = 0; trial < 3; ++trial) {
      const VectorX x = somewhere(space.start, random);
      INFO(file);
      try {
        const Study expected = read_spec(with_numbers(space.start, x), file);
        const Study found = space.study_at(x);
        const auto compare = [](const std::vector<double>& a, const std::vector<double>& b) {
          REQUIRE(a.size() == b.size());
          // a number is divided by its unit and multiplied again
          for (std::size_t i = 0; i < a.size(); ++i) CHECK(std::abs(a[i] - b[i]) <= 1e-14 * std::abs(b[i]));
        };
        compare(numbers_of(found.mechanism), numbers_of(expected.mechanism));
        compare(numbers_of(found.trajectories), numbers_of(expected.trajectories));
        ++read;
      } catch (const SpecError&) {
        // these numbers make no mechanism
      }
    }
  }
  CHECK(read > 20);
}

TEST_CASE("derivatives of a mechanism by its free numbers are central differences of the mechanism") {
  std::mt19937 random(5);
  for (const std::string& file : config_files()) {
    const DesignSpace space = read_design_space_file(file);
    const VectorX x = somewhere(space.start, random);
    const study::ParametricMechanism mechanism = space.parametric();
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      std::vector<Dual<1>> numbers(x.begin(), x.end());
      numbers[static_cast<std::size_t>(i)].d[0] = 1;
      const MechanismOf<Dual<1>> exact = mechanism.evaluate(numbers);
      const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(i)];
      const double h = 1e-5 * (free.upper - free.lower);
      VectorX up = x, down = x;
      up[i] += h, down[i] -= h;
      const auto a = numbers_of(space.instantiate(up).mechanism), b = numbers_of(space.instantiate(down).mechanism);
      const auto slopes = numbers_of(model::convert_mechanism<double>(exact, [](const Dual<1>& v) { return v.d[0]; }));
      const auto values = numbers_of(space.instantiate(x).mechanism);
      REQUIRE(a.size() == slopes.size());
      INFO(file << ", " << free.key_path);
      for (std::size_t k = 0; k < a.size(); ++k) {
        const double difference = (a[k] - b[k]) / (2 * h);
        // what is no number but an index or a count stays as it is
        if (difference == 0) continue;
        CHECK(std::abs(slopes[k] - difference) <= 1e-7 * (std::abs(difference) + std::abs(values[k]) / h * 1e-9));
      }
    }
  }
}

TEST_CASE("hostile expressions do no harm") {
  CHECK_THROWS_AS(value_at(std::string(100'000, '(')), ExpressionError);
  CHECK(value_at(std::string(499, '(') + "1" + std::string(499, ')')) == 1);
  CHECK(value_at(std::string(998, '-') + "1") == 1);
  // a thousand doublings are a thousand nodes
  const int count = sampling::is_whole() ? 1000 : 200;
  std::string parameters = "{p0: {free: [0, 1]}";
  for (int k = 1; k < count; ++k) parameters += fmt::format(", p{}: \"p{} + p{}\"", k, k - 1, k - 1);
  const std::string text = specs::with(specs::planar, "parameters: {", "parameters: " + parameters + ", ");
  const DesignSpace space = read_design_space(text, "s.yaml");
  CHECK(space.recording->graph.nodes().size() < 3 * static_cast<std::size_t>(count));
  const study::RecordedValues<double> values(*space.recording, std::vector<double>(space.inputs.size(), 0.5));
  CHECK(values(space.recording->parameters[static_cast<std::size_t>(count - 1)].value) == std::ldexp(0.5, count - 1));
}
