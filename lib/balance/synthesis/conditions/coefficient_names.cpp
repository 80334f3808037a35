#include "balance/synthesis/conditions/coefficient_names.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <numeric>

namespace balance::conditions {

namespace {

/// Coefficients below this fraction of the largest one in their row are round-off.
constexpr double coefficient_tolerance = 1e-9;

/// The conditions' matrices with one symbol increased and decreased.
struct PerturbedMatrices {
  MatrixX up, down;
};

bool has_same_pivots(const Conditions& a, const Conditions& b) {
  return b.status == ConditionsStatus::done && a.pivots == b.pivots && a.matrix.rows() == b.matrix.rows() &&
         a.matrix.cols() == b.matrix.cols();
}

Mechanism scale_symbol(const Mechanism& mechanism, const GeometricSymbol& symbol, double factor) {
  if (symbol.is_angle)
    return rotate_point_direction(mechanism, symbol.uses.front().number, factor > 1 ? probe_angle : -probe_angle);
  Mechanism result = mechanism;
  for (const GeometricSymbol::Use& use : symbol.uses)
    result = scale_geometric_parameter(result, use.number, elementary::pow(factor, use.exponent));
  return result;
}

bool has_changed(const MatrixX& before, const MatrixX& after) {
  for (Eigen::Index row = 0; row < before.rows(); ++row) {
    const double size = numerics::max_abs(before.row(row));
    if (numerics::max_abs(before.row(row) - after.row(row)) > 1e-7 * size) return true;
  }
  return false;
}

bool has_only_ones(const MatrixX& matrix) { return (matrix.array() == 0 || matrix.array().abs() == 1).all(); }

std::optional<CoefficientFormula> recognise_at(const MatrixX& matrix, const std::vector<PerturbedMatrices>& probes,
                                               const VectorX& values, Eigen::Index row, Eigen::Index column) {
  const auto count = static_cast<Eigen::Index>(probes.size());
  PerturbationResponse response{matrix(row, column), VectorX(count), VectorX(count)};
  if (std::abs(response.value) <= coefficient_tolerance * numerics::max_abs(matrix.row(row))) return std::nullopt;
  for (Eigen::Index s = 0; s < count; ++s) {
    response.up[s] = probes[static_cast<std::size_t>(s)].up(row, column);
    response.down[s] = probes[static_cast<std::size_t>(s)].down(row, column);
  }
  return recognise_coefficient(values, response);
}

void mark_used_symbols(const CoefficientFormula& formula, std::vector<bool>& used) {
  for (const SymbolPower& power : formula.factor.powers) used[static_cast<std::size_t>(power.symbol)] = true;
  if (formula.wave)
    for (const SymbolPower& angle : formula.wave->angles) used[static_cast<std::size_t>(angle.symbol)] = true;
  for (const RationalMonomial& term : formula.sum)
    for (const SymbolPower& power : term.powers) used[static_cast<std::size_t>(power.symbol)] = true;
}

/// Perturbs one symbol. Returns std::nullopt if no condition changes or the conditions are no longer comparable.
std::optional<PerturbedMatrices> perturb_symbol(const Mechanism& mechanism, const Conditions& conditions,
                                                const GeometricSymbol& symbol,
                                                const std::function<Conditions(const Mechanism&)>& derive) {
  const Conditions up = derive(scale_symbol(mechanism, symbol, probe_factor));
  // what a larger symbol does not change, a smaller one does not change either
  if (!has_same_pivots(conditions, up) || !has_changed(conditions.matrix, up.matrix)) return std::nullopt;
  const Conditions down = derive(scale_symbol(mechanism, symbol, 1 / probe_factor));
  if (!has_same_pivots(conditions, down)) return std::nullopt;
  return PerturbedMatrices{up.matrix, down.matrix};
}

bool is_unnamed(const MatrixX& matrix, const ConditionNames& names, Eigen::Index row, Eigen::Index column) {
  return std::abs(matrix(row, column)) > coefficient_tolerance * numerics::max_abs(matrix.row(row)) &&
         names.find(static_cast<int>(row), static_cast<int>(column)) == nullptr;
}

bool has_unnamed(const MatrixX& matrix, const ConditionNames& names) {
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      if (is_unnamed(matrix, names, row, column)) return true;
  return false;
}

/// Names the remaining bare numbers: describes points by distance and direction instead of by coordinates.
void name_by_angles(const Mechanism& mechanism, const Conditions& conditions, std::vector<PerturbedMatrices> probes,
                    const std::function<Conditions(const Mechanism&)>& derive, ConditionNames& names) {
  const MatrixX& matrix = conditions.matrix;
  std::vector<bool> replaced(names.symbols.size(), false), is_angle(names.symbols.size(), false);
  for (const PolarPoint& point : list_polar_points(mechanism)) {
    // lengths named by the spec are kept
    bool is_named = false;
    for (std::size_t s = 0; s < replaced.size(); ++s)
      if (names.symbols[s].label == point.first || names.symbols[s].label == point.second)
        is_named = replaced[s] = true;
    if (!is_named) continue;
    for (const auto* number : {&point.distance, &point.angle}) {
      const bool angle = number == &point.angle;
      GeometricSymbol symbol{number->label, number->unit, number->value, {{*number, 1}}, angle};
      if (auto probe = perturb_symbol(mechanism, conditions, symbol, derive)) {
        probes.push_back(std::move(*probe));
        names.symbols.push_back(std::move(symbol));
        is_angle.push_back(angle);
      }
    }
  }
  std::vector<Eigen::Index> active_symbols;
  std::vector<bool> is_active_angle;
  for (std::size_t s = 0; s < names.symbols.size(); ++s) {
    if (s < replaced.size() && replaced[s]) continue;
    active_symbols.push_back(static_cast<Eigen::Index>(s));
    is_active_angle.push_back(is_angle[s]);
  }
  VectorX values(static_cast<Eigen::Index>(active_symbols.size()));
  for (std::size_t u = 0; u < active_symbols.size(); ++u)
    values[static_cast<Eigen::Index>(u)] = names.symbols[static_cast<std::size_t>(active_symbols[u])].value;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      if (!is_unnamed(matrix, names, row, column)) continue;
      PerturbationResponse response{matrix(row, column), VectorX(values.size()), VectorX(values.size())};
      for (std::size_t u = 0; u < active_symbols.size(); ++u) {
        response.up[static_cast<Eigen::Index>(u)] = probes[static_cast<std::size_t>(active_symbols[u])].up(row, column);
        response.down[static_cast<Eigen::Index>(u)] =
            probes[static_cast<std::size_t>(active_symbols[u])].down(row, column);
      }
      auto formula = recognise_trigonometric_coefficient(values, is_active_angle, response);
      if (!formula) continue;
      for (SymbolPower& power : formula->factor.powers)
        power.symbol = static_cast<int>(active_symbols[static_cast<std::size_t>(power.symbol)]);
      for (SymbolPower& angle : formula->wave->angles)
        angle.symbol = static_cast<int>(active_symbols[static_cast<std::size_t>(angle.symbol)]);
      names.formulas[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] = std::move(*formula);
    }
}

/// Keeps the symbols that occur, in order.
void remove_unused_symbols(ConditionNames& names) {
  std::vector<bool> used(names.symbols.size(), false);
  for (const auto& row : names.formulas)
    for (const auto& formula : row)
      if (formula) mark_used_symbols(*formula, used);
  std::vector<int> new_index(used.size(), -1);
  std::vector<GeometricSymbol> used_symbols;
  for (std::size_t s = 0; s < used.size(); ++s) {
    if (!used[s]) continue;
    new_index[s] = static_cast<int>(used_symbols.size());
    used_symbols.push_back(std::move(names.symbols[s]));
  }
  const auto renumber = [&](RationalMonomial& term) {
    for (SymbolPower& power : term.powers) power.symbol = new_index[static_cast<std::size_t>(power.symbol)];
  };
  for (auto& row : names.formulas) {
    for (auto& formula : row) {
      if (!formula) continue;
      renumber(formula->factor);
      if (formula->wave)
        for (SymbolPower& angle : formula->wave->angles)
          angle.symbol = new_index[static_cast<std::size_t>(angle.symbol)];
      for (RationalMonomial& term : formula->sum) renumber(term);
    }
  }
  names.symbols = std::move(used_symbols);
}

}  // namespace

