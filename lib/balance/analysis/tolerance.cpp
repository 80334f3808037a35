#include "balance/analysis/tolerance.hpp"

#include "balance/analysis/toleranced_duals.hpp"
#include "balance/gradients/motion_gradient.hpp"
#include "balance/result/quantities.hpp"
#include "balance/result/round_off.hpp"
#include "balance/result/tracks.hpp"
#include "balance/simulation/simulate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace balance {

namespace {

/// A magnitude below so many of its deviations is not taken for linear in the numbers.
constexpr double clear_of_zero = 3;

/// Fourth moment over the squared second one, less that of a normal distribution.
double excess(Spread spread) { return spread == Spread::normal ? 0 : -1.2; }

/// One row of the run or of what lies between its samples, and its part of the duration.
struct Instant {
  bool between = false;
  long row = 0;
  double time = 0;
  double weight = 0;
};

std::vector<Instant> instants_of(const RunGradient& gradient) {
  std::vector<Instant> places;
  std::size_t j = 0;
  const std::vector<long>& next = gradient.between.next_sample;
  for (long k = 0; k < gradient.run.time.size(); ++k) {
    for (; j < next.size() && next[j] == k; ++j)
      places.push_back({true, static_cast<long>(j), gradient.between.rows.time[static_cast<long>(j)]});
    places.push_back({false, k, gradient.run.time[k]});
  }
  const double duration = places.back().time - places.front().time;
  for (std::size_t i = 1; i < places.size(); ++i) {
    const double half = (places[i].time - places[i - 1].time) / (2 * duration);
    places[i - 1].weight += half;
    places[i].weight += half;
  }
  return places;
}

std::vector<std::string> arrays_named(const std::vector<std::string>& quantities) {
  std::vector<std::string> arrays;
  for (const std::string& quantity : quantities) arrays.push_back(quantity.substr(0, quantity.find('[')));
  if (!arrays.empty()) arrays.push_back("power");
  return arrays;
}

class Deviations {
 public:
  Deviations(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
             const std::vector<std::string>& quantities)
      : numbers_(numbers),
        nominal_(simulate(space.start.mechanism, trajectory)),
        sigma_(static_cast<Eigen::Index>(numbers.size())) {
    for (std::size_t i = 0; i < numbers.size(); ++i) sigma_[static_cast<Eigen::Index>(i)] = numbers[i].deviation();
    if (nominal_.outcome.status != MotionStatus::done) return;
    const std::vector<std::string> arrays = arrays_named(quantities);
    for (std::size_t first = 0; first < numbers.size(); first += dual_width) {
      const TolerancedDuals duals(space, numbers, first);
      gradients_.push_back(differentiate(duals.mechanism(), duals.trajectory(trajectory), arrays));
      if (gradients_.back().run.outcome.status != MotionStatus::done) return;
      figures_.push_back(figure_gradients(gradients_.back()));
    }
    places_ = instants_of(gradients_.front());
  }

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
  const Result& run() const { return gradients_.back().run; }

  static bool wanted(const Track& track, const std::vector<std::string>& quantities) {
    const std::string array = track.quantity.substr(0, track.quantity.find('['));
    return quantities.empty() || std::any_of(quantities.begin(), quantities.end(), [&](const std::string& one) {
             return one == track.quantity || one == array;
           });
  }

  const Result& derivative(Eigen::Index number, bool between) const {
    const RunGradient& gradient = gradients_[static_cast<std::size_t>(number) / dual_width];
    const std::size_t k = static_cast<std::size_t>(number) % dual_width;
    if (between) return gradient.derivatives_between[k].rows;
    return gradient.derivatives[k];
  }

  /// Every entry's standard deviation.
  Result deviations() const {
    Result out = run();
    for (const QuantityKind& kind : quantity_table()) {
      Samples& array = out.*kind.member;
      if (array.size() == 0) continue;
      array.setZero();
      for (Eigen::Index i = 0; i < sigma_.size(); ++i) {
        const Samples& change = derivative(i, false).*kind.member;
        if (change.rows() == array.rows() && change.cols() == array.cols())
          array.array() += (sigma_[i] * change.array()).square();
      }
      array = array.cwiseSqrt();
    }
    return out;
  }

  template <class Value, class Derivative>
  FigureDeviation figure(Value&& value, Derivative&& derivative) const {
    FigureDeviation out{value(figures_.front()), 0, VectorX(sigma_.size())};
    for (Eigen::Index i = 0; i < sigma_.size(); ++i) {
      const std::size_t k = static_cast<std::size_t>(i);
      out.by_number[i] = derivative(figures_[k / dual_width])[k % dual_width] * sigma_[i];
    }
    out.deviation = out.by_number.norm();
    return out;
  }

  FigureDeviation figure_of_track(std::size_t t, double FigureGradient::*value,
                                  std::array<double, dual_width> FigureGradient::*derivative) const {
    return figure([&](const FigureGradients& all) { return all.figures[t].*value; },
                  [&](const FigureGradients& all) { return all.figures[t].*derivative; });
  }

  /// A row per number: what its deviation changes the track's components by.
  MatrixX changes(const Track& track, const Instant& place) const {
    MatrixX out(sigma_.size(), track.count);
    for (Eigen::Index i = 0; i < sigma_.size(); ++i)
      out.row(i) =
          sigma_[i] * (derivative(i, place.between).*track.array).row(place.row).segment(track.first, track.count);
    return out;
  }

  QuantityTolerance measure(const Track& track, std::size_t t) const {
    QuantityTolerance out{.quantity = track.quantity, .unit = track.unit};
    out.peak = figure_of_track(t, &FigureGradient::peak, &FigureGradient::d_peak);
    out.rms = figure_of_track(t, &FigureGradient::rms, &FigureGradient::d_rms);
    out.mean = figure_of_track(t, &FigureGradient::mean, &FigureGradient::d_mean);
    out.range = figure_of_track(t, &FigureGradient::range, &FigureGradient::d_range);
    MatrixX squares = MatrixX::Zero(sigma_.size(), sigma_.size());
    VectorX cross = VectorX::Zero(sigma_.size());
    double own = 0;
    for (const Instant& place : places_) {
      const Result& rows = place.between ? gradients_.front().between.rows : run();
      const VectorX value = (rows.*track.array).row(place.row).segment(track.first, track.count).transpose();
      const MatrixX change = changes(track, place);
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
  VectorX sigma_;
  std::vector<RunGradient> gradients_;  ///< dual_width numbers each
  std::vector<FigureGradients> figures_;
  std::vector<Instant> places_;
};

}  // namespace

ToleranceReport tolerance(const DesignSpace& space, const Tolerances& numbers, const Trajectory& trajectory,
                          const std::vector<std::string>& quantities) {
  if (numbers.empty()) throw std::invalid_argument("there are no numbers that may be off");
  if (depends_on_mechanism(trajectory))
    throw std::invalid_argument("the trajectory '" + trajectory.name + "' is found anew for every mechanism");
  if (trajectory.samples * static_cast<long>(numbers.size()) > most_tolerance_samples)
    throw std::invalid_argument("too many samples for " + std::to_string(numbers.size()) + " numbers: at most " +
                                std::to_string(most_tolerance_samples / static_cast<long>(numbers.size())));
  return Deviations(space, numbers, trajectory, quantities).report(quantities);
}

}  // namespace balance
