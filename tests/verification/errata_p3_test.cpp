/// P3's equations as printed, and as they must be: each misprint is shown wrong, each correction right, by numbers in general
/// position. The references are sums over clouds of points and distances between points, not the program's formulas.

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/synthesis/verification/natural_equations.hpp"
#include "balance/synthesis/verification/natural_model.hpp"
#include "balance/synthesis/verification/natural_momentum.hpp"

#include <doctest/doctest.h>

#include <map>
#include <numeric>

using namespace balance;
using balance::verification::natural::Complex;

namespace {

/// A body as a cloud of points in its own axes.
struct Cloud {
  std::vector<double> mass{0.7, 0.4, 0.9, 0.3};
  std::vector<Complex> place{{0.1, 0.3}, {0.5, -0.2}, {0.35, 0.6}, {-0.2, 0.15}};

  template <class F>
  auto sum(F&& f) const {
    auto total = f(place[0]);
    total *= mass[0];
    for (std::size_t k = 1; k < mass.size(); ++k) total += mass[k] * f(place[k]);
    return total;
  }
  double m() const { return std::accumulate(mass.begin(), mass.end(), 0.0); }
  double x() const {
    return sum([](Complex r) { return r.real(); }) / m();
  }
  double y() const {
    return sum([](Complex r) { return r.imag(); }) / m();
  }
  double xx() const {
    return sum([](Complex r) { return r.real() * r.real(); });
  }
  double yy() const {
    return sum([](Complex r) { return r.imag() * r.imag(); });
  }
  double xy() const {
    return sum([](Complex r) { return r.real() * r.imag(); });
  }
  double polar() const { return xx() + yy(); }
};

/// ∫ λᵢ λⱼ dm with the areas' weights λ of A (0, 0), B (l, 0), C (k, h).
Matrix3 mass_of(const Cloud& body, double l, double k, double h) {
  const auto weights = [&](Complex r) {
    const double third = r.imag() / h, second = (r.real() - k * third) / l;
    return Vector3(1 - second - third, second, third);
  };
  return body.sum([&](Complex r) { return Matrix3(weights(r) * weights(r).transpose()); });
}

constexpr double l = 0.8, k = 0.3, h = 0.7;

}  // namespace

TEST_CASE("P3 eq. 2-5: a two-point body's mass matrix, with J about A in all three places") {
  const Cloud body;
  const double m = body.m(), x = body.x(), y = body.y(), J = body.polar();
  const Eigen::Matrix2cd M = verification::natural::two_point_mass({m, m * Complex(x, y), J}, 0, l);
  const Complex diagonal = m - 2 * m * x / l + J / (l * l), upper = {m * x / l - J / (l * l), m * y / l};
  CHECK(std::abs(M(0, 0) - diagonal) < 1e-14);
  CHECK(std::abs(M(0, 1) - upper) < 1e-14);  // a 2×2 block [Re −Im; Im Re] is eq. 3
  CHECK(std::abs(M(1, 0) - std::conj(upper)) < 1e-14);
  CHECK(std::abs(M(1, 1) - J / (l * l)) < 1e-14);
  // eq. 3 with another inertia I, say about the CoM, would not give the kinetic energy of a spin about A
  const double about_com = J - m * (x * x + y * y);
  CHECK(std::abs(m * x / l - about_com / (l * l) - upper.real()) > 0.1);
}

TEST_CASE("P3 eq. 1-5: the two-point matrix gives the kinetic energy of every rigid motion of a cloud") {
  const Cloud body;
  const Complex a(-0.2, 0.4), b(0.5, -0.1), velocity(0.7, -1.1);
  const double spin = 1.9;
  const Complex moment = body.sum([](Complex r) { return r; });
  const Eigen::Matrix2cd M = verification::natural::two_point_mass({body.m(), moment, body.polar()}, a, b);
  const auto at = [&](Complex r) { return velocity + verification::natural::imaginary * spin * r; };
  const Eigen::Vector2cd rates(at(a), at(b));
  const double energy = 0.5 * (rates.adjoint() * M * rates)(0).real();
  CHECK(energy == doctest::Approx(0.5 * body.sum([&](Complex r) { return std::norm(at(r)); })).epsilon(1e-13));
}

