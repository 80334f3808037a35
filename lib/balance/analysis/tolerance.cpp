#include "balance/analysis/tolerance.hpp"

#include "balance/analysis/toleranced_run.hpp"
#include "balance/result/quantities.hpp"
#include "balance/result/round_off.hpp"
#include "balance/simulation/simulate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace balance {

namespace {

/// A magnitude below so many of its deviations is not taken for linear in the numbers.
constexpr double clear_of_zero = 3;

class Deviations {
 public:
  Deviations(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
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
    out.deviation = deviations();
    const std::vector<Track> tracks = list_tracks(run());
    for (std::size_t t = 0; t < tracks.size(); ++t)
      if (wanted(tracks[t], quantities)) out.quantities.push_back(measure(tracks[t], t));
    out.energy = figure([](const FigureGradients& all) { return all.energy; },
                        [](const FigureGradients& all) { return all.d_energy; });
    return out;
  }

 private:
  Eigen::Index size() const { return off_.deviations().size(); }
  const Result& run() const { return off_.run(); }

  static bool wanted(const Track& track, const std::vector<std::string>& quantities) {
    const std::string array = track.quantity.substr(0, track.quantity.find('['));
    return quantities.empty() || std::any_of(quantities.begin(), quantities.end(), [&](const std::string& one) {
             return one == track.quantity || one == array;
           });
  }

  /// Every entry's standard deviation.
  Result deviations() const {
    Result out = run();
    for (const QuantityKind& kind : quantity_table()) {
      Samples& array = out.*kind.member;
      if (array.size() == 0) continue;
      array.setZero();
      for (Eigen::Index i = 0; i < size(); ++i) {
        const Samples& change = off_.derivative(i, false).*kind.member;
        if (change.rows() == array.rows() && change.cols() == array.cols())
          array.array() += (off_.deviations()[i] * change.array()).square();
      }
      array = array.cwiseSqrt();
    }
    return out;
  }

  template <class Value, class Derivative>
  FigureDeviation figure(Value&& value, Derivative&& derivative) const {
    FigureDeviation out{value(off_.figures().front()), 0, VectorX(size())};
    for (Eigen::Index i = 0; i < size(); ++i) {
      const std::size_t k = static_cast<std::size_t>(i);
      out.by_number[i] = derivative(off_.figures()[k / dual_width])[k % dual_width] * off_.deviations()[i];
    }
    out.deviation = out.by_number.norm();
    return out;
  }

  FigureDeviation figure_of_track(std::size_t t, double FigureGradient::*value,
                                  std::array<double, dual_width> FigureGradient::*derivative) const {
    return figure([&](const FigureGradients& all) { return all.figures[t].*value; },
                  [&](const FigureGradients& all) { return all.figures[t].*derivative; });
  }

  QuantityTolerance measure(const Track& track, std::size_t t) const {
    QuantityTolerance out{.quantity = track.quantity, .unit = track.unit};
    out.peak = figure_of_track(t, &FigureGradient::peak, &FigureGradient::d_peak);
    out.rms = figure_of_track(t, &FigureGradient::rms, &FigureGradient::d_rms);
    out.mean = figure_of_track(t, &FigureGradient::mean, &FigureGradient::d_mean);
    out.range = figure_of_track(t, &FigureGradient::range, &FigureGradient::d_range);
    MatrixX squares = MatrixX::Zero(size(), size());
    VectorX cross = VectorX::Zero(size());
    double own = 0;
    for (const Instant& place : off_.places()) {
      const VectorX value = off_.value(track, place);
      const MatrixX change = off_.changes(track, place);
      squares += place.weight * change * change.transpose();
      cross += place.weight * change * value;
      own += place.weight * value.squaredNorm();
      if (!place.between) meet(place, value.norm(), change, out.worst);
    }
    finish(squares, cross, own, out);
    drop_round_off(nominal_, out);
    return out;
  }

  static void meet(const Instant& place, double value, const MatrixX& change, WorstSample& worst) {
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
      variance += excess(numbers_[i].spread) * square * square;
    }
    out.expected_rms = std::sqrt(own + spread * spread);
    out.square_deviation = std::sqrt(std::max(0.0, variance));
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    if (spread > 0 && std::sqrt(own) < clear_of_zero * spread)
      for (FigureDeviation* one : {&out.peak, &out.rms, &out.mean}) one->deviation = none;
    if (out.worst.deviation > 0 && out.range.value < clear_of_zero * out.worst.deviation) out.range.deviation = none;
  }

  /// As in a run's metrics.
  static void drop_round_off(const Result& nominal, QuantityTolerance& out) {
    const auto& all = nominal.metrics;
    const auto same = [&](const Metric& one) { return one.quantity == out.quantity; };
    const auto metric = std::find_if(all.begin(), all.end(), same);
    if (metric == all.end()) return;
    for (double* one :
         {&out.peak.value, &out.rms.value, &out.mean.value, &out.range.value, &out.expected_rms, &out.worst.value})
      *one = above(metric->round_off, *one);
  }

  const Tolerances& numbers_;
  Result nominal_;
  TolerancedRun off_;
};

}  // namespace

ToleranceReport tolerance(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                          const std::vector<std::string>& quantities) {
  return Deviations(space, numbers, trajectory, quantities).report(quantities);
}

}  // namespace balance
