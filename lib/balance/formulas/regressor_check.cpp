#include "balance/formulas/regressor_check.hpp"

#include "balance/base/extrema.hpp"
#include "balance/formulas/check.hpp"
#include "balance/formulas/text_value.hpp"

#include <cmath>
#include <limits>

namespace balance::formulas {

namespace {

/// Every name's value, rates and accelerations included.
std::map<std::string, double> names_of(const FormulaSheet& sheet, const RegressorState& state) {
  auto names = evaluate_names(sheet, state.y);
  const SymbolicRegressor& regressor = *sheet.regressor;
  for (std::size_t c = 0; c < regressor.rates.size(); ++c) {
    names[sheet.ring->symbol(regressor.rates[c]).name] = state.dy[static_cast<Eigen::Index>(c)];
    names[sheet.ring->symbol(regressor.accelerations[c]).name] = state.ddy[static_cast<Eigen::Index>(c)];
  }
  return names;
}

MatrixX printed_regressor(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                          const std::map<std::string, double>& names) {
  std::vector<double> symbols, angles;
  for (const Symbol& symbol : sheet.ring->symbols()) symbols.push_back(names.at(symbol.name));
  for (const Angle& angle : sheet.ring->angles()) angles.push_back(names.at(angle.name));
  const Matrix& Y = sheet.regressor->Y;
  MatrixX value(static_cast<Eigen::Index>(Y.size()), static_cast<Eigen::Index>(sheet.regressor->parameters.size()));
  for (std::size_t i = 0; i < Y.size(); ++i)
    for (std::size_t p = 0; p < Y[i].size(); ++p) {
      const auto text = texts.find("Y" + index_text({i, p}, std::max(Y.size(), Y[i].size())));
      value(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(p)) =
          text != texts.end() ? evaluate_text(text->second, names) : evaluate_polynomial(Y[i][p], symbols, angles);
    }
  return value;
}

}  // namespace

double max_regressor_error(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                           InverseDynamics& engine, const RegressorState& state) {
  const auto expected = engine.regressor(state.q, state.rate, state.acceleration);
  if (!expected) return std::numeric_limits<double>::quiet_NaN();
  const MatrixX Y = printed_regressor(sheet, texts, names_of(sheet, state));
  if (Y.cols() != expected.value.effort.cols()) return std::numeric_limits<double>::quiet_NaN();
  const MatrixX found = state.B.transpose() * Y, size = state.B.cwiseAbs().transpose() * Y.cwiseAbs();
  const auto kind = [&](Eigen::Index p) { return expected.value.parameters[static_cast<std::size_t>(p)].kind; };
  std::map<ParameterKind, double> scale;  // a column of which nothing is left has the round-off of others of its unit
  for (Eigen::Index p = 0; p < Y.cols(); ++p) scale[kind(p)] = std::max(scale[kind(p)], max_abs(size.col(p)));
  double worst = 0;
  for (Eigen::Index p = 0; p < Y.cols(); ++p) {
    const double off = max_abs(found.col(p) - expected.value.effort.col(p));
    worst = std::max(worst, off / std::max(scale[kind(p)], 1e-300));
  }
  return worst;
}

}  // namespace balance::formulas
