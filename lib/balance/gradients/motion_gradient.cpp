#include "balance/gradients/motion_gradient.hpp"

#include "balance/gradients/moment.hpp"
#include "balance/gradients/schedule_gradient.hpp"
#include "balance/kinematics/tree_loads.hpp"
#include "balance/motion/configuration_text.hpp"
#include "balance/motion/walk.hpp"
#include "balance/motion/wording.hpp"
#include "balance/result/recorder.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>

namespace balance {

namespace {

/// What is known without Detail::everything.
constexpr std::array force_quantities = {"torque",         "power",        "com_acceleration", "shaking_force",
                                         "shaking_moment", "ground_force", "ground_moment"};

DerivativeDetail extent_of(const std::vector<std::string>& quantities) {
  if (quantities.empty()) return DerivativeDetail::all;
  const auto early = [](const std::string& name) {
    return std::find(force_quantities.begin(), force_quantities.end(), name) != force_quantities.end();
  };
  return std::all_of(quantities.begin(), quantities.end(), early) ? DerivativeDetail::forces
                                                                  : DerivativeDetail::figures;
}

template <class S>
class DualRun {
 public:
  DualRun(const MechanismOf<DualNumber>& mechanism, const TrajectoryOf<DualNumber>& trajectory,
          const std::vector<std::string>& quantities)
      : duals_(mechanism),
        dual_trajectory_(trajectory),
        wanted_(quantities),
        mechanism_(balance::values_of(mechanism)),
        trajectory_(cast_scalar<double>(trajectory, [](const DualNumber& x) { return x.value; })),
        needed_(prescribed_coordinates(trajectory_)),
        tree_(compile_tree<S>(mechanism_, needed_)),
        plan_(compile_trajectory(mechanism_, tree_, trajectory_)) {}

  RunGradient run() {
    RunGradient out;
    out.run.outcome = plan_.outcome;
    if (plan_.outcome.status != MotionStatus::done) return out;
    const typename S::Vector about = to_vector<S>(trajectory_.about);
    SampleEvaluator<S> observer(mechanism_, tree_, plan_.freedoms, about);
    if (!observer.actuation().mismatch().empty()) {
      out.run.outcome = {MotionStatus::mismatch, 0, observer.actuation().mismatch(), {}};
      return out;
    }
    schedule_.emplace(duals_, tree_, needed_, dual_trajectory_, trajectory_, plan_);
    moment_.emplace(duals_, tree_, needed_, plan_.quantities, plan_.has_redundant_closures, plan_.freedoms,
                    to_vector<DualSpace<S>>(dual_trajectory_.about));
    allocate(out);
    TreePayloads<S> loads(mechanism_, tree_, plan_.prescribed_motion->duration());
    TreePayloads<DualSpace<S>> dual_loads(duals_, moment_->tree(), plan_.prescribed_motion->duration());
    const auto carry = [&](double time) {
      loads.apply(time, tree_);
      dual_loads.apply(time, moment_->tree());
    };
    carry(0);
    MotionStepper<S> stepper(mechanism_, tree_, plan_);
    stepper.set_regularity_monitor(observer.regularity_monitor());
    MotionOutcome lost;
    const bool done =
        visit_time_grid(stepper, *plan_.prescribed_motion, trajectory_.samples, [&](const TimeGridPoint& stop) {
          if (stop.kind == TimeGridPoint::Kind::after_jump) carry(stepper.time());
          // where the jump moves away from the sample, both count
          if (stop.has_coincident_next && stop.kind == TimeGridPoint::Kind::after_jump &&
              !schedule_->is_moving_jump(stop.index))
            return true;
          if (!observer.evaluate(stepper, detail()) || !differentiate_at(stepper, stop)) {
            lost = make_actuation_singularity_outcome(stepper.time(),
                                                      format_configuration(mechanism_, tree_, stepper.y()));
            return false;
          }
          record(observer.sample(), stop, out);
          return true;
        });
    for (std::size_t k = 0; k < dual_width; ++k) out.closure_gaps[k] = moment_->closure_gaps(k);
    out.run.outcome = {MotionStatus::done, plan_.prescribed_motion->duration(), "", observer.actuation().notes()};
    if (!done) out.run.outcome = lost.status == MotionStatus::unsolved ? stepper.outcome() : lost;
    return out;
  }

