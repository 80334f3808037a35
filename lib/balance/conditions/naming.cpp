#include "balance/conditions/naming.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/extrema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// Coefficients below this part of their row's largest are round-off.
constexpr double coefficient_tolerance = 1e-9;

/// The matrices with one symbol larger and smaller.
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
    const double size = max_abs(before.row(row));
    if (max_abs(before.row(row) - after.row(row)) > 1e-7 * size) return true;
  }
  return false;
}

bool has_only_ones(const MatrixX& matrix) { return (matrix.array() == 0 || matrix.array().abs() == 1).all(); }

std::optional<CoefficientFormula> recognise_at(const MatrixX& matrix, const std::vector<PerturbedMatrices>& probes,
                                               const VectorX& values, Eigen::Index row, Eigen::Index column) {
  const auto count = static_cast<Eigen::Index>(probes.size());
  PerturbationResponse response{matrix(row, column), VectorX(count), VectorX(count)};
  if (std::abs(response.value) <= coefficient_tolerance * max_abs(matrix.row(row))) return std::nullopt;
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

/// One symbol's conditions, if it changes any and leaves them comparable.
std::optional<PerturbedMatrices> perturb_symbol(const Mechanism& mechanism, const Conditions& conditions,
                                                const GeometricSymbol& symbol,
                                                const std::function<Conditions(const Mechanism&)>& derive) {
  const Conditions up = derive(scale_symbol(mechanism, symbol, probe_factor));
  // what a larger symbol does not change, a smaller one does not either
  if (!has_same_pivots(conditions, up) || !has_changed(conditions.matrix, up.matrix)) return std::nullopt;
  const Conditions down = derive(scale_symbol(mechanism, symbol, 1 / probe_factor));
  if (!has_same_pivots(conditions, down)) return std::nullopt;
  return PerturbedMatrices{up.matrix, down.matrix};
}

bool is_unnamed(const MatrixX& matrix, const ConditionNames& names, Eigen::Index row, Eigen::Index column) {
  return std::abs(matrix(row, column)) > coefficient_tolerance * max_abs(matrix.row(row)) &&
         names.find(static_cast<int>(row), static_cast<int>(column)) == nullptr;
}

bool has_unnamed(const MatrixX& matrix, const ConditionNames& names) {
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      if (is_unnamed(matrix, names, row, column)) return true;
  return false;
}

/// Names for what is still a bare number: with points by distance and direction instead of their coordinates.
void name_by_angles(const Mechanism& mechanism, const Conditions& conditions, std::vector<PerturbedMatrices> probes,
                    const std::function<Conditions(const Mechanism&)>& derive, ConditionNames& names) {
  const MatrixX& matrix = conditions.matrix;
  std::vector<bool> replaced(names.symbols.size(), false), is_angle(names.symbols.size(), false);
  for (const PolarPoint& point : list_polar_points(mechanism)) {
    // lengths that the spec names stay
    bool own = false;
    for (std::size_t s = 0; s < replaced.size(); ++s)
      if (names.symbols[s].label == point.first || names.symbols[s].label == point.second) own = replaced[s] = true;
    if (!own) continue;
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
  std::vector<Eigen::Index> used;
  std::vector<bool> used_angle;
  for (std::size_t s = 0; s < names.symbols.size(); ++s) {
    if (s < replaced.size() && replaced[s]) continue;
    used.push_back(static_cast<Eigen::Index>(s));
    used_angle.push_back(is_angle[s]);
  }
  VectorX some(static_cast<Eigen::Index>(used.size()));
  for (std::size_t u = 0; u < used.size(); ++u)
    some[static_cast<Eigen::Index>(u)] = names.symbols[static_cast<std::size_t>(used[u])].value;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row)
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      if (!is_unnamed(matrix, names, row, column)) continue;
      PerturbationResponse response{matrix(row, column), VectorX(some.size()), VectorX(some.size())};
      for (std::size_t u = 0; u < used.size(); ++u) {
        response.up[static_cast<Eigen::Index>(u)] = probes[static_cast<std::size_t>(used[u])].up(row, column);
        response.down[static_cast<Eigen::Index>(u)] = probes[static_cast<std::size_t>(used[u])].down(row, column);
      }
      auto formula = recognise_trigonometric_coefficient(some, used_angle, response);
      if (!formula) continue;
      for (SymbolPower& power : formula->factor.powers)
        power.symbol = static_cast<int>(used[static_cast<std::size_t>(power.symbol)]);
      for (SymbolPower& angle : formula->wave->angles)
        angle.symbol = static_cast<int>(used[static_cast<std::size_t>(angle.symbol)]);
      names.formulas[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] = std::move(*formula);
    }
}

/// Keeps the symbols that occur, in their order.
void remove_unused_symbols(ConditionNames& names) {
  std::vector<bool> used(names.symbols.size(), false);
  for (const auto& row : names.formulas)
    for (const auto& formula : row)
      if (formula) mark_used_symbols(*formula, used);
  std::vector<int> place(used.size(), -1);
  std::vector<GeometricSymbol> kept;
  for (std::size_t s = 0; s < used.size(); ++s) {
    if (!used[s]) continue;
    place[s] = static_cast<int>(kept.size());
    kept.push_back(std::move(names.symbols[s]));
  }
  const auto renumber = [&](RationalMonomial& term) {
    for (SymbolPower& power : term.powers) power.symbol = place[static_cast<std::size_t>(power.symbol)];
  };
  for (auto& row : names.formulas) {
    for (auto& formula : row) {
      if (!formula) continue;
      renumber(formula->factor);
      if (formula->wave)
        for (SymbolPower& angle : formula->wave->angles) angle.symbol = place[static_cast<std::size_t>(angle.symbol)];
      for (RationalMonomial& term : formula->sum) renumber(term);
    }
  }
  names.symbols = std::move(kept);
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
      names.notes.push_back("coefficients stay numbers: the mechanism is too large to see what they are made of");
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

}  // namespace balance
