#include "balance/synthesis/formulas/condition_solver.hpp"
#include "balance/synthesis/formulas/formula_parser.hpp"
#include "balance/synthesis/formulas/formula_printer.hpp"
#include "balance/synthesis/formulas/polynomial_division.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace balance::formulas;

namespace {

/// Polynomials of the letters a to h, x, y, z, written as text.
struct Letters {
  Ring ring;

  Letters() {
    double value = 0.7;
    for (const char letter : std::string("abcdefghxyz"))
      ring.add_symbol(std::string(1, letter), SymbolKind::dimensionless, value += 0.31);
  }
  int symbol(const std::string& name) const {
    const auto& all = ring.symbols();
    return static_cast<int>(std::find_if(all.begin(), all.end(), [&](const Symbol& one) { return one.name == name; }) -
                            all.begin());
  }
  static Polynomial number(const std::string& text) { return {Rational::parse(text)}; }
  Polynomial name(const std::string& one) { return Polynomial::of_symbol(ring, symbol(one)); }
  static bool is_function(const std::string&) { return false; }
  static Polynomial call(const std::string&, const Polynomial&) { return {}; }
  static Polynomial power(const Polynomial& base, int exponent) { return balance::formulas::power(base, exponent); }
  static Polynomial quotient(const Polynomial& a, const Polynomial& b) { return a * balance::formulas::power(b, -1); }
  Polynomial read(const std::string& text) { return FormulaParser<Polynomial, Letters>(text, *this).read(); }

  ConditionSolution solve(const std::vector<std::string>& conditions, const std::vector<std::string>& unknowns) {
    std::vector<Polynomial> rows;
    std::vector<int> symbols;
    for (const std::string& text : conditions) rows.push_back(read(text));
    for (const std::string& one : unknowns) symbols.push_back(symbol(one));
    return solve_conditions(rows, symbols);
  }
  bool is_value(const SolvedUnknown& one, const std::string& numerator, const std::string& denominator) {
    return one.value.numerator * read(denominator) == one.value.denominator * read(numerator);
  }
};

}  // namespace

TEST_CASE("the greatest common divisor of two products is the product of what they share") {
  Letters l;
  const Polynomial p = l.read("(a + b - 2 c) (a^2 - b)"), q = l.read("6 a (c x + y)^2"),
                   shared = l.read("3 b (a x - y)");
  const Polynomial found = greatest_common_divisor(p * shared, q * shared);
  CHECK(found == with_coprime_coefficients(shared));
  CHECK(greatest_common_divisor(p, q) == Polynomial(1));
  CHECK(divide_exactly(p * q, q).value() == p);
  CHECK_FALSE(divide_exactly(p * q + Polynomial(1), q).has_value());
}

TEST_CASE("factors are separated by the symbols that they depend on, and repeated ones are found") {
  Letters l;
  const auto factors = list_factors(l.read("-4 x (a + b) (c - y)^2"));
  REQUIRE(factors.size() == 3);
  for (const char* factor : {"x", "a + b", "c - y"})
    CHECK(std::count(factors.begin(), factors.end(), with_coprime_coefficients(l.read(factor))) == 1);
}

TEST_CASE("two equations that are linear in two unknowns give Cramer's rule, whose determinant must not vanish") {
  Letters l;
  const auto solution = l.solve({"a x + b y - c", "d x + e y - f"}, {"x", "y"});
  REQUIRE(solution.solved.size() == 2);
  CHECK(l.is_value(solution.solved[0], "c e - b f", "a e - b d"));
  CHECK(l.is_value(solution.solved[1], "a f - c d", "a e - b d"));
  REQUIRE(solution.nonzero.size() == 1);
  CHECK(solution.nonzero[0] == with_coprime_coefficients(l.read("a e - b d")));
  CHECK(solution.remaining.empty());
}

