#include "balance/design/inertial_model.hpp"

#include "balance/base/extrema.hpp"
#include "balance/design/features.hpp"
#include "balance/design/gauss_newton.hpp"
#include "balance/design/places.hpp"
#include "balance/design/restricted.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace balance::designing {

namespace {

/// Second differences below this part of the values are round-off.
constexpr double straight = 1e-9;
}  // namespace

InertialModel::InertialModel(const Context& context, const VectorX& anchor, const std::vector<bool>& matters)
    : context_(context),
      dimension_(context.survey.at_base.space == SpaceKind::planar ? 2 : 3),
      terms_(static_cast<Eigen::Index>(matters.size())) {
  divide(anchor, matters);
  unknowns_ = static_cast<Eigen::Index>(linear_.size());
  for (Lift& lift : lifts_) {
    lift.unknown = static_cast<int>(unknowns_);
    unknowns_ += dimension_ + (lift.inertia >= 0 ? 1 : 0);
  }
}

VectorX InertialModel::features(const VectorX& u) const {
  VectorX values;
  context_.map.evaluate(u, values, nullptr);
  return values;
}

/// The mixed second difference of something that matters is not zero.
bool InertialModel::curved(int i, int j, const VectorX& base, const std::vector<bool>& matters) const {
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
  const VectorX bend = i == j ? VectorX(f0 - 2 * fa + fb) : VectorX(f0 - fa - fb + f);
  const VectorX size = f0.cwiseAbs().cwiseMax(fa.cwiseAbs()).cwiseMax(fb.cwiseAbs());
  const Mechanism& mechanism = context_.survey.at_base;
  const double length = characteristic_length(mechanism);
  const double nothing =
      1e-14 * std::min(1.0, total_mass(mechanism) * length * length);  // a small mechanism's terms are small
  for (Eigen::Index k = 0; k < bend.size(); ++k) {
    const bool counts = k >= terms_ || matters[static_cast<std::size_t>(k)];
    if (counts && !(std::abs(bend[k]) <= straight * size[k] + nothing)) return true;
  }
  return false;
}

/// The one element whose CoM a number moves, and nothing else.
std::optional<InertialModel::Lift> InertialModel::lift_of(int number, const std::vector<bool>& matters) const {
  const Mechanism& mechanism = context_.survey.at_base;
  const std::vector<Parameter> terms = list_terms(mechanism, context_.survey.loose);
  std::optional<Lift> lift;
  for (const Element& element : list_elements(mechanism, context_.survey.loose)) {
    if (element.bearer == Bearer::spring) continue;
    Lift one;
    for (std::size_t k = 0; k < terms.size(); ++k)
      if (terms[k].bearer == element.bearer && terms[k].index == element.index && terms[k].slot == 0)
        one.first = static_cast<int>(k);
    const int count = dimension_ == 2 ? 4 : 10;
    bool touched = false;
    for (int k = 0; k < count; ++k) touched = touched || context_.survey.touches(number, one.first + k);
    if (!touched) continue;
    if (lift || context_.survey.touches(number, one.first)) return std::nullopt;
    bool second = false;
    for (int k = one.first + 1 + dimension_; k < one.first + count; ++k)
      second = second || matters[static_cast<std::size_t>(k)];
    if (second && dimension_ == 3) return std::nullopt;
    for (int k = 0; k < (dimension_ == 2 ? 1 : 6); ++k)
      if (context_.survey.touches(number, element.inertia + k)) return std::nullopt;
    if (second) one.inertia = element.inertia;
    one.numbers = {number};
    lift = one;
  }
  return lift;
}

void InertialModel::divide(const VectorX& anchor, const std::vector<bool>& matters) {
  const VectorX& base = context_.survey.base;
  std::vector<int> inner = inertial_numbers(context_);
  outer_ = geometric_numbers(context_);
  std::map<int, Lift> lifts;
  const std::vector<int> all = inner;
  const auto bends = [&](int i) {
    return std::any_of(all.begin(), all.end(), [&](int j) { return curved(i, j, base, matters); });
  };
  inner.clear();
  for (const int i : all) {
    const VectorX& moved = context_.survey.features[static_cast<std::size_t>(i)];
    if (same_numbers(moved, context_.survey.base_features)) {
      outer_.push_back(i);  // a motion's, if anything's
      continue;
    }
    const std::optional<Lift> lift = bends(i) ? lift_of(i, matters) : std::nullopt;
    if (!lift)
      inner.push_back(i);
    else if (const auto known = lifts.find(lift->first); known == lifts.end())
      lifts[lift->first] = *lift;
    else
      known->second.numbers.push_back(i);
  }
  for (auto& [first, lift] : lifts) {
    if (sample(lift, anchor))
      lifts_.push_back(lift);
    else
      outer_.insert(outer_.end(), lift.numbers.begin(), lift.numbers.end());
  }
  straighten(inner, matters);
  linear_ = inner;
  std::sort(outer_.begin(), outer_.end());
}

