#pragma once
/// What a motion passes on its way: least distances from singularities, and singular configurations of single loops or of some of the
/// actuators where the others keep it determinate. Places between steps are computed, so that what is found does not depend on
/// the steps. Private to motion and dynamics.

#include "balance/motion/guard.hpp"
#include "balance/motion/loop_ranks.hpp"
#include "balance/motion/scout.hpp"
#include "balance/motion/valley.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace balance {

template <class S>
class Passages {
 public:
  /// The last three moments, the latest last.
  using Trail = std::array<const MotionMoment*, 3>;

  /// All must outlive it. @param steps where the last moments are whenever it is told of one
  Passages(const Mechanism& mechanism, const Tree<S>& tree, const Plan<S>& plan, const Trail& steps);
  Passages(const Passages&) = delete;  // it points into itself
  Passages& operator=(const Passages&) = delete;

  /// Also of the actuators; the guard must outlive it.
  void watch(const Guard<S>& guard);
  /// At the first moment of a motion.
  void begin(const Equations<S>& equations, double pivot, double hold_pivot);
  /// The last moment again, its coordinates counted from other references.
  void restart(const Equations<S>& equations, double pivot, double hold_pivot);
  /// At the end of a step.
  /// @param equations filled there
  /// @param pivot, hold_pivot smallest ones of the equations and of the guarded matrix
  /// @param way how far the mechanism has turned since the last moment [rad, characteristic lengths]
  void see(const Equations<S>& equations, double pivot, double hold_pivot, double way);
  /// Up to the last moment seen.
  std::vector<std::string> notes();

 private:
  /// The nearest pass by singularities of one matrix.
  struct NearPass {
    Valley valley;
    double mobility = INFINITY, time = 0;
    double pivots = 1;  ///< smallest pivot by mobility, near there

    bool is_near() const { return mobility * pivots < near_singular; }
    void take(const Valley::Place& place) {
      if (place.value < mobility) mobility = place.value, time = place.time;
    }
  };
  /// A matrix that may lose rank without consequences.
  struct Part {
    std::size_t index = 0;  ///< of the loop, or of the actuator left out
    bool motors = false;
    Valley valley;
    Eigen::Index rank = 0;
    std::vector<double> times;  ///< at which it has lost rank
  };
  template <class Mobility>
  void look(NearPass& pass, const Equations<S>& equations, double pivot, const Mobility& mobility);
  void look_at_distances(const Equations<S>& equations, double pivot, double hold_pivot);
  void look_at_parts();
  void look_at(Part& part, double time);
  double weakest(const Part& part, const VectorX& strengths) const;
  VectorX strengths(const Part& part) const;
  std::string name(const Part& part) const;
  bool visit(const Trail& trail, double time);
  void push_coarse();

  const Mechanism& mechanism_;
  Scout<S> scout_;
  const Guard<S>* guard_ = nullptr;
  std::optional<LoopRanks<S>> loops_;
  NearPass motion_, actuation_;
  std::vector<Part> parts_;
  Trail steps_;
  std::array<MotionMoment, 3> looked_at_;  ///< the last at which parts were looked at
  Trail coarse_{&looked_at_[0], &looked_at_[1], &looked_at_[2]};
  double turned_ = 0;            ///< since the last of the latter
  double start_ = 0, at_ = NAN;  ///< of the motion; of the scout
  bool pending_ = false;         ///< the last step is not in coarse_ yet
};

extern template class Passages<Planar>;
extern template class Passages<Spatial>;

}  // namespace balance
