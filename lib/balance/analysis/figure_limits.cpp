#include "balance/analysis/figure_limits.hpp"

#include "balance/analysis/objective.hpp"

#include <algorithm>

namespace balance {

std::vector<DesignLimit> build_design_limits(const DesignSpace& space, const std::vector<FigureLimit>& limits,
                                             const VectorX& start, const FreeSprings& loose) {
  std::vector<DesignLimit> built;
  for (const FigureLimit& limit : limits)
    built.push_back({limit.text, build_objective(space, limit.terms, start, loose), limit.is_lower, limit.bound});
  return built;
}

namespace {

/// A root of a mean square is as cheap from all samples; of a peak each is an inequality.
FigureSampling samples_for(const FigureLimit& limit) {
  const bool peak = std::any_of(limit.terms.begin(), limit.terms.end(),
                                [](const ObjectiveTerm& term) { return term.figure == Statistic::peak; });
  return peak ? FigureSampling::coarse : FigureSampling::full;
}

}  // namespace

std::function<std::optional<std::vector<ConvexLimit>>(const VectorX& x)> build_convex_limits(
    const DesignSpace& space, const std::vector<FigureLimit>& limits, const FreeSprings& loose, int& known) {
  using Figures = std::function<std::optional<std::vector<AffineFigure>>(const VectorX&)>;
  std::vector<std::pair<Figures, double>> built;
  for (const FigureLimit& limit : limits)
    if (!limit.is_lower)
      if (Figures figures = build_convex_terms(space, limit.terms, loose, samples_for(limit)))
        built.emplace_back(std::move(figures), limit.bound);
  known = static_cast<int>(built.size());
  if (built.empty()) return {};
  return [built](const VectorX& x) -> std::optional<std::vector<ConvexLimit>> {
    std::vector<ConvexLimit> all;
    for (const auto& [figures_at, bound] : built) {
      auto figures = figures_at(x);
      if (!figures) return std::nullopt;
      all.push_back({std::move(*figures), bound});
    }
    return all;
  };
}

}  // namespace balance
