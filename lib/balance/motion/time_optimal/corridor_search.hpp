#pragma once
/// What is made least by a way within a corridor, with its derivatives.

#include "balance/foundation/numerics/chebyshev_series.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/optimised_law.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/time_optimal/path_model.hpp"
#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <optional>
#include <vector>

namespace balance {

// Finds the way within a corridor.

/// Fills the controls of the trajectory's corridor, so that the duration (law fastest), the least peak in a duration (gentlest) or the
/// peak under a stated law is least. A trajectory without one, or whose way has been found, stays as it is.
/// @return done; or why the path in the corridor's middle cannot be followed or has no law
/// @throws std::invalid_argument if the trajectory asks for something that does not exist
MotionOutcome optimise_corridor_path(const Mechanism& mechanism, Trajectory& trajectory,
                                     std::optional<CorridorResult>& found);

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

// The offsets that stay within a corridor of width 1, as a set of controls.

/// Controls of a corridor's splines, `knots + 2` for each direction. The set is convex; it is known by the half-spaces that hold it.
class CorridorSet {
 public:
  CorridorSet(int knots, Eigen::Index directions);

  Eigen::Index size() const { return each_ * directions_; }
  /// How much the splines bend, and a little of how large they are: ∫ (o''² + o²) ds = xᵀ M x.
  MatrixX metric() const;
  /// The largest distance from the path anywhere.
  double gauge(const VectorX& controls) const;
  /// Normals n of half-spaces n·x ≤ 1 that touch the set where the distance is largest and above 1.
  std::vector<VectorX> cutting_planes(const VectorX& controls) const;

 private:
  struct OffsetMaximum {
    double place = 0, distance = 0;
    VectorX offset;
  };

  VectorX basis_values(std::size_t panel, double place) const;
  OffsetMaximum offset_at(const VectorX& controls, std::size_t panel, double place) const;
  /// Every local maximum of the distance.
  std::vector<OffsetMaximum> offset_maxima(const VectorX& controls) const;
  std::size_t panel_at(double place) const { return bases_.find_panel(place, 0, bases_.panels().size()); }

  Eigen::Index each_, directions_;
  PiecewiseChebyshevSeries bases_;  ///< B-splines
};

}  // namespace balance
