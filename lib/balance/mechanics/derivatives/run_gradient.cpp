#include "balance/mechanics/derivatives/run_gradient.hpp"

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/derivatives/prescribed_motion_gradient.hpp"
#include "balance/mechanics/dynamics/tree_motion_source.hpp"
#include "balance/mechanics/kinematics/tree_payloads.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace balance::derivatives {

using trajectory::TimeGridPoint;

namespace {

using Gradient = Eigen::Array<double, numerics::dual_width, 1>;

/// A scalar, or a vector's magnitude, with its derivatives.
struct FigureWithGradient {
  double value = 0;
  Gradient d = Gradient::Zero();
  double size() const { return std::abs(value); }
  Gradient d_size() const { return value < 0 ? Gradient(-d) : d; }
};

/// One row of the run or of its intermediate samples, in time order. Its time may depend on the variables.
struct GradientRow {
  bool between;
  long row;
  FigureWithGradient time;
};

FigureWithGradient time_at(const RunGradient& gradient, bool between, long row) {
  FigureWithGradient out{(between ? gradient.intermediate.rows : gradient.run).time[row], Gradient::Zero()};
  for (std::size_t k = 0; k < numerics::dual_width; ++k)
    out.d[static_cast<Eigen::Index>(k)] =
        (between ? gradient.derivatives_between[k].rows : gradient.derivatives[k]).time[row];
  return out;
}

std::vector<GradientRow> order_rows_by_time(const RunGradient& gradient) {
  std::vector<GradientRow> gradient_rows;
  std::size_t j = 0;
  const std::vector<long>& next = gradient.intermediate.next_sample;
  for (long k = 0; k < gradient.run.time.size(); ++k) {
    for (; j < next.size() && next[j] == k; ++j)
      gradient_rows.push_back({true, static_cast<long>(j), time_at(gradient, true, static_cast<long>(j))});
    gradient_rows.push_back({false, k, time_at(gradient, false, k)});
  }
  return gradient_rows;
}

/// Half the time between two rows.
FigureWithGradient half_step(const GradientRow& from, const GradientRow& to) {
  return {(to.time.value - from.time.value) / 2, (to.time.d - from.time.d) / 2};
}

FigureWithGradient value_at(const RunGradient& gradient, Samples RunResult::*array, int first, int count,
                            const GradientRow& gradient_row) {
  const auto entries = [&](const RunResult& rows) { return (rows.*array).row(gradient_row.row).segment(first, count); };
  const auto current = entries(gradient_row.between ? gradient.intermediate.rows : gradient.run);
  FigureWithGradient out{count == 1 ? current[0] : current.norm(), Gradient::Zero()};
  for (std::size_t k = 0; k < numerics::dual_width; ++k) {
    const auto change = entries(gradient_row.between ? gradient.derivatives_between[k].rows : gradient.derivatives[k]);
    if (count == 1)
      out.d[static_cast<Eigen::Index>(k)] = change[0];
    else if (out.value > 0)
      out.d[static_cast<Eigen::Index>(k)] = current.dot(change) / out.value;
  }
  return out;
}

void write(const Gradient& from, std::array<double, numerics::dual_width>& to) {
  std::copy(from.begin(), from.end(), to.begin());
}

/// Number of intervals of a run that record extremes of their own: short enough to contain one hump each.
constexpr std::size_t extreme_intervals = 48;

/// Updates the extremes of the interval that a row lies in.
void update_extremes(const FigureWithGradient& current, std::size_t row_index, std::size_t row_count,
                     FigureGradient& figure) {
  const std::size_t interval = row_index * std::min(extreme_intervals, row_count) / row_count;
  const auto update = [&](std::vector<Extreme>& extremes, double sign) {
    if (interval >= extremes.size())
      extremes.emplace_back();
    else if (!(sign * current.value > sign * extremes[interval].value))
      return;
    extremes[interval].value = current.value;
    write(current.d, extremes[interval].d);
  };
  update(figure.highest, 1);
  update(figure.lowest, -1);
}

FigureGradient differentiate_figure(const RunGradient& gradient, const results::MetricSeries& series,
                                    const std::vector<GradientRow>& gradient_rows) {
  FigureGradient figure;
  figure.quantity = series.quantity;
  FigureWithGradient peak, low{INFINITY}, high{-INFINITY}, last;
  double squares = 0, sum = 0;
  Gradient d_squares = Gradient::Zero(), d_sum = Gradient::Zero();
  for (std::size_t i = 0; i < gradient_rows.size(); ++i) {
    const FigureWithGradient current = value_at(gradient, series.array, series.first, series.count, gradient_rows[i]);
    update_extremes(current, i, gradient_rows.size(), figure);
    if (current.size() > peak.size()) peak = current;
    if (current.value < low.value) low = current;
    if (current.value > high.value) high = current;
    if (i > 0) {
      const FigureWithGradient half_interval = half_step(gradient_rows[i - 1], gradient_rows[i]);
      const double square = current.value * current.value + last.value * last.value,
                   size = current.size() + last.size();
      squares += half_interval.value * square;
      d_squares +=
          2 * half_interval.value * (current.value * current.d + last.value * last.d) + square * half_interval.d;
      sum += half_interval.value * size;
      d_sum += half_interval.value * (current.d_size() + last.d_size()) + size * half_interval.d;
    }
    last = current;
  }
  const double duration = gradient_rows.back().time.value - gradient_rows.front().time.value;
  const Gradient d_duration = (gradient_rows.back().time.d - gradient_rows.front().time.d) / duration;  // relative
  figure.peak = peak.size(), figure.range = high.value - low.value;
  figure.rms = std::sqrt(squares / duration), figure.mean = sum / duration;
  write(peak.d_size(), figure.d_peak);
  write(high.d - low.d, figure.d_range);
  write(d_sum / duration - figure.mean * d_duration, figure.d_mean);
  if (figure.rms > 0) write(d_squares / (2 * figure.rms * duration) - figure.rms / 2 * d_duration, figure.d_rms);
  return figure;
}

}  // namespace

