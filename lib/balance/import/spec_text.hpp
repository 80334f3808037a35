#pragma once
/// A robot as the text of a spec that people read and change.

#include "balance/import/robot.hpp"

#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

/// A rough value of a coordinate, by its name in the spec.
using AssemblyValue = std::pair<std::string, double>;

struct GeneratedSpec {
  std::string text;
  std::vector<std::pair<std::string, std::string>> renamed;  ///< `link 'a b'` and what it is called in the spec
};

/// @param assembly empty: none is written
GeneratedSpec generate_spec(const ForeignModel& robot, const std::vector<AssemblyValue>& assembly);

/// Whether no body can have this inertia about its centre of mass, as the spec's reader judges it.
bool violates_triangle_inequality(const Matrix3& inertia, SpaceKind space);

}  // namespace balance::foreign
