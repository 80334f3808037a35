// Designs and conditions of P0's 5R, P3's 3RRR and of force and moment balancing's classics, judged by random motions.

#include "balance/synthesis/conditions/modular_conditions.hpp"
#include "designs.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <string>

using namespace published;

namespace {

int count(const Mechanism& m, GoalKind kind) {
  const balance::Conditions c = balance::derive_conditions(m, {{kind}});
  REQUIRE_MESSAGE(c.status == balance::ConditionsStatus::done, c.reason);
  return c.rank;
}

/// What weight and springs ask of the motors along a random motion, as a part of what they ask before the design.
double weight_left(const DesignReport& r, const char* about, double reach, std::mt19937& random) {
  const Trajectory t = wander(r.study_before, about, reach, random);
  const auto holding = [&](const Mechanism& m) {
    Mechanism free = m;
    free.gravity.setZero();
    free.springs.clear();
    return largest(run(m, t).torque - run(free, t).torque);
  };
  return holding(r.study_after.mechanism) / holding(r.study_before.mechanism);
}

/// Shaking force along a random motion, as a part of what single bodies' forces amount to before the design.
double force_left(const DesignReport& r, const char* about, double reach, std::mt19937& random) {
  const Trajectory t = wander(r.study_before, about, reach, random);
  return largest(run(r.study_after.mechanism, t).shaking_force) /
         largest(run(r.study_before.mechanism, t).shaking_force);
}

}  // namespace

TEST_CASE(
    "P0: a 5R has 6 static, 8 gyroscopic, 9 gyroscopic conditions in the motors' accelerations, 11 dynamic ones") {
  const Mechanism m = load("5r-impossible.yaml").mechanism;
  CHECK(count(m, GoalKind::statics) == 6);
  CHECK(count(m, GoalKind::gyroscopic) == 8);
  CHECK(count(m, GoalKind::gyroscopic_independent) == 9);
  CHECK(count(m, GoalKind::dynamic) == 11);
  CHECK(balance::conditions::derive_modular_conditions(m, {{GoalKind::statics}}).rank == 8);
}

TEST_CASE("P0: a 5R balanced leg by leg has no velocity terms if each leg carries its share of the payload itself") {
  Mechanism m = load("5r-balanced.yaml").mechanism;
  const auto largest_residual = [](const Mechanism& of) {
    const balance::Conditions c = balance::derive_conditions(of, {{GoalKind::gyroscopic}});
    REQUIRE_MESSAGE(c.status == balance::ConditionsStatus::done, c.reason);
    return balance::conditions::scaled_residuals(c, balance::dynamics::parameter_values(of)).cwiseAbs().maxCoeff();
  };
  // all of it on coupler1, in the accelerations of A1 and B1
  CHECK(largest_residual(m) > 1e-2);
  const auto on = [&](const std::string& name) {
    for (std::size_t b = 0; b < m.bodies.size(); ++b)
      if (m.bodies[b].name == name) return b;
    FAIL("no body " << name);
    return m.bodies.size();
  };
  for (balance::Attachment& cargo : m.attachments)
    if (cargo.kind == balance::AttachmentKind::payload) cargo.mass /= 2;
  const std::size_t other = on("coupler2");
  const Vector3 tip = m.bodies[other].points.back().position;
  m.attachments.push_back(
      {"half", balance::AttachmentKind::payload, static_cast<int>(other), tip, 0.3, Matrix3::Zero()});
  CHECK(tip.x() == doctest::Approx(0.42));
  CHECK(largest_residual(m) < 1e-12);
}

TEST_CASE("P0 section 2.2: the 5R without discs cannot do without velocity terms in the motors' own accelerations") {
  const DesignReport r = designed(space_of("5r-impossible.yaml"));
  CHECK(r.outcome.status == DesignStatus::infeasible);
  REQUIRE(r.outcome.certificate);
  // (0.6 / 0.65)² = 0.852071…
  CHECK_MESSAGE(r.outcome.certificate->statement.starts_with("coupler1.J + 0.852"), r.outcome.certificate->statement);
  CHECK_MESSAGE(r.outcome.certificate->statement.ends_with(" coupler2.J = 0 cannot hold: both are positive"),
                r.outcome.certificate->statement);
}

