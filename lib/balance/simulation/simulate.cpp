#include "balance/simulation/simulate.hpp"

#include "balance/base/extrema.hpp"
#include "balance/dynamics/term_meter.hpp"
#include "balance/kinematics/tree_loads.hpp"
#include "balance/motion/configuration_text.hpp"
#include "balance/motion/law_curve.hpp"
#include "balance/motion/timing_bounds.hpp"
#include "balance/motion/wording.hpp"
#include "balance/result/metrics.hpp"
#include "balance/result/overflow.hpp"
#include "balance/result/recorder.hpp"
#include "balance/result/round_off.hpp"
#include "balance/simulation/group_stepper.hpp"
#include "balance/simulation/payload_watch.hpp"
#include "balance/timing/time_law.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance {

namespace {

/// Which moments' terms are measured: some fifty evenly spread ones, and wherever accelerations are larger or the mobility is
/// smaller than at all before.
class Selection {
 public:
  explicit Selection(long samples) : stride_(std::max(1L, samples / 50)) {}

  bool takes(long row, const VectorX& accelerations, double mobility) {
    const double fastest = max_abs(accelerations);
    if (row % stride_ != 0 && fastest <= 1.25 * fastest_ && mobility >= 0.8 * mobility_) return false;
    fastest_ = std::max(fastest_, fastest);
    mobility_ = std::min(mobility_, mobility);
    return true;
  }

