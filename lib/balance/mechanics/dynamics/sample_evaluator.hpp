#pragma once
/// Evaluates all quantities of a moving mechanism at one instant.

#include "balance/mechanics/dynamics/actuation.hpp"
#include "balance/mechanics/dynamics/external_forces.hpp"
#include "balance/mechanics/kinematics/motion_stepper.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"

#include <vector>

namespace balance::dynamics {

/// A tree in motion. The state holds poses and angular velocities, unless every coordinate is prescribed (is_explicit).
template <class S>
struct TreeMotion {
  kinematics::TreeState<S>& state;
  const typename S::Scalar *y, *dy, *ddy;
  typename S::Scalar time;
  bool is_explicit;
};

/// Which quantities to evaluate.
enum class Detail {
  kinematics,  ///< coordinates and tool
  forces,      ///< coordinates, efforts, power, centre of mass, shaking and ground wrenches, tool
  all,         ///< also reactions, energies, velocity of the centre of mass, derived quantities
};

template <class S>
class SampleEvaluator {
 public:
  using T = typename S::Scalar;

  /// @param about world point about which moments are taken
  SampleEvaluator(const MechanismOf<T>& mechanism, const kinematics::Tree<S>& tree, int freedoms,
                  const typename S::Vector& about);

  const Actuation<S>& actuation() const { return actuation_; }
  /// Lets a stepper monitor whether the actuators hold the mechanism throughout the motion.
  kinematics::RegularityMonitor<S>& regularity_monitor() { return actuation_; }
  const trajectory::SampleOf<T>& sample() const { return sample_; }
  /// Mutable, for callers that add further quantities (mobility).
  trajectory::SampleOf<T>& sample() { return sample_; }

  /// Evaluates the stepper's present instant with its present accelerations.
  /// @return false if the actuators do not hold the mechanism there
  template <class Stepper>
  bool evaluate(Stepper& stepper, Detail detail) {
    return evaluate(current_motion(stepper), stepper.equations(), stepper.duration(), detail);
  }

  /// Computes only the efforts, sample().effort, and the tree's generalised forces that they balance.
  bool solve_efforts(const TreeMotion<S>& motion, const kinematics::KinematicEquations<S>& equations, double duration);
  /// Generalised forces per tree coordinate that solve_efforts() found, friction included [N m or N].
  const std::vector<T>& generalised_forces() const { return tau_; }

  /// The efforts as a matrix times the tree's generalised forces, see Actuation::project.
  bool project(const kinematics::KinematicEquations<S>& equations, MatrixX& projection) {
    return actuation_.project(equations, projection);
  }

  /// Evaluates a given instant.
  /// @param equations evaluated there @param duration of the whole motion [s], for the rest threshold of friction
  bool evaluate(const TreeMotion<S>& motion, const kinematics::KinematicEquations<S>& equations, double duration,
                Detail detail);

  /// Evaluates everything at an instant of a motion whose efforts are known.
  /// @param efforts per actuator
  /// @param multipliers per closure row, as Actuation::multipliers()
  void evaluate_under_efforts(const TreeMotion<S>& motion, const T* efforts, const std::vector<T>& multipliers);

  /// Whether instants can be solved elsewhere (mechanics/lanes/lane_kernels.hpp): all coordinates linear in the tree's,
  /// no external force but weight, no friction, efforts from one square system.
  bool can_use_lanes() const {
    return cut_joints_.empty() && external_.is_empty() && mechanism_.friction.empty() && actuation_.is_regular();
  }
  /// Adds the quantities that follow from the coordinates to an instant so solved, of the motion evaluated last. @pre
  /// can_use_lanes()
  void complete_sample(const T* y, const T* dy, const T* ddy, trajectory::SampleOf<T>& sample) const;

  /// Evaluates only the coordinates, to keep the count of full turns.
  void update_coordinates(const TreeMotion<S>& motion);
  /// Adds full turns to the angles evaluated last, and to all later ones, such that they are nearest to these.
  /// @param near per coordinate of the mechanism [rad or m]
  void continue_turns(const VectorX& near);
  /// Makes the next evaluation the first of another motion.
  void restart() { is_first_ = true; }

 private:
  /// A coordinate outside y: of a cut joint, linear in y if it is a planar angle, else read off the relative pose; or
  /// of a floating spherical joint.
  struct CutCoordinate {
    CoordinateId coordinate;
    bool linear;
    kinematics::LinearQuantityOf<T> quantity;
  };

  struct TreeCoordinate {
    CoordinateId coordinate;
    kinematics::LinearQuantityOf<T> source;
  };

  template <class Stepper>
  static TreeMotion<S> current_motion(Stepper& stepper) {
    return {stepper.state(), stepper.y(), stepper.dy(), stepper.ddy(), stepper.time(), stepper.is_explicit()};
  }
  void classify_coordinates();
  bool balance_efforts(const TreeMotion<S>& motion, const kinematics::KinematicEquations<S>& equations,
                       double duration);
  void set_state(const TreeMotion<S>& motion, Detail detail);
  void read_coordinates(const TreeMotion<S>& motion);
  void read_linear(const T* y, const T* dy, const T* ddy, trajectory::SampleOf<T>& sample) const;
  void read_power(trajectory::SampleOf<T>& sample) const;
  void initialise_turns(const T* y);
  void compute_cut_joints(const TreeMotion<S>& motion);
  void balance_forces(const TreeMotion<S>& motion);
  void compute_derived_quantities(const TreeMotion<S>& motion, Detail detail, const std::vector<T>& multipliers);
  void read_tool(const TreeMotion<S>& motion);
  void read_reactions(const TreeMotion<S>& motion, const std::vector<T>& multipliers);

  const MechanismOf<T>& mechanism_;
  const kinematics::Tree<S>& tree_;
  typename S::Vector gravity_, about_;
  ExternalForces<S> external_;
  Actuation<S> actuation_;
  std::vector<TreeCoordinate> tree_coordinates_;
  std::vector<CutCoordinate> cut_coordinates_;
  std::vector<JointId> cut_joints_;  ///< with coordinates that are not linear
  kinematics::FixedFrame<S> tool_;
  kinematics::LinearQuantityOf<T> tool_angle_;
  kinematics::TreeState<S>* state_ = nullptr;
  std::vector<Wrench<S>> wrenches_;
  Wrench<S> external_total_, external_loads_;
  std::vector<T> tau_;
  trajectory::SampleOf<T> sample_;
  bool is_first_ = true;
  T last_time_ = 0;  ///< of the last evaluation
};

extern template class SampleEvaluator<kinematics::Planar>;
extern template class SampleEvaluator<kinematics::Spatial>;

}  // namespace balance::dynamics
