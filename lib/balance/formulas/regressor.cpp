#include "balance/formulas/regressor.hpp"

namespace balance::formulas {

SymbolicRegressor derive_regressor(Ring& ring, const SymbolicEquations& e) {
  SymbolicRegressor out;
  const std::size_t n = e.M.size();
  std::vector<Polynomial> rate, acceleration;
  for (const std::string& name : e.tree.columns) {
    out.rates.push_back(ring.add_symbol("d" + name, SymbolKind::rate, 0));
    out.accelerations.push_back(ring.add_symbol("dd" + name, SymbolKind::acceleration, 0));
    rate.push_back(Polynomial::of_symbol(ring, out.rates.back()));
    acceleration.push_back(Polynomial::of_symbol(ring, out.accelerations.back()));
  }
  out.parameters = e.tree.inertial;
  for (std::size_t i = 0; i < n; ++i) {
    Row row;
    for (const int parameter : out.parameters) {
      Polynomial sum = derivative_by_symbol(e.z[i], parameter);
      for (std::size_t j = 0; j < n; ++j) {
        sum += derivative_by_symbol(e.M[i][j], parameter) * acceleration[j];
        for (std::size_t k = j; k < n; ++k)
          sum += Polynomial(j == k ? 1 : 2) * derivative_by_symbol(e.D[i][j][k], parameter) * rate[j] * rate[k];
      }
      row.push_back(std::move(sum));
    }
    out.Y.push_back(std::move(row));
  }
  return out;
}

std::string parameter_text(const Ring& ring, const SymbolicRegressor& regressor) {
  std::string text;
  for (std::size_t p = 0; p < regressor.parameters.size(); ++p)
    text += (p == 0 ? "" : ", ") + std::to_string(p + 1) + " " + ring.symbol(regressor.parameters[p]).name;
  return text;
}

}  // namespace balance::formulas
