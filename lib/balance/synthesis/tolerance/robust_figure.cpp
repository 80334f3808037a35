#include "balance/synthesis/tolerance/robust_figure.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/synthesis/tolerance/toleranced_run.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance {

namespace {

constexpr double undefined_figure = std::numeric_limits<double>::quiet_NaN();

/// What is there at one moment of a run.
struct RunMoment {
  double weight = 0;  ///< part of the duration
  VectorX value;      ///< of the track's components
  MatrixX change;     ///< numbers × components
  double variance() const { return change.squaredNorm(); }
  double expected_square() const { return value.squaredNorm() + variance(); }
};

class RobustTrack {
 public:
  RobustTrack(const TolerancedRun& off, const Tolerances& numbers, const MetricSeries& track) : numbers_(numbers) {
    for (const ToleranceSample& place : off.samples())
      moments_.push_back({place.weight, off.value(track, place), off.contributions(track, place)});
  }

  RobustFigure compute(Statistic figure, double k) const {
    switch (figure) {
      case Statistic::peak: return peak(k);
      case Statistic::rms: return rms(k);
      case Statistic::mean: return mean(k);
      case Statistic::range: return range(k);
    }
    return {};
  }

 private:
  RobustFigure peak(double k) const {
    RobustFigure out;
    out.value = -1;
    for (const RunMoment& moment : moments_) {
      const double size = moment.value.norm(), deviation = std::sqrt(moment.variance());
      out.nominal = std::max(out.nominal, size);
      if (size + k * deviation > out.value) {
        out.mean = size;
        out.deviation = deviation;
        out.value = size + k * deviation;
      }
    }
    return out;
  }

  RobustFigure rms(double k) const {
    double own = 0, expected = 0;
    for (const RunMoment& moment : moments_) {
      own += moment.weight * moment.value.squaredNorm();
      expected += moment.weight * moment.expected_square();
    }
    const double root = std::sqrt(expected);
    return root_figure(std::sqrt(own), root, k, [&](const RunMoment&) { return root; });
  }

  RobustFigure mean(double k) const {
    double own = 0, expected = 0;
    for (const RunMoment& moment : moments_) {
      own += moment.weight * moment.value.norm();
      expected += moment.weight * std::sqrt(moment.expected_square());
    }
    return root_figure(own, expected, k, [](const RunMoment& moment) { return std::sqrt(moment.expected_square()); });
  }

  /// Of Σ w √E with E the expected squares at the moments or over all of them: squares q are off by q − E = 2 bᵀ z + zᵀ G z − tr G, and
  /// their roots by (q − E) / (2 √E).
  template <class Root>
  RobustFigure root_figure(double nominal, double mean, double k, Root&& root) const {
    const auto size = static_cast<Eigen::Index>(numbers_.size());
    VectorX cross = VectorX::Zero(size);
    MatrixX squares = MatrixX::Zero(size, size);
    for (const RunMoment& moment : moments_) {
      const double there = root(moment);
      if (!(there > 0)) continue;
      cross += moment.weight / there * moment.change * moment.value;
      squares += moment.weight / there * moment.change * moment.change.transpose();
    }
    double variance = cross.squaredNorm() + squares.squaredNorm() / 2;
    for (Eigen::Index i = 0; i < size; ++i)
      variance +=
          excess_kurtosis(numbers_[static_cast<std::size_t>(i)].distribution) * squares(i, i) * squares(i, i) / 4;
    const double deviation = std::sqrt(std::max(0.0, variance));
    return {nominal, mean, deviation, mean + k * deviation};
  }

  /// A scalar or a magnitude, and its derivatives times the deviations. A magnitude of zero has none.
  struct ValueWithGradient {
    double value = 0;
    VectorX change;
  };

  static ValueWithGradient magnitude_with_gradient(const RunMoment& moment) {
    if (moment.value.size() == 1) return {moment.value[0], moment.change.col(0)};
    const double size = moment.value.norm();
    if (size > 0) return {size, moment.change * moment.value / size};
    return {0, VectorX::Zero(moment.change.rows())};
  }

