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

namespace balance {

namespace {

constexpr long max_static_poses = 100'000;
constexpr int max_step_halvings = 30;

/// Efforts at rest in a pose, and what every number's deviation changes them by.
struct StaticEfforts {
  VectorX effort;
  MatrixX change;  ///< actuators × numbers
};

class StaticToleranceSearch {
 public:
  StaticToleranceSearch(const DesignSpace& space, const Tolerances& numbers, long steps)
      : numbers_(numbers),
        sigma_(static_cast<Eigen::Index>(numbers.size())),
        inverse_dynamics_(space.start.mechanism),
        steps_(steps) {
    for (Eigen::Index i = 0; i < sigma_.size(); ++i) sigma_[i] = numbers[static_cast<std::size_t>(i)].deviation();
    for (std::size_t first = 0; first < numbers.size(); first += dual_width)
      duals_.push_back(TolerancedDuals(space, numbers, first).mechanism());
    const Mechanism& mechanism = space.start.mechanism;
    for (const std::string& name : inverse_dynamics_.independent())
      for (const Coordinate& coordinate : mechanism.coordinates)
        if (coordinate.name == name && coordinate.kind != CoordinateKind::angle)
          throw std::invalid_argument("the workspace is whole turns, and " + name + " is a slide");
    choose_steps();
    for (const int actuator : mechanism.actuators)
      out_.actuators.push_back(
          {mechanism.coordinates[static_cast<std::size_t>(actuator)].name,
           mechanism.coordinates[static_cast<std::size_t>(actuator)].kind == CoordinateKind::angle ? "N m" : "N", 0, 0,
           VectorX::Zero(size()), VectorX::Zero(sigma_.size())});
    out_.coordinates = inverse_dynamics_.independent();
  }

