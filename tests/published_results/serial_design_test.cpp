// Designs of the serial arms of P1 and P0: the numbers found are those of the papers' equations, and the designed arms are
// judged by random motions.

#include "designs.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace published;

namespace {

/// Torques along random motions are constants times accelerations: no weight, no velocity terms, no coupling.
void check_decoupled(const DesignReport& report, const VectorX& k, std::mt19937& random) {
  const Mechanism& m = report.study_after.mechanism;
  for (int motion = 0; motion < 3; ++motion) {
    const Trajectory t = wander(m, VectorX::Zero(k.size()), 2.5, random);
    const RunResult after = run(m, t), before = run(report.study_before.mechanism, t);
    const balance::Samples want = after.joint_acceleration.leftCols(k.size()) * k.asDiagonal();
    const double scale = std::max(largest(before.torque), largest(after.torque));
    CHECK(largest(after.torque - want) < 1e-10 * scale);
    CHECK(largest(before.torque - want) > 1e-3 * scale);  // there was something to balance
  }
}

constexpr const char* planar_arm = R"(
name: planar RRR arm
space: planar
gravity: [gx, -9.81]
parameters: {gx: 0, l1: 1, l2: 1, m1: 1, m2: 1, m3: 1, J1: 1, J2: 1, J3: 1, J4: 1, J5: 1, J6: 1, J7: 1}
ground:
  points: {O: [0, 0]}
bodies:
  link1: {mass: m1, com: [{free: [-40, 40], start: 0.3}, 0], inertia: J1, points: {A: [0, 0], B: [l1, 0]}}
  link2: {mass: m2, com: [{free: [-40, 40], start: 0.3}, 0], inertia: J2, points: {B: [0, 0], C: [l2, 0]}}
  link3: {mass: m3, com: [{free: [-40, 40], start: 0.3}, 0], inertia: J3, points: {C: [0, 0], E: [1, 0]}}
discs:
  d4: {on: link1, at: A, follows: J2, inertia: J4}
  d5: {on: link1, at: A, follows: J2, ratio: {free: [-2000, -0.001], start: -2}, inertia: J5}
  d6: {on: link2, at: B, follows: J3, inertia: J6}
  d7: {on: link2, at: B, follows: J3, ratio: {free: [-2000, -0.001], start: -2}, inertia: J7}
joints:
  J1: {type: revolute, connects: [ground.O, link1.A]}
  J2: {type: revolute, connects: [link1.B, link2.B]}
  J3: {type: revolute, connects: [link2.C, link3.C]}
actuators: [J1, J2, J3]
tool: link3.E
design: {goal: decoupled}
)";

constexpr const char* spatial_arm = R"(
name: spatial RRR arm
space: spatial
gravity: [0, 0, -9.81]
parameters: {l1: 1, l2: 1, m1: 1, m2: 1, m3: 1, Jz1: 1, Jx2: 1, Jz2: 1, Jx3: 1, Jz3: 1, Jx4: 1, Jx5: 1, Jz4: 1, Jz5: 1,
             need: 1}
ground:
  points: {O: [0, 0, 0]}
bodies:
  link1: {mass: m1, com: [0, 0, 0.2], inertia: [Jz1, Jz1, Jz1], points: {A: [0, 0, 0], B: [0, l1, 0]}}
  link2: {mass: m2, com: [0, {free: [-40, 40], start: 0.2}, 0],
          inertia: [Jx2, {free: ["need - 0.9 * Jz2", "need + 0.9 * Jz2"], start: "need - 0.3 * Jz2"}, Jz2],
          points: {B: [0, 0, 0], C: [0, l2, 0]}}
  link3: {mass: m3, com: [0, {free: [-40, 40], start: 0.2}, 0],
          inertia: [Jx3, {free: ["Jz3 * 0.9", "Jz3 * 1.2"], start: "Jz3 * 1.1"}, Jz3], points: {C: [0, 0, 0]}}
