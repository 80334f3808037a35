// Proofs of impossibility, each checked without the code that found it: a proof is tried on thousands of bodies.

#include "hand_made.hpp"

#include "balance/synthesis/conditions/infeasibility_certificate.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace hand_made;
using Kind = conditions::InfeasibilityCertificate::Kind;

namespace {

/// The proof is what it says: its coefficients are the combination of the conditions, and the left-hand side is positive for
/// random bodies.
void check_proof(const conditions::InfeasibilityCertificate& proof, const Conditions& conditions, Mechanism mechanism) {
  const VectorX combined = conditions.matrix.transpose() * proof.combination;
  // Round-off of a few terms of size one.
  CHECK((combined - proof.coefficients).cwiseAbs().maxCoeff() < 1e-8 * proof.coefficients.cwiseAbs().maxCoeff());
  RandomNumbers random(7);
  double least = 1e300;
  for (int i = 0; i < 2000; ++i) {
    reshape(mechanism, random);
    const VectorX pi = dynamics::parameter_values(mechanism, dynamics::FreeSprings(mechanism.springs.size(), true));
    least = std::min(least, proof.coefficients.dot(pi));
  }
  CHECK(least > 0);
}

std::optional<conditions::InfeasibilityCertificate> prove(const Mechanism& mechanism, const Conditions& conditions) {
  const auto proof = certify_infeasible(conditions, mechanism);
  if (proof) check_proof(*proof, conditions, mechanism);
  return proof;
}

}  // namespace

TEST_CASE("two positive moments of inertia cannot add up to zero") {
  const Mechanism m = bodies(SpaceKind::planar, 2);
  const auto proof = prove(m, make_conditions(m, {{{"1.J", 2}, {"2.J", 1.704}}}));
  REQUIRE(proof);
  CHECK(proof->kind == Kind::sign);
  CHECK(proof->statement == "1.J + 0.852 2.J = 0 cannot hold: both are positive");
}

TEST_CASE("a body's mass cannot vanish, a counterweight's can") {
  Mechanism m = bodies(SpaceKind::planar, 2);
  m.attachments.push_back({"cw", AttachmentKind::counterweight, 1, Vector3(-0.3, 0, 0), 0.5, Matrix3::Zero()});
  const auto one = prove(m, make_conditions(m, {{{"1.m", -3}}}));
  REQUIRE(one);
  CHECK(one->statement == "1.m = 0 cannot hold: it is positive");
  CHECK_FALSE(prove(m, make_conditions(m, {{{"cw.m", 1}, {"cw.J", 2}}})));
  const auto two = prove(m, make_conditions(m, {{{"1.J", 1}, {"cw.m", 0.25}}}));
  REQUIRE(two);
  CHECK(two->statement == "1.J + 0.25 cw.m = 0 cannot hold: none can be negative and 1.J is positive");
  const auto three = prove(m, make_conditions(m, {{{"1.m", 1}, {"2.m", 1}, {"2.J", 4}}}));
  REQUIRE(three);
  CHECK(three->statement == "1.m + 2.m + 4 2.J = 0 cannot hold: all are positive");
}

TEST_CASE("terms of both signs prove nothing") {
  const Mechanism m = bodies(SpaceKind::planar, 2);
  CHECK_FALSE(prove(m, make_conditions(m, {{{"1.J", 1}, {"2.J", -1}}})));
  CHECK_FALSE(prove(m, make_conditions(m, {{{"1.mx", 1}, {"2.m", 1}}})));
  CHECK_FALSE(prove(m, make_conditions(m, {{{"1.mx", 1}}, {{"2.my", 1}}})));
}

TEST_CASE("first moments that hide a sign are eliminated and the shortest sentence is found") {
  const Mechanism m = bodies(SpaceKind::planar, 3);
  // 2·(first) − 3·(second) = 5 1.J + 2 2.J; the third condition, mixed in, could only make it longer.
  const auto proof = prove(m, make_conditions(m, {{{"1.mx", 3}, {"1.J", 1}, {"2.J", 1}},
                                                  {{"1.mx", 2}, {"1.J", -1}},
                                                  {{"3.m", 1}, {"3.J", 1}, {"1.J", 1}, {"3.my", 1}},
                                                  {{"3.my", 1}}}));
  REQUIRE(proof);
  CHECK(proof->kind == Kind::sign);
  CHECK(proof->statement == "1.J + 0.4 2.J = 0 cannot hold: both are positive");
}

