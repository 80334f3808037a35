#pragma once
/// Designs whose variables all come in sizes: a finite number, rated one by one.

#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/search_budget.hpp"

#include <limits>
#include <vector>

namespace balance::design {

/// How good a design is: first its rank, then its value; less is better.
struct DesignRating {
  enum class Rank {
    exact,                ///< value: the figure, or 0 without one
    limits_violated,      ///< the conditions are met; value: violation of the worst limit
    conditions_violated,  ///< the limits are kept; value: the figure or, if that is secondary, the residual
    everything_violated,  ///< value: violation of the worst limit
  };
  Rank rank = Rank::everything_violated;
  double value = std::numeric_limits<double>::infinity();
  double added_mass = 0;  ///< decides between equal values [kg]

  /// Whether this is better than the other by more than round-off.
  bool is_better_than(const DesignRating& other) const;
};

struct SizeSearchResult {
  VectorX x;  ///< the best design [SI]; empty: no combination that was tried is a design
  DesignRating rating;
  long combinations = 0;      ///< number that was tried
  bool is_exhausted = false;  ///< whether these are all combinations
};

/// Whether every variable has sizes and nothing else is to be chosen.
bool is_finite(const DesignProblem& problem);

/// Number of combinations of sizes of some variables that differ where they must, whatever sizes the others have;
/// `limit` if there are as many or more.
long count_combinations(const DesignProblem& problem, const std::vector<int>& variables, long limit);

/// Rates all combinations until the time ends, first those that exchanges of single sizes lead to from the start
/// values. If the figures are functions of the parameters along a motion, each set of lengths is moved only once.
/// @param problem must be finite
SizeSearchResult try_all_sizes(const DesignProblem& problem, SearchBudget& budget);

/// Exchanges one size, or two that must differ, as long as this makes the design better: from the start values and from
/// random combinations, until several such searches end equally well.
/// @param problem must be finite
/// @param max_combinations number of combinations after which the search ends
SizeSearchResult exchange_sizes(const DesignProblem& problem, SearchBudget& budget, long max_combinations);

}  // namespace balance::design
