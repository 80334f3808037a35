#include "balance/interface/comparison/sampled_curve.hpp"

#include "balance/foundation/numerics/bracketed_root.hpp"

#include <algorithm>
#include <cmath>

namespace balance::comparison {
namespace {

constexpr double jump_slope_ratio = 10;         // times its neighbours': smooth samples worth comparing never come near
constexpr double jump_epsilon = 1e-9;           // of the largest sample: steps of round-off are no jumps
constexpr double time_tolerance = 1e-9;         // of the whole time: a sample is meant
constexpr double touch_tolerance = 1e-9;        // of the largest sample: a level is touched, not missed by round-off
constexpr Eigen::Index curve_stencil_size = 4;  // number of samples that an interpolated value uses
constexpr int vector_subdivision = 8;           // parts of a step in which a magnitude is searched for crossings
constexpr double root_tolerance = 0;            // relative to a root's position: to its last digits

}  // namespace

std::vector<Eigen::Index> find_piece_begins(const VectorX& time, const Samples& samples, int first, int count,
                                            Eigen::Index begin, Eigen::Index end) {
  const auto row = [&](Eigen::Index k) { return samples.row(begin + k).segment(first, count); };
  const Eigen::Index n = end - begin;
  VectorX step(std::max<Eigen::Index>(n, 1)), slope(step.size());
  step[0] = slope[0] = 0;
  double largest = 0;
  for (Eigen::Index k = 0; k < n; ++k) largest = std::max(largest, row(k).norm());
  for (Eigen::Index k = 1; k < n; ++k) {
    step[k] = (row(k) - row(k - 1)).norm();
    slope[k] = step[k] / (time[begin + k] - time[begin + k - 1]);
  }
  std::vector<Eigen::Index> begins = {begin};
  for (Eigen::Index k = 1; k < n; ++k) {
    // Two neighbouring steps, because a single one may happen to be flat.
    const Eigen::Index from = std::clamp<Eigen::Index>(k - 1, 1, std::max<Eigen::Index>(n - 3, 1));
    double neighbour_slope = 0;
    for (Eigen::Index i = from; i < std::min(from + 3, n); ++i)
      neighbour_slope = i == k ? neighbour_slope : std::max(neighbour_slope, slope[i]);
    if (n > 3 && step[k] > jump_epsilon * largest && slope[k] > jump_slope_ratio * neighbour_slope)
      begins.push_back(begin + k);
  }
  return begins;
}

SampledCurve::SampledCurve(VectorX time, Samples samples) {
  double largest = 0;
  for (Eigen::Index k = 0; k < samples.rows(); ++k) largest = std::max(largest, samples.row(k).norm());
  std::vector<Eigen::Index> rows, breaks;
  for (Eigen::Index k = 0; k < time.size(); ++k) {
    if (!rows.empty() && time[k] <= time[rows.back()]) {
      // both sides of a jump of another quantity
      if (!((samples.row(k) - samples.row(rows.back())).norm() > jump_epsilon * largest)) continue;
      breaks.push_back(static_cast<Eigen::Index>(rows.size()));
    }
    rows.push_back(k);
  }
  const auto count = static_cast<Eigen::Index>(rows.size());
  time_.resize(count);
  samples_.resize(count, samples.cols());
  for (Eigen::Index k = 0; k < count; ++k) {
    time_[k] = time[rows[static_cast<std::size_t>(k)]];
    samples_.row(k) = samples.row(rows[static_cast<std::size_t>(k)]);
    values_.push_back(scalar_of(samples_.row(k).transpose()));
  }
  breaks.push_back(count);
  Eigen::Index begin = 0;
  for (const Eigen::Index end : breaks) {
    for (const Eigen::Index piece :
         find_piece_begins(time_, samples_, 0, static_cast<int>(samples_.cols()), begin, end))
      piece_begins_.push_back(piece);
    begin = end;
  }
  piece_begins_.push_back(count);
}

VectorX StepPolynomial::value(double s) const {
  return coefficients.transpose() * Eigen::Vector4d(1, s, s * s, s * s * s);
}

VectorX StepPolynomial::slope(double s) const {
  return coefficients.transpose() * Eigen::Vector4d(0, 1, 2 * s, 3 * s * s);
}

StepPolynomial interpolate_step(const VectorX& time, const Eigen::Ref<const Samples>& samples, Eigen::Index begin,
                                Eigen::Index end, Eigen::Index k, Eigen::Index shift) {
  const Eigen::Index points = std::min(curve_stencil_size, end - begin);
  const Eigen::Index nearest = std::clamp(k - points / 2, begin, end - points),
                     from = std::clamp(nearest + shift, begin, end - points);
  StepPolynomial p{Eigen::Matrix<double, 4, Eigen::Dynamic>::Zero(4, samples.cols()), time[k - 1],
                   time[k] - time[k - 1]};
  const auto place = [&](Eigen::Index i) { return (time[from + i] - p.begin) / p.length; };
  MatrixX differences = samples.middleRows(from, points);
  for (Eigen::Index order = 1; order < points; ++order)
    for (Eigen::Index i = points - 1; i >= order; --i)
      differences.row(i) = (differences.row(i) - differences.row(i - 1)) / (place(i) - place(i - order));
  Eigen::Vector4d basis(1, 0, 0, 0);  // coefficients of (s − s_0) (s − s_1) …
  for (Eigen::Index order = 0; order < points; ++order) {
    p.coefficients += basis * differences.row(order);
    const Eigen::Vector4d shifted(0, basis[0], basis[1], basis[2]);
    basis = shifted - place(order) * basis;
  }
  return p;
}

/// The piece's first or last polynomial at a time outside of the piece.
VectorX SampledCurve::extrapolate(std::size_t piece, double time) const {
  const Eigen::Index begin = piece_begins_[piece], end = piece_end(piece);
  if (end - begin == 1) return samples_.row(begin).transpose();
  return polynomial(piece, time < time_[begin] ? begin + 1 : end - 1).value_at_time(time);
}

std::pair<double, SampledCurve::Gap> SampledCurve::evaluate(double time, JumpSide side) const {
  const double tolerance = time_tolerance * (end_time() - begin_time());
  if (!(time >= begin_time() - tolerance && time <= end_time() + tolerance)) return {NAN, Gap::outside};
  const std::size_t pieces = piece_begins_.size() - 1;
  std::size_t last = 0;  // piece that begins at the time or before it
  while (last + 1 < pieces && time_[piece_begins_[last + 1]] <= time + tolerance) ++last;
  const bool is_at_begin = std::abs(time_[piece_begins_[last]] - time) <= tolerance;
  if (side == JumpSide::before && is_at_begin && last > 0) --last;
  const Eigen::Index begin = piece_begins_[last], end = piece_end(last);
  if (time > time_[end - 1] + tolerance) {  // within the step of a jump
    if (side == JumpSide::any) return {NAN, Gap::jump};
    return {scalar_of(extrapolate(side == JumpSide::after ? last + 1 : last, time)), Gap::none};
  }
  const auto next = std::lower_bound(time_.begin() + begin, time_.begin() + end, time - tolerance);
  const Eigen::Index k = next - time_.begin();
  if (std::abs(time_[k] - time) <= tolerance) return {values_[static_cast<std::size_t>(k)], Gap::none};
  return {scalar_of(polynomial(last, k).value_at_time(time)), Gap::none};
}

/// Places within a step, from 0 to 1, between which the curve is monotonic: of a vector's magnitude, a fine division.
std::vector<double> SampledCurve::critical_points(const StepPolynomial& p) const {
  std::vector<double> points;
  if (!is_scalar()) {
    for (int i = 1; i < vector_subdivision; ++i) points.push_back(static_cast<double>(i) / vector_subdivision);
    return points;
  }
  // 3 c s² + 2 b s + a = 0, without cancellation
  const double a = p.coefficients(1, 0), b = p.coefficients(2, 0), c = 3 * p.coefficients(3, 0);
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0)) return points;
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  for (const double s : {q / c, a / q})
    if (s > 0 && s < 1) points.push_back(s);
  std::sort(points.begin(), points.end());
  return points;
}

