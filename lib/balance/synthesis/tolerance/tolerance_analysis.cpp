#include "balance/synthesis/tolerance/tolerance_analysis.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/tolerance/extreme_figure.hpp"
#include "balance/synthesis/tolerance/toleranced_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace balance {

void add_incompatible_parameters(const ClosureGaps& found, std::size_t number, const std::string& path,
                                 double deviation, const Mechanism& mechanism,
                                 std::vector<IncompatibleParameter>& openings) {
  if (deviation == 0) return;
  for (const ClosureGap& one : found)
    openings.push_back({number, path, mechanism.joints[static_cast<std::size_t>(one.joint)].name,
                        one.is_length ? "m" : "rad", one.gap * deviation});
}

Tolerances remove_incompatible_parameters(const Tolerances& numbers,
                                          const std::vector<IncompatibleParameter>& openings) {
  Tolerances rest;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (std::none_of(openings.begin(), openings.end(),
                     [i](const IncompatibleParameter& one) { return one.index == i; }))
      rest.push_back(numbers[i]);
  if (rest.empty()) throw std::invalid_argument("every number opens a joint, so that there is nothing to draw");
  return rest;
}

std::string format_incompatibility_note(const IncompatibleParameter& opening) {
  return fmt::format(
      "over-constrained loops cannot follow {} by itself: its deviation would open {} by {:.3g} {}, and has no part in "
      "what is said of deviations",
      opening.key_path, opening.joint, opening.gap, opening.unit);
}

namespace {

/// A magnitude below so many of its deviations is not taken for linear in the numbers.
constexpr double min_linear_ratio = 3;
/// Other moments that change a deviation by less are no rivals.
constexpr double extreme_deviation_tolerance = 0.02;
constexpr double undefined_deviation = std::numeric_limits<double>::quiet_NaN();

class ToleranceAnalysis {
 public:
  ToleranceAnalysis(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                    const std::vector<std::string>& quantities)
      : numbers_(numbers),
        nominal_(simulate(space.start.mechanism, trajectory)),
        off_(space, numbers, trajectory, quantities) {}

  ToleranceReport report(const std::vector<std::string>& quantities) const {
    ToleranceReport out;
    out.outcome = nominal_.outcome;
    out.numbers = numbers_;
    out.run = nominal_;
    if (nominal_.outcome.status == MotionStatus::done) out.outcome = run().outcome;
    if (out.outcome.status != MotionStatus::done) return out;
    out.incompatible_parameters = off_.incompatible_parameters();
    out.deviation = deviations();
    const std::vector<MetricSeries> all = list_metric_series(run());
    std::vector<MetricSeries> tracks;
    for (std::size_t t = 0; t < all.size(); ++t) {
      if (!is_requested(all[t], quantities)) continue;
      tracks.push_back(all[t]);
      out.quantities.push_back(analyse_quantity(all[t], t));
    }
    apply_extreme_statistics(tracks, out.quantities);
    for (QuantityTolerance& one : out.quantities) drop_round_off(one);
    out.energy = figure([](const FigureGradients& one) { return one.energy; },
                        [](const FigureGradients& one) { return one.d_energy; });
    drop_round_off(out.energy);
    return out;
  }

 private:
  Eigen::Index size() const { return off_.deviations().size(); }
  const RunResult& run() const { return off_.run(); }

  static bool is_requested(const MetricSeries& track, const std::vector<std::string>& quantities) {
    return quantities.empty() || std::any_of(quantities.begin(), quantities.end(), [&](const std::string& one) {
             return is_quantity_or_array_name(one, track.quantity);
           });
  }

