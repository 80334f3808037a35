#pragma once
/// The seam to NLopt: one local or global search in the box.

#include "balance/foundation/base/types.hpp"

#include <cstdint>
#include <functional>
#include <string>

namespace balance::design {

/// Minimise a function for −1 ≤ u ≤ 1 subject to equalities = 0 and inequalities ≥ 0.
struct NonlinearProgram {
  int size = 0;
  double bound = 1;  ///< of every |u_i|
  /// @param gradient written if not null. Not finite where it cannot be computed: a search goes round such points.
  std::function<double(const VectorX& u, VectorX* gradient)> objective;
  int equality_count = 0, inequality_count = 0;
  std::function<void(const VectorX&u, VectorX&values, MatrixX*jacobian)> equalities, inequalities;
};

struct StoppingCriteria {
  int max_evaluations = 2000;
  double max_time = 0;  ///< of computing; 0: no limit. Looked at in every call of objective and constraints.
  double relative_tolerance = 1e-13;  ///< change of the numbers or of the objective that ends a local search
  double initial_step = 0;            ///< first one of methods without gradients; 0: their own choice
  std::function<bool()> stop = {};    ///< asked in every call: true ends the search; null: nothing does
};

struct NloptResult {
  VectorX u;                         ///< the best point, also where the search ended for lack of digits; finite
  double value = 0;                  ///< of the objective there; NaN if it cannot be computed
  bool is_budget_exhausted = false;  ///< evaluations or seconds ran out
};

/// @param method slsqp, auglag, cobyla, bobyqa, sbplx; the last two disregard constraints
NloptResult search_locally(const std::string& method, const NonlinearProgram& program, const VectorX& start,
                           const StoppingCriteria& limits);

/// Constraints are disregarded. The same seed gives the same result.
/// @param method direct, crs, isres, esch, mlsl
/// @param gradients the objective has them
NloptResult search_globally(const std::string& method, const NonlinearProgram& program, const VectorX& start,
                            const StoppingCriteria& limits, std::uint64_t seed, bool gradients);

/// The method asks for gradients.
bool is_gradient_based(const std::string& local_method);

}  // namespace balance::design
