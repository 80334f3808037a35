#pragma once
/// How much of a search is asked for.

#include <cstdint>
#include <string>
#include <vector>

namespace balance {

/// The words that SearchOptions::global and SearchOptions::local may be.
const std::vector<std::string>& global_methods();
const std::vector<std::string>& local_methods();

/// How to search where the solution does not follow directly.
struct SearchOptions {
  std::string global = "crs";   ///< one of global_methods()
  std::string local = "auto";   ///< one of local_methods(); auto: slsqp where gradients exist, else cobyla
  std::uint64_t seed = 1;       ///< of restarts and global search
  int max_restarts = 40;        ///< of Gauss–Newton, 1…10000
  int max_evaluations = 20000;  ///< of a global search, 1…10^8; a twentieth where every one is a simulation
  double max_time = 60;         ///< of computing, for everything that one design does, positive

  /// @throws std::invalid_argument
  void validate() const;
};

}  // namespace balance
