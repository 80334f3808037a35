#pragma once
/// What is stated of the angular momentum that remaining quantities keep. Private to timing.

#include "balance/motion/spline.hpp"
#include "balance/motion/trajectory.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

/// Components of the angular momentum as functions of time.
class PrescribedMomentum {
 public:
  /// @throws std::invalid_argument if there are not as many components as quantities that could keep them, or if a quantity that
  ///         goes by time stands beside a law that is not known yet. The message is fit for a user.
  PrescribedMomentum(SpaceKind space, const Trajectory& trajectory);

  /// The components, in the order of the courses: 0 x, 1 y, 2 z.
  const std::vector<int>& axes() const { return axes_; }
  /// Whether time matters: a component is not always zero, or a spline that goes by time lies beside.
  bool is_time_dependent() const { return over_time_; }
  /// @return [N m s], one entry per component
  VectorX at(double time) const;
  /// Where a third derivative may jump [s].
  std::vector<double> knots() const;
  /// Empty, or why the values do not hold for the whole motion. @param duration [s]
  std::string uncovered_interval(double duration) const;

 private:
  struct Component {
    double constant = 0;
    std::optional<CubicSpline> spline;
  };

  void add(const MomentumTask& kept);
  void check(SpaceKind space) const;

  std::vector<int> axes_;
  std::vector<Component> components_;
  bool over_time_ = false;
};

}  // namespace balance