const CoefficientFormula* ConditionNames::find(int row, int parameter) const {
  if (formulas.empty()) return nullptr;
  const auto& formula = formulas.at(static_cast<std::size_t>(row)).at(static_cast<std::size_t>(parameter));
  return formula ? &*formula : nullptr;
}

std::vector<GeometricSymbol> list_geometric_symbols(const Mechanism& mechanism) {
  std::vector<GeometricSymbol> symbols;
  for (const GeometricParameter& number : list_geometric_parameters(mechanism))
    if (number.value != 0) symbols.push_back({number.label, number.unit, number.value, {{number, 1}}});
  return symbols;
}

ConditionNames name_coefficients(const Mechanism& mechanism, const Conditions& conditions,
                                 const std::vector<GeometricSymbol>& symbols,
                                 const std::function<Conditions(const Mechanism&)>& derive,
                                 const NamingOptions& options) {
  ConditionNames names;
  const MatrixX& matrix = conditions.matrix;
  if (matrix.rows() == 0 || symbols.empty()) return names;
  if (matrix.cols() > options.max_parameters || static_cast<int>(symbols.size()) > options.max_symbols) {
    if (!has_only_ones(matrix))
      names.notes.push_back("coefficients are numbers: the mechanism is too large to show them as formulas");
    return names;
  }
  std::vector<PerturbedMatrices> probes;
  for (const GeometricSymbol& symbol : symbols) {
    auto probe = perturb_symbol(mechanism, conditions, symbol, derive);
    if (!probe) continue;
    probes.push_back(std::move(*probe));
    names.symbols.push_back(symbol);
  }
  VectorX values(static_cast<Eigen::Index>(names.symbols.size()));
  for (Eigen::Index s = 0; s < values.size(); ++s) values[s] = names.symbols[static_cast<std::size_t>(s)].value;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    auto& formulas = names.formulas.emplace_back();
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      formulas.push_back(recognise_at(matrix, probes, values, row, column));
  }
  if (has_unnamed(matrix, names)) name_by_angles(mechanism, conditions, std::move(probes), derive, names);
  remove_unused_symbols(names);
  return names;
}

