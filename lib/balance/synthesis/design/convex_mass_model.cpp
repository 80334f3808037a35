#include "balance/synthesis/design/convex_mass_model.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/levenberg_marquardt.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/geometry_features.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace balance::design {

// Samples of points and directions.

/// Maximum dimension of grids.
inline constexpr int max_grid_dimension = 3;
/// A grid in the box [−1, 1]ⁿ including its boundary, as columns.
MatrixX grid_points(int n);

/// Unit vectors in all directions as rows, including the axes.
/// @param dimension 2 or 3
MatrixX direction_samples(int dimension);

/// Unit normals, as rows, of the facets of all Σ u_i edge_i with |u_i| ≤ 1, and both normals of every direction in which
/// it is flat. No rows if the edges (columns) are not independent.
MatrixX parallelotope_normals(const MatrixX& edges);

namespace {

/// Second differences below this fraction of the values are round-off.
constexpr double nonlinearity_tolerance = 1e-9;

/// The slopes of an affine function of the points; no columns if the function is not affine.
/// @param points, values as columns
MatrixX affine_edges(const MatrixX& points, const MatrixX& values) {
  MatrixX basis(points.rows() + 1, points.cols());
  basis << points, MatrixX::Ones(1, points.cols());
  const MatrixX fit = values * basis.transpose() * (basis * basis.transpose()).inverse();
  if (!(numerics::max_abs(values - fit * basis) <= nonlinearity_tolerance * numerics::max_abs(values)))
    return MatrixX(values.rows(), 0);
  return fit.leftCols(points.rows());
}

}  // namespace

ConvexMassModel::ConvexMassModel(const SolverContext& context, const VectorX& anchor,
                                 const std::vector<bool>& is_active_parameter)
    : context_(context),
      dimension_(context.classification.base_mechanism.space == SpaceKind::planar ? 2 : 3),
      terms_(static_cast<Eigen::Index>(is_active_parameter.size())) {
  classify_variables(anchor, is_active_parameter);
  unknowns_ = static_cast<Eigen::Index>(linear_.size());
  for (FirstMomentLift& lift : lifts_) {
    lift.unknown = static_cast<int>(unknowns_);
    unknowns_ += dimension_ + (lift.inertia >= 0 ? 1 : 0);
  }
}

VectorX ConvexMassModel::features(const VectorX& u) const {
  VectorX values;
  context_.features.evaluate(u, values, nullptr);
  return values;
}

/// Whether the mixed second difference of a relevant feature is not zero.
bool ConvexMassModel::is_nonlinear(int i, int j, const VectorX& base,
                                   const std::vector<bool>& is_active_parameter) const {
  VectorX a = base, b = base, both = base;
  const auto shift = [&](int k) { return base[k] > 0 ? -0.37 : 0.41; };
  if (i == j) {
    a[i] += shift(i);
    b[i] += 2 * shift(i);
    both = a;
  } else {
    a[i] += shift(i);
    b[j] += shift(j);
    both[i] = a[i];
    both[j] = b[j];
  }
  const VectorX f0 = features(base), fa = features(a), fb = features(b), f = features(both);
  const VectorX second_difference = i == j ? VectorX(f0 - 2 * fa + fb) : VectorX(f0 - fa - fb + f);
  const VectorX size = f0.cwiseAbs().cwiseMax(fa.cwiseAbs()).cwiseMax(fb.cwiseAbs());
  const Mechanism& mechanism = context_.classification.base_mechanism;
  const double length = characteristic_length(mechanism);
  const double absolute_tolerance =
      1e-14 * std::min(1.0, total_mass(mechanism) * length * length);  // the terms of a small mechanism are small
  for (Eigen::Index k = 0; k < second_difference.size(); ++k) {
    const bool is_relevant = k >= terms_ || is_active_parameter[static_cast<std::size_t>(k)];
    if (is_relevant && !(std::abs(second_difference[k]) <= nonlinearity_tolerance * size[k] + absolute_tolerance))
      return true;
  }
  return false;
}