/// Whether a distance from a level within a step is larger than the error of the interpolation, which the polynomials
/// through neighbouring rows show. Otherwise the end of a motion, where the curve is flat, would seem to be passed.
bool SampledCurve::is_beyond_error(std::size_t piece, Eigen::Index k, double s, const StepPolynomial& p,
                                   double distance) const {
  for (const Eigen::Index shift : {-1, 1}) {
    const double error = std::abs(scalar_of(polynomial(piece, k, shift).value(s)) - scalar_of(p.value(s)));
    if (std::abs(distance) <= error) return false;
  }
  return true;
}

std::vector<double> SampledCurve::find_crossings(double level) const {
  double largest = std::abs(level);
  for (const double value : values_) largest = std::max(largest, std::abs(value));
  std::vector<double> crossings;
  for (std::size_t piece = 0; piece + 1 < piece_begins_.size(); ++piece) {
    /// A place up to which the curve is monotonic from the one before, and its distance from the level.
    struct Place {
      double time, distance;
      std::size_t polynomial;
    };
    const Eigen::Index begin = piece_begins_[piece];
    std::vector<Place> places{{time_[begin], values_[static_cast<std::size_t>(begin)] - level, 0}};
    std::vector<StepPolynomial> polynomials;
    const auto distance = [&](std::size_t i, double time) {
      return scalar_of(polynomials[i].value_at_time(time)) - level;
    };
    for (Eigen::Index k = begin + 1; k < piece_end(piece); ++k) {
      const std::size_t i = polynomials.size();
      polynomials.push_back(polynomial(piece, k));
      const double first = values_[static_cast<std::size_t>(k - 1)] - level,
                   last = values_[static_cast<std::size_t>(k)] - level;
      for (const double s : critical_points(polynomials[i])) {
        const double time = polynomials[i].begin + s * polynomials[i].length, d = distance(i, time);
        // the samples on both sides are on one side of the level
        const bool is_excursion = first * last >= 0 && d * (first + last) <= 0;
        if (!is_excursion || is_beyond_error(piece, k, s, polynomials[i], d)) places.push_back({time, d, i});
      }
      places.push_back({time_[k], values_[static_cast<std::size_t>(k)] - level, i});
    }
    const auto is_on_level = [&](std::size_t i) { return std::abs(places[i].distance) <= touch_tolerance * largest; };
    const auto find_root = [&](std::size_t i) -> std::optional<double> {  // between places i − 1 and i
      if (!(places[i - 1].distance * places[i].distance < 0)) return std::nullopt;
      return numerics::find_bracketed_root([&](double time) { return distance(places[i].polynomial, time); },
                                           places[i - 1].time, places[i].time, places[i - 1].distance,
                                           places[i].distance, root_tolerance);
    };
    for (std::size_t i = 0; i < places.size(); ++i) {
      std::optional<double> crossing;
      if (i > 0) crossing = find_root(i);
      if (is_on_level(i)) {  // one crossing of a stretch on the level, and of the steps to and from it
        std::size_t nearest = i;
        for (; i < places.size() && is_on_level(i); ++i) {
          if (!crossing && i > 0) crossing = find_root(i);
          if (std::abs(places[i].distance) < std::abs(places[nearest].distance)) nearest = i;
        }
        if (!crossing && i < places.size()) crossing = find_root(i);
        if (!crossing) crossing = places[nearest].time;
      }
      if (crossing && (crossings.empty() || *crossing > crossings.back())) crossings.push_back(*crossing);
    }
  }
  return crossings;
}