namespace {

/// Relative. Conditions carry round-off of about 1e-10; a wrong second-order law would be off by 2e-4.
constexpr double recognition_tolerance = 1e-7;
constexpr int max_angle_multiple = 2;
constexpr int max_exponent = 4, max_exponent_in_sum = 2, max_integer = 4;

bool is_near(double a, double b, double scale) { return std::abs(a - b) <= recognition_tolerance * scale; }

/// Returns the exponent if the response is a power of one symbol, otherwise std::nullopt.
std::optional<int> find_exponent(const PerturbationResponse& r, Eigen::Index s) {
  const double up = r.up[s] / r.value, down = r.down[s] / r.value;
  if (!(up > 0) || !(down > 0) || !is_near(up * down, 1, 1)) return std::nullopt;
  const double exponent = elementary::log(up / down) / (2 * elementary::log(probe_factor));
  const int rounded = static_cast<int>(std::lround(exponent));
  // Division by the step's logarithm amplifies noise about sixty times.
  if (std::abs(exponent - rounded) > 64 * recognition_tolerance || std::abs(rounded) > max_exponent)
    return std::nullopt;
  return rounded;
}

/// Returns the multiple of one angle in a sinusoidal response; 0 if the response does not depend on the angle.
/// @param quadrature A sin ψ for the response A cos ψ, from other angles; 0: unknown, then the multiple is positive
std::optional<int> find_angle_multiple(const PerturbationResponse& r, Eigen::Index s, double quadrature) {
  const double scale = std::abs(r.value) + std::abs(r.up[s]) + std::abs(r.down[s]);
  if (is_near(r.up[s], r.value, scale) && is_near(r.down[s], r.value, scale)) return 0;
  for (int k = 1; k <= max_angle_multiple; ++k) {
    if (!is_near(r.up[s] + r.down[s], 2 * r.value * elementary::cos(k * probe_angle), scale)) continue;
    const double measured_quadrature = -(r.up[s] - r.down[s]) / (2 * elementary::sin(k * probe_angle));
    if (quadrature == 0) return k;
    for (const int sign : {1, -1})
      if (std::abs(measured_quadrature - sign * quadrature) < 1e-5 * (scale + std::abs(quadrature))) return sign * k;
  }
  return std::nullopt;
}

RationalMonomial unit_monomial(std::vector<SymbolPower> powers) { return {1, 1, std::move(powers)}; }

/// A number that is a sum of two products of powers of the symbols.
class TwoTermSum {
 public:
  TwoTermSum(const VectorX& symbols, const PerturbationResponse& response, const std::vector<int>& dependent_symbols)
      : symbols_(symbols), response_(response), dependent_symbols_(dependent_symbols) {}