/// Elements some of whose mass properties the variable changes.
std::vector<ConvexMassModel::ElementCopy> ConvexMassModel::list_moved_elements(int number) const {
  const Mechanism& mechanism = context_.classification.base_mechanism;
  const std::vector<dynamics::Parameter> terms =
      conditions::list_terms(mechanism, context_.classification.loose_springs);
  std::vector<ElementCopy> moved;
  for (const ElementFeatures& element : list_element_features(mechanism, context_.classification.loose_springs)) {
    if (element.bearer == dynamics::ParameterOwner::spring) continue;
    ElementCopy candidate{0, element.inertia};
    for (std::size_t k = 0; k < terms.size(); ++k)
      if (terms[k].owner_kind == element.bearer && terms[k].index == element.index && terms[k].slot == 0)
        candidate.first = static_cast<int>(k);
    bool is_moved = false;
    for (int k = 0; k < count_mass_terms(); ++k)
      is_moved = is_moved || context_.classification.has_effect(number, candidate.first + k);
    if (is_moved) moved.push_back(candidate);
  }
  return moved;
}

bool ConvexMassModel::are_copies(const ElementCopy& a, const ElementCopy& b) const {
  const auto are_equal = [&](const VectorX& features) {
    return is_equal_to_rounding(features.segment(a.first, count_mass_terms()),
                                features.segment(b.first, count_mass_terms())) &&
           is_equal_to_rounding(features.segment(a.inertia, dimension_ == 2 ? 1 : 6),
                                features.segment(b.inertia, dimension_ == 2 ? 1 : 6));
  };
  const std::vector<VectorX>& perturbed = context_.classification.perturbed_features;
  return are_equal(context_.classification.base_features) && std::all_of(perturbed.begin(), perturbed.end(), are_equal);
}

/// The lift for a variable that moves the CoM of one element, or of copies of it, and has no other effect; std::nullopt
/// for others.
std::optional<ConvexMassModel::FirstMomentLift> ConvexMassModel::find_lift(
    int number, const std::vector<bool>& is_active_parameter) const {
  FirstMomentLift lift;
  lift.copies = list_moved_elements(number);
  if (lift.copies.empty()) return std::nullopt;
  bool has_second_moments = false;
  for (const ElementCopy& element : lift.copies) {
    if (!are_copies(element, lift.copies.front())) return std::nullopt;
    if (context_.classification.has_effect(number, element.first)) return std::nullopt;
    for (int k = 0; k < (dimension_ == 2 ? 1 : 6); ++k)
      if (context_.classification.has_effect(number, element.inertia + k)) return std::nullopt;
    for (int k = element.first + 1 + dimension_; k < element.first + count_mass_terms(); ++k)
      has_second_moments = has_second_moments || is_active_parameter[static_cast<std::size_t>(k)];
  }
  if (has_second_moments && dimension_ == 3) return std::nullopt;
  lift.numbers = {number};
  lift.first = lift.copies.front().first;
  if (has_second_moments) lift.inertia = lift.copies.front().inertia;
  return lift;
}

void ConvexMassModel::classify_variables(const VectorX& anchor, const std::vector<bool>& is_active_parameter) {
  const VectorX& base = context_.classification.base;
  std::vector<int> inner = inertial_variables(context_);
  outer_ = geometric_variables(context_);
  std::map<int, FirstMomentLift> lifts;
  const std::vector<int> all = inner;
  const auto is_nonlinear_in = [&](int i) {
    return std::any_of(all.begin(), all.end(), [&](int j) { return is_nonlinear(i, j, base, is_active_parameter); });
  };
  inner.clear();
  for (const int i : all) {
    const VectorX& moved = context_.classification.perturbed_features[static_cast<std::size_t>(i)];
    if (is_equal_to_rounding(moved, context_.classification.base_features)) {
      outer_.push_back(i);  // can affect only the motion
      continue;
    }
    const std::optional<FirstMomentLift> lift = is_nonlinear_in(i) ? find_lift(i, is_active_parameter) : std::nullopt;
    if (!lift)
      inner.push_back(i);
    else if (const auto known = lifts.find(lift->first); known == lifts.end())
      lifts[lift->first] = *lift;
    else
      known->second.numbers.push_back(i);
  }
  // A place with a component that nothing depends on, such as a height: all of it belongs to the first moment.
  std::erase_if(inner, [&](int i) {
    const std::optional<FirstMomentLift> lift = find_lift(i, is_active_parameter);
    const auto known = lift ? lifts.find(lift->first) : lifts.end();
    if (known == lifts.end()) return false;
    known->second.numbers.push_back(i);
    return true;
  });
  for (auto& [first, lift] : lifts) {
    if (sample_com_positions(lift, anchor))
      lifts_.push_back(lift);
    else
      outer_.insert(outer_.end(), lift.numbers.begin(), lift.numbers.end());
  }
  move_nonlinear_out(inner, is_active_parameter);
  linear_ = inner;
  std::sort(outer_.begin(), outer_.end());
}

