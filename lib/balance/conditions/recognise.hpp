#pragma once
/// Recognises numbers as products, quotients and two-term sums of quantities that have names, and as cosines and sines of angles.

#include "balance/base/types.hpp"

#include <optional>
#include <vector>

namespace balance {

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

}  // namespace balance
