#pragma once
/// What a motion passes on its way: least distances from singularities, and singular configurations of single loops or of some of the
/// actuators where the others keep it determinate. Places between steps are computed, so that what is found does not depend on
/// the steps.

#include "balance/foundation/numerics/scalar_search.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/forward_kinematics.hpp"
#include "balance/mechanics/kinematics/kinematic_equations.hpp"
#include "balance/mechanics/model/topology.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace balance {

/// Loops that would lose rank on their own where others keep the motion determinate.
template <class S>
class LoopRankMonitor {
 public:
  /// @param mechanism, tree must outlive it
  LoopRankMonitor(const Mechanism& mechanism, const Tree<S>& tree);

  std::size_t loop_count() const { return loops_.size(); }
  /// "A, B, C, D": the joints along a loop.
  std::string joint_names(std::size_t loop) const;

  /// Singular values, largest first, of what a loop's joints let its bodies do against each other: as many as equations of closure,
  /// angles and characteristic lengths.
  /// @param poses of the tree's nodes
  VectorX singular_values(std::size_t loop, const TreeState<S>& poses) const;

 private:
  void add_joint_twists(const LoopStep& step, const TreeState<S>& poses, const typename S::Vector& about,
                        MatrixX& twists) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  std::vector<SimpleLoop> loops_;
};

extern template class LoopRankMonitor<Planar>;
extern template class LoopRankMonitor<Spatial>;

/// A configuration with its rates at one time, and configurations between two of them.
struct CoordinateSample {
  double time = 0;
  VectorX y, dy, ddy;
};

/// Visits configurations between two moments of a motion, without touching the stepper that follows it.
template <class S>
class StateInterpolator {
 public:
  /// @param tree, plan must outlive the scout
  StateInterpolator(const Tree<S>& tree, const CompiledTrajectory<S>& plan);

  /// To a time between the two: the Hermite polynomial of degree 5, corrected by Newton. Their coordinates must be counted from the
  /// tree's present references.
  /// @return false if there is no such configuration near
  bool interpolate(const CoordinateSample& a, const CoordinateSample& b, double time);
  const KinematicEquations<S>& equations() const { return equations_; }
  const TreeState<S>& state() const { return state_; }

 private:
  const Tree<S>& tree_;
  const CompiledTrajectory<S>& plan_;
  KinematicEquations<S> equations_;
  TreeState<S> state_;
  DriveSample sample_;
  VectorX y_;
  std::vector<double> x_;
};

extern template class StateInterpolator<Planar>;
extern template class StateInterpolator<Spatial>;

template <class S>
class SingularityMonitor {
 public:
  /// The last three moments, the latest last.
  using History = std::array<const CoordinateSample*, 3>;

  /// All must outlive it. @param steps where the last moments are whenever it is told of one
  SingularityMonitor(const Mechanism& mechanism, const Tree<S>& tree, const CompiledTrajectory<S>& plan,
                     const History& steps);
  SingularityMonitor(const SingularityMonitor&) = delete;  // it points into itself
  SingularityMonitor& operator=(const SingularityMonitor&) = delete;

  /// Also of the actuators; the guard must outlive it.
  void monitor_actuation(const RegularityMonitor<S>& guard);
  /// At the first moment of a motion.
  void begin(const KinematicEquations<S>& equations, double pivot, double hold_pivot);
  /// The last moment again, its coordinates counted from other references.
  void restart(const KinematicEquations<S>& equations, double pivot, double hold_pivot);
  /// At the end of a step.
  /// @param equations filled there
  /// @param pivot, hold_pivot smallest ones of the equations and of the guarded matrix
  /// @param way how far the mechanism has turned since the last moment [rad, characteristic lengths]
  void sample(const KinematicEquations<S>& equations, double pivot, double hold_pivot, double way);
  /// Up to the last moment seen.
  std::vector<std::string> notes();

 private:
  /// The nearest pass by singularities of one matrix.
  struct NearSingularity {
    LocalMinimumTracker minimum_tracker;
    double mobility = INFINITY, time = 0;
    double pivot_per_mobility = 1;  ///< smallest pivot by mobility, near there

    bool is_near() const { return mobility * pivot_per_mobility < near_singular_pivot_threshold; }
    void update_minimum(const LocalMinimumTracker::TimedValue& place) {
      if (place.value < mobility) mobility = place.value, time = place.time;
    }
  };
  /// A matrix that may lose rank without consequences.
  struct RedundantMatrix {
    std::size_t index = 0;  ///< of the loop, or of the actuator left out
    bool is_actuation = false;
    LocalMinimumTracker valley;
    Eigen::Index rank = 0;
    std::vector<double> rank_loss_times;  ///< at which it has lost rank
  };
  template <class Mobility>
  void sample_distance(NearSingularity& pass, const KinematicEquations<S>& equations, double pivot,
                       const Mobility& mobility);
  void sample_distances(const KinematicEquations<S>& equations, double pivot, double hold_pivot);
  void sample_redundant_matrices();
  void sample_redundant_matrix(RedundantMatrix& part, double time);
  double decisive_singular_value(const RedundantMatrix& part, const VectorX& strengths) const;
  VectorX singular_values(const RedundantMatrix& part) const;
  std::string describe(const RedundantMatrix& part) const;
  bool interpolate(const History& trail, double time);
  void push_coarse_sample();

  const Mechanism& mechanism_;
  StateInterpolator<S> interpolator_;
  const RegularityMonitor<S>* regularity_monitor_ = nullptr;
  std::optional<LoopRankMonitor<S>> loops_;
  NearSingularity motion_, actuation_;
  std::vector<RedundantMatrix> redundant_matrices_;
  History steps_;
  std::array<CoordinateSample, 3> coarse_samples_;  ///< the last at which parts were looked at
  History coarse_history_{&coarse_samples_[0], &coarse_samples_[1], &coarse_samples_[2]};
  double rotation_since_sample_ = 0;            ///< since the last of the latter
  double start_ = 0, interpolated_time_ = NAN;  ///< of the motion; of the scout
  bool pending_ = false;                        ///< the last step is not in coarse_ yet
};

extern template class SingularityMonitor<Planar>;
extern template class SingularityMonitor<Spatial>;

}  // namespace balance
