#include "balance/synthesis/formulas/condition_solver.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

namespace balance::formulas {

namespace {

/// A condition that is linear in an unknown: slope · unknown + rest.
struct LinearCondition {
  std::size_t row = 0;
  std::size_t unknown = 0;  ///< index into the list of unknowns
  Polynomial slope, rest;
};

/// A slope that is smaller than this part of another one is a zero with round-off.
constexpr double vanishing_slope_ratio = 1e-9;

class ConditionElimination {
 public:
  ConditionElimination(const std::vector<Polynomial>& conditions, const std::vector<int>& unknowns)
      : conditions_(conditions), unknowns_(unknowns), values_(unknowns.size()) {
    for (const Polynomial& condition : conditions)
      if (!condition.is_zero()) rows_.push_back(clear_denominators(condition));
  }

  ConditionSolution run() {
    while (const auto pivot = find_pivot()) eliminate(*pivot);
    ConditionSolution solution;
    list_nonzero(solution);
    list_remaining(solution);
    for (std::size_t u = 0; u < unknowns_.size(); ++u)
      if (values_[u])
        solution.solved.push_back({unknowns_[u], *values_[u]});
      else
        solution.unsolved.push_back({unknowns_[u], reason_of(u, solution)});
    return solution;
  }

 private:
  static Polynomial clear_denominators(const Polynomial& p) {
    return with_coprime_coefficients(RationalFunction(p).numerator);
  }

  std::size_t count_unknowns(const Polynomial& p) const {
    const std::vector<int> symbols = symbols_in(p);
    return static_cast<std::size_t>(std::count_if(unknowns_.begin(), unknowns_.end(), [&](int symbol) {
      return std::binary_search(symbols.begin(), symbols.end(), symbol);
    }));
  }

  /// A slope without unknowns comes first, since it cannot vanish later; then one that does not vanish with the ring's
  /// values, a product, a condition with few unknowns, the order of the unknowns, and a short condition.
  std::optional<LinearCondition> find_pivot() const {
    std::optional<LinearCondition> best;
    std::tuple<std::size_t, bool, bool, std::size_t, std::size_t, std::size_t> best_rank;
    const std::vector<double> largest = largest_slopes();
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const std::size_t others = count_unknowns(rows_[r]);
      for (std::size_t u = 0; others > 0 && u < unknowns_.size(); ++u) {
        auto coefficients = coefficients_of(rows_[r], unknowns_[u]);
        if (coefficients.rbegin()->first != 1) continue;
        const Polynomial& slope = coefficients[1];
        const bool vanishes = !(std::abs(evaluate_polynomial(slope)) > vanishing_slope_ratio * largest[u]);
        const std::tuple rank(count_unknowns(slope), vanishes, slope.size() > 1, others, u, rows_[r].size());
        if (best && !(rank < best_rank)) continue;
        best = LinearCondition{r, u, slope, coefficients[0]};
        best_rank = rank;
      }
    }
    return best;
  }

  /// Per unknown, with the ring's values.
  std::vector<double> largest_slopes() const {
    std::vector<double> largest(unknowns_.size(), 0);
    for (const Polynomial& row : rows_)
      for (std::size_t u = 0; u < unknowns_.size(); ++u)
        if (degree_in(row, unknowns_[u]) == 1)
          largest[u] = std::max(largest[u], std::abs(evaluate_polynomial(coefficients_of(row, unknowns_[u])[1])));
    return largest;
  }

  void eliminate(const LinearCondition& pivot) {
    const int symbol = unknowns_[pivot.unknown];
    const RationalFunction value(-pivot.rest, pivot.slope);
    rows_.erase(rows_.begin() + static_cast<std::ptrdiff_t>(pivot.row));
    add_known_factors(value.denominator);
    for (Polynomial& row : rows_) row = remove_known_factors(substitute(row, symbol, value).numerator);
    std::erase_if(rows_, [](const Polynomial& row) { return row.is_zero(); });
    for (auto& known : values_)
      if (known) known = substitute(*known, symbol, value);
    values_[pivot.unknown] = value;
  }

  void add_known_factors(const Polynomial& denominator) {
    for (Polynomial& factor : list_factors(denominator, known_factors_))
      if (std::find(known_factors_.begin(), known_factors_.end(), factor) == known_factors_.end())
        known_factors_.push_back(std::move(factor));
  }

  /// Divides a condition by what is known not to vanish, such as lengths and gravity.
  Polynomial remove_known_factors(Polynomial row) const {
    if (row.is_zero()) return row;
    for (const Polynomial& factor : known_factors_)
      while (const auto quotient = divide_exactly(row, factor)) row = *quotient;
    const Monomial lengths = common_monomial(row).select([&](int s, int) {
      const SymbolKind kind = row.ring()->symbol(s).kind;
      return kind == SymbolKind::length || kind == SymbolKind::gravity;
    });
    row = multiplied_by(row, lengths.inverse());
    return with_coprime_coefficients(row);
  }

  void list_nonzero(ConditionSolution& solution) {
    known_factors_.clear();
    for (const auto& value : values_)
      if (value) add_known_factors(value->denominator);
    solution.nonzero = known_factors_;
  }

  /// The conditions as they were, with all values: the identities that the elimination used are checked by this.
  void list_remaining(ConditionSolution& solution) const {
    for (const Polynomial& condition : conditions_) {
      RationalFunction value(condition);
      for (std::size_t u = 0; u < unknowns_.size(); ++u)
        if (values_[u]) value = substitute(value, unknowns_[u], *values_[u]);
      if (!value.is_zero()) solution.remaining.push_back(remove_known_factors(clear_denominators(value.numerator)));
    }
    std::stable_sort(solution.remaining.begin(), solution.remaining.end(),
                     [](const Polynomial& a, const Polynomial& b) { return a.size() < b.size(); });
    std::vector<Polynomial> independent;
    for (Polynomial& row : solution.remaining)
      if (std::none_of(independent.begin(), independent.end(),
                       [&](const Polynomial& other) { return divide_exactly(row, other).has_value(); }))
        independent.push_back(std::move(row));
    solution.remaining = std::move(independent);
  }

  UnsolvedReason reason_of(std::size_t u, const ConditionSolution& solution) const {
    const auto occurs_in = [&](const Polynomial& p) {
      const std::vector<int> symbols = symbols_in(p);
      return std::binary_search(symbols.begin(), symbols.end(), unknowns_[u]);
    };
    if (std::none_of(conditions_.begin(), conditions_.end(), occurs_in)) return UnsolvedReason::absent;
    return std::any_of(solution.remaining.begin(), solution.remaining.end(), occurs_in) ? UnsolvedReason::nonlinear
                                                                                        : UnsolvedReason::undetermined;
  }

  const std::vector<Polynomial>& conditions_;
  const std::vector<int>& unknowns_;
  std::vector<Polynomial> rows_;
  std::vector<std::optional<RationalFunction>> values_;  ///< per unknown
  std::vector<Polynomial> known_factors_;                ///< that must not vanish
};

}  // namespace

ConditionSolution solve_conditions(const std::vector<Polynomial>& conditions, const std::vector<int>& unknowns) {
  return ConditionElimination(conditions, unknowns).run();
}

}  // namespace balance::formulas
