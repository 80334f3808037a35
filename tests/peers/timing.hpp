#pragma once
/// How long the actuator efforts of given states take, all libraries in one run.

#include "peer.hpp"
#include "peer_case.hpp"

#include <vector>

namespace balance::peers {

/// Prints the machine and a table in Markdown: microseconds per state and, for peers, the ratio to balance.
void print_times(const std::vector<PeerCase>& subjects, const std::vector<PeerLibrary>& libraries);

}  // namespace balance::peers