/// The number that bends most goes out, until the others are straight.
void InertialModel::straighten(std::vector<int>& inner, const std::vector<bool>& matters) {
  const VectorX& base = context_.survey.base;
  while (!inner.empty()) {
    std::vector<int> count(inner.size(), 0);
    for (std::size_t i = 0; i < inner.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        if (curved(inner[i], inner[j], base, matters)) count[i] += i == j ? 2 : 1, count[j] += i == j ? 0 : 1;
    const auto most = std::max_element(count.begin(), count.end());
    if (*most == 0) break;
    outer_.push_back(inner[static_cast<std::size_t>(most - count.begin())]);
    inner.erase(inner.begin() + (most - count.begin()));
  }
}

VectorX InertialModel::place(const Lift& lift, const VectorX& u) const {
  const VectorX f = features(u);
  return f.segment(lift.first + 1, dimension_) / f[lift.first];
}

/// Where the CoM may be. @return false if that depends on other numbers, or is too much to sample
bool InertialModel::sample(Lift& lift, const VectorX& anchor) const {
  const auto n = static_cast<int>(lift.numbers.size());
  if (n > most_grid_numbers) return false;
  const MatrixX points = grid(n);
  VectorX u = context_.survey.base, other = anchor;
  for (const int i : inertial_numbers(context_)) other[i] = std::max(0.3, std::abs(anchor[i]));
  lift.places.resize(dimension_, points.cols());
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    u(lift.numbers) = points.col(k);
    lift.places.col(k) = place(lift, u);
    if (!lift.places.col(k).allFinite()) return false;
  }
  other(lift.numbers) = points.col(0);
  lift.radius = max_abs(lift.places.colwise().norm());
  if (!((place(lift, other) - lift.places.col(0)).norm() < 1e-9 * lift.radius)) return false;
  lift.values = points;
  lift.directions = compass(dimension_);
  lift.reach = row_maxima(lift.directions * lift.places);
  lift.mass = std::max(std::abs(features(context_.survey.base)[lift.first]), 1e-12);
  return true;
}

std::optional<InertialTerms> InertialModel::at(const VectorX& u) const {
  VectorX base = u;
  for (const int i : linear_) base[i] = 0;
  for (const Lift& lift : lifts_) base(lift.numbers).setZero();
  const VectorX zero = features(base);
  if (!zero.allFinite()) return std::nullopt;
  MatrixX slopes = MatrixX::Zero(zero.size(), unknowns_);
  for (std::size_t k = 0; k < linear_.size(); ++k) {
    VectorX moved = base;
    moved[linear_[k]] = 1;
    slopes.col(static_cast<Eigen::Index>(k)) = features(moved) - zero;
  }
  if (!slopes.allFinite()) return std::nullopt;
  InertialTerms terms{slopes.topRows(terms_), zero.head(terms_), {}};
  ConeRows rows(unknowns_);
  const auto n = static_cast<Eigen::Index>(linear_.size());
  if (n > 0) {
    rows.at_most(MatrixX::Identity(n, unknowns_), VectorX::Ones(n));
    rows.at_most(-MatrixX::Identity(n, unknowns_), VectorX::Ones(n));
  }
  VectorX g;
  MatrixX dg;
  context_.physical.evaluate(zero, &slopes, g, &dg);
  for (Eigen::Index k = 0; k < g.size(); ++k) rows.at_most(VectorX(-dg.row(k).transpose()), g[k]);
  for (const Lift& lift : lifts_) put(lift, zero, slopes, terms);
  for (const Lift& lift : lifts_) limit(lift, terms, zero, slopes, rows);
  terms.limits = rows.finish(VectorX::Zero(unknowns_));
  return terms;
}

