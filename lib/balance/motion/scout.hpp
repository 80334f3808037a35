#pragma once
/// A configuration with its rates at one time, and configurations between two of them. Private to motion and dynamics.

#include "balance/motion/equations.hpp"
#include "balance/motion/plan.hpp"

#include <vector>

namespace balance {

struct CoordinateSample {
  double time = 0;
  VectorX y, dy, ddy;
};

/// Visits configurations between two moments of a motion, without touching whoever follows it.
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

}  // namespace balance
