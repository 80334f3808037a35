#pragma once
/// Interface to NLopt: a local or global search in a box.

#include "balance/foundation/base/types.hpp"

#include <cstdint>
#include <functional>
#include <string>

namespace balance::design {

/// Minimise a function for |u_i| ≤ bound subject to equalities = 0 and inequalities ≥ 0.
struct NonlinearProgram {
  int size = 0;
  double bound = 1;  ///< of every |u_i|
  /// @param gradient set unless null. May return a non-finite value where undefined; the search avoids such points.
  std::function<double(const VectorX& u, VectorX* gradient)> objective;
  int equality_count = 0, inequality_count = 0;
  std::function<void(const VectorX&u, VectorX&values, MatrixX*jacobian)> equalities, inequalities;
};

struct StoppingCriteria {
  int max_evaluations = 2000;
  double max_time = 0;  ///< CPU time [s]; 0: unlimited. Checked in every call of objective and constraints.
  double relative_tolerance = 1e-13;  ///< of variables or objective; smaller changes end a local search
  double initial_step = 0;            ///< of methods without gradients; 0: their own choice
  std::function<bool()> stop = {};    ///< polled in every call: true ends the search; may be null
};

struct NloptResult {
  VectorX u;                         ///< the best point, even if the search ran out of precision; finite
  double value = 0;                  ///< objective at u; NaN if undefined
  bool is_budget_exhausted = false;  ///< limit of evaluations or time was reached
};

/// @param method slsqp, auglag, cobyla, bobyqa, sbplx; the last two ignore constraints
NloptResult search_locally(const std::string& method, const NonlinearProgram& program, const VectorX& start,
                           const StoppingCriteria& limits);

/// Ignores constraints. The same seed gives the same result.
/// @param method direct, crs, isres, esch, mlsl
/// @param gradients whether the objective provides them
NloptResult search_globally(const std::string& method, const NonlinearProgram& program, const VectorX& start,
                            const StoppingCriteria& limits, std::uint64_t seed, bool gradients);

/// Whether the method uses gradients.
bool is_gradient_based(const std::string& local_method);

}  // namespace balance::design
