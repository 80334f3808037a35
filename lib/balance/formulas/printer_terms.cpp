// Numbers, symbols, waves and products of them.

#include "balance/base/elementary.hpp"
#include "balance/formulas/printer.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <tuple>

namespace balance::formulas {

namespace {

bool is_greek(const std::string& word) {
  for (const char* letter : {"alpha", "beta",   "gamma", "delta", "theta", "phi",     "psi", "mu",   "rho", "tau",
                             "omega", "lambda", "eta",   "kappa", "sigma", "epsilon", "xi",  "zeta", "nu",  "chi"})
    if (word == letter) return true;
  return false;
}

/// A letter of the field's with letters that say of what, as formulas name numbers: `lg`, `Jxy`, the `xB` of a point B.
bool is_quantity(const std::string& head) {
  if (head.size() < 2) return false;
  if (std::string("xyz").find(head[0]) != std::string::npos && std::isupper(static_cast<unsigned char>(head[1])) != 0)
    return true;
  const std::string behind = head[0] == 'J'                                           ? "xyzat"
                             : std::string("Img").find(head[0]) != std::string::npos  ? "xyzt"
                             : std::string("lxyz").find(head[0]) != std::string::npos ? "g"
                                                                                      : "";
  return head.size() <= 3 && head.find_first_not_of(behind, 1) == std::string::npos;
}

/// Place in a product: g, inertias, lengths, the rest.
int order_of(SymbolKind kind) {
  switch (kind) {
    case SymbolKind::gravity: return 0;
    case SymbolKind::inertia:
    case SymbolKind::first_moment:
    case SymbolKind::mass:
    case SymbolKind::stiffness: return 1;
    case SymbolKind::length:
    case SymbolKind::slide: return 2;
    case SymbolKind::com_coordinate: return 3;
    case SymbolKind::ratio:
    case SymbolKind::dimensionless: return 4;
    case SymbolKind::alias: return 5;
    case SymbolKind::rate: return 6;
    case SymbolKind::acceleration: return 7;
  }
  return 8;
}

/// As if exponents of all symbols stood in a row: the first that differs, higher ones first.
bool is_before(const Monomial& a, const Monomial& b) {
  for (int i = 0;; ++i) {
    const bool more_a = i < a.size(), more_b = i < b.size();
    if (!more_a && !more_b) return false;
    const int next_a = more_a ? a.symbol(i) : Ring::max_symbols, next_b = more_b ? b.symbol(i) : Ring::max_symbols;
    const int left = next_a <= next_b ? a.exponent(i) : 0, right = next_b <= next_a ? b.exponent(i) : 0;
    if (left != right) return left > right;
  }
}

}  // namespace

std::string latex_name(const std::string& name) {
  std::string head, tail;
  const std::size_t digit = name.find_first_of("0123456789_");
  head = name.substr(0, digit);
  tail = digit == std::string::npos ? "" : name.substr(digit);
  if (is_quantity(head)) tail = head.substr(1) + tail, head.resize(1);
  if (is_greek(head))
    head = "\\" + head;
  else if (head.size() > 1)
    head = "\\mathrm{" + head + "}";
  std::string below;
  for (const char c : tail)
    if (c != '_') below += c;
  if (tail.ends_with("_")) below += '\'';
  const bool words = std::any_of(below.begin(), below.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
  if (below.empty()) return head;
  return head + (words && below.size() > 2 ? "_{\\mathrm{" + below + "}}" : "_{" + below + "}");
}

std::string FormulaPrinter::symbol_text(int symbol) const {
  const std::string& name = ring_->symbol(symbol).name;
  const bool is_text = scratch_.contains(name);
  return style_ == PrintStyle::latex && !is_text ? latex_name(name) : name;
}

std::string FormulaPrinter::angle_text(int angle) const {
  const std::string& name = ring_->angle(angle).name;
  return style_ == PrintStyle::latex ? latex_name(name) : name;
}

std::string FormulaPrinter::number(Rational value) const {
  const std::string above = std::to_string(value.numerator());
  if (value.is_integer()) return above;
  const std::string below = std::to_string(value.denominator());
  return style_ == PrintStyle::latex ? "\\tfrac{" + above + "}{" + below + "}" : above + "/" + below;
}

std::string FormulaPrinter::factor(int symbol, int exponent) const {
  const std::string text = symbol_text(symbol);
  if (exponent == 1) return text;
  const std::string power = std::to_string(exponent);
  // The name of a symbol that stands for a sine holds brackets; LaTeX wants braces around what has an index of its own.
  return style_ == PrintStyle::latex ? "{" + text + "}^{" + power + "}" : text + "^" + power;
}

std::string FormulaPrinter::format_square(const std::string& text) const {
  return style_ == PrintStyle::latex ? "{" + text + "}^{2}" : text + "^2";
}

std::string FormulaPrinter::circular(const CircularFunction& function, int divided_by) const {
  std::string argument;
  for (const auto& [angle, whole] : function.argument) {
    const int multiple = whole / divided_by;
    argument += argument.empty() ? (multiple < 0 ? "-" : "") : (multiple < 0 ? " - " : " + ");
    if (std::abs(multiple) != 1) argument += std::to_string(std::abs(multiple)) + " ";
    argument += angle_text(angle);
  }
  const std::string name = function.is_sine ? "sin" : "cos";
  return (style_ == PrintStyle::latex ? "\\" + name : name) + "(" + argument + ")";
}

std::string FormulaPrinter::format_trigonometric(TrigonometricId wave) const {
  std::string text;
  for (const CircularFunction& function : ring_->wave(wave)) text += (text.empty() ? "" : " ") + circular(function);
  return text;
}

/// Its size counts symbols, functions and numbers; the sign is left out.
FormulaPrinter::Printed FormulaPrinter::term(const Monomial& monomial, Rational coefficient,
                                             TrigonometricId wave) const {
  Printed above, below;
  std::vector<std::pair<int, int>> order;
  for (int k = 0; k < monomial.size(); ++k) order.emplace_back(order_of(ring_->symbol(monomial.symbol(k)).kind), k);
  std::sort(order.begin(), order.end());
  const auto put = [](Printed& to, const std::string& text) {
    to.text += (to.text.empty() ? "" : " ") + text;
    ++to.size;
  };
  for (const auto& [rank, k] : order) {
    const int exponent = monomial.exponent(k);
    put(exponent > 0 ? above : below, factor(monomial.symbol(k), std::abs(exponent)));
  }
  if (wave != 0) put(above, format_trigonometric(wave));
  const Rational size = abs(coefficient);
  if (!(size == Rational(1)) || above.text.empty()) {
    above.text = number(size) + (above.text.empty() ? "" : " " + above.text);
    ++above.size;
  }
  return below.text.empty() ? above : divided(above, below);
}

FormulaPrinter::Printed FormulaPrinter::bracketed(Printed inner) const {
  if (!inner.is_sum) return inner;
  const bool latex = style_ == PrintStyle::latex;
  inner.text = (latex ? "\\left(" : "(") + inner.text + (latex ? "\\right)" : ")");
  inner.is_sum = false;
  return inner;
}

FormulaPrinter::Printed FormulaPrinter::divided(Printed above, const Printed& below) const {
  const bool many = below.size > 1 || below.is_sum || below.text.find(' ') != std::string::npos;
  if (style_ == PrintStyle::latex)
    above.text = "\\frac{" + above.text + "}{" + below.text + "}";
  else
    above.text = bracketed(above).text + (many ? "/(" : "/") + below.text + (many ? ")" : "");
  above.size += below.size;
  above.is_sum = false;
  return above;
}

FormulaPrinter::Printed FormulaPrinter::join_terms(const std::vector<std::pair<bool, Printed>>& parts) const {
  Printed sum;
  for (const auto& [negative, part] : parts) {
    const std::string text = negative ? bracketed(part).text : part.text;
    const bool minus = negative || text.starts_with('-');  // of a sum only the first term's
    sum.text += sum.text.empty() ? (minus ? "-" : "") : (minus ? " - " : " + ");
    sum.text += text.substr(!negative && minus ? 1 : 0);
    sum.size += part.size;
  }
  sum.is_sum = parts.size() > 1 || (!parts.empty() && (parts[0].first || parts[0].second.is_sum));
  return sum;
}

/// Fractions last, inertias before masses, then by number.
std::vector<Term> FormulaPrinter::sorted(const Polynomial& p) const {
  const auto key = [this](const Term& term) {
    int fractions = 0, rank = 99, lead = 0;
    for (int k = 0; k < term.monomial.size(); ++k) {
      const int symbol = term.monomial.symbol(k);
      if (term.monomial.exponent(k) < 0) ++fractions;
      const auto kind = ring_->symbol(symbol).kind;
      if (rank == 99 && term.monomial.exponent(k) > 0 && is_inertial(kind))
        rank = static_cast<int>(kind), lead = symbol;
    }
    return std::tuple(fractions, rank, lead);
  };
  struct Keyed {
    std::tuple<int, int, int> key;
    const Term* term;
  };
  std::vector<Keyed> order;
  for (const Term& term : p.terms()) order.push_back({key(term), &term});
  std::sort(order.begin(), order.end(), [this](const Keyed& a, const Keyed& b) {
    if (a.key != b.key) return a.key < b.key;
    if (is_before(a.term->monomial, b.term->monomial)) return true;
    if (is_before(b.term->monomial, a.term->monomial)) return false;
    return ring_->wave(a.term->wave) < ring_->wave(b.term->wave);
  });
  std::vector<Term> terms;
  for (const Keyed& keyed : order) terms.push_back(*keyed.term);
  return terms;
}

std::string FormulaPrinter::print_numbers(const Polynomial& p) const {
  std::map<std::pair<Monomial, TrigonometricId>, double> coefficients;
  for (const Term& term : p.terms()) {
    double value = term.coefficient.value();
    Monomial kept;
    for (int k = 0; k < term.monomial.size(); ++k) {
      const Symbol& symbol = ring_->symbol(term.monomial.symbol(k));
      if (symbol.kind >= SymbolKind::slide)
        kept.append(term.monomial.symbol(k), term.monomial.exponent(k));
      else
        value *= elementary::pow(symbol.value, term.monomial.exponent(k));
    }
    coefficients[{kept, term.wave}] += value;
  }
  std::string text;
  for (const auto& [key, value] : coefficients) {
    char digits[40];
    const double size = std::fabs(value);
    std::snprintf(digits, sizeof digits, "%.15g", size);
    if (value == 0) continue;
    const Printed rest = term(key.first, 1, key.second);
    text += text.empty() ? (value < 0 ? "-" : "") : (value < 0 ? " - " : " + ");
    text += digits;
    if (!(key.first.is_one() && key.second == 0))
      text += (rest.text.starts_with("1/") ? " (" + rest.text + ")" : " " + rest.text);
  }
  return text.empty() ? "0" : text;
}

}  // namespace balance::formulas
