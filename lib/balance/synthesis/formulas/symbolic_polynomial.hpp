#pragma once
/// What polynomials are made of: symbols, angles, and products of cosines and sines ("waves").
///
/// Angles belong to runs: those of joints with parallel axes. In a run a wave has at most one cosine or sine, of an integer
/// combination of the run's angles, since products within a run are turned into sums at once:
///
///     cos a cos b = (cos(a − b) + cos(a + b)) / 2,  …
///
/// So every polynomial has one form, sin² + cos² = 1 and cos(a + b) need no rule of their own, and what is zero is seen to be.

#include "balance/foundation/expression/expression.hpp"
#include "balance/synthesis/formulas/rational.hpp"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace balance::formulas {

// A product of powers of symbols.

/// Symbols ascend; exponents from −15 to 15, never 0. Small, since there are thousands of them.
class Monomial {
 public:
  static constexpr int max_factors = 14;

  Monomial() = default;
  /// symbol^exponent. @throws FormulaError if the exponent is too large
  explicit Monomial(int symbol, int exponent = 1) { append(symbol, exponent); }

  int size() const { return size_; }
  bool is_one() const { return size_ == 0; }
  int symbol(int k) const { return factors_[static_cast<std::size_t>(k)] >> 5; }
  int exponent(int k) const { return (factors_[static_cast<std::size_t>(k)] & 31) - 16; }
  /// Of any symbol, 0 for one that does not occur.
  int exponent_of(int symbol) const;

  /// Puts another symbol behind the others. @param exponent 0: nothing happens
  void append(int symbol, int exponent);
  /// The factors whose symbols, or exponents, are chosen.
  template <class Choose>
  Monomial select(Choose&& choose) const {
    Monomial chosen;
    for (int k = 0; k < size_; ++k)
      if (choose(symbol(k), exponent(k))) chosen.append(symbol(k), exponent(k));
    return chosen;
  }
  Monomial inverse() const;

  friend Monomial operator*(const Monomial& a, const Monomial& b);
  friend Monomial operator/(const Monomial& a, const Monomial& b) { return a * b.inverse(); }
  friend auto operator<=>(const Monomial& a,
                          const Monomial& b) = default;  // NOLINT(modernize-use-nullptr): of its own making

 private:
  std::array<std::uint16_t, max_factors> factors_{};
  std::uint16_t size_ = 0;
};

/// What a symbol stands for: it decides about its place in a product and about what sums are grouped by.
enum class SymbolKind {
  inertia,       ///< moment or product of inertia
  first_moment,  ///< mass times a place
  mass,
  stiffness,
  gravity,
  length,          ///< may be divided by
  com_coordinate,  ///< of a mass; may be zero
  ratio,           ///< of discs and couplings
  dimensionless,   ///< of no known dimension
  slide,           ///< a coordinate
  rate,            ///< of a coordinate
  acceleration,
  alias,  ///< stands for a whole expression
};

/// Masses, first moments, moments of inertia, stiffnesses: what forces are linear in.
constexpr bool is_inertial(SymbolKind kind) { return kind <= SymbolKind::stiffness; }

struct Symbol {
  std::string name;
  SymbolKind kind = SymbolKind::dimensionless;
  double value = 0;   ///< SI
  Expression source;  ///< of its value, over the spec's inputs
};

struct Angle {
  std::string name;
  int group = 0;
  bool is_fixed = false;
  double value = 0;   ///< [rad], of fixed angles
  Expression source;  ///< of a fixed angle's value
};

/// A cosine or sine of Σ multiple · angle; the first multiple is positive, the angles ascend.
struct CircularFunction {
  int group = 0;
  bool is_sine = false;
  std::vector<std::pair<int, int>> argument;  ///< angle, multiple: never 0

  friend auto operator<=>(const CircularFunction&,
                          const CircularFunction&) = default;  // NOLINT(modernize-use-nullptr): of its own making
};

/// Runs ascend, each occurs once.
using TrigonometricMonomial = std::vector<CircularFunction>;
/// A wave by its number in the ring; 0 is the empty product.
using TrigonometricId = std::uint32_t;

/// A multiple of a wave.
struct TrigonometricTerm {
  TrigonometricId wave = 0;
  Rational factor = 1;
};

/// The names that polynomials share. They hold its address: neither copied nor moved.
class Ring {
 public:
  Ring();
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;

  /// More are refused.
  static constexpr int max_symbols = 2000, max_trigonometric_monomials = 20'000;

  /// @return the symbol's number; a name that is there already gets one that is not, by a `_` behind it
  int add_symbol(const std::string& name, SymbolKind kind, const Expression& source);
  int add_angle(const std::string& name, int run);
  int add_fixed_angle(const std::string& name, int run, const Expression& source);
  /// An angle where it stands by itself, as a coordinate of a torsion spring: a symbol with the angle's own name.
  int symbol_of_angle(int angle);
  /// Forgets the symbols from there on, in which no polynomial must be left.
  void truncate_symbols(int count) { symbols_.resize(static_cast<std::size_t>(count)); }
  bool has_name(const std::string& name) const;

