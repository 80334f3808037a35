#include "balance/synthesis/tolerance/tolerance_analysis.hpp"

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/results/term_magnitudes.hpp"
#include "balance/motion/study/study.hpp"
#include "balance/synthesis/tolerance/toleranced_run.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace balance::tolerance {

namespace {

constexpr long max_static_poses = 100'000;
constexpr int max_step_halvings = 30;

/// Efforts at rest in a pose, and their changes by every number's deviation.
struct StaticEfforts {
  VectorX effort;
  MatrixX change;  ///< actuators × numbers
};

class StaticToleranceSearch {
 public:
  StaticToleranceSearch(const DesignSpace& space, const Tolerances& numbers, long steps)
      : numbers_(numbers),
        deviations_(static_cast<Eigen::Index>(numbers.size())),
        inverse_dynamics_(space.start.mechanism),
        steps_(steps) {
    for (Eigen::Index i = 0; i < deviations_.size(); ++i)
      deviations_[i] = numbers[static_cast<std::size_t>(i)].deviation();
    for (std::size_t first = 0; first < numbers.size(); first += numerics::dual_width)
      duals_.push_back(TolerancedDuals(space, numbers, first).mechanism());
    const Mechanism& mechanism = space.start.mechanism;
    for (const std::string& name : inverse_dynamics_.independent())
      for (const Coordinate& coordinate : mechanism.coordinates)
        if (coordinate.name == name && coordinate.kind != CoordinateKind::angle)
          throw std::invalid_argument("the workspace consists of whole turns, but " + name + " slides");
    choose_steps();
    for (const int actuator : mechanism.actuators)
      result_.actuators.push_back(
          {mechanism.coordinates[static_cast<std::size_t>(actuator)].name,
           mechanism.coordinates[static_cast<std::size_t>(actuator)].kind == CoordinateKind::angle ? "N m" : "N", 0, 0,
           VectorX::Zero(size()), VectorX::Zero(deviations_.size())});
    result_.coordinates = inverse_dynamics_.independent();
  }

  StaticTolerance run() {
    scan_grid();
    if (result_.pose_count == result_.unreachable_count) {
      result_.outcome = first_failure_;
      result_.outcome.reason = "no pose of the workspace could be reached and held: " + first_failure_.reason;
      return result_;
    }
    if (exclude_incompatible_parameters()) scan_grid();
    result_.outcome = {MotionStatus::done, 0, "", {}};
    for (std::size_t a = 0; a < result_.actuators.size(); ++a) {
      refine(a);
      zero_round_off(a);
    }
    return result_;
  }

 private:
  Eigen::Index size() const { return inverse_dynamics_.degrees_of_freedom(); }

  void choose_steps() {
    if (steps_ == 0) steps_ = size() <= 2 ? 72 : size() == 3 ? 24 : 8;
    long poses = 1;
    for (Eigen::Index k = 0; k < size(); ++k)
      if ((poses *= steps_) > max_static_poses)
        throw std::invalid_argument("the workspace has too many poses: at most " + std::to_string(max_static_poses));
    poses_ = poses;
  }

  /// Consecutive poses are one step apart, so that loops keep their assembly mode.
  void scan_grid() {
    result_.pose_count = poses_;
    result_.unreachable_count = 0;
    is_evaluated_.assign(result_.actuators.size(), false);
    VectorX q(size());
    for (long pose = 0; pose < poses_; ++pose) {
      long index = pose;
      for (Eigen::Index k = 0; k < size(); ++k, index /= steps_)
        q[k] = 2 * std::numbers::pi * static_cast<double>(index % steps_) / static_cast<double>(steps_);
      const std::optional<StaticEfforts> efforts = evaluate(q);
      if (!efforts) ++result_.unreachable_count;
      for (std::size_t a = 0; efforts && a < result_.actuators.size(); ++a) update_worst(a, q, *efforts);
    }
  }

  std::optional<StaticEfforts> evaluate(const VectorX& q) {
    const VectorX zero = VectorX::Zero(size());
    StaticEfforts efforts;
    efforts.change.resize(static_cast<Eigen::Index>(result_.actuators.size()), deviations_.size());
    for (std::size_t chunk = 0; chunk < duals_.size(); ++chunk) {
      const Expected<StateGradient> gradient =
          derivatives::derivatives(inverse_dynamics_, duals_[chunk], q, zero, zero);
      if (!gradient) {
        if (first_failure_.reason.empty()) first_failure_ = gradient.outcome;
        return std::nullopt;
      }
      efforts.effort = gradient.value.sample.effort;
      const std::size_t first = chunk * numerics::dual_width;
      for (std::size_t i = first;
           i < std::min(first + numerics::dual_width, static_cast<std::size_t>(deviations_.size())); ++i) {
        const auto number = static_cast<Eigen::Index>(i);
        efforts.change.col(number) = deviations_[number] * gradient.value.derivatives[i - first].effort;
        add_incompatible_parameter(gradient.value.closure_gaps[i - first], i);
      }
    }
    return efforts;
  }