std::vector<Eigen::Index> InertialModel::massless(const InertialTerms& terms, const VectorX& upper) const {
  std::vector<Eigen::Index> none;
  const Box& box = context_.box;
  for (const Lift& lift : lifts_) {
    double most = terms.constant[lift.first];
    for (std::size_t k = 0; k < linear_.size(); ++k) {
      const double slope = terms.matrix(lift.first, static_cast<Eigen::Index>(k));
      const int i = linear_[k];
      const double high = box.half()[i] > 0 ? std::min(1.0, (upper[i] - box.centre()[i]) / box.half()[i]) : 0.0;
      most += std::max(-slope, slope * high);
    }
    if (most > 1e-12 * lift.mass) continue;
    const int count = dimension_ + (lift.inertia >= 0 ? 1 : 0);
    for (int k = 0; k < count; ++k) none.push_back(lift.unknown + k);
  }
  return none;
}

/// The element's first moment and inertia from its own unknowns, which are measured in mass · radius (²).
void InertialModel::put(const Lift& lift, const VectorX& zero, const MatrixX& slopes, InertialTerms& terms) const {
  for (int d = 0; d < dimension_; ++d) {
    const int row = lift.first + 1 + d;
    terms.matrix.row(row).setZero();
    terms.matrix(row, lift.unknown + d) = lift.mass * lift.radius;
    terms.constant[row] = 0;
  }
  if (lift.inertia < 0) return;
  const int row = lift.first + 1 + dimension_;
  terms.matrix.row(row) = slopes.row(lift.inertia);
  terms.matrix(row, lift.unknown + dimension_) = lift.mass * lift.radius * lift.radius;
  terms.constant[row] = zero[lift.inertia];
}

/// h in the cone over all places, |h|²/m no more than what it adds to the inertia, which is no more than m r².
void InertialModel::limit(const Lift& lift, const InertialTerms& terms, const VectorX& zero, const MatrixX& slopes,
                          ConeRows& rows) const {
  const VectorX mass = slopes.row(lift.first).transpose() / lift.mass;
  const double least = zero[lift.first] / lift.mass;
  for (Eigen::Index k = 0; k < lift.directions.rows(); ++k) {
    VectorX row = -lift.reach[k] / lift.radius * mass;
    row.segment(lift.unknown, dimension_) += lift.directions.row(k).transpose();
    rows.at_most(row, lift.reach[k] / lift.radius * least);
  }
  MatrixX cone = MatrixX::Zero(1 + dimension_, terms.matrix.cols());
  VectorX constant = VectorX::Zero(1 + dimension_);
  cone.row(0) = mass.transpose();
  constant[0] = least;
  cone.block(1, lift.unknown, dimension_, dimension_).setIdentity();
  rows.in_cone(cone, constant);
  if (lift.inertia < 0) return;
  const int q = lift.unknown + dimension_;
  VectorX upper = -mass;
  upper[q] += 1;
  rows.at_most(upper, least);
  // (q + m)² ≥ |2 h|² + (q − m)²
  MatrixX rotated = MatrixX::Zero(2 + dimension_, terms.matrix.cols());
  VectorX shift = VectorX::Zero(2 + dimension_);
  rotated.row(0) = mass.transpose();
  rotated.row(1) = -mass.transpose();
  rotated(0, q) += 1;
  rotated(1, q) += 1;
  shift[0] = least;
  shift[1] = -least;
  rotated.block(2, lift.unknown, dimension_, dimension_) = 2 * MatrixX::Identity(dimension_, dimension_);
  rows.in_cone(rotated, shift);
}

VectorX InertialModel::recovered(const VectorX& u, const VectorX& unknowns) const {
  VectorX all = u;
  for (std::size_t k = 0; k < linear_.size(); ++k)
    all[linear_[k]] = std::clamp(unknowns[static_cast<Eigen::Index>(k)], -1.0, 1.0);
  for (const Lift& lift : lifts_) {
    const double mass = features(all)[lift.first];
    if (!(mass > 1e-9 * lift.mass)) continue;
    const VectorX target = unknowns.segment(lift.unknown, dimension_) * (lift.mass * lift.radius / mass);
    const Eigen::Index nearest = min_index((lift.places.colwise() - target).colwise().norm());
    Equations equations;
    equations.conditions = equations.rows = dimension_;
    const auto off = [&](const VectorX& v) {
      VectorX moved = all;
      moved(lift.numbers) = v;
      return VectorX((place(lift, moved) - target) / lift.radius);
    };
    equations.evaluate = [&](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      values = off(v);
      if (jacobian != nullptr) *jacobian = central_differences(off, v, dimension_);
      return values.allFinite();
    };
    all(lift.numbers) = gauss_newton(equations, lift.values.col(nearest), 20).u;
  }
  return all;
}

}  // namespace balance::designing