TEST_CASE("P0 eq. 95 for each leg: the modular strategy finds the counterweights of 5r-balanced.yaml") {
  balance::DesignStudyOptions options;
  options.is_modular = true;
  const DesignReport r = balanced(space_of("5r.yaml"), options);
  const Mechanism wanted = load("5r-balanced.yaml").mechanism;
  for (const balance::Attachment& cw : wanted.attachments)
    if (cw.kind == balance::AttachmentKind::counterweight)
      CHECK(found(r, "counterweights." + cw.name + ".mass") == doctest::Approx(cw.mass).epsilon(1e-10));
  std::mt19937 random(95);
  CHECK(weight_left(r, "cycloid", 0.15, random) < 1e-10);
}

TEST_CASE("the complete conditions of the 5R need less added mass than those leg by leg") {
  balance::DesignStudyOptions legs;
  legs.is_modular = true;
  const DesignReport whole = balanced(space_of("5r-design.yaml")), parts = balanced(space_of("5r-design.yaml"), legs);
  CHECK(whole.outcome.objective == doctest::Approx(14.542).epsilon(1e-9));
  CHECK(parts.outcome.objective == doctest::Approx(20.96575).epsilon(1e-9));
  CHECK(found(whole, "counterweights.cw12.mass") == doctest::Approx(0));
  CHECK(found(whole, "counterweights.cw11.mass") == doctest::Approx(2.625).epsilon(1e-9));
  std::mt19937 random(6);
  CHECK(weight_left(whole, "cycloid", 0.15, random) < 1e-10);
  CHECK(weight_left(parts, "cycloid", 0.15, random) < 1e-10);
}

TEST_CASE("P3 eq. 61: the cranks of the 3RRR get their CoM to -0.09 m, and the CoM follows the tool at half its way") {
  const DesignReport r = balanced(space_of("3rrr-proportional.yaml"));
  CHECK(found(r, "parameters.xg") == doctest::Approx(-0.09).epsilon(1e-10));
  std::mt19937 random(61);
  for (int motion = 0; motion < 3; ++motion) {
    const Trajectory t = wander(r.study_before, "cycloid", 0.1, random);
    const auto gap = [&](const Mechanism& m) {
      const RunResult run_of = run(m, t);
      double worst = 0;
      for (long k = 1; k < run_of.time.size(); ++k)
        worst = std::max(worst, ((run_of.com_position.row(k) - run_of.com_position.row(0)) -
                                 0.5 * (run_of.tool_position.row(k) - run_of.tool_position.row(0)))
                                    .norm());
      return worst;
    };
    CHECK(gap(r.study_after.mechanism) < 1e-12);
    CHECK(gap(r.study_before.mechanism) > 1e-3);
  }
}

TEST_CASE("slider-crank: the rod's CoM goes to -0.15 m and the crank's to -0.075 m, and nothing shakes") {
  const DesignReport r = balanced(space_of("slider-crank-force-balance.yaml"));
  CHECK(found(r, "bodies.rod.com[0]") == doctest::Approx(-0.15).epsilon(1e-12));
  CHECK(found(r, "bodies.crank.com[0]") == doctest::Approx(-0.075).epsilon(1e-12));
  std::mt19937 random(3);
  CHECK(force_left(r, "cycloid", 3, random) < 1e-10);
}

TEST_CASE("Berkof and Lowen 1969: counterweights on input and output link force balance any four-bar") {
  std::mt19937 random(1969);
  const DesignReport r = balanced(space_of("four-bar-force-balance.yaml"));
  // First moments as complex numbers in the links' axes, real along the line of pins: the coupler's mass acts in B with the
  // factor 1 − c/b and in C with c/b.
  const std::complex<double> share = std::complex<double>(0.175, 0.02) / 0.35;
  const std::complex<double> crank = -1.4 * (1.0 - share) * 0.1 - 0.4 * 0.05, rocker = -1.4 * share * 0.25 - 1 * 0.125;
  const auto whole = [](double angle) { return angle < 0 ? angle + 2 * std::numbers::pi : angle; };
  CHECK(found(r, "counterweights.cw1.mass") == doctest::Approx(std::abs(crank) / 0.1).epsilon(1e-10));
  CHECK(found(r, "counterweights.cw2.mass") == doctest::Approx(std::abs(rocker) / 0.1).epsilon(1e-10));
  CHECK(found(r, "parameters.phi1") == doctest::Approx(whole(std::arg(crank))).epsilon(1e-10));
  CHECK(found(r, "parameters.phi2") == doctest::Approx(whole(std::arg(rocker))).epsilon(1e-10));
  CHECK(force_left(r, "cycloid", 3, random) < 1e-10);
}

