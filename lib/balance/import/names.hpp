#pragma once
/// Names that a spec can have, for names that a file has.

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

/// One namespace of a spec: bodies, joints, the points of a body.
class NameAllocator {
 public:
  /// @param reserved names that have a meaning of their own
  explicit NameAllocator(std::set<std::string> reserved) : taken_(std::move(reserved)) {}

  /// The name itself if a spec can have it and it is not taken, else one like it.
  std::string allocate(const std::string& wanted);

 private:
  std::set<std::string> taken_;
  std::map<std::string, int> next_;  ///< number to try behind a name
};

/// Characters that a name cannot have become `_`, and what no name has room for is cut off.
std::string sanitise_name(const std::string& wanted);

}  // namespace balance::foreign
