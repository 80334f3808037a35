#include "balance/timing/ceiling_curve.hpp"

#include "balance/timing/allowed.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

constexpr double ceiling_places = 400;  // of the whole path
constexpr double least_pieces = 4;      // of a panel

}  // namespace

void add_ceiling(const PathModel& model, const std::vector<double>& bounds, PhasePlane& plane) {
  Allowed allowed(model, bounds);
  std::vector<double> place, rate;
  double guess = 0;
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const Panel& panel = model.value.panels()[p];
    const double width = panel.end - panel.begin;
    const int pieces = static_cast<int>(std::max(least_pieces, std::ceil(ceiling_places * width)));
    for (int k = 0; k <= pieces; ++k) {
      const double s = k == pieces ? panel.end : panel.begin + width * k / pieces;
      allowed.go(s, p, p + 1);
      allowed.drop_inertia();
      const Ceiling here = allowed.ceiling(guess);
      guess = std::isfinite(here.x) ? here.x : 0;
      if (!place.empty() && s == place.back() && std::sqrt(here.x) == rate.back()) continue;
      place.push_back(s);
      rate.push_back(std::sqrt(here.x));
    }
  }
  plane.ceiling_place = Eigen::Map<const VectorX>(place.data(), static_cast<Eigen::Index>(place.size()));
  plane.ceiling = Eigen::Map<const VectorX>(rate.data(), static_cast<Eigen::Index>(rate.size()));
}

}  // namespace balance
