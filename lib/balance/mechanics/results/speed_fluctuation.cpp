#include "balance/mechanics/results/speed_fluctuation.hpp"

#include "balance/foundation/numerics/bracketed_root.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/results/orders.hpp"
#include "balance/mechanics/results/round_off.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

namespace balance::results {

namespace {

constexpr Eigen::Index max_integrated_orders = 256;
constexpr double root_tolerance = 1e-13;
constexpr double energy_epsilon = 1e-11;   ///< of the mean energy: smaller ranges are round-off
constexpr double fluctuation_at_rest = 2;  ///< of a machine that comes to rest

/// Largest and smallest value of a function with samples that repeat after the last one, by parabolas through three of them.
std::pair<double, double> find_extremes(const VectorX& samples) {
  const Eigen::Index count = samples.size();
  const auto refine = [&](Eigen::Index k) {
    const double before = samples[(k + count - 1) % count], here = samples[k], after = samples[(k + 1) % count];
    const double slope = (after - before) / 2, curvature = after - 2 * here + before;
    return curvature == 0 ? here : here - slope * slope / (2 * curvature);
  };
  return {refine(numerics::max_index(samples)), refine(numerics::min_index(samples))};
}

/// A machine over its period: inertia at the coordinate, and energy but for a constant.
class Machine {
 public:
  Machine(const RunResult& run, Eigen::Index coordinate, const UniformTurning& turning)
      : speed_(std::abs(turning.speed)) {
    const Eigen::Index count = run.time.size() - 1;
    inertia_ = 2 * run.kinetic_energy.col(0).head(count) / (speed_ * speed_);
    mean_torque_ = run.torque.col(0).head(count).mean();
    energy_ = speed_ * speed_ / 2 * inertia_;
    const VectorX angle = run.joint_position.col(coordinate),
                  deviation = run.torque.col(0).head(count).array() - mean_torque_;
    for (Eigen::Index k = 1; k <= std::min(max_integrated_orders, (count - 1) / 2); ++k) {
      const double order = static_cast<double>(k) / turning.turns, weight = 2 / (static_cast<double>(count) * order);
      const Harmonic harmonic(angle, order);
      energy_ -=
          weight * (harmonic.cosine.dot(deviation) * harmonic.sine - harmonic.sine.dot(deviation) * harmonic.cosine);
    }
  }

  double mean_torque() const { return mean_torque_; }
  double mean_energy() const { return speed_ * speed_ / 2 * mean_inertia(); }
  double mean_inertia() const { return inertia_.mean(); }
  double energy_range() const {
    const auto [largest, smallest] = find_extremes(energy_);
    return largest - smallest;
  }

  /// Largest and smallest speed with a flywheel; std::nullopt if it would come to rest.
  std::optional<std::pair<double, double>> find_speeds(double flywheel) const {
    const auto mean_excess = [&](double constant) {
      const auto [largest, smallest] = find_extremes(speeds(constant, flywheel));
      return (largest + smallest) / 2 - speed_;
    };
    const double low = -numerics::min_coefficient(energy_), at_low = mean_excess(low);
    if (at_low >= 0) return std::nullopt;
    double step = speed_ * speed_ * (mean_inertia() + flywheel), at_high = mean_excess(low + step);
    while (at_high < 0) at_high = mean_excess(low + (step *= 2));
    return find_extremes(
        speeds(numerics::find_bracketed_root(mean_excess, low, low + step, at_low, at_high, root_tolerance), flywheel));
  }

  double coefficient(double flywheel) const {
    const auto speeds = find_speeds(flywheel);
    return speeds ? 2 * (speeds->first - speeds->second) / (speeds->first + speeds->second) : fluctuation_at_rest;
  }

  /// Inertia of the smallest flywheel for a coefficient.
  double find_flywheel(double stated) const {
    const auto excess = [&](double flywheel) { return coefficient(flywheel) - stated; };
    const double without = excess(0);
    if (without <= 0) return 0;
    double high = std::max(mean_inertia(), energy_range() / (stated * speed_ * speed_)), at_high = excess(high);
    while (at_high > 0) at_high = excess(high *= 2);
    return numerics::find_bracketed_root(excess, 0, high, without, at_high, root_tolerance);
  }

 private:
  VectorX speeds(double constant, double flywheel) const {
    return (2 * (energy_.array() + constant).max(0) / (inertia_.array() + flywheel)).sqrt();
  }

  double speed_, mean_torque_ = 0;
  VectorX inertia_, energy_;
};

}  // namespace

std::optional<SpeedFluctuation> analyse_speed_fluctuation(const RunResult& run, const UniformTurning& turning,
                                                          std::optional<double> stated) {
  const auto refuse = [&](const char* reason) {
    if (stated) throw std::invalid_argument(reason);
    return std::nullopt;  // nobody asked
  };
  if (run.actuator_names != std::vector<std::string>{turning.coordinate})
    return refuse("the speed fluctuates by its own dynamics only if a single actuator turns at constant speed");
  const auto coordinate = std::find(run.coordinate_names.begin(), run.coordinate_names.end(), turning.coordinate);
  const Machine machine(run, coordinate - run.coordinate_names.begin(), turning);
  if (!(machine.mean_inertia() > 0)) return refuse("without moving masses no speed fluctuates");
  const auto speeds = machine.find_speeds(0);
  if (!speeds && !stated) return std::nullopt;  // the machine would come to rest
  SpeedFluctuation result;
  result.mean_torque = suppress_round_off(column_round_off(run, &RunResult::torque, 0), machine.mean_torque());
  result.energy_range = suppress_round_off(energy_epsilon * machine.mean_energy(), machine.energy_range());
  if (speeds) {
    result.largest = speeds->first, result.smallest = speeds->second;
    result.coefficient = machine.coefficient(0);
  }
  if (stated) result.flywheel = machine.find_flywheel(*stated);
  return result;
}

}  // namespace balance::results
