#pragma once
/// What free numbers change in a spec: the rest need not be read again.

#include "balance/spec/node.hpp"
#include "balance/spec/parameters.hpp"

#include <set>
#include <string>

namespace balance::read {

/// What depends on a free number, or might.
struct OpenParts {
  std::set<std::string> parameters;
  /// Those that share a list come together: `ground` and `bodies`, `counterweights` and `payloads`, `motion` and `trajectories`.
  std::set<std::string> sections;
};
OpenParts find_open_parts(const Node& root, const Parameters::Overrides& overrides);

}  // namespace balance::read
