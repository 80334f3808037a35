#pragma once
/// Least value of a function that may be undefined in places, without gradients.

#include "balance/synthesis/design/search_budget.hpp"

#include <string>

namespace balance::design {

struct MultistartSettings {
  std::function<double(const VectorX& u)> objective;  ///< not finite where there is none
  double bound = 1;                                   ///< of every |u_i|
  std::vector<VectorX> starts;                        ///< of equal size; the first one is the best known
  std::string method = "cobyla";                      ///< of NLopt's local ones without gradients
  int max_local_searches = 3;                         ///< local searches, from the best of the starts
  int max_evaluations = 400;                          ///< of each of them
  double initial_step = 0.1;                          ///< the first one
  double min_step = 1e-6;                             ///< step that ends the search
};

struct MultistartResult {
  VectorX u;         ///< one of the starts at least
  double value = 0;  ///< not finite: there is no value at any start
};

/// Looks at all starts, goes down from the best of them, and at the end tries steps along every coordinate, back from the bounds
/// too, until none of the finest helps.
MultistartResult search_multistart(const MultistartSettings& task, SearchBudget& budget);

/// Points that fill the box evenly; the same for the same seed.
std::vector<VectorX> low_discrepancy_points(int count, int size, std::uint64_t seed);

}  // namespace balance::design
