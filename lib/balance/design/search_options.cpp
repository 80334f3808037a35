#include "balance/design/nlopt_search.hpp"
#include "balance/design/problem.hpp"

#include <cmath>
#include <stdexcept>

namespace balance {

void SearchOptions::validate() const {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(what);
  };
  require(designing::is_global_method(global), "the global search is one of direct, crs, isres, esch, mlsl");
  require(designing::is_local_method(local), "the local search is one of auto, slsqp, auglag, cobyla, bobyqa, sbplx");
  require(restarts >= 1 && restarts <= 10000, "the number of restarts lies between 1 and 10000");
  require(evaluations >= 1 && evaluations <= 100000000, "the number of evaluations lies between 1 and 1e8");
  require(seconds > 0 && std::isfinite(seconds), "the search's time must be positive");
}

}  // namespace balance
