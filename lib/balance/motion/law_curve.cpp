#include "balance/motion/law_curve.hpp"

#include <algorithm>
#include <vector>

namespace balance {
namespace {

constexpr int curve_pieces = 400;  // of the duration

}  // namespace

void trace_law(const Schedule& schedule, PhasePlane& plane) {
  const double duration = schedule.duration();
  std::vector<std::pair<double, Side>> moments;
  for (int k = 0; k <= curve_pieces; ++k)
    moments.emplace_back(k == curve_pieces ? duration : duration * k / curve_pieces,
                         k == curve_pieces ? Side::before : Side::after);
  for (const double jump : schedule.jumps()) {
    moments.emplace_back(jump, Side::before);
    moments.emplace_back(jump, Side::after);
  }
  std::sort(moments.begin(), moments.end());
  const auto count = static_cast<Eigen::Index>(moments.size());
  plane.time.resize(count), plane.place.resize(count), plane.rate.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto [time, side] = moments[static_cast<std::size_t>(i)];
    const LawValue here = schedule.way(time, side);
    plane.time[i] = time, plane.place[i] = here.s, plane.rate[i] = here.ds;
  }
}

}  // namespace balance