/// A place strictly within a step where the slope of sign · value (of a vector: of half its square) falls through zero.
std::optional<double> SampledCurve::find_interior_extremum(const StepPolynomial& p, double sign) const {
  const auto slope = [&](double s) { return sign * (is_scalar() ? p.slope(s)[0] : p.value(s).dot(p.slope(s))); };
  const double first = slope(0), last = slope(1);
  if (!(first > 0 && last < 0)) return std::nullopt;
  return numerics::find_bracketed_root(slope, 0, 1, first, last, root_tolerance);
}

double SampledCurve::find_extremum(Extremum extremum) const {
  const auto rank = [&](double value) {
    return extremum == Extremum::peak ? std::abs(value) : extremum == Extremum::maximum ? value : -value;
  };
  double best = -INFINITY, largest = 0;
  for (const double value : values_) best = std::max(best, rank(value)), largest = std::max(largest, std::abs(value));
  // among extremes that are equal up to round-off, the first
  const auto at =
      std::find_if(values_.begin(), values_.end(), [&](double value) { return rank(value) >= best - 1e-10 * largest; });
  if (at == values_.end()) return begin_time();
  const Eigen::Index k = at - values_.begin();
  const std::size_t piece = static_cast<std::size_t>(
      std::upper_bound(piece_begins_.begin(), piece_begins_.end() - 1, k) - piece_begins_.begin() - 1);
  const double sign = extremum == Extremum::minimum || (extremum == Extremum::peak && *at < 0) ? -1 : 1;
  double time = time_[k], value = rank(*at);
  for (const Eigen::Index step : {k, k + 1}) {
    if (step <= piece_begins_[piece] || step >= piece_end(piece)) continue;
    const StepPolynomial p = polynomial(piece, step);
    const std::optional<double> s = find_interior_extremum(p, sign);
    if (!s) continue;
    const double candidate = rank(scalar_of(p.value(*s)));
    if (candidate > value) time = p.begin + *s * p.length, value = candidate;
  }
  return time;
}

}  // namespace balance::comparison
