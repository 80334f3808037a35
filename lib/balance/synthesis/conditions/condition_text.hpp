#pragma once
/// Conditions as LaTeX. Needs amsmath.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"

#include <string>
#include <vector>

namespace balance::conditions {

/// "m_{\text{link2}}", "(m x)_{\text{link1}}", "I_{xx,\text{link1}}".
std::string parameter_latex(const dynamics::Parameter& parameter);

/// A symbol's label in LaTeX: "l_{1}", "\gamma_{3}", "x_{\text{link1.B}}".
std::string symbol_latex(const std::string& label);

/// "\frac{l_{1}^{2}}{2\, l_{2}}", with its sign.
std::string formula_latex(const CoefficientFormula& formula, const std::vector<GeometricSymbol>& symbols);

/// "(m x)_{\text{link1}} + l_{1}\, m_{\text{link2}} = 0", for math mode.
std::string condition_latex(const Conditions& conditions, int row, const ConditionNames& names = {});

/// All conditions, one per line, in an align* environment; long ones take several lines. Ends with a line feed.
std::string conditions_latex(const Conditions& conditions, const ConditionNames& names = {});

// Linear combinations of parameters as text.

/// "link1.mx + 0.5 link2.m - 2 link3.J", without coefficients below round-off; "0" if none remain.
/// @param coefficients one per parameter
std::string linear_combination_text(const std::vector<dynamics::Parameter>& parameters, const VectorX& coefficients);

}  // namespace balance::conditions
