#pragma once
/// Short names for runs that come from files.

#include <string>
#include <vector>

namespace balance {

/// Where a run is stored.
struct RunLocation {
  std::string path;   ///< of the file
  std::string group;  ///< in a file with several runs; "": the file is one run
};

/// One name per run, no two alike: the file's stem, or the group; where that is not enough with the file or the folder before it,
/// and where nothing tells them apart with a number behind it. Only the first may be called `base`.
std::vector<std::string> make_run_names(const std::vector<RunLocation>& places);

}  // namespace balance