 private:
  long stride_;
  double fastest_ = 0, mobility_ = 1;
};

template <class S>
class Run {
 public:
  Run(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        progress_(progress),
        tree_(compile<S>(mechanism, prescribed_coordinates(trajectory))),
        plan_(make_plan(mechanism, tree_, trajectory)) {}

  Result run() {
    Result result;
    result.outcome = plan_.outcome;
    if (plan_.outcome.status != MotionStatus::done) return result;
    const typename S::Vector about = to_vector<S>(trajectory_.about);
    Observer<S> observer(mechanism_, tree_, plan_.freedoms, about);
    if (!observer.actuation().mismatch().empty()) {
      result.outcome = {MotionStatus::mismatch, 0, observer.actuation().mismatch(), {}};
      return result;
    }
    Stepper<S> stepper(mechanism_, tree_, plan_);
    stepper.watch(observer.guard());
    name_columns(mechanism_, result);
    result.about = trajectory_.about;
    BetweenSamples between;
    name_columns(mechanism_, between.rows);
    size_arrays(mechanism_, trajectory_.samples, {}, result);
    size_arrays(mechanism_, most_rows_between(*plan_.schedule, trajectory_.samples), {}, between.rows);
    recorder_.emplace(result);
    const double clock = 1 / plan_.schedule->duration(), fall = mechanism_.gravity.norm() / tree_.length;
    meter_.emplace(mechanism_, tree_, about, RestScale{clock, std::max(clock * clock, fall)});
    loads_.emplace(mechanism_, tree_, plan_.schedule->duration());
    loads_->give(0, tree_);
    GroupStepper<S> leader(mechanism_, tree_, plan_, {plan_.schedule->duration(), trajectory_.samples}, about, stepper,
                           observer);
    if (!follow(leader, stepper, observer, result, between)) {
      Result stopped;
      stopped.outcome = lost_;
      return stopped;
    }
    set_round_off(result, meter_->terms(), meter_->grown());
    add_metrics(result, between);
    if (const auto overflow = find_overflow(result, between, mechanism_)) {
      Result stopped;
      stopped.outcome = *overflow;
      return stopped;
    }
    clear_round_off(result);
    trace_law(*plan_.schedule, result.phase_plane);
    result.outcome = {MotionStatus::done, plan_.schedule->duration(), "", observer.actuation().notes()};
    if (const std::string note = sampling_note(result, between); !note.empty()) result.outcome.notes.push_back(note);
    for (std::string& note : stepper.notes()) result.outcome.notes.push_back(std::move(note));
    for (const PassiveFreedom& spin : tree_.locked_freedoms)
      result.outcome.notes.push_back(locked_freedom(mechanism_, spin));
    add_payload_notes(mechanism_, plan_.schedule->duration(), result);
    return result;
  }

 private:
  /// Through the whole walk.
  bool follow(GroupStepper<S>& leader, Stepper<S>& stepper, Observer<S>& observer, Result& result,
              BetweenSamples& between) {
    const long between_reports = 1 + (1 << 15) / (8 + tree_.columns);  // a large mechanism's samples take longer
    const auto see = [&](const Stop& stop) {
      if (progress_ && stop.index % between_reports == between_reports - 1)
        progress_(static_cast<double>(stop.index) / static_cast<double>(trajectory_.samples));
      if (stop.kind == Stop::Kind::sample) return record(leader, stepper, observer, result, stop.index);
      if (stop.followed && stop.kind == Stop::Kind::after_jump) return true;
      return record(leader, stepper, observer, between.rows, between.add(stop.next_sample));
    };
    const bool done = walk(leader, *plan_.schedule, trajectory_.samples, [&](const Stop& stop) {
      if (stop.kind == Stop::Kind::after_jump) change_loads(leader, result);
      return see(stop);
    });
    if (!done && lost_.status == MotionStatus::unsolved) lost_ = stepper.outcome();
    return done;
  }

  /// On the far side of a jump, whose near side was seen last: payloads that are taken up or set down there.
  void change_loads(GroupStepper<S>& leader, Result& result) {
    const int before = loads_->now();
    const VectorX effort = leader.last().effort;
    if (!loads_->give(leader.time(), tree_)) return;
    leader.reload();
    if (!leader.observe()) return;  // who records the moment finds the same
    const Instant<S> now = leader.closely();
    const auto motion = [&](std::size_t a) {
      const Attachment& payload = mechanism_.attachments[a];
      const FixedFrame<S>& body = tree_.bodies[static_cast<std::size_t>(payload.body)];
      const NodeState<S>& node = now.state[static_cast<std::size_t>(body.node)];
      const typename S::Vector place = body.p_N + body.R_N * to_vector<S>(payload.position);
      return PayloadMotion{point_velocity<S>(node, place).norm(), angular_to_3d(node.angular_velocity).norm()};
    };
    add_payload_changes(mechanism_, loads_->stretches(),
                        {leader.time(), before, loads_->now(), effort, leader.last().effort}, motion, result);
  }

  bool record(GroupStepper<S>& leader, Stepper<S>& stepper, Observer<S>& observer, Result& result, long row) {
    if (!leader.observe()) {
      lost_ = no_longer_held(stepper.time(), configuration_text(mechanism_, tree_, stepper.y()));
      return false;
    }
    const Sample& seen = leader.last();
    recorder_->write(seen, row, result);
    if (selection_.takes(row, seen.acceleration, seen.mobility))
      meter_->see(leader.closely(), seen, observer.actuation().multipliers(), seen.mobility);
    return true;
  }

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const Progress& progress_;
  Tree<S> tree_;
  Plan<S> plan_;
  std::optional<Recorder> recorder_;
  std::optional<TermMeter<S>> meter_;
  std::optional<TreeLoads<S>> loads_;
  Selection selection_{trajectory_.samples};
  MotionOutcome lost_;  ///< why the run ended early
};

}  // namespace

Result simulate(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress) {
  check_timing(trajectory);
  const TimedTrajectory timed = time_law(mechanism, trajectory);
  Result result;
  result.outcome = timed.outcome;
  if (timed.outcome.status != MotionStatus::done) return result;
  result = in_space(mechanism.space, [&]<class S>(S) { return Run<S>(mechanism, timed.trajectory, progress).run(); });
  result.found_law = timed.found;
  result.found_corridor = timed.corridor;
  result.phase_plane.ceiling_place = timed.phase_plane.ceiling_place;
  result.phase_plane.ceiling = timed.phase_plane.ceiling;
  return result;
}

}  // namespace balance
