#include "balance/conditions/naming.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// Coefficients below this part of their row's largest are round-off.
constexpr double negligible = 1e-9;

/// The matrices with one symbol larger and smaller.
struct Nudged {
  MatrixX up, down;
};

bool comparable(const Conditions& a, const Conditions& b) {
  return b.status == ConditionsStatus::done && a.pivots == b.pivots && a.matrix.rows() == b.matrix.rows() &&
         a.matrix.cols() == b.matrix.cols();
}

Mechanism with_symbol(const Mechanism& mechanism, const Symbol& symbol, double factor) {
  Mechanism result = mechanism;
  for (const Symbol::Use& use : symbol.uses) result = scaled(result, use.number, std::pow(factor, use.exponent));
  return result;
}

bool changes(const MatrixX& before, const MatrixX& after) {
  for (Eigen::Index row = 0; row < before.rows(); ++row) {
    const double size = before.row(row).cwiseAbs().maxCoeff();
    if ((before.row(row) - after.row(row)).cwiseAbs().maxCoeff() > 1e-7 * size) return true;
  }
  return false;
}

bool only_ones(const MatrixX& matrix) { return (matrix.array() == 0 || matrix.array().abs() == 1).all(); }

std::optional<Formula> recognise_at(const MatrixX& matrix, const std::vector<Nudged>& probes, const VectorX& values,
                                    Eigen::Index row, Eigen::Index column) {
  const auto count = static_cast<Eigen::Index>(probes.size());
  Response response{matrix(row, column), VectorX(count), VectorX(count)};
  if (std::abs(response.value) <= negligible * matrix.row(row).cwiseAbs().maxCoeff()) return std::nullopt;
  for (Eigen::Index s = 0; s < count; ++s) {
    response.up[s] = probes[static_cast<std::size_t>(s)].up(row, column);
    response.down[s] = probes[static_cast<std::size_t>(s)].down(row, column);
  }
  return recognise(values, response);
}

void note_used(const Formula& formula, std::vector<bool>& used) {
  for (const SymbolPower& power : formula.factor.powers) used[static_cast<std::size_t>(power.symbol)] = true;
  for (const Monomial& term : formula.sum)
    for (const SymbolPower& power : term.powers) used[static_cast<std::size_t>(power.symbol)] = true;
}

/// Keeps the symbols that occur, in their order.
void drop_unused(ConditionNames& names) {
  std::vector<bool> used(names.symbols.size(), false);
  for (const auto& row : names.formulas)
    for (const auto& formula : row)
      if (formula) note_used(*formula, used);
  std::vector<int> place(used.size(), -1);
  std::vector<Symbol> kept;
  for (std::size_t s = 0; s < used.size(); ++s) {
    if (!used[s]) continue;
    place[s] = static_cast<int>(kept.size());
    kept.push_back(std::move(names.symbols[s]));
  }
  const auto renumber = [&](Monomial& term) {
    for (SymbolPower& power : term.powers) power.symbol = place[static_cast<std::size_t>(power.symbol)];
  };
  for (auto& row : names.formulas) {
    for (auto& formula : row) {
      if (!formula) continue;
      renumber(formula->factor);
      for (Monomial& term : formula->sum) renumber(term);
    }
  }
  names.symbols = std::move(kept);
}

}  // namespace

const Formula* ConditionNames::find(int row, int parameter) const {
  if (formulas.empty()) return nullptr;
  const auto& formula = formulas.at(static_cast<std::size_t>(row)).at(static_cast<std::size_t>(parameter));
  return formula ? &*formula : nullptr;
}

std::vector<Symbol> own_symbols(const Mechanism& mechanism) {
  std::vector<Symbol> symbols;
  for (const GeometricNumber& number : list_geometry(mechanism))
    if (number.value != 0) symbols.push_back({number.label, number.unit, number.value, {{number, 1}}});
  return symbols;
}

ConditionNames name_coefficients(const Mechanism& mechanism, const Conditions& conditions,
                                 const std::vector<Symbol>& symbols,
                                 const std::function<Conditions(const Mechanism&)>& derive,
                                 const NamingOptions& options) {
  ConditionNames names;
  const MatrixX& matrix = conditions.matrix;
  if (matrix.rows() == 0 || symbols.empty()) return names;
  if (matrix.cols() > options.most_parameters || static_cast<int>(symbols.size()) > options.most_symbols) {
    if (!only_ones(matrix))
      names.notes.push_back("coefficients stay numbers: the mechanism is too large to see what they are made of");
    return names;
  }
  std::vector<Nudged> probes;
  for (const Symbol& symbol : symbols) {
    const Conditions up = derive(with_symbol(mechanism, symbol, probe_factor));
    if (!comparable(conditions, up)) continue;
    const Conditions down = derive(with_symbol(mechanism, symbol, 1 / probe_factor));
    if (!comparable(conditions, down) || !(changes(matrix, up.matrix) || changes(matrix, down.matrix))) continue;
    probes.push_back({up.matrix, down.matrix});
    names.symbols.push_back(symbol);
  }
  VectorX values(static_cast<Eigen::Index>(names.symbols.size()));
  for (Eigen::Index s = 0; s < values.size(); ++s) values[s] = names.symbols[static_cast<std::size_t>(s)].value;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    auto& formulas = names.formulas.emplace_back();
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      formulas.push_back(recognise_at(matrix, probes, values, row, column));
  }
  drop_unused(names);
  return names;
}

}  // namespace balance
