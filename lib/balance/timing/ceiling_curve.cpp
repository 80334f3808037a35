#include "balance/timing/ceiling_curve.hpp"

#include "balance/timing/allowed.hpp"

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

constexpr double curve_points = 400;        // of the whole path
constexpr double min_points_per_panel = 4;  // of a panel

}  // namespace

void add_maximum_velocity_curve(const PathModel& model, const std::vector<double>& bounds, PhasePlane& plane) {
  AccelerationLimits allowed(model, bounds);
  std::vector<double> place, rate;
  double guess = 0;
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const Panel& panel = model.value.panels()[p];
    const double width = panel.end - panel.begin;
    const int pieces = static_cast<int>(std::max(min_points_per_panel, std::ceil(curve_points * width)));
    for (int k = 0; k <= pieces; ++k) {
      const double s = k == pieces ? panel.end : panel.begin + width * k / pieces;
      allowed.move_to(s, p, p + 1);
      allowed.drop_zero_inertia_rows();
      const VelocityBound here = allowed.max_velocity(guess);
      guess = std::isfinite(here.x) ? here.x : 0;
      if (!place.empty() && s == place.back() && std::sqrt(here.x) == rate.back()) continue;
      place.push_back(s);
      rate.push_back(std::sqrt(here.x));
    }
  }
  plane.mvc_path_parameter = Eigen::Map<const VectorX>(place.data(), static_cast<Eigen::Index>(place.size()));
  plane.mvc_path_rate = Eigen::Map<const VectorX>(rate.data(), static_cast<Eigen::Index>(rate.size()));
}

}  // namespace balance
