#include "balance/synthesis/formulas/condition_solver.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>

namespace balance::formulas {

namespace {

/// What is left of a condition with the unknowns that are known already.
struct ReducedCondition {
  std::size_t origin = 0;  ///< index into the conditions
  Polynomial polynomial;
};

/// A condition that is linear in an unknown: slope · unknown + rest.
struct LinearCondition {
  std::size_t row = 0;
  std::size_t unknown = 0;  ///< index into the list of unknowns
  Polynomial slope, rest;
};

/// A slope that is smaller than this part of another one is a zero with round-off.
constexpr double vanishing_slope_ratio = 1e-9;

/// Relative to the largest pivot, at numbers of the order of one.
constexpr double singular_pivot = 1e-9;

class ConditionElimination {
 public:
  ConditionElimination(const std::vector<Polynomial>& conditions, const std::vector<int>& unknowns)
      : conditions_(conditions), unknowns_(unknowns), values_(unknowns.size()) {
    for (std::size_t k = 0; k < conditions.size(); ++k)
      if (!conditions[k].is_zero()) rows_.push_back({k, clear_denominators(conditions[k])});
    if (rows_.empty()) return;
    ring_ = rows_[0].polynomial.ring();
    if (ring_ == nullptr) return;
    for (const Symbol& symbol : ring_->symbols()) typical_numbers_.push_back(symbol.value);
    for (const Angle& angle : ring_->angles()) angles_.push_back(angle.value);
    for (const int unknown : unknowns_) {  // it is about to change
      double& value = typical_numbers_[static_cast<std::size_t>(unknown)];
      if (value == 0) value = 1;
    }
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

  /// A slope that does not vanish with the spec's numbers comes first, since what it multiplies need not be zero
  /// otherwise; then one without unknowns, a product, a condition with few unknowns, the order of the unknowns, and a
  /// short condition. Of slope · unknown = 0 with a slope that vanishes, the slope is the factor that is zero.
  std::optional<LinearCondition> find_pivot() const {
    std::optional<LinearCondition> best;
    std::tuple<bool, std::size_t, bool, std::size_t, std::size_t, std::size_t> best_rank;
    const std::vector<double> largest = largest_slopes();
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const Polynomial& row = rows_[r].polynomial;
      const std::size_t others = count_unknowns(row);
      for (std::size_t u = 0; others > 0 && u < unknowns_.size(); ++u) {
        auto coefficients = coefficients_of(row, unknowns_[u]);
        if (coefficients.rbegin()->first != 1) continue;
        const Polynomial& slope = coefficients[1];
        const bool vanishes = !(std::abs(typical_value(slope)) > vanishing_slope_ratio * largest[u]);
        if (vanishes && coefficients[0].is_zero()) continue;
        const std::tuple rank(vanishes, count_unknowns(slope), slope.size() > 1, others, u, row.size());
        if (best && !(rank < best_rank)) continue;
        best = LinearCondition{r, u, slope, coefficients[0]};
        best_rank = rank;
      }
    }
    return best;
  }

  /// With the spec's numbers.
  double typical_value(const Polynomial& p) const { return evaluate_polynomial(p, typical_numbers_, angles_); }

  /// Per unknown, with the spec's numbers.
  std::vector<double> largest_slopes() const {
    std::vector<double> largest(unknowns_.size(), 0);
    for (const ReducedCondition& row : rows_)
      for (std::size_t u = 0; u < unknowns_.size(); ++u)
        if (degree_in(row.polynomial, unknowns_[u]) == 1)
          largest[u] = std::max(largest[u], std::abs(typical_value(coefficients_of(row.polynomial, unknowns_[u])[1])));
    return largest;
  }

  void eliminate(const LinearCondition& pivot) {
    const int symbol = unknowns_[pivot.unknown];
    const RationalFunction value(-pivot.rest, pivot.slope);
    pivots_.push_back({rows_[pivot.row].origin, pivot.slope});
    rows_.erase(rows_.begin() + static_cast<std::ptrdiff_t>(pivot.row));
    add_known_factors(value.denominator);
    for (ReducedCondition& row : rows_)
      row.polynomial = remove_known_factors(substitute(row.polynomial, symbol, value).numerator);
    std::erase_if(rows_, [](const ReducedCondition& row) { return row.polynomial.is_zero(); });
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
    const Monomial lengths = common_monomial(row).select([&](int s, int) { return is_never_zero(s); });
    row = multiplied_by(row, lengths.inverse());
    return with_coprime_coefficients(row);
  }

  bool is_never_zero(int symbol) const {
    const SymbolKind kind = ring_->symbol(symbol).kind;
    return kind == SymbolKind::length || kind == SymbolKind::gravity;
  }

