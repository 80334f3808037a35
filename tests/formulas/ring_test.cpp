#include "balance/synthesis/formulas/formula_parser.hpp"
#include "balance/synthesis/formulas/formula_printer.hpp"
#include "balance/synthesis/formulas/mechanism_symbols.hpp"
#include "balance/synthesis/formulas/symbolic_polynomial.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace balance::formulas;

namespace {

struct Random {
  Ring ring;
  std::mt19937 random{7};
  std::vector<double> symbols, angles;

  Random() {
    std::uniform_real_distribution<double> any(0.3, 1.7);
    for (const char* name : {"a", "b", "m"}) {
      symbols.push_back(any(random));
      ring.add_symbol(name, name[0] == 'm' ? SymbolKind::mass : SymbolKind::length, symbols.back());
    }
    for (int k = 0; k < 3; ++k) {
      angles.push_back(any(random));
      ring.add_fixed_angle(std::string(1, static_cast<char>('u' + k)), k == 2 ? 1 : 0, angles.back());
    }
  }
  Polynomial draw(int terms) {
    std::uniform_int_distribution<int> pick(0, 2), size(-3, 3);
    Polynomial sum;
    for (int t = 0; t < terms; ++t)
      sum += Polynomial(Rational(size(random), 4)) * Polynomial::of_symbol(ring, pick(random), 1 + pick(random)) *
             Polynomial::of_angle(ring, pick(random), pick(random) == 0) *
             Polynomial::of_angle(ring, pick(random), pick(random) == 0);
    return sum;
  }
};

}  // namespace

TEST_CASE("sin² + cos² is one, and angles add up, without a rule") {
  Random r;
  const auto c = [&](int k) { return Polynomial::of_angle(r.ring, k, false); };
  const auto s = [&](int k) { return Polynomial::of_angle(r.ring, k, true); };
  CHECK(c(0) * c(0) + s(0) * s(0) == Polynomial(1));
  CHECK((c(0) * c(1) - s(0) * s(1)).size() == 1);
  CHECK((c(0) * c(2)).size() == 1);  // axes that are not parallel: nothing to be added
}

TEST_CASE("sums, products and derivatives of polynomials are those of their values") {
  Random r;
  for (int round = 0; round < 20; ++round) {
    const Polynomial p = r.draw(4), q = r.draw(5);
    CHECK(evaluate_polynomial(p * q) ==
          doctest::Approx(evaluate_polynomial(p) * evaluate_polynomial(q)).epsilon(1e-12));
    CHECK(evaluate_polynomial(p - q) ==
          doctest::Approx(evaluate_polynomial(p) - evaluate_polynomial(q)).epsilon(1e-12));
    // central differences of step 1e-5: their error is 1e-10 of the third derivative
    for (int angle = 0; angle < 3; ++angle) {
      auto up = r.angles, down = r.angles;
      up[static_cast<std::size_t>(angle)] += 1e-5, down[static_cast<std::size_t>(angle)] -= 1e-5;
      const double slope = (evaluate_polynomial(p, r.symbols, up) - evaluate_polynomial(p, r.symbols, down)) / 2e-5;
      CHECK(evaluate_polynomial(derivative_by_angle(p, angle)) == doctest::Approx(slope).epsilon(1e-7));
    }
  }
}

TEST_CASE("what is printed reads as what it was") {
  Random r;
  for (int round = 0; round < 60; ++round) {
    const Polynomial p = r.draw(1 + round % 6), q = round % 3 == 0 ? p * p : p;
    std::map<std::string, double> names;
    for (const Symbol& symbol : r.ring.symbols()) names[symbol.name] = symbol.value;
    for (const Angle& angle : r.ring.angles()) names[angle.name] = angle.value;
    const std::string text = FormulaPrinter(r.ring).print(q);
    CHECK_MESSAGE(evaluate_text(text, names) == doctest::Approx(evaluate_polynomial(q)).epsilon(1e-11), text);
    CHECK_MESSAGE(evaluate_text(FormulaPrinter(r.ring).print_numbers(q), names) ==
                      doctest::Approx(evaluate_polynomial(q)).epsilon(1e-11),
                  text);
    const std::string collected = FormulaPrinter(r.ring, PrintStyle::text, {1, 0}).print(q);
    CHECK_MESSAGE(evaluate_text(collected, names) == doctest::Approx(evaluate_polynomial(q)).epsilon(1e-11), collected);
    const Polynomial divisor = r.draw(1 + round % 3) + Polynomial(2), factor = r.draw(1 + round % 4);
    const double ratio = evaluate_polynomial(p) / evaluate_polynomial(divisor);
    const std::string quotient = FormulaPrinter(r.ring).print_ratio(p, divisor),
                      product = FormulaPrinter(r.ring).print_product(p, divisor, factor);
    CHECK_MESSAGE(evaluate_text(quotient, names) == doctest::Approx(ratio).epsilon(1e-10), quotient);
    CHECK_MESSAGE(evaluate_text(product, names) == doctest::Approx(ratio * evaluate_polynomial(factor)).epsilon(1e-10),
                  product);
  }
}

