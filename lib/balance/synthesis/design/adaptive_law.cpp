#include "balance/synthesis/design/adaptive_law.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/solve_design.hpp"
#include "balance/synthesis/design/solver_context.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace balance::design {

namespace {

/// A a + Σ b_m m(p) = 0 with monomials m of the load variables p, all in unit coordinates.
struct SeparatedConditions {
  MatrixX matrix;                                ///< A: conditions × adapted variables
  std::map<numerics::Monomial, VectorX> loaded;  ///< b
};

/// @return std::nullopt if an adapted variable occurs in a product
std::optional<SeparatedConditions> separate_conditions(const numerics::SparsePolynomial& rows, int adapted) {
  SeparatedConditions conditions{MatrixX::Zero(rows.outputs(), adapted), {}};
  for (const numerics::SparsePolynomial::Term& term : rows.terms()) {
    const bool is_adapted = !term.monomial.empty() && term.monomial.front().first < adapted;
    if (is_adapted && (term.monomial.size() > 1 || term.monomial.front().second > 1)) return std::nullopt;
    VectorX* column = nullptr;
    if (!is_adapted) {
      column = &conditions.loaded[term.monomial];
      if (column->size() == 0) column->setZero(rows.outputs());
    }
    for (const auto& [row, coefficient] : term.coefficients)
      (is_adapted ? conditions.matrix(row, term.monomial.front().first) : (*column)[row]) += coefficient;
  }
  return conditions;
}

/// The adapted variables as polynomials of the load variables, both in unit coordinates.
std::optional<numerics::SparsePolynomial> solve_adapted_variables(const SeparatedConditions& conditions,
                                                                  const VectorX& anchor, int variables) {
  const Eigen::Index n = conditions.matrix.cols();
  MatrixX inverse = MatrixX::Zero(n, conditions.matrix.rows()), null_space_projector = MatrixX::Identity(n, n);
  if (conditions.matrix.size() > 0) {
    constexpr double adaptive_rank_tolerance = 1e-10;  // relative to the largest singular value
    numerics::SingularValueDecomposition svd(conditions.matrix, Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(adaptive_rank_tolerance);
    const Eigen::Index rank = svd.rank();
    const MatrixX v = svd.matrixV().leftCols(rank);
    inverse =
        v * svd.singularValues().head(rank).cwiseInverse().asDiagonal() * svd.matrixU().leftCols(rank).transpose();
    null_space_projector -= v * v.transpose();
  }
  numerics::PolynomialBuilder collector(static_cast<int>(n));
  const VectorX undetermined = null_space_projector * anchor;
  for (int i = 0; i < n; ++i) collector.add({}, i, undetermined[i]);
  for (const auto& [monomial, rhs] : conditions.loaded) {
    VectorX solution = -inverse * rhs;
    solution -= inverse * (conditions.matrix * solution + rhs);
    if (numerics::max_abs(conditions.matrix * solution + rhs) > condition_tolerance) return std::nullopt;
    for (int i = 0; i < n; ++i) collector.add(monomial, i, solution[i]);
  }
  return collector.build(variables, 1e-12);
}

/// Drops the digits that are round-off in differences of numbers of this size.
double round_to_significant_digits(double value, double size) {
  constexpr int significant_digits = 13;
  const double scale = size > 0 ? elementary::pow(10, significant_digits - std::ceil(elementary::log10(size))) : 1;
  return scale > 1 && std::isfinite(scale) ? std::round(value * scale) / scale : value;
}

AdaptiveLaw to_si_law(const numerics::SparsePolynomial& units, const VariableScaling& scaling, int adapted) {
  const numerics::SparsePolynomial loads = units.substitute(scaling.centre(), scaling.half_width());
  AdaptiveLaw law;
  const Eigen::Index count = scaling.size() - adapted;
  law.terms.push_back({std::vector<int>(static_cast<std::size_t>(count), 0), scaling.centre().head(adapted)});
  const auto degree = [](const AdaptiveLaw::Term& term) {
    return std::accumulate(term.powers.begin(), term.powers.end(), 0);
  };
  for (const numerics::SparsePolynomial::Term& term : loads.terms()) {
    AdaptiveLaw::Term next{std::vector<int>(static_cast<std::size_t>(count), 0), VectorX::Zero(adapted)};
    for (const auto& [variable, power] : term.monomial)
      next.powers[static_cast<std::size_t>(variable - adapted)] = power;
    for (const auto& [i, coefficient] : term.coefficients) next.coefficients[i] = coefficient * scaling.half_width()[i];
    if (degree(next) > 0) {
      law.terms.push_back(std::move(next));
      continue;
    }
    for (Eigen::Index i = 0; i < adapted; ++i) {
      double& sum = law.terms.front().coefficients[i];
      const double size = std::abs(sum) + std::abs(next.coefficients[i]);
      sum += next.coefficients[i];
      if (std::abs(sum) < 1e-13 * size) sum = 0;
    }
  }
  const VectorX size = scaling.centre().cwiseAbs() + scaling.half_width();
  for (AdaptiveLaw::Term& term : law.terms) {
    double load = 1;
    for (std::size_t k = 0; k < term.powers.size(); ++k)
      load *= elementary::pow(size[adapted + static_cast<Eigen::Index>(k)], term.powers[k]);
    for (Eigen::Index i = 0; i < adapted; ++i)
      term.coefficients[i] = round_to_significant_digits(term.coefficients[i], size[i] / load);
  }
  std::stable_sort(law.terms.begin(), law.terms.end(),
                   [&](const auto& a, const auto& b) { return degree(a) < degree(b); });
  return law;
}

}  // namespace

VectorX AdaptiveLaw::evaluate(const VectorX& loads) const {
  VectorX values = VectorX::Zero(terms.front().coefficients.size());
  for (const Term& term : terms) {
    double product = 1;
    for (std::size_t k = 0; k < term.powers.size(); ++k)
      product *= elementary::pow(loads[static_cast<Eigen::Index>(k)], term.powers[k]);
    values += product * term.coefficients;
  }
  return values;
}

MatrixX AdaptiveLaw::jacobian(const VectorX& loads) const {
  MatrixX slope = MatrixX::Zero(terms.front().coefficients.size(), loads.size());
  for (const Term& term : terms)
    for (std::size_t k = 0; k < term.powers.size(); ++k) {
      if (term.powers[k] == 0) continue;
      double product = term.powers[k];
      for (std::size_t j = 0; j < term.powers.size(); ++j)
        product *= elementary::pow(loads[static_cast<Eigen::Index>(j)], term.powers[j] - (j == k ? 1 : 0));
      slope.col(static_cast<Eigen::Index>(k)) += product * term.coefficients;
    }
  return slope;
}

bool AdaptiveLaw::is_affine(Eigen::Index i) const {
  return std::all_of(terms.begin(), terms.end(), [&](const Term& term) {
    return term.coefficients[i] == 0 || std::accumulate(term.powers.begin(), term.powers.end(), 0) <= 1;
  });
}

std::optional<AdaptiveLaw> find_adaptive_law(const DesignProblem& problem, const VectorX& anchor) {
  SearchBudget budget(problem.search.max_time);
  const SolverContext context(problem, budget);
  const int adapted = static_cast<int>(anchor.size());
  if (context.classification.has_geometric() || !context.features.polynomial()) return std::nullopt;
  const Conditions conditions = context.conditions_at(context.scaling.start());
  if (conditions.status != ConditionsStatus::done) return std::nullopt;
  const Eigen::Index row_count = conditions.parameter_rows();
  MatrixX rows = MatrixX::Zero(row_count, context.features.feature_count());
  rows.leftCols(conditions.matrix.cols()) =
      conditions.row_scales.head(row_count).cwiseInverse().asDiagonal() * conditions.matrix.topRows(row_count);
  const auto separated = separate_conditions(context.features.polynomial()->combine(rows), adapted);
  if (!separated) return std::nullopt;
  const VariableScaling& scaling = context.scaling;
  const VectorX unit = (anchor - scaling.centre().head(adapted)).cwiseQuotient(scaling.half_width().head(adapted));
  const auto units = solve_adapted_variables(*separated, unit, scaling.size());
  if (!units) return std::nullopt;
  return to_si_law(*units, scaling, adapted);
}

}  // namespace balance::design
