#include "balance/mechanics/results/torque_distribution_record.hpp"

#include "balance/mechanics/results/result.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace balance::results {

namespace {

constexpr double excess_tolerance = 1e-9;  // of effort and bound: smaller excesses are round-off

/// Finds the excess of one actuator.
class ExcessSearch {
 public:
  ExcessSearch(int actuator, const model::EffortShare& share)
      : lower_(share.lower_bound()), upper_(share.upper_bound()) {
    found_.actuator = actuator;
  }

  void add(double time, double effort) {
    if (lower_) add(time, effort, *lower_, *lower_ - effort);
    if (upper_) add(time, effort, *upper_, effort - *upper_);
  }

  const BoundExcess& found() const { return found_; }

 private:
  void add(double time, double effort, double bound, double excess) {
    if (!(excess > excess_tolerance * (std::abs(effort) + std::abs(bound)))) return;
    found_.first_time = found_.excess > 0 ? std::min(found_.first_time, time) : time;
    found_.last_time = found_.excess > 0 ? std::max(found_.last_time, time) : time;
    if (excess <= found_.excess) return;
    found_.excess = excess, found_.time = time, found_.effort = effort, found_.bound = bound;
  }

  std::optional<double> lower_, upper_;
  BoundExcess found_;
};

std::string describe(const BoundExcess& excess, const RunResult& result) {
  const auto a = static_cast<std::size_t>(excess.actuator);
  const std::string& unit = result.actuator_units[a];
  char text[320];
  std::snprintf(text, sizeof text,
                "torque_distribution: %s exceeds its bound of %.6g %s by up to %.6g %s, at t = %.6g s",
                result.actuator_names[a].c_str(), excess.bound, unit.c_str(), excess.excess, unit.c_str(), excess.time);
  std::string note = text;
  if (excess.first_time < excess.last_time) {
    std::snprintf(text, sizeof text, " (between %.6g s and %.6g s)", excess.first_time, excess.last_time);
    note += text;
  }
  return note;
}

}  // namespace

void record_torque_distribution(const Mechanism& mechanism, const RunResult& intermediate, std::size_t count,
                                EffortOrigin origin, RunResult& result) {
  if (!mechanism.torque_distribution) return;
  result.torque_distribution.emplace().distribution = *mechanism.torque_distribution;
  const std::vector<model::EffortShare>& shares = mechanism.torque_distribution->shares;
  for (std::size_t a = 0; a < shares.size(); ++a) {
    ExcessSearch search(static_cast<int>(a), shares[a]);
    const auto add_rows = [&](const RunResult& rows, Eigen::Index row_count) {
      for (Eigen::Index k = 0; k < row_count; ++k)
        search.add(rows.time[k], rows.torque(k, static_cast<Eigen::Index>(a)));
    };
    add_rows(result, result.torque.rows());
    add_rows(intermediate, static_cast<Eigen::Index>(count));
    if (!(search.found().excess > 0)) continue;
    result.torque_distribution->excesses.push_back(search.found());
    result.outcome.notes.push_back(
        describe(search.found(), result) +
        (origin == EffortOrigin::motion ? "; no efforts that make this motion keep all bounds there" : ""));
  }
}

}  // namespace balance::results
