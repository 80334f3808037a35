#include "balance/mechanics/derivatives/run_gradient.hpp"

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/derivatives/prescribed_motion_gradient.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/tree_payloads.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace balance {

namespace {

using Gradient = Eigen::Array<double, dual_width, 1>;

/// A scalar, or a vector's magnitude, with its derivatives.
struct FigureWithGradient {
  double value = 0;
  Gradient d = Gradient::Zero();
  double size() const { return std::abs(value); }
  Gradient d_size() const { return value < 0 ? Gradient(-d) : d; }
};

/// One row of the run or of what lies between its samples, in the order of time, which numbers may move.
struct GradientRow {
  bool between;
  long row;
  FigureWithGradient time;
};

FigureWithGradient time_at(const RunGradient& gradient, bool between, long row) {
  FigureWithGradient out{(between ? gradient.intermediate.rows : gradient.run).time[row], Gradient::Zero()};
  for (std::size_t k = 0; k < dual_width; ++k)
    out.d[static_cast<Eigen::Index>(k)] =
        (between ? gradient.derivatives_between[k].rows : gradient.derivatives[k]).time[row];
  return out;
}

std::vector<GradientRow> order_rows_by_time(const RunGradient& gradient) {
  std::vector<GradientRow> places;
  std::size_t j = 0;
  const std::vector<long>& next = gradient.intermediate.next_sample;
  for (long k = 0; k < gradient.run.time.size(); ++k) {
    for (; j < next.size() && next[j] == k; ++j)
      places.push_back({true, static_cast<long>(j), time_at(gradient, true, static_cast<long>(j))});
    places.push_back({false, k, time_at(gradient, false, k)});
  }
  return places;
}

/// Half the time from one place to the next.
FigureWithGradient half_step(const GradientRow& from, const GradientRow& to) {
  return {(to.time.value - from.time.value) / 2, (to.time.d - from.time.d) / 2};
}

FigureWithGradient value_at(const RunGradient& gradient, Samples RunResult::*array, int first, int count,
                            const GradientRow& place) {
  const auto entries = [&](const RunResult& rows) { return (rows.*array).row(place.row).segment(first, count); };
  const auto now = entries(place.between ? gradient.intermediate.rows : gradient.run);
  FigureWithGradient out{count == 1 ? now[0] : now.norm(), Gradient::Zero()};
  for (std::size_t k = 0; k < dual_width; ++k) {
    const auto change = entries(place.between ? gradient.derivatives_between[k].rows : gradient.derivatives[k]);
    if (count == 1)
      out.d[static_cast<Eigen::Index>(k)] = change[0];
    else if (out.value > 0)
      out.d[static_cast<Eigen::Index>(k)] = now.dot(change) / out.value;
  }
  return out;
}

void write(const Gradient& from, std::array<double, dual_width>& to) {
  std::copy(from.begin(), from.end(), to.begin());
}

/// So many stretches of a run have extremes of their own: short enough to hold one hump each.
constexpr std::size_t extreme_intervals = 48;

/// Takes a place's value into its stretch's extremes.
void update_extremes(const FigureWithGradient& now, std::size_t place, std::size_t count, FigureGradient& figure) {
  const std::size_t stretch = place * std::min(extreme_intervals, count) / count;
  const auto take = [&](std::vector<Extreme>& extremes, double sign) {
    if (stretch >= extremes.size())
      extremes.emplace_back();
    else if (!(sign * now.value > sign * extremes[stretch].value))
      return;
    extremes[stretch].value = now.value;
    write(now.d, extremes[stretch].d);
  };
  take(figure.highest, 1);
  take(figure.lowest, -1);
}

FigureGradient differentiate_figure(const RunGradient& gradient, const MetricSeries& track,
                                    const std::vector<GradientRow>& places) {
  FigureGradient figure;
  figure.quantity = track.quantity;
  FigureWithGradient peak, low{INFINITY}, high{-INFINITY}, last;
  double squares = 0, sum = 0;
  Gradient d_squares = Gradient::Zero(), d_sum = Gradient::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const FigureWithGradient now = value_at(gradient, track.array, track.first, track.count, places[i]);
    update_extremes(now, i, places.size(), figure);
    if (now.size() > peak.size()) peak = now;
    if (now.value < low.value) low = now;
    if (now.value > high.value) high = now;
    if (i > 0) {
      const FigureWithGradient half = half_step(places[i - 1], places[i]);
      const double square = now.value * now.value + last.value * last.value, size = now.size() + last.size();
      squares += half.value * square;
      d_squares += 2 * half.value * (now.value * now.d + last.value * last.d) + square * half.d;
      sum += half.value * size;
      d_sum += half.value * (now.d_size() + last.d_size()) + size * half.d;
    }
    last = now;
  }
  const double duration = places.back().time.value - places.front().time.value;
  const Gradient d_duration = (places.back().time.d - places.front().time.d) / duration;  // as part of it
  figure.peak = peak.size(), figure.range = high.value - low.value;
  figure.rms = std::sqrt(squares / duration), figure.mean = sum / duration;
  write(peak.d_size(), figure.d_peak);
  write(high.d - low.d, figure.d_range);
  write(d_sum / duration - figure.mean * d_duration, figure.d_mean);
  if (figure.rms > 0) write(d_squares / (2 * figure.rms * duration) - figure.rms / 2 * d_duration, figure.d_rms);
  return figure;
}

}  // namespace

FigureGradients differentiate_figures(const RunGradient& gradient) {
  const std::vector<GradientRow> places = order_rows_by_time(gradient);
  FigureGradients out;
  for (const MetricSeries& track : list_metric_series(gradient.run))
    out.figures.push_back(differentiate_figure(gradient, track, places));
  Gradient d_energy = Gradient::Zero();
  for (int a = 0; a < static_cast<int>(gradient.run.power.cols()); ++a)
    for (std::size_t i = 1; i < places.size(); ++i) {
      const FigureWithGradient half = half_step(places[i - 1], places[i]);
      for (const std::size_t end : {i - 1, i}) {
        const FigureWithGradient power = value_at(gradient, &RunResult::power, a, 1, places[end]);
        out.energy += half.value * power.size();
        d_energy += half.value * power.d_size() + power.size() * half.d;
      }
    }
  write(d_energy, out.d_energy);
  out.duration = places.back().time.value;
  write(places.back().time.d, out.d_duration);
  return out;
}

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
