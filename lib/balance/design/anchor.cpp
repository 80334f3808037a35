#include "balance/design/geometric.hpp"
#include "balance/design/restricted.hpp"
#include "balance/design/seek.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Points of the box from which an anchor is looked for.
constexpr int max_start_samples = 200;
/// Part of half a length's range within which it may be meant to be a special one.
constexpr double length_ratio_tolerance = 1e-5;

}  // namespace

std::optional<VectorX> find_feasible_start(const SolverContext& context, std::string& reason) {
  const auto good = [&](const VectorX& u, std::string& why) {
    why = context.infeasibility_reason(u);
    if (!why.empty()) return false;
    const Conditions conditions = context.conditions_at(u);
    if (conditions.status != ConditionsStatus::done) why = conditions.reason;
    return conditions.status == ConditionsStatus::done;
  };
  const VectorX start = context.scaling.start();
  if (good(start, reason)) return start;
  // nearer ones first, the other numbers as they are
  const std::vector<int> lengths = geometric_variables(context);
  const auto points =
      low_discrepancy_points(max_start_samples, static_cast<int>(lengths.size()), context.problem.search.seed);
  for (std::size_t k = 0; k < points.size() && !context.budget.is_spent(); ++k) {
    VectorX u = start;
    const double part = static_cast<double>(k + 1) / static_cast<double>(points.size());
    for (std::size_t i = 0; i < lengths.size(); ++i)
      u[lengths[i]] = std::clamp(
          start[lengths[i]] + part * (points[k][static_cast<Eigen::Index>(i)] - start[lengths[i]]), -1.0, 1.0);
    std::string why;
    if (good(u, why)) return u;
  }
  return std::nullopt;
}

std::optional<VectorX> snap_to_length_ratios(const SolverContext& context, const VectorX& u) {
  const VectorX numbers = collect_geometry(context.mechanism(u), context.options.loose_springs);
  const VectorX x = context.scaling.to_variables(u);
  VectorX moved = u;
  for (const int i : geometric_variables(context)) {
    const double half = context.scaling.half_width()[i];
    double nearest = length_ratio_tolerance * half;
    if (!(half > 0)) continue;
    for (const double other : numbers)
      for (const double ratio : {1.0, 2.0, 0.5, 1.5, 2.0 / 3, 3.0, 1.0 / 3, 4.0 / 3, 0.75}) {
        const double off = std::abs(std::abs(other) * ratio - std::abs(x[i]));
        // the number itself is among them
        if (off >= nearest || off <= 1e-15 * std::abs(x[i])) continue;
        nearest = off;
        moved[i] =
            std::clamp((std::copysign(std::abs(other) * ratio, x[i]) - context.scaling.centre()[i]) / half, -1.0, 1.0);
      }
  }
  return moved == u ? std::nullopt : std::optional<VectorX>(moved);
}

}  // namespace balance::design
