#include "balance/analysis/tolerance_at_rest.hpp"

#include "balance/analysis/toleranced_duals.hpp"
#include "balance/gradients/state_duals.hpp"
#include "balance/study/passing_payloads.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace balance {

namespace {

constexpr long most_poses = 100'000;
constexpr int halvings = 30;

/// Efforts at rest in a pose, and what every number's deviation changes them by.
struct Held {
  VectorX effort;
  MatrixX change;  ///< actuators × numbers
};

class Rest {
 public:
  Rest(const DesignSpace& space, const Tolerances& numbers, long steps)
      : numbers_(numbers), door_(space.start.mechanism), steps_(steps) {
    for (std::size_t first = 0; first < numbers.size(); first += dual_width)
      duals_.push_back(TolerancedDuals(space, numbers, first).mechanism());
    const Mechanism& mechanism = space.start.mechanism;
    for (const std::string& name : door_.independent())
      for (const Coordinate& coordinate : mechanism.coordinates)
        if (coordinate.name == name && coordinate.kind != CoordinateKind::angle)
          throw std::invalid_argument("the workspace is whole turns, and " + name + " is a slide");
    choose_steps();
    for (const int actuator : mechanism.actuators)
      out_.actuators.push_back(
          {mechanism.coordinates[static_cast<std::size_t>(actuator)].name,
           mechanism.coordinates[static_cast<std::size_t>(actuator)].kind == CoordinateKind::angle ? "N m" : "N", 0, 0,
           VectorX::Zero(size()), VectorX::Zero(static_cast<Eigen::Index>(numbers.size()))});
    out_.coordinates = door_.independent();
  }

  RestTolerance run() {
    walk_grid();
    if (out_.poses == out_.unreached) return out_;
    out_.outcome = {MotionStatus::done, 0, "", {}};
    for (std::size_t a = 0; a < out_.actuators.size(); ++a) refine(a);
    return out_;
  }

 private:
  Eigen::Index size() const { return door_.degrees_of_freedom(); }

  void choose_steps() {
    if (steps_ == 0) steps_ = size() <= 2 ? 72 : size() == 3 ? 24 : 8;
    long poses = 1;
    for (Eigen::Index k = 0; k < size(); ++k)
      if ((poses *= steps_) > most_poses)
        throw std::invalid_argument("the workspace has too many poses: at most " + std::to_string(most_poses));
    poses_ = poses;
  }

  /// Every pose one step from the one before, so that loops keep their assembly mode.
  void walk_grid() {
    out_.poses = poses_;
    VectorX q(size());
    for (long pose = 0; pose < poses_; ++pose) {
      long rest = pose;
      for (Eigen::Index k = 0; k < size(); ++k, rest /= steps_)
        q[k] = 2 * std::numbers::pi * static_cast<double>(rest % steps_) / static_cast<double>(steps_);
      const std::optional<Held> held = look(q);
      if (!held) ++out_.unreached;
      for (std::size_t a = 0; held && a < out_.actuators.size(); ++a) meet(a, q, *held);
    }
  }

  std::optional<Held> look(const VectorX& q) {
    const VectorX still = VectorX::Zero(size());
    Held held;
    held.change.resize(static_cast<Eigen::Index>(out_.actuators.size()), static_cast<Eigen::Index>(numbers_.size()));
    for (std::size_t chunk = 0; chunk < duals_.size(); ++chunk) {
      const Answer<StateGradient> found = derivatives(door_, duals_[chunk], q, still, still);
      if (!found) return std::nullopt;
      held.effort = found.value.sample.effort;
      for (std::size_t k = 0; k < dual_width && chunk * dual_width + k < numbers_.size(); ++k) {
        const std::size_t number = chunk * dual_width + k;
        held.change.col(static_cast<Eigen::Index>(number)) =
            numbers_[number].deviation() * found.value.derivatives[k].effort;
      }
    }
    return held;
  }

  bool meet(std::size_t a, const VectorX& q, const Held& held) {
    const auto row = static_cast<Eigen::Index>(a);
    const double deviation = held.change.row(row).norm();
    RestDeviation& worst = out_.actuators[a];
    if (!(deviation > worst.deviation)) return false;
    worst.deviation = deviation;
    worst.effort = held.effort[row];
    worst.pose = q;
    worst.shares = held.change.row(row).transpose().array().square() / (deviation * deviation);
    return true;
  }

  /// Along each coordinate in turn, in steps that are halved where none leads upwards.
  void refine(std::size_t a) {
    double step = std::numbers::pi / static_cast<double>(steps_);
    for (int halving = 0; halving < halvings; step /= 2, ++halving)
      for (Eigen::Index k = 0; k < size(); ++k)
        for (const double way : {step, -step}) {
          VectorX q = out_.actuators[a].pose;
          q[k] += way;
          if (const auto held = look(q)) meet(a, q, *held);
        }
  }

  const Tolerances& numbers_;
  InverseDynamics door_;
  long steps_, poses_ = 0;
  std::vector<MechanismOf<DualNumber>> duals_;
  RestTolerance out_;
};

}  // namespace

RestTolerance tolerance_at_rest(const DesignSpace& space, const Tolerances& numbers, long steps) {
  refuse_passing_payloads(space.start, "tolerances");
  if (numbers.empty()) throw std::invalid_argument("there are no numbers that may be off");
  return Rest(space, numbers, steps).run();
}

}  // namespace balance
