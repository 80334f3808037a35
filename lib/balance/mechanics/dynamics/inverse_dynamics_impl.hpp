#pragma once
/// Implementation of InverseDynamics, for the plane and for space.

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/kinematics/assembly_branch.hpp"
#include "balance/mechanics/results/term_magnitudes.hpp"

namespace balance::dynamics {

/// A state as plain arrays of n entries each, and its time.
struct StateView {
  const double *q, *dq, *ddq;
  double time;
};

/// Many states, one per row.
struct StateTableView {
  Eigen::Ref<const Samples> q, dq, ddq;
  const VectorX& time;  ///< empty: 0 for all

  Eigen::Index rows() const { return q.rows(); }
  StateView row(Eigen::Index k) const {
    return {q.data() + k * q.outerStride(), dq.data() + k * dq.outerStride(), ddq.data() + k * ddq.outerStride(),
            time.size() > 0 ? time[k] : 0};
  }
};

class InverseDynamics::Implementation {
 public:
  Implementation(Mechanism source_mechanism, const InverseOptions& requested_options)
      : mechanism(std::move(source_mechanism)), options(requested_options) {}
  virtual ~Implementation() = default;
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  virtual MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near, VectorX& coordinates) = 0;
  virtual MotionOutcome efforts(const StateView& state, double* effort) = 0;
  virtual void efforts(const StateTableView& states, EffortBatch& table) = 0;
  virtual MotionOutcome observe(const StateView& state, Sample& sample) = 0;
  /// Magnitudes of the terms whose sum is the last observed sample, and the same amplified by the inverse of the
  /// mobility.
  virtual void measure_terms(const Sample& sample, double time, results::TermMagnitudes& terms,
                             results::TermMagnitudes& amplified) = 0;
  virtual MotionOutcome mass_matrix(const double* q, MatrixX& mass) = 0;
  virtual MotionOutcome bias(const StateView& state, VectorX& bias) = 0;
  virtual MotionOutcome regressor(const StateView& state, EffortRegressor& regressor) = 0;

  const Mechanism mechanism;
  const InverseOptions options;
  int freedoms = 0;
  bool is_fully_actuated_tree =
      false;  ///< only a tree with a motor at every coordinate: the fastest way to the efforts
  std::vector<std::string> independent, notes;
};

template <class S>
class InverseDynamicsOf final : public InverseDynamics::Implementation {
 public:
  InverseDynamicsOf(const Mechanism& mechanism, const InverseOptions& options);

  MotionOutcome assemble(const double* q, const std::vector<CoordinateValue>& near, VectorX& coordinates) override;
  MotionOutcome efforts(const StateView& state, double* effort) override;
  void efforts(const StateTableView& states, EffortBatch& table) override;
  MotionOutcome observe(const StateView& state, Sample& sample) override;
  void measure_terms(const Sample& sample, double time, results::TermMagnitudes& terms,
                     results::TermMagnitudes& amplified) override;
  MotionOutcome mass_matrix(const double* q, MatrixX& mass) override;
  MotionOutcome bias(const StateView& state, VectorX& bias) override;
  MotionOutcome regressor(const StateView& state, EffortRegressor& regressor) override;

  const kinematics::AssemblyBranch<S>& branch() const { return branch_; }

 private:
  struct ActuatedColumn {
    kinematics::ColumnId column;
    double inverse;  ///< 1 / ratio of the actuated coordinate to the tree coordinate
  };

  MotionOutcome set_state(const StateView& state);
  MotionOutcome solve_open_tree(const StateView& state, double* effort);
  TreeMotion<S> current_motion(double time);
  MotionOutcome make_not_held_outcome(double time) const;
  MotionOutcome mismatch(double time) const;
  void fill_shaking(EffortRegressor& regressor);

  kinematics::AssemblyBranch<S> branch_;
  SampleEvaluator<S> sample_evaluator_;
  typename S::Vector gravity_;
  std::vector<ActuatedColumn> actuated_columns_;
  std::vector<Wrench<S>> wrenches_;
  std::vector<double> tau_;
  MatrixX C_;
};

extern template class InverseDynamicsOf<kinematics::Planar>;
extern template class InverseDynamicsOf<kinematics::Spatial>;

}  // namespace balance::dynamics
