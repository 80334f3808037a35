#include "balance/synthesis/conditions/condition_text.hpp"

#include "balance/foundation/base/latex_lines.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>

namespace balance::conditions {

namespace {

constexpr std::array greek_names = {"alpha", "beta",  "gamma", "delta",  "epsilon", "zeta", "eta",
                                    "theta", "iota",  "kappa", "lambda", "mu",      "nu",   "xi",
                                    "pi",    "rho",   "sigma", "tau",    "phi",     "chi",  "psi",
                                    "omega", "Gamma", "Delta", "Theta",  "Lambda",  "Omega"};
constexpr double indent_width = 3;  ///< of continued lines, in letters

/// A name in upright type.
std::string upright_latex(const std::string& name) {
  std::string text;
  for (const char c : name) {
    switch (c) {
      case '\\': text += "\\textbackslash{}"; break;
      case '^': text += "\\textasciicircum{}"; break;
      case '~': text += "\\textasciitilde{}"; break;
      case '{':
      case '}':
      case '$':
      case '&':
      case '#':
      case '_':
      case '%': text += '\\'; [[fallthrough]];
      default: text += c;
    }
  }
  return "\\text{" + text + "}";
}

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// A word in italic type: a Greek letter, a single letter or a name.
std::string italic_latex(const std::string& word) {
  if (std::find(greek_names.begin(), greek_names.end(), word) != greek_names.end()) return "\\" + word;
  return word.size() == 1 && std::isalnum(static_cast<unsigned char>(word[0])) != 0
             ? word
             : "\\mathit{" + upright_latex(word).substr(6);
}

/// "l1", "l_1", "l_max": a word and its subscript.
std::string identifier_latex(const std::string& name) {
  const std::size_t underscore = name.find('_');
  if (underscore != std::string::npos && underscore > 0 && underscore + 1 < name.size()) {
    const std::string index = name.substr(underscore + 1);
    const bool is_numeric = std::all_of(index.begin(), index.end(), is_digit);
    return italic_latex(name.substr(0, underscore)) + "_{" + (is_numeric ? index : upright_latex(index)) + "}";
  }
  std::size_t digits = name.size();
  while (digits > 0 && is_digit(name[digits - 1])) --digits;
  if (digits == 0) return upright_latex(name);
  return digits == name.size() ? italic_latex(name)
                               : italic_latex(name.substr(0, digits)) + "_{" + name.substr(digits) + "}";
}

std::string monomial_size(const RationalMonomial& m, const std::vector<GeometricSymbol>& symbols) {
  std::vector<std::string> numerator_factors, denominator_factors;
  for (const SymbolPower& p : m.powers) {
    std::string text = symbol_latex(symbols.at(static_cast<std::size_t>(p.symbol)).label);
    if (std::abs(p.exponent) != 1) text += fmt::format("^{{{}}}", std::abs(p.exponent));
    (p.exponent > 0 ? numerator_factors : denominator_factors).push_back(text);
  }
  const int numerator = std::abs(m.numerator);
  if (numerator != 1 || (numerator_factors.empty() && (m.denominator != 1 || !denominator_factors.empty())))
    numerator_factors.insert(numerator_factors.begin(), std::to_string(numerator));
  if (m.denominator != 1) denominator_factors.insert(denominator_factors.begin(), std::to_string(m.denominator));
  const std::string numerator_text = fmt::format("{}", fmt::join(numerator_factors, "\\, "));
  return denominator_factors.empty()
             ? numerator_text
             : fmt::format("\\frac{{{}}}{{{}}}", numerator_text, fmt::join(denominator_factors, "\\, "));
}

std::string sum_latex(const std::vector<RationalMonomial>& sum, bool is_negated,
                      const std::vector<GeometricSymbol>& symbols) {
  std::string text;
  for (const RationalMonomial& term : sum) {
    const bool negative = (term.numerator < 0) != is_negated;
    const std::string size = monomial_size(term, symbols);
    text += text.empty() ? (negative ? "-" : "") : (negative ? " - " : " + ");
    text += size.empty() ? "1" : size;
  }
  return "\\left(" + text + "\\right)";
}

struct LatexCoefficient {
  bool negative = false;
  std::string size;  ///< empty for 1
};

LatexCoefficient number_latex(double value) {
  std::string number = fmt::format("{:.6g}", std::abs(value));
  if (const std::size_t e = number.find('e'); e != std::string::npos)
    number = fmt::format("{} \\cdot 10^{{{}}}", number.substr(0, e), std::atoi(number.c_str() + e + 1));
  return {value < 0, number == "1" ? "" : number};
}

std::string trigonometric_latex(const TrigonometricFactor& trig, const std::vector<GeometricSymbol>& symbols) {
  std::string text;
  for (const SymbolPower& angle : trig.angles) {
    text += text.empty() ? (angle.exponent < 0 ? "-" : "") : (angle.exponent < 0 ? " - " : " + ");
    if (std::abs(angle.exponent) != 1) text += std::to_string(std::abs(angle.exponent)) + "\\, ";
    text += symbol_latex(symbols.at(static_cast<std::size_t>(angle.symbol)).label);
  }
  return (trig.is_sine ? "\\sin\\left(" : "\\cos\\left(") + text + "\\right)";
}

LatexCoefficient coefficient_latex(const CoefficientFormula& formula, const std::vector<GeometricSymbol>& symbols) {
  std::string size = monomial_size(formula.factor, symbols);
  const bool negative = formula.factor.numerator < 0;
  if (formula.wave) size += (size.empty() ? "" : "\\, ") + trigonometric_latex(*formula.wave, symbols);
  if (formula.sum.empty()) return {negative, size};
  const bool is_negated = formula.sum.front().numerator < 0;
  if (!size.empty()) size += "\\, ";
  return {negative != is_negated, size + sum_latex(formula.sum, is_negated, symbols)};
}

/// Terms of the columns [first, last) with their signs; the first one has a sign only if it is negative.
std::vector<std::string> terms_latex(const Conditions& conditions, int row, const ConditionNames& names,
                                     Eigen::Index first, Eigen::Index last, bool is_negated) {
  const double largest = numerics::max_abs(conditions.matrix.row(row));
  std::vector<std::string> terms;
  for (Eigen::Index p = first; p < last; ++p) {
    const double value = conditions.matrix(row, p);
    if (std::abs(value) <= 1e-12 * largest) continue;
    const CoefficientFormula* formula = names.find(row, static_cast<int>(p));
    const LatexCoefficient c = formula != nullptr ? coefficient_latex(*formula, names.symbols) : number_latex(value);
    const bool minus = c.negative != is_negated;
    const char* sign = terms.empty() ? (minus ? "-" : "") : (minus ? "- " : "+ ");
    terms.push_back(sign + (c.size.empty() ? "" : c.size + "\\, ") +
                    parameter_latex(conditions.parameters[static_cast<std::size_t>(p)]));
  }
  return terms;
}

/// The left-hand side, and the right-hand side with the known terms.
struct EquationSides {
  std::vector<std::string> left;
  std::string right;
};

EquationSides split_sides(const Conditions& conditions, int row, const ConditionNames& names) {
  const Eigen::Index parameter_count = conditions.parameter_columns(),
                     term_count = static_cast<Eigen::Index>(conditions.parameters.size());
  EquationSides sides{terms_latex(conditions, row, names, 0, parameter_count, false), ""};
  const bool has_no_parameters = sides.left.empty();
  const auto known_terms = terms_latex(conditions, row, names, parameter_count, term_count, !has_no_parameters);
  if (has_no_parameters)
    sides.left = known_terms.empty() ? std::vector<std::string>{"0"} : known_terms;
  else
    sides.right = fmt::format("{}", fmt::join(known_terms, " "));
  if (sides.right.empty()) sides.right = "0";
  return sides;
}

}  // namespace

std::string parameter_latex(const dynamics::Parameter& p) {
  const std::string owner = upright_latex(p.owner), &s = p.symbol;
  if (p.owner_kind == dynamics::ParameterOwner::load) {
    const bool couple = p.kind == dynamics::ParameterKind::couple;
    std::string axis = s.substr(1, s.find('(') == std::string::npos ? s.npos : s.find('(') - 1);
    if (!axis.empty()) axis += ",";
    return fmt::format("{}_{{{}{}}}{}", couple ? "M" : "F", axis, owner,
                       s.find('(') == std::string::npos ? ""
                       : is_load_change(p)
                           ? "(t)"
                           : "(" + upright_latex(s.substr(s.find('(') + 1, s.size() - s.find('(') - 2)) + ")");
  }
  if (p.owner_kind == dynamics::ParameterOwner::force_element)
    return fmt::format("{}_{{{}}}", p.kind == dynamics::ParameterKind::viscous ? "d" : "F", owner);
  if (p.owner_kind == dynamics::ParameterOwner::friction)
    return fmt::format("{}{}_{{{}}}", p.kind == dynamics::ParameterKind::viscous ? "d" : "c",
                       s == coulomb_forward    ? "^{+}"
                       : s == coulomb_backward ? "^{-}"
                                               : "",
                       owner);
  if (s.size() == 2 && s[0] == 'm') return fmt::format("(m {})_{{{}}}", s[1], owner);
  if (s.size() == 3 && s[0] == 'I') return fmt::format("I_{{{},{}}}", s.substr(1), owner);
  if (s.size() >= 3 && s[0] == 'k') {
    std::string product = "k";
    for (std::size_t i = 1; i + 1 < s.size(); i += 2) product += fmt::format(" {}_{}", s[i], s[i + 1]);
    return fmt::format("({})_{{{}}}", product, owner);
  }
  return fmt::format("{}_{{{}}}", italic_latex(s), owner);
}

std::string symbol_latex(const std::string& label) {
  const std::size_t dot = label.rfind('.');
  if (dot == std::string::npos) return identifier_latex(label);
  return italic_latex(label.substr(dot + 1)) + "_{" + upright_latex(label.substr(0, dot)) + "}";
}

std::string formula_latex(const CoefficientFormula& formula, const std::vector<GeometricSymbol>& symbols) {
  const LatexCoefficient c = coefficient_latex(formula, symbols);
  return (c.negative ? "-" : "") + (c.size.empty() ? "1" : c.size);
}

std::string condition_latex(const Conditions& conditions, int row, const ConditionNames& names) {
  const EquationSides sides = split_sides(conditions, row, names);
  return fmt::format("{} = {}", fmt::join(sides.left, " "), sides.right);
}

std::string conditions_latex(const Conditions& conditions, const ConditionNames& names) {
  if (conditions.matrix.rows() == 0) return "% no conditions\n";
  std::string text = "\\begin{align*}\n";
  for (int row = 0; row < static_cast<int>(conditions.matrix.rows()); ++row) {
    text += row == 0 ? "  & " : " \\\\\n  & ";
    const std::vector<std::string> lines =
        break_latex(condition_latex(conditions, row, names), latex_line_width - indent_width);
    for (std::size_t i = 0; i < lines.size(); ++i) text += (i > 0 ? " \\\\\n  & \\quad {}" : "") + lines[i];
  }
  return text + "\n\\end{align*}\n";
}

namespace {

std::string power_text(const std::string& label, int exponent) {
  return exponent == 1 ? label : fmt::format("{}^{}", label, exponent);
}

/// "3 l1^2/(2 l2)" without its sign; "" for 1.
std::string monomial_text(const RationalMonomial& m, const std::vector<GeometricSymbol>& symbols) {
  const int numerator = std::abs(m.numerator);
  std::vector<std::string> numerator_factors, denominator_factors;
  for (const SymbolPower& p : m.powers) {
    const std::string& label = symbols.at(static_cast<std::size_t>(p.symbol)).label;
    (p.exponent > 0 ? numerator_factors : denominator_factors).push_back(power_text(label, std::abs(p.exponent)));
  }
  if (m.powers.empty() && m.denominator != 3)
    return m.denominator == 1 && numerator == 1 ? ""
                                                : fmt::format("{:g}", static_cast<double>(numerator) / m.denominator);
  if (numerator != 1 || numerator_factors.empty())
    numerator_factors.insert(numerator_factors.begin(), std::to_string(numerator));
  if (m.denominator != 1) denominator_factors.insert(denominator_factors.begin(), std::to_string(m.denominator));
  std::string text = fmt::format("{}", fmt::join(numerator_factors, " "));
  if (denominator_factors.size() == 1) text += "/" + denominator_factors.front();
  if (denominator_factors.size() > 1) text += fmt::format("/({})", fmt::join(denominator_factors, " "));
  return text;
}

std::string text_or_one(const std::string& text) { return text.empty() ? "1" : text; }

bool is_negative(const RationalMonomial& m) { return m.numerator < 0; }

std::string sum_text(const std::vector<RationalMonomial>& sum, const std::vector<GeometricSymbol>& symbols) {
  std::string text;
  for (const RationalMonomial& term : sum) {
    text += text.empty() ? (is_negative(term) ? "-" : "") : (is_negative(term) ? " - " : " + ");
    text += text_or_one(monomial_text(term, symbols));
  }
  return text;
}

/// "cos(link1.B.angle - 2 link2.C.angle)"
std::string trigonometric_text(const TrigonometricFactor& trig, const std::vector<GeometricSymbol>& symbols) {
  std::string text;
  for (const SymbolPower& angle : trig.angles) {
    text += text.empty() ? (angle.exponent < 0 ? "-" : "") : (angle.exponent < 0 ? " - " : " + ");
    if (std::abs(angle.exponent) != 1) text += std::to_string(std::abs(angle.exponent)) + " ";
    text += symbols.at(static_cast<std::size_t>(angle.symbol)).label;
  }
  return (trig.is_sine ? "sin(" : "cos(") + text + ")";
}

/// A coefficient in front of a parameter, its sign separate; in brackets if a quotient could absorb what follows.
struct Coefficient {
  bool negative = false;
  std::string size;  ///< empty for 1
};

Coefficient coefficient_text(const CoefficientFormula* formula, double value,
                             const std::vector<GeometricSymbol>& symbols) {
  if (formula == nullptr) {
    const std::string number = fmt::format("{:.6g}", std::abs(value));
    return {value < 0, number == "1" ? "" : number};
  }
  std::string size = monomial_text(formula->factor, symbols);
  if (size.find('/') != std::string::npos) size = "(" + size + ")";
  if (formula->wave) size += (size.empty() ? "" : " ") + trigonometric_text(*formula->wave, symbols);
  if (formula->sum.empty()) return {is_negative(formula->factor), size};
  // If both terms are negative, the sign moves in front of the sum.
  std::vector<RationalMonomial> sum = formula->sum;
  const bool is_negated = is_negative(sum.front());
  if (is_negated)
    for (RationalMonomial& term : sum) term.numerator = -term.numerator;
  return {is_negative(formula->factor) != is_negated,
          (size.empty() ? "" : size + " ") + "(" + sum_text(sum, symbols) + ")"};
}

}  // namespace

std::string formula_text(const CoefficientFormula& formula, const std::vector<GeometricSymbol>& symbols) {
  if (formula.wave) {
    const Coefficient coefficient = coefficient_text(&formula, 1, symbols);
    return (coefficient.negative ? "-" : "") + coefficient.size;
  }
  if (formula.sum.empty())
    return (is_negative(formula.factor) ? "-" : "") + text_or_one(monomial_text(formula.factor, symbols));
  const RationalMonomial& f = formula.factor;
  if (f.powers.empty() && f.numerator == 1 && f.denominator == 1) return sum_text(formula.sum, symbols);
  const Coefficient coefficient = coefficient_text(&formula, 1, symbols);
  return (coefficient.negative ? "-" : "") + coefficient.size;
}

namespace {

/// Terms of the columns [first, last) with their signs; "" if there are none.
std::string side_text(const Conditions& conditions, int row, const ConditionNames& names, Eigen::Index first,
                      Eigen::Index last, double sign) {
  const double largest = numerics::max_abs(conditions.matrix.row(row));
  std::string text;
  for (Eigen::Index p = first; p < last; ++p) {
    const double value = conditions.matrix(row, p);
    if (std::abs(value) <= 1e-12 * largest) continue;
    const Coefficient c = coefficient_text(names.find(row, static_cast<int>(p)), value, names.symbols);
    const bool minus = c.negative != (sign < 0);
    text += text.empty() ? (minus ? "-" : "") : (minus ? " - " : " + ");
    text += (c.size.empty() ? "" : c.size + " ") + conditions.parameters[static_cast<std::size_t>(p)].name;
  }
  return text;
}

}  // namespace

std::string condition_text(const Conditions& conditions, int row, const ConditionNames& names) {
  const Eigen::Index parameter_count = conditions.parameter_columns(),
                     term_count = static_cast<Eigen::Index>(conditions.parameters.size());
  const std::string left = side_text(conditions, row, names, 0, parameter_count, 1);
  const std::string known_terms = side_text(conditions, row, names, parameter_count, term_count, left.empty() ? 1 : -1);
  if (left.empty()) return (known_terms.empty() ? "0" : known_terms) + " = 0";
  return left + " = " + (known_terms.empty() ? "0" : known_terms);
}

std::string linear_combination_text(const std::vector<dynamics::Parameter>& parameters, const VectorX& coefficients) {
  const double largest = numerics::max_abs(coefficients);
  std::string text;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const double c = coefficients[static_cast<Eigen::Index>(p)], size = std::abs(c);
    if (size <= 1e-12 * largest) continue;
    text += text.empty() ? (c < 0 ? "-" : "") : (c < 0 ? " - " : " + ");
    const std::string number = fmt::format("{:.6g}", size);
    if (number != "1") text += number + " ";
    text += parameters[p].name;
  }
  return text.empty() ? "0" : text;
}

}  // namespace balance::conditions
