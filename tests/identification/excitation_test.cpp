/// Laws of motions along which to measure: their series, their limits, and what they show.

#include "balance/synthesis/identification/excitation.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/random.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/synthesis/identification/excitation_model.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace balance::identification {
namespace {

const char* const two_link_arm = R"(
space: planar
gravity: [0, -9.81]
ground: {points: {O: [0, 0]}}
bodies:
  upper: {mass: 2, com: [0.25, 0], inertia: 0.05, points: {S: [0, 0], E: [0.5, 0]}}
  fore: {mass: 1, com: [0.2, 0], inertia: 0.02, points: {E: [0, 0]}}
joints:
  A1: {type: revolute, connects: [ground.O, upper.S]}
  A2: {type: revolute, connects: [upper.E, fore.E]}
friction: {A1: {viscous: 0.3, coulomb: 0.7}}
actuators: [A1, A2]
)";

Mechanism five_bar() { return read_spec_file(std::string(BALANCE_CONFIGS "/5r.yaml")).mechanism; }

using Kind = ExcitationLimit::Kind;

ExcitationOptions limited(const Mechanism& mechanism, double rate, double acceleration) {
  ExcitationOptions options;
  options.max_time = 0;
  options.max_evaluations = 60;
  options.random_series = 9;
  options.starts = 1;
  for (const CoordinateId c : mechanism.actuators) {
    options.limits.push_back({Kind::rate, c, -rate, rate});
    options.limits.push_back({Kind::acceleration, c, -acceleration, acceleration});
  }
  return options;
}

TEST_CASE("a series of any coefficients begins and ends every period at rest, and its rates are its derivatives") {
  for (const int harmonics : {2, 3, 5, 8}) {
    CAPTURE(harmonics);
    const FourierMotion motion(harmonics, 3);
    CHECK(motion.coefficient_count() == 2 * harmonics - 1);
    numerics::UniformRandom random(7);
    const VectorX u = random.sample_normal(motion.coefficient_count());
    for (const double time : {0.0, 3.0, 6.0})
      for (const int order : {1, 2})  // a dozen terms of up to ω² H
        CHECK(std::abs(u.dot(motion.basis(time, order))) < 1e-12 * 5 * harmonics * u.norm());
    const double h = 1e-5;
    for (const double time : {0.4, 1.7, 2.9})
      for (const int order : {0, 1}) {
        const double difference =
            (u.dot(motion.basis(time + h, order)) - u.dot(motion.basis(time - h, order))) / (2 * h);
        // (ω H)³ h²/6 of truncation, 1e-16/h of round-off
        CHECK(difference == doctest::Approx(u.dot(motion.basis(time, order + 1))).epsilon(1e-6).scale(10 * u.norm()));
      }
    // the same from the factors of sines and cosines
    const MatrixX factors = motion.series(u);
    double value = u[0];
    for (int k = 0; k < harmonics; ++k) {
      const double phase = 2 * std::acos(-1.0) * (k + 1) * 0.4 / 3;
      value += factors(k, 0) * std::sin(phase) + factors(k, 1) * std::cos(phase);
    }
    CHECK(value == doctest::Approx(u.dot(motion.basis(0.4, 0))).epsilon(1e-12).scale(1));
  }
}

TEST_CASE(
    "the columns of a motion times the numbers of the spec are its efforts, and their slopes those of differences") {
  for (const bool has_loops : {false, true}) {
    CAPTURE(has_loops);
    const Mechanism mechanism = has_loops ? five_bar() : read_spec(two_link_arm, "arm.yaml").mechanism;
    ExcitationOptions options = limited(mechanism, 3, 30);
    for (int a = 0; a < 2; ++a) options.limits.push_back({Kind::effort, a, -1e4, 1e4});
    ExcitationModel model(mechanism, options);
    CHECK(model.has_loops() == has_loops);
    MatrixX coefficients = MatrixX::Zero(2, model.motion().coefficient_count());
    coefficients.col(0) = model.start();
    coefficients.rightCols(coefficients.cols() - 1).setConstant(0.02);
    const VectorX times = period_times(options.period, 12);
    const auto motion = model.sample(coefficients, times, options.rest_rate);
    REQUIRE(motion);
    InverseDynamics inverse(mechanism);
    VectorX efforts;
    for (Eigen::Index s = 1; s < times.size(); ++s) {
      REQUIRE(inverse
                  .efforts(motion->q.row(s).transpose(), motion->dq.row(s).transpose(), motion->ddq.row(s).transpose(),
                           efforts)
                  .status == MotionStatus::done);
      if (std::abs(motion->dq(s, 0)) < options.rest_rate) continue;  // where dry friction is a ramp
      // sums of the same terms in another order
      CHECK((efforts - motion->measured.row(s).transpose()).norm() < 1e-9 * (1 + efforts.norm()));
    }
    const auto U = static_cast<Eigen::Index>(model.unknowns().size());
    numerics::UniformRandom random(3);
    MatrixX factors(2, U);
    for (Eigen::Index k = 0; k < U; ++k) factors.col(k) = random.sample_normal(2);
    const Eigen::Index s = 5;
    const auto slopes = model.differentiate(*motion, s, times, 1, factors);
    const auto base = model.sample(coefficients, times, 1);
    REQUIRE((slopes && base));
    const auto smooth = model.differentiate(*base, s, times, 1, factors);
    REQUIRE(smooth);
    // along the coefficients, through q, rates and accelerations: central differences of the whole motion
    const double h = 1e-5;
    for (const Eigen::Index j : {Eigen::Index{0}, Eigen::Index{3}})
      for (const Eigen::Index i : {Eigen::Index{0}, Eigen::Index{1}}) {
        MatrixX up = coefficients, down = coefficients;
        up(i, j) += h, down(i, j) -= h;
        const auto above = model.sample(up, times, 1), below = model.sample(down, times, 1);
        REQUIRE((above && below));
        const auto k = static_cast<std::size_t>(s);
        const double difference = ((above->columns[k] - below->columns[k]).cwiseProduct(factors)).sum() / (2 * h);
        double slope = 0;
        for (int order = 0; order < 3; ++order)
          slope += smooth->information[order * 2 + i] * model.motion().basis(times[s], order)[j];
        // steps of 1e-6 forward and of 1e-5 to both sides
        CHECK(slope == doctest::Approx(difference).epsilon(1e-4).scale(factors.norm()));
      }
  }
}

