#pragma once
/// Finds everything that is known of a moving mechanism at one moment.

#include "balance/mechanics/dynamics/actuation.hpp"
#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/kinematics/motion_stepper.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

#include <vector>

namespace balance {

/// A tree in motion. The state holds poses and angular velocities, unless every coordinate is prescribed (`direct`).
template <class S>
struct TreeMotion {
  TreeState<S>& state;
  const typename S::Scalar *y, *dy, *ddy;
  typename S::Scalar time;
  bool is_explicit;
};

/// How much to find out.
enum class Detail {
  forces,  ///< coordinates, efforts, power, centre of mass, shaking force and moment, tool
  all,     ///< also ground wrench, reactions, energies, velocity of the centre of mass, what follows from others
};

template <class S>
class SampleEvaluator {
 public:
  using T = typename S::Scalar;

  /// @param about world point that moments are about
  SampleEvaluator(const MechanismOf<T>& mechanism, const Tree<S>& tree, int freedoms, const typename S::Vector& about);

  const Actuation<S>& actuation() const { return actuation_; }
  /// For a stepper to watch whether the actuators hold the mechanism all along its way.
  RegularityMonitor<S>& regularity_monitor() { return actuation_; }
  const SampleOf<T>& sample() const { return sample_; }
  /// For callers that know more of the moment (mobility).
  SampleOf<T>& sample() { return sample_; }

  /// The stepper's present moment, with the accelerations that it holds now.
  /// @return false if the actuators do not hold the mechanism there
  template <class Leader>
  bool evaluate(Leader& stepper, Detail detail) {
    return evaluate(instant_of(stepper), stepper.equations(), stepper.duration(), detail);
  }

  /// Only the efforts: sample().effort, and the tree's generalised forces that they balance.
  bool solve_efforts(const TreeMotion<S>& now, const KinematicEquations<S>& equations, double duration);
  /// Generalised forces per tree coordinate that solve_efforts() found, friction included [N m or N].
  const std::vector<T>& generalised_forces() const { return tau_; }

  /// The efforts as a matrix times the tree's generalised forces, see Actuation::project.
  bool project(const KinematicEquations<S>& equations, MatrixX& projection) {
    return actuation_.project(equations, projection);
  }

  /// A moment of one's own.
  /// @param equations filled there @param duration as a stepper's [s]: what friction takes for rest
  bool evaluate(const TreeMotion<S>& instant, const KinematicEquations<S>& equations, double duration, Detail detail);

  /// Everything at a moment of a motion whose efforts are known.
  /// @param efforts per actuator
  /// @param multipliers per closure row, as Actuation::multipliers()
  void evaluate_under_efforts(const TreeMotion<S>& instant, const T* efforts, const std::vector<T>& multipliers);

  /// Only the coordinates and the tool, at the stepper's present moment: the motion without the forces.
  template <class Leader>
  void evaluate_kinematics(Leader& stepper) {
    const TreeMotion<S> now = instant_of(stepper);
    update_coordinates(now);
    if (mechanism_.tool) read_tool(now);
  }

  /// Whether moments can be found elsewhere (mechanics/lanes/lane_kernels.hpp): all coordinates linear in the tree's, nothing outside but
  /// weight, no friction, the efforts by one square system.
  bool can_use_lanes() const {
    return cut_joints_.empty() && external_.is_empty() && mechanism_.friction.empty() && actuation_.is_regular();
  }
  /// Adds what follows from the coordinates to a moment so found, of the motion that was seen last. Only where can_use_lanes().
  void complete_sample(const T* y, const T* dy, const T* ddy, SampleOf<T>& seen) const;

  /// Only the coordinates, so that the count of whole turns goes on.
  void update_coordinates(const TreeMotion<S>& instant);
  /// The next observation is the first of another motion.
  void restart() { first_ = true; }

 private:
  /// A coordinate that is none of y's: of a cut joint, linear in y where it is a planar angle, else read off the relative
  /// pose; of a floating spherical joint.
  struct CutCoordinate {
    CoordinateId coordinate;
    bool linear;
    LinearQuantityOf<T> quantity;
  };

  struct TreeCoordinate {
    CoordinateId coordinate;
    LinearQuantityOf<T> source;
  };

  template <class Leader>
  static TreeMotion<S> instant_of(Leader& stepper) {
    return {stepper.state(), stepper.y(), stepper.dy(), stepper.ddy(), stepper.time(), stepper.is_explicit()};
  }
  void classify_coordinates();
  bool balance_efforts(const TreeMotion<S>& now, const KinematicEquations<S>& equations, double duration);
  void set_state(const TreeMotion<S>& now, Detail detail);
  void read_coordinates(const TreeMotion<S>& now);
  void read_linear(const T* y, const T* dy, const T* ddy, SampleOf<T>& seen) const;
  void read_power(SampleOf<T>& seen) const;
  void initialise_turns(const T* y);
  void compute_cut_joints(const TreeMotion<S>& now);
  void balance_forces(const TreeMotion<S>& now);
  void compute_derived_quantities(const TreeMotion<S>& now, Detail detail, const std::vector<T>& multipliers);
  void read_tool(const TreeMotion<S>& now);
  void read_reactions(const TreeMotion<S>& now, const std::vector<T>& multipliers);

  const MechanismOf<T>& mechanism_;
  const Tree<S>& tree_;
  typename S::Vector gravity_, about_;
  ExternalForces<S> external_;
  Actuation<S> actuation_;
  std::vector<TreeCoordinate> tree_coordinates_;
  std::vector<CutCoordinate> cut_coordinates_;
  std::vector<JointId> cut_joints_;  ///< with coordinates that are not linear
  FixedFrame<S> tool_;
  LinearQuantityOf<T> tool_angle_;
  TreeState<S>* state_ = nullptr;
  std::vector<Wrench<S>> wrenches_;
  Wrench<S> external_total_, external_loads_;
  std::vector<T> tau_;
  SampleOf<T> sample_;
  bool first_ = true;
  T time_ = 0;  ///< of the last observation
};

extern template class SampleEvaluator<Planar>;
extern template class SampleEvaluator<Spatial>;

}  // namespace balance
