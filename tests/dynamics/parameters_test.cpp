// Base parameters: what efforts can tell of masses, and what they cannot.

#include "configs.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/synthesis/conditions/base_parameters.hpp"

#include <doctest/doctest.h>

using namespace balance;
using namespace balance::dynamics;
using namespace equations;

namespace {

/// Efforts per unit of every parameter at many states of a machine.
MatrixX stacked(const Study& study, int states) {
  InverseDynamics door(study.mechanism);
  EquationTerms terms(study.mechanism);
  const auto all = start_of(study);
  const VectorX start = own(terms, all);
  std::vector<CoordinateGuess> near;
  for (const CoordinateValue& v : all)
    near.push_back({study.mechanism.coordinates[static_cast<std::size_t>(v.coordinate)].name, v.value});
  door.assemble(start, near);
  MatrixX rows;
  for (int k = 0; k < states; ++k) {
    const VectorX q = start + 0.2 * wave(start.size(), 0.37 * k * k + k);
    const auto Y = door.regressor(q, 2 * wave(q.size(), 1.3 * k), 3 * wave(q.size(), 2.9 * k + 1));
    if (!Y) continue;
    const Eigen::Index before = rows.rows();
    rows.conservativeResize(before + Y.value.effort.rows(), Y.value.effort.cols());
    rows.bottomRows(Y.value.effort.rows()) = Y.value.effort;
  }
  return rows;
}

}  // namespace

TEST_CASE("efforts at many states tell the base parameters and nothing more") {
  for (const char* file :
       {"rr.yaml", "planar-rrr.yaml", "scara.yaml", "four-bar.yaml", "5r.yaml", "spatial-rrr.yaml"}) {
    CAPTURE(file);
    Study study = doors::config(file);
    study.mechanism.springs.clear();
    const Conditions base = conditions::compute_base_parameters(study.mechanism);
    REQUIRE_MESSAGE(base.status == ConditionsStatus::done, base.reason);
    const MatrixX Y = stacked(study, 60);
    REQUIRE(Y.cols() == base.matrix.cols());
    // every row of efforts is a combination of base parameters
    const MatrixX B = base.matrix;
    Eigen::CompleteOrthogonalDecomposition<MatrixX> qr(B.transpose());
    const MatrixX rest = Y.transpose() - B.transpose() * qr.solve(Y.transpose());
    CHECK(largest(rest) <= 1e-9 * largest(Y));
    // and they are as many as the efforts distinguish
    VectorX size = Y.colwise().norm().transpose();
    const double none = 1e-12 * size.maxCoeff();  // a column of round-off
    for (double& s : size) s = s > none ? 1 / s : 0;
    Eigen::JacobiSVD<MatrixX> svd(Y * size.asDiagonal());
    int rank = 0;
    for (const double s : svd.singularValues()) rank += s > 1e-9 * svd.singularValues()[0] ? 1 : 0;
    CHECK(rank == base.rank);
  }
}

TEST_CASE("a planar arm of two links has six base parameters with weight, four without") {
  Study study = doors::config("rr.yaml");
  Mechanism& m = study.mechanism;
  m.attachments.clear();
  m.discs.clear();
  m.springs.clear();
  m.friction.clear();
  m.loads.clear();
  CHECK(conditions::compute_base_parameters(m).rank == 6);
  m.gravity.setZero();
  CHECK(conditions::compute_base_parameters(m).rank == 4);
}
