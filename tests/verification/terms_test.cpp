// P3's matrices at one configuration.

#include "../dynamics/every_config.hpp"

#include "balance/mechanics/dynamics/equation_terms.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/synthesis/verification/natural_terms.hpp"

#include <doctest/doctest.h>

using namespace balance;

namespace {

constexpr const char* machines[] = {"3rrr.yaml",         "5r.yaml",          "four-bar.yaml",
                                    "slider-crank.yaml", "scotch-yoke.yaml", "squeezer.yaml"};

struct Linkage {
  explicit Linkage(const std::string& file) : study(doors::config(file)), terms(study.mechanism) {
    start = kinematics::solve_configuration(study.mechanism, study.trajectories.front().from).coordinates;
    q.resize(terms.degrees_of_freedom());
    for (Eigen::Index k = 0; k < q.size(); ++k)
      q[k] = start[static_cast<std::size_t>(terms.independent()[static_cast<std::size_t>(k)])].value;
    terms.assemble(q, start);
  }
  verification::natural::NaturalTerms at(const VectorX& there) {
    return verification::natural::compute_natural_terms(study.mechanism, terms.assemble(there, start).value);
  }

  Study study;
  dynamics::EquationTerms terms;
  std::vector<CoordinateValue> start;
  VectorX q;
};

}  // namespace

TEST_CASE("the coefficients C_P are the column sums of the mass matrix and add up to the mass of what moves") {
  for (const char* file : machines) {
    CAPTURE(file);
    Linkage linkage(file);
    const verification::natural::NaturalTerms n = linkage.at(linkage.q);
    CHECK((n.mass - n.mass.transpose()).cwiseAbs().maxCoeff() <= 1e-14 * n.mass.cwiseAbs().maxCoeff());
    std::complex<double> sum = 0;
    for (std::size_t p = 0; p < n.points.size(); ++p) {
      const auto c = static_cast<Eigen::Index>(2 * p);
      double re = 0, im = 0;
      for (Eigen::Index r = 0; r < n.mass.rows(); r += 2) re += n.mass(r, c), im += n.mass(r + 1, c);
      CHECK(std::abs(n.coefficients[p].coefficient - std::complex<double>(re, im)) <= 1e-13 * n.total_mass);
      sum += n.coefficients[p].coefficient;
    }
    CHECK(std::abs(sum - n.total_mass) <= 1e-12 * n.total_mass);
  }
}

TEST_CASE("the constraints are met, and a motion's differences lie in the null space of their Jacobian") {
  for (const char* file : machines) {
    CAPTURE(file);
    Linkage linkage(file);
    const verification::natural::NaturalTerms n = linkage.at(linkage.q);
    CHECK(n.residual.cwiseAbs().maxCoeff() <= 1e-10);
    const VectorX way = VectorX::Constant(linkage.q.size(), 1e-4);
    const verification::natural::NaturalTerms next = linkage.at(linkage.q + way), last = linkage.at(linkage.q - way);
    REQUIRE(next.points == n.points);
    VectorX rate = VectorX::Zero(n.jacobian.cols());
    for (Eigen::Index p = 0; p < n.moving; ++p)
      rate.segment(2 * p, 2) = (next.position.row(p) - last.position.row(p)).transpose() / (2e-4 * n.unit);
    if (rate.size() > 2 * n.moving) continue;  // counted angles are not told here
    CHECK((n.jacobian * rate).cwiseAbs().maxCoeff() <=
          1e-6 * (1 + rate.cwiseAbs().maxCoeff()) * n.jacobian.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("the points' mass matrix has the mechanism's kinetic energy") {
  for (const char* file : {"3rrr.yaml", "5r.yaml", "four-bar.yaml", "slider-crank.yaml"}) {
    CAPTURE(file);
    Linkage linkage(file);

    const verification::natural::NaturalTerms next = linkage.at(linkage.q + VectorX::Constant(linkage.q.size(), 1e-4)),
                                              last = linkage.at(linkage.q - VectorX::Constant(linkage.q.size(), 1e-4));
    VectorX rate(next.mass.rows());
    for (Eigen::Index p = 0; p < next.position.rows(); ++p)
      rate.segment(2 * p, 2) = (next.position.row(p) - last.position.row(p)).transpose() / 2e-4;
    const MatrixX M = linkage.terms.independent_terms(linkage.q).value.mass;
    const VectorX ones = VectorX::Ones(linkage.q.size());
    CHECK(std::abs(rate.dot(next.mass * rate) - ones.dot(M * ones)) <= 1e-6 * ones.dot(M * ones));
  }
}
