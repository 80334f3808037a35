#include "balance/conditions/naming.hpp"

#include "balance/base/extrema.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdlib>

namespace balance {

namespace {

std::string power_text(const std::string& label, int exponent) {
  return exponent == 1 ? label : fmt::format("{}^{}", label, exponent);
}

/// "3 l1^2/(2 l2)" without its sign; "" for one.
std::string monomial_text(const RationalMonomial& m, const std::vector<GeometricSymbol>& symbols) {
  const int numerator = std::abs(m.numerator);
  std::vector<std::string> above, below;
  for (const SymbolPower& p : m.powers) {
    const std::string& label = symbols.at(static_cast<std::size_t>(p.symbol)).label;
    (p.exponent > 0 ? above : below).push_back(power_text(label, std::abs(p.exponent)));
  }
  if (m.powers.empty() && m.denominator != 3)
    return m.denominator == 1 && numerator == 1 ? ""
                                                : fmt::format("{:g}", static_cast<double>(numerator) / m.denominator);
  if (numerator != 1 || above.empty()) above.insert(above.begin(), std::to_string(numerator));
  if (m.denominator != 1) below.insert(below.begin(), std::to_string(m.denominator));
  std::string text = fmt::format("{}", fmt::join(above, " "));
  if (below.size() == 1) text += "/" + below.front();
  if (below.size() > 1) text += fmt::format("/({})", fmt::join(below, " "));
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
std::string wave_text(const TrigonometricFactor& wave, const std::vector<GeometricSymbol>& symbols) {
  std::string text;
  for (const SymbolPower& angle : wave.angles) {
    text += text.empty() ? (angle.exponent < 0 ? "-" : "") : (angle.exponent < 0 ? " - " : " + ");
    if (std::abs(angle.exponent) != 1) text += std::to_string(std::abs(angle.exponent)) + " ";
    text += symbols.at(static_cast<std::size_t>(angle.symbol)).label;
  }
  return (wave.is_sine ? "sin(" : "cos(") + text + ")";
}

/// A coefficient in front of a parameter: sign apart, brackets where a quotient could swallow what follows.
struct Coefficient {
  bool negative = false;
  std::string size;  ///< empty for one
};

Coefficient coefficient_text(const CoefficientFormula* formula, double value,
                             const std::vector<GeometricSymbol>& symbols) {
  if (formula == nullptr) {
    const std::string number = fmt::format("{:.6g}", std::abs(value));
    return {value < 0, number == "1" ? "" : number};
  }
  std::string size = monomial_text(formula->factor, symbols);
  if (size.find('/') != std::string::npos) size = "(" + size + ")";
  if (formula->wave) size += (size.empty() ? "" : " ") + wave_text(*formula->wave, symbols);
  if (formula->sum.empty()) return {is_negative(formula->factor), size};
  // A sum whose both terms are negative shows its sign in front.
  std::vector<RationalMonomial> sum = formula->sum;
  const bool turned = is_negative(sum.front());
  if (turned)
    for (RationalMonomial& term : sum) term.numerator = -term.numerator;
  return {is_negative(formula->factor) != turned,
          (size.empty() ? "" : size + " ") + "(" + sum_text(sum, symbols) + ")"};
}

}  // namespace

std::string formula_text(const CoefficientFormula& formula, const std::vector<GeometricSymbol>& symbols) {
  if (formula.wave) {
    const Coefficient whole = coefficient_text(&formula, 1, symbols);
    return (whole.negative ? "-" : "") + whole.size;
  }
  if (formula.sum.empty())
    return (is_negative(formula.factor) ? "-" : "") + text_or_one(monomial_text(formula.factor, symbols));
  const RationalMonomial& f = formula.factor;
  if (f.powers.empty() && f.numerator == 1 && f.denominator == 1) return sum_text(formula.sum, symbols);
  const Coefficient whole = coefficient_text(&formula, 1, symbols);
  return (whole.negative ? "-" : "") + whole.size;
}

namespace {

/// Terms of the columns [first, last) with their signs; "" if there are none.
std::string side_text(const Conditions& conditions, int row, const ConditionNames& names, Eigen::Index first,
                      Eigen::Index last, double sign) {
  const double largest = max_abs(conditions.matrix.row(row));
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
  const Eigen::Index own = conditions.parameter_columns(),
                     all = static_cast<Eigen::Index>(conditions.parameters.size());
  const std::string left = side_text(conditions, row, names, 0, own, 1);
  const std::string known = side_text(conditions, row, names, own, all, left.empty() ? 1 : -1);
  if (left.empty()) return (known.empty() ? "0" : known) + " = 0";
  return left + " = " + (known.empty() ? "0" : known);
}

}  // namespace balance