  /// Every entry's standard deviation.
  RunResult deviations() const {
    RunResult out = run();
    for (const QuantityDefinition& kind : quantity_table()) {
      Samples& array = out.*kind.member;
      if (array.size() == 0) continue;
      array.setZero();
      for (Eigen::Index i = 0; i < size(); ++i) {
        const Samples& change = off_.derivative(i, false).*kind.member;
        if (change.rows() == array.rows() && change.cols() == array.cols())
          array.array() += (off_.deviations()[i] * change.array()).square();
      }
      array = array.cwiseSqrt();
      for (Eigen::Index c = 0; c < array.cols(); ++c)
        clear_column(array, c, column_round_off(nominal_, kind.member, c));
    }
    return out;
  }

  template <class Value, class Derivative>
  FigureDeviation figure(Value&& value, Derivative&& derivative) const {
    FigureDeviation out{value(off_.figures().front()), 0, VectorX(size())};
    for (Eigen::Index i = 0; i < size(); ++i) {
      const std::size_t k = static_cast<std::size_t>(i);
      out.contributions[i] = derivative(off_.figures()[k / dual_width])[k % dual_width] * off_.deviations()[i];
    }
    out.deviation = out.contributions.norm();
    return out;
  }

  void blank_incompatible_parameters(VectorX& by_number) const {
    for (const IncompatibleParameter& one : off_.incompatible_parameters())
      by_number[static_cast<Eigen::Index>(one.index)] = undefined_deviation;
  }

  /// Peaks and ranges that may come to be elsewhere.
  void apply_extreme_statistics(const std::vector<MetricSeries>& tracks,
                                std::vector<QuantityTolerance>& quantities) const {
    struct ExtremeFigureTask {
      FigureDeviation* figure;
      ExtremeFigure extreme;
    };
    std::vector<ExtremeFigureTask> contests;
    for (std::size_t t = 0; t < tracks.size(); ++t) {
      MetricSeries track = tracks[t];
      if (track.array == &RunResult::total_torque) {  // a magnitude, not linear near zero
        track.array = &RunResult::torque;
        track.first = 0, track.count = static_cast<int>(run().torque.cols());
      }
      std::vector<LinearizedSample> moments;
      for (const ToleranceSample& place : off_.samples())
        moments.push_back({place.time, off_.value(track, place), off_.contributions(track, place)});
      using enum ExtremeFigure::Kind;
      for (const auto& [figure, kind] : {std::pair{&quantities[t].peak, peak}, {&quantities[t].range, range}}) {
        if (std::isnan(figure->deviation)) continue;
        ExtremeFigure extreme(moments, kind);
        if (extreme.has_several_candidates()) contests.push_back({figure, std::move(extreme)});
      }
    }
    std::vector<ExtremeFigure*> extremes;
    for (ExtremeFigureTask& contest : contests) extremes.push_back(&contest.extreme);
    sample_extreme_figures(extremes, numbers_);
    for (const auto& [figure, extreme] : contests) {
      const double deviation = extreme.deviation();
      if (std::abs(deviation - figure->deviation) <= extreme_deviation_tolerance * figure->deviation) continue;
      figure->deviation = deviation;
      figure->contributions = extreme.contributions();
      figure->extremum_times = extreme.extremum_times();
    }
  }

  FigureDeviation figure_of_track(std::size_t t, double FigureGradient::*value,
                                  std::array<double, dual_width> FigureGradient::*derivative) const {
    return figure([&](const FigureGradients& all) { return all.figures[t].*value; },
                  [&](const FigureGradients& all) { return all.figures[t].*derivative; });
  }

  QuantityTolerance analyse_quantity(const MetricSeries& track, std::size_t t) const {
    QuantityTolerance out{.quantity = track.quantity, .unit = track.unit};
    out.peak = figure_of_track(t, &FigureGradient::peak, &FigureGradient::d_peak);
    out.rms = figure_of_track(t, &FigureGradient::rms, &FigureGradient::d_rms);
    out.mean = figure_of_track(t, &FigureGradient::mean, &FigureGradient::d_mean);
    out.range = figure_of_track(t, &FigureGradient::range, &FigureGradient::d_range);
    MatrixX squares = MatrixX::Zero(size(), size());
    VectorX cross = VectorX::Zero(size());
    double own = 0;
    for (const ToleranceSample& place : off_.samples()) {
      const VectorX value = off_.value(track, place);
      const MatrixX change = off_.contributions(track, place);
      squares += place.weight * change * change.transpose();
      cross += place.weight * change * value;
      own += place.weight * value.squaredNorm();
      if (!place.is_intermediate) update_worst(place, value.norm(), change, out.worst);
    }
    finish(squares, cross, own, out);
    return out;
  }

