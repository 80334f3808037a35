/// Laws of the pieces of an identification: filter, derivatives, equation of motion, deviations, possible bodies.

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/random.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/motion/simulation/signal_processing.hpp"
#include "balance/synthesis/identification/base_combinations.hpp"
#include "balance/synthesis/identification/consistent_bodies.hpp"
#include "balance/synthesis/identification/estimation.hpp"
#include "balance/synthesis/identification/motion_equation.hpp"
#include "balance/synthesis/identification/regression.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

namespace balance::identification {

using simulation::derivative_margin;
using simulation::differentiate;
using simulation::find_bandwidth;
using simulation::ZeroPhaseFilter;

namespace {

TEST_CASE("the low-pass passes slow signals, halves the cut-off and delays nothing") {
  constexpr double step = 0.002, cutoff = 10;
  constexpr Eigen::Index n = 5000;
  for (const auto& [frequency, gain] : {std::pair{0.1, 1.0}, std::pair{10.0, 0.5}, std::pair{100.0, 0.0}}) {
    MatrixX signal(n, 1);
    VectorX sine(n), cosine(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const double phase = 2 * std::numbers::pi * frequency * step * static_cast<double>(k);
      sine[k] = std::sin(phase), cosine[k] = std::cos(phase);
    }
    signal.col(0) = sine;
    ZeroPhaseFilter(cutoff, step).apply(signal);
    // away from the ends, over whole periods; two passes of |H|² = 1/2 at the cut-off, (f_c/f)⁸ = 1e-8 far above it
    const Eigen::Index begin = 0, count = n;
    const VectorX middle = signal.col(0).segment(begin, count);
    CHECK(middle.dot(sine) / sine.squaredNorm() == doctest::Approx(gain).epsilon(0.01).scale(1));
    CHECK(std::abs(middle.dot(cosine)) / cosine.squaredNorm() < 0.01);
  }
}

TEST_CASE("the bandwidth of a noisy motion is that of the motion") {
  constexpr double step = 0.001;
  numerics::UniformRandom random(4);
  const VectorX shocks = random.sample_normal(20000);
  MatrixX positions(20000, 1);
  for (Eigen::Index k = 0; k < positions.rows(); ++k)
    positions(k, 0) = std::sin(2 * std::numbers::pi * 1.5 * step * static_cast<double>(k)) + 5e-3 * shocks[k];
  // rates of the noise, 5e-3 √2/step, are as large as those of the motion; the window widens a line by two of 0.05 Hz
  CHECK(find_bandwidth({positions}, {step}, 0.9) == doctest::Approx(1.5).epsilon(0.1));
}

TEST_CASE("differences are exact for polynomials of degree six") {
  constexpr double step = 0.1;
  MatrixX values(40, 1), rates, accelerations;
  for (Eigen::Index k = 0; k < values.rows(); ++k) {
    const double t = step * static_cast<double>(k);
    values(k, 0) = 1 - t + t * t * t * (2 - t * t * t / 8);
  }
  differentiate(values, step, rates, accelerations);
  for (Eigen::Index k = derivative_margin; k < values.rows() - derivative_margin; ++k) {
    const double t = step * static_cast<double>(k);
    // round-off of values up to 500 divided by step and its square
    CHECK(rates(k, 0) == doctest::Approx(-1 + 6 * t * t - 0.75 * std::pow(t, 5)).epsilon(1e-9).scale(100));
    CHECK(accelerations(k, 0) == doctest::Approx(12 * t - 3.75 * std::pow(t, 4)).epsilon(1e-9).scale(1000));
  }
}

TEST_CASE("the equation of motion gives the efforts of inverse dynamics, friction, springs and discs included") {
  for (const char* file : {"5r.yaml", "3rrr.yaml", "delta.yaml", "geared-five-bar.yaml", "spatial-rrr.yaml",
                           "spring-balancer-two-link.yaml", "torsion-spring-arm.yaml"}) {
    CAPTURE(file);
    Mechanism mechanism = read_spec_file(std::string(BALANCE_CONFIGS "/") + file).mechanism;
    mechanism.friction.clear();
    for (const CoordinateId c : mechanism.actuators)
      mechanism.friction.push_back({.coordinate = c, .viscous = 0.3, .coulomb = 0.7});
    InverseDynamics inverse(mechanism);
    MotionEquations equations(mechanism);
    const auto n = equations.degrees_of_freedom();
    REQUIRE(inverse.degrees_of_freedom() == n);
    if (!has_effort_rows(mechanism, n)) continue;
    numerics::UniformRandom random(1);
    VectorX q(n);
    for (int k = 0; k < n; ++k) {
      q[k] = 0.1;
      for (const CoordinateValue& value : mechanism.assembly)
        if (value.coordinate == equations.independent()[static_cast<std::size_t>(k)]) q[k] = value.value;
    }
    MotionEquation equation;
    VectorX efforts;
    for (int state = 0; state < 5; ++state) {
      const VectorX at = q + 0.05 * random.sample_point(n), dq = random.sample_normal(n), ddq = random.sample_normal(n);
      REQUIRE(equations.evaluate(at, dq, ddq, 0, equation).status == MotionStatus::done);
      REQUIRE(inverse.efforts(at, dq, ddq, efforts).status == MotionStatus::done);
      VectorX generalised = equation.inertial * equations.inertial_values() + equation.known;
      for (const Friction& friction : mechanism.friction) {
        const double rate = equation.rates[friction.coordinate];
        generalised += equation.rate_map.row(friction.coordinate).transpose() * (0.3 * rate + (rate < 0 ? -0.7 : 0.7));
      }
      const VectorX difference = equation.input * efforts - generalised;
      // both from the same numbers in another order
      CHECK(difference.norm() <= 1e-10 * (generalised.norm() + 1));
    }
  }
}

TEST_CASE("base combinations reproduce the rows, and the last columns are expressed by the first groups") {
  numerics::UniformRandom random(2);
  MatrixX rows(30, 6);
  for (Eigen::Index c = 0; c < 4; ++c) rows.col(c) = random.sample_normal(30);
  rows.col(4) = 2 * rows.col(0) - rows.col(2);
  rows.col(5).setZero();
  const BaseCombinations base = find_base_combinations(MatrixX(0, 6), rows, {1, 0, 0, 0, 0, 0});
  CHECK(base.base == std::vector<int>{1, 2, 3, 4});  // column 0, of the last group, follows from 2 and 4
  CHECK(base.rest == std::vector<int>{0, 5});
  const VectorX x = random.sample_normal(6);
  CHECK((base_columns(rows, base) * base.evaluate(x) - rows * x).norm() < 1e-12 * rows.norm() * x.norm());
  MatrixX more(10, 6);
  for (Eigen::Index c = 0; c < 6; ++c) more.col(c) = random.sample_normal(10);
  CHECK(find_missing_combinations(more, base, {1, 0, 0, 0, 0, 0}).rows() == 2);
  CHECK(find_missing_combinations(rows, base, {1, 0, 0, 0, 0, 0}).rows() == 0);
}

/// One channel with one piece.
std::vector<Channel> make_channel(const MatrixX& columns, const VectorX& measured, double step) {
  const auto n = static_cast<std::size_t>(measured.size());
  ChannelPiece piece;
  piece.step = step;
  piece.measured = measured, piece.columns = columns;
  piece.known = piece.rate = piece.slope = piece.time = VectorX::Zero(measured.size());
  piece.moving.assign(n, true), piece.is_fitted.assign(n, true);
  Channel channel{.name = "A", .unit = "N m"};
  channel.pieces.push_back(piece);
  return {channel};
}

TEST_CASE("robust deviations are those of the double sum with Bartlett weights, and honest for correlated residuals") {
  constexpr Eigen::Index n = 400, lag = 20;
  BaseCombinations base;
  base.base = {0, 1};
  base.factors = MatrixX(2, 0);
  numerics::UniformRandom random(3);
  double squares = 0, robust = 0, white = 0;
  constexpr int trials = 300;
  for (int trial = 0; trial < trials; ++trial) {
    MatrixX columns(n, 2);
    VectorX measured(n);
    double correlated = 0;
    const VectorX shocks = random.sample_normal(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      columns(k, 0) = 1, columns(k, 1) = std::sin(0.05 * static_cast<double>(k));
      correlated = 0.8 * correlated + shocks[k];
      measured[k] = 3 + 2 * columns(k, 1) + correlated;
    }
    const std::vector<Channel> channels = make_channel(columns, measured, 0.05);
    const std::vector<std::optional<double>> gains(1);
    const Estimate found = estimate(channels, compress(channels), base, VectorX::Zero(2), gains);
    const MatrixX covariance = robust_covariance(channels, base, found, gains, 0.05 * static_cast<double>(lag));
    squares += (found.beta[0] - 3) * (found.beta[0] - 3);
    robust += covariance(0, 0);
    white += found.residual_rms[0] * found.residual_rms[0] / static_cast<double>(n);
    if (trial > 0) continue;
    const VectorX residual = measured - columns * found.beta;
    MatrixX sum = MatrixX::Zero(2, 2);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = std::max<Eigen::Index>(0, i - lag); j < std::min(n, i + lag + 1); ++j)
        sum += std::max(0.0, 1 - std::abs(static_cast<double>(i - j)) / static_cast<double>(lag)) * residual[i] *
               residual[j] * columns.row(i).transpose() * columns.row(j);
    const MatrixX inverse = (columns.transpose() * columns).inverse();
    const MatrixX expected = inverse * sum * inverse * (static_cast<double>(n) / static_cast<double>(n - 2));
    CHECK((covariance - expected).norm() < 1e-9 * expected.norm());
  }
  // the long-run variance of such residuals is 9 times that of white ones; a window of 20 rows finds most of it
  CHECK(std::sqrt(robust / squares) > 0.7);
  CHECK(std::sqrt(robust / squares) < 1.2);
  CHECK(std::sqrt(white / squares) < 0.45);
}

TEST_CASE("bodies stay possible where measurements ask for impossible ones, and follow possible ones") {
  Mechanism mechanism = read_spec_file(BALANCE_CONFIGS "/spatial-rrr.yaml").mechanism;
  mechanism.attachments.clear();
  const std::vector<UnknownParameter> unknowns = list_unknowns(mechanism, {});
  VectorX wanted(static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t k = 0; k < unknowns.size(); ++k) wanted[static_cast<Eigen::Index>(k)] = unknowns[k].spec_value;
  for (const bool is_possible : {true, false}) {
    // deviations of 1e-4 and 0.03: measurements of negative masses that are as exact as others press a body flat
    const MatrixX A = (is_possible ? 1e4 : 30) * MatrixX::Identity(wanted.size(), wanted.size());
    VectorX measured = wanted;
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      if (unknowns[k].kind != UnknownKind::body) measured[static_cast<Eigen::Index>(k)] = 0.5;
      if (unknowns[k].kind == UnknownKind::body && unknowns[k].slot == 0)
        measured[static_cast<Eigen::Index>(k)] *= is_possible ? 1.2 : -1;
      if (is_possible && unknowns[k].kind == UnknownKind::body && unknowns[k].slot > 0 && unknowns[k].slot < 10)
        measured[static_cast<Eigen::Index>(k)] *= 1.2;
    }
    const ConsistentFit fit = fit_consistent_bodies(mechanism, unknowns, A, A * measured, 1);
    CHECK(fit.is_converged);
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      if (unknowns[k].kind == UnknownKind::body && unknowns[k].slot == 0)
        CHECK(consistency_margin(fit.x.segment(static_cast<Eigen::Index>(k), 10)) > 0);
      // measurements with a deviation of 1e-4 outweigh the prior, whose slope is of the order of 1 per unit of P₀
      if (is_possible)
        CHECK(fit.x[static_cast<Eigen::Index>(k)] ==
              doctest::Approx(measured[static_cast<Eigen::Index>(k)]).epsilon(0.02).scale(0.01));
    }
  }
}

}  // namespace
}  // namespace balance::identification
