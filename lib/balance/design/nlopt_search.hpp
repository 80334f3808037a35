#pragma once
/// The seam to NLopt: one local or global search in the box. Private to design.

#include "balance/base/types.hpp"

#include <cstdint>
#include <functional>
#include <string>

namespace balance::designing {

/// Minimise a function for −1 ≤ u ≤ 1 subject to equalities = 0 and inequalities ≥ 0.
struct Program {
  int size = 0;
  double bound = 1;  ///< of every |u_i|
  /// @param gradient written if not null. Not finite where it cannot be computed: a search goes round such points.
  std::function<double(const VectorX& u, VectorX* gradient)> objective;
  int equality_count = 0, inequality_count = 0;
  std::function<void(const VectorX&u, VectorX&values, MatrixX*jacobian)> equalities, inequalities;
};

struct SearchLimits {
  int evaluations = 2000;
  double seconds = 0;       ///< of computing; 0: no limit. Looked at in every call of objective and constraints.
  double relative = 1e-13;  ///< change of the numbers or of the objective that ends a local search
  double step = 0;          ///< first one of methods without gradients; 0: their own choice
  std::function<bool()> stop = {};  ///< asked in every call: true ends the search; null: nothing does
};

struct Found {
  VectorX u;             ///< the best point, also where the search ended for lack of digits; finite
  double value = 0;      ///< of the objective there; NaN if it cannot be computed
  bool stopped = false;  ///< evaluations or seconds ran out
};

/// @param method slsqp, auglag, cobyla, bobyqa, sbplx; the last two disregard constraints
Found search_locally(const std::string& method, const Program& program, const VectorX& start,
                     const SearchLimits& limits);

/// Constraints are disregarded. The same seed gives the same result.
/// @param method direct, crs, isres, esch, mlsl
/// @param gradients the objective has them
Found search_globally(const std::string& method, const Program& program, const VectorX& start,
                      const SearchLimits& limits, std::uint64_t seed, bool gradients);

/// The method asks for gradients.
bool wants_gradients(const std::string& local_method);

}  // namespace balance::designing
