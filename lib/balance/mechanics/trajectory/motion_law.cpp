#include "balance/mechanics/trajectory/motion_law.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>

namespace balance::trajectory {
namespace {

constexpr double pi = std::numbers::pi;

/// Ramps whose lengths add up to one within round-off leave no phase of constant velocity.
constexpr double ramp_tolerance = 1e-12;

/// Where a trapezoidal velocity starts to decrease; exactly `ramp_up` if the ramps meet.
double deceleration_start(const MotionLaw& law) {
  const double start = 1 - law.ramp_down;
  return start - law.ramp_up < ramp_tolerance ? law.ramp_up : start;
}

// The first halves, t in [0, 1/2], of the symmetric laws. The second halves follow from s(t) = 1 − s(1 − t), which
// makes both ends exact and avoids cancellation in the polynomials near 1.

/// t − sin(2πt)/2π by half-angle formulas: 1 − cos loses digits near the end, 2 sin² does not.
MotionLawValue cycloidal_half(double t) {
  const auto [sine, cosine] = sine_cosine(pi * t);
  return {t - sine * cosine / pi, 2 * sine * sine, 4 * pi * sine * cosine};
}

MotionLawValue bang_bang_half(double t) { return {2 * t * t, 4 * t, 4}; }

MotionLawValue cubic_half(double t) { return {t * t * (3 - 2 * t), 6 * t * (1 - t), 6 - 12 * t}; }

MotionLawValue polynomial_345_half(double t) {
  const double square = t * t, r = 1 - t;
  return {square * t * (10 + t * (-15 + 6 * t)), 30 * square * r * r, 60 * t * r * (1 - 2 * t)};
}

MotionLawValue polynomial_4567_half(double t) {
  const double square = t * t, r = 1 - t;
  return {square * square * (35 + t * (-84 + t * (70 - 20 * t))), 140 * square * t * r * r * r,
          420 * square * r * r * (1 - 2 * t)};
}

/// (1 − cos πt)/2
MotionLawValue harmonic_half(double t) {
  const double sine_half = elementary::sin(pi * t / 2);
  const auto [sine, cosine] = sine_cosine(pi * t);
  return {sine_half * sine_half, pi / 2 * sine, pi * pi / 2 * cosine};
}

/// s'' is a quarter sine of period 1/2 up to 1/8, then a quarter sine of period 3/2, which is zero at 1/2. With s'' =
/// A at 1/8, integrating gives s'(1/2) = A/π and s(1/2) = A (4 + π)/(8π²); the latter must be 1/2, so A = 4π²/(4 + π).
MotionLawValue modified_sine_half(double t) {
  constexpr double unit = 1 / (4 + pi);
  if (t < 0.125) {
    const auto [sine, cosine] = sine_cosine(2 * pi * t);
    return {unit * (pi * t - sine * cosine / 2), 2 * pi * unit * sine * sine, 8 * pi * pi * unit * sine * cosine};
  }
  const double phase = pi / 3 * (4 * t + 1);
  const auto [sine, cosine] = sine_cosine(phase);
  return {unit * (2 + pi * t - 2.25 * sine), pi * unit * (1 - 3 * cosine), 4 * pi * pi * unit * sine};
}

/// s'' is a quarter sine up to 1/8, constant A up to 3/8, a quarter cosine down to zero at 1/2. Integrating twice gives
/// s(1/2) = A (2 + π)/(16π), which must be 1/2, so A = 8π/(2 + π).
MotionLawValue modified_trapezoidal_half(double t) {
  constexpr double peak = 8 * pi / (2 + pi);
  constexpr double w = 4 * pi;
  constexpr double ds_first = peak / w, s_first = ds_first * (0.125 - 1 / w);
  constexpr double ds_second = ds_first + peak / 4, s_second = s_first + ds_first / 4 + peak / 32;
  if (t < 0.125) {
    const auto [sine, cosine] = sine_cosine(w * t / 2);
    return {peak / w * (t - 2 * sine * cosine / w), 2 * peak / w * sine * sine, 2 * peak * sine * cosine};
  }
  if (t < 0.375) {
    const double u = t - 0.125;
    return {s_first + u * (ds_first + u * peak / 2), ds_first + u * peak, peak};
  }
  const double u = t - 0.375;
  const auto [sine, cosine] = sine_cosine(w * u);
  return {s_second + u * ds_second + peak * (1 - cosine) / (w * w), ds_second + peak * sine / w, peak * cosine};
}

template <typename Half>
MotionLawValue evaluate_symmetric(Half half, double tau, Side side) {
  if (tau < 0.5 || (tau == 0.5 && side == Side::before)) return half(tau);
  const MotionLawValue value = half(1 - tau);
  return {1 - value.s, value.ds, -value.dds};
}

MotionLawValue trapezoidal_velocity(const MotionLaw& law, double tau, Side side) {
  const double up = law.ramp_up, down = law.ramp_down, brake = deceleration_start(law);
  const double velocity = 1 / (1 - (up + down) / 2);  // the area under the trapezium is one
  if (tau < up || (tau == up && side == Side::before)) {
    return {velocity * tau * tau / (2 * up), velocity * tau / up, velocity / up};
  }
  if (tau > brake || (tau == brake && side == Side::after)) {
    const double remaining = 1 - tau;
    return {1 - velocity * remaining * remaining / (2 * down), velocity * remaining / down, -velocity / down};
  }
  return {velocity * (tau - up / 2), velocity, 0};
}

/// Index of the node at the beginning of the interval that contains tau.
std::size_t find_node_interval(const std::vector<MotionLawNode>& nodes, double tau, Side side) {
  const auto is_beyond = [side](double at, const MotionLawNode& node) {
    return side == Side::after ? at < node.tau : at <= node.tau;
  };
  const auto next = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, tau, is_beyond);
  return static_cast<std::size_t>(next - nodes.begin()) - 1;
}

MotionLawValue interpolate_nodes(const MotionLawNode& a, const MotionLawNode& b, double tau) {
  const PhasePoint point = interpolate_quintic({a.tau, a.s, a.ds, a.dds_after}, {b.tau, b.s, b.ds, b.dds_before}, tau);
  return {point.s, point.v, point.u};
}

MotionLawValue evaluate_nodes(const MotionLaw& law, double tau, Side side) {
  validate(law);
  const std::size_t k = find_node_interval(law.nodes, tau, side);
  return interpolate_nodes(law.nodes[k], law.nodes[k + 1], tau);
}

}  // namespace