  static void update_worst(const ToleranceSample& place, double value, const MatrixX& change, WorstSample& worst) {
    const VectorX parts = change.rowwise().squaredNorm();
    const double deviation = std::sqrt(parts.sum());
    if (worst.shares.size() > 0 && !(deviation > worst.deviation)) return;
    worst = {place.row, place.time, value, deviation, deviation > 0 ? VectorX(parts / parts.sum()) : parts};
  }

  void finish(const MatrixX& squares, const VectorX& cross, double own, QuantityTolerance& out) const {
    const double spread = std::sqrt(squares.trace());
    double variance = 4 * cross.squaredNorm() + 2 * squares.squaredNorm();
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      const double square = squares(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
      variance += excess_kurtosis(numbers_[i].distribution) * square * square;
    }
    out.expected_rms = std::sqrt(own + spread * spread);
    out.square_deviation = std::sqrt(std::max(0.0, variance));
    if (spread > 0 && std::sqrt(own) < min_linear_ratio * spread)
      for (FigureDeviation* one : {&out.peak, &out.rms, &out.mean}) one->deviation = undefined_deviation;
    if (out.worst.deviation > 0 && out.range.value < min_linear_ratio * out.worst.deviation)
      out.range.deviation = undefined_deviation;
  }

  /// As in a run's metrics: a deviation that is below what its quantity leaves of zero is none.
  void drop_round_off(QuantityTolerance& out) const {
    const auto& all = nominal_.metrics;
    const auto same = [&](const Metric& one) { return one.quantity == out.quantity; };
    const auto metric = std::find_if(all.begin(), all.end(), same);
    if (metric == all.end()) return;
    const auto drop = [&](double& value) { value = suppress_round_off(metric->round_off, value); };
    drop(out.expected_rms);
    if (out.expected_rms == 0) out.square_deviation = 0;
    for (FigureDeviation* figure : {&out.peak, &out.rms, &out.mean, &out.range}) {
      drop(figure->value);
      drop(figure->deviation);
      for (double& part : figure->contributions) drop(part);
      if (out.expected_rms == 0) figure->deviation = 0, figure->contributions.setZero(), figure->extremum_times.clear();
    }
    blank_incompatible_parameters(out);
    for (double* value : {&out.worst.value, &out.worst.deviation}) drop(*value);
    if (out.worst.deviation == 0) out.worst.shares.setZero();
  }

  void drop_round_off(FigureDeviation& energy) const {
    const VectorX& time = nominal_.time;
    double round_off = 0;
    for (Eigen::Index a = 0; a < nominal_.power.cols(); ++a)
      round_off += column_round_off(nominal_, &RunResult::power, a) * (time[time.size() - 1] - time[0]);
    for (double* value : {&energy.value, &energy.deviation}) *value = suppress_round_off(round_off, *value);
    for (double& part : energy.contributions) part = suppress_round_off(round_off, part);
    blank_incompatible_parameters(energy.contributions);
  }

  void blank_incompatible_parameters(QuantityTolerance& out) const {
    for (FigureDeviation* figure : {&out.peak, &out.rms, &out.mean, &out.range})
      blank_incompatible_parameters(figure->contributions);
  }

  const Tolerances& numbers_;
  RunResult nominal_;
  TolerancedRun off_;
};

}  // namespace

ToleranceReport analyse_tolerance(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                                  const std::vector<std::string>& quantities) {
  return ToleranceAnalysis(space, numbers, trajectory, quantities).report(quantities);
}

}  // namespace balance