  /// Keeps the maximum gap per number and joint.
  void add_incompatible_parameter(const derivatives::ClosureGaps& gaps, std::size_t number) {
    std::vector<IncompatibleParameter> detected;
    add_incompatible_parameters(gaps, number, numbers_[number].path, deviations_[static_cast<Eigen::Index>(number)],
                                inverse_dynamics_.mechanism(), detected);
    for (const IncompatibleParameter& parameter : detected) {
      const auto existing =
          std::find_if(result_.incompatible_parameters.begin(), result_.incompatible_parameters.end(),
                       [&](const IncompatibleParameter& other) {
                         return other.index == number && other.joint == parameter.joint && other.unit == parameter.unit;
                       });
      if (existing == result_.incompatible_parameters.end())
        result_.incompatible_parameters.push_back(parameter);
      else
        existing->gap = std::max(existing->gap, parameter.gap);
    }
  }

  /// @return whether there are any
  bool exclude_incompatible_parameters() {
    for (const IncompatibleParameter& parameter : result_.incompatible_parameters)
      deviations_[static_cast<Eigen::Index>(parameter.index)] = 0;
    return !result_.incompatible_parameters.empty();
  }

  bool update_worst(std::size_t a, const VectorX& q, const StaticEfforts& efforts) {
    const auto row = static_cast<Eigen::Index>(a);
    const double deviation = efforts.change.row(row).norm();
    StaticDeviation& worst = result_.actuators[a];
    if (is_evaluated_[a] && !(deviation > worst.deviation)) return false;
    is_evaluated_[a] = true;
    worst.deviation = deviation;
    worst.effort = efforts.effort[row];
    worst.pose = q;
    worst.shares = efforts.change.row(row).transpose().array().square();
    if (deviation > 0) worst.shares /= deviation * deviation;
    return true;
  }

  /// Maximises along one coordinate after the other, with steps that are halved from sweep to sweep.
  void refine(std::size_t a) {
    double step = std::numbers::pi / static_cast<double>(steps_);
    for (int halving = 0; halving < max_step_halvings; step /= 2, ++halving)
      for (Eigen::Index k = 0; k < size(); ++k)
        for (const double offset : {step, -step}) {
          VectorX q = result_.actuators[a].pose;
          q[k] += offset;
          if (const auto efforts = evaluate(q)) update_worst(a, q, *efforts);
        }
  }

  /// Sets values below the round-off of the effort's terms to zero.
  void zero_round_off(std::size_t a) {
    StaticDeviation& worst = result_.actuators[a];
    const VectorX zero = VectorX::Zero(size());
    const Expected<dynamics::EffortRegressor> regressor = inverse_dynamics_.regressor(worst.pose, zero, zero);
    if (!regressor) return;
    const auto row = static_cast<Eigen::Index>(a);
    const double term_magnitude =
        regressor.value.effort.row(row).cwiseAbs().dot(regressor.value.values.cwiseAbs().transpose()) +
        std::abs(regressor.value.constant_effort[row]);
    for (double* value : {&worst.effort, &worst.deviation})
      *value = results::suppress_round_off(results::round_off_factor * term_magnitude, *value);
    if (worst.deviation == 0) worst.shares.setZero();
  }

  const Tolerances& numbers_;
  VectorX deviations_;  ///< standard deviations; 0 for numbers that open a joint
  InverseDynamics inverse_dynamics_;
  long steps_, poses_ = 0;
  std::vector<MechanismOf<derivatives::DualNumber>> duals_;
  std::vector<bool> is_evaluated_;  ///< per actuator: whether any pose was evaluated
  MotionOutcome first_failure_;
  StaticTolerance result_;
};

}  // namespace

StaticTolerance analyse_static_tolerance(const DesignSpace& space, const Tolerances& numbers, long steps) {
  reject_temporary_payloads(space.start, "tolerances");
  if (numbers.empty()) throw std::invalid_argument("there are no numbers with tolerances");
  if (space.start.mechanism.actuators.empty())
    throw std::invalid_argument("there are no actuators whose efforts at rest could deviate");
  return StaticToleranceSearch(space, numbers, steps).run();
}

}  // namespace balance::tolerance