TEST_CASE("the 5R cannot lose its velocity terms in the actuators' accelerations (P0 section 3.3)") {
  const Mechanism m = bodies(SpaceKind::planar, 4);
  // Lengths 0.5, 0.6, 0.45, 0.65: derived by an independent program, printed with four digits.
  const auto proof = prove(m, make_conditions(m, {{{"1.mx", 1}, {"2.m", 0.5}, {"4.J", 1.183}},
                                                  {{"1.my", 1}},
                                                  {{"2.mx", 1}, {"4.J", 1.42}},
                                                  {{"2.my", 1}},
                                                  {{"2.J", 1}, {"4.J", 0.8521}},
                                                  {{"3.mx", 1}, {"4.m", 0.45}, {"4.J", -1.065}},
                                                  {{"3.my", 1}},
                                                  {{"4.mx", 1}, {"4.J", -1.538}},
                                                  {{"4.my", 1}}}));
  REQUIRE(proof);
  CHECK(proof->statement == "2.J + 0.8521 4.J = 0 cannot hold: both are positive");
}

TEST_CASE("the 5R can be balanced statically and gyroscopically (P0 section 3.3)") {
  const Mechanism m = bodies(SpaceKind::planar, 4);
  CHECK_FALSE(prove(m, make_conditions(m, {{{"1.mx", 1}, {"2.m", 0.5}},
                                           {{"1.my", 1}},
                                           {{"2.mx", 1}},
                                           {{"2.my", 1}},
                                           {{"3.mx", 1}, {"4.m", 0.45}},
                                           {{"3.my", 1}},
                                           {{"4.mx", 1}},
                                           {{"4.my", 1}}})));
}

TEST_CASE("the moment of inertia about any other point is positive too") {
  const Mechanism m = bodies(SpaceKind::planar, 1);
  const double l = 0.7, h = -0.4;
  const auto proof =
      prove(m, make_conditions(m, {{{"1.J", 1}, {"1.mx", -2 * l}, {"1.my", -2 * h}, {"1.m", l * l + h * h}}}));
  REQUIRE(proof);
  CHECK(proof->kind == Kind::cone);
  CHECK(proof->statement ==
        "1.m - 2.15385 1.mx + 1.23077 1.my + 1.53846 1.J = 0 cannot hold: the left-hand side is positive for every "
        "distribution of mass");
  // Less than that can vanish: J − 2 l mx + s m with s < l² is negative for a small body at x = l.
  CHECK_FALSE(prove(m, make_conditions(m, {{{"1.J", 1}, {"1.mx", -2 * l}, {"1.m", 0.99 * l * l}}})));
  CHECK_FALSE(prove(m, make_conditions(m, {{{"1.J", 1}, {"1.mx", -2 * l}, {"1.m", (1 - 1e-6) * l * l}}})));
}

TEST_CASE("a certificate on the cone's boundary is found among several conditions") {
  const Mechanism m = bodies(SpaceKind::planar, 2);
  const double l = 0.7, k = 0.3;
  // Their sum with weights (1, 2, −1) is the inertia of 1 about (l, 0) plus that of 2 about (0, k).
  const auto proof =
      prove(m, make_conditions(m, {{{"1.J", 1}, {"2.my", 0.4}, {"1.my", 2}},
                                   {{"1.mx", -l}, {"2.J", 0.5}, {"2.my", -0.5}, {"1.my", -0.5}},
                                   {{"1.m", -l * l}, {"2.m", -k * k}, {"2.my", 2 * k - 0.6}, {"1.my", 1}}}));
  REQUIRE(proof);
  CHECK(proof->kind == Kind::cone);
}

TEST_CASE("no moment of inertia exceeds the sum of the other two, unless the body is flat") {
  const Mechanism m = bodies(SpaceKind::spatial, 2);
  const std::vector<Terms> triangle = {{{"1.Ixx", 1}, {"1.Iyy", 1}, {"1.Izz", -1}}};
  const auto proof = prove(m, make_conditions(m, triangle));
  REQUIRE(proof);
  CHECK(proof->kind == Kind::cone);
  CHECK(proof->statement ==
        "1.Ixx + 1.Iyy - 1.Izz = 0 cannot hold: the left-hand side is positive for every distribution of mass that is "
        "not flat");
  const auto thick = prove(m, make_conditions(m, {{{"1.Ixx", 2}, {"1.Iyy", 1.5}, {"1.Izz", -1}}}));
  REQUIRE(thick);
  CHECK(thick->statement.ends_with("for every distribution of mass"));
  // A flat body meets it.
  Mechanism flat = m;
  flat.bodies[1].com = Vector3(0.1, 0.2, 0);
  flat.bodies[1].inertia.diagonal() = Vector3(0.2, 0.3, 0.5);
  CHECK_FALSE(certify_infeasible(make_conditions(flat, triangle), flat));
  CHECK_FALSE(prove(m, make_conditions(m, {{{"1.Ixx", 1}, {"1.Iyy", 0.9}, {"1.Izz", -1}}})));
}