TEST_CASE("Berkof 1973: an in-line four-bar without any shaking force or moment") {
  const DesignReport r = balanced(space_of("four-bar-dynamic.yaml"));
  CHECK(found(r, "bodies.coupler.inertia") == doctest::Approx(1.4 * 0.175 * 0.175).epsilon(1e-10));
  CHECK(found(r, "counterweights.cw1.mass") == doctest::Approx(1.8).epsilon(1e-10));
  CHECK(found(r, "counterweights.cw2.mass") == doctest::Approx(3).epsilon(1e-10));
  // about the bearings: slender link, half of the coupler at the pin, counterweight
  const double crank = 0.4 * 0.01 / 3 + 0.7 * 0.01 + 1.8 * 0.0025, rocker = 0.0625 / 3 + 0.7 * 0.0625 + 3 * 0.01;
  CHECK(found(r, "discs.d1.ratio") == doctest::Approx(-1 - crank / 0.004).epsilon(1e-10));
  CHECK(found(r, "discs.d2.ratio") == doctest::Approx(-1 - rocker / 0.02).epsilon(1e-10));
  std::mt19937 random(1973);
  const Trajectory t = wander(r.study_before, "cycloid", 3, random);
  const RunResult before = run(r.study_before.mechanism, t), after = run(r.study_after.mechanism, t);
  CHECK(largest(after.shaking_force) < 1e-10 * largest(before.shaking_force));
  CHECK(largest(after.shaking_moment) < 1e-10 * largest(before.shaking_moment));
}

TEST_CASE("counterweights force balance the 5R with three masses and the 3RRR with six") {
  std::mt19937 random(4);
  const DesignReport five = balanced(space_of("5r-force-balance.yaml"));
  const double want[] = {2.625, 8.872, 3.045};
  for (long k = 0; k < 3; ++k) CHECK(five.outcome.x[k] == doctest::Approx(want[k]).epsilon(1e-10));
  CHECK(force_left(five, "cycloid", 0.15, random) < 1e-10);
  const DesignReport three = balanced(space_of("3rrr-force-balance.yaml"));
  for (long k = 0; k < 6; ++k) CHECK(three.outcome.x[k] == doctest::Approx(k < 3 ? 9.36 : 2.7).epsilon(1e-10));
  CHECK(force_left(three, "cycloid", 0.1, random) < 1e-10);
}

TEST_CASE("the balanced Delta robot's motors feel no weight") {
  const DesignReport r = balanced(space_of("delta-gravity.yaml"));
  const double rod = (0.2 * 0.275 + 0.55 / 6) / 0.1, arm = (0.6 * 0.1 + 0.5 * (0.2 + rod + 1 / 6.0)) / 0.12;
  CHECK(found(r, "parameters.cwr") == doctest::Approx(rod).epsilon(1e-9));
  CHECK(found(r, "parameters.cwa") == doctest::Approx(arm).epsilon(1e-9));
  std::mt19937 random(5);
  CHECK(weight_left(r, "cycloid", 0.2, random) < 1e-9);
}

TEST_CASE("springs of zero free length hold links in every position: m g c = k h r") {
  std::mt19937 random(7);
  const DesignReport one = balanced(space_of("spring-balancer-one-link.yaml"));
  CHECK(found(one, "springs.s.stiffness") == doctest::Approx(2 * 9.81 * 0.2 / (0.3 * 0.1)).epsilon(1e-10));
  CHECK(found(one, "bodies.link.points.P[1]") == doctest::Approx(0.015).epsilon(1e-10));
  CHECK(weight_left(one, "cycloid", 3, random) < 1e-10);
  const DesignReport two = balanced(space_of("spring-balancer-two-link.yaml"));
  const double k2 = 1.5 * 9.81 * 0.15 / (0.3 * 0.1);
  const double k1 = ((2 * 0.2 + 1.5 * 0.4) * 9.81 - k2 * 0.3 * 0.4) / (0.3 * 0.1), k3 = k2 * 0.4 * 0.1 / (0.1 * 0.1);
  CHECK(found(two, "springs.s1.stiffness") == doctest::Approx(k1).epsilon(1e-10));
  CHECK(found(two, "springs.s2.stiffness") == doctest::Approx(k2).epsilon(1e-10));
  CHECK(found(two, "springs.s3.stiffness") == doctest::Approx(k3).epsilon(1e-10));
  CHECK(weight_left(two, "cycloid", 3, random) < 1e-10);
}
