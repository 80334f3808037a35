#include "balance/synthesis/formulas/formula_printer.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <tuple>

namespace balance::formulas {

namespace {

constexpr int max_nesting_depth = 7;

Polynomial divided_by(const Polynomial& p, const Term& common) {
  std::vector<Term> terms;
  for (const Term& term : p.terms())
    terms.push_back(
        {term.monomial / common.monomial, common.wave != 0 ? 0 : term.wave, term.coefficient / common.coefficient});
  return Polynomial::of_terms(p.ring(), std::move(terms));
}

Monomial positive_part(const Monomial& m) {
  return m.select([](int, int exponent) { return exponent > 0; });
}
Monomial negative_part(const Monomial& m) {
  return m.select([](int, int exponent) { return exponent < 0; });
}

/// What all terms share: powers of one sign, the wave, and the size of their numbers if that is one.
Term content_of(const Polynomial& p) {
  Term common = p.terms()[0];
  common.coefficient = abs(common.coefficient);
  for (const Term& term : p.terms()) {
    Monomial shared;
    for (int k = 0; k < common.monomial.size(); ++k) {
      const int a = common.monomial.exponent(k), b = term.monomial.exponent_of(common.monomial.symbol(k));
      if (a > 0 && b > 0) shared.append(common.monomial.symbol(k), std::min(a, b));
      if (a < 0 && b < 0) shared.append(common.monomial.symbol(k), std::max(a, b));
    }
    common.monomial = shared;
    if (term.wave != common.wave) common.wave = 0;
    if (!(abs(term.coefficient) == common.coefficient)) common.coefficient = Rational(0);
  }
  for (const Term& term : p.terms())
    if (term.wave != common.wave) common.wave = 0;
  if (common.coefficient.sign() == 0) common.coefficient = Rational(1);
  return common;
}

/// The least size of a factor, if that is below one and all others are multiples of it, else zero.
Rational smallest_common_factor(const Polynomial& p) {
  Rational least = abs(p.terms()[0].coefficient);
  for (const Term& term : p.terms())
    if (abs(term.coefficient) < least) least = abs(term.coefficient);
  bool whole = least < Rational(1);
  for (const Term& term : p.terms()) whole = whole && (term.coefficient / least).is_integer();
  return whole ? least : Rational();
}

}  // namespace

std::string FormulaPrinter::print(const Polynomial& p) {
  const int count = static_cast<int>(ring_->symbols().size());
  std::string text = format(p, 0).text;
  ring_->truncate_symbols(count);
  scratch_.clear();
  return text;
}

FormulaPrinter::Printed FormulaPrinter::format(const Polynomial& p, int depth) {
  if (p.is_zero()) return {"0", 1, false};
  if (p.size() == 1) {
    const Term& only = p.terms()[0];
    Printed printed = term(only.monomial, only.coefficient, only.wave);
    if (only.coefficient.sign() < 0) printed.text.insert(0, "-"), printed.is_sum = true;
    return printed;
  }
  if (auto taken = factor_out_number(p, depth)) return *taken;
  if (auto taken = factor_out_content(p, depth)) return *taken;
  return format_sum(p, depth);
}

/// Half of everything, where that is shorter.
std::optional<FormulaPrinter::Printed> FormulaPrinter::factor_out_number(const Polynomial& p, int depth) {
  if (number_is_out_) return std::nullopt;
  const Term common = content_of(p);
  Rational least = abs(p.terms()[0].coefficient);
  for (const Term& term : p.terms())
    if (abs(term.coefficient) < least) least = abs(term.coefficient);
  bool whole = least < Rational(1) && common.monomial.is_one() && common.wave == 0 && common.coefficient == Rational(1);
  for (const Term& term : p.terms()) whole = whole && (term.coefficient / least).is_integer();
  if (!whole) return std::nullopt;
  const bool negative = sorted(p)[0].coefficient.sign() < 0;
  number_is_out_ = true;
  const Printed kept = format(p, depth);
  Printed taken = bracketed(format(Polynomial(Rational(negative ? -1 : 1) / least) * p, depth + 1));
  number_is_out_ = false;
  taken.text = (negative ? "-" : "") + number(least) + " " + taken.text;
  taken.size += 1;
  taken.is_sum = negative;
  return taken.size < kept.size ? taken : kept;
}

std::optional<FormulaPrinter::Printed> FormulaPrinter::factor_out_content(const Polynomial& p, int depth) {
  Term common = content_of(p);
  if (common.monomial.is_one() && common.wave == 0 && common.coefficient == Rational(1)) return std::nullopt;
  if (const Rational least = smallest_common_factor(p); least.sign() != 0 && common.coefficient == Rational(1))
    common.coefficient = least;
  Polynomial rest = divided_by(p, common);
  const bool negative = sorted(p)[0].coefficient.sign() < 0;
  if (negative) rest = -rest;
  const Monomial above = positive_part(common.monomial), below = negative_part(common.monomial).inverse();
  Printed printed = bracketed(format(rest, depth + 1));
  if (!above.is_one() || !(common.coefficient == Rational(1))) {
    const Printed head = term(above, common.coefficient, 0);
    printed.text = head.text + " " + printed.text;
    printed.size += head.size;
  }
  if (common.wave != 0) {
    printed.text += " " + format_trigonometric(common.wave);
    ++printed.size;
  }
  if (!below.is_one()) printed = divided(printed, term(below, 1, 0));
  if (negative) printed.text.insert(0, "-"), printed.is_sum = true;
  return printed;
}

/// What all terms of the root share stands before the brackets, squared itself.
FormulaPrinter::Printed FormulaPrinter::square_of(const Polynomial& root, int depth) {
  const Term common = content_of(root);
  const bool out = common.wave == 0 && negative_part(common.monomial).is_one();
  Printed printed = format(out ? divided_by(root, common) : root, depth + 1);
  printed.is_sum = true;  // a product needs brackets as well
  printed = bracketed(printed);
  printed.text = format_square(printed.text);
  if (!out || (common.monomial.is_one() && common.coefficient == Rational(1))) return printed;
  const Printed head = term(common.monomial * common.monomial, common.coefficient * common.coefficient, 0);
  printed.text = head.text + " " + printed.text;
  printed.size += head.size;
  return printed;
}

FormulaPrinter::Printed FormulaPrinter::format_sum(const Polynomial& p, int depth) {
  if (const auto root = square_root(p)) return square_of(*root, depth);
  const auto all = [](const Term& term) { return Term{term.monomial, term.wave, 1}; };
  if (depth > max_nesting_depth) return format_grouped(p, all, depth);
  const auto& terms = p.terms();
  if (std::all_of(terms.begin(), terms.end(), [](const Term& term) { return term.wave == 0; }))
    return format_without_trigonometric(p, depth);
  Printed printed = format_grouped(
      p,
      [](const Term& term) {
        return Term{{}, term.wave, 1};
      },
      depth);
  if (!squares_) return printed;
  if (auto squares = format_squares(p); squares && squares->size < printed.size) return *squares;
  return printed;
}

FormulaPrinter::Printed FormulaPrinter::format_without_trigonometric(const Polynomial& p, int depth) {
  const auto kind_is = [this](bool inertial) {
    return [this, inertial](const Term& term) {
      return Term{term.monomial.select([&](int s, int) { return is_inertial(ring_->symbol(s).kind) == inertial; }), 0,
                  1};
    };
  };
  const auto fraction = [](const Term& term) { return Term{negative_part(term.monomial), 0, 1}; };
  std::vector<Part> ways;
  bool fractions = false;
  for (const Term& term : p.terms()) fractions = fractions || !negative_part(term.monomial).is_one();
  if (fractions) ways.emplace_back(fraction);
  ways.emplace_back(kind_is(true));
  ways.emplace_back(kind_is(false));
  // Horner: the length that most terms share, to the power that all of those have
  std::map<int, std::pair<int, int>> shared;  // symbol: terms, least power
  for (const Term& term : p.terms())
    for (int k = 0; k < term.monomial.size(); ++k)
      if (term.monomial.exponent(k) > 0 && !is_inertial(ring_->symbol(term.monomial.symbol(k)).kind)) {
        auto& [count, least] = shared.try_emplace(term.monomial.symbol(k), 0, 99).first->second;
        ++count, least = std::min(least, term.monomial.exponent(k));
      }
  int most = -1;
  for (const auto& [symbol, found] : shared)
    if (found.first > 1 && (most < 0 || found.first > shared[most].first)) most = symbol;
  if (most >= 0)
    ways.emplace_back([most, least = shared[most].second](const Term& term) {
      return Term{term.monomial.exponent_of(most) > 0 ? Monomial(most, least) : Monomial(), 0, 1};
    });
  std::optional<Printed> best;
  for (const Part& way : ways) {
    std::vector<Monomial> keys;
    for (const Term& term : p.terms()) keys.push_back(way(term).monomial);
    std::sort(keys.begin(), keys.end());
    const auto count = static_cast<std::size_t>(std::unique(keys.begin(), keys.end()) - keys.begin());
    if (count == 1 || count == p.size()) continue;
    Printed printed = format_grouped(p, way, depth);
    if (!best || printed.size < best->size) best = std::move(printed);
    if (fractions && &way == &ways[0]) break;  // fractions are always kept apart
  }
  Printed plain = format_grouped(
      p,
      [](const Term& term) {
        return Term{term.monomial, 0, 1};
      },
      depth);
  return best && best->size <= plain.size ? *best : plain;
}

/// Terms by a part of them; every group prints as part · (rest).
FormulaPrinter::Printed FormulaPrinter::format_grouped(const Polynomial& p, const Part& part, int depth) {
  std::vector<std::pair<Term, std::vector<Term>>> groups;
  std::map<std::pair<Monomial, TrigonometricId>, std::size_t> index;
  for (const Term& term : sorted(p)) {
    const Term key = part(term);
    const auto [at, fresh] = index.try_emplace({key.monomial, key.wave}, groups.size());
    if (fresh) groups.push_back({key, {}});
    groups[at->second].second.push_back(
        {term.monomial / key.monomial, key.wave != 0 ? 0 : term.wave, term.coefficient});
  }
  std::vector<std::pair<bool, Printed>> parts;
  for (auto& [key, terms] : groups) {
    bool negative = false;
    Printed printed = group(key, Polynomial::of_terms(ring_, std::move(terms)), depth, negative);
    parts.emplace_back(negative, std::move(printed));
  }
  return join_terms(parts);
}

FormulaPrinter::Printed FormulaPrinter::group(const Term& key, const Polynomial& rest, int depth, bool& negative) {
  if (rest.size() == 1) {
    const Term& only = rest.terms()[0];
    negative = only.coefficient.sign() < 0;
    return term(key.monomial * only.monomial, only.coefficient, key.wave != 0 ? key.wave : only.wave);
  }
  const bool plain = key.monomial.is_one() && key.wave == 0;
  negative = !plain && sorted(rest)[0].coefficient.sign() < 0;
  const Printed inner = format(negative ? -rest : rest, depth + 1);
  if (plain) return inner;
  const Monomial above = positive_part(key.monomial), below = negative_part(key.monomial).inverse();
  Printed printed = bracketed(inner);
  if (!above.is_one()) {
    const Printed head = term(above, 1, 0);
    printed.text = head.text + " " + printed.text;
    printed.size += head.size;
  }
  if (key.wave != 0) {
    printed.text += " " + format_trigonometric(key.wave);
    ++printed.size;
  }
  return below.is_one() ? printed : divided(printed, term(below, 1, 0));
}

std::string FormulaPrinter::print_ratio(const Polynomial& numerator, const Polynomial& denominator) {
  Polynomial above = numerator, below = denominator;
  std::string whole;
  for (const int n : {1, -1, 2, -2}) {
    const Polynomial rest = above - Polynomial(n) * below;
    if (rest.size() + below.size() != above.size()) continue;
    whole = std::to_string(n);
    above = rest;
    break;
  }
  if (above.is_zero()) return whole.empty() ? "0" : whole;
  const Term a = content_of(above), b = content_of(below);
  const Monomial shared = a.monomial.select([&](int s, int e) { return e > 0 && b.monomial.exponent_of(s) > 0; });
  Monomial common;
  for (int k = 0; k < shared.size(); ++k)
    common.append(shared.symbol(k), std::min(shared.exponent(k), b.monomial.exponent_of(shared.symbol(k))));
  above = divided_by(above, {common, 0, 1}), below = divided_by(below, {common, 0, 1});
  const bool flipped = sorted(below)[0].coefficient.sign() < 0;
  if (flipped) above = -above, below = -below;
  const bool negative = sorted(above)[0].coefficient.sign() < 0;
  const Printed fraction = divided(format(negative ? -above : above, 1), format(below, 1));
  ring_->truncate_symbols(static_cast<int>(ring_->symbols().size() - scratch_.size()));
  scratch_.clear();
  if (whole.empty()) return (negative ? "-" : "") + fraction.text;
  return whole + (negative ? " - " : " + ") + fraction.text;
}

// Numbers, symbols, waves and products of them.

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
bool is_printed_before(const Monomial& a, const Monomial& b) {
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
    if (is_printed_before(a.term->monomial, b.term->monomial)) return true;
    if (is_printed_before(b.term->monomial, a.term->monomial)) return false;
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
