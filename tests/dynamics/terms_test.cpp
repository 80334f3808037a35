// The equation of motion's matrices, each by a second route.

#include "configs.hpp"

#include "balance/mechanics/dynamics/forward_dynamics.hpp"

#include <doctest/doctest.h>

using namespace balance;
using namespace balance::dynamics;
using namespace equations;

namespace {

/// A machine at the start of its first trajectory, a little aside.
struct Machine {
  explicit Machine(const std::string& file) : study(doors::config(file)), terms(study.mechanism), all(start_of(study)) {
    const VectorX start = own(terms, all);
    for (double aside = 0.05; aside > 1e-4; aside /= 4) {
      q = start + aside * wave(start.size(), 0.3) * characteristic();
      if (terms.assemble(start, all) && terms.independent_terms(q)) return;
    }
    FAIL("no configuration");
  }
  /// Lengths move by parts of the mechanism's length.
  double characteristic() const {
    for (const int c : terms.independent())
      if (study.mechanism.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::length)
        return std::min(1.0, characteristic_length(study.mechanism));
    return 1;
  }

  Study study;
  EquationTerms terms;
  std::vector<CoordinateValue> all;
  VectorX q;
};

/// Derivatives of M′ along a direction, by differences of order six.
MatrixX mass_derivative(Machine& m, const VectorX& direction) {
  const double h = 2e-3 * m.characteristic();
  const auto M = [&](double t) { return m.terms.independent_terms(m.q + t * direction).value.mass; };
  return (45 * (M(h) - M(-h)) - 9 * (M(2 * h) - M(-2 * h)) + (M(3 * h) - M(-3 * h))) / (60 * h);
}

/// Velocity terms' matrix C with C q̇ = w′: Σ_r D′_krs q̇_r.
MatrixX coriolis(const IndependentTerms& terms, const VectorX& rates) {
  MatrixX C(rates.size(), rates.size());
  for (Eigen::Index k = 0; k < rates.size(); ++k)
    C.row(k) = rates.transpose() * terms.velocity[static_cast<std::size_t>(k)];
  return C;
}

/// Near singularities derivatives grow: what differences of order six leave at this step.
constexpr double by_differences = 1e-6;

}  // namespace

TEST_CASE("M' is the mass matrix of the inverse and of the forward dynamics") {
  for (const char* file : machines) {
    CAPTURE(file);
    Machine m(file);
    const auto found = m.terms.independent_terms(m.q);
    REQUIRE(found);
    const MatrixX& M = found.value.mass;
    InverseDynamics door(m.study.mechanism);
    std::vector<CoordinateGuess> near;
    for (const CoordinateValue& v : m.all)
      near.push_back({m.study.mechanism.coordinates[static_cast<std::size_t>(v.coordinate)].name, v.value});
    REQUIRE(door.assemble(m.q, near));
    CHECK(largest(M - door.mass_matrix(m.q).value) <= 1e-10 * largest(M));

    ForwardOptions options;
    options.preferred = m.terms.independent();
    ForwardDynamics forward(m.study.mechanism, options);
    const VectorX all = m.terms.assemble(m.q, m.all).value;
    if (forward.set_state(0, all, VectorX::Zero(all.size())).status != MotionStatus::done) continue;
    if (forward.independent() != m.terms.independent()) continue;
    CHECK(largest(M - forward.equation().mass) <= 1e-9 * largest(M));
  }
}

TEST_CASE("D'_krs are the Christoffel symbols of M'") {
  for (const char* file : machines) {
    CAPTURE(file);
    Machine m(file);
    const auto found = m.terms.independent_terms(m.q);
    REQUIRE(found);
    const IndependentTerms& t = found.value;
    const Eigen::Index d = m.q.size();
    std::vector<MatrixX> slope;
    double size = largest(t.mass);
    for (Eigen::Index r = 0; r < d; ++r) {
      slope.push_back(mass_derivative(m, VectorX::Unit(d, r)));
      size = std::max(size, largest(slope.back()));
    }
    const auto dM = [&](Eigen::Index by, Eigen::Index a, Eigen::Index b) {
      return slope[static_cast<std::size_t>(by)](a, b);
    };
    for (Eigen::Index k = 0; k < d; ++k)
      for (Eigen::Index r = 0; r < d; ++r)
        for (Eigen::Index s = 0; s < d; ++s)
          CHECK(std::abs(t.velocity[static_cast<std::size_t>(k)](r, s) -
                         (dM(r, k, s) + dM(s, k, r) - dM(k, r, s)) / 2) <= by_differences * size);
  }
}

TEST_CASE("the rate of M' less twice the velocity terms is antisymmetric") {
  for (const char* file : machines) {
    CAPTURE(file);
    Machine m(file);
    const VectorX rates = wave(m.q.size(), 1.1);
    const auto found = m.terms.independent_terms(m.q);
    REQUIRE(found);
    const MatrixX dM = mass_derivative(m, rates);
    const MatrixX N = dM - 2 * coriolis(found.value, rates);
    CHECK(largest(N + N.transpose()) <= by_differences * std::max(largest(dM), largest(found.value.mass)));
  }
}

