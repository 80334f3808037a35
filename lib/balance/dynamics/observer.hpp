#pragma once
/// Finds everything that is known of a moving mechanism at one moment. Private to dynamics and the rooms that open it up.

#include "balance/dynamics/actuation.hpp"
#include "balance/dynamics/external.hpp"
#include "balance/motion/sample.hpp"
#include "balance/motion/stepper.hpp"

#include <vector>

namespace balance {

/// A tree in motion. The state holds poses and angular velocities, unless every coordinate is prescribed (`direct`).
template <class S>
struct Instant {
  State<S>& state;
  const double *y, *dy, *ddy;
  double time;
  bool direct;
};

/// How much to find out.
enum class Detail {
  forces,      ///< coordinates, efforts, power, centre of mass, shaking force and moment, tool
  everything,  ///< also ground wrench, reactions, energies, velocity of the centre of mass, what follows from others
};

template <class S>
class Observer {
 public:
  /// @param about world point that moments are about
  Observer(const Mechanism& mechanism, const Tree<S>& tree, int freedoms, const typename S::Vector& about);

  const Actuation<S>& actuation() const { return actuation_; }
  /// For a stepper to watch whether the actuators hold the mechanism all along its way.
  Guard<S>& guard() { return actuation_; }
  const Sample& last() const { return seen_; }
  /// For whoever knows more of the moment (mobility) to write it down.
  Sample& last() { return seen_; }

  /// The stepper's present moment, with the accelerations that it holds now.
  /// @return false if the actuators do not hold the mechanism there
  bool observe(Stepper<S>& stepper, Detail detail);

  /// Rates and accelerations of one's own at a stepper's configuration.
  /// @param equations filled there @param duration as a stepper's [s]: what friction takes for rest
  bool observe(const Instant<S>& instant, const Equations<S>& equations, double duration, Detail detail);

  /// Everything at a moment of a motion whose efforts are known.
  /// @param efforts per actuator
  /// @param multipliers per closure row, as Actuation::multipliers()
  void observe_under(const Instant<S>& instant, const double* efforts, const std::vector<double>& multipliers);

  /// Only the coordinates and the tool, at the stepper's present moment: the motion without the forces.
  void watch(Stepper<S>& stepper);

  /// Only the coordinates, so that the count of whole turns goes on.
  void follow(const Instant<S>& instant);
  /// The next observation is the first of another motion.
  void restart() { first_ = true; }

 private:
  /// A coordinate that is none of y's: of a cut joint, linear in y where it is a planar angle, else read off the relative
  /// pose; of a floating spherical joint.
  struct CutCoordinate {
    int coordinate;
    bool linear;
    LinearQuantity quantity;
  };

  struct TreeCoordinate {
    int coordinate;
    CoordinateSource source;
  };

  void sort_coordinates();
  void set_state(const Instant<S>& now, Detail detail);
  void read_coordinates(const Instant<S>& now);
  void read_cut_coordinates(const Instant<S>& now);
  void balance_forces(const Instant<S>& now);
  void read_rest(const Instant<S>& now, Detail detail, const std::vector<double>& multipliers);
  void read_forces();
  void read_tool(const Instant<S>& now);
  void read_reactions(const Instant<S>& now, const std::vector<double>& multipliers);
  void read_energies();
  void add_closure_wrenches(const std::vector<double>& multipliers);

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  typename S::Vector gravity_, about_;
  ExternalForces<S> external_;
  Actuation<S> actuation_;
  std::vector<TreeCoordinate> own_;
  std::vector<CutCoordinate> cut_;
  std::vector<int> cut_joints_;  ///< with coordinates that are not linear
  FixedFrame<S> tool_;
  LinearQuantity tool_angle_;
  State<S>* state_ = nullptr;
  std::vector<Wrench<S>> wrenches_;
  Wrench<S> external_total_, external_loads_;
  std::vector<double> tau_;
  Sample seen_;
  bool first_ = true;
  double time_ = 0;  ///< of the last observation
};

extern template class Observer<Planar>;
extern template class Observer<Spatial>;

}  // namespace balance
