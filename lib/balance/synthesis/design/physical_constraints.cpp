#include "balance/synthesis/design/physical_constraints.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <algorithm>
#include <array>

namespace balance::design {

namespace {

/// Margin of bodies, relative to their largest mass or inertia: distinguishable from zero, but too small to matter.
constexpr double min_relative_inertia = 1e-6;
/// Margin of quantities that must not be negative, relative to their size; larger than their round-off.
constexpr double nonnegativity_margin = 1e-12;
/// Violations below this are round-off, relative to the size of the quantity.
constexpr double inertia_tolerance = 1e-13;

/// Σ from Ixx, Iyy, Izz, Ixy, Ixz, Iyz: second moments of mass ∫ r rᵀ dm about the CoM.
Matrix3 second_moments(const double* i) {
  const double half_trace = (i[0] + i[1] + i[2]) / 2;
  Matrix3 s;
  s << half_trace - i[0], -i[3], -i[4],  //
      -i[3], half_trace - i[1], -i[5],   //
      -i[4], -i[5], half_trace - i[2];
  return s;
}

/// d(vᵀ Σ v) by the six inertia components, for a unit vector v.
std::array<double, 6> second_moment_gradient(const Vector3& v) {
  const Vector3 w = v.cwiseAbs2();
  return {0.5 - w[0], 0.5 - w[1], 0.5 - w[2], -2 * v[0] * v[1], -2 * v[0] * v[2], -2 * v[1] * v[2]};
}

}  // namespace

PhysicalConstraints::PhysicalConstraints(const FeatureMap& map, const VariableClassification& classification,
                                         const VectorX& start) {
  for (const ElementFeatures& element :
       list_element_features(classification.base_mechanism, classification.loose_springs)) {
    const bool is_body = element.bearer == dynamics::ParameterOwner::body;
    add(map, classification, start, element.mass, false, is_body);
    const bool is_unconstrained =
        is_body && classification.base_mechanism.bodies[static_cast<std::size_t>(element.index)].inertia_as_given;
    if (element.inertia >= 0 && !is_unconstrained)
      add(map, classification, start, element.inertia, classification.base_mechanism.space == SpaceKind::spatial,
          is_body);
  }
}

void PhysicalConstraints::add(const FeatureMap& map, const VariableClassification& classification, const VectorX& start,
                              int feature, bool matrix, bool is_body) {
  const int n = static_cast<int>(classification.base.size()), count = matrix ? 6 : 1;
  bool is_variable = false, affine = map.polynomial().has_value();
  InertialBound item{feature, matrix, 0, 0, is_body};
  for (int f = feature; f < feature + count; ++f) {
    for (int i = 0; i < n; ++i) is_variable = is_variable || classification.has_effect(i, f);
    affine = affine && map.polynomial()->is_affine(f);
    for (const VectorX& sample : classification.perturbed_features)
      item.size = std::max(item.size, std::abs(sample[f]));
    item.size = std::max({item.size, std::abs(classification.base_features[f]), std::abs(start[f])});
  }
  if (!is_variable || item.size == 0) return;
  if (is_body) {
    const double at_start =
        matrix ? Eigen::SelfAdjointEigenSolver<Matrix3>(second_moments(&start[feature]), Eigen::EigenvaluesOnly)
                     .eigenvalues()[0]
               : start[feature];
    // Σ of a thin rod is singular from the start and accepted as such.
    item.margin = at_start > -min_relative_inertia * item.size && (matrix || at_start > 0)
                      ? std::min(min_relative_inertia, at_start / item.size)
                      : min_relative_inertia;
  } else if (!matrix) {
    item.margin = std::clamp(start[feature] / item.size, 0.0, nonnegativity_margin);
  }
  const double required_margin = (is_body ? item.margin : 0) - inertia_tolerance;
  if (!matrix && map.polynomial() && map.polynomial()->lower_bound(feature) >= required_margin * item.size &&
      (!is_body || map.polynomial()->lower_bound(feature) > 0))
    return;
  convex_ = convex_ && affine;
  items_.push_back(item);
}

int PhysicalConstraints::size() const {
  int sum = 0;
  for (const InertialBound& item : items_) sum += item.matrix ? 3 : 1;
  return sum;
}

void PhysicalConstraints::evaluate(const VectorX& features, const MatrixX* slopes, VectorX& g,
                                   MatrixX* jacobian) const {
  g.resize(size());
  if (jacobian != nullptr) jacobian->setZero(size(), slopes->cols());
  int row = 0;
  for (const InertialBound& item : items_) {
    if (!item.matrix) {
      g[row] = features[item.feature] / item.size - item.margin;
      if (jacobian != nullptr) jacobian->row(row) = slopes->row(item.feature) / item.size;
      ++row;
      continue;
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(second_moments(&features[item.feature]));
    for (int k = 0; k < 3; ++k, ++row) {
      g[row] = solver.eigenvalues()[k] / item.size - item.margin;
      if (jacobian == nullptr) continue;
      const auto gradient = second_moment_gradient(solver.eigenvectors().col(k));
      for (int c = 0; c < 6; ++c)
        jacobian->row(row) += gradient[static_cast<std::size_t>(c)] / item.size * slopes->row(item.feature + c);
    }
  }
}

bool PhysicalConstraints::is_satisfied(const VectorX& features) const {
  if (!features.allFinite()) return false;
  VectorX g;
  evaluate(features, nullptr, g, nullptr);
  int row = 0;
  for (const InertialBound& item : items_)
    for (int k = 0; k < (item.matrix ? 3 : 1); ++k, ++row)
      // Search tolerances may use up half of the margin of a body; the rest keeps the quantity positive. An element may
      // vanish.
      if (g[row] < -std::max(inertia_tolerance, item.is_body ? item.margin / 2 : item.margin)) return false;
  return true;
}

}  // namespace balance::design
