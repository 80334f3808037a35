#pragma once
/// Options of a search.

#include <cstdint>
#include <string>
#include <vector>

namespace balance::study {

/// Valid values of SearchOptions::global and SearchOptions::local.
const std::vector<std::string>& global_methods();
const std::vector<std::string>& local_methods();

/// Options for problems without a direct solution.
struct SearchOptions {
  std::string global = "crs";   ///< one of global_methods()
  std::string local = "auto";   ///< one of local_methods(); auto: slsqp if gradients exist, else cobyla
  std::uint64_t seed = 1;       ///< of restarts and global search
  int max_restarts = 40;        ///< of Gauss–Newton, 1…10000
  int max_evaluations = 20000;  ///< of a global search, 1…10^8; a twentieth if each one is a simulation
  double max_time = 60;         ///< computing time of one design in total [s], positive

  /// @throws std::invalid_argument if an option is out of range
  void validate() const;
};

}  // namespace balance::study
