#include "balance/synthesis/formulas/formula_printer.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <tuple>

namespace balance::formulas {

namespace {

constexpr int max_nesting_depth = 7;

/// In letters of LaTeX: longer ones stand behind the fraction, where lines can be broken.
constexpr std::size_t max_latex_numerator = 120;

Polynomial divided_by(const Polynomial& p, const Term& common) {
  std::vector<Term> terms;
  for (const Term& term : p.terms())
    terms.push_back(
        {term.monomial / common.monomial, common.wave != 0 ? 0 : term.wave, term.coefficient / common.coefficient});
  return Polynomial::of_terms(p.ring(), std::move(terms));
}

Monomial negative_part(const Monomial& m) {
  return m.select([](int, int exponent) { return exponent < 0; });
}

/// What all terms have in common: powers of the same sign, the wave, and equal magnitudes of the coefficients.
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

/// The least number that makes all coefficients whole; 1 if it is too large for a fraction.
std::int64_t common_denominator(const Polynomial& p) {
  constexpr std::int64_t largest = 1'000'000;
  std::int64_t multiple = 1;
  for (const Term& term : p.terms()) {
    const std::int64_t denominator = term.coefficient.denominator();
    if (denominator > largest || (multiple = std::lcm(multiple, denominator)) > largest) return 1;
  }
  return multiple;
}

bool occurs_in(const Polynomial& p, int symbol) {
  return std::any_of(p.terms().begin(), p.terms().end(),
                     [symbol](const Term& term) { return term.monomial.exponent_of(symbol) != 0; });
}

/// The minimum magnitude of the coefficients, if it is below one and divides all others; otherwise zero.
Rational smallest_common_factor(const Polynomial& p) {
  Rational smallest = abs(p.terms()[0].coefficient);
  for (const Term& term : p.terms())
    if (abs(term.coefficient) < smallest) smallest = abs(term.coefficient);
  bool divides_all = smallest < Rational(1);
  for (const Term& term : p.terms()) divides_all = divides_all && (term.coefficient / smallest).is_integer();
  return divides_all ? smallest : Rational();
}

/// The positive powers that all terms of both share.
Monomial shared_powers(const Polynomial& p, const Polynomial& q) {
  const Monomial a = content_of(p).monomial, b = content_of(q).monomial;
  Monomial common;
  for (int k = 0; k < a.size(); ++k)
    if (const int exponent = std::min(a.exponent(k), b.exponent_of(a.symbol(k))); exponent > 0)
      common.append(a.symbol(k), exponent);
  return common;
}

}  // namespace

std::string FormulaPrinter::print(const Polynomial& p) {
  std::string text = format(p, 0).text;
  remove_placeholders();
  return text;
}

FormulaPrinter::Printed FormulaPrinter::format(const Polynomial& p, int depth) {
  if (p.is_zero()) return {"0", 1, false};
  if (p.size() == 1) {
    const Term& only = p.terms()[0];
    Printed printed = term(only.monomial, only.coefficient, only.wave);
    if (only.coefficient.sign() < 0) negate(printed);
    return printed;
  }
  for (const int symbol : collected_)
    if (occurs_in(p, symbol))
      return format_grouped(
          p,
          [symbol](const Term& term) {
            const int exponent = term.monomial.exponent_of(symbol);
            return Term{exponent != 0 ? Monomial(symbol, exponent) : Monomial(), 0, 1};
          },
          depth);
  if (auto factored = factor_out_number(p, depth)) return *factored;
  if (auto factored = factor_out_content(p, depth)) return *factored;
  return format_sum(p, depth);
}

/// Factors out the smallest coefficient, such as ½, if that is shorter.
std::optional<FormulaPrinter::Printed> FormulaPrinter::factor_out_number(const Polynomial& p, int depth) {
  if (is_number_factored_out_) return std::nullopt;
  const Term common = content_of(p);
  Rational smallest = abs(p.terms()[0].coefficient);
  for (const Term& term : p.terms())
    if (abs(term.coefficient) < smallest) smallest = abs(term.coefficient);
  bool divides_all =
      smallest < Rational(1) && common.monomial.is_one() && common.wave == 0 && common.coefficient == Rational(1);
  for (const Term& term : p.terms()) divides_all = divides_all && (term.coefficient / smallest).is_integer();
  if (!divides_all) return std::nullopt;
  const bool negative = sorted(p)[0].coefficient.sign() < 0;
  is_number_factored_out_ = true;
  const Printed unfactored = format(p, depth);
  Printed factored =
      product({}, smallest, 0, format(Polynomial(Rational(negative ? -1 : 1) / smallest) * p, depth + 1));
  is_number_factored_out_ = false;
  if (negative) negate(factored);
  return factored.size < unfactored.size ? factored : unfactored;
}

std::optional<FormulaPrinter::Printed> FormulaPrinter::factor_out_content(const Polynomial& p, int depth) {
  Term common = content_of(p);
  if (common.monomial.is_one() && common.wave == 0 && common.coefficient == Rational(1)) return std::nullopt;
  if (const Rational smallest = smallest_common_factor(p); smallest.sign() != 0 && common.coefficient == Rational(1))
    common.coefficient = smallest;
  Polynomial rest = divided_by(p, common);
  const bool negative = is_minus_taken_out(rest);
  if (negative) rest = -rest;
  Printed printed = product(common.monomial, common.coefficient, common.wave, format(rest, depth + 1));
  if (negative) negate(printed);
  return printed;
}

/// Of a difference the minuend comes first: a − b, not −(b − a); but of a length and a place of a centre of mass it is the
/// length, −(l − lg), as papers write it.
bool FormulaPrinter::is_minus_taken_out(const Polynomial& p) const {
  const auto is_negative = [](const Term& term) { return term.coefficient.sign() < 0; };
  const auto negatives = std::count_if(p.terms().begin(), p.terms().end(), is_negative);
  if (p.size() == 2 && negatives == 1) {
    const auto kind_of = [this](const Term& term) {
      return term.monomial.size() == 1 && term.wave == 0 ? ring_->symbol(term.monomial.symbol(0)).kind
                                                         : SymbolKind::alias;
    };
    const bool first = is_negative(p.terms()[0]);
    return kind_of(p.terms()[first ? 0 : 1]) == SymbolKind::length &&
           kind_of(p.terms()[first ? 1 : 0]) == SymbolKind::com_coordinate;
  }
  return negatives > 0 && is_negative(sorted(p)[0]);
}

/// The common factors of the root's terms are squared separately, in front of the brackets.
FormulaPrinter::Printed FormulaPrinter::square_of(const Polynomial& root, int depth) {
  const Term common = content_of(root);
  const bool factors_out = common.wave == 0 && negative_part(common.monomial).is_one();
  Printed printed = format(factors_out ? divided_by(root, common) : root, depth + 1);
  printed.is_sum = true;  // a product needs brackets, too
  printed = bracketed(printed);
  printed.text = format_square(printed.text);
  if (!factors_out || (common.monomial.is_one() && common.coefficient == Rational(1))) return printed;
  return product(common.monomial * common.monomial, common.coefficient * common.coefficient, 0, printed);
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
  if (!recognises_squares_) return printed;
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
  std::vector<Part> groupings;
  bool has_fractions = false;
  for (const Term& term : p.terms()) has_fractions = has_fractions || !negative_part(term.monomial).is_one();
  if (has_fractions) groupings.emplace_back(fraction);
  groupings.emplace_back(kind_is(true));
  groupings.emplace_back(kind_is(false));
  // Horner: the length that occurs in most terms, to the power that all of these contain
  std::map<int, std::pair<int, int>> occurrences;  // symbol: number of terms, minimum exponent
  for (const Term& term : p.terms())
    for (int k = 0; k < term.monomial.size(); ++k)
      if (term.monomial.exponent(k) > 0 && !is_inertial(ring_->symbol(term.monomial.symbol(k)).kind)) {
        auto& [count, min_exponent] = occurrences.try_emplace(term.monomial.symbol(k), 0, 99).first->second;
        ++count, min_exponent = std::min(min_exponent, term.monomial.exponent(k));
      }
  int horner_symbol = -1;
  for (const auto& [symbol, occurrence] : occurrences)
    if (occurrence.first > 1 && (horner_symbol < 0 || occurrence.first > occurrences[horner_symbol].first))
      horner_symbol = symbol;
  if (horner_symbol >= 0)
    groupings.emplace_back([horner_symbol, min_exponent = occurrences[horner_symbol].second](const Term& term) {
      return Term{term.monomial.exponent_of(horner_symbol) > 0 ? Monomial(horner_symbol, min_exponent) : Monomial(), 0,
                  1};
    });
  std::optional<Printed> best;
  for (const Part& grouping : groupings) {
    std::vector<Monomial> keys;
    for (const Term& term : p.terms()) keys.push_back(grouping(term).monomial);
    std::sort(keys.begin(), keys.end());
    const auto count = static_cast<std::size_t>(std::unique(keys.begin(), keys.end()) - keys.begin());
    if (count == 1 || count == p.size()) continue;
    Printed printed = format_grouped(p, grouping, depth);
    if (!best || printed.size < best->size) best = std::move(printed);
    if (has_fractions && &grouping == &groupings[0]) break;  // fractions are always kept separate
  }
  Printed ungrouped = format_grouped(
      p,
      [](const Term& term) {
        return Term{term.monomial, 0, 1};
      },
      depth);
  return best && best->size <= ungrouped.size ? *best : ungrouped;
}

/// Groups terms by a part of them; every group is printed as part · (rest).
FormulaPrinter::Printed FormulaPrinter::format_grouped(const Polynomial& p, const Part& part, int depth) {
  std::vector<std::pair<Term, std::vector<Term>>> groups;
  std::map<std::pair<Monomial, TrigonometricId>, std::size_t> index;
  for (const Term& term : sorted(p)) {
    const Term key = part(term);
    const auto [entry, is_new] = index.try_emplace({key.monomial, key.wave}, groups.size());
    if (is_new) groups.push_back({key, {}});
    groups[entry->second].second.push_back(
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
  if (key.monomial.is_one() && key.wave == 0) return format(rest, depth + 1);
  Term content = content_of(rest);
  negative = is_minus_taken_out(divided_by(rest, content));
  // a number that all terms share belongs in front of the key: 2 m (a + b), not m 2 (a + b)
  if (const Rational smallest = smallest_common_factor(rest);
      content.coefficient == Rational(1) && !(content.monomial.is_one() && content.wave == 0) && smallest.sign() != 0)
    content.coefficient = smallest;
  return product(key.monomial, content.coefficient, key.wave,
                 format(Polynomial(Rational(negative ? -1 : 1) / content.coefficient) * rest, depth + 1));
}

/// The parts of a ratio, whole + (or −) numerator / denominator.
struct FormulaPrinter::Ratio {
  int whole = 0;
  bool is_negative = false;
  Polynomial numerator, denominator;
};

FormulaPrinter::Ratio FormulaPrinter::simplify(Polynomial numerator, Polynomial denominator) const {
  Ratio ratio;
  for (const int n : {1, -1, 2, -2}) {
    const Polynomial rest = numerator - Polynomial(n) * denominator;
    if (rest.size() + denominator.size() != numerator.size()) continue;
    ratio.whole = n;
    numerator = rest;
    break;
  }
  if (numerator.is_zero()) return ratio;
  const Monomial common = shared_powers(numerator, denominator);
  const Rational fraction(1, std::lcm(common_denominator(numerator), common_denominator(denominator)));
  numerator = divided_by(numerator, {common, 0, fraction});
  denominator = divided_by(denominator, {common, 0, fraction});
  if (sorted(denominator)[0].coefficient.sign() < 0) numerator = -numerator, denominator = -denominator;
  ratio.is_negative = is_minus_taken_out(numerator);
  ratio.numerator = ratio.is_negative ? -numerator : numerator;
  ratio.denominator = denominator;
  return ratio;
}

std::string FormulaPrinter::print_ratio(const Polynomial& numerator, const Polynomial& denominator) {
  const Ratio ratio = simplify(numerator, denominator);
  if (ratio.numerator.is_zero()) return std::to_string(ratio.whole);
  const Printed fraction = divided(format(ratio.numerator, 1), format(ratio.denominator, 1));
  remove_placeholders();
  const std::string whole = ratio.whole == 0 ? "" : std::to_string(ratio.whole);
  if (ratio.is_negative) return whole.empty() ? "-" + fraction.text : whole + " - " + fraction.text;
  if (ratio.whole < 0) return fraction.text + " - " + whole.substr(1);
  return whole.empty() ? fraction.text : whole + " + " + fraction.text;
}

std::string FormulaPrinter::print_product(const Polynomial& numerator, const Polynomial& denominator,
                                          const Polynomial& factor) {
  if (factor.is_zero()) return "0";
  if (const Monomial common = shared_powers(factor, denominator); !common.is_one())
    return print_product(numerator, divided_by(denominator, {common, 0, 1}), divided_by(factor, {common, 0, 1}));
  const Ratio ratio = simplify(numerator, denominator);
  if (ratio.numerator.is_zero()) return print(Polynomial(ratio.whole) * factor);
  const bool is_negative = is_minus_taken_out(factor);
  const Printed second = format(is_negative ? -factor : factor, 1);
  Printed first;
  if (ratio.whole != 0)
    first = {print_ratio(numerator, denominator), 0, true};
  else if (style_ == PrintStyle::text || ratio.denominator == Polynomial(1))
    first = format(ratio.numerator, 1);
  else
    first = divided(format(ratio.numerator, 1), format(ratio.denominator, 1));
  Printed printed = second;
  if (first.text != "1") {
    const Printed before = bracketed(first);
    if (second.is_quotient)
      printed = quotient(before.text + " " + second.over, second.divisor, second.under, before.size + second.size);
    else
      printed = {before.text + " " + bracketed(second).text, before.size + second.size, false};
  }
  if (ratio.whole == 0 && style_ == PrintStyle::text && !(ratio.denominator == Polynomial(1)))
    printed = divided(printed, format(ratio.denominator, 1));
  remove_placeholders();
  return ((ratio.whole == 0 && ratio.is_negative) != is_negative ? "-" : "") + printed.text;
}

void FormulaPrinter::remove_placeholders() {
  ring_->truncate_symbols(static_cast<int>(ring_->symbols().size() - placeholders_.size()));
  placeholders_.clear();
}

// Numbers, symbols, waves and products of them.

namespace {

bool is_greek(const std::string& word) {
  for (const char* letter : {"alpha", "beta",   "gamma", "delta",  "theta", "phi",     "psi",   "mu",   "rho", "tau",
                             "omega", "lambda", "eta",   "kappa",  "sigma", "epsilon", "xi",    "zeta", "nu",  "chi",
                             "Gamma", "Delta",  "Theta", "Lambda", "Xi",    "Pi",      "Sigma", "Phi",  "Psi", "Omega"})
    if (word == letter) return true;
  return false;
}

/// Names of formulas whose letters are not those that are printed. Blocks in natural coordinates are complex numbers.
std::string decorated_letter(const std::string& head) {
  for (const char* name : {"Mhat", "Dhat", "zhat", "Cbar", "cbar", "Wbar", "Wtilde", "Ntilde"})
    if (head == name) return "\\" + head.substr(1) + " " + head.substr(0, 1);
  if (head == "Mre" || head == "Cre") return "\\Re " + head.substr(0, 1);
  if (head == "Mim" || head == "Cim") return "\\Im " + head.substr(0, 1);
  return "";
}

/// Whether this is a letter with letters as index, as in names of formulas: `lg`, `Jxy`, the `xB` of a point B.
bool is_quantity(const std::string& head) {
  if (head.size() < 2) return false;
  if (std::string("xyz").find(head[0]) != std::string::npos && std::isupper(static_cast<unsigned char>(head[1])) != 0)
    return true;
  const std::string index_letters = head[0] == 'J'                                           ? "xyzat"
                                    : std::string("Img").find(head[0]) != std::string::npos  ? "xyzt"
                                    : std::string("lxyz").find(head[0]) != std::string::npos ? "g"
                                                                                             : "";
  return head.size() <= 3 && head.find_first_not_of(index_letters, 1) == std::string::npos;
}

/// Rank in a product: g, inertias, lengths, the rest.
int product_rank(SymbolKind kind) {
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

/// Compares the exponents symbol by symbol; at the first difference, the larger exponent comes first.
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
  if (const std::string letter = decorated_letter(head); !letter.empty())
    head = letter;
  else if (is_greek(head))
    head = "\\" + head;
  else if (head.size() > 1)
    head = "\\mathrm{" + head + "}";
  std::string subscript;
  const auto is_digit = [&](std::size_t k) {
    return k < tail.size() && std::isdigit(static_cast<unsigned char>(tail[k])) != 0;
  };
  for (std::size_t k = 0; k < tail.size(); ++k) {
    if (tail[k] != '_') subscript += tail[k];
    if (tail[k] == '_' && k > 0 && is_digit(k - 1) && is_digit(k + 1)) subscript += ',';
  }
  if (tail.ends_with("_")) subscript += '\'';
  const bool has_letters =
      std::any_of(subscript.begin(), subscript.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
  if (subscript.empty()) return head;
  return head + (has_letters && subscript.size() > 2 ? "_{\\mathrm{" + subscript + "}}" : "_{" + subscript + "}");
}

std::string FormulaPrinter::symbol_text(int symbol) const {
  const std::string& name = ring_->symbol(symbol).name;
  const bool is_text = placeholders_.contains(name);
  return style_ == PrintStyle::latex && !is_text ? latex_name(name) : name;
}

std::string FormulaPrinter::angle_text(int angle) const {
  const std::string& name = ring_->angle(angle).name;
  return style_ == PrintStyle::latex ? latex_name(name) : name;
}

std::string FormulaPrinter::number(Rational value) const {
  const std::string numerator = std::to_string(value.numerator());
  if (value.is_integer()) return numerator;
  const std::string denominator = std::to_string(value.denominator());
  return style_ == PrintStyle::latex ? "\\tfrac{" + numerator + "}{" + denominator + "}"
                                     : numerator + "/" + denominator;
}

std::string FormulaPrinter::factor(int symbol, int exponent) const {
  const std::string text = symbol_text(symbol);
  if (exponent == 1) return text;
  const std::string power = std::to_string(exponent);
  // A symbol that stands for a sine has brackets in its name; LaTeX needs braces around a base with an index.
  return style_ == PrintStyle::latex ? "{" + text + "}^{" + power + "}" : text + "^" + power;
}

std::string FormulaPrinter::format_square(const std::string& text) const {
  return style_ == PrintStyle::latex ? "{" + text + "}^{2}" : text + "^2";
}

std::string FormulaPrinter::circular(const CircularFunction& function, int divisor) const {
  std::string argument;
  for (const auto& [angle, undivided] : function.argument) {
    const int multiple = undivided / divisor;
    argument += argument.empty() ? (multiple < 0 ? "-" : "") : (multiple < 0 ? " - " : " + ");
    if (std::abs(multiple) != 1) argument += std::to_string(std::abs(multiple)) + " ";
    argument += angle_text(angle);
  }
  const std::string name = function.is_sine ? "sin" : "cos";
  return (style_ == PrintStyle::latex ? "\\" + name : name) + "(" + argument + ")";
}

std::string FormulaPrinter::format_trigonometric(TrigonometricId trig) const {
  std::string text;
  for (const CircularFunction& function : ring_->wave(trig)) text += (text.empty() ? "" : " ") + circular(function);
  return text;
}

/// `size` counts symbols, functions and numbers; the sign is left out.
FormulaPrinter::Printed FormulaPrinter::term(const Monomial& monomial, Rational coefficient,
                                             TrigonometricId trig) const {
  return product(monomial, coefficient, trig, {});
}

namespace {

/// Names of several letters in LaTeX keep their distance from what stands beside them.
void append_factor(std::string& product, const std::string& factor) {
  if (factor.empty()) return;
  const bool is_word = factor.find("\\mathrm{") < 2 ||
                       product.compare(std::min(product.rfind(' ') + 1, product.size()), 8, "\\mathrm{") == 0;
  if (!product.empty()) product += is_word ? " \\, " : " ";
  product += factor;
}

/// Whether several factors stand side by side outside brackets.
bool has_several_factors(const std::string& text) {
  int depth = 0;
  for (const char c : text) {
    if (c == '(') ++depth;
    if (c == ')') --depth;
    if (c == ' ' && depth == 0) return true;
  }
  return false;
}

}  // namespace

/// over / (divisor under), as text.
FormulaPrinter::Printed FormulaPrinter::quotient(std::string over, std::int64_t divisor, std::string under,
                                                 int size) const {
  if (over.empty()) over = "1";
  if (divisor == 1 && under.empty()) return {over, size, false};
  std::string below = divisor == 1 ? "" : std::to_string(divisor);
  append_factor(below, under);
  Printed printed{over + (has_several_factors(below) ? "/(" + below + ")" : "/" + below), size, false};
  printed.is_quotient = true;
  printed.over = std::move(over), printed.divisor = divisor, printed.under = std::move(under);
  return printed;
}

/// A fraction's denominator stands below the line, `a b/2`; in LaTeX a fraction stands in front.
FormulaPrinter::Printed FormulaPrinter::product(const Monomial& monomial, Rational coefficient, TrigonometricId trig,
                                                const Printed& inner) const {
  const bool latex = style_ == PrintStyle::latex;
  const bool merges = !latex && inner.is_quotient;
  Rational leading = abs(coefficient);
  if (merges) leading = leading / Rational(inner.divisor, 1);
  std::string over, under = merges ? inner.under : "";
  int size = inner.size;
  const Rational shown = latex ? leading : Rational(leading.numerator(), 1);
  if (!(shown == Rational(1))) append_factor(over, number(shown));
  if (!(leading == Rational(1))) ++size;
  std::vector<std::pair<int, int>> order;
  for (int k = 0; k < monomial.size(); ++k) order.emplace_back(product_rank(ring_->symbol(monomial.symbol(k)).kind), k);
  std::sort(order.begin(), order.end());
  for (const auto& [rank, k] : order) {
    const int exponent = monomial.exponent(k);
    append_factor(exponent > 0 ? over : under, factor(monomial.symbol(k), std::abs(exponent)));
    ++size;
  }
  append_factor(over, merges ? inner.over : bracketed(inner).text);
  if (trig != 0) append_factor(over, format_trigonometric(trig)), ++size;
  if (over.empty() && size == 0) size = 1;
  if (!latex) return quotient(over, leading.denominator(), under, size);
  if (over.empty()) over = "1";
  if (!under.empty()) over = "\\frac{" + over + "}{" + under + "}";
  return {over, size, false};
}

FormulaPrinter::Printed FormulaPrinter::bracketed(Printed inner) const {
  if (!inner.is_sum) return inner;
  const bool latex = style_ == PrintStyle::latex;
  inner.text = (latex ? "\\left(" : "(") + inner.text + (latex ? "\\right)" : ")");
  inner.is_sum = inner.is_quotient = false;
  return inner;
}

FormulaPrinter::Printed FormulaPrinter::divided(const Printed& numerator, Printed denominator) const {
  const int size = numerator.size + denominator.size;
  if (style_ == PrintStyle::latex) {
    if (numerator.text.size() > max_latex_numerator)
      return {"\\frac{1}{" + denominator.text + "} " + bracketed(numerator).text, size, false};
    return {"\\frac{" + numerator.text + "}{" + denominator.text + "}", size, false};
  }
  denominator.is_sum = denominator.is_sum || denominator.is_quotient;
  std::string under = numerator.is_quotient ? numerator.under : "";
  append_factor(under, bracketed(denominator).text);
  if (numerator.is_quotient) return quotient(numerator.over, numerator.divisor, under, size);
  return quotient(bracketed(numerator).text, 1, under, size);
}

FormulaPrinter::Printed FormulaPrinter::join_terms(std::vector<std::pair<bool, Printed>> parts) const {
  const auto is_minus = [](const auto& part) { return part.first || part.second.text.starts_with('-'); };
  if (parts.size() == 2 && !parts[0].second.is_sum && is_minus(parts[0]) && !is_minus(parts[1]))
    std::swap(parts[0], parts[1]);
  Printed sum;
  for (const auto& [negative, printed] : parts) {
    const std::string text = negative ? bracketed(printed).text : printed.text;
    const bool minus = negative || text.starts_with('-');  // of a sum, the first term's sign
    sum.text += sum.text.empty() ? (minus ? "-" : "") : (minus ? " - " : " + ");
    sum.text += text.substr(!negative && minus ? 1 : 0);
    sum.size += printed.size;
  }
  sum.is_sum = parts.size() > 1 || (!parts.empty() && (parts[0].first || parts[0].second.is_sum));
  return sum;
}

/// Fractions last, inertias before masses, then by index of the symbol.
std::vector<Term> FormulaPrinter::sorted(const Polynomial& p) const {
  const auto key = [this](const Term& term) {
    int fractions = 0, rank = 99, leading_symbol = 0;
    for (int k = 0; k < term.monomial.size(); ++k) {
      const int symbol = term.monomial.symbol(k);
      if (term.monomial.exponent(k) < 0) ++fractions;
      const auto kind = ring_->symbol(symbol).kind;
      if (rank == 99 && term.monomial.exponent(k) > 0 && is_inertial(kind))
        rank = static_cast<int>(kind), leading_symbol = symbol;
    }
    return std::tuple(fractions, rank, leading_symbol);
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
    Monomial monomial;
    for (int k = 0; k < term.monomial.size(); ++k) {
      const Symbol& symbol = ring_->symbol(term.monomial.symbol(k));
      if (symbol.kind >= SymbolKind::slide)
        monomial.append(term.monomial.symbol(k), term.monomial.exponent(k));
      else
        value *= elementary::pow(symbol.value, term.monomial.exponent(k));
    }
    coefficients[{monomial, term.wave}] += value;
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
