#include "balance/motion/study/search_options.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::study {
namespace {

void require(bool condition, const std::string& what) {
  if (!condition) throw std::invalid_argument(what);
}

void require_among(const std::vector<std::string>& names, const std::string& name, const char* search) {
  std::string list;
  for (const std::string& candidate : names) list += (list.empty() ? "" : ", ") + candidate;
  require(std::find(names.begin(), names.end(), name) != names.end(),
          std::string("the ") + search + " search must be one of " + list);
}

}  // namespace

const std::vector<std::string>& global_methods() {
  static const std::vector<std::string> names = {"direct", "crs", "isres", "esch", "mlsl"};
  return names;
}

const std::vector<std::string>& local_methods() {
  static const std::vector<std::string> names = {"auto", "slsqp", "auglag", "cobyla", "bobyqa", "sbplx"};
  return names;
}

void SearchOptions::validate() const {
  require_among(global_methods(), global, "global");
  require_among(local_methods(), local, "local");
  require(max_restarts >= 1 && max_restarts <= 10000, "the number of restarts must lie between 1 and 10000");
  require(max_evaluations >= 1 && max_evaluations <= 100000000, "the number of evaluations must lie between 1 and 1e8");
  require(max_time > 0 && std::isfinite(max_time), "the search's time must be positive");
}

}  // namespace balance::study
