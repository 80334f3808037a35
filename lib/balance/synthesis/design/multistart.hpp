#pragma once
/// Derivative-free minimisation of a function that may be undefined in places.

#include "balance/synthesis/design/search_budget.hpp"

#include <string>

namespace balance::design {

struct MultistartSettings {
  std::function<double(const VectorX& u)> objective;  ///< not finite where undefined
  double bound = 1;                                   ///< of every |u_i|
  std::vector<VectorX> starts;                        ///< of equal size; the first one is the best known point
  std::string method = "cobyla";                      ///< one of NLopt's local methods without gradients
  int max_local_searches = 3;                         ///< from the best of the starts
  int max_evaluations = 400;                          ///< of each of them
  double initial_step = 0.1;                          ///< initial step
  double min_step = 1e-6;                             ///< final step
};

struct MultistartResult {
  VectorX u;         ///< at least as good as the best start
  double value = 0;  ///< not finite: no start has a value
};

/// Evaluates all starts, searches locally from the best of them, and finally tries steps along all coordinates, also
/// away from bounds, until even the smallest steps do not help.
MultistartResult search_multistart(const MultistartSettings& settings, SearchBudget& budget);

/// Quasi-random points that fill the box evenly; reproducible by the seed.
std::vector<VectorX> low_discrepancy_points(int count, int size, std::uint64_t seed);

}  // namespace balance::design
