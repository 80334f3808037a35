#pragma once
/// A configuration with its rates at one time, and configurations between two of them. Private to motion and dynamics.

#include "balance/motion/equations.hpp"
#include "balance/motion/plan.hpp"

#include <vector>

namespace balance {

struct MotionMoment {
  double time = 0;
  VectorX y, dy, ddy;
};

/// Visits configurations between two moments of a motion, without touching whoever follows it.
template <class S>
class Scout {
 public:
  /// @param tree, plan must outlive the scout
  Scout(const Tree<S>& tree, const Plan<S>& plan);

  /// To a time between the two: the Hermite polynomial of degree 5, corrected by Newton. Their coordinates must be counted from the
  /// tree's present references.
  /// @return false if there is no such configuration near
  bool visit(const MotionMoment& a, const MotionMoment& b, double time);
  const Equations<S>& equations() const { return equations_; }
  const State<S>& state() const { return state_; }

 private:
  const Tree<S>& tree_;
  const Plan<S>& plan_;
  Equations<S> equations_;
  State<S> state_;
  DriveSample sample_;
  VectorX y_;
  std::vector<double> x_;
};

extern template class Scout<Planar>;
extern template class Scout<Spatial>;

}  // namespace balance