TEST_CASE("products of inertia are bounded by the moments") {
  const Mechanism m = bodies(SpaceKind::spatial, 1);
  // ∫(x² + y² + 2a xy) = Izz − 2a Ixy, with Ixy = −∫xy.
  const auto proof = prove(m, make_conditions(m, {{{"1.Izz", 1}, {"1.Ixy", -1.9}}}));
  REQUIRE(proof);
  CHECK(proof->kind == Kind::cone);
  CHECK_FALSE(prove(m, make_conditions(m, {{{"1.Izz", 1}, {"1.Ixy", -2.1}}})));
}

TEST_CASE("springs and their ends have no sign that helps, stiffness alone may vanish") {
  Mechanism m = bodies(SpaceKind::planar, 1);
  Spring spring;
  spring.name = "s", spring.second = 1, spring.stiffness = 100;
  spring.point_first = Vector3(0, 1, 0), spring.point_second = Vector3(0.5, 0, 0);
  m.springs.push_back(spring);
  CHECK_FALSE(prove(m, make_conditions(m, {{{"s.k", 1}}})));
  CHECK_FALSE(prove(m, make_conditions(m, {{{"1.m", 1}, {"s.kax", 1}}})));
  CHECK_FALSE(prove(m, make_conditions(m, {{{"1.m", 1}, {"s.k", -1}}})));
  const auto proof = prove(m, make_conditions(m, {{{"1.m", 1}, {"s.k", 1}}}));
  REQUIRE(proof);
  CHECK(proof->statement == "1.m + s.k = 0 cannot hold: none can be negative and 1.m is positive");
}

TEST_CASE("a disc's first moments about its own centre are no way out") {
  Mechanism m = bodies(SpaceKind::spatial, 1);
  Disc disc;
  disc.name = "d", disc.body = 1, disc.mass = 0.2;
  disc.inertia.diagonal() = Vector3(0.01, 0.01, 0.02);
  m.discs.push_back(disc);
  const auto proof = certify_infeasible(make_conditions(m, {{{"1.m", 1}, {"d.m", 1}, {"d.mx", 3}}}), m);
  REQUIRE(proof);
  CHECK(proof->statement == "1.m + d.m = 0 cannot hold: none can be negative and 1.m is positive");
}

TEST_CASE("conditions that some bodies meet are never proved impossible") {
  for (const SpaceKind space : {SpaceKind::planar, SpaceKind::spatial})
    for (unsigned seed = 1; seed <= 60; ++seed) {
      CAPTURE(seed);
      RandomNumbers random(seed);
      Mechanism m = bodies(space, 1 + static_cast<int>(seed % 3));
      if (seed % 2 == 0)
        m.attachments.push_back({"cw", AttachmentKind::counterweight, 1, random.place(1), 0.5, Matrix3::Zero()});
      reshape(m, random);
      const VectorX pi = dynamics::parameter_values(m);
      const Eigen::Index n = 1 + static_cast<Eigen::Index>(random.number(0, 0.9) * static_cast<double>(pi.size()));
      MatrixX rows = random.matrix(n, pi.size());
      if (seed % 3 == 0) rows = rows.cwiseAbs();  // tempting: all of one sign but for what follows
      rows -= (rows * pi) * pi.transpose() / pi.squaredNorm();
      Mechanism other = m;
      reshape(other, random);  // the proof must not lean on the present numbers
      CHECK_FALSE(certify_infeasible(with_matrix(other, rows), other));
    }
}

