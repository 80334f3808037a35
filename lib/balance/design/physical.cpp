#include "balance/design/physical.hpp"

#include "balance/base/factorizations.hpp"

#include <algorithm>
#include <array>

namespace balance::designing {

namespace {

/// Bodies keep this part of their largest mass or inertia: enough to be told from none, too little to matter.
constexpr double strictly = 1e-6;
/// What an expression may not be below zero by is kept this part of its size above it, more than its round-off.
constexpr double nonnegative_margin = 1e-12;
/// Violations below this part of a quantity's size are round-off.
constexpr double cone_round_off = 1e-13;

/// Σ from Ixx, Iyy, Izz, Ixy, Ixz, Iyz: the second moments ∫ r rᵀ dm about the CoM.
Matrix3 second_moments(const double* i) {
  const double half_trace = (i[0] + i[1] + i[2]) / 2;
  Matrix3 s;
  s << half_trace - i[0], -i[3], -i[4],  //
      -i[3], half_trace - i[1], -i[5],   //
      -i[4], -i[5], half_trace - i[2];
  return s;
}

/// d(vᵀ Σ v) by the six numbers, for a unit vector.
std::array<double, 6> slope(const Vector3& v) {
  const Vector3 w = v.cwiseAbs2();
  return {0.5 - w[0], 0.5 - w[1], 0.5 - w[2], -2 * v[0] * v[1], -2 * v[0] * v[2], -2 * v[1] * v[2]};
}

}  // namespace

Physical::Physical(const ParameterMap& map, const Survey& survey, const VectorX& start) {
  for (const Element& element : list_elements(survey.at_base, survey.loose)) {
    const bool body = element.bearer == Bearer::body;
    add(map, survey, start, element.mass, false, body);
    const bool as_given =
        body && survey.at_base.bodies[static_cast<std::size_t>(element.index)].inertia_as_given;  // whatever it is
    if (element.inertia >= 0 && !as_given)
      add(map, survey, start, element.inertia, survey.at_base.space == SpaceKind::spatial, body);
  }
}

void Physical::add(const ParameterMap& map, const Survey& survey, const VectorX& start, int feature, bool matrix,
                   bool body) {
  const int n = static_cast<int>(survey.base.size()), count = matrix ? 6 : 1;
  bool touched = false, affine = map.polynomial().has_value();
  Item item{feature, matrix, 0, 0};
  for (int f = feature; f < feature + count; ++f) {
    for (int i = 0; i < n; ++i) touched = touched || survey.touches(i, f);
    affine = affine && map.polynomial()->affine(f);
    for (const VectorX& sample : survey.features) item.size = std::max(item.size, std::abs(sample[f]));
    item.size = std::max({item.size, std::abs(survey.base_features[f]), std::abs(start[f])});
  }
  if (!touched || item.size == 0) return;
  if (body) {
    const double at_start =
        matrix ? Eigen::SelfAdjointEigenSolver<Matrix3>(second_moments(&start[feature]), Eigen::EigenvaluesOnly)
                     .eigenvalues()[0]
               : start[feature];
    // a thin rod's Σ is singular to begin with, and read as such
    item.margin = at_start > -strictly * item.size && (matrix || at_start > 0)
                      ? std::min(strictly, at_start / item.size)
                      : strictly;
  } else if (!matrix) {
    item.margin = std::clamp(start[feature] / item.size, 0.0, nonnegative_margin);
  }
  const double demanded = (body ? item.margin : 0) - cone_round_off;
  if (!matrix && map.polynomial() && map.polynomial()->least(feature) >= demanded * item.size &&
      (!body || map.polynomial()->least(feature) > 0))
    return;
  convex_ = convex_ && affine;
  items_.push_back(item);
}

int Physical::size() const {
  int sum = 0;
  for (const Item& item : items_) sum += item.matrix ? 3 : 1;
  return sum;
}

void Physical::evaluate(const VectorX& features, const MatrixX* slopes, VectorX& g, MatrixX* jacobian) const {
  g.resize(size());
  if (jacobian != nullptr) jacobian->setZero(size(), slopes->cols());
  int row = 0;
  for (const Item& item : items_) {
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
      const auto by_number = slope(solver.eigenvectors().col(k));
      for (int c = 0; c < 6; ++c)
        jacobian->row(row) += by_number[static_cast<std::size_t>(c)] / item.size * slopes->row(item.feature + c);
    }
  }
}

bool Physical::holds(const VectorX& features) const {
  if (!features.allFinite()) return false;
  VectorX g;
  evaluate(features, nullptr, g, nullptr);
  int row = 0;
  for (const Item& item : items_)
    for (int k = 0; k < (item.matrix ? 3 : 1); ++k, ++row)
      // half of a margin may be lost to the search's tolerances; what remains is still positive
      if (g[row] < -std::max(cone_round_off, item.margin / 2)) return false;
  return true;
}

}  // namespace balance::designing
