#include "balance/formulas/numbers.hpp"

#include "balance/formulas/expression.hpp"
#include "balance/formulas/text_value.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <utility>

namespace balance::formulas {

/// Expressions of the spec over its parameters.
struct ParameterMaker {
  Numbers& numbers;

  static Polynomial number(const std::string& text) { return {Rational::of_text(text)}; }
  Polynomial name(const std::string& name) const { return numbers.parameter(name); }
  static bool is_function(const std::string&) { return true; }
  static Polynomial call(const std::string& function, const Polynomial&) {
    throw FormulaError(function + " is no polynomial");
  }
  static Polynomial power(const Polynomial& base, int exponent) { return formulas::power(base, exponent); }
  static Polynomial quotient(const Polynomial& a, const Polynomial& b) { return a * formulas::power(b, -1); }
};

namespace {

bool agree(double a, double b) { return std::abs(a - b) <= 1e-12 * (std::abs(a) + std::abs(b)); }

/// The spec's unit here, if it is a short number.
bool unit_of(double ratio, Rational& unit) {
  if (!std::isfinite(ratio) || ratio == 0) return false;
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", ratio);
  if (!agree(std::strtod(text, nullptr), ratio)) return false;
  unit = Rational::of_text(text);
  return true;
}

}  // namespace

Numbers::Numbers(Ring& ring, const SpecTexts& texts, bool put_in) : ring_(&ring), texts_(&texts), put_in_(put_in) {
  std::map<std::string, double> values{{"pi", std::numbers::pi}};
  for (std::size_t before = 0; before < values.size();) {  // until no more of them can be told
    before = values.size();
    for (const auto& [name, text] : texts.parameters) try {
        if (!values.contains(name)) values[name] = text_value(text, std::map(values));
      } catch (const FormulaError&) {
        continue;  // it needs others first, or is none that can be read: its numbers get symbols of their own
      }
  }
  for (const auto& [name, text] : texts.parameters) {
    if (!values.contains(name)) continue;
    symbols_[name] = ring.add_symbol(plain_name(name), SymbolKind::number, values[name]);
    cause_[name] = text;
  }
}

Polynomial Numbers::parameter(const std::string& name) {
  const auto known = symbols_.find(name);
  if (known == symbols_.end()) throw FormulaError(name + " is no parameter");
  const std::string& text = cause_[name];
  const bool expression =
      text.find_first_of("+*/^") != std::string::npos ||
      text.find_first_of("abcdfghijklmnopqrstuvwxyzABCDFGHIJKLMNOPQRSTUVWXYZ_") != std::string::npos;
  Polynomial found;
  if (put_in_ && expression && open_.insert(name).second) {
    const bool is_read = read(text, ring_->symbol(known->second).value, SymbolKind::number, found);
    open_.erase(name);
    if (is_read) return found;
  }
  return Polynomial::of_symbol(*ring_, known->second);
}

bool Numbers::read(const std::string& text, double value, SymbolKind kind, Polynomial& found) try {
  ParameterMaker make{*this};
  found = ExpressionReader<Polynomial, ParameterMaker>(text, make).read();
  if (found.ring() == nullptr) return false;
  const double written = value_of(found);
  Rational unit = 1;
  if (!agree(written, value)) {
    if (!unit_of(value / written, unit)) return false;
    found = found * Polynomial(unit);
    if (!agree(value_of(found), value)) return false;
  }
  if (found.size() == 1 && found.terms()[0].monomial.size() == 1) {
    const int symbol = found.terms()[0].monomial.symbol(0);
    if (ring_->symbol(symbol).kind == SymbolKind::number) ring_->set_kind(symbol, kind);
  }
  return true;
} catch (const FormulaError&) {
  return false;  // it is no polynomial: the number gets a symbol
}

Polynomial Numbers::at(const std::string& path, double value, const std::string& name, SymbolKind kind) {
  if (path.empty()) return find(path, value, name, kind);
  const auto known = known_.find(path);
  if (known != known_.end()) return known->second;
  return known_[path] = find(path, value, name, kind);
}

Polynomial Numbers::find(const std::string& path, double value, const std::string& name, SymbolKind kind) {
  const auto text = texts_->numbers.find(path);
  if (text != texts_->numbers.end()) {
    const bool ratio = kind == SymbolKind::ratio;
    const auto known = symbols_.find(text->second);
    if (ratio && known != symbols_.end() && agree(ring_->symbol(known->second).value, value)) {
      ring_->set_kind(known->second, kind);
      return Polynomial::of_symbol(*ring_, known->second);
    }
    Polynomial found;
    if (read(text->second, value, kind, found)) return found;
  }
  if (kind == SymbolKind::ratio && std::abs(value) == 1) return {value < 0 ? -1 : 1};
  return named(value, name, kind);
}

Polynomial Numbers::named(double value, const std::string& name, SymbolKind kind) {
  if (value == 0) return {};
  return Polynomial::of_symbol(*ring_, ring_->add_symbol(plain_name(name), kind, value));
}

namespace {

/// UTF-8 and what formulas and programs write for it.
constexpr std::pair<const char*, const char*> greek[] = {
    {"α", "alpha"}, {"β", "beta"},  {"γ", "gamma"}, {"δ", "delta"},  {"ε", "epsilon"}, {"ζ", "zeta"},   {"η", "eta"},
    {"θ", "theta"}, {"ι", "iota"},  {"κ", "kappa"}, {"λ", "lambda"}, {"μ", "mu"},      {"µ", "mu"},     {"ν", "nu"},
    {"ξ", "xi"},    {"π", "pi"},    {"ρ", "rho"},   {"σ", "sigma"},  {"τ", "tau"},     {"φ", "phi"},    {"χ", "chi"},
    {"ψ", "psi"},   {"ω", "omega"}, {"Γ", "Gamma"}, {"Δ", "Delta"},  {"Θ", "Theta"},   {"Λ", "Lambda"}, {"Ξ", "Xi"},
    {"Π", "Pi"},    {"Σ", "Sigma"}, {"Φ", "Phi"},   {"Ψ", "Psi"},    {"Ω", "Omega"}};

std::string greek_written_out(std::string name) {
  for (const auto& [letter, word] : greek)
    for (std::size_t at = name.find(letter); at != std::string::npos; at = name.find(letter, at))
      name.replace(at, std::string(letter).size(), word);
  return name;
}

}  // namespace

std::string plain_name(const std::string& name) {
  std::string plain;
  for (const char c : greek_written_out(name)) {
    const bool good = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    plain += good ? c : '_';
  }
  for (const char* taken : {"sin", "cos", "sqrt", "pi"})
    if (plain == taken) plain += '_';
  if (plain.empty() || std::isdigit(static_cast<unsigned char>(plain[0])) != 0) plain.insert(plain.begin(), 'x');
  return plain;
}

}  // namespace balance::formulas