TEST_CASE("P3 eq. 8-14: the three-point matrix as corrected is the integral of products of weights") {
  const Cloud body;
  const double m = body.m(), x = body.x(), y = body.y(), Jx = body.xx(), Jy = body.yy(), Jxy = body.xy();
  const Matrix3 exact = mass_of(body, l, k, h);
  Matrix3
      corrected;  // what the text calls J_b, the polar moment, must be the product ∫xy dm; J_x is ∫x² dm, J_y ∫y² dm
  corrected(0, 0) = (1 / (h * h) + k * k / (l * l * h * h) - 2 * k / (l * h * h)) * Jy +
                    (2 / (l * h) - 2 * k / (l * l * h)) * Jxy + Jx / (l * l) +
                    m * (1 - 2 * x / l - 2 * y / h + 2 * y * k / (l * h));
  corrected(0, 1) = (k / (l * h * h) - k * k / (l * l * h * h)) * Jy + (2 * k / (l * l * h) - 1 / (l * h)) * Jxy -
                    Jx / (l * l) + m * (x / l - y * k / (l * h));
  corrected(0, 2) = (k / (l * h * h) - 1 / (h * h)) * Jy - Jxy / (l * h) + m * y / h;
  corrected(1, 1) = k * k / (l * l * h * h) * Jy - 2 * k / (l * l * h) * Jxy + Jx / (l * l);
  corrected(1, 2) = Jxy / (l * h) - k / (l * h * h) * Jy;
  corrected(2, 2) = Jy / (h * h);
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) CHECK(corrected(i, j) == doctest::Approx(exact(i, j)).epsilon(1e-12));
  Matrix3 moments;
  moments << m, m * x, m * y, m * x, Jx, Jxy, m * y, Jxy, Jy;
  CHECK((verification::natural::three_point_mass(moments, 0, l, Complex(k, h)) - exact).norm() < 1e-13);

  // as printed
  const double eq12 = k * k / (l * l * h * h) * Jy - 2 * k * k / (l * l * h) * Jxy + Jx / (k * k);
  const double eq13 = Jxy / (l * h) - k / (l * h) * Jy;
  const double eq14 = Jy / h;
  CHECK(std::abs(eq12 - exact(1, 1)) > 0.1);
  CHECK(std::abs(eq13 - exact(1, 2)) > 0.01);
  CHECK(std::abs(eq14 - exact(2, 2)) > 0.1);
  // eq. 8, 10 and 11 with the polar moment that the text calls J_b
  const double J = body.polar();
  CHECK(std::abs((2 / (l * h) - 2 * k / (l * l * h)) * (J - Jxy)) > 0.1);
  CHECK(std::abs((2 * k / (l * l * h) - 1 / (l * h)) * (J - Jxy)) > 0.1);
  CHECK(std::abs((J - Jxy) / (l * h)) > 0.1);
}

TEST_CASE(
    "P3 eq. 6-14: only J = J_x + J_y shows in a rigid motion: any split of it gives the same energy and momentum") {
  const Cloud body;
  const verification::natural::NaturalInertia inertia{body.m(), body.sum([](Complex r) { return r; }), body.polar()};
  Matrix3 moments;
  moments << body.m(), body.m() * body.x(), body.m() * body.y(), body.m() * body.x(), body.xx(), body.xy(),
      body.m() * body.y(), body.xy(), body.yy();
  const Complex corners[] = {{0, 0}, {l, 0}, {k, h}};
  const Matrix3 own = verification::natural::three_point_mass(moments, corners[0], corners[1], corners[2]);
  const Matrix3 other = verification::natural::three_point_mass(verification::natural::isotropic_moments(inertia),
                                                                corners[0], corners[1], corners[2]);
  CHECK((own - other).norm() > 0.01);
  Eigen::Vector3cd rates;
  for (int p = 0; p < 3; ++p) rates[p] = Complex(0.4, -0.9) + verification::natural::imaginary * 1.3 * corners[p];
  const auto energy = [&](const Matrix3& M) { return 0.5 * (rates.adjoint() * M * rates)(0).real(); };
  CHECK(energy(own) == doctest::Approx(energy(other)).epsilon(1e-13));
  CHECK(std::abs((own * rates).sum() - (other * rates).sum()) < 1e-13);
}

TEST_CASE("P3 eq. 27: the term with the points' velocities, (dq̃/dt) M q̇, is zero for every M that a body can have") {
  const Cloud body;
  const Eigen::Matrix2cd M = verification::natural::two_point_mass(
      {body.m(), body.sum([](Complex r) { return r; }), body.polar()}, {0.1, 0.2}, {0.6, -0.3});
  const Eigen::Vector2cd rates(Complex(0.3, -0.8), Complex(1.4, 0.5));  // not even rigid
  CHECK(std::abs((rates.adjoint() * M * rates)(0).imag()) < 1e-15);
}