FigureGradients differentiate_figures(const RunGradient& gradient, const std::vector<results::MetricSeries>& further) {
  const std::vector<GradientRow> gradient_rows = order_rows_by_time(gradient);
  FigureGradients out;
  for (const results::MetricSeries& series : list_metric_series(gradient.run))
    out.figures.push_back(differentiate_figure(gradient, series, gradient_rows));
  for (const results::MetricSeries& series : further)
    out.figures.push_back(differentiate_figure(gradient, series, gradient_rows));
  Gradient d_energy = Gradient::Zero();
  for (int a = 0; a < static_cast<int>(gradient.run.power.cols()); ++a)
    for (std::size_t i = 1; i < gradient_rows.size(); ++i) {
      const FigureWithGradient half_interval = half_step(gradient_rows[i - 1], gradient_rows[i]);
      for (const std::size_t end : {i - 1, i}) {
        const FigureWithGradient power = value_at(gradient, &RunResult::power, a, 1, gradient_rows[end]);
        out.energy += half_interval.value * power.size();
        d_energy += half_interval.value * power.d_size() + power.size() * half_interval.d;
      }
    }
  write(d_energy, out.d_energy);
  out.duration = gradient_rows.back().time.value;
  write(gradient_rows.back().time.d, out.d_duration);
  return out;
}

namespace {

/// Quantities that do not need Detail::all.
constexpr std::array force_quantities = {"torque",         "power",        "com_acceleration", "shaking_force",
                                         "shaking_moment", "ground_force", "ground_moment"};

/// Quantities that need DerivativeDetail::all.
constexpr std::array configuration_quantities = {"joint_position",  "joint_velocity", "joint_acceleration",
                                                 "com_position",    "tool_position",  "tool_orientation",
                                                 "potential_energy"};

DerivativeDetail required_detail(const std::vector<std::string>& quantities) {
  if (quantities.empty()) return DerivativeDetail::all;
  const auto is_of_configuration = [](const std::string& name) {
    return std::find(configuration_quantities.begin(), configuration_quantities.end(), name) !=
           configuration_quantities.end();
  };
  if (std::any_of(quantities.begin(), quantities.end(), is_of_configuration)) return DerivativeDetail::all;
  const auto is_force_quantity = [](const std::string& name) {
    return std::find(force_quantities.begin(), force_quantities.end(), name) != force_quantities.end();
  };
  return std::all_of(quantities.begin(), quantities.end(), is_force_quantity) ? DerivativeDetail::forces
                                                                              : DerivativeDetail::figures;
}

template <class S>
class DualRun {
 public:
  DualRun(const MechanismOf<DualNumber>& mechanism, const TrajectoryOf<DualNumber>& trajectory,
          const std::vector<std::string>& quantities)
      : dual_mechanism_(mechanism),
        dual_trajectory_(trajectory),
        quantities_(quantities),
        mechanism_(model::values_of(mechanism)),
        trajectory_(trajectory::cast_scalar<double>(trajectory, [](const DualNumber& x) { return x.value; })),
        motion_(mechanism_, trajectory_),
        source_(mechanism_, motion_, trajectory_.about,
                derivative_detail_ == DerivativeDetail::forces ? dynamics::Detail::forces : dynamics::Detail::all) {}

