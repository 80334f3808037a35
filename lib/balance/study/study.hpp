#pragma once
/// Everything that one spec asks for, complete and validated.

#include "balance/model/mechanism.hpp"
#include "balance/motion/trajectory.hpp"

#include <string>
#include <vector>

namespace balance {

/// A number that the designer left open: `{free: [lower, upper], start: …}`. The study holds its start value.
struct FreeNumber {
  std::string path;  ///< key path in the spec, `counterweights.cw2.mass`, or the parameter's: `parameters.x`
  double lower = 0, upper = 0, start = 0;
};

/// What `design:` asks for.
struct DesignRequest {
  std::vector<std::string> goals;
  std::string minimize;  ///< the YAML text of the objective as written; empty if none
};

struct Study {
  Mechanism mechanism;
  std::vector<Trajectory>
      trajectories;  ///< declared ones and the built-in `cycloid` and `bang-bang`; empty without `motion`
  std::vector<FreeNumber> free_numbers;
  DesignRequest design;
  std::string spec_file;              ///< as named by the user
  std::string spec_text;              ///< as read
  std::vector<std::string> warnings;  ///< legal but suspicious
};

}  // namespace balance
