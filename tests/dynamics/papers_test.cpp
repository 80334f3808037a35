// P0's closed forms as printed, with the corrections of docs/errata.md, at random parameters and configurations.

#include "configs.hpp"

#include <doctest/doctest.h>

#include <random>

using namespace balance;
using namespace balance::dynamics;
using namespace equations;

namespace {

constexpr double g = 9.81;

class Draw {
 public:
  explicit Draw(unsigned seed) : bits_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() % 1000003u) / 1000003.0;
  }

 private:
  std::mt19937 bits_;
};

/// An RR arm with a payload and a balancing mass on each link: P0 section 3.2, figure 2.
struct Arm {
  double a1, a2, m1, m2, c1, c2, I1, I2, payload, m3, c3, m4, c4;

  explicit Arm(Draw& draw)
      : a1(draw(0.28, 0.34)),
        a2(draw(0.42, 0.48)),
        m1(draw(0.5, 2)),
        m2(draw(0.5, 2)),
        c1(draw(0.2, 0.8)),
        c2(draw(0.2, 0.8)),
        I1(draw(0.01, 0.05)),
        I2(draw(0.01, 0.05)),
        payload(draw(0.1, 1)),
        m3(draw(0.5, 3)),
        c3(draw(0.1, 0.9)),
        m4(draw(0.5, 3)),
        c4(draw(0.1, 0.9)) {}

  // P0 eq. 90
  double inertia1() const { return a2 * a2 * (m2 * c2 * c2 + payload + m4 * c4 * c4) + I2; }
  double inertia2() const { return a1 * a1 * (m1 * c1 * c1 + m3 * c3 * c3 + m2 + payload + m4) + I1; }
  double inertia3() const { return a1 * a2 * (m2 * c2 - m4 * c4 + payload); }
  double mu1() const { return g * a1 * (m1 * c1 - m3 * c3 + m2 + payload + m4); }
  double mu2() const { return g * a2 * (m2 * c2 - m4 * c4 + payload); }

  /// Adds it with its first joint at a place of the ground. @return index of its second link
  int add_to(Mechanism& m, double foot) const {
    const auto link = [&](double mass, double com, double length, double J) {
      m.bodies.push_back({.name = "link" + std::to_string(m.bodies.size()),
                          .mass = mass,
                          .com = {com * length, 0, 0},
                          .inertia = Vector3(0, 0, J).asDiagonal(),
                          .points = {}});
      return static_cast<int>(m.bodies.size()) - 1;
    };
    const auto point_mass = [&](int body, double x, double mass) {
      Attachment one;
      one.name = "mass" + std::to_string(m.attachments.size() + 1);
      one.body = body;
      one.position = {x, 0, 0};
      one.mass = mass;
      m.attachments.push_back(one);
    };
    const int first = link(m1, c1, a1, I1), second = link(m2, c2, a2, I2);
    const std::string own = std::to_string(first);
    m.joints.push_back({.name = "R" + own, .first = 0, .second = first, .point_first = {foot, 0, 0}});
    m.joints.push_back({.name = "S" + own, .first = first, .second = second, .point_first = {a1, 0, 0}});
    point_mass(second, a2, payload);
    point_mass(first, -c3 * a1, m3);
    point_mass(second, -c4 * a2, m4);
    return second;
  }
};

Mechanism empty() {
  Mechanism m;
  m.gravity = {0, -g, 0};
  m.bodies = {{.name = "ground"}};
  return m;
}

}  // namespace

TEST_CASE("P0 eq. 90, 92–94: the RR arm's M', D' and z' for random parameters") {
  Draw draw(90);
  for (int trial = 0; trial < 20; ++trial) {
    const Arm arm(draw);
    Mechanism m = empty();
    arm.add_to(m, 0.1);
    m.coordinates = list_coordinates(m.space, m.joints);
    m.actuators = {0, 1};
    EquationTerms terms(m);
    const VectorX q = Vector2(draw(-3, 3), draw(-3, 3));
    const auto found = terms.independent_terms(q);
    REQUIRE(found);
    const IndependentTerms& t = found.value;
    const double c = std::cos(q[1]), s = std::sin(q[1]), I1 = arm.inertia1(), I2 = arm.inertia2(), I3 = arm.inertia3();
    MatrixX M(2, 2), one(2, 2), two(2, 2);
    M << I1 + I2 + 2 * c * I3, I1 + c * I3, I1 + c * I3, I1;  // eq. 92
    one << 0, -I3 * s, -I3 * s, -I3 * s;                      // eq. 93: G is on the other side
    two << I3 * s, 0, 0, 0;
    CHECK(largest(t.mass - M) <= 1e-13 * largest(M));
    CHECK(largest(t.velocity[0] - one) <= 1e-13 * largest(M));
    CHECK(largest(t.velocity[1] - two) <= 1e-13 * largest(M));
    const VectorX z = Vector2(arm.mu1() * std::cos(q[0]) + arm.mu2() * std::cos(q[0] + q[1]),
                              arm.mu2() * std::cos(q[0] + q[1]));  // eq. 94
    CHECK(largest(t.static_terms.sum() - z) <= 1e-13 * g * total_mass(m));
    CHECK(t.viscous.isZero(0));
  }
}

TEST_CASE("P0 eq. 105 as corrected is the 5R's C for random parameters") {
  Draw draw(105);
  for (int trial = 0; trial < 20; ++trial) {
    const Arm left(draw), right(draw);
    Mechanism m = empty();
    const int first = left.add_to(m, 0), second = right.add_to(m, 0.3);
    m.joints.push_back({.name = "P",
                        .first = first,
                        .second = second,
                        .point_first = {left.a2, 0, 0},
                        .point_second = {right.a2, 0, 0}});
    m.coordinates = list_coordinates(m.space, m.joints);
    m.actuators = {0, 2};
    m.assembly = {{0, 2.2}, {1, -1.3}, {2, 0.9}, {3, 1.3}};
    EquationTerms terms(m);
    const VectorX q = Vector2(draw(1.9, 2.3), draw(0.8, 1.2));
    const auto all = terms.assemble(q);
    REQUIRE_MESSAGE(all, all.outcome.reason);
    const auto found = terms.redundant_terms(q);
    REQUIRE(found);
    const double q12 = all.value[1], q22 = all.value[3];
    const double q3 = all.value[2] + q22 - all.value[0] - q12;  // eq. 102, up to a whole turn
    const double s3 = std::sin(q3);
    MatrixX C(4, 2);
    C << 1, 0, -std::sin(q12 + q3) * left.a1 / (s3 * left.a2) - 1, std::sin(q22) * right.a1 / (s3 * left.a2), 0, 1,
        -std::sin(q12) * left.a1 / (s3 * right.a2), std::sin(q22 - q3) * right.a1 / (s3 * right.a2) - 1;
    // rows in the paper's order: R1, S1 of the first leg, then of the second
    const char* const names[] = {"R1", "S1", "R3", "S3"};
    for (Eigen::Index row = 0; row < 4; ++row) {
      const auto& tree = terms.redundant();
      const auto at = std::find(tree.begin(), tree.end(), names[row]) - tree.begin();
      REQUIRE(at < static_cast<std::ptrdiff_t>(tree.size()));
      CHECK(largest(found.value.transformation.row(at) - C.row(row)) <= 1e-11 * largest(C));
    }
  }
}
