#pragma once
/// Optimises a path within a corridor.

#include "balance/foundation/numerics/chebyshev_series.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/optimised_law.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/time_optimal/path_model.hpp"
#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <optional>
#include <vector>

namespace balance::time_optimal {

// The search.

/// Fills the control points of the trajectory's corridor so that the duration (law fastest), the minimum peak for a
/// duration (gentlest) or the peak under a given law is minimised. Does nothing without a corridor, or if its path is
/// known.
/// @return done; or why the centreline of the corridor cannot be followed or has no law
/// @throws std::invalid_argument if the trajectory asks for something that does not exist
MotionOutcome optimise_corridor_path(const Mechanism& mechanism, Trajectory& trajectory,
                                     std::optional<trajectory::CorridorResult>& corridor_result);

/// The objective as a function of the corridor's controls: the maximum of several terms. For an optimised law there is
/// one term, the duration or the peak of that law. For a given law, each term is the magnitude of a quantity at one
/// time.
class CorridorObjective {
 public:
  /// @param trajectory with a corridor whose path is not known
  CorridorObjective(const Mechanism& mechanism, const Trajectory& trajectory);

  /// For the centreline: done, or why it cannot be followed.
  const MotionOutcome& outcome() const { return outcome_; }
  Eigen::Index directions() const { return directions_; }
  /// "N"; "s" for a duration.
  const std::string& unit() const { return unit_; }

  /// Empty if the path cannot be followed or has no law; see infeasibility_outcome().
  VectorX terms(const VectorX& controls);
  const MotionOutcome& infeasibility_outcome() const { return refusal_; }

  /// Derivatives of the terms at the controls of the last call of terms(), one row per term.
  MatrixX jacobian();

 private:
  /// Models on both sides of the current one, for steps that do not overlap: every fourth spline of a direction at
  /// once.
  struct Neighbours {
    PathModel above, below;
    double step = 0;  ///< between the two; 0: neither path can be followed
  };

  Trajectory with_control_points(const VectorX& controls) const;
  PathModel model_of(const VectorX& controls) const;
  void list_path_points();
  void build_neighbours();
  /// Gradient of a row's magnitude with respect to all controls.
  VectorX constraint_gradient(const PathPoint& point, const ConstraintValue& constraint) const;
  VectorX stated_law_terms() const;
  MatrixX stated_law_jacobian() const;
  VectorX optimal_law_gradient() const;

  const Mechanism& mechanism_;
  Trajectory trajectory_;
  PathLimits limits_;
  Eigen::Index control_points_per_direction_ = 0, directions_ = 1;
  std::string unit_ = "s";
  MotionOutcome outcome_, refusal_;
  double step_ = 0;                     ///< for finite differences [m or rad]
  std::vector<PathPoint> path_points_;  ///< under a given law; their rows are set on use
  VectorX controls_;
  PathModel model_;
  MinPeakLaw law_;
  std::vector<Neighbours> neighbours_;  ///< by direction and colour
};

// The offsets within a corridor of width 1, as a set of controls.

/// Controls of a corridor's splines, `knots + 2` for each direction. The set is convex and described by its
/// half-spaces.
class CorridorSet {
 public:
  CorridorSet(int knots, Eigen::Index directions);

  Eigen::Index size() const { return controls_per_direction_ * directions_; }
  /// M of ∫ (o''² + o²) ds = xᵀ M x, which measures the bending of the splines and, to a small part, their size.
  MatrixX metric() const;
  /// Maximum distance from the path.
  double gauge(const VectorX& controls) const;
  /// Normals n of supporting half-spaces n·x ≤ 1, one per local maximum of the distance above 1.
  std::vector<VectorX> cutting_planes(const VectorX& controls) const;

 private:
  struct OffsetMaximum {
    double s = 0, distance = 0;
    VectorX offset;
  };

  VectorX basis_values(std::size_t panel, double s) const;
  OffsetMaximum offset_at(const VectorX& controls, std::size_t panel, double s) const;
  /// All local maxima of the distance.
  std::vector<OffsetMaximum> offset_maxima(const VectorX& controls) const;
  std::size_t panel_at(double s) const { return bases_.find_panel(s, 0, bases_.panels().size()); }

  Eigen::Index controls_per_direction_, directions_;
  numerics::PiecewiseChebyshevSeries bases_;  ///< B-splines
};

}  // namespace balance::time_optimal