/// Moves the variable with the most nonlinear interactions to the outer ones, until the others are affine.
void ConvexMassModel::move_nonlinear_out(std::vector<int>& inner, const std::vector<bool>& is_active_parameter) {
  const VectorX& base = context_.classification.base;
  while (!inner.empty()) {
    std::vector<int> count(inner.size(), 0);
    for (std::size_t i = 0; i < inner.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        if (is_nonlinear(inner[i], inner[j], base, is_active_parameter))
          count[i] += i == j ? 2 : 1, count[j] += i == j ? 0 : 1;
    const auto max_count = std::max_element(count.begin(), count.end());
    if (*max_count == 0) break;
    outer_.push_back(inner[static_cast<std::size_t>(max_count - count.begin())]);
    inner.erase(inner.begin() + (max_count - count.begin()));
  }
}

VectorX ConvexMassModel::com_position(const FirstMomentLift& lift, const VectorX& u) const {
  const VectorX f = features(u);
  return f.segment(lift.first + 1, dimension_) / f[lift.first];
}

/// Samples the possible positions of the CoM. @return false if they depend on other variables or need too many samples
bool ConvexMassModel::sample_com_positions(FirstMomentLift& lift, const VectorX& anchor) const {
  const auto n = static_cast<int>(lift.numbers.size());
  if (n > max_grid_dimension) return false;
  const MatrixX points = grid_points(n);
  VectorX u = context_.classification.base, other = anchor;
  for (const int i : inertial_variables(context_)) other[i] = std::max(0.3, std::abs(anchor[i]));
  lift.com_samples.resize(dimension_, points.cols());
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    u(lift.numbers) = points.col(k);
    lift.com_samples.col(k) = com_position(lift, u);
    if (!lift.com_samples.col(k).allFinite()) return false;
  }
  other(lift.numbers) = points.col(0);
  lift.radius = numerics::max_abs(lift.com_samples.colwise().norm());
  if (!((com_position(lift, other) - lift.com_samples.col(0)).norm() < 1e-9 * lift.radius)) return false;
  lift.variable_samples = points;
  lift.directions = parallelotope_normals(affine_edges(points, lift.com_samples));
  if (lift.directions.rows() == 0) lift.directions = direction_samples(dimension_);
  lift.support = numerics::row_maxima(lift.directions * lift.com_samples);
  lift.mass = std::max(std::abs(features(context_.classification.base)[lift.first]), 1e-12);
  return true;
}

std::optional<AffineTerms> ConvexMassModel::evaluate(const VectorX& u) const {
  VectorX base = u;
  for (const int i : linear_) base[i] = 0;
  for (const FirstMomentLift& lift : lifts_) base(lift.numbers).setZero();
  const VectorX zero = features(base);
  if (!zero.allFinite()) return std::nullopt;
  MatrixX slopes = MatrixX::Zero(zero.size(), unknowns_);
  for (std::size_t k = 0; k < linear_.size(); ++k) {
    VectorX moved = base;
    moved[linear_[k]] = 1;
    slopes.col(static_cast<Eigen::Index>(k)) = features(moved) - zero;
  }
  if (!slopes.allFinite()) return std::nullopt;
  AffineTerms terms{slopes.topRows(terms_), zero.head(terms_), {}};
  numerics::ConeProgramBuilder rows(unknowns_);
  const auto n = static_cast<Eigen::Index>(linear_.size());
  if (n > 0) {
    rows.add_inequalities(MatrixX::Identity(n, unknowns_), VectorX::Ones(n));
    rows.add_inequalities(-MatrixX::Identity(n, unknowns_), VectorX::Ones(n));
  }
  VectorX g;
  MatrixX dg;
  context_.physical_constraints.evaluate(zero, &slopes, g, &dg);
  for (Eigen::Index k = 0; k < g.size(); ++k) rows.add_inequalities(VectorX(-dg.row(k).transpose()), g[k]);
  for (const FirstMomentLift& lift : lifts_)
    for (const ElementCopy& element : lift.copies) write_lift_rows(lift, element, zero, slopes, terms);
  for (const FirstMomentLift& lift : lifts_) add_lift_cones(lift, terms, zero, slopes, rows);
  terms.constraints = rows.build(VectorX::Zero(unknowns_));
  return terms;
}