/// Integrates the cubic through the rates and second rates of both points. The remaining displacement is added
/// by x³ (10 − 15x + 6x²), whose first and second derivatives vanish at both ends.
PhasePoint interpolate_quintic(const PhasePoint& a, const PhasePoint& b, double t) {
  constexpr double displacement_epsilon = 1e-14;  // of s, which ends at 1
  const double h = b.t - a.t, x = (t - a.t) / h;
  const double v = a.v * h, w = a.u * h * h, gain = b.v * h - v, w1 = b.u * h * h;
  const double c2 = 3 * gain - 2 * w - w1, c3 = w + w1 - 2 * gain;
  double correction = b.s - a.s - (v + w / 2 + c2 / 3 + c3 / 4);
  if (std::abs(correction) < displacement_epsilon) correction = 0;
  const double y = 1 - x;
  return {t,
          a.s + x * (v + x * (w / 2 + x * (c2 / 3 + x * c3 / 4))) + correction * x * x * x * (10 + x * (-15 + 6 * x)),
          (v + x * (w + x * (c2 + x * c3)) + 30 * correction * x * x * y * y) / h,
          (w + x * (2 * c2 + x * 3 * c3) + 60 * correction * x * y * (1 - 2 * x)) / (h * h)};
}

void validate(const MotionLaw& law) {
  if (is_mechanism_dependent(law.kind) && law.nodes.size() < 2)
    throw std::invalid_argument("the law of motion depends on the mechanism and has not been found yet");
  if (law.kind != MotionLawKind::trapezoidal_velocity) return;
  const auto is_fraction = [](double ramp) { return ramp > 0 && ramp < 1; };
  if (!is_fraction(law.ramp_up) || !is_fraction(law.ramp_down)) {
    throw std::invalid_argument(
        "the ramps of a trapezoidal velocity must lie between 0 and 1, as parts of the duration; found " +
        std::to_string(law.ramp_up) + " and " + std::to_string(law.ramp_down));
  }
  if (law.ramp_up + law.ramp_down > 1 + ramp_tolerance) {
    throw std::invalid_argument(
        "the two ramps of a trapezoidal velocity must together take at most the whole duration; found " +
        std::to_string(law.ramp_up) + " + " + std::to_string(law.ramp_down) + " > 1");
  }
}

MotionLawValue evaluate(const MotionLaw& law, double tau, Side side) {
  switch (law.kind) {
    case MotionLawKind::cycloidal: return evaluate_symmetric(cycloidal_half, tau, side);
    case MotionLawKind::bang_bang: return evaluate_symmetric(bang_bang_half, tau, side);
    case MotionLawKind::uniform: return {tau, 1, 0};
    case MotionLawKind::cubic: return evaluate_symmetric(cubic_half, tau, side);
    case MotionLawKind::polynomial_345: return evaluate_symmetric(polynomial_345_half, tau, side);
    case MotionLawKind::polynomial_4567: return evaluate_symmetric(polynomial_4567_half, tau, side);
    case MotionLawKind::harmonic: return evaluate_symmetric(harmonic_half, tau, side);
    case MotionLawKind::modified_sine: return evaluate_symmetric(modified_sine_half, tau, side);
    case MotionLawKind::modified_trapezoidal: return evaluate_symmetric(modified_trapezoidal_half, tau, side);
    case MotionLawKind::trapezoidal_velocity: return trapezoidal_velocity(law, tau, side);
    case MotionLawKind::time_optimal:
    case MotionLawKind::min_peak:
    case MotionLawKind::constant_momentum: return evaluate_nodes(law, tau, side);
  }
  throw std::invalid_argument("unknown law of motion");
}

std::vector<double> find_acceleration_jumps(const MotionLaw& law) {
  if (law.kind == MotionLawKind::bang_bang) return {0.5};
  if (is_mechanism_dependent(law.kind)) {
    std::vector<double> jumps;
    for (const MotionLawNode& node : law.nodes)
      if (node.dds_before != node.dds_after && node.tau > 0 && node.tau < 1) jumps.push_back(node.tau);
    return jumps;
  }
  if (law.kind != MotionLawKind::trapezoidal_velocity) return {};
  const double brake = deceleration_start(law);
  if (brake == law.ramp_up) return {brake};
  return {law.ramp_up, brake};
}

}  // namespace balance::trajectory