  std::optional<std::vector<RationalMonomial>> find() const {
    for (int total = 1; total <= 2 * max_exponent_in_sum; ++total) {
      for (int i = -max_exponent_in_sum; i <= max_exponent_in_sum; ++i) {
        for (int k = -max_exponent_in_sum; k < i; ++k) {
          if (std::abs(i) + std::abs(k) != total) continue;
          if (auto terms = solve_for_exponents(i, k)) return terms;
        }
      }
    }
    return std::nullopt;
  }

 private:
  /// Splits the value into its two terms, given the exponents i and k of the first symbol.
  std::optional<std::vector<RationalMonomial>> solve_for_exponents(int i, int k) const {
    const double fi = elementary::pow(probe_factor, i), fk = elementary::pow(probe_factor, k);
    const double first = (response_.up[dependent_symbols_[0]] - response_.value * fk) / (fi - fk);
    const double second = response_.value - first;
    if (!matches_response(dependent_symbols_[0], first, second, i, k)) return std::nullopt;
    std::vector<SymbolPower> a, b;
    for (const int s : dependent_symbols_) {
      const auto exponents =
          s == dependent_symbols_[0] ? std::optional(std::pair(i, k)) : find_exponent_pair(s, first, second);
      if (!exponents) return std::nullopt;
      if (exponents->first != 0) a.push_back({s, exponents->first});
      if (exponents->second != 0) b.push_back({s, exponents->second});
    }
    const auto first_term = make_term(first, a), second_term = make_term(second, b);
    if (!first_term || !second_term) return std::nullopt;
    return first_term->numerator < 0 && second_term->numerator > 0 ? std::vector{*second_term, *first_term}
                                                                   : std::vector{*first_term, *second_term};
  }

  bool matches_response(int s, double first, double second, int i, int k) const {
    const double scale = std::abs(first) + std::abs(second);
    const auto value_at = [&](double f) { return first * elementary::pow(f, i) + second * elementary::pow(f, k); };
    return is_near(value_at(probe_factor), response_.up[s], scale) &&
           is_near(value_at(1 / probe_factor), response_.down[s], scale);
  }

  std::optional<std::pair<int, int>> find_exponent_pair(int s, double first, double second) const {
    for (int i = -max_exponent_in_sum; i <= max_exponent_in_sum; ++i)
      for (int k = -max_exponent_in_sum; k <= max_exponent_in_sum; ++k)
        if (matches_response(s, first, second, i, k)) return std::pair(i, k);
    return std::nullopt;
  }

  std::optional<RationalMonomial> make_term(double term_value, const std::vector<SymbolPower>& powers) const {
    const double product = unit_monomial(powers).value(symbols_);
    // A part that is almost zero is an artefact of the split.
    if (std::abs(term_value) < recognition_tolerance * std::abs(response_.value)) return std::nullopt;
    auto ratio = find_small_ratio(term_value / product);
    if (ratio) ratio->powers = powers;
    return ratio;
  }

  const VectorX& symbols_;
  const PerturbationResponse& response_;
  const std::vector<int>& dependent_symbols_;
};

}  // namespace

double RationalMonomial::value(const VectorX& symbols) const {
  double result = static_cast<double>(numerator) / denominator;
  for (const SymbolPower& power : powers) result *= elementary::pow(symbols[power.symbol], power.exponent);
  return result;
}

double TrigonometricFactor::value(const VectorX& symbols) const {
  double sum = 0;
  for (const SymbolPower& angle : angles) sum += angle.exponent * symbols[angle.symbol];
  return is_sine ? elementary::sin(sum) : elementary::cos(sum);
}