namespace {

/// P3's 3RRR with no two numbers alike. Platform: C1 (0, 0), C2 (l7, 0), C3 (k7, h7), as eq. 40, 43, 46 have it.
struct Platform3Rrr {
  double length[8] = {0, 0.18, 0.21, 0.17, 0.2, 0.19, 0.23, 0.15};
  double mass[8] = {0, 1.1, 0.8, 1.3, 0.7, 0.9, 1.2, 3.1};
  double x[8] = {0, 0.08, 0.11, 0.07, 0.09, 0.1, 0.12, 0.06};
  double y[8] = {0, 0.02, -0.03, 0.01, 0.025, -0.015, 0.03, 0.05};
  double k7 = 0.07, h7 = 0.13;
  Mechanism m;

  Platform3Rrr() {
    m.bodies.emplace_back();
    m.bodies[0].name = "ground";
    const Vector3 A[] = {{0.22, -0.13, 0}, {-0.21, -0.12, 0}, {0.01, 0.25, 0}};
    m.bodies[0].points = {{"A1", A[0]}, {"A2", A[1]}, {"A3", A[2]}};
    for (int b = 1; b <= 7; ++b) {
      Body body;
      body.name = std::to_string(b);
      body.mass = mass[b];
      body.com = {x[b], y[b], 0};
      body.inertia(2, 2) = 0.003 + 0.0002 * b;
      const Vector3 end(length[b], 0, 0), zero = Vector3::Zero();
      if (b == 7)
        body.points = {{"C1", zero}, {"C2", end}, {"C3", {k7, h7, 0}}};
      else if (b % 2 == 1)
        body.points = {{"A", zero}, {"B", end}};
      else
        body.points = {{"B", zero}, {"C", end}};
      m.bodies.push_back(body);
    }
    for (int leg = 0; leg < 3; ++leg) {
      const int crank = 2 * leg + 1, coupler = crank + 1;
      const std::string n = std::to_string(leg + 1);
      m.joints.push_back({.name = "A" + n, .first = model::ground, .second = crank, .point_first = A[leg]});
      m.joints.push_back({.name = "B" + n, .first = crank, .second = coupler, .point_first = {length[crank], 0, 0}});
      m.joints.push_back({.name = "C" + n,
                          .first = coupler,
                          .second = 7,
                          .point_first = {length[coupler], 0, 0},
                          .point_second = m.bodies[7].points[static_cast<std::size_t>(leg)].position});
    }
    m.coordinates = list_coordinates(SpaceKind::planar, m.joints);
  }

  std::map<std::string, Complex> coefficients() const {
    std::map<std::string, Complex> all;
    for (const verification::natural::PointCoefficient& p : verification::natural::point_coefficients(m))
      all[p.point] = p.coefficient;
    return all;
  }
  /// Weights of the platform's corners at its centre of mass.
  Vector3 shares() const {
    const double third = y[7] / h7, second = (x[7] - k7 * third) / length[7];
    return {1 - second - third, second, third};
  }
};

}  // namespace

TEST_CASE("P3 eq. 37-46: the coefficient matrices as corrected; as printed, eq. 40 and 46 are not C_C1 and C_C3") {
  const Platform3Rrr robot;
  const std::map<std::string, Complex> C = robot.coefficients();
  const auto end = [&](int b) { return robot.mass[b] / robot.length[b] * Complex(robot.x[b], robot.y[b]); };
  const auto start = [&](int b) { return robot.mass[b] - end(b); };
  const auto close = [](Complex a, Complex b) { return std::abs(a - b) < 1e-13; };
  const double m7 = robot.mass[7], x7 = robot.x[7], y7 = robot.y[7], l7 = robot.length[7];
  CHECK(close(C.at("1.B"), end(1) + start(2)));  // eq. 39, 42, 45
  CHECK(close(C.at("3.B"), end(3) + start(4)));
  CHECK(close(C.at("5.B"), end(5) + start(6)));
  const Complex c1 = m7 + (robot.k7 * y7 / (robot.h7 * l7) - x7 / l7 - y7 / robot.h7) * m7 + end(2);
  const Complex c2 = (x7 / l7 - y7 * robot.k7 / (robot.h7 * l7)) * m7 + end(4);
  const Complex c3 = y7 / robot.h7 * m7 + end(6);
  CHECK(close(C.at("2.C"), c1));  // eq. 40 with x7 / l7
  CHECK(close(C.at("4.C"), c2));  // eq. 43
  CHECK(close(C.at("6.C"), c3));  // eq. 46 with + x6 / l6 m6
  const Complex printed40 = m7 + (robot.k7 * y7 / (robot.h7 * l7) - x7 / robot.h7 - y7 / robot.h7) * m7 + end(2);
  const Complex printed46 = y7 / robot.h7 * m7 - std::conj(end(6));
  CHECK(std::abs(printed40 - c1) > 0.1);
  CHECK(std::abs(printed46 - c3) > 0.1);
  // together they carry the platform and the couplers' shares
  CHECK(close(c1 + c2 + c3, m7 + end(2) + end(4) + end(6)));
  CHECK(std::abs(printed40 + c2 + printed46 - (m7 + end(2) + end(4) + end(6))) > 0.1);
  Complex total;
  for (const auto& [name, coefficient] : C) total += coefficient;
  CHECK(close(total, std::accumulate(robot.mass, robot.mass + 8, 0.0)));
}