TEST_CASE("fractions stand below the line, and the minuend of a difference comes first") {
  Ring ring;
  for (const char* name : {"a", "b", "c"}) ring.add_symbol(name, SymbolKind::length, 1);
  const Polynomial a = Polynomial::of_symbol(ring, 0), b = Polynomial::of_symbol(ring, 1),
                   c = Polynomial::of_symbol(ring, 2);
  const Polynomial half = Rational(1, 2), minus = -1;
  FormulaPrinter printer(ring);
  CHECK(printer.print(minus * half * a * (b + c)) == "-a (b + c)/2");
  CHECK(printer.print(half * power(c, -1) * a * b) == "a b/(2 c)");
  CHECK(printer.print(minus * Polynomial(2) * a * b + Polynomial(2) * a * c) == "2 a (c - b)");
  CHECK(printer.print(b - a) == "b - a");
  CHECK(printer.print_ratio(half * a + b, c) == "(a + 2 b)/(2 c)");
  CHECK(printer.print_product(minus * a, half * c, a + b) == "-2 a (a + b)/c");
  CHECK(FormulaPrinter(ring, PrintStyle::text, {2}).print((a + b) * c * c + a * c) == "c^2 (a + b) + a c");
}

TEST_CASE("a fraction that does not fit is reported, never rounded") {
  const Rational huge(std::numeric_limits<std::int64_t>::max(), 1), tiny = Rational(1) / huge;
  CHECK_THROWS_AS(huge * Rational(2), FormulaError);
  CHECK_THROWS_AS(huge + Rational(1), FormulaError);
  CHECK_THROWS_AS(tiny * Rational(1, 3), FormulaError);
  CHECK(huge * tiny == Rational(1));
  CHECK(Rational::parse("-0.35") == Rational(-7, 20));
  CHECK(Rational::parse("1.5e-3") == Rational(3, 2000));
  CHECK_THROWS_AS(Rational::parse("1e99"), FormulaError);
  CHECK_THROWS_AS(Rational(1) / Rational(0), FormulaError);
}

TEST_CASE("texts that are no formulas are refused, however deep") {
  CHECK_THROWS_AS(evaluate_text("1 +", {}), FormulaError);
  CHECK_THROWS_AS(evaluate_text("a", {}), FormulaError);
  CHECK_THROWS_AS(evaluate_text("2^1.5", {}), FormulaError);
  CHECK_THROWS_AS(evaluate_text(std::string(100'000, '('), {}), FormulaError);
  CHECK_THROWS_AS(evaluate_text(std::string(100'000, '-'), {}), FormulaError);
  CHECK(evaluate_text("-2^2 + 6/2 a (1 + 1)", {{"a", 0.5}}) == doctest::Approx(-1));
}

TEST_CASE("Greek letters of names are written out, and names that mean something else are not taken") {
  CHECK(identifier_name("θ1") == "theta1");
  CHECK(identifier_name("µ_Ω") == "mu_Omega");
  CHECK(identifier_name("π") == "pi_");
  CHECK(identifier_name("2nd.leg") == "x2nd_leg");
}

TEST_CASE("in LaTeX a word is upright as a whole, and a quantity's letter has the rest as its index") {
  CHECK(latex_name("prototype") == "\\mathrm{prototype}");
  CHECK(latex_name("tare2") == "\\mathrm{tare}_{2}");
  CHECK(latex_name("l2") == "l_{2}");
  CHECK(latex_name("lg2") == "l_{g2}");
  CHECK(latex_name("Jxy2") == "J_{\\mathrm{xy2}}");
  CHECK(latex_name("Ja_d") == "J_{ad}");
  CHECK(latex_name("xB2") == "x_{B2}");
  CHECK(latex_name("theta1") == "\\theta_{1}");
  CHECK(latex_name("m_cargo") == "m_{\\mathrm{cargo}}");
  CHECK(latex_name("C1_10") == "C_{1,10}");
  CHECK(latex_name("Delta2") == "\\Delta_{2}");
}
