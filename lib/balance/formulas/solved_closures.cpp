#include "balance/formulas/solved_closures.hpp"

#include <algorithm>
#include <cstdlib>

namespace balance::formulas {

namespace {

Polynomial determinant(const Matrix& A) {
  if (A.empty()) return {1};
  Polynomial sum;
  for (std::size_t j = 0; j < A.size(); ++j) {
    if (A[0][j].is_zero()) continue;
    Matrix minor;
    for (std::size_t i = 1; i < A.size(); ++i) {
      minor.emplace_back(A[i]);
      minor.back().erase(minor.back().begin() + static_cast<std::ptrdiff_t>(j));
    }
    const Polynomial part = A[0][j] * determinant(minor);
    sum = j % 2 == 0 ? sum + part : sum - part;
  }
  return sum;
}

/// A wave with a multiple of a relation added to an argument.
CircularFunction apply_relation(const CircularFunction& function, const AngleRelation& relation, int times) {
  std::map<int, int> argument(function.argument.begin(), function.argument.end());
  for (const auto& [angle, multiple] : relation.multiples) argument[angle] += times * multiple;
  argument[relation.angle] -= times;
  CircularFunction other{function.group, function.is_sine, {}};
  for (const auto& [angle, multiple] : argument)
    if (multiple != 0) other.argument.emplace_back(angle, multiple);
  return other;
}

int length_of(const CircularFunction& function) {
  int length = 0;
  for (const auto& [angle, multiple] : function.argument) length += std::abs(multiple);
  return length;
}

}  // namespace

Polynomial shorten_angle_sums(const SymbolicTree& tree, const Polynomial& p) {
  std::vector<Term> terms;
  for (const Term& term : p.terms()) {
    Term best = term;
    if (term.wave != 0) {
      TrigonometricMonomial wave = p.ring()->wave(term.wave);
      for (CircularFunction& function : wave)
        for (const AngleRelation& relation : tree.relations)
          for (const int times : {-2, -1, 1, 2}) {
            if (p.ring()->angle(relation.angle).group != function.group) continue;
            const CircularFunction other = apply_relation(function, relation, times);
            if (length_of(other) < length_of(function)) function = other;
          }
      best.wave = p.ring()->canonicalise(std::move(wave), best.coefficient);
    }
    terms.push_back(best);
  }
  return Polynomial::of_terms(p.ring(), std::move(terms));
}

std::vector<SheetFormula> solve_closures(const SymbolicEquations& e, const std::vector<int>& independent) {
  const std::size_t rows = e.A.size(), columns = e.tree.columns.size();
  std::vector<std::size_t> dependent;
  for (std::size_t c = 0; c < columns; ++c)
    if (std::find(independent.begin(), independent.end(), static_cast<int>(c)) == independent.end())
      dependent.push_back(c);
  if (rows == 0 || rows > max_solved_closures || dependent.size() != rows) return {};
  /// The dependent columns, one of them replaced by −(column of an independent one).
  const auto square = [&](std::size_t replaced, std::size_t by) {
    Matrix B(rows);
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < rows; ++j) B[i].push_back(j == replaced ? -e.A[i][by] : e.A[i][dependent[j]]);
    return B;
  };
  const Polynomial det = shorten_angle_sums(e.tree, determinant(square(rows, 0)));
  if (det.is_zero()) return {};
  std::vector<SheetFormula> solved{{"Delta", "", det, Polynomial(1), ""}};
  for (const std::size_t d : std::vector<std::size_t>(dependent)) {
    const auto at = static_cast<std::size_t>(std::find(dependent.begin(), dependent.end(), d) - dependent.begin());
    for (std::size_t u = 0; u < independent.size(); ++u) {
      const auto by = static_cast<std::size_t>(independent[u]);
      Polynomial numerator = shorten_angle_sums(e.tree, determinant(square(at, by)));
      if (numerator.is_zero()) continue;
      const bool named = det.size() > 1;
      solved.push_back({"C", index_text({d, u}, columns), std::move(numerator), det, named ? "Delta" : ""});
    }
  }
  if (det.size() == 1) solved.erase(solved.begin());
  return solved;
}

}  // namespace balance::formulas
