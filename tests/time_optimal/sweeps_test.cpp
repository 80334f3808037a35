// The second route to the least duration: limits in the middle of cells on a graded grid, one sweep backwards for the speeds from which
// the end can be reached, one forwards as fast as they allow (reachability analysis, Pham and Pham 2018). Coefficients come from runs
// in the natural formulation by laws in closed form. Nothing of it knows arcs, ceilings or places without inertia.

#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

using namespace balance;
using namespace balance::time_optimal;

namespace {

constexpr int cells = 600;

struct Row {
  double a, b, c, bound;
};

/// Torques by a law: one row per sample.
Samples torques(const Mechanism& mechanism, Trajectory trajectory, MotionLawKind law, double duration, long samples) {
  trajectory.law = {.kind = law};
  trajectory.duration = duration;
  trajectory.samples = samples;
  const RunResult run = verification::simulate_natural(mechanism, trajectory);
  REQUIRE(run.outcome.status == MotionStatus::done);
  return run.torque;
}

/// The rows at a place of the path. At constant speed the torque is b + c in one second, b/4 + c in two; by bang-bang in one second
/// it is ± 4a + 8 min(s, 1 − s) b + c.
class Rows {
 public:
  Rows(const Mechanism& mechanism, const Trajectory& trajectory, const std::vector<double>& bounds) : bounds_(bounds) {
    constexpr long count = 2001;
    const Samples once = torques(mechanism, trajectory, MotionLawKind::uniform, 1, count);
    const Samples twice = torques(mechanism, trajectory, MotionLawKind::uniform, 2, count);
    const Samples bang = torques(mechanism, trajectory, MotionLawKind::bang_bang, 1, count);
    std::vector<double> even, graded;
    for (long k = 0; k < count; ++k) {
      const double t = static_cast<double>(k) / (count - 1);
      even.push_back(t);
      graded.push_back(t < 0.5 ? 2 * t * t : 1 - 2 * (1 - t) * (1 - t));
    }
    b_.emplace(even, Samples((once - twice) * (4.0 / 3)), numerics::SplineEnd::not_a_knot);
    c_.emplace(even, Samples((4 * twice - once) / 3), numerics::SplineEnd::not_a_knot);
    Samples a(count, once.cols());
    for (long k = 0; k < count; ++k) {
      const double s = graded[static_cast<std::size_t>(k)];
      const bool first = k < count / 2;  // a sample at a jump holds what comes after it
      const VectorX rest = 8 * std::min(s, 1 - s) * at(*b_, s) + at(*c_, s);
      a.row(k) = (first ? 0.25 : -0.25) * (bang.row(k).transpose() - rest).transpose();
    }
    a_.emplace(graded, a, numerics::SplineEnd::not_a_knot);
  }

  std::vector<Row> operator()(double s) const {
    const VectorX a = at(*a_, s), b = at(*b_, s), c = at(*c_, s);
    std::vector<Row> rows;
    for (Eigen::Index r = 0; r < a.size(); ++r)
      rows.push_back({a[r], b[r], c[r], bounds_[static_cast<std::size_t>(r)]});
    return rows;
  }

 private:
  static VectorX at(const numerics::CubicSpline& spline, double s) {
    VectorX value(spline.size()), first = value, second = value;
    spline.at(s, value, first, second);
    return value;
  }

  std::vector<double> bounds_;
  std::optional<numerics::CubicSpline> a_, b_, c_;
};

struct Cell {
  double width;
  std::vector<Row> rows;

  /// The x at its end that the limits allow from x at its start, with constant s'' = (y − x)/2w and the limits asked in the middle.
  std::pair<double, double> reach(double x) const {
    double low = 0, high = INFINITY;
    for (const Row& row : rows) {
      const double p = row.b / 2 - row.a / (2 * width), q = row.b / 2 + row.a / (2 * width);
      const double first = (-row.bound - row.c - p * x) / q, second = (row.bound - row.c - p * x) / q;
      low = std::max(low, std::min(first, second));
      high = std::min(high, std::max(first, second));
    }
    return {low, high};
  }
};

double sweep(const Rows& rows) {
  std::vector<double> s;
  for (int i = 0; i <= cells; ++i) s.push_back(std::pow(std::sin(std::numbers::pi * i / (2 * cells)), 2));
  std::vector<Cell> grid;
  for (int i = 0; i < cells; ++i) grid.push_back({s[i + 1] - s[i], rows((s[i] + s[i + 1]) / 2)});
  std::vector<double> most(cells + 1, 0);
  for (int i = cells - 1; i >= 0; --i) {
    const auto allowed = [&](double x) {
      const auto [low, high] = grid[i].reach(x);
      return low <= std::min(high, most[i + 1]);
    };
    double low = 0, high = 1;
    while (allowed(high)) high *= 2;
    for (int halving = 0; halving < 60; ++halving) (allowed((low + high) / 2) ? low : high) = (low + high) / 2;
    most[i] = low;
  }
  double x = 0, duration = 0;
  for (int i = 0; i < cells; ++i) {
    const double next = std::max(0.0, std::min(most[i + 1], grid[i].reach(x).second));
    duration += 2 * grid[i].width / (std::sqrt(x) + std::sqrt(next));
    x = next;
  }
  return duration;
}

void compare(const std::string& config, const std::vector<trajectory::MotionLimit>& limits,
             const std::vector<double>& bounds) {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + config);
  Trajectory trajectory = study.trajectories.front();
  const double swept = sweep(Rows(study.mechanism, trajectory, bounds));
  trajectory.law.kind = MotionLawKind::time_optimal;
  trajectory.limits = limits;
  const ResolvedTrajectory timed = resolve_trajectory(study.mechanism, trajectory);
  INFO(timed.outcome.reason);
  REQUIRE(timed.outcome.status == MotionStatus::done);
  // the sweeps chatter beside places without inertia and miss switches by up to a cell
  CHECK(timed.trajectory.duration == doctest::Approx(swept).epsilon(2e-4));
}

}  // namespace

TEST_CASE("two sweeps on a grid find the fastest duration, too") {
  compare("3rrr.yaml", {{"torque", 60}}, {60, 60, 60});
  compare("3rrr.yaml", {{"torque", 20}}, {20, 20, 20});
  compare("5r.yaml", {{"torque", 12}}, {12, 12});
  compare("rr.yaml", {{"torque[R1]", 40}, {"torque[R2]", 10}}, {40, 10});
  compare("rr.yaml", {{"torque[R1]", 100}, {"torque[R2]", 10}}, {100, 10});
}
