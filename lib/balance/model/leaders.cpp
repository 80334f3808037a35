#include "balance/model/leaders.hpp"

namespace balance {

bool creates_coupling_cycle(const CouplingGraph& leaders, CoordinateId follower,
                            const std::vector<CoordinateId>& from) {
  std::vector<bool> seen(leaders.size(), false);
  std::vector<CoordinateId> open = from;
  while (!open.empty()) {
    const CoordinateId c = open.back();
    open.pop_back();
    if (c == follower) return true;
    if (seen[static_cast<std::size_t>(c)]) continue;
    seen[static_cast<std::size_t>(c)] = true;
    const std::vector<CoordinateId>& above = leaders[static_cast<std::size_t>(c)];
    open.insert(open.end(), above.begin(), above.end());
  }
  return false;
}

}  // namespace balance
