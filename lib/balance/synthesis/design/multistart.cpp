#include "balance/synthesis/design/multistart.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/synthesis/design/nlopt_search.hpp"
#include "balance/synthesis/design/variable_classification.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::design {

namespace {

/// Starts closer together than this count as one.
constexpr double duplicate_start_tolerance = 1e-3;

class MultistartSearch {
 public:
  MultistartSearch(const MultistartSettings& settings, SearchBudget& budget) : settings_(settings), budget_(budget) {
    best_.value = std::numeric_limits<double>::quiet_NaN();
    best_.u = settings.starts.front();
  }

  MultistartResult run() {
    std::vector<std::pair<double, VectorX>> evaluated;
    for (const VectorX& start : settings_.starts) {
      if (!evaluated.empty() && budget_.is_spent()) break;
      if (const double value = evaluate(start); std::isfinite(value)) evaluated.emplace_back(value, start);
    }
    if (evaluated.empty() || settings_.starts.front().size() == 0) return best_;
    std::stable_sort(evaluated.begin(), evaluated.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<VectorX> used;
    for (const auto& one : evaluated) {
      const VectorX& start = one.second;
      if (static_cast<int>(used.size()) >= settings_.max_local_searches || budget_.is_spent()) break;
      if (std::any_of(used.begin(), used.end(),
                      [&](const VectorX& u) { return (u - start).norm() < duplicate_start_tolerance; }))
        continue;
      used.push_back(start);
      search_from(start);
    }
    refine_by_coordinates();
    return best_;
  }

 private:
  double evaluate(const VectorX& u) {
    ++budget_.evaluations;
    const double value = settings_.objective(u);
    if (std::isfinite(value) && !(best_.value <= value)) best_ = {u, value};
    return value;
  }

  void search_from(const VectorX& start) {
    NonlinearProgram program;
    program.size = static_cast<int>(start.size());
    program.bound = settings_.bound;
    program.objective = [this](const VectorX& u, VectorX*) { return evaluate(u); };
    StoppingCriteria limits;
    limits.max_evaluations = settings_.max_evaluations;
    limits.max_time = budget_.remaining_time();
    limits.stop = budget_.make_stop_callback();
    limits.relative_tolerance = 1e-7;
    limits.initial_step = settings_.initial_step;
    ++budget_.local_searches;
    if (search_locally(settings_.method, program, start, limits).is_budget_exhausted && budget_.is_spent())
      budget_.stopped = true;
  }

  /// Searches one coordinate after the other with a parabola through three points; reduces the step if none improves.
  void refine_by_coordinates() {
    const auto n = best_.u.size();
    for (double step = settings_.initial_step; step > settings_.min_step && !budget_.is_spent();) {
      const MultistartResult before = best_;
      for (Eigen::Index i = 0; i < n && !budget_.is_spent(); ++i) search_coordinate(i, step);
      const double decrease = before.value - best_.value;
      if (!(decrease > 1e-12 * std::abs(before.value))) {
        step /= 4;
        continue;
      }
      evaluate(clip(best_.u + (best_.u - before.u)));
      if (!(decrease > 1e-5 * std::abs(before.value))) step /= 4;
    }
  }

  void search_coordinate(Eigen::Index i, double step) {
    const MultistartResult middle = best_;
    const auto moved = [&](double offset) {
      VectorX u = middle.u;
      u[i] += offset;
      return clip(u);
    };
    const VectorX ahead = moved(step), behind = moved(-step);
    const double up = ahead == middle.u ? NAN : evaluate(ahead), down = behind == middle.u ? NAN : evaluate(behind);
    const double curvature = up - 2 * middle.value + down;
    const double a = ahead[i] - middle.u[i], b = middle.u[i] - behind[i];
    if (!std::isfinite(curvature) || a != b || !(curvature > 0)) return;
    const double vertex = 0.5 * step * (down - up) / curvature;
    if (std::abs(vertex) > 1e-3 * step && std::abs(vertex) < step) evaluate(moved(vertex));
  }

  VectorX clip(const VectorX& u) const { return u.cwiseMax(-settings_.bound).cwiseMin(settings_.bound); }

  const MultistartSettings& settings_;
  SearchBudget& budget_;
  MultistartResult best_;
};

}  // namespace

MultistartResult search_multistart(const MultistartSettings& settings, SearchBudget& budget) {
  return MultistartSearch(settings, budget).run();
}

std::vector<VectorX> low_discrepancy_points(int count, int size, std::uint64_t seed) {
  // Multiples of the powers of 1/root with root^(n+1) = root + 1, for n = 1 the golden ratio.
  double root = 1.5;
  for (int k = 0; k < 40; ++k) root = elementary::pow(1 + root, 1.0 / (size + 1));
  numerics::UniformRandom random(seed);
  const VectorX shift = random.sample_point(size, 0, 1);
  std::vector<VectorX> points;
  for (int k = 1; k <= count; ++k) {
    VectorX u(size);
    for (int i = 0; i < size; ++i) {
      double whole = 0;
      u[i] = 2 * std::modf(shift[i] + k * elementary::pow(root, -(i + 1)), &whole) - 1;
    }
    points.push_back(u);
  }
  return points;
}

}  // namespace balance::design
