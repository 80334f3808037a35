#pragma once
/// One assembly mode of a mechanism, followed from state to state: maps independent coordinates to tree coordinates
/// that close the loops, with their rates and accelerations.

#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/kinematic_equations.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <string>
#include <vector>

namespace balance::kinematics {

// The independent coordinates in which a state of a mechanism is given.

/// A mechanism compiled so that its independent coordinates are tree coordinates that need no reference orientation.
template <class S>
struct IndependentCoordinates {
  Tree<S> tree;
  std::vector<CoordinateId> needed;       ///< coordinates that the tree was compiled with
  std::vector<CoordinateId> coordinates;  ///< as many as freedoms; they determine the others
  int freedoms = 0;                       ///< computed by rank
  bool redundant = false;                 ///< closures have more rows than rank
  std::string note;                       ///< names coordinates chosen automatically; else empty
};

/// @param names may be empty: see InverseOptions::independent
/// @throws std::invalid_argument if the loops cannot be closed, a name does not exist, or the coordinates do not
///        determine the motion
template <class S>
IndependentCoordinates<S> choose_independent_coordinates(const Mechanism& mechanism,
                                                         const std::vector<std::string>& names);

/// Index of the mechanism's coordinate of this name.
/// @param what the option that names it, for the message
/// @throws std::invalid_argument if there is none
int require_coordinate(const Mechanism& mechanism, const std::string& name, const char* what);

extern template IndependentCoordinates<Planar> choose_independent_coordinates<Planar>(const Mechanism&,
                                                                                      const std::vector<std::string>&);
extern template IndependentCoordinates<Spatial> choose_independent_coordinates<Spatial>(
    const Mechanism&, const std::vector<std::string>&);

template <class S>
class AssemblyBranch {
 public:
  /// @param mechanism must outlive the branch
  AssemblyBranch(const Mechanism& mechanism, IndependentCoordinates<S> choice);
  AssemblyBranch(const AssemblyBranch&) = delete;
  AssemblyBranch& operator=(const AssemblyBranch&) = delete;

  const Tree<S>& tree() const { return tree_; }
  const Drive<S>& drive() const { return drive_; }
  const KinematicEquations<S>& equations() const { return equations_; }
  int freedoms() const { return freedoms_; }
  /// Coordinates that the tree was compiled with.
  const std::vector<CoordinateId>& required_coordinates() const { return required_coordinates_; }
  const std::vector<CoordinateId>& independent() const { return independent_; }
  bool has_redundant_closures() const { return has_redundant_closures_; }
  /// See IndependentCoordinates::note.
  const std::string& note() const { return note_; }
  /// Whether there are no loops, so that nothing has to be solved; state() then holds no poses.
  bool is_explicit() const { return is_explicit_; }

  /// Whether, in addition, the tree's coordinates are the independent ones in their order.
  bool has_identity_map() const { return has_identity_map_; }

  /// Searches for the configuration nearest to the mechanism's assembly values.
  /// @param near overrides these for the coordinates that it names
  MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near);
  bool is_assembled() const { return assembled_; }

  /// Moves to other independent coordinates along the straight line; the first call assembles. On failure the
  /// configuration does not change.
  /// @param time of the values of constraints on speeds [s]
  MotionOutcome move_to(const double* q, double time) {
    sample_.constraint_time = time;
    if (!is_explicit_) return move_closed_to(q);
    set_explicit(q, 1, y_.data());
    MotionOutcome outcome;
    outcome.status = MotionStatus::done;
    return outcome;
  }

  /// Sets the rates at the configuration of move_to(). The state then holds angular velocities and, if a closure
  /// slides, those of the origins.
  void set_rates(const double* dq);
  /// Sets the accelerations, after the rates. The state's accelerations are scratch.
  void set_accelerations(const double* ddq);
  /// Rates of the tree coordinates per rate of each independent coordinate: columns × freedoms. Keeps rates and
  /// accelerations.
  void fill_transformation(MatrixX& C);

  TreeState<S>& state() { return state_; }
  const double* y() const { return y_.data(); }
  const double* dy() const { return dy_.data(); }
  const double* ddy() const { return ddy_.data(); }
  /// Newton steps of the last move_to().
  int iterations() const { return iterations_; }
  /// Smallest singular value of the scaled equations; 1 without loops.
  double mobility() { return is_explicit_ ? 1 : equations_.min_singular_value(); }
  /// All coordinates of the mechanism; angles that are not tree coordinates in (−π, π].
  VectorX coordinates() const;

 private:
  struct Snapshot {
    VectorX y;
    std::vector<double> q;
    std::vector<typename S::Rotation> references;  ///< of the spherical joints
  };

  /// Values, rates or accelerations of an open tree. @param constant 1 for values, whose offsets count; else 0
  void set_explicit(const double* q, double constant, double* y) const {
    for (std::size_t k = 0; k < columns_.size(); ++k)
      y[columns_[k].column] = (q[k] - constant * columns_[k].offset) * columns_[k].inverse;
  }
  MotionOutcome move_closed_to(const double* q);
  bool step(const double* q);
  bool step_repeatedly(const double* q);
  MotionOutcome track_with_stepper(const double* q, const char* reason_prefix);
  bool newton(VectorX& y, const double* q);
  bool update_equations();
  bool reset_spherical_references();
  CompiledTrajectory<S> compile_path_to(const double* q) const;
  Snapshot snapshot() const;
  void restore(const Snapshot& saved);

  struct IndependentColumn {
    ColumnId column;
    double inverse, offset;  ///< y[column] = (q − offset) · inverse
  };

  const Mechanism& mechanism_;
  Tree<S> tree_;
  std::vector<CoordinateId> required_coordinates_, independent_;
  std::string note_;
  int freedoms_;
  bool has_redundant_closures_, is_explicit_, has_identity_map_ = false;
  Drive<S> drive_;
  KinematicEquations<S> equations_;
  double residual_tolerance_;
  std::vector<IndependentColumn> columns_;
  std::vector<ColumnId> matrix_columns_;  ///< columns that the closures' matrix depends on
  std::vector<typename S::Rotation> initial_references_;
  TreeState<S> state_;
  trajectory::DriveSample sample_;
  VectorX y_, dy_, ddy_, predicted_, trial_;
  std::vector<double> q_, x_;
  bool assembled_ = false;
  bool has_current_equations_ = false;  ///< equations and poses are up to date with y_
  int iterations_ = 0;
};

extern template class AssemblyBranch<Planar>;
extern template class AssemblyBranch<Spatial>;

}  // namespace balance::kinematics
