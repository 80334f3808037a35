#pragma once
/// One assembly mode of a mechanism, followed from state to state: independent coordinates to tree coordinates that close the loops,
/// with their rates and accelerations.

#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/kinematic_equations.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <string>
#include <vector>

namespace balance {

// Which coordinates a state of a mechanism is given in.

/// A mechanism compiled so that its independent coordinates are coordinates of the tree that need no reference orientation.
template <class S>
struct IndependentCoordinates {
  Tree<S> tree;
  std::vector<CoordinateId> needed;       ///< coordinates that the tree was compiled with
  std::vector<CoordinateId> coordinates;  ///< as many as freedoms, and they determine the others
  int freedoms = 0;                       ///< by rank
  bool redundant = false;                 ///< closures have more rows than rank
  std::string note;                       ///< which coordinates were chosen if nobody asked for them; else empty
};

/// @param names may be empty: see InverseOptions::independent
/// @throws std::invalid_argument if the loops cannot be closed, or a name does not exist, or these coordinates do not determine the
///         motion
template <class S>
IndependentCoordinates<S> choose_independent_coordinates(const Mechanism& mechanism,
                                                         const std::vector<std::string>& names);

/// The mechanism's coordinate of this name.
/// @param what is named, for the message
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
  const std::vector<CoordinateId>& required_coordinates() const { return needed_; }
  const std::vector<CoordinateId>& independent() const { return independent_; }
  bool has_redundant_closures() const { return redundant_; }
  /// See IndependentCoordinates::note.
  const std::string& note() const { return note_; }
  /// Without loops nothing has to be solved: state() then holds no poses.
  bool is_explicit() const { return direct_; }

  /// Moreover the tree's coordinates are the independent ones, in their order.
  bool has_identity_map() const { return plain_; }

  /// Finds the configuration anew, nearest to the mechanism's assembly values.
  /// @param near takes their place where it names the same coordinates
  MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near);
  bool is_assembled() const { return assembled_; }

  /// On to other independent coordinates, along the straight way; assembles the first ones. On failure the configuration stays.
  MotionOutcome move_to(const double* q) {
    if (!direct_) return move_closed_to(q);
    set_direct(q, 1, y_.data());
    MotionOutcome done;
    done.status = MotionStatus::done;
    return done;
  }

  /// Rates where go() has led. Then the state holds angular velocities and, if a closure slides, those of the origins.
  void set_rates(const double* dq);
  /// Accelerations, after the rates. The state's accelerations are scratch.
  void set_accelerations(const double* ddq);
  /// Tree coordinates' rates per rate of each independent coordinate: columns × freedoms. Forgets nothing.
  void fill_transformation(MatrixX& C);

  TreeState<S>& state() { return state_; }
  const double* y() const { return y_.data(); }
  const double* dy() const { return dy_.data(); }
  const double* ddy() const { return ddy_.data(); }
  /// Newton steps of the last go().
  int iterations() const { return iterations_; }
  /// Smallest singular value of the scaled equations; 1 without loops.
  double mobility() { return direct_ ? 1 : equations_.min_singular_value(); }
  /// All coordinates of the mechanism; angles that are none of the tree's in (−π, π].
  VectorX coordinates() const;

 private:
  struct Snapshot {
    VectorX y;
    std::vector<double> q;
    std::vector<typename S::Rotation> references;  ///< of the spherical joints
  };

  /// Values, rates or accelerations of an open tree. @param constant 1 for values: their offsets count
  void set_direct(const double* q, double constant, double* y) const {
    for (std::size_t k = 0; k < columns_.size(); ++k)
      y[columns_[k].column] = (q[k] - constant * columns_[k].offset) * columns_[k].inverse;
  }
  MotionOutcome move_closed_to(const double* q);
  bool step(const double* q);
  bool step_repeatedly(const double* q);
  MotionOutcome track_with_stepper(const double* q, const char* words);
  bool newton(VectorX& y, const double* q);
  bool update_equations();
  bool reset_spherical_references();
  CompiledTrajectory<S> compile_path_to(const double* q) const;
  Snapshot snapshot() const;
  void restore(const Snapshot& mark);

  struct IndependentColumn {
    ColumnId column;
    double inverse, offset;  ///< y[column] = (q − offset) · inverse
  };

  const Mechanism& mechanism_;
  Tree<S> tree_;
  std::vector<CoordinateId> needed_, independent_;
  std::string note_;
  int freedoms_;
  bool redundant_, direct_, plain_ = false;
  Drive<S> drive_;
  KinematicEquations<S> equations_;
  double round_off_;
  std::vector<IndependentColumn> columns_;
  std::vector<ColumnId> matrix_columns_;  ///< columns that the closures' matrix depends on
  std::vector<typename S::Rotation> initial_references_;
  TreeState<S> state_;
  DriveSample sample_;
  VectorX y_, dy_, ddy_, predicted_, trial_;
  std::vector<double> q_, x_;
  bool assembled_ = false;
  bool has_current_equations_ = false;  ///< equations and poses are those of y_
  int iterations_ = 0;
};

extern template class AssemblyBranch<Planar>;
extern template class AssemblyBranch<Spatial>;

}  // namespace balance
