#include "balance/motion/law_curve.hpp"

#include <algorithm>
#include <vector>

namespace balance {
namespace {

constexpr int phase_plane_intervals = 400;  // of the duration

}  // namespace

void sample_phase_plane(const PrescribedMotion& schedule, PhasePlane& plane) {
  const double duration = schedule.duration();
  std::vector<std::pair<double, Side>> moments;
  for (int k = 0; k <= phase_plane_intervals; ++k)
    moments.emplace_back(k == phase_plane_intervals ? duration : duration * k / phase_plane_intervals,
                         k == phase_plane_intervals ? Side::before : Side::after);
  for (const double jump : schedule.jump_times()) {
    moments.emplace_back(jump, Side::before);
    moments.emplace_back(jump, Side::after);
  }
  std::sort(moments.begin(), moments.end());
  const auto count = static_cast<Eigen::Index>(moments.size());
  plane.time.resize(count), plane.path_parameter.resize(count), plane.path_rate.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto [time, side] = moments[static_cast<std::size_t>(i)];
    const MotionLawValue here = schedule.path_progress(time, side);
    plane.time[i] = time, plane.path_parameter[i] = here.s, plane.path_rate[i] = here.ds;
  }
}

}  // namespace balance