std::vector<Eigen::Index> ConvexMassModel::list_massless_unknowns(const AffineTerms& terms,
                                                                  const VectorX& upper) const {
  std::vector<Eigen::Index> massless;
  const VariableScaling& scaling = context_.scaling;
  for (const FirstMomentLift& lift : lifts_) {
    double max_mass = terms.constant[lift.first];
    for (std::size_t k = 0; k < linear_.size(); ++k) {
      const double slope = terms.matrix(lift.first, static_cast<Eigen::Index>(k));
      const int i = linear_[k];
      const double high =
          scaling.half_width()[i] > 0 ? std::min(1.0, (upper[i] - scaling.centre()[i]) / scaling.half_width()[i]) : 0.0;
      max_mass += std::max(-slope, slope * high);
    }
    if (max_mass > 1e-12 * lift.mass) continue;
    const int count = dimension_ + (lift.inertia >= 0 ? 1 : 0);
    for (int k = 0; k < count; ++k) massless.push_back(lift.unknown + k);
  }
  return massless;
}

/// Expresses first moment and inertia of the element by its own unknowns, in units of mass · radius and mass · radius².
void ConvexMassModel::write_lift_rows(const FirstMomentLift& lift, const ElementCopy& element, const VectorX& zero,
                                      const MatrixX& slopes, AffineTerms& terms) const {
  for (int d = 0; d < dimension_; ++d) {
    const int row = element.first + 1 + d;
    terms.matrix.row(row).setZero();
    terms.matrix(row, lift.unknown + d) = lift.mass * lift.radius;
    terms.constant[row] = 0;
  }
  if (lift.inertia < 0) return;
  const int row = element.first + 1 + dimension_;
  terms.matrix.row(row) = slopes.row(element.inertia);
  terms.matrix(row, lift.unknown + dimension_) = lift.mass * lift.radius * lift.radius;
  terms.constant[row] = zero[element.inertia];
}

/// Constrains h to the cone over all positions, and the contribution q to the inertia to |h|²/m ≤ q ≤ m r².
void ConvexMassModel::add_lift_cones(const FirstMomentLift& lift, const AffineTerms& terms, const VectorX& zero,
                                     const MatrixX& slopes, numerics::ConeProgramBuilder& rows) const {
  const VectorX mass = slopes.row(lift.first).transpose() / lift.mass;
  const double constant_mass = zero[lift.first] / lift.mass;
  for (Eigen::Index k = 0; k < lift.directions.rows(); ++k) {
    VectorX row = -lift.support[k] / lift.radius * mass;
    row.segment(lift.unknown, dimension_) += lift.directions.row(k).transpose();
    rows.add_inequalities(row, lift.support[k] / lift.radius * constant_mass);
  }
  MatrixX cone = MatrixX::Zero(1 + dimension_, terms.matrix.cols());
  VectorX constant = VectorX::Zero(1 + dimension_);
  cone.row(0) = mass.transpose();
  constant[0] = constant_mass;
  cone.block(1, lift.unknown, dimension_, dimension_).setIdentity();
  rows.add_cone(cone, constant);
  if (lift.inertia < 0) return;
  const int q = lift.unknown + dimension_;
  VectorX upper = -mass;
  upper[q] += 1;
  rows.add_inequalities(upper, constant_mass);
  // (q + m)² ≥ |2 h|² + (q − m)²
  MatrixX rotated = MatrixX::Zero(2 + dimension_, terms.matrix.cols());
  VectorX shift = VectorX::Zero(2 + dimension_);
  rotated.row(0) = mass.transpose();
  rotated.row(1) = -mass.transpose();
  rotated(0, q) += 1;
  rotated(1, q) += 1;
  shift[0] = constant_mass;
  shift[1] = -constant_mass;
  rotated.block(2, lift.unknown, dimension_, dimension_) = 2 * MatrixX::Identity(dimension_, dimension_);
  rows.add_cone(rotated, shift);
}

