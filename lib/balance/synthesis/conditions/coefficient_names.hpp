#pragma once
/// Coefficients of conditions under the names of the lengths and ratios that they are made of: `l1` instead of `0.5`.

#include "balance/foundation/base/types.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/conditions/geometric_parameters.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance {

/// Recognises numbers as products, quotients and two-term sums of quantities that have names, and as cosines and sines of angles.
struct SymbolPower {
  int symbol = 0;    ///< index into a list that the user keeps
  int exponent = 1;  ///< not zero

  bool operator==(const SymbolPower&) const = default;
};

/// numerator/denominator · Π symbol^exponent
struct RationalMonomial {
  int numerator = 1;    ///< signed
  int denominator = 1;  ///< positive
  std::vector<SymbolPower> powers;

  double value(const VectorX& symbols) const;
  bool operator==(const RationalMonomial&) const = default;
};

/// Cosine or sine of a sum of whole multiples of angles.
struct TrigonometricFactor {
  bool is_sine = false;
  std::vector<SymbolPower> angles;  ///< exponent: the multiple; the first one is positive

  double value(const VectorX& symbols) const;
};

/// factor, factor · (first + second) or factor · wave
struct CoefficientFormula {
  RationalMonomial factor;
  std::vector<RationalMonomial> sum;  ///< empty or two
  std::optional<TrigonometricFactor> wave;

  double value(const VectorX& symbols) const;
};

/// A number that depends on symbols, here and with one of them at a time multiplied and divided by `probe_factor`; angles are
/// turned by `probe_angle` to and fro.
struct PerturbationResponse {
  double value = 0;
  VectorX up, down;  ///< one entry per symbol
};

/// So far that a power is told from a sum through ten digits of noise, so near that a mechanism still assembles.
inline constexpr double probe_factor = 1 + 1.0 / 64;
inline constexpr double probe_angle = 1.0 / 64;  ///< [rad]

/// A number that is plus or minus a ratio of 1, 2, 3 and 4.
std::optional<RationalMonomial> find_small_ratio(double number);

/// The formula that explains all of a response, with whole exponents of at most 4 and numbers that are ratios of 1, 2, 3 and
/// 4; nothing if there is none.
/// @param symbols their values, not zero
std::optional<CoefficientFormula> recognise_coefficient(const VectorX& symbols, const PerturbationResponse& response);

/// The same for numbers that are a product of powers times the cosine or sine of a sum of angles.
/// @param is_angle one per symbol
std::optional<CoefficientFormula> recognise_trigonometric_coefficient(const VectorX& symbols,
                                                                      const std::vector<bool>& is_angle,
                                                                      const PerturbationResponse& response);

/// A quantity that readers know by a name, and the geometric numbers that it governs.
struct GeometricSymbol {
  std::string label;  ///< "l1", "link1.B.x"
  std::string unit;   ///< "m", "m/s^2", "1"
  double value = 0;   ///< SI, not zero
  struct Use {
    GeometricParameter number;
    int exponent = 1;  ///< the number follows this power of the symbol
  };
  std::vector<Use> uses;
  bool is_angle = false;  ///< a direction, which its one use is turned by
};

/// Every geometric number that is not zero, under its own name.
std::vector<GeometricSymbol> list_geometric_symbols(const Mechanism& mechanism);

/// The same conditions with names. A coefficient without a formula is only a number.
struct ConditionNames {
  std::vector<GeometricSymbol> symbols;  ///< those that occur
  std::vector<std::vector<std::optional<CoefficientFormula>>>
      formulas;                    ///< per condition and parameter; empty: none at all
  std::vector<std::string> notes;  ///< what could not be named, and why

  /// Nothing for a coefficient that is only a number.
  const CoefficientFormula* find(int row, int parameter) const;
};

struct NamingOptions {
  int max_parameters = 120;  ///< of larger mechanisms the conditions take too long to derive again and again
  int max_symbols = 60;
};

/// Derives the conditions again with each symbol a little larger and smaller. What no lengths explain is tried, in the plane, with
/// the directions of the points whose two coordinates are symbols of their own: frames that are turned against the lines from
/// joint to joint leave cosines and sines. A symbol whose change takes the mechanism's special
/// geometry away, so that there are other conditions, is left out.
/// @param derive as the conditions were derived
ConditionNames name_coefficients(const Mechanism& mechanism, const Conditions& conditions,
                                 const std::vector<GeometricSymbol>& symbols,
                                 const std::function<Conditions(const Mechanism&)>& derive,
                                 const NamingOptions& options = {});

/// "l1^2/(2 l2)", "l1 (l2 - l3)", "0.5", with its sign.
std::string formula_text(const CoefficientFormula& formula, const std::vector<GeometricSymbol>& symbols);

/// "link1.mx + l1 link2.m = 0", "link1.mx + l1 link2.m = (l1/g) push.fy": one condition, known terms on the right. Without a formula for a
/// coefficient six digits of it.
std::string condition_text(const Conditions& conditions, int row, const ConditionNames& names = {});

}  // namespace balance
