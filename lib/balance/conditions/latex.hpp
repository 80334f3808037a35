#pragma once
/// Conditions as LaTeX. Needs amsmath.

#include "balance/conditions/naming.hpp"

#include <string>

namespace balance {

/// "m_{\text{link2}}", "(m x)_{\text{link1}}", "I_{xx,\text{link1}}".
std::string parameter_latex(const Parameter& parameter);

/// Of a symbol's label: "l_{1}", "\gamma_{3}", "x_{\text{link1.B}}".
std::string symbol_latex(const std::string& label);

/// "\frac{l_{1}^{2}}{2\, l_{2}}", with its sign.
std::string formula_latex(const CoefficientFormula& formula, const std::vector<GeometricSymbol>& symbols);

/// "(m x)_{\text{link1}} + l_{1}\, m_{\text{link2}} = 0", for maths mode.
std::string condition_latex(const Conditions& conditions, int row, const ConditionNames& names = {});

/// All of them, one below the other, in an align* environment; long ones on several lines. Ends with a line feed.
std::string conditions_latex(const Conditions& conditions, const ConditionNames& names = {});

}  // namespace balance