TEST_CASE("conditions mixed from an impossible one are proved impossible") {
  int proved = 0;
  for (const SpaceKind space : {SpaceKind::planar, SpaceKind::spatial})
    for (unsigned seed = 1; seed <= 30; ++seed) {
      CAPTURE(seed);
      RandomNumbers random(seed);
      Mechanism m = bodies(space, 2);
      const Conditions all = with_matrix(m, MatrixX());
      const auto count = static_cast<Eigen::Index>(all.parameters.size());
      // Row 0: the integral of a squared linear polynomial over each body. Rows mixed: the span stays the same.
      MatrixX rows = random.matrix(4, count);
      VectorX positive = VectorX::Zero(count);
      const Vector3 a = random.place(1), b = random.place(1);
      for (const auto& [name, at] : {std::pair{"1", a}, std::pair{"2", b}}) {
        const std::string of(name);
        positive[find(all, of + ".m")] = at.head(space == SpaceKind::planar ? 2 : 3).squaredNorm();
        positive[find(all, of + ".mx")] = -2 * at.x();
        positive[find(all, of + ".my")] = -2 * at.y();
        if (space == SpaceKind::planar) {
          positive[find(all, of + ".J")] = 1;
        } else {
          positive[find(all, of + ".mz")] = -2 * at.z();
          for (const char* I : {".Ixx", ".Iyy", ".Izz"}) positive[find(all, of + I)] = 0.5;
        }
      }
      rows.row(0) = positive.transpose();
      const auto proof = prove(m, with_matrix(m, random.matrix(4, 4) * rows));
      proved += proof.has_value();
    }
  CHECK(proved == 60);
}

TEST_CASE("bounds prove what physics does not") {
  const Mechanism m = bodies(SpaceKind::planar, 2);
  Conditions c = make_conditions(m, {{{"1.mx", 1}, {"2.m", 0.5}}});
  conditions::BoundedParameters p;
  p.constant = dynamics::parameter_values(m);
  p.gradient = MatrixX::Zero(p.constant.size(), 1);
  p.gradient(find(c, "1.mx"), 0) = 1;
  p.constant[find(c, "1.mx")] = 0;
  p.lower = VectorX::Constant(1, -0.4688), p.upper = VectorX::Constant(1, 0.3);
  const auto proof = certify_infeasible(c, p);
  REQUIRE(proof);
  CHECK(proof->kind == Kind::bounds);
  CHECK(proof->statement == "1.mx + 0.5 2.m = 0 cannot hold within the bounds: the left-hand side is at least 0.0312");
  p.lower[0] = -0.51;
  CHECK_FALSE(certify_infeasible(c, p));
  p.lower[0] = -0.5;  // just enough
  CHECK_FALSE(certify_infeasible(c, p));
}

TEST_CASE("two conditions that pull one number apart cannot both hold") {
  const Mechanism m = bodies(SpaceKind::planar, 2);
  Conditions c = make_conditions(m, {{{"1.mx", 1}, {"2.m", 0.5}}, {{"1.mx", 1}, {"2.m", 0.7}}});
  c.row_scales << 0.1, 10;
  conditions::BoundedParameters p{dynamics::parameter_values(m), MatrixX::Zero(8, 1),
                                  VectorX::Constant(1, -std::numeric_limits<double>::infinity()),
                                  VectorX::Constant(1, std::numeric_limits<double>::infinity())};
  p.gradient(find(c, "1.mx"), 0) = 3;
  const auto proof = certify_infeasible(c, p);
  REQUIRE(proof);
  CHECK(proof->statement == "2.m = 0 cannot hold within the bounds: the left-hand side is at least 1");
}

TEST_CASE("conditions that a point within the bounds meets are never proved impossible") {
  int proved = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    CAPTURE(seed);
    RandomNumbers random(seed);
    const Mechanism m = bodies(SpaceKind::planar, 3);
    Conditions c = with_matrix(m, random.matrix(1 + seed % 6, 12));
    const Eigen::Index n = 1 + seed % 5;
    conditions::BoundedParameters p{random.matrix(12, 1), random.matrix(12, n), -random.matrix(n, 1).cwiseAbs(),
                                    random.matrix(n, 1).cwiseAbs()};
    VectorX z = seed % 2 == 0 ? p.lower : p.upper;  // a corner: the hardest place
    const VectorX pi = p.constant + p.gradient * z;
    c.matrix -= (c.matrix * pi) * pi.transpose() / pi.squaredNorm();
    CHECK_FALSE(certify_infeasible(c, p));
    // The same conditions with another constant: if there is a proof, no random point contradicts it.
    p.constant += 0.5 * random.matrix(12, 1);
    if (const auto proof = certify_infeasible(c, p)) {
      ++proved;
      for (int i = 0; i < 200; ++i) {
        for (Eigen::Index j = 0; j < n; ++j) z[j] = random.number(p.lower[j], p.upper[j]);
        CHECK(proof->coefficients.dot(p.constant + p.gradient * z) > 0);
      }
    }
  }
  CHECK(proved > 20);
}
