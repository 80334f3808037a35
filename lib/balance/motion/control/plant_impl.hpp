#pragma once
/// Implementation of Plant.

#include "balance/mechanics/dynamics/loop_dynamics.hpp"
#include "balance/mechanics/dynamics/term_magnitude_recorder.hpp"
#include "balance/motion/control/ode_integrator.hpp"
#include "balance/motion/control/plant.hpp"

#include <cmath>

namespace balance::control {

class Plant::Implementation {
 public:
  virtual ~Implementation() = default;
  virtual MotionOutcome start(double time, const VectorX& position, const VectorX& velocity) = 0;
  virtual MotionOutcome advance(double time, const VectorX& efforts) = 0;
  virtual MotionOutcome advance(double time, const EffortProfile& effort_profile) = 0;
  virtual int freedoms() const = 0;
  virtual const std::vector<CoordinateId>& independent() = 0;
  virtual double time() const = 0;
  virtual const VectorX& position() const = 0;
  virtual const VectorX& velocity() const = 0;
  virtual VectorX acceleration(const VectorX& efforts) = 0;
  virtual dynamics::EquationOfMotion equation() = 0;
  virtual const Sample& observe(const VectorX& efforts) = 0;
  virtual const results::TermMagnitudes& term_sizes() const = 0;
  virtual const results::TermMagnitudes& term_sizes_over_mobility() const = 0;
  virtual const PlantCost& cost() const = 0;
  virtual const std::vector<std::string>& notes() const = 0;
};

template <class S>
class PlantOf : public Plant::Implementation {
 public:
  PlantOf(const Mechanism& mechanism, const PlantOptions& options, const Vector3& about);

  MotionOutcome start(double time, const VectorX& q, const VectorX& dq) override;
  MotionOutcome advance(double time, const VectorX& efforts) override;
  MotionOutcome advance(double time, const EffortProfile& effort_profile) override;
  int freedoms() const override { return loops_.freedoms(); }
  const std::vector<CoordinateId>& independent() override;
  double time() const override { return time_; }
  const VectorX& position() const override { return position_; }
  const VectorX& velocity() const override { return velocity_; }
  VectorX acceleration(const VectorX& efforts) override;
  dynamics::EquationOfMotion equation() override;
  const Sample& observe(const VectorX& efforts) override;
  const results::TermMagnitudes& term_sizes() const override { return magnitude_recorder_->magnitudes(); }
  const results::TermMagnitudes& term_sizes_over_mobility() const override {
    return magnitude_recorder_->amplified_magnitudes();
  }
  const PlantCost& cost() const override { return cost_; }
  const std::vector<std::string>& notes() const override { return notes_; }

 private:
  /// Thrown if the integration cannot continue to a state: another branch, a singularity, or NaN.
  struct StateRejected {};

  dynamics::TreeMotion<S> instant() { return {loops_.state(), y_.data(), dy_.data(), ddy_.data(), time_, false}; }
  void require_started(const VectorX& efforts) const;
  void evaluate(const VectorX& efforts);
  void update_coordinates();
  void make_notes();

  // the integration: plant.cpp
  MotionOutcome advance_to(double time);
  MotionOutcome integrate_to(double end);
  void update_efforts(double time);
  bool try_step(double& time, double& step, bool& is_rejected, bool& has_new_coordinates);
  void derivative(const std::vector<double>& x, std::vector<double>& dxdt, double time);
  bool project_step(double time, double step, bool& has_new_coordinates);
  bool can_have_crossed_singularity(double step);
  void restore_step_start();
  void update_max_rate();
  bool choose_independent_columns(double time);
  void unpack_state(const std::vector<double>& x);
  void pack_state();

  // dry friction: plant_stick_slip.cpp
  bool update_friction(const VectorX& efforts);
  double friction_margin(double time);
  bool step_without_error_control(double step);
  double find_rate_minimum(double step) const;
  bool has_event_within(double step, double& high, double& margin);
  bool locate_event(double step, double& time);
  bool handle_event();
  bool overflows();
  MotionOutcome stop(MotionStatus status);

  const Mechanism& mechanism_;
  PlantOptions options_;
  typename S::Vector about_;
  dynamics::LoopDynamics<S> loops_;
  std::vector<CoordinateId> column_coordinates_, independent_;
  std::vector<kinematics::ColumnId> matrix_columns_;  ///< tree columns on which the closures' matrix depends
  std::optional<dynamics::SampleEvaluator<S>> evaluator_;
  std::optional<dynamics::TermMagnitudeRecorder<S>> magnitude_recorder_;
  Integrator integrator_;
  double time_ = 0, step_;
  double max_rate_ = 0;            ///< largest rate of any coordinate so far [rad/s, characteristic lengths per second]
  double event_time_ = -INFINITY;  ///< of the last event of dry friction
  int stalled_events_ = 0;         ///< number of successive events without any progress
  bool is_ignoring_events_ = false,
       has_noted_shared_stiction_ = false;  ///< the next step ignores events; shared stiction has been noted
  int suspect_steps_ = 0;                   ///< successive steps in which the closures may have been singular
  bool is_at_event_ = false;                ///< the last step ended at a dry friction event
  bool is_started_ = false, updates_coordinates_each_step_ = false;
  std::vector<double> x_, step_start_x_;  ///< tree coordinates, then their rates, lengths in characteristic lengths
  std::vector<double> load_breakpoints_, multipliers_;
  const EffortProfile* effort_profile_ = nullptr;  ///< that efforts_ follow; null: they are constant
  VectorX y_, dy_, ddy_, efforts_, position_, velocity_;
  VectorX start_ddy_;  ///< accelerations at step_start_x_; only with dry friction
  Sample sample_;
  PlantCost cost_;
  std::vector<std::string> notes_;
};

template <class S>
std::unique_ptr<Plant::Implementation> make_plant(const Mechanism& mechanism, const PlantOptions& options,
                                                  const Vector3& about) {
  return std::make_unique<PlantOf<S>>(mechanism, options, about);
}

extern template class PlantOf<kinematics::Planar>;
extern template class PlantOf<kinematics::Spatial>;

}  // namespace balance::control
