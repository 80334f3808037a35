#pragma once
/// What is made least by a way within a corridor, with its derivatives. Private to timing.

#include "balance/timing/law_task.hpp"
#include "balance/timing/row_value.hpp"

#include <optional>
#include <vector>

namespace balance {

/// A function of the corridor's controls: the largest of its pieces. Under a law that is searched for there is one, the duration or the
/// peak that the law reaches; under a stated one a piece is a quantity's magnitude at a moment.
class CorridorObjective {
 public:
  /// @param trajectory with a corridor whose way is not known
  CorridorObjective(const Mechanism& mechanism, const Trajectory& trajectory);

  /// Of the path itself: done, or why it cannot be followed.
  const MotionOutcome& outcome() const { return outcome_; }
  Eigen::Index directions() const { return directions_; }
  /// "N"; of a duration "s".
  const std::string& unit() const { return unit_; }

  /// Empty if the way cannot be followed or has no law: refusal() says why.
  VectorX terms(const VectorX& controls);
  const MotionOutcome& infeasibility_outcome() const { return refusal_; }

  /// Derivatives of the pieces at the controls last asked for, one row each.
  MatrixX jacobian();

 private:
  /// The models to both sides of the present one, in steps that do not overlap: every fourth spline of a direction at once.
  struct Neighbours {
    PathModel above, below;
    double step = 0;  ///< between them; 0: neither can be followed
  };

  Trajectory with_control_points(const VectorX& controls) const;
  PathModel model_of(const VectorX& controls) const;
  void list_path_points();
  void build_neighbours();
  /// Of a row's magnitude with respect to all controls.
  VectorX constraint_gradient(const PathPoint& moment, const ConstraintValue& here) const;
  VectorX stated_law_terms() const;
  MatrixX stated_law_jacobian() const;
  VectorX optimal_law_gradient() const;

  const Mechanism& mechanism_;
  Trajectory trajectory_;
  PathLimits limits_;
  Eigen::Index control_points_per_direction_ = 0, directions_ = 1;
  std::string unit_ = "s";
  MotionOutcome outcome_, refusal_;
  double step_ = 0;                 ///< of differences [m or rad]
  std::vector<PathPoint> moments_;  ///< under a stated law; their rows are the first
  VectorX controls_;
  PathModel model_;
  MinPeakLaw law_;
  std::vector<Neighbours> neighbours_;  ///< by direction and colour
};

}  // namespace balance