  Polynomial with_solution(const Polynomial& p) const {
    RationalFunction value(p);
    for (std::size_t u = 0; u < unknowns_.size(); ++u)
      if (values_[u]) value = substitute(value, unknowns_[u], *values_[u]);
    return value.numerator;
  }

  /// Factors of the denominators, and of slopes by which was divided: where these vanish, other values meet the
  /// conditions as well, as any x meets 0 x = 0.
  void list_nonzero(ConditionSolution& solution) {
    known_factors_.clear();
    for (const auto& value : values_)
      if (value) add_known_factors(value->denominator);
    solution.nonzero = known_factors_;
    for (const ReducedCondition& pivot : pivots_) {
      const Polynomial slope = with_solution(pivot.polynomial);
      if (slope.is_zero() || slope.ring() == nullptr) continue;
      for (Polynomial& factor : list_factors(slope, known_factors_)) {
        const std::vector<int> symbols = symbols_in(factor);
        const bool is_listed =
            std::find(solution.nonzero.begin(), solution.nonzero.end(), factor) != solution.nonzero.end();
        if (is_listed || std::all_of(symbols.begin(), symbols.end(), [this](int s) { return is_never_zero(s); }) ||
            determine_unknowns_without(factor))
          continue;
        solution.nonzero.push_back(std::move(factor));
      }
    }
  }

  /// Whether the conditions still determine the unknowns where a factor vanishes: their derivatives keep their rank at a
  /// place where it does, and nothing else is special.
  bool determine_unknowns_without(const Polynomial& factor) const {
    std::vector<double> numbers(ring_->symbols().size());
    for (std::size_t k = 0; k < numbers.size(); ++k)  // no relation between them holds by chance
      numbers[k] = 0.5 + std::fmod(static_cast<double>(k + 1) * std::numbers::phi, 1.0);
    const std::vector<int> symbols = symbols_in(factor);
    const auto linear = std::find_if(symbols.begin(), symbols.end(), [&](int s) { return degree_in(factor, s) == 1; });
    if (linear == symbols.end()) return false;
    auto coefficients = coefficients_of(factor, *linear);
    numbers[static_cast<std::size_t>(*linear)] = -evaluate_polynomial(coefficients[0], numbers, angles_) /
                                                 evaluate_polynomial(coefficients[1], numbers, angles_);
    std::vector<int> solved;
    for (std::size_t u = 0; u < unknowns_.size(); ++u) {
      if (!values_[u]) continue;
      solved.push_back(unknowns_[u]);
      numbers[static_cast<std::size_t>(unknowns_[u])] = evaluate_polynomial(values_[u]->numerator, numbers, angles_) /
                                                        evaluate_polynomial(values_[u]->denominator, numbers, angles_);
    }
    const auto count = static_cast<Eigen::Index>(solved.size());
    MatrixX jacobian(count, count);
    for (Eigen::Index r = 0; r < count; ++r)
      for (Eigen::Index c = 0; c < count; ++c)
        jacobian(r, c) =
            evaluate_polynomial(derivative_by_symbol(conditions_[pivots_[static_cast<std::size_t>(r)].origin],
                                                     solved[static_cast<std::size_t>(c)]),
                                numbers, angles_);
    if (!jacobian.allFinite()) return false;
    numerics::CompleteOrthogonalDecomposition decomposition;
    decomposition.setThreshold(singular_pivot);
    return decomposition.compute(jacobian).rank() == count;
  }

  /// The conditions as they were, with all values: the identities that the elimination used are checked by this.
  void list_remaining(ConditionSolution& solution) const {
    for (const Polynomial& condition : conditions_) {
      const Polynomial value = with_solution(condition);
      if (!value.is_zero()) solution.remaining.push_back(remove_known_factors(clear_denominators(value)));
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
    UnsolvedReason reason = UnsolvedReason::undetermined;
    for (const Polynomial& row : solution.remaining) {
      if (degree_in(row, unknowns_[u]) == 1) return UnsolvedReason::vanishing_slope;
      if (occurs_in(row)) reason = UnsolvedReason::nonlinear;
    }
    return reason;
  }

  const std::vector<Polynomial>& conditions_;
  const std::vector<int>& unknowns_;
  std::vector<ReducedCondition> rows_;
  std::vector<ReducedCondition> pivots_;                 ///< the slopes by which was divided, in order
  std::vector<std::optional<RationalFunction>> values_;  ///< per unknown
  std::vector<Polynomial> known_factors_;                ///< that must not vanish
  Ring* ring_ = nullptr;                                 ///< null: all conditions are plain numbers
  std::vector<double> typical_numbers_, angles_;         ///< per symbol, per angle
};

}  // namespace

ConditionSolution solve_conditions(const std::vector<Polynomial>& conditions, const std::vector<int>& unknowns) {
  return ConditionElimination(conditions, unknowns).run();
}

}  // namespace balance::formulas
