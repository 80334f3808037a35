// The equation of motion as matrices, of mechanisms that nobody designed.

#include "random_mechanism_classes.hpp"

#include "balance/mechanics/dynamics/equation_terms.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace {

using namespace balance;

double largest(const MatrixX& matrix) { return matrix.size() == 0 ? 0 : matrix.cwiseAbs().maxCoeff(); }

VectorX wave(Eigen::Index n, double phase) {
  VectorX v(n);
  for (Eigen::Index k = 0; k < n; ++k) v[k] = std::sin(1.7 * static_cast<double>(k + 1) + phase);
  return v;
}

/// A member of the crowd at its start.
struct Subject {
  Subject(laws::Kind kind, std::uint32_t seed) : member(laws::member(kind, seed)), terms(member.experiment.mechanism) {
    for (Eigen::Index c = 0; c < member.start.size(); ++c) near.push_back({static_cast<int>(c), member.start[c]});
    q.resize(terms.degrees_of_freedom());
    for (Eigen::Index k = 0; k < q.size(); ++k) q[k] = member.start[terms.independent()[static_cast<std::size_t>(k)]];
  }

  laws::Member member;
  dynamics::EquationTerms terms;
  std::vector<CoordinateValue> near;
  VectorX q;
};

/// What a law loses where C is large: near singularities.
double room(const MatrixX& C) { return 1 + largest(C) * largest(C); }

void check(Subject& s) {
  REQUIRE(s.terms.degrees_of_freedom() == s.member.freedoms);
  const auto placed = s.terms.assemble(s.q, s.near);
  REQUIRE_MESSAGE(placed, placed.outcome.reason);
  const auto own = s.terms.independent_terms(s.q, 0.1);
  const auto tree = s.terms.redundant_terms(s.q, 0.1);
  REQUIRE_MESSAGE(own, own.outcome.reason);
  REQUIRE(tree);
  const MatrixX &C = tree.value.transformation, &H = tree.value.mass;
  const VectorX dq = wave(s.q.size(), 0.4), ddq = 2 * wave(s.q.size(), 1.9), dy = C * dq;
  CHECK(largest(tree.value.constraints * C) <= 1e-9 * room(C) * (1 + largest(tree.value.constraints)));
  CHECK(largest(C.transpose() * H * C - own.value.mass) <= 1e-10 * room(C) * largest(H));
  CHECK(largest(C.transpose() * tree.value.rest.sum() - own.value.static_terms.sum()) <=
        1e-10 * room(C) * (1 + largest(tree.value.rest.sum())));
  VectorX w(dy.size()), c(dy.size()), expected(dq.size());
  double size = largest(H);
  for (Eigen::Index a = 0; a < dy.size(); ++a) {
    const MatrixX& form = tree.value.velocity[static_cast<std::size_t>(a)];
    w[a] = dy.dot(form * dy);
    c[a] = dq.dot(tree.value.acceleration[static_cast<std::size_t>(a)] * dq);
    size = std::max(size, largest(form));
  }
  for (Eigen::Index k = 0; k < dq.size(); ++k)
    expected[k] = dq.dot(own.value.velocity[static_cast<std::size_t>(k)] * dq);
  CHECK(largest(C.transpose() * (H * c + w) - expected) <=
        1e-9 * room(C) * size * (1 + largest(c) + dy.squaredNorm()) * static_cast<double>(dy.size()));
  const auto split = s.terms.split_efforts(s.q, dq, ddq, 0.1);
  if (!split) {
    CHECK_FALSE(split.outcome.reason.empty());
    return;
  }
  CHECK(largest(split.value.parts.rowwise().sum() - split.value.effort) <=
        1e-12 * room(C) * largest(split.value.parts));
}

}  // namespace

TEST_CASE("random mechanisms: parts add up to torques, and eliminating the loops gives M', D' and z'") {
  for (const laws::Kind kind : laws::kinds)
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
      CAPTURE(laws::name_of(kind));
      CAPTURE(seed);
      Subject subject(kind, seed);
      check(subject);
    }
}