VectorX ConvexMassModel::recover_variables(const VectorX& u, const VectorX& unknowns) const {
  VectorX all = u;
  for (std::size_t k = 0; k < linear_.size(); ++k)
    all[linear_[k]] = std::clamp(unknowns[static_cast<Eigen::Index>(k)], -1.0, 1.0);
  for (const FirstMomentLift& lift : lifts_) {
    const double mass = features(all)[lift.first];
    if (!(mass > 1e-9 * lift.mass)) continue;
    const VectorX target = unknowns.segment(lift.unknown, dimension_) * (lift.mass * lift.radius / mass);
    const Eigen::Index nearest = numerics::min_index((lift.com_samples.colwise() - target).colwise().norm());
    numerics::NonlinearSystem equations;
    equations.primary_rows = equations.row_count = dimension_;
    const auto deviation = [&](const VectorX& v) {
      VectorX moved = all;
      moved(lift.numbers) = v;
      return VectorX((com_position(lift, moved) - target) / lift.radius);
    };
    equations.evaluate = [&](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      values = deviation(v);
      if (jacobian != nullptr) *jacobian = central_difference_jacobian(deviation, v, dimension_);
      return values.allFinite();
    };
    all(lift.numbers) = solve_levenberg_marquardt(equations, lift.variable_samples.col(nearest), 20).u;
  }
  return all;
}

namespace {

/// Grid points per axis in one, two and three dimensions.
constexpr std::array<int, max_grid_dimension> grid_points_per_axis = {65, 17, 9};
/// Smallest ratio of singular values of independent edges.
constexpr double edge_rank_tolerance = 1e-6;

}  // namespace

MatrixX grid_points(int n) {
  const int points_per_axis = grid_points_per_axis[static_cast<std::size_t>(n - 1)];
  Eigen::Index count = 1;
  for (int i = 0; i < n; ++i) count *= points_per_axis;
  MatrixX points(n, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    Eigen::Index rest = k;
    for (int i = 0; i < n; ++i, rest /= points_per_axis)
      points(i, k) = -1 + 2.0 * static_cast<double>(rest % points_per_axis) / (points_per_axis - 1);
  }
  return points;
}

MatrixX parallelotope_normals(const MatrixX& edges) {
  const Eigen::Index dimension = edges.rows(), n = edges.cols();
  if (n == 0 || n > dimension) return MatrixX(0, dimension);
  const numerics::SingularValueDecomposition svd(edges, Eigen::ComputeFullU | Eigen::ComputeThinV);
  const VectorX& s = svd.singularValues();
  if (!(s[n - 1] > edge_rank_tolerance * s[0])) return MatrixX(0, dimension);
  MatrixX normals(dimension, dimension);
  normals.topRows(n) =
      svd.matrixV() * s.cwiseInverse().asDiagonal() * svd.matrixU().leftCols(n).transpose();  // the pseudoinverse
  normals.topRows(n).rowwise().normalize();
  normals.bottomRows(dimension - n) = svd.matrixU().rightCols(dimension - n).transpose();
  MatrixX both(2 * dimension, dimension);
  both << normals, -normals;
  return both;
}

MatrixX direction_samples(int dimension) {
  constexpr int planar_direction_count = 32;
  if (dimension == 3) {
    MatrixX directions(26, 3);
    Eigen::Index row = 0;
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (const Vector3 d(z, y, x); d.norm() > 0) directions.row(row++) = d.normalized();
    return directions;
  }
  MatrixX directions(planar_direction_count, 2);
  for (int k = 0; k < planar_direction_count; ++k) {
    const double angle = 2 * std::numbers::pi * k / planar_direction_count;
    directions.row(k) << elementary::cos(angle), elementary::sin(angle);
  }
  return directions;
}

}  // namespace balance::design
