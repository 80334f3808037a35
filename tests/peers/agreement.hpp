#pragma once
/// How far a peer's results are from balance's.

#include "peer.hpp"
#include "peer_case.hpp"

#include <optional>

namespace balance::peers {

/// Largest differences over all samples of a run, relative to the largest magnitude of the same quantity in it.
struct Agreement {
  double efforts = 0;
  std::optional<double> ground_force, ground_moment;  ///< none if the peer does not give them
  double closure = 0;       ///< violation of the cut joints' equations by balance's coordinates [rad or m]
  double closure_rate = 0;  ///< the same of rates, relative to the largest rate
};

/// @throws NotComparable if the efforts are not unique
Agreement compare_with_peer(const PeerCase& subject, Peer& peer);

}  // namespace balance::peers
