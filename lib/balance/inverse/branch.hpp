#pragma once
/// One assembly mode of a mechanism, followed from state to state: independent coordinates to tree coordinates that close the loops,
/// with their rates and accelerations. Private to inverse.

#include "balance/inverse/independent.hpp"
#include "balance/motion/equations.hpp"
#include "balance/motion/motion.hpp"
#include "balance/motion/plan.hpp"

#include <vector>

namespace balance {

template <class S>
class Branch {
 public:
  /// @param mechanism must outlive the branch
  Branch(const Mechanism& mechanism, IndependentChoice<S> choice);
  Branch(const Branch&) = delete;
  Branch& operator=(const Branch&) = delete;

  const Tree<S>& tree() const { return tree_; }
  const Drive<S>& drive() const { return drive_; }
  const Equations<S>& equations() const { return equations_; }
  int freedoms() const { return freedoms_; }
  /// Coordinates that the tree was compiled with.
  const std::vector<CoordinateId>& needed() const { return needed_; }
  const std::vector<CoordinateId>& independent() const { return independent_; }
  bool redundant() const { return redundant_; }
  /// See IndependentChoice::note.
  const std::string& note() const { return note_; }
  /// Without loops nothing has to be solved: state() then holds no poses.
  bool direct() const { return direct_; }

  /// Moreover the tree's coordinates are the independent ones, in their order.
  bool plain() const { return plain_; }

  /// Finds the configuration anew, nearest to the mechanism's assembly values.
  /// @param near takes their place where it names the same coordinates
  MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near);
  bool assembled() const { return assembled_; }

  /// On to other independent coordinates, along the straight way; assembles the first ones. On failure the configuration stays.
  MotionOutcome go(const double* q) {
    if (!direct_) return go_round(q);
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

  State<S>& state() { return state_; }
  const double* y() const { return y_.data(); }
  const double* dy() const { return dy_.data(); }
  const double* ddy() const { return ddy_.data(); }
  /// Newton steps of the last go().
  int iterations() const { return iterations_; }
  /// Smallest singular value of the scaled equations; 1 without loops.
  double mobility() { return direct_ ? 1 : equations_.least_singular_value(); }
  /// All coordinates of the mechanism; angles that are none of the tree's in (−π, π].
  VectorX coordinates() const;

 private:
  struct Mark {
    VectorX y;
    std::vector<double> q;
    std::vector<typename S::Rotation> references;  ///< of the spherical joints
  };

  /// Values, rates or accelerations of an open tree. @param constant 1 for values: their offsets count
  void set_direct(const double* q, double constant, double* y) const {
    for (std::size_t k = 0; k < columns_.size(); ++k)
      y[columns_[k].column] = (q[k] - constant * columns_[k].offset) * columns_[k].inverse;
  }
  MotionOutcome go_round(const double* q);
  bool step(const double* q);
  bool walk(const double* q);
  MotionOutcome lead(const double* q, const char* words);
  bool newton(VectorX& y, const double* q);
  bool settle();
  bool rereference_spherical_joints();
  Plan<S> plan_to(const double* q) const;
  Mark mark() const;
  void go_back(const Mark& mark);

  struct OwnColumn {
    Column column;
    double inverse, offset;  ///< y[column] = (q − offset) · inverse
  };

  const Mechanism& mechanism_;
  Tree<S> tree_;
  std::vector<CoordinateId> needed_, independent_;
  std::string note_;
  int freedoms_;
  bool redundant_, direct_, plain_ = false;
  Drive<S> drive_;
  Equations<S> equations_;
  double round_off_;
  std::vector<OwnColumn> columns_;
  std::vector<Column> matrix_columns_;  ///< columns that the closures' matrix depends on
  std::vector<typename S::Rotation> first_references_;
  State<S> state_;
  DriveSample sample_;
  VectorX y_, dy_, ddy_, predicted_, trial_;
  std::vector<double> q_, x_;
  bool assembled_ = false;
  bool fresh_ = false;  ///< equations and poses are those of y_
  int iterations_ = 0;
};

extern template class Branch<Planar>;
extern template class Branch<Spatial>;

}  // namespace balance