TEST_CASE("P3 eq. 35: the block of B2 is M4 of body 3 and M1 of body 4, not M4 of body 1") {
  const Platform3Rrr robot;
  const verification::natural::NaturalModel model =
      verification::natural::build_model(robot.m, {}, false, {std::vector<double>(robot.m.coordinates.size(), 0.0), 0});
  const auto B2 = static_cast<int>(std::find(model.basic.names.begin(), model.basic.names.end(), "3.B") -
                                   model.basic.names.begin());
  Complex block;
  for (const verification::natural::MassEntry& entry : model.mass)
    if (entry.row == B2 && entry.column == B2) block += entry.value;
  const auto about_origin = [&](int b) {
    return robot.m.bodies[static_cast<std::size_t>(b)].inertia(2, 2) +
           robot.mass[b] * (robot.x[b] * robot.x[b] + robot.y[b] * robot.y[b]);
  };
  const auto M4 = [&](int b) { return about_origin(b) / (robot.length[b] * robot.length[b]); };           // eq. 5
  const auto M1 = [&](int b) { return robot.mass[b] * (1 - 2 * robot.x[b] / robot.length[b]) + M4(b); };  // eq. 2
  CHECK(std::abs(block - (M4(3) + M1(4))) < 1e-12);
  CHECK(std::abs(block - (M4(3) + M4(1))) > 0.01);
}

TEST_CASE("P3 eq. 30: nine distances close the 3RRR with three freedoms; the printed rows do not") {
  const Platform3Rrr robot;
  // assembled: the configuration nearest to one in which the legs reach inwards
  const double A1 = 2.2, A2 = 0.2, A3 = -2.2;
  std::vector<double> q{A1, 1.0, 0, A2, 1.0, 0, A3, 1.0, 0};
  const verification::natural::NaturalModel model = verification::natural::build_model(robot.m, {}, false, {q, 0});
  CHECK(model.unknowns() == 12);
  CHECK(model.constraints.size() == 9);
  verification::natural::NaturalKinematicEquations equations(model, {});
  verification::natural::NaturalCoordinates at = model.start;
  REQUIRE(equations.solve_least_norm(at, VectorX()));
  CHECK(verification::natural::find_generic_constraint_rank(model, at) == 9);
  const auto point = [&](const std::string& name) {
    const auto found = std::find(model.basic.names.begin(), model.basic.names.end(), name);
    REQUIRE(found != model.basic.names.end());
    return at.points[static_cast<std::size_t>(found - model.basic.names.begin())] * model.length();
  };
  const Complex B2 = point("3.B"), B3 = point("5.B"), C1 = point("2.C"), C2 = point("4.C"), C3 = point("6.C");
  const auto row = [](Complex p, Complex p2, double d) { return std::norm(p - p2) - d * d; };
  CHECK(std::abs(row(C2, B2, robot.length[4])) < 1e-12);  // right: l4
  CHECK(std::abs(row(C2, B2, robot.length[6])) > 1e-3);   // printed: l6
  const double C2C3 = std::hypot(robot.length[7] - robot.k7, robot.h7);
  CHECK(std::abs(row(C2, C3, C2C3)) < 1e-12);
  const double printed = (C2.real() - B3.real()) * (C2.real() - B3.real()) +
                         (C2.imag() - C3.imag()) * (C2.imag() - C3.imag()) - C2C3 * C2C3;
  CHECK(std::abs(printed) > 1e-3);  // x_B3 in the platform's second row
  CHECK(std::abs(row(C1, C2, robot.length[7])) < 1e-12);
  // without the row of link 5, which eq. 30 lacks, B3 is free to leave its circle
  const MatrixX jacobian = equations.jacobian(at);
  for (int r = 0; r < 9; ++r) {
    MatrixX eight(8, 12);
    eight << jacobian.topRows(r), jacobian.bottomRows(8 - r);
    CHECK(Eigen::FullPivLU<MatrixX>(eight).rank() == 8);
  }
}