  const std::vector<Symbol>& symbols() const { return symbols_; }
  const std::vector<Angle>& angles() const { return angles_; }
  const Symbol& symbol(int index) const { return symbols_[static_cast<std::size_t>(index)]; }
  const Angle& angle(int index) const { return angles_[static_cast<std::size_t>(index)]; }
  void set_value(int symbol, double value) { symbols_[static_cast<std::size_t>(symbol)].value = value; }
  void set_angle(int angle, double value) { angles_[static_cast<std::size_t>(angle)].value = value; }
  void set_kind(int symbol, SymbolKind kind) { symbols_[static_cast<std::size_t>(symbol)].kind = kind; }
  const TrigonometricMonomial& wave(TrigonometricId id) const { return waves_[id]; }

  /// The number of a wave, which is brought into its one form. @param factor takes its sign
  TrigonometricId canonicalise(TrigonometricMonomial wave, Rational& factor);
  /// The product of two waves as a sum of waves, one for each pair of signs.
  const std::vector<TrigonometricTerm>& product(TrigonometricId a, TrigonometricId b);
  /// Derivative by an angle: at most one wave.
  TrigonometricTerm derivative(TrigonometricId wave, int angle);

  /// Products of terms that formulas may take altogether: seconds, and some hundred megabytes.
  static constexpr std::size_t max_products = 6'000'000;
  /// Counts work. @throws FormulaError where it is too much
  void count_products(std::size_t products) {
    work_ += products;
    if (work_ > max_products) throw FormulaError("they are too long; a program (--code) is not");
  }

 private:
  std::vector<Symbol> symbols_;
  std::vector<Angle> angles_;
  std::vector<TrigonometricMonomial> waves_;
  std::map<TrigonometricMonomial, TrigonometricId> numbers_;
  std::map<std::pair<TrigonometricId, TrigonometricId>, std::vector<TrigonometricTerm>> products_;
  std::size_t work_ = 0;
};

/// Sums of: fraction · product of powers of symbols · wave. One form for every function, see symbolic_polynomial.hpp.
struct Term {
  Monomial monomial;
  TrigonometricId wave = 0;
  Rational coefficient;
};

class Polynomial {
 public:
  /// More are refused, so that no mechanism takes all memory.
  static constexpr std::size_t max_terms = 400'000;

  Polynomial() = default;
  Polynomial(int whole) : Polynomial(Rational(whole)) {}  // NOLINT(google-explicit-constructor)
  Polynomial(Rational number);                            // NOLINT(google-explicit-constructor)
  /// symbol^exponent.
  static Polynomial of_symbol(Ring& ring, int symbol, int exponent = 1);
  /// cos or sin of an angle.
  static Polynomial of_angle(Ring& ring, int angle, bool sine);
  /// Terms in any order, some perhaps alike.
  static Polynomial of_terms(Ring* ring, std::vector<Term> terms);

  const std::vector<Term>& terms() const { return terms_; }
  std::size_t size() const { return terms_.size(); }
  bool is_zero() const { return terms_.empty(); }
  /// Null for a plain number.
  Ring* ring() const { return ring_; }

  Polynomial operator-() const;
  Polynomial& operator+=(const Polynomial& other);
  Polynomial& operator-=(const Polynomial& other) { return *this += -other; }
  friend Polynomial operator+(Polynomial a, const Polynomial& b) { return a += b; }
  friend Polynomial operator-(Polynomial a, const Polynomial& b) { return a -= b; }
  friend Polynomial operator*(const Polynomial& a, const Polynomial& b);
  friend bool operator==(const Polynomial& a, const Polynomial& b);

 private:
  Ring* ring_ = nullptr;
  std::vector<Term> terms_;  ///< ascending, none alike, no factor zero
};

Polynomial derivative_by_angle(const Polynomial& p, int angle);
Polynomial derivative_by_symbol(const Polynomial& p, int symbol);
/// Powers from 0 on; negative ones of a single term without a wave. @throws FormulaError for others
Polynomial power(const Polynomial& base, int exponent);
/// The symbol's place taken by a value. @throws FormulaError if it is divided by a value of several terms
Polynomial substitute(const Polynomial& p, int symbol, const Polynomial& value);

/// Its value where symbols and angles have these values.
double evaluate_polynomial(const Polynomial& p, const std::vector<double>& symbols, const std::vector<double>& angles);
/// With the values that the ring's symbols and angles have.
double evaluate_polynomial(const Polynomial& p);

/// Every wave and the polynomial of symbols before it, by the wave's number.
std::map<TrigonometricId, Polynomial> group_by_trigonometric(const Polynomial& p);
/// Terms by a part of their monomial, divided by it.
std::map<Monomial, Polynomial> group_by_part(const Polynomial& p, const std::function<Monomial(const Term&)>& part);

}  // namespace balance::formulas
