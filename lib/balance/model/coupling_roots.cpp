#include "balance/model/coupling_roots.hpp"

#include <stdexcept>

namespace balance {

std::vector<CouplingRoot> coupling_roots(const Mechanism& mechanism) {
  std::vector<const Coupling*> coupling_of(mechanism.coordinates.size(), nullptr);
  for (const Coupling& coupling : mechanism.couplings)
    if (coupling_of[coupling.follower] == nullptr) coupling_of[coupling.follower] = &coupling;
  std::vector<CouplingRoot> roots;
  for (int c = 0; c < static_cast<int>(mechanism.coordinates.size()); ++c) {
    CouplingRoot root{c};
    std::size_t steps = 0;
    for (const Coupling* next = coupling_of[c]; next != nullptr; next = coupling_of[root.coordinate]) {
      if (++steps > mechanism.couplings.size()) throw std::invalid_argument("couplings follow each other in a circle");
      root.offset += root.ratio * next->offset;
      root.ratio *= next->ratio;
      root.coordinate = next->leader;
    }
    roots.push_back(root);
  }
  return roots;
}

}  // namespace balance
