#pragma once
/// Coefficients of conditions under the names of the lengths and ratios that they are made of: `l1` instead of `0.5`.

#include "balance/conditions/conditions.hpp"
#include "balance/conditions/geometry.hpp"
#include "balance/conditions/recognise.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance {

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

/// "link1.mx + l1 link2.m = 0", "link1.mx + l1 link2.m = (l1/g) push.fy": one condition, known terms on the right. Without a formula for a coefficient six digits of it.
std::string condition_text(const Conditions& conditions, int row, const ConditionNames& names = {});

}  // namespace balance
