#include "arms.hpp"

#include "balance/mechanics/dynamics/forward_dynamics.hpp"

#include <algorithm>

using namespace arms;

namespace {

/// Sampled switching overshoots zero by at most what one period does; the torque that is held while the state moves adds a part
/// of the same size.
double band(const Controller& c) { return 2 * c.switching_gain.maxCoeff() * c.period; }

/// s falls at the rate k until |s₀|/k and stays in the band; then e decays with 1/λ. Column: of the actuated coordinate.
void check_sliding(const RunResult& r, const Controller& c, Eigen::Index column, Eigen::Index coordinate, double k,
                   double lambda) {
  const double s0 = r.sliding_variable(0, column), reached = std::abs(s0) / k;
  REQUIRE(reached > 20 * c.period);
  REQUIRE(reached < 0.6 * r.time[r.time.size() - 1]);
  long first = -1;
  for (long i = 0; i < r.time.size(); ++i) {
    const double s = r.sliding_variable(i, column), t = r.time[i];
    if (t < reached)
      CHECK(std::abs(std::abs(s) - (std::abs(s0) - k * t)) < band(c));
    else
      CHECK(std::abs(s) < band(c));
    if (first < 0 && t > reached) first = i;
  }
  for (long i = first; i < r.time.size(); ++i) {
    const double decayed = r.tracking_error(first, coordinate) * std::exp(-lambda * (r.time[i] - r.time[first]));
    CHECK(std::abs(r.tracking_error(i, coordinate) - decayed) < band(c) / lambda);
  }
}

}  // namespace

TEST_CASE("P0 eq. 44, 49: a one-joint arm reaches its sliding surface at |s0|/k, then its error decays with 1/lambda") {
  Controller c = controller(study::ControllerType::sliding_mode, 10'000);
  c.lambda = all(1, 10);
  c.switching_gain = all(1, 5);
  const Study study = arm();
  for (const double offset : {0.1, -0.15}) {
    c.initial_error.joints = {{0, offset}};
    const RunResult r = run(study, "cycloid", c);
    CHECK(r.sliding_variable(0, 0) == doctest::Approx(10 * offset).epsilon(1e-9));
    check_sliding(r, c, 0, 0, 5, 10);
  }
}

TEST_CASE(
    "P0 eq. 44, 49 on the 5R: each actuated coordinate reaches its surface at its own |s0|/k and decays with its own "
    "1/lambda") {
  Controller c = controller(study::ControllerType::sliding_mode, 10'000);
  c.lambda = (VectorX(2) << 25, 40).finished();
  c.switching_gain = (VectorX(2) << 15, 20).finished();
  const Study study = five_bar();
  const auto& motors = study.mechanism.actuators;
  c.initial_error.joints = {{motors[0], 0.05}, {motors[1], -0.04}};
  const RunResult r = run(study, "cycloid", c, 126);
  for (int a = 0; a < 2; ++a) {
    Controller own = c;
    own.switching_gain = all(1, c.switching_gain[a]);
    check_sliding(r, own, a, motors[static_cast<std::size_t>(a)], c.switching_gain[a], c.lambda[a]);
  }
}

TEST_CASE("with the sign the torque jumps by 2 I k at every sample; a boundary layer leaves nothing of that") {
  // At rest and without weight: on the surface u = −I k sign s + small, alternately.
  const Study study = arm("", "0");
  Controller c = controller(study::ControllerType::sliding_mode, 1000);
  c.lambda = all(1, 10);
  c.switching_gain = all(1, 4);
  c.initial_error.joints = {{0, 1e-4}};
  const RunResult sign = run(study, "rest", c);
  const double samples = 1000;
  CHECK(metric(sign, "torque_variation[J]").peak == doctest::Approx(2 * inertia * 4 * samples).epsilon(0.02));
  c.boundary_layer = all(1, 0.05);
  const RunResult layer = run(study, "rest", c);
  // Linear inside: u goes from −I (k/φ s₀ + …) to zero without turning back: less than a few of the sign's thousand jumps.
  CHECK(metric(layer, "torque_variation[J]").peak < 2 * inertia * 4);
  CHECK(metric(layer, "tracking_error").peak <= 1e-4 * (1 + 1e-9));
}

TEST_CASE(
    "the extended law reaches the surface of the 5R in its redundant coordinates and stays, with either projection") {
  const Study study = five_bar();
  const auto& motors = study.mechanism.actuators;
  for (const study::AccelerationProjection projection :
       {study::AccelerationProjection::inertia, study::AccelerationProjection::identity}) {
    Controller c = controller(study::ControllerType::extended_sliding_mode, 10'000);
    c.lambda = all(1, 30);
    c.switching_gain = all(1, 30);
    c.projection = projection;
    c.initial_error.joints = {{motors[0], 0.03}, {motors[1], -0.02}};
    const RunResult r = run(study, "cycloid", c, 126);
    REQUIRE(r.sliding_names.size() == 4);
    const double start = r.sliding_variable.row(0).norm();
    CHECK(start > 0.5);
    // docs/control.md, step 3: the identity's norm of s falls at k at least, up to what the loops' curvature leaves.
    const double reached = start / 30 * (projection == study::AccelerationProjection::identity ? 1.1 : 3);
    const long on = row(r, reached);
    REQUIRE(reached < 0.3);
    for (long i = on + 1; i < r.time.size(); ++i) CHECK(r.sliding_variable.row(i).norm() < 0.1 * start);
    const Eigen::Index a1 = motors[0], a2 = motors[1];
    const auto error = [&](long i) { return std::hypot(r.tracking_error(i, a1), r.tracking_error(i, a2)); };
    CHECK(error(0) > 0.03);
    CHECK(error(r.time.size() - 1) < band(c) / 30);  // what the switching leaves of it
  }
}

TEST_CASE("the extended law of a serial arm is the plain one: there is nothing to project on") {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/rr.yaml");
  Controller plain = controller(study::ControllerType::sliding_mode, 2000), extended = plain;
  const long motors = static_cast<long>(study.mechanism.actuators.size());
  plain.lambda = all(motors, 20);
  plain.switching_gain = all(motors, 10);
  extended.type = study::ControllerType::extended_sliding_mode;
  extended.lambda = all(1, 20);
  extended.switching_gain = all(1, 10);
  plain.initial_error.joints = extended.initial_error.joints = {{study.mechanism.actuators[0], 0.02}};
  plain.boundary_layer = all(motors, 0.2);
  extended.boundary_layer = all(1, 0.2);
  for (const study::AccelerationProjection projection :
       {study::AccelerationProjection::inertia, study::AccelerationProjection::identity}) {
    extended.projection = projection;
    const RunResult a = run(study, "cycloid", plain, 51), b = run(study, "cycloid", extended, 51);
    CHECK((a.joint_position - b.joint_position).cwiseAbs().maxCoeff() < 1e-7);
    CHECK((a.torque - b.torque).cwiseAbs().maxCoeff() < 1e-5 * a.torque.cwiseAbs().maxCoeff());
  }
}
