#include "balance/synthesis/formulas/closure_solution.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>

namespace balance::formulas {

namespace {

/// Larger systems are not solved: the determinant becomes longer than the closures.
constexpr std::size_t max_solved_closures = 4;

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
    const Polynomial product = A[0][j] * determinant(minor);
    sum = j % 2 == 0 ? sum + product : sum - product;
  }
  return sum;
}

/// Adds a multiple of a relation, which is zero, to an argument.
CircularFunction apply_relation(const CircularFunction& function, const AngleRelation& relation, int times) {
  std::map<int, int> argument(function.argument.begin(), function.argument.end());
  for (const auto& [angle, multiple] : relation.multiples) argument[angle] += times * multiple;
  argument[relation.angle] -= times;
  CircularFunction shifted{function.group, function.is_sine, {}};
  for (const auto& [angle, multiple] : argument)
    if (multiple != 0) shifted.argument.emplace_back(angle, multiple);
  return shifted;
}

int argument_length(const CircularFunction& function) {
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
      TrigonometricMonomial trig = p.ring()->wave(term.wave);
      for (CircularFunction& function : trig)
        for (const AngleRelation& relation : tree.relations)
          for (const int times : {-2, -1, 1, 2}) {
            if (p.ring()->angle(relation.angle).group != function.group) continue;
            const CircularFunction shifted = apply_relation(function, relation, times);
            if (argument_length(shifted) < argument_length(function)) function = shifted;
          }
      best.wave = p.ring()->canonicalise(std::move(trig), best.coefficient);
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
  /// The dependent columns, one of which is replaced by −(column of an independent one).
  const auto replace_column = [&](std::size_t replaced, std::size_t replacement) {
    Matrix B(rows);
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < rows; ++j)
        B[i].push_back(j == replaced ? -e.A[i][replacement] : e.A[i][dependent[j]]);
    return B;
  };
  const Polynomial det = shorten_angle_sums(e.tree, determinant(replace_column(rows, 0)));
  if (det.is_zero()) return {};
  std::vector<SheetFormula> solved{{"Delta", "", det, Polynomial(1), ""}};
  for (const std::size_t d : std::vector<std::size_t>(dependent)) {
    const auto replaced_index =
        static_cast<std::size_t>(std::find(dependent.begin(), dependent.end(), d) - dependent.begin());
    for (std::size_t u = 0; u < independent.size(); ++u) {
      const auto replacement = static_cast<std::size_t>(independent[u]);
      Polynomial numerator = shorten_angle_sums(e.tree, determinant(replace_column(replaced_index, replacement)));
      if (numerator.is_zero()) continue;
      const bool has_name = det.size() > 1;
      solved.push_back({"C", index_text({d, u}, columns), std::move(numerator), det, has_name ? "Delta" : ""});
    }
  }
  if (det.size() == 1) solved.erase(solved.begin());
  return solved;
}

std::vector<int> list_independent_columns(const Mechanism& mechanism, const SymbolicEquations& e) {
  std::vector<int> columns;
  const std::size_t freedoms = e.M.size() - std::min(e.A.size(), e.M.size());
  for (const int actuator : mechanism.actuators)
    for (std::size_t c = 0; c < e.M.size(); ++c)
      if (e.tree.coordinates[c] == actuator) columns.push_back(static_cast<int>(c));
  for (std::size_t c = 0; columns.size() < freedoms && c < e.M.size(); ++c)
    if (std::find(columns.begin(), columns.end(), static_cast<int>(c)) == columns.end())
      columns.push_back(static_cast<int>(c));
  std::sort(columns.begin(), columns.end());
  return columns;
}