TEST_CASE("z' of weight and springs is the slope of the potential energy") {
  for (const char* file : machines) {
    CAPTURE(file);
    Machine m(file);
    const auto found = m.terms.independent_terms(m.q);
    REQUIRE(found);
    InverseDynamics door(m.study.mechanism);
    std::vector<CoordinateGuess> near;
    for (const CoordinateValue& v : m.all)
      near.push_back({m.study.mechanism.coordinates[static_cast<std::size_t>(v.coordinate)].name, v.value});
    door.assemble(m.q, near);
    const VectorX still = VectorX::Zero(m.q.size());
    const auto energy = [&](const VectorX& q) { return door.at(q, still, still).value.potential_energy; };
    const double h = 2e-3 * m.characteristic();
    const VectorX z = found.value.static_terms.weight + found.value.static_terms.springs;
    for (Eigen::Index k = 0; k < m.q.size(); ++k) {
      const VectorX e = h * VectorX::Unit(m.q.size(), k);
      const double slope = (45 * (energy(m.q + e) - energy(m.q - e)) - 9 * (energy(m.q + 2 * e) - energy(m.q - 2 * e)) +
                            (energy(m.q + 3 * e) - energy(m.q - 3 * e))) /
                           (60 * h);
      CHECK(std::abs(z[k] - slope) <= by_differences * std::max({largest(z), std::abs(energy(m.q)), 1e-3}));
    }
  }
}

TEST_CASE("the equations before the loops are eliminated become M', D' and z' by C, and A C = 0") {
  for (const char* file : machines) {
    CAPTURE(file);
    Machine m(file);
    const auto own_terms = m.terms.independent_terms(m.q);
    const auto tree = m.terms.redundant_terms(m.q);
    REQUIRE(own_terms);
    REQUIRE(tree);
    const MatrixX& C = tree.value.transformation;
    const MatrixX M = C.transpose() * tree.value.mass * C;
    CHECK(largest(tree.value.constraints * C) <= 1e-10 * largest(tree.value.constraints) * (1 + largest(C)));
    CHECK(largest(M - own_terms.value.mass) <= 1e-10 * largest(M));
    CHECK(largest(C.transpose() * tree.value.rest.sum() - own_terms.value.static_terms.sum()) <=
          1e-10 * (1 + largest(C)) * largest(tree.value.rest.sum()));
    CHECK(largest(C.transpose() * tree.value.viscous * C - own_terms.value.viscous) <=
          1e-10 * largest(own_terms.value.viscous));
    // P1 eq. 12: v'# = Cᵀ (M Ċ q̇ + v')
    const VectorX rates = wave(m.q.size(), 0.8), dy = C * rates;
    VectorX w(dy.size()), c(dy.size()), expected(rates.size());
    for (Eigen::Index a = 0; a < dy.size(); ++a) {
      w[a] = dy.dot(tree.value.velocity[static_cast<std::size_t>(a)] * dy);
      c[a] = rates.dot(tree.value.acceleration[static_cast<std::size_t>(a)] * rates);
    }
    for (Eigen::Index k = 0; k < rates.size(); ++k)
      expected[k] = rates.dot(own_terms.value.velocity[static_cast<std::size_t>(k)] * rates);
    const VectorX sum = C.transpose() * (tree.value.mass * c + w);
    CHECK(largest(sum - expected) <= 1e-9 * (largest(tree.value.mass) * (largest(c) + dy.squaredNorm()) * largest(C)));
  }
}

TEST_CASE("P1 eq. 27, 28: the balanced planar arm has k = 2.537333, 4.3168, 0.0715 and nothing else, wherever it is") {
  const Study study = doors::config("planar-rrr.yaml");
  EquationTerms terms(study.mechanism);
  const double l1 = 0.5, l2 = 0.4, m1 = 3, m2 = 2, m3 = 1, m67 = 0.8;
  const double J1 = 0.08, J2 = 0.03, J3 = 0.01, J4 = 0.001, J5 = 0.02, J6 = 0.001, J7 = 0.002;
  const double about2 = J2 + J3 + J4 + J6 + J7 + m3 * l2 * l2 + m3 * m3 * l2 * l2 / m2;
  const double printed[] = {J1 + J2 + J3 + J4 + J5 + J6 + J7 + (m2 + m67) * l1 * l1 + m3 * (l1 * l1 + l2 * l2) +
                                l1 * l1 * (m2 + m3 + m67) * (m2 + m3 + m67) / m1 + l2 * l2 * m3 * m3 / m2,
                            about2 + about2 * about2 / J5, (J3 + J6) * (J3 + J6 + J7) / J7};
  for (const double phase : {0.0, 1.3, 4.0}) {
    const auto found = terms.independent_terms(3 * wave(3, phase));
    REQUIRE(found);
    const IndependentTerms& t = found.value;
    for (Eigen::Index k = 0; k < 3; ++k) {
      CHECK(std::abs(t.mass(k, k) - printed[k]) <= 1e-13 * printed[k]);
      CHECK(std::abs(t.static_terms.sum()[k]) <= 1e-13 * 9.81 * (m1 + m2 + m3 + m67) * l1);
      CHECK(largest(t.velocity[static_cast<std::size_t>(k)]) <= 1e-13 * largest(t.mass));
    }
    CHECK(largest(t.mass - MatrixX(t.mass.diagonal().asDiagonal())) <= 1e-13 * largest(t.mass));
  }
  // as the papers' formulas give them, to the digits that are told of this arm
  CHECK(std::abs(printed[0] - 2.537333) < 5e-7);
  CHECK(std::abs(printed[1] - 4.3168) < 5e-5);
  CHECK(std::abs(printed[2] - 0.0715) < 5e-5);
}
