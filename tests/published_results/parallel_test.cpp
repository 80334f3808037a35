// Closed loops with numbers known from papers and textbooks.

#include "published.hpp"

#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace published;

namespace {

/// Effort at the first sample of a motion that starts at rest without acceleration: what holds the mechanism.
double holding_torque(const balance::Study& study, double angle) {
  Trajectory t = make_trajectory(study, "cycloid", 2);
  t.from.joints[0].value = angle;
  t.to.joints[0].value = angle + 0.01;
  return run(study.mechanism, t).torque(0, 0);
}

}  // namespace

TEST_CASE("the hanging four-bar rests with its outer links at atan(sqrt 15), where no torque is needed") {
  const balance::Study study = load("static-four-bar.yaml");
  const double rest = std::atan(std::sqrt(15.0)) - std::numbers::pi;
  const double weight = 3 * 4 * 9.81 * 4;  // three links of 4 kg, 4 m long
  CHECK(std::abs(holding_torque(study, rest)) < 1e-12 * weight);
  double low = rest - 0.1, high = rest + 0.1;
  REQUIRE(holding_torque(study, low) * holding_torque(study, high) < 0);
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (holding_torque(study, low) * holding_torque(study, middle) <= 0 ? high : low) = middle;
  }
  CHECK(low == doctest::Approx(rest).epsilon(1e-12));
}

TEST_CASE("spatial slider-crank: at 6 rad/s the slider starts at x = 0.2 m with 0.24 m/s") {
  const balance::Study study = load("spatial-slider-crank.yaml");
  const RunResult r = run(study.mechanism, make_trajectory(study, "steady", 101));
  const long A = coordinate(study.mechanism, "A"), S = coordinate(study.mechanism, "S");
  CHECK(r.joint_velocity(0, A) == doctest::Approx(6).epsilon(1e-13));
  CHECK(r.joint_position(0, S) == doctest::Approx(0.2).epsilon(1e-12));
  CHECK(std::abs(r.joint_velocity(0, S)) == doctest::Approx(0.24).epsilon(1e-12));
  for (long k = 0; k < 101; ++k) {  // the rod is 0.3 m long
    const double angle = r.joint_position(k, A), x = r.joint_position(k, S);
    const double y = 0.1 - 0.08 * std::sin(angle), z = 0.12 + 0.08 * std::cos(angle);
    CHECK(x * x + y * y + z * z == doctest::Approx(0.09).epsilon(1e-11));
  }
}

namespace {

/// Passive joint rates of the 5R per unit crank rates: both legs carry the tip at the same velocity.
Eigen::Matrix2d passive_rates(const Mechanism& m, const RunResult& r, long k) {
  const auto leg = [&](const char* A, const char* B, double a1, double a2) {
    const double p = r.joint_position(k, coordinate(m, A)), q = p + r.joint_position(k, coordinate(m, B));
    const Eigen::Vector2d second(-a2 * std::sin(q), a2 * std::cos(q));
    Eigen::Matrix2d J;
    J << second + Eigen::Vector2d(-a1 * std::sin(p), a1 * std::cos(p)), second;
    return J;
  };
  const Eigen::Matrix2d one = leg("A1", "B1", 0.3, 0.45), two = leg("A2", "B2", 0.32, 0.42);
  Eigen::Matrix2d passive, active;  // passive · (B1, B2) = active · (A1, A2)
  passive << one.col(1), -two.col(1);
  active << -one.col(0), two.col(0);
  return passive.inverse() * active;
}

}  // namespace

TEST_CASE("P0 section 3.3: a 5R balanced leg by leg feels no weight") {
  balance::Study study = load("5r-balanced.yaml");
  for (const char* name : {"cycloid", "bang-bang"}) {
    const Trajectory t = make_trajectory(study, name, 51);
    Mechanism weightless = study.mechanism;
    weightless.gravity.setZero();
    const RunResult with = run(study.mechanism, t), without = run(weightless, t);
    CHECK((with.torque - without.torque).cwiseAbs().maxCoeff() < 1e-11 * with.torque.cwiseAbs().maxCoeff());
    for (long k = 1; k < 51; ++k) CHECK((with.com_position.row(k) - with.com_position.row(0)).norm() < 1e-12);
    CHECK(with.shaking_force.cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("P0 eq. 106 and 107: its torques are the legs' constant inertias coupled, without velocity terms") {
  const balance::Study study = load("5r-balanced.yaml");
  const Mechanism& m = study.mechanism;
  const RunResult r = run(m, make_trajectory(study, "cycloid", 51));
  const auto cw = [&](const std::string& name) {
    for (const balance::Attachment& extra : m.attachments)
      if (extra.name == name) return extra.mass;
    FAIL("no " << name);
    return 0.0;
  };
  const auto inertias = [](double a1, double a2, double m1, double J1, double m2, double J2, double w1, double w2) {
    const double i1 = J2 + a2 * a2 * (m2 / 4 + 0.3) + w2 * 0.15 * 0.15;
    const double i2 = J1 + a1 * a1 * (m1 / 4 + m2 + 0.3 + w2) + w1 * 0.12 * 0.12;
    Eigen::Matrix2d M;
    M << i1 + i2, i1, i1, i1;
    return M;
  };
  const Eigen::Matrix2d M1 = inertias(0.3, 0.45, 1.2, 0.01, 0.9, 0.016, cw("cw11"), cw("cw12"));
  const Eigen::Matrix2d M2 = inertias(0.32, 0.42, 1.3, 0.012, 0.8, 0.013, cw("cw21"), cw("cw22"));
  const double scale = r.torque.cwiseAbs().maxCoeff();
  for (long k = 0; k < 51; ++k) {
    const auto a = [&](const char* name) { return r.joint_acceleration(k, coordinate(m, name)); };
    const Eigen::Vector2d one = M1 * Eigen::Vector2d(a("A1"), a("B1")), two = M2 * Eigen::Vector2d(a("A2"), a("B2"));
    const Eigen::Vector2d want =
        Eigen::Vector2d(one[0], two[0]) + passive_rates(m, r, k).transpose() * Eigen::Vector2d(one[1], two[1]);
    CHECK((r.torque.row(k).transpose() - want).norm() < 1e-10 * scale);
  }
}

TEST_CASE("the four-bar in space moves and costs what the planar one does") {
  for (const char* name : {"cycloid", "bang-bang"}) {
    const RunResult flat = run("four-bar.yaml", name, 101), space = run("four-bar-in-space.yaml", name, 101);
    const double torque = flat.torque.cwiseAbs().maxCoeff(), force = flat.shaking_force.cwiseAbs().maxCoeff();
    CHECK((flat.torque - space.torque).cwiseAbs().maxCoeff() < 1e-9 * torque);
    CHECK((flat.shaking_force - space.shaking_force.leftCols(2)).cwiseAbs().maxCoeff() < 1e-9 * force);
    CHECK((flat.shaking_moment - space.shaking_moment.col(2)).cwiseAbs().maxCoeff() < 1e-9 * force);
    CHECK((flat.joint_velocity.col(0) - space.joint_velocity.col(0)).cwiseAbs().maxCoeff() < 1e-10);
    CHECK(space.shaking_force.col(2).cwiseAbs().maxCoeff() < 1e-9 * force);
  }
}

TEST_CASE("the geared five-bar's tool runs on the line half-way between the bearings") {
  const RunResult r = run("geared-five-bar.yaml", "cycloid", 101);
  CHECK((r.tool_position.col(0).array() - 0.15).abs().maxCoeff() < 1e-12);
}
