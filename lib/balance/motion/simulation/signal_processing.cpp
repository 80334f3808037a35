#include "balance/motion/simulation/signal_processing.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <unsupported/Eigen/FFT>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>

namespace balance::simulation {

namespace {

constexpr double gap_steps = 5;               ///< a longer step, in median ones, is a gap
constexpr double even_step_tolerance = 1e-3;  ///< largest deviation of a step from the median, relative
constexpr Eigen::Index min_piece_samples = 24;

double median_step(const VectorX& time) {
  std::vector<double> steps;
  for (Eigen::Index k = 1; k < time.size(); ++k) steps.push_back(time[k] - time[k - 1]);
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

std::string format_time(double time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", time);
  return text;
}

double interpolate_linearly(const VectorX& x, const VectorX& y, double at, Eigen::Index& k) {
  while (k + 2 < x.size() && x[k + 1] < at) ++k;
  const double weight = (at - x[k]) / (x[k + 1] - x[k]);
  return y[k] + weight * (y[k + 1] - y[k]);
}

UniformPiece resample_piece(const MeasurementRecord& record, Eigen::Index begin, Eigen::Index count, double step) {
  UniformPiece piece{.start = record.time[begin], .step = step, .values = {}};
  const VectorX time = record.time.segment(begin, count);
  double unevenness = 0;
  for (Eigen::Index k = 0; k < count; ++k) unevenness = std::max(unevenness, std::abs(time[k] - piece.time(k)));
  if (unevenness <= even_step_tolerance * step) {
    piece.values = record.values.middleRows(begin, count);
    return piece;
  }
  const double duration = time[count - 1] - time[0];
  const auto samples = static_cast<Eigen::Index>(std::floor(duration / step + even_step_tolerance)) + 1;
  piece.values.resize(samples, record.values.cols());
  for (Eigen::Index s = 0; s < record.values.cols(); ++s) {
    const VectorX measured = record.values.col(s).segment(begin, count);
    if (record.signals[static_cast<std::size_t>(s)].kind == MeasuredSignal::Kind::position) {
      const numerics::CubicSpline spline({time.begin(), time.end()}, Samples(measured),
                                         numerics::SplineEnd::not_a_knot);
      VectorX value(1), first(1), second(1);
      for (Eigen::Index k = 0; k < samples; ++k) {
        spline.at(std::min(piece.time(k), time[count - 1]), value, first, second);
        piece.values(k, s) = value[0];
      }
    } else {
      Eigen::Index interval = 0;
      for (Eigen::Index k = 0; k < samples; ++k)
        piece.values(k, s) = interpolate_linearly(time, measured, std::min(piece.time(k), time[count - 1]), interval);
    }
  }
  return piece;
}

}  // namespace

int find_signal(const MeasurementRecord& record, MeasuredSignal signal) {
  const auto match = std::find(record.signals.begin(), record.signals.end(), signal);
  return match == record.signals.end() ? -1 : static_cast<int>(match - record.signals.begin());
}

std::vector<UniformPiece> resample(const MeasurementRecord& record, std::vector<std::string>& notes) {
  const double step = median_step(record.time);
  std::vector<UniformPiece> pieces;
  for (Eigen::Index begin = 0; begin < record.time.size();) {
    Eigen::Index end = begin + 1;
    while (end < record.time.size() && record.time[end] - record.time[end - 1] <= gap_steps * step) ++end;
    if (end < record.time.size())
      notes.push_back(record.source + ": cut at the gap from " + format_time(record.time[end - 1]) + " to " +
                      format_time(record.time[end]) + " s");
    if (end - begin >= min_piece_samples)
      pieces.push_back(resample_piece(record, begin, end - begin, step));
    else
      notes.push_back(record.source + ": the " + std::to_string(end - begin) + " rows from " +
                      format_time(record.time[begin]) + " s are too few to differentiate and are left out");
    begin = end;
  }
  return pieces;
}

// Butterworth filter as two sections of second order (bilinear transform with prewarping), from the analogue prototype
// s² + s/Q + 1 with 1/Q = 2 cos(π/8) and 2 cos(3π/8).
ZeroPhaseFilter::ZeroPhaseFilter(double cutoff, double step) {
  if (!(cutoff > 0) || !(cutoff * step < 0.49)) return;
  const double k = elementary::tan(std::numbers::pi * cutoff * step);
  for (const double angle : {std::numbers::pi / 8, 3 * std::numbers::pi / 8}) {
    const double damping = 2 * elementary::cos(angle), norm = 1 / (1 + damping * k + k * k);
    const double b = k * k * norm;
    sections_.push_back({b, 2 * b, b, 2 * (k * k - 1) * norm, (1 - damping * k + k * k) * norm});
  }
  padding_ = static_cast<Eigen::Index>(std::ceil(2 / (cutoff * step)));
}

void ZeroPhaseFilter::run(std::vector<double>& signal) const {
  for (const Section& s : sections_) {
    // transposed direct form; the states of a constant input, whose output equals it
    double z1 = (1 - s.b0) * signal.front(), z2 = (s.b2 - s.a2) * signal.front();
    for (double& x : signal) {
      const double y = s.b0 * x + z1;
      z1 = s.b1 * x - s.a1 * y + z2;
      z2 = s.b2 * x - s.a2 * y;
      x = y;
    }
  }
}

void ZeroPhaseFilter::apply(Eigen::Ref<MatrixX> columns) const {
  const Eigen::Index n = columns.rows();
  if (sections_.empty() || n < 2) return;
  const Eigen::Index padding = std::min(padding_, n - 1);
  std::vector<double> signal(static_cast<std::size_t>(n + 2 * padding));
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    auto column = columns.col(c);
    for (Eigen::Index k = 0; k < padding; ++k) {
      signal[static_cast<std::size_t>(k)] = 2 * column[0] - column[padding - k];
      signal[static_cast<std::size_t>(padding + n + k)] = 2 * column[n - 1] - column[n - 2 - k];
    }
    std::copy(column.begin(), column.end(), signal.begin() + padding);
    run(signal);
    std::reverse(signal.begin(), signal.end());
    run(signal);
    std::reverse(signal.begin(), signal.end());
    std::copy_n(signal.begin() + padding, n, column.begin());
  }
}

void differentiate(const MatrixX& values, double step, MatrixX& rates, MatrixX& accelerations) {
  const Eigen::Index n = values.rows();
  rates.setZero(n, values.cols());
  accelerations.setZero(n, values.cols());
  if (n < 2 * derivative_margin + 1) return;
  for (Eigen::Index k = derivative_margin; k < n - derivative_margin; ++k) {
    const auto difference = [&](Eigen::Index j) { return values.row(k + j) - values.row(k - j); };
    const auto sum = [&](Eigen::Index j) { return values.row(k + j) + values.row(k - j) - 2 * values.row(k); };
    rates.row(k) = (difference(1) * 0.75 - difference(2) * 0.15 + difference(3) / 60) / step;
    accelerations.row(k) = (sum(1) * 1.5 - sum(2) * 0.15 + sum(3) / 90) / (step * step);
  }
  for (Eigen::Index k = 0; k < derivative_margin; ++k) {
    for (MatrixX* all : {&rates, &accelerations}) {
      all->row(k) = all->row(derivative_margin);
      all->row(n - 1 - k) = all->row(n - 1 - derivative_margin);
    }
  }
}

namespace {

struct SpectralLine {
  double frequency, energy;  ///< negative where there is less than the mean noise
};

/// Spectrum of a signal's rates through a Hann window. White noise of the positions, such as that of encoders, has rates
/// whose power grows as sin²(π f step): what the top quarter of the band holds is taken for such noise, and its like is
/// subtracted everywhere.
void append_rate_spectrum(const VectorX& positions, double step, std::vector<SpectralLine>& lines) {
  const Eigen::Index n = positions.size() - 1;
  if (n < 2) return;
  std::vector<double> rates(static_cast<std::size_t>(n));
  for (Eigen::Index k = 0; k < n; ++k) {
    const double phase = 2 * std::numbers::pi * (static_cast<double>(k) + 0.5) / static_cast<double>(n);
    rates[static_cast<std::size_t>(k)] = (positions[k + 1] - positions[k]) / step * (1 - elementary::cos(phase));
  }
  std::vector<std::complex<double>> spectrum;
  Eigen::FFT<double> fft;
  fft.fwd(spectrum, rates);
  const std::size_t half = spectrum.size() / 2 + 1;
  std::vector<double> shape(half);
  double top_power = 0, top_shape = 0;
  for (std::size_t k = 0; k < half; ++k) {
    const double sine = elementary::sin(std::numbers::pi * static_cast<double>(k) / static_cast<double>(n));
    shape[k] = sine * sine;
    if (4 * k >= 3 * half) top_power += std::norm(spectrum[k]), top_shape += shape[k];
  }
  const double level = top_shape > 0 ? top_power / top_shape : 0;
  for (std::size_t k = 0; k < half; ++k)
    lines.push_back({static_cast<double>(k) / (static_cast<double>(n) * step),
                     (std::norm(spectrum[k]) - level * shape[k]) * step / static_cast<double>(n)});
}

}  // namespace

double find_bandwidth(const std::vector<MatrixX>& positions, const std::vector<double>& steps, double fraction) {
  double bandwidth = 0;
  for (Eigen::Index c = 0; !positions.empty() && c < positions.front().cols(); ++c) {
    std::vector<SpectralLine> lines;
    for (std::size_t p = 0; p < positions.size(); ++p) append_rate_spectrum(positions[p].col(c), steps[p], lines);
    std::stable_sort(lines.begin(), lines.end(),
                     [](const SpectralLine& a, const SpectralLine& b) { return a.frequency < b.frequency; });
    double total = 0, sum = 0;
    for (const SpectralLine& line : lines) total += line.energy;
    if (!(total > 0)) continue;
    for (const SpectralLine& line : lines)
      if ((sum += line.energy) >= fraction * total) {
        bandwidth = std::max(bandwidth, line.frequency);
        break;
      }
  }
  return bandwidth;
}

double find_cutoff(const std::vector<MatrixX>& positions, const std::vector<double>& steps,
                   std::vector<std::string>& notes) {
  constexpr double energy_fraction = 0.99, bandwidths = 6, max_sampling_fraction = 0.2;
  double cutoff = bandwidths * find_bandwidth(positions, steps, energy_fraction), sampling = 0;
  for (const double step : steps) sampling = std::max(sampling, 1 / step);
  if (cutoff > max_sampling_fraction * sampling) {
    cutoff = max_sampling_fraction * sampling;
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.4g", sampling);
    notes.push_back(std::string("the motion fills the band that ") + rate +
                    " rows a second can show: the cut-off is a fifth of them");
  }
  if (!(cutoff > 0)) return 0;
  const double magnitude = std::floor(elementary::log10(cutoff)) - 1;
  double unit = 1;
  for (int k = 0; k < std::abs(static_cast<int>(magnitude)); ++k) unit *= magnitude > 0 ? 10 : 0.1;
  return std::round(cutoff / unit) * unit;
}

Eigen::Index count_edge_samples(double cutoff, double step) {
  return static_cast<Eigen::Index>(std::ceil(1 / (cutoff * step))) + derivative_margin;
}

}  // namespace balance::simulation
