#include "balance/synthesis/formulas/symbolic_equations.hpp"

#include "balance/synthesis/formulas/symbolic_recursion.hpp"

namespace balance::formulas {

namespace {

/// D_ijk = (∂M_ij/∂q_k + ∂M_ik/∂q_j − ∂M_jk/∂q_i) / 2.
std::vector<Matrix> christoffel_symbols(const SymbolicTree& tree, const Matrix& M) {
  const std::size_t n = M.size();
  std::vector<Matrix> dM(n, Matrix(n, Row(n))), D = dM;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i; j < n; ++j)
      for (std::size_t k = 0; k < n; ++k)
        dM[i][j][k] = dM[j][i][k] = column_derivative(tree, M[i][j], static_cast<int>(k));
  const Polynomial half(Rational(1, 2));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = j; k < n; ++k) D[i][j][k] = D[i][k][j] = half * (dM[i][j][k] + dM[i][k][j] - dM[j][k][i]);
  return D;
}

/// Generalised force of a spring: k Δ·∂Δ for zero free length, otherwise (1 − l₀/L) times that.
void add_spring(const LinearSpring& spring, PolynomialFactory& make, SymbolicEquations& e) {
  const Vector d =
      world_position<Polynomial>(e.tree, make, spring.b) - world_position<Polynomial>(e.tree, make, spring.a);
  const Polynomial square = dot(d, d);
  Polynomial factor = Polynomial(Rational(1, 2)) * spring.stiffness;
  if (spring.length >= 0) {
    factor = factor - factor * spring.free_length * Polynomial::of_symbol(make.ring, spring.length, -1);
    e.lengths.emplace_back(spring.length, square);
  }
  for (std::size_t i = 0; i < e.z.size(); ++i)
    e.z[i] += factor * column_derivative(e.tree, square, static_cast<int>(i));
}

/// Generalised force of a joint spring: k q − preload.
void add_joint_spring(const JointSpring& spring, PolynomialFactory& make, SymbolicEquations& e) {
  const Polynomial force = spring.stiffness * Polynomial::of_symbol(make.ring, spring.symbol) - spring.preload;
  for (const auto& [column, ratio] : e.tree.variables[static_cast<std::size_t>(spring.variable)].follows)
    e.z[static_cast<std::size_t>(column)] += ratio * force;
}

void add_weight_and_springs(PolynomialFactory& make, SymbolicEquations& e) {
  Polynomial potential;
  for (std::size_t k = 0; k < 3; ++k) potential -= e.tree.gravity[k] * e.moment[k];
  for (std::size_t i = 0; i < e.M.size(); ++i) e.z.push_back(column_derivative(e.tree, potential, static_cast<int>(i)));
  for (const LinearSpring& spring : e.tree.springs) add_spring(spring, make, e);
  for (const JointSpring& spring : e.tree.joint_springs) add_joint_spring(spring, make, e);
}

}  // namespace

Polynomial column_derivative(const SymbolicTree& tree, const Polynomial& p, int column) {
  Polynomial sum;
  for (const JointVariable& variable : tree.variables)
    for (const auto& [follows, ratio] : variable.follows)
      if (follows == column && variable.index >= 0)
        sum += ratio *
               (variable.is_angle ? derivative_by_angle(p, variable.index) : derivative_by_symbol(p, variable.index));
  return sum;
}

SymbolicEquations derive_equations(Ring& ring, SymbolicTree tree, const EquationSelection& selection) {
  SymbolicEquations e;
  e.tree = std::move(tree);
  PolynomialFactory make{ring};
  Mass total;
  e.M = composite_body_mass_matrix<Polynomial>(e.tree, make, total);
  e.mass = total.mass, e.moment = total.moment;
  if (selection.velocity) e.D = christoffel_symbols(e.tree, e.M);
  if (selection.gravity) add_weight_and_springs(make, e);
  if (!selection.closures) return e;
  e.closure = closure_equations<Polynomial>(e.tree, make);
  for (const Polynomial& h : e.closure) {
    e.A.emplace_back();
    for (std::size_t i = 0; i < e.M.size(); ++i)
      e.A.back().push_back(column_derivative(e.tree, h, static_cast<int>(i)));
  }
  return e;
}

TermCount count_terms(const SymbolicEquations& e) {
  TermCount count;
  for (std::size_t i = 0; i < e.M.size(); ++i)
    for (std::size_t j = 0; j < e.M.size(); ++j) {
      if (j >= i) count.M += e.M[i][j].size();
      for (std::size_t k = j; !e.D.empty() && k < e.M.size(); ++k) count.D += e.D[i][j][k].size();
    }
  for (const Polynomial& z : e.z) count.z += z.size();
  for (const Row& row : e.A)
    for (const Polynomial& a : row) count.A += a.size();
  return count;
}

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
