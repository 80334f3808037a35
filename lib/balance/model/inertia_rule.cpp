#include "balance/model/inertia_rule.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"

namespace balance {

namespace {

constexpr double inertia_tolerance = 1e-6;  ///< of the largest principal moment: values typed with six digits pass

}  // namespace

InertiaCheck find_inertia_issue(const Matrix3& inertia, bool planar, InertiaOwner bearer) {
  InertiaCheck verdict;
  const bool body = bearer == InertiaOwner::body;
  if (body && inertia.isZero(0)) return verdict;
  if (planar) {
    const double j = verdict.principal_moments[2] = inertia(2, 2);
    if (body ? !(j > 0) : j < 0) verdict.issue = InertiaIssue::not_positive_definite;
    return verdict;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(inertia, Eigen::EigenvaluesOnly);
  const Vector3& principal = verdict.principal_moments = solver.eigenvalues();  // increasing
  const double slack = inertia_tolerance * max_abs(principal);
  if (body ? !(principal[0] > 0) : principal[0] < -slack)
    verdict.issue = InertiaIssue::not_positive_definite;
  else if (principal[0] + principal[1] < principal[2] - slack)
    verdict.issue = InertiaIssue::triangle_violated;
  return verdict;
}

}  // namespace balance
