#include "balance/analysis/figure_limits.hpp"

#include "balance/analysis/objective.hpp"

namespace balance {

std::vector<DesignLimit> build_limits(const DesignSpace& space, const std::vector<FigureLimit>& limits,
                                      const VectorX& start, const LooseSprings& loose) {
  std::vector<DesignLimit> built;
  for (const FigureLimit& limit : limits)
    built.push_back({limit.text, build_objective(space, limit.terms, start, loose), limit.at_least, limit.bound});
  return built;
}

}  // namespace balance