double CoefficientFormula::value(const VectorX& symbols) const {
  double bracket = sum.empty() ? 1 : 0;
  for (const RationalMonomial& term : sum) bracket += term.value(symbols);
  return factor.value(symbols) * bracket * (wave ? wave->value(symbols) : 1);
}

std::optional<RationalMonomial> find_small_ratio(double number) {
  for (int denominator = 1; denominator <= max_integer; ++denominator) {
    for (int numerator = 1; numerator <= max_integer; ++numerator) {
      if (std::gcd(numerator, denominator) != 1) continue;
      const double ratio = static_cast<double>(numerator) / denominator;
      if (is_near(std::abs(number), ratio, ratio))
        return RationalMonomial{number < 0 ? -numerator : numerator, denominator, {}};
    }
  }
  return std::nullopt;
}

std::optional<CoefficientFormula> recognise_coefficient(const VectorX& symbols, const PerturbationResponse& response) {
  if (response.value == 0 || !std::isfinite(response.value)) return std::nullopt;
  std::vector<SymbolPower> powers;
  std::vector<int> dependent_symbols;  // symbols without a power law
  for (Eigen::Index s = 0; s < symbols.size(); ++s) {
    const auto exponent = find_exponent(response, s);
    if (!exponent) dependent_symbols.push_back(static_cast<int>(s));
    if (exponent && *exponent != 0) powers.push_back({static_cast<int>(s), *exponent});
  }
  const double product = unit_monomial(powers).value(symbols);
  if (dependent_symbols.empty()) {
    auto ratio = find_small_ratio(response.value / product);
    if (!ratio) return std::nullopt;
    ratio->powers = std::move(powers);
    return CoefficientFormula{*ratio, {}, std::nullopt};
  }
  const PerturbationResponse sum_response{response.value / product, response.up / product, response.down / product};
  auto sum = TwoTermSum(symbols, sum_response, dependent_symbols).find();
  if (!sum) return std::nullopt;
  return CoefficientFormula{unit_monomial(std::move(powers)), std::move(*sum), std::nullopt};
}

std::optional<CoefficientFormula> recognise_trigonometric_coefficient(const VectorX& symbols,
                                                                      const std::vector<bool>& is_angle,
                                                                      const PerturbationResponse& response) {
  const double f = response.value;
  if (f == 0 || !std::isfinite(f)) return std::nullopt;
  std::vector<SymbolPower> powers;
  TrigonometricFactor trig;
  double angle_sum = 0, quadrature = 0;  // Σ k a; A sin ψ where f = A cos ψ
  for (Eigen::Index s = 0; s < symbols.size(); ++s) {
    const auto symbol = static_cast<int>(s);
    if (!is_angle[static_cast<std::size_t>(s)]) {
      const auto exponent = find_exponent(response, s);
      if (!exponent) return std::nullopt;
      if (*exponent != 0) powers.push_back({symbol, *exponent});
      continue;
    }
    const auto multiple = find_angle_multiple(response, s, trig.angles.empty() ? 0 : quadrature);
    if (!multiple) return std::nullopt;
    if (*multiple == 0) continue;
    if (trig.angles.empty())
      quadrature = -(response.up[s] - response.down[s]) / (2 * elementary::sin(*multiple * probe_angle));
    trig.angles.push_back({symbol, *multiple});
    angle_sum += *multiple * symbols[s];
  }
  if (trig.angles.empty()) return std::nullopt;
  const double quarters = (elementary::atan2(quadrature, f) - angle_sum) / (std::numbers::pi / 2),
               rounded_quarters = std::round(quarters);
  // Near a crest, the phase is accurate to only half the digits.
  if (std::abs(quarters - rounded_quarters) > 1e-5) return std::nullopt;
  const int quarter = ((static_cast<int>(rounded_quarters) % 4) + 4) % 4;  // cos(x + quarter π/2)
  trig.is_sine = quarter % 2 == 1;
  const double basis_value = trig.value(symbols) * unit_monomial(powers).value(symbols);
  if (basis_value == 0) return std::nullopt;
  auto ratio = find_small_ratio(f / basis_value);
  if (!ratio) return std::nullopt;
  ratio->powers = std::move(powers);
  return CoefficientFormula{std::move(*ratio), {}, std::move(trig)};
}

}  // namespace balance::conditions
