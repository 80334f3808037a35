#include "balance/model/coupling_roots.hpp"

#include "balance/base/number.hpp"

#include <stdexcept>

namespace balance {

template <class T>
std::vector<CouplingRootOf<T>> coupling_roots(const MechanismOf<T>& mechanism) {
  std::vector<const CouplingOf<T>*> coupling_of(mechanism.coordinates.size(), nullptr);
  for (const CouplingOf<T>& coupling : mechanism.couplings)
    if (coupling_of[coupling.follower] == nullptr) coupling_of[coupling.follower] = &coupling;
  std::vector<CouplingRootOf<T>> roots;
  for (int c = 0; c < static_cast<int>(mechanism.coordinates.size()); ++c) {
    CouplingRootOf<T> root{c};
    std::size_t steps = 0;
    for (const CouplingOf<T>* next = coupling_of[c]; next != nullptr; next = coupling_of[root.coordinate]) {
      if (++steps > mechanism.couplings.size()) throw std::invalid_argument("couplings follow each other in a circle");
      root.offset += root.ratio * next->offset;
      root.ratio *= next->ratio;
      root.coordinate = next->leader;
    }
    roots.push_back(root);
  }
  return roots;
}

template std::vector<CouplingRootOf<Number>> coupling_roots<Number>(const MechanismOf<Number>&);

}  // namespace balance