namespace {

/// C of the dependent columns: numerators over one determinant.
struct ClosureRates {
  Matrix C;  ///< columns × independent ones
  Polynomial determinant = 1;
};

ClosureRates find_closure_rates(const SymbolicEquations& e, const std::vector<int>& independent) {
  const std::size_t n = e.tree.columns.size();
  ClosureRates rates{Matrix(n, Row(independent.size())), 1};
  const std::vector<SheetFormula> solved = solve_closures(e, independent);
  if (!e.closure.empty() && solved.empty()) throw FormulaError("the closures are not solved in closed form");
  for (const SheetFormula& formula : solved) {
    if (formula.name != "C") continue;
    rates.determinant = formula.denominator;
    for (std::size_t c = 0; c < n; ++c)
      for (std::size_t u = 0; u < independent.size(); ++u)
        if (formula.indices == index_text({c, u}, n)) rates.C[c][u] = formula.value;
  }
  return rates;
}

class TorqueSection {
 public:
  TorqueSection(const Mechanism& mechanism, const SymbolicEquations& equations, const SolvedConditions* solved)
      : e_(equations),
        solved_(solved),
        n_(equations.tree.columns.size()),
        independent_(list_independent_columns(mechanism, equations)),
        rates_(find_closure_rates(equations, independent_)) {}

  SheetSection make() {
    std::string names;
    for (const int column : independent_)
      names += (names.empty() ? "" : ", ") + e_.tree.columns[static_cast<std::size_t>(column)];
    section_.section = SheetSectionKind::torques;
    section_.heading = "Torques of " + names +
                       " that move the mechanism: that of the i-th has U_ij times the acceleration of coordinate j, "
                       "U_ijk times the rates of j and k, for both orders, and U_i";
    for (std::size_t u = 0; u < independent_.size(); ++u) {
      for (std::size_t j = 0; j < n_; ++j) add(u, {j}, [&](std::size_t c) { return e_.M[c][j]; });
      for (std::size_t j = 0; j < n_; ++j)
        for (std::size_t k = j; k < n_; ++k) add(u, {j, k}, [&](std::size_t c) { return e_.D[c][j][k]; });
      add(u, {}, [&](std::size_t c) { return e_.z[c]; });
    }
    return std::move(section_);
  }

 private:
  RationalFunction with_solution(const Polynomial& p) const {
    RationalFunction value(p);
    if (solved_ != nullptr)
      for (const SolvedUnknown& one : solved_->solution.solved) value = substitute(value, one.symbol, one.value);
    return value;
  }

  std::string indices_of(std::size_t u, const std::vector<std::size_t>& columns) const {
    std::string text = std::to_string(u + 1);
    for (const std::size_t c : columns) text += (n_ > 9 ? "_" : "") + std::to_string(c + 1);
    return text;
  }

  /// @param entry of each column of the tree
  template <class Entry>
  void add(std::size_t u, const std::vector<std::size_t>& columns, const Entry& entry) {
    SheetFormula formula{"U", indices_of(u, columns), {}, 1, ""};
    const RationalFunction own = with_solution(entry(static_cast<std::size_t>(independent_[u])));
    const auto polynomial = as_polynomial(own);
    formula.value = polynomial ? *polynomial : own.numerator;
    if (!polynomial) formula.denominator = own.denominator;
    section_.terms += formula.value.size();
    for (std::size_t c = 0; c < n_; ++c) {
      if (rates_.C[c][u].is_zero()) continue;
      const RationalFunction factor = with_solution(entry(c));
      if (factor.is_zero()) continue;
      const auto factor_polynomial = as_polynomial(factor);
      formula.products.push_back({rates_.C[c][u],
                                  factor_polynomial ? rates_.determinant : rates_.determinant * factor.denominator,
                                  factor_polynomial ? *factor_polynomial : factor.numerator});
      section_.terms += rates_.C[c][u].size() + formula.products.back().factor.size();
    }
    if (formula.value.is_zero() && formula.products.empty())
      section_.zero.push_back(formula.label());
    else
      section_.formulas.push_back(std::move(formula));
  }

  const SymbolicEquations& e_;
  const SolvedConditions* solved_;
  std::size_t n_;
  std::vector<int> independent_;
  ClosureRates rates_;
  SheetSection section_;
};

}  // namespace

SheetSection make_torque_section(const Mechanism& mechanism, const SymbolicEquations& equations,
                                 const SolvedConditions* solved) {
  return TorqueSection(mechanism, equations, solved).make();
}

}  // namespace balance::formulas