TEST_CASE("a condition that is quadratic in one unknown is linear in the next, once the first is known") {
  Letters l;
  const auto solution = l.solve({"b y + c x^2 + a", "d x + e"}, {"y", "x"});
  REQUIRE(solution.solved.size() == 2);
  CHECK(l.is_value(solution.solved[0], "-(a d^2 + c e^2)", "b d^2"));
  CHECK(l.is_value(solution.solved[1], "-e", "d"));
}

TEST_CASE("what is not solved says why, and what remains is what the solution leaves of the conditions") {
  Letters l;
  SUBCASE("more unknowns than conditions: those named first are solved for") {
    const auto solution = l.solve({"a x + b y + c"}, {"y", "x", "z"});
    REQUIRE(solution.solved.size() == 1);
    CHECK(solution.solved[0].symbol == l.symbol("y"));
    REQUIRE(solution.unsolved.size() == 2);
    CHECK(solution.unsolved[0].reason == UnsolvedReason::undetermined);
    CHECK(solution.unsolved[1].reason == UnsolvedReason::absent);
  }
  SUBCASE("not linear") {
    const auto solution = l.solve({"a x^2 - b"}, {"x"});
    CHECK(solution.solved.empty());
    CHECK(solution.unsolved.at(0).reason == UnsolvedReason::nonlinear);
    CHECK(solution.remaining.size() == 1);
  }
  SUBCASE("a condition on the other numbers") {
    const auto solution = l.solve({"a x - b", "c x - d"}, {"x"});
    REQUIRE(solution.remaining.size() == 1);
    CHECK(solution.remaining[0] == with_coprime_coefficients(l.read("b c - a d")));
  }
  SUBCASE("a contradiction") {
    const auto solution = l.solve({"x + y", "x + y + 1"}, {"x"});
    REQUIRE(solution.remaining.size() == 1);
    CHECK(solution.remaining[0] == Polynomial(1));
  }
  SUBCASE("dependent conditions leave nothing") {
    CHECK(l.solve({"a x - b", "2 c a x - 2 c b"}, {"x"}).remaining.empty());
  }
}

TEST_CASE("of a product that must vanish, the factor is zero that is zero with the spec's numbers") {
  Letters l;
  SUBCASE("the mass of a counterweight beside its line is not zero: y is") {
    l.ring.set_value(l.symbol("z"), 0);
    const auto solution = l.solve({"x y + a", "x z"}, {"x", "y"});
    REQUIRE(solution.solved.size() == 1);
    CHECK(l.is_value(solution.solved[0], "-a", "y"));
    REQUIRE(solution.remaining.size() == 1);
    CHECK(solution.remaining[0] == l.read("a z"));
  }
  SUBCASE("alone it is not solved, and the reason is said") {
    l.ring.set_value(l.symbol("z"), 0);
    const auto solution = l.solve({"x z"}, {"x"});
    CHECK(solution.solved.empty());
    CHECK(solution.unsolved.at(0).reason == UnsolvedReason::vanishing_slope);
    CHECK(solution.remaining.size() == 1);
  }
  SUBCASE("otherwise the unknown is, and the factor must not vanish") {
    const auto solution = l.solve({"x z"}, {"x"});
    REQUIRE(solution.solved.size() == 1);
    CHECK(solution.solved[0].value.is_zero());
    REQUIRE(solution.nonzero.size() == 1);
    CHECK(solution.nonzero[0] == l.read("z"));
  }
}

TEST_CASE("factors by which was divided are listed only where the unknowns depend on them") {
  Letters l;
  // where b vanishes, any x is a solution; a is the first pivot, but the determinant does not need it
  CHECK(l.solve({"b (a x + c)"}, {"x"}).nonzero.size() == 2);
  const auto solution = l.solve({"a x + b y", "d x + e y"}, {"x", "y"});
  REQUIRE(solution.nonzero.size() == 1);
  CHECK(solution.nonzero[0] == with_coprime_coefficients(l.read("a e - b d")));
}
