#pragma once
/// Monitors a motion for its minimum distances from singularities, and for singular configurations of single loops, or
/// of some of the actuators, while the others keep it determinate. Configurations between steps are computed, so that
/// the results do not depend on the steps.

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

namespace balance::kinematics {

/// Detects loops that lose rank on their own while others keep the motion determinate.
template <class S>
class LoopRankMonitor {
 public:
  /// @param mechanism, tree must outlive it
  LoopRankMonitor(const Mechanism& mechanism, const Tree<S>& tree);

  std::size_t loop_count() const { return loops_.size(); }
  /// "A, B, C, D": the joints along a loop.
  std::string joint_names(std::size_t loop) const;

  /// Singular values, in decreasing order, of the twists that a loop's joints allow between its bodies, in angles and
  /// characteristic lengths: as many as closure equations of a loop.
  /// @param poses of the tree's nodes
  VectorX singular_values(std::size_t loop, const TreeState<S>& poses) const;

 private:
  void add_joint_twists(const model::LoopStep& step, const TreeState<S>& poses, const typename S::Vector& about,
                        MatrixX& twists) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  std::vector<model::SimpleLoop> loops_;
};

extern template class LoopRankMonitor<Planar>;
extern template class LoopRankMonitor<Spatial>;

/// Coordinates, rates and accelerations at one time.
struct CoordinateSample {
  double time = 0;
  VectorX y, dy, ddy;
};

/// Computes configurations between two instants of a motion, independently of the stepper that follows it.
template <class S>
class StateInterpolator {
 public:
  /// @param tree, plan must outlive the interpolator
  StateInterpolator(const Tree<S>& tree, const CompiledTrajectory<S>& plan);

  /// Interpolates to a time between two samples by the Hermite polynomial of degree 5, corrected by Newton's method.
  /// Both samples must refer to the tree's present references.
  /// @return false if there is no such configuration nearby
  bool interpolate(const CoordinateSample& a, const CoordinateSample& b, double time);
  const KinematicEquations<S>& equations() const { return equations_; }
  const TreeState<S>& state() const { return state_; }

 private:
  const Tree<S>& tree_;
  const CompiledTrajectory<S>& plan_;
  KinematicEquations<S> equations_;
  TreeState<S> state_;
  trajectory::DriveSample sample_;
  VectorX y_;
  std::vector<double> x_;
};

extern template class StateInterpolator<Planar>;
extern template class StateInterpolator<Spatial>;

template <class S>
class SingularityMonitor {
 public:
  /// The last three samples, the latest last.
  using History = std::array<const CoordinateSample*, 3>;

  /// All arguments must outlive the monitor. @param steps the stepper's last samples, up to date at every call
  SingularityMonitor(const Mechanism& mechanism, const Tree<S>& tree, const CompiledTrajectory<S>& plan,
                     const History& steps);
  SingularityMonitor(const SingularityMonitor&) = delete;  // it points into itself
  SingularityMonitor& operator=(const SingularityMonitor&) = delete;

  /// Monitors the actuators, too; `monitor` must outlive this object.
  void monitor_actuation(const RegularityMonitor<S>& monitor);
  /// To be called at the first instant of a motion.
  void begin(const KinematicEquations<S>& equations, double pivot, double actuation_pivot);
  /// To be called when the coordinates of the last instant refer to other spherical references.
  void restart(const KinematicEquations<S>& equations, double pivot, double actuation_pivot);
  /// To be called at the end of a step.
  /// @param equations evaluated there
  /// @param pivot, actuation_pivot smallest ones of the equations and of the monitored actuation matrix
  /// @param distance since the last instant [rad, characteristic lengths]
  void sample(const KinematicEquations<S>& equations, double pivot, double actuation_pivot, double distance);
  /// Notes on the motion up to the last sample.
  std::vector<std::string> notes();

 private:
  /// The nearest approach to a singularity of one matrix.
  struct NearSingularity {
    numerics::LocalMinimumTracker minimum_tracker;
    double mobility = INFINITY, time = 0;
    double pivot_per_mobility = 1;  ///< smallest pivot divided by mobility, near there

    bool is_near() const { return mobility * pivot_per_mobility < numerics::near_singular_pivot_threshold; }
    void update_minimum(const numerics::LocalMinimumTracker::TimedValue& minimum) {
      if (minimum.value < mobility) mobility = minimum.value, time = minimum.time;
    }
  };
  /// A matrix that may lose rank while the motion stays determinate.
  struct RedundantMatrix {
    std::size_t index = 0;  ///< of the loop, or of the omitted actuator
    bool is_actuation = false;
    numerics::LocalMinimumTracker minimum_tracker;
    Eigen::Index rank = 0;
    std::vector<double> rank_loss_times;  ///< at which it has lost rank
  };
  template <class Mobility>
  void sample_distance(NearSingularity& approach, const KinematicEquations<S>& equations, double pivot,
                       const Mobility& mobility);
  void sample_distances(const KinematicEquations<S>& equations, double pivot, double actuation_pivot);
  void sample_redundant_matrices();
  void sample_redundant_matrix(RedundantMatrix& matrix, double time);
  double decisive_singular_value(const RedundantMatrix& matrix, const VectorX& sigma) const;
  VectorX singular_values(const RedundantMatrix& matrix) const;
  std::string describe(const RedundantMatrix& matrix) const;
  bool interpolate(const History& history, double time);
  void push_coarse_sample();

  const Mechanism& mechanism_;
  StateInterpolator<S> interpolator_;
  const RegularityMonitor<S>* regularity_monitor_ = nullptr;
  std::optional<LoopRankMonitor<S>> loops_;
  NearSingularity motion_, actuation_;
  std::vector<RedundantMatrix> redundant_matrices_;
  History steps_;
  std::array<CoordinateSample, 3> coarse_samples_;  ///< the last at which redundant matrices were examined
  History coarse_history_{&coarse_samples_[0], &coarse_samples_[1], &coarse_samples_[2]};
  double rotation_since_sample_ = 0;            ///< since the last of coarse_samples_
  double start_ = 0, interpolated_time_ = NAN;  ///< of the motion; of interpolator_
  bool has_pending_step_ = false;               ///< the last step is not in coarse_samples_ yet
};

extern template class SingularityMonitor<Planar>;
extern template class SingularityMonitor<Spatial>;

}  // namespace balance::kinematics
