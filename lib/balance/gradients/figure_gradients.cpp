#include "balance/gradients/motion_gradient.hpp"
#include "balance/result/tracks.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace balance