  /// The largest of all pairs. Those that even deviations against each other would not make larger need no look.
  RobustFigure range(double k) const {
    std::vector<ValueWithGradient> heights;
    for (const RunMoment& moment : moments_) heights.push_back(magnitude_with_gradient(moment));
    const auto ordered = [&](double sign) {
      std::vector<std::pair<double, std::size_t>> bounds;
      for (std::size_t i = 0; i < heights.size(); ++i)
        bounds.emplace_back(sign * heights[i].value + k * heights[i].change.norm(), i);
      std::sort(bounds.begin(), bounds.end(), std::greater<>());
      return bounds;
    };
    const auto tops = ordered(1), bottoms = ordered(-1);
    const auto compare = [](const ValueWithGradient& a, const ValueWithGradient& b) { return a.value < b.value; };
    const auto [least, most] = std::minmax_element(heights.begin(), heights.end(), compare);
    RobustFigure out{most->value - least->value, 0, 0, -1};
    for (const auto& [top, s] : tops) {
      if (top + bottoms.front().first <= out.value) break;
      for (const auto& [bottom, t] : bottoms) {
        if (top + bottom <= out.value) break;
        const double mean = heights[s].value - heights[t].value;
        const double deviation = (heights[s].change - heights[t].change).norm();
        if (mean + k * deviation > out.value) out = {out.nominal, mean, deviation, mean + k * deviation};
      }
    }
    return out;
  }

  const Tolerances& numbers_;
  std::vector<RunMoment> moments_;
};

/// The worst of the tracks that the quantity is of.
RobustFigure max_robust_figure(const TolerancedRun& off, const Tolerances& numbers, const ObjectiveTerm& term) {
  std::optional<RobustFigure> worst;
  double nominal = 0;
  for (const MetricSeries& track : list_metric_series(off.run())) {
    if (!is_quantity_name(term.quantity, track.quantity) && track.worst_group != term.quantity) continue;
    const RobustFigure found = RobustTrack(off, numbers, track).compute(term.figure, *term.deviation_multiple);
    nominal = std::max(nominal, found.nominal);
    if (!worst || found.value > worst->value) worst = found;
  }
  if (!worst)
    throw std::invalid_argument("a run along '" + term.trajectory + "' has no quantity '" + term.quantity + "'");
  worst->nominal = nominal;
  return *worst;
}

}  // namespace

Tolerances evaluate_tolerances(const DesignSpace& space) {
  const RecordedValues<double> values(*space.recording, space.inputs);
  Tolerances numbers = space.start.tolerances;
  for (TolerancedParameter& one : numbers) {
    const double now = values(space.recording->toleranced.at(static_cast<std::size_t>(one.recording_index)));
    if (one.relative_width > 0) one.width = one.relative_width * std::abs(now);
    one.value = now;
  }
  return numbers;
}

RobustFigure compute_robust_figure(const DesignSpace& space, const VectorX& x, const ObjectiveTerm& term) {
  const DesignSpace here = space.fix_others(x, {});
  const Tolerances numbers = evaluate_tolerances(here);
  const DesignInstance trial{here.start.mechanism, here.start.trajectories};
  const TolerancedRun off(here, numbers, find_trajectory(trial, term), {term.quantity});
  if (off.outcome().status != MotionStatus::done)
    return {undefined_figure, undefined_figure, undefined_figure, undefined_figure};
  RobustFigure found = max_robust_figure(off, numbers, term);
  found.incompatible_parameters = off.incompatible_parameters();
  return found;
}

std::vector<RobustTerm> robust_terms(const DesignSpace& space, const VectorX& x,
                                     const std::vector<ObjectiveTerm>& terms) {
  std::vector<RobustTerm> found;
  for (const ObjectiveTerm& term : terms)
    if (term.deviation_multiple) found.push_back({term, compute_robust_figure(space, x, term)});
  return found;
}

}  // namespace balance
