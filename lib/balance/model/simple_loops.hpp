#pragma once
/// The loops of a mechanism one by one: closed chains of bodies in which none occurs twice.

#include "balance/model/mechanism.hpp"

#include <cstddef>
#include <vector>

namespace balance {

struct LoopStep {
  JointId joint = 0;
  bool forward = true;  ///< walked from its first body to its second
};

/// A loop, in the order in which it is walked.
using SimpleLoop = std::vector<LoopStep>;

/// @param most loops that are listed, the shortest first
std::vector<SimpleLoop> list_simple_loops(const Mechanism& mechanism, std::size_t most);

}  // namespace balance
