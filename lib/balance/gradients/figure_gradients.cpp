#include "balance/gradients/motion_gradient.hpp"
#include "balance/result/tracks.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// One row of the run or of what lies between its samples, in the order of time.
struct Place {
  double time;
  bool between;
  long row;
};

std::vector<Place> in_order(const RunGradient& gradient) {
  std::vector<Place> places;
  std::size_t j = 0;
  const std::vector<long>& next = gradient.between.next_sample;
  for (long k = 0; k < gradient.run.time.size(); ++k) {
    for (; j < next.size() && next[j] == k; ++j)
      places.push_back({gradient.between.rows.time[static_cast<long>(j)], true, static_cast<long>(j)});
    places.push_back({gradient.run.time[k], false, k});
  }
  return places;
}

using Gradient = Eigen::Array<double, dual_width, 1>;

/// A scalar, or a vector's magnitude, with its derivatives.
struct Value {
  double value = 0;
  Gradient d = Gradient::Zero();
  double size() const { return std::abs(value); }
  Gradient d_size() const { return value < 0 ? Gradient(-d) : d; }
};

Value value_at(const RunGradient& gradient, Samples Result::*array, int first, int count, const Place& place) {
  const auto entries = [&](const Result& rows) { return (rows.*array).row(place.row).segment(first, count); };
  const auto now = entries(place.between ? gradient.between.rows : gradient.run);
  Value out{count == 1 ? now[0] : now.norm(), Gradient::Zero()};
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

FigureGradient measure(const RunGradient& gradient, const Track& track, const std::vector<Place>& places) {
  FigureGradient figure{.quantity = track.quantity};
  Value peak, low{INFINITY}, high{-INFINITY}, last;
  double squares = 0, sum = 0;
  Gradient d_squares = Gradient::Zero(), d_sum = Gradient::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Value now = value_at(gradient, track.array, track.first, track.count, places[i]);
    if (now.size() > peak.size()) peak = now;
    if (now.value < low.value) low = now;
    if (now.value > high.value) high = now;
    if (i > 0) {
      const double half = (places[i].time - places[i - 1].time) / 2;
      squares += half * (now.value * now.value + last.value * last.value);
      d_squares += 2 * half * (now.value * now.d + last.value * last.d);
      sum += half * (now.size() + last.size());
      d_sum += half * (now.d_size() + last.d_size());
    }
    last = now;
  }
  const double duration = places.back().time - places.front().time;
  figure.peak = peak.size(), figure.range = high.value - low.value;
  figure.rms = std::sqrt(squares / duration), figure.mean = sum / duration;
  write(peak.d_size(), figure.d_peak);
  write(high.d - low.d, figure.d_range);
  write(d_sum / duration, figure.d_mean);
  if (figure.rms > 0) write(d_squares / (2 * figure.rms * duration), figure.d_rms);
  return figure;
}

}  // namespace

FigureGradients figure_gradients(const RunGradient& gradient) {
  const std::vector<Place> places = in_order(gradient);
  FigureGradients out;
  for (const Track& track : list_tracks(gradient.run)) out.figures.push_back(measure(gradient, track, places));
  Gradient d_energy = Gradient::Zero();
  for (int a = 0; a < static_cast<int>(gradient.run.actuator_names.size()); ++a)
    for (std::size_t i = 1; i < places.size(); ++i) {
      const double half = (places[i].time - places[i - 1].time) / 2;
      for (const std::size_t end : {i - 1, i}) {
        const Value power = value_at(gradient, &Result::power, a, 1, places[end]);
        out.energy += half * power.size();
        d_energy += half * power.d_size();
      }
    }
  write(d_energy, out.d_energy);
  return out;
}

}  // namespace balance