discs:
  d4: {on: link2, at: B, follows: J3, inertia: {axial: Jx4, transverse: Jz4}}
  d5: {on: link2, at: B, follows: J3, ratio: {free: [-2000, -0.001], start: -2}, inertia: {axial: Jx5, transverse: Jz5}}
joints:
  J1: {type: revolute, connects: [ground.O, link1.A], axis: [0, 0, 1]}
  J2: {type: revolute, connects: [link1.B, link2.B], axis: [1, 0, 0]}
  J3: {type: revolute, connects: [link2.C, link3.C], axis: [1, 0, 0]}
actuators: [J1, J2, J3]
design: {goal: decoupled}
)";

constexpr const char* scara_arm = R"(
name: SCARA arm
space: spatial
gravity: [3, -9.81, 0]
parameters: {l1: 1, l2: 1, m1: 1, m2: 1, m3: 1, J1: 1, J2: 1, J3: 1, J4: 1, J5: 1}
ground:
  points: {O: [0, 0, 0]}
bodies:
  link1: {mass: m1, com: [{free: [-40, 40], start: 0.2}, 0, 0], inertia: [J1, J1, J1],
          points: {A: [0, 0, 0], B: [l1, 0, 0]}}
  link2: {mass: m2, com: [{free: [-40, 40], start: 0.2}, 0, 0], inertia: [J2, J2, J2],
          points: {B: [0, 0, 0], C: [l2, 0, 0]}}
  slide: {mass: m3, com: [0, 0, 0.1], inertia: [J3, J3, J3], points: {C: [0, 0, 0]}}
discs:
  d4: {on: link1, at: A, follows: J2, inertia: {axial: J4, transverse: J4}}
  d5: {on: link1, at: A, follows: J2, ratio: {free: [-2000, -0.001], start: -2}, inertia: {axial: J5, transverse: J5}}
joints:
  J1: {type: revolute, connects: [ground.O, link1.A], axis: [0, 0, 1]}
  J2: {type: revolute, connects: [link1.B, link2.B], axis: [0, 0, 1]}
  J3: {type: prismatic, connects: [link2.C, slide.C], axis: [0, 0, 1]}
actuators: [J1, J2, J3]
design: {goal: decoupled}
)";

bool near(double found, double wanted) { return std::abs(found - wanted) < 1e-10 * std::max(1.0, std::abs(wanted)); }

}  // namespace

TEST_CASE("P1 section 3.1: designing a planar RRR arm gives eq. 20 and 26, and torques as eq. 27 and 28") {
  std::mt19937 random(126);
  for (int trial = 0; trial < 4; ++trial) {
    const auto any = [&] { return draw(random, 0.2, 2); };
    const double l1 = any(), l2 = any(), m1 = any(), m2 = any(), m3 = any();
    const double J1 = any(), J2 = any(), J3 = any(), J4 = any(), J5 = any(), J6 = any(), J7 = any();
    const DesignReport r = balanced(space_of_text(planar_arm, {{"gx", any()},
                                                               {"l1", l1},
                                                               {"l2", l2},
                                                               {"m1", m1},
                                                               {"m2", m2},
                                                               {"m3", m3},
                                                               {"J1", J1},
                                                               {"J2", J2},
                                                               {"J3", J3},
                                                               {"J4", J4},
                                                               {"J5", J5},
                                                               {"J6", J6},
                                                               {"J7", J7}}));
    const double all = J2 + J3 + J4 + J6 + J7 + m3 * l2 * l2 + m3 * m3 * l2 * l2 / m2;
    CHECK(near(found(r, "bodies.link1.com[0]"), -l1 * (m2 + m3) / m1));
    CHECK(near(found(r, "bodies.link2.com[0]"), -l2 * m3 / m2));
    CHECK(near(found(r, "bodies.link3.com[0]"), 0));
    CHECK(near(found(r, "discs.d5.ratio"), -all / J5));
    CHECK(near(found(r, "discs.d7.ratio"), -(J3 + J6) / J7));
    VectorX k(3);
    k << J1 + J2 + J3 + J4 + J5 + J6 + J7 + m2 * l1 * l1 + m3 * (l1 * l1 + l2 * l2) +
             l1 * l1 * (m2 + m3) * (m2 + m3) / m1 + l2 * l2 * m3 * m3 / m2,
        all + all * all / J5, (J3 + J6) * (J3 + J6 + J7) / J7;
    check_decoupled(r, k, random);
  }
}

