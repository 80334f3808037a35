#include "balance/gradients/motion_gradient.hpp"

#include "balance/gradients/moment.hpp"
#include "balance/gradients/schedule_gradient.hpp"
#include "balance/motion/configuration_text.hpp"
#include "balance/motion/walk.hpp"
#include "balance/motion/wording.hpp"
#include "balance/result/recorder.hpp"

#include <optional>
#include <stdexcept>

namespace balance {

namespace {

Sample values_of(const SampleOf<DualNumber>& sample, const Sample& over_doubles) {
  Sample out = over_doubles;
  out.mobility = sample.mobility.value;
  return out;
}

template <class S>
class DualRun {
 public:
  DualRun(const MechanismOf<DualNumber>& mechanism, const Trajectory& trajectory)
      : duals_(mechanism),
        mechanism_(balance::values_of(mechanism)),
        trajectory_(trajectory),
        needed_(prescribed_coordinates(trajectory)),
        tree_(compile<S>(mechanism_, needed_)),
        plan_(make_plan(mechanism_, tree_, trajectory)) {}

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
    schedule_.emplace(duals_, tree_, needed_, trajectory_, plan_);
    moment_.emplace(duals_, tree_, needed_, plan_.quantities, plan_.redundant, plan_.freedoms, about);
    make_room(out);
    Stepper<S> stepper(mechanism_, tree_, plan_);
    stepper.watch(observer.guard());
    MotionOutcome lost;
    const bool done = walk(stepper, *plan_.schedule, trajectory_.samples, [&](const Stop& stop) {
      if (stop.followed && stop.kind == Stop::Kind::after_jump) return true;
      if (!observer.observe(stepper, Detail::everything) || !look(stepper, stop)) {
        lost = no_longer_held(stepper.time(), configuration_text(mechanism_, tree_, stepper.y()));
        return false;
      }
      record(observer.last(), stop, out);
      return true;
    });
    out.run.outcome = {MotionStatus::done, plan_.schedule->duration(), "", observer.actuation().notes()};
    if (!done) out.run.outcome = lost.status == MotionStatus::unsolved ? stepper.outcome() : lost;
    return out;
  }

 private:
  void make_room(RunGradient& out) {
    const long rows = trajectory_.samples, more = most_rows_between(*plan_.schedule, rows);
    const auto prepare = [&](Result& result, long count) {
      name_columns(mechanism_, result);
      result.about = trajectory_.about;
      size_arrays(mechanism_, count, {}, result);
    };
    prepare(out.run, rows);
    prepare(out.between.rows, more);
    for (Result& result : out.derivatives) prepare(result, rows);
    for (BetweenSamples& between : out.derivatives_between) prepare(between.rows, more);
    recorders_.assign(dual_width + 1, Recorder(out.run));
  }

  bool look(Stepper<S>& stepper, const Stop& stop) {
    const Side side = stop.kind == Stop::Kind::before_jump ? Side::before : Side::after;
    schedule_->at(stepper.time(), side, target_);
    moment_->move(stepper.y(), target_);
    if (!moment_->observe(stepper.time(), stepper.duration(), Detail::everything)) return false;
    mobility_ = moment_->mobility();
    return true;
  }

  void record(const Sample& seen, const Stop& stop, RunGradient& out) {
    SampleOf<DualNumber> now = moment_->sample();
    now.mobility = mobility_;
    const bool sample = stop.kind == Stop::Kind::sample;
    const long row = sample ? stop.index : out.between.add(stop.next_sample);
    recorders_[dual_width].write(values_of(now, seen), row, sample ? out.run : out.between.rows);
    for (std::size_t k = 0; k < dual_width; ++k) {
      BetweenSamples& between = out.derivatives_between[k];
      if (!sample) between.add(stop.next_sample);
      recorders_[k].write(derivative_of(now, k), row, sample ? out.derivatives[k] : between.rows);
    }
  }

  const MechanismOf<DualNumber>& duals_;
  const Mechanism mechanism_;
  const Trajectory& trajectory_;
  std::vector<int> needed_;
  Tree<S> tree_;
  Plan<S> plan_;
  std::optional<ScheduleGradient> schedule_;
  std::optional<DualMoment<S>> moment_;
  DriveSampleOf<DualNumber> target_;
  DualNumber mobility_;
  std::vector<Recorder> recorders_;
};

}  // namespace

RunGradient differentiate(const MechanismOf<DualNumber>& mechanism, const Trajectory& trajectory) {
  if (trajectory.samples < 2) throw std::invalid_argument("a trajectory needs at least two samples");
  return mechanism.space == SpaceKind::planar ? DualRun<Planar>(mechanism, trajectory).run()
                                              : DualRun<Spatial>(mechanism, trajectory).run();
}

}  // namespace balance