  RunGradient run() {
    RunGradient out;
    out.run.outcome = source_.outcome();
    if (out.run.outcome.status != MotionStatus::done) return out;
    const kinematics::CompiledTrajectory<S>& plan = motion_.plan;
    const std::vector<CoordinateId> needed = prescribed_coordinates(trajectory_);
    motion_gradient_.emplace(dual_mechanism_, source_.tree(), needed, dual_trajectory_, trajectory_, plan);
    evaluator_.emplace(dual_mechanism_, source_.tree(), needed, plan.quantities, plan.has_redundant_closures,
                       plan.freedoms, kinematics::to_vector<DualSpace<S>>(dual_trajectory_.about));
    allocate(out);
    kinematics::TreePayloads<DualSpace<S>> payloads(dual_mechanism_, evaluator_->tree(),
                                                    plan.prescribed_motion->duration());
    payloads.apply(0, evaluator_->tree());
    const bool is_completed = visit_time_grid(source_, trajectory_.samples, [&](const TimeGridPoint& grid_point) {
      const bool is_after_jump = grid_point.kind == TimeGridPoint::Kind::after_jump;
      if (is_after_jump) payloads.apply(source_.time(), evaluator_->tree());
      // the sample stands for a jump at the same time, unless the variables move the jump away from it
      if (is_after_jump && grid_point.has_coincident_next && !motion_gradient_->is_moving_jump(grid_point.index))
        return true;
      if (!source_.evaluate()) return false;
      if (!differentiate_at(grid_point)) return source_.stop_at_actuation_singularity();
      record(source_.evaluator().sample(), grid_point, out);
      return true;
    });
    for (std::size_t k = 0; k < numerics::dual_width; ++k) out.closure_gaps[k] = evaluator_->closure_gaps(k);
    out.run.outcome = is_completed ? source_.completed_outcome() : source_.outcome();
    return out;
  }

 private:
  bool is_requested(const char* quantity) const {
    return quantities_.empty() || std::find(quantities_.begin(), quantities_.end(), quantity) != quantities_.end();
  }

  void allocate(RunGradient& out) {
    const long rows = trajectory_.samples, intermediate_rows = max_intermediate_rows(source_.prescribed_motion(), rows);
    const auto prepare = [&](RunResult& result, long count) {
      name_columns(mechanism_, result);
      result.moment_reference = trajectory_.about;
      results::resize_arrays(mechanism_, count, {}, result);
      for (const results::QuantityDefinition& kind : results::quantity_table())
        if (!is_requested(kind.name)) (result.*kind.member).resize(0, 0);
    };
    prepare(out.run, rows);
    prepare(out.intermediate.rows, intermediate_rows);
    for (RunResult& result : out.derivatives) prepare(result, rows);
    for (results::IntermediateSamples& between : out.derivatives_between) prepare(between.rows, intermediate_rows);
    recorders_.assign(numerics::dual_width + 1, results::ResultRecorder(out.run));
  }

  bool differentiate_at(const TimeGridPoint& grid_point) {
    const trajectory::Side side =
        grid_point.kind == TimeGridPoint::Kind::before_jump ? trajectory::Side::before : trajectory::Side::after;
    const bool jump =
        grid_point.kind == TimeGridPoint::Kind::before_jump || grid_point.kind == TimeGridPoint::Kind::after_jump;
    const DualNumber time = motion_gradient_->at(source_.time(), side, jump ? grid_point.index : -1, target_);
    evaluator_->differentiate_motion(source_.stepper().y(), target_);
    if (!evaluator_->evaluate(time, source_.prescribed_motion().duration(), source_.detail())) return false;
    if (is_requested("mobility")) evaluator_->sample().mobility = evaluator_->mobility();
    return true;
  }

  void record(Sample& sample, const TimeGridPoint& grid_point, RunGradient& out) {
    const trajectory::SampleOf<DualNumber>& dual_sample = evaluator_->sample();
    const bool is_sample = grid_point.kind == TimeGridPoint::Kind::sample;
    const long row = is_sample ? grid_point.index : out.intermediate.add(grid_point.next_sample);
    sample.mobility = dual_sample.mobility.value;
    recorders_[numerics::dual_width].write(sample, row, is_sample ? out.run : out.intermediate.rows);
    for (std::size_t k = 0; k < numerics::dual_width; ++k) {
      results::IntermediateSamples& between = out.derivatives_between[k];
      if (!is_sample) between.add(grid_point.next_sample);
      write_derivative(dual_sample, k, derivative_detail_, derivative_);
      recorders_[k].write(derivative_, row, is_sample ? out.derivatives[k] : between.rows);
    }
  }

  const MechanismOf<DualNumber>& dual_mechanism_;
  const TrajectoryOf<DualNumber>& dual_trajectory_;
  const std::vector<std::string>& quantities_;
  const DerivativeDetail derivative_detail_ = required_detail(quantities_);
  const Mechanism mechanism_;
  const Trajectory trajectory_;
  const kinematics::CompiledMotion<S> motion_;
  dynamics::TreeMotionSource<S> source_;
  std::optional<PrescribedMotionGradient> motion_gradient_;
  std::optional<DualEvaluator<S>> evaluator_;
  trajectory::DriveSampleOf<DualNumber> target_;
  Sample derivative_;
  std::vector<results::ResultRecorder> recorders_;
};

}  // namespace

RunGradient differentiate_run(const MechanismOf<DualNumber>& mechanism, const TrajectoryOf<DualNumber>& trajectory,
                              const std::vector<std::string>& quantities) {
  if (trajectory.samples < 2) throw std::invalid_argument("a trajectory needs at least two samples");
  if (has_velocity_constraints(values_of(mechanism)))
    throw std::invalid_argument("a motion with constraints on speeds has no derivatives: it depends on the whole path");
  return kinematics::dispatch_space(mechanism.space,
                                    [&]<class S>(S) { return DualRun<S>(mechanism, trajectory, quantities).run(); });
}

}  // namespace balance::derivatives