TEST_CASE("P1 section 3.2: designing a spatial RRR arm gives eq. 30 and eq. 37 as corrected, not as printed") {
  std::mt19937 random(137);
  for (int trial = 0; trial < 4; ++trial) {
    const auto any = [&] { return draw(random, 0.2, 2); };
    const double l1 = any(), l2 = any(), m1 = any(), m2 = any(), m3 = any();
    const double Jz1 = any(), Jz2 = any(), Jz3 = any(), Jx4 = any(), Jx5 = any(), Jz4 = any(), Jz5 = any();
    const double bar = m3 * l2 * l2 * (1 + m3 / m2), need = Jz2 + bar;  // eq. 37 as printed: Jz2 alone
    const double Jx2 = need, Jx3 = Jz3;  // wide enough for a body that has these inertias
    const DesignReport r = balanced(space_of_text(spatial_arm, {{"l1", l1},
                                                                {"l2", l2},
                                                                {"m1", m1},
                                                                {"m2", m2},
                                                                {"m3", m3},
                                                                {"Jz1", Jz1},
                                                                {"Jx2", Jx2},
                                                                {"Jz2", Jz2},
                                                                {"Jx3", Jx3},
                                                                {"Jz3", Jz3},
                                                                {"Jx4", Jx4},
                                                                {"Jx5", Jx5},
                                                                {"Jz4", Jz4},
                                                                {"Jz5", Jz5},
                                                                {"need", need}}));
    CHECK(near(found(r, "bodies.link2.com[1]"), -l2 * m3 / m2));
    CHECK(near(found(r, "bodies.link3.com[1]"), 0));
    CHECK(near(found(r, "bodies.link2.inertia[1]"), need));
    CHECK(near(found(r, "bodies.link3.inertia[1]"), Jz3));
    CHECK(near(found(r, "discs.d5.ratio"), -(Jx3 + Jx4) / Jx5));
    VectorX k(3);
    k << Jz1 + Jz2 + Jz3 + Jz4 + Jz5 + (m2 + m3) * l1 * l1 + bar, Jx2 + Jx3 + Jx4 + Jx5 + bar,
        (Jx3 + Jx4) * (Jx3 + Jx4 + Jx5) / Jx5;
    check_decoupled(r, k, random);
  }
}

TEST_CASE("P1 section 3.3: designing a SCARA arm gives eq. 41 and 47 with the slider's distance from joint 2") {
  std::mt19937 random(147);
  for (int trial = 0; trial < 4; ++trial) {
    const auto any = [&] { return draw(random, 0.2, 2); };
    // in the first trial the slider is on the axis of joint 2: eq. 41 and 47 as printed
    const double l1 = any(), l2 = trial == 0 ? 0 : any(), m1 = any(), m2 = any(), m3 = any();
    const double J1 = any(), J2 = any(), J3 = any(), J4 = any(), J5 = any(), X = m3 * l2 * l2 * (1 + m3 / m2);
    const DesignReport r = balanced(space_of_text(scara_arm, {{"l1", l1},
                                                              {"l2", l2},
                                                              {"m1", m1},
                                                              {"m2", m2},
                                                              {"m3", m3},
                                                              {"J1", J1},
                                                              {"J2", J2},
                                                              {"J3", J3},
                                                              {"J4", J4},
                                                              {"J5", J5}}));
    CHECK(near(found(r, "bodies.link1.com[0]"), -l1 * (m2 + m3) / m1));
    CHECK(near(found(r, "bodies.link2.com[0]"), -l2 * m3 / m2));
    CHECK(near(found(r, "discs.d5.ratio"), -(J2 + J3 + J4 + X) / J5));
    VectorX k(3);
    k << J1 + J2 + J3 + J4 + J5 + X + (m2 + m3) * l1 * l1 + l1 * l1 * (m2 + m3) * (m2 + m3) / m1,
        (J2 + J3 + J4 + X) * (J2 + J3 + J4 + J5 + X) / J5, m3;
    check_decoupled(r, k, random);
  }
}