TEST_CASE(
    "the motion that is found keeps its limits between all samples and shows more than random series within them") {
  for (const bool has_loops : {false, true}) {
    CAPTURE(has_loops);
    const Mechanism mechanism = has_loops ? five_bar() : read_spec(two_link_arm, "arm.yaml").mechanism;
    const ExcitationOptions options = limited(mechanism, 2, 8);
    const Excitation found = find_excitation(mechanism, options);
    CHECK(found.found_rank == found.structural_rank);
    CHECK(found.found.log_det > found.start.log_det);
    CHECK(found.start.log_det >= found.median_random.log_det);
    for (const ExcitationLimitUse& use : found.limits) {
      // three times as dense as those that the search looked at: a sine of the highest harmonic rises by 5e-4 between them
      const double half = (use.limit.upper - use.limit.lower) / 2;
      const int order = use.limit.kind == Kind::position ? 0 : use.limit.kind == Kind::rate ? 1 : 2;
      const auto at = std::find(found.coordinates.begin(), found.coordinates.end(), use.limit.index);
      REQUIRE(at != found.coordinates.end());
      for (int k = 0; k <= 1500; ++k) {
        const double value = found.evaluate(found.duration() * k / 1500, order)[at - found.coordinates.begin()];
        REQUIRE(value <= use.limit.upper + 1e-3 * half);
        REQUIRE(value >= use.limit.lower - 1e-3 * half);
      }
    }
    CHECK(std::any_of(found.limits.begin(), found.limits.end(), [](const auto& use) { return use.is_active; }));
    if (has_loops) CHECK(found.min_mobility >= options.min_mobility);
    const Excitation again = find_excitation(mechanism, options);
    CHECK(again.coefficients == found.coefficients);  // a budget of evaluations gives the same motion
  }
}

TEST_CASE("twice as many periods have twice the information, and twice the noise a quarter") {
  const Mechanism mechanism = read_spec(two_link_arm, "arm.yaml").mechanism;
  ExcitationOptions options = limited(mechanism, 2, 8);
  options.noise_deviations = {0.1, 0.1};
  const Excitation once = find_excitation(mechanism, options);
  options.periods = 2;
  const Excitation twice = find_excitation(mechanism, options);
  options.periods = 1;
  options.noise_deviations = {0.2, 0.2};
  const Excitation noisy = find_excitation(mechanism, options);
  const double rank = once.structural_rank;
  // the search is the same but for round-off of a constant factor, which moves where it stops
  CHECK(twice.start.log_det - once.start.log_det == doctest::Approx(rank * std::log(2)).epsilon(1e-9));
  CHECK(noisy.start.log_det - once.start.log_det == doctest::Approx(-rank * std::log(4)).epsilon(1e-9));
  for (std::size_t k = 0; k < once.base.size(); ++k)
    CHECK(noisy.base[k].random_deviation == doctest::Approx(2 * once.base[k].random_deviation).epsilon(1e-6));
}

TEST_CASE("what cannot be is refused with its reason") {
  const Mechanism mechanism = read_spec(two_link_arm, "arm.yaml").mechanism;
  ExcitationOptions options;
  CHECK_THROWS_AS(find_excitation(mechanism, options), UnlimitedSpeedError);
  options = limited(mechanism, 2, 8);
  options.limits.push_back({Kind::effort, 0, -0.01, 0.01});  // less than the weight
  CHECK_THROWS_AS(find_excitation(mechanism, options), ExcitationError);
  Mechanism partly = mechanism;
  partly.actuators.pop_back();
  CHECK_THROWS_AS(find_excitation(partly, limited(mechanism, 2, 8)), ExcitationError);
}

}  // namespace
}  // namespace balance::identification
