#pragma once
/// What InverseDynamics is made of, for the plane and for space. Private to inverse.

#include "balance/dynamics/observer.hpp"
#include "balance/dynamics/term_sizes.hpp"
#include "balance/inverse/branch.hpp"
#include "balance/inverse/inverse_dynamics.hpp"

namespace balance {

/// A state as plain numbers: n each, and the time.
struct StateNumbers {
  const double *q, *dq, *ddq;
  double time;
};

/// Many states, one a row.
struct StateRows {
  Eigen::Ref<const Samples> q, dq, ddq;
  const VectorX& time;  ///< empty: 0 for all

  Eigen::Index rows() const { return q.rows(); }
  StateNumbers row(Eigen::Index k) const {
    return {q.data() + k * q.outerStride(), dq.data() + k * dq.outerStride(), ddq.data() + k * ddq.outerStride(),
            time.size() > 0 ? time[k] : 0};
  }
};

class InverseDynamics::Engine {
 public:
  Engine(Mechanism given, const InverseOptions& wishes) : mechanism(std::move(given)), options(wishes) {}
  virtual ~Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  virtual MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near, VectorX& coordinates) = 0;
  virtual MotionOutcome efforts(const StateNumbers& state, double* effort) = 0;
  virtual void efforts(const StateRows& states, EffortAnswers& table) = 0;
  virtual MotionOutcome observe(const StateNumbers& state, Sample& sample) = 0;
  /// Sizes of the terms that the last observed sample was the sum of, and the same over the mobility.
  virtual void measure_terms(const Sample& sample, double time, TermSizes& terms, TermSizes& grown) = 0;
  virtual MotionOutcome mass_matrix(const double* q, MatrixX& mass) = 0;
  virtual MotionOutcome bias(const StateNumbers& state, VectorX& bias) = 0;
  virtual MotionOutcome regressor(const StateNumbers& state, EffortRegressor& regressor) = 0;

  const Mechanism mechanism;
  const InverseOptions options;
  int freedoms = 0;
  bool open = false;  ///< nothing but a tree with a motor at every coordinate: the shortest way to the efforts
  std::vector<std::string> independent, notes;
};

template <class S>
class InverseEngine final : public InverseDynamics::Engine {
 public:
  InverseEngine(const Mechanism& mechanism, const InverseOptions& options);

  MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near, VectorX& coordinates) override;
  MotionOutcome efforts(const StateNumbers& state, double* effort) override;
  void efforts(const StateRows& states, EffortAnswers& table) override;
  MotionOutcome observe(const StateNumbers& state, Sample& sample) override;
  void measure_terms(const Sample& sample, double time, TermSizes& terms, TermSizes& grown) override;
  MotionOutcome mass_matrix(const double* q, MatrixX& mass) override;
  MotionOutcome bias(const StateNumbers& state, VectorX& bias) override;
  MotionOutcome regressor(const StateNumbers& state, EffortRegressor& regressor) override;

  const Branch<S>& branch() const { return branch_; }

 private:
  struct Motor {
    Column column;
    double inverse;  ///< of the actuated coordinate's ratio to the tree coordinate
  };

  MotionOutcome set_motion(const StateNumbers& state);
  MotionOutcome open_efforts(const StateNumbers& state, double* effort);
  Instant<S> instant(double time);
  MotionOutcome not_held(double time) const;
  MotionOutcome mismatch(double time) const;
  void fill_shaking(EffortRegressor& regressor);

  Branch<S> branch_;
  Observer<S> observer_;
  typename S::Vector gravity_;
  std::vector<Motor> motors_;
  std::vector<Wrench<S>> wrenches_;
  std::vector<double> tau_;
  MatrixX C_;
};

extern template class InverseEngine<Planar>;
extern template class InverseEngine<Spatial>;

}  // namespace balance
