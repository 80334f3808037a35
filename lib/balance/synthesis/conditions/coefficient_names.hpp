#pragma once
/// Coefficients of conditions as formulas of named lengths and ratios: `l1` instead of `0.5`.

#include "balance/foundation/base/types.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/conditions/geometric_parameters.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance::conditions {

/// Numbers are recognised as products, quotients and two-term sums of named quantities, and as cosines and sines.
struct SymbolPower {
  int symbol = 0;    ///< index into the caller's list of symbols
  int exponent = 1;  ///< nonzero

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

/// Cosine or sine of a sum of integer multiples of angles.
struct TrigonometricFactor {
  bool is_sine = false;
  std::vector<SymbolPower> angles;  ///< exponent: the multiple; positive for the first angle

  double value(const VectorX& symbols) const;
};

/// factor, factor · (first + second) or factor · wave
struct CoefficientFormula {
  RationalMonomial factor;
  std::vector<RationalMonomial> sum;  ///< no or two terms
  std::optional<TrigonometricFactor> wave;

  double value(const VectorX& symbols) const;
};

/// How a number depends on symbols: its value, and its values with one symbol at a time multiplied and divided by
/// `probe_factor`, or, for angles, increased and decreased by `probe_angle`.
struct PerturbationResponse {
  double value = 0;
  VectorX up, down;  ///< one entry per symbol
};

/// Large enough to distinguish a power from a sum in noise of 1e-10, small enough that the mechanism still assembles.
inline constexpr double probe_factor = 1 + 1.0 / 64;
inline constexpr double probe_angle = 1.0 / 64;  ///< [rad]

/// Returns the number as ±p/q with p and q from 1 to 4, or std::nullopt.
std::optional<RationalMonomial> find_small_ratio(double number);

/// Returns the formula that explains the whole response, with integer exponents of magnitude at most 4 and numbers that
/// are ratios of 1, 2, 3 and 4; std::nullopt if there is none.
/// @param symbols their values, nonzero
std::optional<CoefficientFormula> recognise_coefficient(const VectorX& symbols, const PerturbationResponse& response);

/// As above, for a product of powers times the cosine or sine of a sum of angles.
/// @param is_angle one flag per symbol
std::optional<CoefficientFormula> recognise_trigonometric_coefficient(const VectorX& symbols,
                                                                      const std::vector<bool>& is_angle,
                                                                      const PerturbationResponse& response);

/// A named quantity and the geometric numbers that it determines.
struct GeometricSymbol {
  std::string label;  ///< "l1", "link1.B.x"
  std::string unit;   ///< "m", "m/s^2", "1"
  double value = 0;   ///< SI, nonzero
  struct Use {
    GeometricParameter number;
    int exponent = 1;  ///< the number is proportional to this power of the symbol
  };
  std::vector<Use> uses;
  bool is_angle = false;  ///< the direction of a point; its one use is the angle to rotate
};

/// Lists every nonzero geometric number under its own name.
std::vector<GeometricSymbol> list_geometric_symbols(const Mechanism& mechanism);

/// Formulas for the coefficients of conditions. A coefficient without a formula remains a number.
struct ConditionNames {
  std::vector<GeometricSymbol> symbols;  ///< those that occur
  std::vector<std::vector<std::optional<CoefficientFormula>>>
      formulas;                    ///< per condition and parameter; empty if nothing has a formula
  std::vector<std::string> notes;  ///< what could not be named, and why

  /// nullptr if the coefficient has no formula
  const CoefficientFormula* find(int row, int parameter) const;
};

struct NamingOptions {
  int max_parameters = 120;  ///< larger mechanisms take too long to derive the conditions repeatedly
  int max_symbols = 60;
};

/// Derives the conditions again with each symbol slightly larger and smaller. In the plane, coefficients that lengths
/// do not explain are then tried with the directions of points whose coordinates are symbols: frames that are rotated
/// relative to the lines between joints lead to cosines and sines. Symbols whose change destroys the mechanism's
/// special geometry, so that the conditions become different ones, are left out.
/// @param derive derives conditions as `conditions` were derived
ConditionNames name_coefficients(const Mechanism& mechanism, const Conditions& conditions,
                                 const std::vector<GeometricSymbol>& symbols,
                                 const std::function<Conditions(const Mechanism&)>& derive,
                                 const NamingOptions& options = {});

/// "l1^2/(2 l2)", "l1 (l2 - l3)", "0.5", with its sign.
std::string formula_text(const CoefficientFormula& formula, const std::vector<GeometricSymbol>& symbols);

/// "link1.mx + l1 link2.m = 0", "link1.mx + l1 link2.m = (l1/g) push.fy": one condition, known terms on the right-hand
/// side. Coefficients without a formula have six digits.
std::string condition_text(const Conditions& conditions, int row, const ConditionNames& names = {});

}  // namespace balance::conditions
