#pragma once
/// Components of polynomials: symbols, angles, and products of cosines and sines ("waves").
///
/// Angles belong to groups: those of joints with parallel axes. A wave has at most one cosine or sine per group, of an
/// integer combination of the group's angles, since products within a group are turned into sums immediately:
///
///     cos a cos b = (cos(a − b) + cos(a + b)) / 2,  …
///
/// So every polynomial has a unique form: zero is recognised, and sin² + cos² = 1 and cos(a + b) need no rules.

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

/// Symbols are in ascending order; exponents from −15 to 15, never 0. Small, since there are thousands of monomials.
class Monomial {
 public:
  static constexpr int max_factors = 14;

  Monomial() = default;
  /// symbol^exponent.
  /// @throws FormulaError if the exponent is too large
  explicit Monomial(int symbol, int exponent = 1) { append(symbol, exponent); }

  int size() const { return size_; }
  bool is_one() const { return size_ == 0; }
  int symbol(int k) const { return factors_[static_cast<std::size_t>(k)] >> 5; }
  int exponent(int k) const { return (factors_[static_cast<std::size_t>(k)] & 31) - 16; }
  /// Exponent of any symbol; 0 if it does not occur.
  int exponent_of(int symbol) const;

  /// Appends a symbol, which must come after the others.
  /// @param exponent 0: nothing happens
  void append(int symbol, int exponent);
  /// The factors selected by symbol or exponent.
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

/// Meaning of a symbol. It determines the symbol's position in a product and the grouping of sums.
enum class SymbolKind {
  inertia,       ///< moment or product of inertia
  first_moment,  ///< mass times a coordinate
  mass,
  stiffness,
  gravity,
  length,          ///< may be a divisor
  com_coordinate,  ///< of a mass; may be zero
  ratio,           ///< of discs and couplings
  dimensionless,   ///< of no known dimension
  slide,           ///< a coordinate
  rate,            ///< of a coordinate
  acceleration,
  alias,  ///< stands for a whole expression
};

/// Masses, first moments, moments of inertia, stiffnesses: forces are linear in these.
constexpr bool is_inertial(SymbolKind kind) { return kind <= SymbolKind::stiffness; }

struct Symbol {
  std::string name;
  SymbolKind kind = SymbolKind::dimensionless;
  double value = 0;   ///< SI
  Expression source;  ///< of its value, as a function of the spec's inputs
};

struct Angle {
  std::string name;
  int group = 0;
  bool is_fixed = false;
  double value = 0;   ///< [rad], of fixed angles
  Expression source;  ///< of a fixed angle's value
};

/// A cosine or sine of Σ multiple · angle; the first multiple is positive, the angles are in ascending order.
struct CircularFunction {
  int group = 0;
  bool is_sine = false;
  std::vector<std::pair<int, int>> argument;  ///< angle, multiple: never 0

  friend auto operator<=>(const CircularFunction&,
                          const CircularFunction&) = default;  // NOLINT(modernize-use-nullptr): of its own making
};

/// Groups in ascending order, each at most once.
using TrigonometricMonomial = std::vector<CircularFunction>;
/// A wave by its index in the ring; 0 is the empty product.
using TrigonometricId = std::uint32_t;

/// A multiple of a wave.
struct TrigonometricTerm {
  TrigonometricId wave = 0;
  Rational factor = 1;
};

/// The names that polynomials share. Polynomials hold the ring's address, so it can be neither copied nor moved.
class Ring {
 public:
  Ring();
  Ring(const Ring&) = delete;
  Ring& operator=(const Ring&) = delete;

  /// More are refused with a FormulaError.
  static constexpr int max_symbols = 2000, max_trigonometric_monomials = 20'000;

  /// @return the symbol's index; a name that exists already is extended by `_`
  int add_symbol(const std::string& name, SymbolKind kind, const Expression& source);
  int add_angle(const std::string& name, int group);
  int add_fixed_angle(const std::string& name, int group, const Expression& source);
  /// An angle by itself, as the coordinate of a torsion spring: a symbol with the angle's own name.
  int symbol_of_angle(int angle);
  /// Removes the symbols from this index on; no polynomial may contain them any more.
  void truncate_symbols(int count) { symbols_.resize(static_cast<std::size_t>(count)); }
  bool has_name(const std::string& name) const;

