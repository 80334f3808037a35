#include "balance/formulas/numbers.hpp"

#include "balance/formulas/expression.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace balance::formulas {

/// Expressions of the spec over its parameters.
struct ParameterFactory {
  SpecSymbols& numbers;

  static Polynomial number(const std::string& text) { return {Rational::parse(text)}; }
  Polynomial name(const std::string& name) const { return numbers.parameter(name); }
  static bool is_function(const std::string&) { return true; }
  static Polynomial call(const std::string& function, const Polynomial&) {
    throw FormulaError(function + " is no polynomial");
  }
  static Polynomial power(const Polynomial& base, int exponent) { return formulas::power(base, exponent); }
  static Polynomial quotient(const Polynomial& a, const Polynomial& b) { return a * formulas::power(b, -1); }
};

namespace {

bool is_equal_to_rounding(double a, double b) { return std::abs(a - b) <= 1e-12 * (std::abs(a) + std::abs(b)); }

/// The spec's unit here, if it is a short number.
bool unit_of(double ratio, Rational& unit) {
  if (!std::isfinite(ratio) || ratio == 0) return false;
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", ratio);
  if (!is_equal_to_rounding(std::strtod(text, nullptr), ratio)) return false;
  unit = Rational::parse(text);
  return true;
}

}  // namespace

SpecSymbols::SpecSymbols(Ring& ring, const ParametricModel& model, const SpecNumberTexts& texts, bool put_in)
    : ring_(&ring), model_(&model), texts_(&texts), is_inlining_(put_in) {
  for (const ParameterText& parameter : texts.parameters) definitions_[parameter.name] = parameter.text;
  for (const NamedExpression& parameter : model.parameters())
    symbols_[parameter.name] =
        ring.add_symbol(identifier_name(parameter.name), SymbolKind::dimensionless, parameter.value);
  for (const Symbol& symbol : ring.symbols()) perturbed_values_.push_back(model.perturbed_value(symbol.source));
}

Polynomial SpecSymbols::parameter(const std::string& name) {
  const auto known = symbols_.find(name);
  if (known == symbols_.end()) throw FormulaError(name + " is no parameter");
  const std::string& text = definitions_[name];
  const bool expression =
      text.find_first_of("+*/^") != std::string::npos ||
      text.find_first_of("abcdfghijklmnopqrstuvwxyzABCDFGHIJKLMNOPQRSTUVWXYZ_") != std::string::npos;
  Polynomial found;
  if (is_inlining_ && expression && in_progress_.insert(name).second) {
    const bool is_read = read(text, Expression(ring_->symbol(known->second).source), SymbolKind::dimensionless, found);
    in_progress_.erase(name);
    if (is_read) return found;
  }
  return Polynomial::of_symbol(*ring_, known->second);
}

/// Two numbers that agree here and elsewhere are the same one.
bool SpecSymbols::read(const std::string& text, const Expression& source, SymbolKind kind, Polynomial& found) try {
  ParameterFactory make{*this};
  found = FormulaParser<Polynomial, ParameterFactory>(text, make).read();
  if (found.ring() == nullptr) return false;
  const double elsewhere = model_->perturbed_value(source), written = evaluate_polynomial(found, perturbed_values_, {});
  if (!is_equal_to_rounding(written, elsewhere)) {
    Rational unit = 1;
    if (!unit_of(elsewhere / written, unit)) return false;
    found = found * Polynomial(unit);
  }
  if (!is_equal_to_rounding(evaluate_polynomial(found), source.value()) ||
      !is_equal_to_rounding(evaluate_polynomial(found, perturbed_values_, {}), elsewhere))
    return false;
  if (found.size() == 1 && found.terms()[0].monomial.size() == 1) {
    const int symbol = found.terms()[0].monomial.symbol(0);
    if (ring_->symbol(symbol).kind == SymbolKind::dimensionless) ring_->set_kind(symbol, kind);
  }
  return true;
} catch (const FormulaError&) {
  return false;  // it is no polynomial: the number gets a symbol
}

Polynomial SpecSymbols::polynomial_at(const std::string& path, const Expression& source, const std::string& name,
                                      SymbolKind kind) {
  if (path.empty()) return find(path, source, name, kind);
  const auto known = known_.find(path);
  if (known != known_.end()) return known->second;
  return known_[path] = find(path, source, name, kind);
}

Polynomial SpecSymbols::find(const std::string& path, const Expression& source, const std::string& name,
                             SymbolKind kind) {
  if (model_->is_zero(source)) return {};
  const auto text = texts_->numbers.find(path);
  if (text != texts_->numbers.end()) {
    const auto known = symbols_.find(text->second);
    if (kind == SymbolKind::ratio && known != symbols_.end() &&
        is_equal_to_rounding(perturbed_values_[static_cast<std::size_t>(known->second)],
                             model_->perturbed_value(source))) {
      ring_->set_kind(known->second, kind);
      return Polynomial::of_symbol(*ring_, known->second);
    }
    Polynomial found;
    if (read(text->second, source, kind, found)) return found;
  }
  const double value = source.value();
  if (kind == SymbolKind::ratio && source.is_constant() && std::abs(value) == 1) return {value < 0 ? -1 : 1};
  return Polynomial::of_symbol(*ring_, ring_->add_symbol(identifier_name(name), kind, source));
}

namespace {

/// UTF-8 and what formulas and programs write for it.
constexpr std::pair<const char*, const char*> greek_letter_names[] = {
    {"α", "alpha"}, {"β", "beta"},  {"γ", "gamma"}, {"δ", "delta"},  {"ε", "epsilon"}, {"ζ", "zeta"},   {"η", "eta"},
    {"θ", "theta"}, {"ι", "iota"},  {"κ", "kappa"}, {"λ", "lambda"}, {"μ", "mu"},      {"µ", "mu"},     {"ν", "nu"},
    {"ξ", "xi"},    {"π", "pi"},    {"ρ", "rho"},   {"σ", "sigma"},  {"τ", "tau"},     {"φ", "phi"},    {"χ", "chi"},
    {"ψ", "psi"},   {"ω", "omega"}, {"Γ", "Gamma"}, {"Δ", "Delta"},  {"Θ", "Theta"},   {"Λ", "Lambda"}, {"Ξ", "Xi"},
    {"Π", "Pi"},    {"Σ", "Sigma"}, {"Φ", "Phi"},   {"Ψ", "Psi"},    {"Ω", "Omega"}};

std::string greek_written_out(std::string name) {
  for (const auto& [letter, word] : greek_letter_names)
    for (std::size_t at = name.find(letter); at != std::string::npos; at = name.find(letter, at))
      name.replace(at, std::string(letter).size(), word);
  return name;
}

}  // namespace

std::string identifier_name(const std::string& name) {
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
