#pragma once
/// What polynomials are made of: symbols, angles, and products of cosines and sines ("waves").
///
/// Angles belong to runs: those of joints with parallel axes. In a run a wave has at most one cosine or sine, of an integer
/// combination of the run's angles, since products within a run are turned into sums at once:
///
///     cos a cos b = (cos(a − b) + cos(a + b)) / 2,  …
///
/// So every polynomial has one form, sin² + cos² = 1 and cos(a + b) need no rule of their own, and what is zero is seen to be.

#include "balance/expression/expression.hpp"
#include "balance/formulas/rational.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace balance::formulas {

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

}  // namespace balance::formulas