TEST_CASE("the arms of P1 in configs/ have the solutions that their headers state") {
  std::mt19937 random(1);
  const struct {
    const char* file;
    std::vector<double> x;
  } arms[] = {{"planar-rrr-design.yaml", {-1.9 / 3, -0.2, 0, -14.2, -5.5}},
              {"spatial-rrr-design.yaml", {-0.2, 0.26, 0, 0.008, -2.8}},
              {"scara-design.yaml", {-0.304, -0.08, -0.1342 / 0.03}}};
  for (const auto& [file, x] : arms) {
    const DesignReport r = balanced(space_of(file));
    REQUIRE(r.outcome.x.size() == static_cast<long>(x.size()));
    for (std::size_t k = 0; k < x.size(); ++k)
      CHECK_MESSAGE(near(r.outcome.x[static_cast<long>(k)], x[k]), file << ": " << r.free_numbers[k].key_path);
    const Mechanism& m = r.study_after.mechanism;
    const RunResult run_after = run(m, wander(m, VectorX::Zero(3), 2, random));
    for (long j = 0; j < 3; ++j) {  // constants by least squares; what is left over must be round-off
      const VectorX u = run_after.torque.col(j), a = run_after.joint_acceleration.col(j);
      CHECK(largest(u - u.dot(a) / a.squaredNorm() * a) < 1e-10 * largest(run_after.torque));
    }
  }
}

TEST_CASE(
    "P0 section 3.2: the counterweights of rr.yaml are those of eq. 95, and the arm feels neither weight nor speed") {
  const DesignReport r = balanced(space_of("rr.yaml"));
  const double cw2 = (1.5 * 0.5 + 0.5) / 0.5, cw1 = (2 * 0.5 + 1.5 + 0.5 + cw2) / 0.4;  // eq. 95
  CHECK(near(found(r, "counterweights.cw2.mass"), cw2));
  CHECK(near(found(r, "counterweights.cw1.mass"), cw1));
  std::mt19937 random(2);
  const Mechanism& m = r.study_after.mechanism;
  for (int motion = 0; motion < 3; ++motion) {
    const Trajectory t = wander(m, VectorX::Zero(2), 3, random);
    const RunResult after = run(m, t);
    const balance::Samples a = after.joint_acceleration.leftCols(2);
    const balance::MatrixX inertia = a.colPivHouseholderQr().solve(after.torque);  // torque = acceleration · inertia
    CHECK(largest(after.torque - a * inertia) < 1e-10 * largest(after.torque));
    CHECK(std::abs(inertia(0, 1) - inertia(1, 0)) < 1e-10 * inertia(0, 0));
    CHECK(largest(after.shaking_force) < 1e-10 * largest(run(r.study_before.mechanism, t).shaking_force));
  }
}

TEST_CASE("counterweights with free places weigh least as far out as they may be") {
  const DesignReport r = balanced(space_of("rr-design.yaml"));
  // NLopt's optimum in a corner of the bounds: exact in the conditions, to its own tolerance in the place
  CHECK(found(r, "counterweights.cw1.at[0]") == doctest::Approx(-0.3).epsilon(1e-6));
  CHECK(found(r, "counterweights.cw2.at[0]") == doctest::Approx(-0.3).epsilon(1e-6));
  CHECK(r.outcome.objective == doctest::Approx((0.5 + 0.5 * (2 + 5 / 3.0)) / 0.3 + 5 / 3.0).epsilon(1e-6));
}