  StaticTolerance run() {
    scan_grid();
    if (out_.pose_count == out_.unreachable_count) {
      out_.outcome = first_failure_;
      out_.outcome.reason = "no pose of the workspace could be reached and held: " + first_failure_.reason;
      return out_;
    }
    if (exclude_incompatible_parameters()) scan_grid();
    out_.outcome = {MotionStatus::done, 0, "", {}};
    for (std::size_t a = 0; a < out_.actuators.size(); ++a) {
      refine(a);
      zero_round_off(a);
    }
    return out_;
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

  /// Every pose one step from the one before, so that loops keep their assembly mode.
  void scan_grid() {
    out_.pose_count = poses_;
    out_.unreachable_count = 0;
    is_evaluated_.assign(out_.actuators.size(), false);
    VectorX q(size());
    for (long pose = 0; pose < poses_; ++pose) {
      long rest = pose;
      for (Eigen::Index k = 0; k < size(); ++k, rest /= steps_)
        q[k] = 2 * std::numbers::pi * static_cast<double>(rest % steps_) / static_cast<double>(steps_);
      const std::optional<StaticEfforts> held = evaluate(q);
      if (!held) ++out_.unreachable_count;
      for (std::size_t a = 0; held && a < out_.actuators.size(); ++a) update_worst(a, q, *held);
    }
  }

  std::optional<StaticEfforts> evaluate(const VectorX& q) {
    const VectorX still = VectorX::Zero(size());
    StaticEfforts held;
    held.change.resize(static_cast<Eigen::Index>(out_.actuators.size()), sigma_.size());
    for (std::size_t chunk = 0; chunk < duals_.size(); ++chunk) {
      const Expected<StateGradient> found = derivatives(inverse_dynamics_, duals_[chunk], q, still, still);
      if (!found) {
        if (first_failure_.reason.empty()) first_failure_ = found.outcome;
        return std::nullopt;
      }
      held.effort = found.value.sample.effort;
      const std::size_t first = chunk * dual_width;
      for (std::size_t i = first; i < std::min(first + dual_width, static_cast<std::size_t>(sigma_.size())); ++i) {
        const auto number = static_cast<Eigen::Index>(i);
        held.change.col(number) = sigma_[number] * found.value.derivatives[i - first].effort;
        add_incompatible_parameter(found.value.closure_gaps[i - first], i);
      }
    }
    return held;
  }

  /// Every joint's largest.
  void add_incompatible_parameter(const ClosureGaps& found, std::size_t number) {
    std::vector<IncompatibleParameter> here;
    add_incompatible_parameters(found, number, numbers_[number].path, sigma_[static_cast<Eigen::Index>(number)],
                                inverse_dynamics_.mechanism(), here);
    for (const IncompatibleParameter& one : here) {
      const auto known =
          std::find_if(out_.incompatible_parameters.begin(), out_.incompatible_parameters.end(),
                       [&](const IncompatibleParameter& other) {
                         return other.index == number && other.joint == one.joint && other.unit == one.unit;
                       });
      if (known == out_.incompatible_parameters.end())
        out_.incompatible_parameters.push_back(one);
      else
        known->gap = std::max(known->gap, one.gap);
    }
  }

  /// @return whether there are any
  bool exclude_incompatible_parameters() {
    for (const IncompatibleParameter& one : out_.incompatible_parameters)
      sigma_[static_cast<Eigen::Index>(one.index)] = 0;
    return !out_.incompatible_parameters.empty();
  }

  bool update_worst(std::size_t a, const VectorX& q, const StaticEfforts& held) {
    const auto row = static_cast<Eigen::Index>(a);
    const double deviation = held.change.row(row).norm();
    StaticDeviation& worst = out_.actuators[a];
    if (is_evaluated_[a] && !(deviation > worst.deviation)) return false;
    is_evaluated_[a] = true;
    worst.deviation = deviation;
    worst.effort = held.effort[row];
    worst.pose = q;
    worst.shares = held.change.row(row).transpose().array().square();
    if (deviation > 0) worst.shares /= deviation * deviation;
    return true;
  }

  /// Along each coordinate in turn, in steps that are halved where none leads upwards.
  void refine(std::size_t a) {
    double step = std::numbers::pi / static_cast<double>(steps_);
    for (int halving = 0; halving < max_step_halvings; step /= 2, ++halving)
      for (Eigen::Index k = 0; k < size(); ++k)
        for (const double way : {step, -step}) {
          VectorX q = out_.actuators[a].pose;
          q[k] += way;
          if (const auto held = evaluate(q)) update_worst(a, q, *held);
        }
  }

  /// What the terms of the effort leave of zero.
  void zero_round_off(std::size_t a) {
    StaticDeviation& one = out_.actuators[a];
    const VectorX still = VectorX::Zero(size());
    const Expected<EffortRegressor> found = inverse_dynamics_.regressor(one.pose, still, still);
    if (!found) return;
    const auto row = static_cast<Eigen::Index>(a);
    const double terms = found.value.effort.row(row).cwiseAbs().dot(found.value.values.cwiseAbs().transpose()) +
                         std::abs(found.value.constant_effort[row]);
    for (double* value : {&one.effort, &one.deviation}) *value = suppress_round_off(round_off_factor * terms, *value);
    if (one.deviation == 0) one.shares.setZero();
  }

  const Tolerances& numbers_;
  VectorX sigma_;  ///< deviations; 0 of numbers that open a joint
  InverseDynamics inverse_dynamics_;
  long steps_, poses_ = 0;
  std::vector<MechanismOf<DualNumber>> duals_;
  std::vector<bool> is_evaluated_;  ///< per actuator: some pose was seen
  MotionOutcome first_failure_;
  StaticTolerance out_;
};

}  // namespace

StaticTolerance analyse_static_tolerance(const DesignSpace& space, const Tolerances& numbers, long steps) {
  reject_temporary_payloads(space.start, "tolerances");
  if (numbers.empty()) throw std::invalid_argument("there are no numbers that may be off");
  if (space.start.mechanism.actuators.empty())
    throw std::invalid_argument("there are no actuators, whose efforts at rest could be off");
  return StaticToleranceSearch(space, numbers, steps).run();
}

}  // namespace balance
