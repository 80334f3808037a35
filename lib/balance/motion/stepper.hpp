#pragma once
/// Follows a plan through time: predictor from the last configurations, Newton on closures and prescribed quantities,
/// then velocities and accelerations from the same factorised matrix. Private to motion and dynamics.

#include "balance/motion/approach.hpp"
#include "balance/motion/passages.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace balance {

/// How an accepted step went: smallest pivots of the equations' and the guarded matrix at its end, how far it turned the mechanism
/// [rad, characteristic lengths], corrections.
struct StepMeasures {
  double pivot = 1, hold_pivot = 1, way = 0;
  int iterations = 0;
};

template <class S>
class Stepper {
 public:
  static constexpr int newton_steps = 8;  ///< for one configuration, at most
  /// Tried steps, and where something rolls evaluations of rates, for a thousandth of the motion, and how many more with every stop: on
  /// the way into a singularity steps become shorter without end.
  static constexpr long max_evaluations = 500'000, evaluations_per_stop = 200;
  static constexpr double longest_correction = 0.1;  ///< of a prediction, in radians or characteristic lengths

  /// @param tree, plan must outlive the stepper; the plan must be done. The stepper may rereference the tree's spherical joints.
  Stepper(const Mechanism& mechanism, Tree<S>& tree, const Plan<S>& plan);

  /// Another matrix to be watched, from begin() on; it must outlive the stepper.
  void watch(Guard<S>& guard) {
    guard_ = &guard;
    passages_.watch(guard);
  }

  /// Time 0. Also true of advance: on false outcome() says why, and the last good configuration stays.
  bool begin();
  /// On to a later time, in as many steps as it takes to stay on the same assembly mode.
  bool advance(double time);
  /// Accelerations on one side of the present time (advance() leaves those of the side `after`).
  void accelerate(Side side);

  /// A step to a moment that was found elsewhere (lanes/kernels.hpp), which this stepper would have accepted. Only the moment and
  /// what is told of the way go on, until catch_up().
  void follow(const MotionMoment& next, const StepMeasures& measures);
  /// Poses, velocities and the matrix at a moment followed to. @param keep and the next steps go on from there
  void catch_up(bool keep);
  /// How often coordinates began to be counted from other references, so that those before and after are not comparable.
  int references() const { return references_; }
  /// Columns on which the matrix depends.
  const std::vector<Column>& matrix_columns() const { return matrix_columns_; }
  double round_off() const { return round_off_; }  ///< scaled residual that cannot be improved upon

  const double* y() const { return now_.y.data(); }
  const double* dy() const { return now_.dy.data(); }
  const double* ddy() const { return now_.ddy.data(); }
  double time() const { return now_.time; }
  double duration() const { return plan_.schedule->duration(); }  ///< of the whole motion [s]
  int iterations() const { return iterations_; }
  const MotionOutcome& outcome() const { return outcome_; }
  /// How near the way so far has come to singularities, and what it has passed; see Passages.
  std::vector<std::string> notes() { return passages_.notes(); }
  const Equations<S>& equations() const { return equations_; }

  /// No equation has to be solved: every coordinate is prescribed. Then state() holds nothing.
  bool direct() const { return direct_; }
  /// Poses and angular velocities now; origins' velocities only if a closure slides; accelerations are scratch.
  State<S>& state() { return state_; }

  /// Smallest singular value of the scaled matrix at the present configuration.
  double mobility();

 private:
  enum class Attempt {
    done,
    no_convergence,
    far,        ///< from what was predicted
    singular,   ///< or may have been on the way
    exhausted,  ///< all evaluations
    not_held    ///< the guarded matrix is singular or may have been
  };

  Attempt step(double time);
  bool newton(VectorX& y);
  void predict(double time);
  bool integrate(double time);
  bool rates_at(double time, const VectorX& y, VectorX& dy);
  void differentiate(MotionMoment& moment);
  Attempt judge(const MotionMoment& next);
  Attempt accept();
  bool settle();
  void locate(Attempt attempt, double smallest);
  double turned(const MotionMoment& next) const;
  bool rereference_spherical_joints(double limit);
  void set_direct(double time);
  void stop(Attempt attempt, double smallest);
  std::pair<MotionStatus, const char*> diagnose(Attempt attempt);

  const Mechanism& mechanism_;
  Tree<S>& tree_;
  const Plan<S>& plan_;
  Equations<S> equations_;
  bool direct_ = false;
  bool rolls_ = false;  ///< there are closures of rates alone
  long evaluations_left_ = max_evaluations;
  double refill_time_ = 0;  ///< when they are counted anew [s]
  double round_off_;
  State<S> state_;
  DriveSample sample_;
  Guard<S>* guard_ = nullptr;
  std::vector<Column> matrix_columns_;
  double floor_ = least_regularity;    ///< smallest pivot that counts as regular
  Approach approach_, hold_approach_;  ///< of the matrix that determines the motion, of the guarded one
  Passages<S> passages_;
  double way_ = 0;         ///< how far the step last judged turns the mechanism
  double hold_pivot_ = 1;  ///< of the guarded matrix, at its end
  MotionMoment now_, before_, older_, next_;
  int past_ = 0;              ///< how many of before_, older_ continue smoothly into now_
  double stride_ = INFINITY;  ///< step to be tried next [s]
  int iterations_ = 0, references_ = 0;
  VectorX predicted_, trial_;
  std::vector<double> x_;      ///< right-hand side, then solution
  std::vector<double> rates_;  ///< dy at the configuration of the last Newton step
  MotionOutcome outcome_;
};

extern template class Stepper<Planar>;
extern template class Stepper<Spatial>;

}  // namespace balance