 private:
  bool is_wanted(const char* quantity) const {
    return wanted_.empty() || std::find(wanted_.begin(), wanted_.end(), quantity) != wanted_.end();
  }
  Detail detail() const { return extent_ == DerivativeDetail::forces ? Detail::forces : Detail::all; }

  void allocate(RunGradient& out) {
    const long rows = trajectory_.samples, more = max_intermediate_rows(*plan_.prescribed_motion, rows);
    const auto prepare = [&](RunResult& result, long count) {
      name_columns(mechanism_, result);
      result.moment_reference = trajectory_.about;
      resize_arrays(mechanism_, count, {}, result);
      for (const QuantityDefinition& kind : quantity_table())
        if (!is_wanted(kind.name)) (result.*kind.member).resize(0, 0);
    };
    prepare(out.run, rows);
    prepare(out.intermediate.rows, more);
    for (RunResult& result : out.derivatives) prepare(result, rows);
    for (IntermediateSamples& between : out.derivatives_between) prepare(between.rows, more);
    recorders_.assign(dual_width + 1, ResultRecorder(out.run));
  }

  bool differentiate_at(MotionStepper<S>& stepper, const TimeGridPoint& stop) {
    const Side side = stop.kind == TimeGridPoint::Kind::before_jump ? Side::before : Side::after;
    const bool jump = stop.kind == TimeGridPoint::Kind::before_jump || stop.kind == TimeGridPoint::Kind::after_jump;
    const DualNumber time = schedule_->at(stepper.time(), side, jump ? stop.index : -1, target_);
    moment_->differentiate_motion(stepper.y(), target_);
    if (!moment_->evaluate(time, stepper.duration(), detail())) return false;
    if (is_wanted("mobility")) moment_->sample().mobility = moment_->mobility();
    return true;
  }

  void record(Sample& seen, const TimeGridPoint& stop, RunGradient& out) {
    const SampleOf<DualNumber>& now = moment_->sample();
    const bool sample = stop.kind == TimeGridPoint::Kind::sample;
    const long row = sample ? stop.index : out.intermediate.add(stop.next_sample);
    seen.mobility = now.mobility.value;
    recorders_[dual_width].write(seen, row, sample ? out.run : out.intermediate.rows);
    for (std::size_t k = 0; k < dual_width; ++k) {
      IntermediateSamples& between = out.derivatives_between[k];
      if (!sample) between.add(stop.next_sample);
      write_derivative(now, k, extent_, derivative_);
      recorders_[k].write(derivative_, row, sample ? out.derivatives[k] : between.rows);
    }
  }

  const MechanismOf<DualNumber>& duals_;
  const TrajectoryOf<DualNumber>& dual_trajectory_;
  const std::vector<std::string>& wanted_;
  const DerivativeDetail extent_ = extent_of(wanted_);
  const Mechanism mechanism_;
  const Trajectory trajectory_;
  std::vector<CoordinateId> needed_;
  Tree<S> tree_;
  CompiledTrajectory<S> plan_;
  std::optional<PrescribedMotionGradient> schedule_;
  std::optional<DualEvaluator<S>> moment_;
  DriveSampleOf<DualNumber> target_;
  Sample derivative_;
  std::vector<ResultRecorder> recorders_;
};

}  // namespace

RunGradient differentiate_run(const MechanismOf<DualNumber>& mechanism, const TrajectoryOf<DualNumber>& trajectory,
                              const std::vector<std::string>& quantities) {
  if (trajectory.samples < 2) throw std::invalid_argument("a trajectory needs at least two samples");
  if (has_velocity_constraints(values_of(mechanism)))
    throw std::invalid_argument(
        "there are no derivatives of a motion whose rates are bound, which all of the way decides");
  return dispatch_space(mechanism.space,
                        [&]<class S>(S) { return DualRun<S>(mechanism, trajectory, quantities).run(); });
}

}  // namespace balance