  const std::vector<Symbol>& symbols() const { return symbols_; }
  const std::vector<Angle>& angles() const { return angles_; }
  const Symbol& symbol(int index) const { return symbols_[static_cast<std::size_t>(index)]; }
  const Angle& angle(int index) const { return angles_[static_cast<std::size_t>(index)]; }
  void set_value(int symbol, double value) { symbols_[static_cast<std::size_t>(symbol)].value = value; }
  void set_angle(int angle, double value) { angles_[static_cast<std::size_t>(angle)].value = value; }
  void set_kind(int symbol, SymbolKind kind) { symbols_[static_cast<std::size_t>(symbol)].kind = kind; }
  const TrigonometricMonomial& wave(TrigonometricId id) const { return trigonometric_monomials_[id]; }

  /// Brings a wave into its unique form and returns its index.
  /// @param factor is multiplied by the sign
  TrigonometricId canonicalise(TrigonometricMonomial trig, Rational& factor);
  /// The product of two waves as a sum of waves, one per combination of signs.
  const std::vector<TrigonometricTerm>& product(TrigonometricId a, TrigonometricId b);
  /// Derivative with respect to an angle: at most one wave.
  TrigonometricTerm derivative(TrigonometricId trig, int angle);

  /// Maximum number of products of terms for all formulas: seconds, and some hundred megabytes.
  static constexpr std::size_t max_products = 6'000'000;
  /// Counts work.
  /// @throws FormulaError if there is too much of it
  void count_products(std::size_t products) {
    product_count_ += products;
    if (product_count_ > max_products) throw FormulaError("they are too long; a program (--code) is not");
  }

 private:
  std::vector<Symbol> symbols_;
  std::vector<Angle> angles_;
  std::vector<TrigonometricMonomial> trigonometric_monomials_;
  std::map<TrigonometricMonomial, TrigonometricId> trigonometric_ids_;
  std::map<std::pair<TrigonometricId, TrigonometricId>, std::vector<TrigonometricTerm>> products_;
  std::size_t product_count_ = 0;
};

/// One term of a polynomial: fraction · product of powers of symbols · wave.
struct Term {
  Monomial monomial;
  TrigonometricId wave = 0;
  Rational coefficient;
};

class Polynomial {
 public:
  /// More are refused, so that no mechanism exhausts the memory.
  static constexpr std::size_t max_terms = 400'000;

  Polynomial() = default;
  Polynomial(int whole) : Polynomial(Rational(whole)) {}  // NOLINT(google-explicit-constructor)
  Polynomial(Rational number);                            // NOLINT(google-explicit-constructor)
  /// symbol^exponent.
  static Polynomial of_symbol(Ring& ring, int symbol, int exponent = 1);
  /// cos or sin of an angle.
  static Polynomial of_angle(Ring& ring, int angle, bool sine);
  /// Terms in any order; like terms are combined.
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
  std::vector<Term> terms_;  ///< ascending, no like terms, no zero coefficients
};

Polynomial derivative_by_angle(const Polynomial& p, int angle);
Polynomial derivative_by_symbol(const Polynomial& p, int symbol);
/// Nonnegative powers; negative ones of a single term without a wave only.
/// @throws FormulaError otherwise
Polynomial power(const Polynomial& base, int exponent);
/// Replaces a symbol by a value.
/// @throws FormulaError if that divides by a value of several terms
Polynomial substitute(const Polynomial& p, int symbol, const Polynomial& value);

/// The value for given values of symbols and angles.
double evaluate_polynomial(const Polynomial& p, const std::vector<double>& symbols, const std::vector<double>& angles);
/// The value for the values stored in the ring.
double evaluate_polynomial(const Polynomial& p);

/// The polynomial in symbols that multiplies each wave, by the wave's index.
std::map<TrigonometricId, Polynomial> group_by_trigonometric(const Polynomial& p);
/// Groups terms by a part of their monomial, which is divided out.
std::map<Monomial, Polynomial> group_by_part(const Polynomial& p, const std::function<Monomial(const Term&)>& part);

}  // namespace balance::formulas
