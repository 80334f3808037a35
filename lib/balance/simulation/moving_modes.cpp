#include "balance/simulation/moving_modes.hpp"

#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/motion/names.hpp"
#include "balance/motion/plan.hpp"
#include "balance/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace balance {

namespace {

constexpr std::uint64_t mode_starts = 60;
constexpr int max_mode_columns = 60;  // of larger mechanisms the search takes longer than anybody waits for a message
constexpr std::size_t max_modes_run = 16;
constexpr double same_mode = 1e-4;  // radians or characteristic lengths

bool is_matter_of_modes(MotionStatus status) {
  using enum MotionStatus;
  return status == unreachable || status == drive_singularity || status == assembly_jump ||
         status == constraint_singularity || status == actuation_singularity;
}

template <class S>
class ModeSearch {
 public:
  ModeSearch(const Mechanism& mechanism, const Trajectory& trajectory)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        tree_(compile<S>(mechanism, prescribed_coordinates(trajectory))) {}

  MovingModes run() {
    MovingModes result;
    if (tree_.closures.empty() || tree_.columns > max_mode_columns) return result;
    const PoseEquations<S> from = pose_equations(mechanism_, tree_, trajectory_.from);
    System<S> system(tree_, from.drive);
    const Solution picked = find_pose(mechanism_, tree_, system, from.target);
    // a pose that leaves freedoms open has a continuum of solutions, not modes
    if (!picked.found || from.drive.rows() < tree_.columns - generic_place_rank(tree_, picked.y)) return result;
    modes_.push_back(read_coordinates(mechanism_, tree_, picked.y));
    for (std::uint64_t seed = 1; seed <= mode_starts; ++seed) {
      const Solution other = solve(system, random_coordinates(tree_, 1000 + seed), from.target, 60);
      if (!other.found) continue;
      const std::vector<double> mode = read_coordinates(mechanism_, tree_, other.y);
      if (std::none_of(modes_.begin(), modes_.end(), [&](const auto& known) { return is_same(known, mode); }))
        modes_.push_back(mode);
    }
    result.others = static_cast<int>(modes_.size()) - 1;
    for (std::size_t m = 1; m < std::min(modes_.size(), max_modes_run); ++m)
      if (moves(modes_[m])) result.moving.push_back(telling(modes_[m]));
    return result;
  }

 private:
  bool is_same(const std::vector<double>& a, const std::vector<double>& b) const {
    for (std::size_t c = 0; c < a.size(); ++c) {
      const bool angle = mechanism_.coordinates[c].kind == CoordinateKind::angle;
      if (std::abs(angle ? unwrapped(a[c], b[c]) - b[c] : (a[c] - b[c]) / tree_.length) > same_mode) return false;
    }
    return true;
  }

  /// Coordinates of the tree that the start pose does not state itself.
  std::vector<CoordinateValue> telling(const std::vector<double>& mode) const {
    std::vector<CoordinateValue> values;
    for (std::size_t c = 0; c < mode.size(); ++c) {
      const auto is_this = [c](const CoordinateValue& one) { return one.coordinate == static_cast<int>(c); };
      const bool stated = std::any_of(trajectory_.from.joints.begin(), trajectory_.from.joints.end(), is_this);
      if (tree_.sources[c].depends() && !stated) values.push_back({static_cast<int>(c), mode[c]});
    }
    return values;
  }

  bool moves(const std::vector<double>& mode) const {
    Mechanism assembled = mechanism_;
    assembled.assembly.clear();
    for (std::size_t c = 0; c < mode.size(); ++c)
      if (tree_.sources[c].depends()) assembled.assembly.push_back({static_cast<int>(c), mode[c]});
    Trajectory coarse = trajectory_;
    coarse.samples = 2;
    return simulate(assembled, coarse).outcome.status == MotionStatus::done;
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  Tree<S> tree_;
  std::vector<std::vector<double>> modes_;
};

}  // namespace

MovingModes find_moving_modes(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (binds_rates(mechanism) || depends_on_mechanism(trajectory)) return {};
  return in_space(mechanism.space, [&]<class S>(S) { return ModeSearch<S>(mechanism, trajectory).run(); });
}

std::string moving_modes_text(const Mechanism& mechanism, const Trajectory& trajectory, const MotionOutcome& outcome,
                              double length_unit, double angle_unit) {
  if (!is_matter_of_modes(outcome.status)) return "";
  const MovingModes modes = find_moving_modes(mechanism, trajectory);
  if (modes.others == 0) return "";
  if (modes.moving.empty())
    return modes.others == 1
               ? "; the other assembly mode cannot make this motion either"
               : "; none of the " + std::to_string(modes.others) + " other assembly modes found can make this motion";
  std::string line;
  for (const CoordinateValue& one : modes.moving.front()) {
    const Coordinate& coordinate = mechanism.coordinates[one.coordinate];
    char value[32];
    std::snprintf(value, sizeof value, "%.6g",
                  one.value / (coordinate.kind == CoordinateKind::length ? length_unit : angle_unit));
    line += (line.empty() ? "" : ", ") + coordinate.name + ": " + value;
  }
  return "; another assembly mode can make this motion: assembly: {" + line + "}";
}

}  // namespace balance
