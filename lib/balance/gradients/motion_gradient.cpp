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
constexpr std::array of_forces = {"torque",         "power",        "com_acceleration", "shaking_force",
                                  "shaking_moment", "ground_force", "ground_moment"};

Extent extent_of(const std::vector<std::string>& quantities) {
  if (quantities.empty()) return Extent::all;
  const auto early = [](const std::string& name) {
    return std::find(of_forces.begin(), of_forces.end(), name) != of_forces.end();
  };
  return std::all_of(quantities.begin(), quantities.end(), early) ? Extent::forces : Extent::figures;
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
        trajectory_(converted<double>(trajectory, [](const DualNumber& x) { return x.value; })),
        needed_(prescribed_coordinates(trajectory_)),
        tree_(compile<S>(mechanism_, needed_)),
        plan_(make_plan(mechanism_, tree_, trajectory_)) {}

  RunGradient run() {
    RunGradient out;
    out.run.outcome = plan_.outcome;
    if (plan_.outcome.status != MotionStatus::done) return out;
    const typename S::Vector about = to_vector<S>(trajectory_.about);
    Observer<S> observer(mechanism_, tree_, plan_.freedoms, about);
    if (!observer.actuation().mismatch().empty()) {
      out.run.outcome = {MotionStatus::mismatch, 0, observer.actuation().mismatch(), {}};
      return out;
    }
    schedule_.emplace(duals_, tree_, needed_, dual_trajectory_, trajectory_, plan_);
    moment_.emplace(duals_, tree_, needed_, plan_.quantities, plan_.redundant, plan_.freedoms,
                    to_vector<OverDuals<S>>(dual_trajectory_.about));
    make_room(out);
    TreeLoads<S> loads(mechanism_, tree_, plan_.schedule->duration());
    TreeLoads<OverDuals<S>> dual_loads(duals_, moment_->tree(), plan_.schedule->duration());
    const auto carry = [&](double time) {
      loads.give(time, tree_);
      dual_loads.give(time, moment_->tree());
    };
    carry(0);
    Stepper<S> stepper(mechanism_, tree_, plan_);
    stepper.watch(observer.guard());
    MotionOutcome lost;
    const bool done = walk(stepper, *plan_.schedule, trajectory_.samples, [&](const Stop& stop) {
      if (stop.kind == Stop::Kind::after_jump) carry(stepper.time());
      // where the jump moves away from the sample, both count
      if (stop.followed && stop.kind == Stop::Kind::after_jump && !schedule_->moves(stop.index)) return true;
      if (!observer.observe(stepper, detail()) || !look(stepper, stop)) {
        lost = no_longer_held(stepper.time(), configuration_text(mechanism_, tree_, stepper.y()));
        return false;
      }
      record(observer.last(), stop, out);
      return true;
    });
    for (std::size_t k = 0; k < dual_width; ++k) out.openings[k] = moment_->openings(k);
    out.run.outcome = {MotionStatus::done, plan_.schedule->duration(), "", observer.actuation().notes()};
    if (!done) out.run.outcome = lost.status == MotionStatus::unsolved ? stepper.outcome() : lost;
    return out;
  }

 private:
  bool is_wanted(const char* quantity) const {
    return wanted_.empty() || std::find(wanted_.begin(), wanted_.end(), quantity) != wanted_.end();
  }
  Detail detail() const { return extent_ == Extent::forces ? Detail::forces : Detail::everything; }

  void make_room(RunGradient& out) {
    const long rows = trajectory_.samples, more = most_rows_between(*plan_.schedule, rows);
    const auto prepare = [&](Result& result, long count) {
      name_columns(mechanism_, result);
      result.about = trajectory_.about;
      size_arrays(mechanism_, count, {}, result);
      for (const QuantityKind& kind : quantity_table())
        if (!is_wanted(kind.name)) (result.*kind.member).resize(0, 0);
    };
    prepare(out.run, rows);
    prepare(out.between.rows, more);
    for (Result& result : out.derivatives) prepare(result, rows);
    for (BetweenSamples& between : out.derivatives_between) prepare(between.rows, more);
    recorders_.assign(dual_width + 1, Recorder(out.run));
  }

  bool look(Stepper<S>& stepper, const Stop& stop) {
    const Side side = stop.kind == Stop::Kind::before_jump ? Side::before : Side::after;
    const bool jump = stop.kind == Stop::Kind::before_jump || stop.kind == Stop::Kind::after_jump;
    const DualNumber time = schedule_->at(stepper.time(), side, jump ? stop.index : -1, target_);
    moment_->move(stepper.y(), target_);
    if (!moment_->observe(time, stepper.duration(), detail())) return false;
    if (is_wanted("mobility")) moment_->sample().mobility = moment_->mobility();
    return true;
  }

  void record(Sample& seen, const Stop& stop, RunGradient& out) {
    const SampleOf<DualNumber>& now = moment_->sample();
    const bool sample = stop.kind == Stop::Kind::sample;
    const long row = sample ? stop.index : out.between.add(stop.next_sample);
    seen.mobility = now.mobility.value;
    recorders_[dual_width].write(seen, row, sample ? out.run : out.between.rows);
    for (std::size_t k = 0; k < dual_width; ++k) {
      BetweenSamples& between = out.derivatives_between[k];
      if (!sample) between.add(stop.next_sample);
      write_derivative(now, k, extent_, derivative_);
      recorders_[k].write(derivative_, row, sample ? out.derivatives[k] : between.rows);
    }
  }

  const MechanismOf<DualNumber>& duals_;
  const TrajectoryOf<DualNumber>& dual_trajectory_;
  const std::vector<std::string>& wanted_;
  const Extent extent_ = extent_of(wanted_);
  const Mechanism mechanism_;
  const Trajectory trajectory_;
  std::vector<CoordinateId> needed_;
  Tree<S> tree_;
  Plan<S> plan_;
  std::optional<ScheduleGradient> schedule_;
  std::optional<DualMoment<S>> moment_;
  DriveSampleOf<DualNumber> target_;
  Sample derivative_;
  std::vector<Recorder> recorders_;
};

}  // namespace

RunGradient differentiate(const MechanismOf<DualNumber>& mechanism, const TrajectoryOf<DualNumber>& trajectory,
                          const std::vector<std::string>& quantities) {
  if (trajectory.samples < 2) throw std::invalid_argument("a trajectory needs at least two samples");
  if (binds_rates(values_of(mechanism)))
    throw std::invalid_argument(
        "there are no derivatives of a motion whose rates are bound, which all of the way decides");
  return in_space(mechanism.space, [&]<class S>(S) { return DualRun<S>(mechanism, trajectory, quantities).run(); });
}

}  // namespace balance
