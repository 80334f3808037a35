#include "balance/synthesis/design/length_ratio_bound.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/box_least_squares.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::design {

// The squared length z of a spring at a sample is linear in features F of its ends. With the mean z̄ over the samples,
// η = z/z̄ and κ = ε/√z̄ the effort is
//   y = y₀ + S V − S_η Z,   Z = κ V,   S_η = S/√η by samples,                                                  (1)
// linear in V and Z, and S_η depends on the shape of the motion only: neither on stiffness and free length nor on the
// size of the places. With D = V − Z
//   y = y₀ + S D + (S − S_η) Z.                                                                                (2)
// Springs that balance a weight well have D near −S⁺ y₀, along a curve of places. ‖y‖ ≤ cutoff and (2) give D; from
// V = D/(1 − κ), Z = κ V and V = k f(x) follow ranges of κ and of the places (Benhamou and others 1999). A direction u
// in the space of samples gives the bound
//   ‖y‖ ‖u‖ ≥ ⟨u, y⟩ = ⟨u, y₀⟩ + ⟨u, S⟩ D + (⟨u, S⟩ − ⟨u, S_η⟩) Z,                                            (3)
// where ⟨u, S_η⟩ is a function of the features F/z̄ alone, enclosed by its second-order Taylor polynomial with the
// remainder of (1 + t)^(−1/2): sums over the samples cancel in it as they do at a point. u orthogonal to S makes D
// vanish from (3): what remains is the part of the weight that no force of a fixed shape balances. Mean value forms of y
// itself do not see this cancellation and need boxes whose squared size is small compared with ‖y‖/‖y₀‖.

SpringSeries::SpringSeries(Eigen::Index components_, bool is_peak_, const VectorX& time_weights, VectorX constant_,
                           const std::vector<MatrixX>& per_spring, const std::vector<SquaredLengths>& lengths)
    : components(components_), is_peak(is_peak_), constant(std::move(constant_)), weights(constant.size()) {
  for (Eigen::Index i = 0; i < weights.size(); ++i) weights[i] = time_weights[i / components];
  Eigen::Index columns = 0;
  for (std::size_t s = 0; s < per_spring.size(); ++s) {
    Part part;
    for (Eigen::Index f = 0; f < per_spring[s].cols(); ++f)
      if ((per_spring[s].col(f).array() != 0).any()) part.features.push_back(static_cast<int>(f));
    part.rows.resize(constant.size(), static_cast<Eigen::Index>(part.features.size()));
    for (std::size_t f = 0; f < part.features.size(); ++f)
      part.rows.col(static_cast<Eigen::Index>(f)) = per_spring[s].col(part.features[f]);
    part.lengths = lengths[s];
    columns += part.rows.cols();
    parts.push_back(std::move(part));
  }
  rows.resize(constant.size(), columns);
  columns = 0;
  for (const Part& part : parts) {
    rows.middleCols(columns, part.rows.cols()) = part.rows;
    columns += part.rows.cols();
  }
  if (columns == 0) return;
  // features that matter differ in size: scaled to unit columns before the test of rank
  const MatrixX normal = rows.transpose() * weights.asDiagonal() * rows;
  const VectorX scale = normal.diagonal().cwiseSqrt();
  if (!(numerics::min_coefficient(scale) > 0)) return;
  const MatrixX scaled = scale.cwiseInverse().asDiagonal() * normal * scale.cwiseInverse().asDiagonal();
  const Eigen::LDLT<MatrixX> factors(scaled);
  constexpr double rank_tolerance = 1e-9;
  if (!(numerics::min_coefficient(VectorX(factors.vectorD())) > rank_tolerance)) return;
  inverse = scale.cwiseInverse().asDiagonal() * factors.solve(MatrixX::Identity(columns, columns)) *
            scale.cwiseInverse().asDiagonal();
}

PlaceRange::PlaceRange(const VectorX& half) {
  for (const double h : half) delta_.emplace_back(-h, h);
}

namespace {

/// Adds what rounding may have moved. False: the two do not meet.
bool narrow_to(Interval& range, const Interval& other) {
  const double margin = 1e-12 * (std::abs(range.lower) + std::abs(range.upper)) + 1e-300;
  if (other.lower > range.upper + margin || other.upper < range.lower - margin) return false;
  const double lower = std::max(range.lower, std::min(other.lower, range.upper)),
               upper = std::min(range.upper, std::max(other.upper, range.lower));
  range = {std::min(lower, upper), std::max(lower, upper)};
  return true;
}

bool contains_zero(const Interval& x) { return x.lower <= 0 && x.upper >= 0; }

}  // namespace

bool PlaceRange::narrow(const BoxForm& form, const Interval& middle, const Interval& target) {
  const std::size_t n = delta_.size();
  Interval total = middle;
  std::array<Interval, max_places> terms;
  for (std::size_t j = 0; j < n; ++j) total = total + (terms[j] = form.gradient[j] * delta_[j]);
  if (target.lower > total.upper || target.upper < total.lower) return false;
  if (target.lower <= total.lower && target.upper >= total.upper) return true;
  for (std::size_t j = 0; j < n; ++j) {
    if (delta_[j].is_point() || contains_zero(form.gradient[j])) continue;
    Interval rest = target - middle;
    for (std::size_t i = 0; i < n; ++i)
      if (i != j) rest = rest - terms[i];
    if (!narrow_to(delta_[j], rest / form.gradient[j])) return false;
    terms[j] = form.gradient[j] * delta_[j];
  }
  return true;
}

namespace {

/// A spring's shape over a box, and ranges of the unknowns of (1) and (2).
struct RatioPart {
  std::vector<int> active;                             ///< features of the lengths that matter
  std::vector<double> middle;                          ///< F/z̄ at the middle, of active features
  std::vector<Interval> deviation;                     ///< F/z̄ less that
  std::vector<std::array<double, max_places>> slopes;  ///< of F/z̄ by the places, about
  std::array<double, max_places> mean_slopes{};        ///< of z̄
  Interval mean, ratio;                                ///< z̄, κ
  double middle_mean = 1;
  VectorX eta;  ///< at the middle, by sample
  std::vector<Interval> eta_deviation;
  VectorX inverse_root, root_radius;  ///< of η^(−1/2): middle and radius
  std::vector<Interval> V, Z, D;
  Eigen::Index first = 0;  ///< of its columns in SpringSeries::rows
};

/// @return false if nothing can be said
bool describe_shape(const SpringSeries::Part& part, const SpringRange& spring, const PlaceRange& places,
                    RatioPart& out) {
  const MatrixX& T = part.lengths.rows;
  const auto at = [](std::size_t f) { return static_cast<Eigen::Index>(f); };
  const std::size_t n = places.ranges().size();
  Interval mean(0.0), natural(0.0);
  std::array<Interval, max_places> mean_gradient;
  out.middle_mean = 0;
  for (std::size_t f = 0; f < spring.features.size(); ++f) {
    const BoxForm& F = spring.features[f];
    if ((F.value.is_point() && F.value.lower == 0) || !(T.col(at(f)).array() != 0).any()) continue;
    out.active.push_back(static_cast<int>(f));
    const double factor = part.lengths.mean[at(f)];
    mean = mean + F.value * factor;
    out.middle_mean += spring.middle_features[f] * factor;
    for (std::size_t j = 0; j < n; ++j) mean_gradient[j] = mean_gradient[j] + F.gradient[j] * factor;
  }
  for (const Interval& square : spring.squares) natural = natural + square * (1.0 / static_cast<double>(T.rows()));
  if (!narrow_to(mean, natural)) return false;
  Interval by_slopes = out.middle_mean;
  for (std::size_t j = 0; j < n; ++j) by_slopes = by_slopes + mean_gradient[j] * places.ranges()[j];
  if (!narrow_to(mean, by_slopes) || !(mean.lower > 0)) return false;
  out.mean = mean;
  for (std::size_t j = 0; j < n; ++j) out.mean_slopes[j] = mean_gradient[j].middle();
  const Interval inverse_mean = inverse(mean);
  std::vector<std::array<Interval, max_places>> gradients;
  for (const int f : out.active) {
    const BoxForm& F = spring.features[static_cast<std::size_t>(f)];
    const double middle = spring.middle_features[static_cast<std::size_t>(f)] / out.middle_mean;
    Interval value = F.value * inverse_mean, mean_value = middle;
    std::array<Interval, max_places> gradient;
    std::array<double, max_places> slopes{};
    for (std::size_t j = 0; j < n; ++j) {
      gradient[j] = (F.gradient[j] - value * mean_gradient[j]) * inverse_mean;
      slopes[j] = gradient[j].middle();
      mean_value = mean_value + gradient[j] * places.ranges()[j];
    }
    if (!narrow_to(value, mean_value)) return false;
    out.middle.push_back(middle);
    out.deviation.push_back(value - middle);
    out.slopes.push_back(slopes);
    gradients.push_back(gradient);
  }
  out.eta.resize(T.rows()), out.inverse_root.resize(T.rows()), out.root_radius.resize(T.rows());
  for (Eigen::Index i = 0; i < T.rows(); ++i) {
    double eta = 0;
    Interval deviation(0.0), by_places(0.0);
    std::array<Interval, max_places> slope;
    for (std::size_t f = 0; f < out.active.size(); ++f) {
      const double factor = T(i, out.active[f]);
      eta += factor * out.middle[f];
      deviation = deviation + out.deviation[f] * factor;
      for (std::size_t j = 0; j < n; ++j) slope[j] = slope[j] + gradients[f][j] * factor;
    }
    for (std::size_t j = 0; j < n; ++j) by_places = by_places + slope[j] * places.ranges()[j];
    const Interval direct = spring.squares[static_cast<std::size_t>(i)] * inverse_mean - eta;
    if (!narrow_to(deviation, by_places) || !narrow_to(deviation, direct)) return false;
    const Interval range = deviation + eta;
    if (!(range.lower > 0) || !(eta > 0)) return false;
    const Interval root = inverse(sqrt(range));
    out.eta[i] = eta;
    out.eta_deviation.push_back(deviation);
    out.inverse_root[i] = root.middle(), out.root_radius[i] = 0.5 * root.width();
  }
  out.ratio = spring.free_length.value * inverse(sqrt(mean));
  for (const BoxForm& force : spring.forces) {
    out.V.push_back(force.value);
    out.Z.push_back(out.ratio * force.value);
    out.D.push_back((Interval(1.0) - out.ratio) * force.value);
  }
  return true;
}

/// Z = κ V, D = (1 − κ) V in all directions.
bool narrow_products(RatioPart& part) {
  for (std::size_t f = 0; f < part.V.size(); ++f) {
    const Interval rest = Interval(1.0) - part.ratio;
    if (!narrow_to(part.D[f], rest * part.V[f])) return false;
    if (!contains_zero(rest) && !narrow_to(part.V[f], part.D[f] / rest)) return false;
    if (!contains_zero(part.V[f]) && !narrow_to(part.ratio, Interval(1.0) - part.D[f] / part.V[f])) return false;
    if (!narrow_to(part.Z[f], part.ratio * part.V[f])) return false;
  }
  return true;
}

/// The problem (2) about the middles of D and Z.
struct RatioModel {
  MatrixX B;
  VectorX a, e, half;
  Eigen::Index unknowns = 0;  ///< D, then as many Z
};

RatioModel make_model(const SpringSeries& series, const std::vector<RatioPart>& parts) {
  RatioModel model;
  const Eigen::Index rows = series.constant.size(), m = series.rows.cols();
  model.unknowns = m;
  model.B.resize(rows, 2 * m);
  model.B.leftCols(m) = series.rows;
  model.a = series.constant;
  model.e = VectorX::Zero(rows);
  model.half.resize(2 * m);
  VectorX middle(2 * m);
  for (std::size_t s = 0; s < parts.size(); ++s) {
    const RatioPart& part = parts[s];
    const MatrixX& S = series.parts[s].rows;
    for (Eigen::Index f = 0; f < S.cols(); ++f) {
      const Interval& D = part.D[static_cast<std::size_t>(f)];
      const Interval& Z = part.Z[static_cast<std::size_t>(f)];
      middle[part.first + f] = D.middle(), middle[m + part.first + f] = Z.middle();
      model.half[part.first + f] = 0.5 * D.width(), model.half[m + part.first + f] = 0.5 * Z.width();
    }
    for (Eigen::Index i = 0; i < rows; ++i) {
      const Eigen::Index sample = i / series.components;
      double centre = 0, reach = 0;
      for (Eigen::Index f = 0; f < S.cols(); ++f) {
        model.B(i, m + part.first + f) = (1 - part.inverse_root[sample]) * S(i, f);
        centre += S(i, f) * middle[m + part.first + f];
        reach += std::abs(S(i, f)) * model.half[m + part.first + f];
      }
      model.e[i] += part.root_radius[sample] * (std::abs(centre) + reach);
    }
  }
  model.a += model.B * middle;
  return model;
}

double norm(const VectorX& weights, const VectorX& y) { return std::sqrt(y.cwiseAbs2().dot(weights)); }

/// Ranges of D from ‖y‖ ≤ cutoff.
bool narrow_forces(const SpringSeries& series, const RatioModel& model, double cutoff, std::vector<RatioPart>& parts) {
  const Eigen::Index m = model.unknowns;
  const VectorX uncertain = model.e + model.B.rightCols(m).cwiseAbs() * model.half.tail(m);
  const double reach = (cutoff + norm(series.weights, uncertain)) * (1 + 1e-12);
  const VectorX c = series.rows.transpose() * series.weights.cwiseProduct(model.a);
  const VectorX step = -(series.inverse * c);
  const double least = model.a.cwiseAbs2().dot(series.weights) + c.dot(step);
  const double square = reach * reach - std::max(least, 0.0);
  if (square < -1e-12 * model.a.cwiseAbs2().dot(series.weights)) return false;
  for (RatioPart& part : parts)
    for (std::size_t f = 0; f < part.D.size(); ++f) {
      const Eigen::Index j = part.first + static_cast<Eigen::Index>(f);
      const double radius = std::sqrt(std::max(square, 0.0) * series.inverse(j, j)) * (1 + 1e-12);
      const double middle = part.D[f].middle() + step[j];
      const double margin = radius + 1e-12 * std::abs(middle);
      if (!narrow_to(part.D[f], {middle - margin, middle + margin})) return false;
    }
  return true;
}

/// Σ w_i η_i^(−1/2) over the box, enclosed.
struct ShapeSum {
  Interval value;
  double remainder = 0;
  VectorX slopes;  ///< by the active features
};

ShapeSum enclose_sum(const RatioPart& part, const MatrixX& T, const VectorX& w) {
  const std::size_t count = part.active.size();
  const auto size = static_cast<Eigen::Index>(count);
  ShapeSum sum;
  sum.slopes = VectorX::Zero(size);
  MatrixX curvature = MatrixX::Zero(size, size);
  VectorX row(size);
  double constant = 0, magnitude = 0;
  for (Eigen::Index i = 0; i < w.size(); ++i) {
    const double eta = part.eta[i], root = 1 / std::sqrt(eta);
    const Interval& deviation = part.eta_deviation[static_cast<std::size_t>(i)];
    for (std::size_t f = 0; f < count; ++f) row[static_cast<Eigen::Index>(f)] = T(i, part.active[f]);
    constant += w[i] * root;
    magnitude += std::abs(w[i]) * root;
    sum.slopes += (-0.5 * w[i] * root / eta) * row;
    const double bend = 0.375 * w[i] * root / (eta * eta);
    for (Eigen::Index j = 0; j < size; ++j) curvature.col(j).tail(size - j) += bend * row[j] * row.tail(size - j);
    const double least = eta + deviation.lower, most = deviation.magnitude();
    // |third derivative|/6 of t^(−1/2) is 5/16 t^(−7/2)
    sum.remainder += std::abs(w[i]) * 0.3125 / (least * least * least * std::sqrt(least)) * most * most * most;
  }
  sum.remainder += 1e-14 * static_cast<double>(w.size()) * magnitude;
  Interval value = constant;
  for (std::size_t f = 0; f < count; ++f) {
    const auto j = static_cast<Eigen::Index>(f);
    value = value + part.deviation[f] * sum.slopes[j] + square(part.deviation[f]) * curvature(j, j);
    for (std::size_t g = 0; g < f; ++g)
      value = value + part.deviation[f] * part.deviation[g] * (2 * curvature(j, static_cast<Eigen::Index>(g)));
  }
  sum.value = value + Interval(-sum.remainder, sum.remainder);
  return sum;
}

/// (3) with a direction, and what its uncertainty is due to.
double bound_by_direction(const SpringSeries& series, const std::vector<RatioPart>& parts, const VectorX& direction,
                          const VectorX& Z0, const std::vector<SpringRange>& springs, const PlaceRange& places,
                          LengthRatioBound* scores) {
  const VectorX wu = series.weights.cwiseProduct(direction);
  double size = 0;
  if (series.is_peak)  // |⟨u, y⟩| ≤ Σ w |u| · the largest |y|
    for (Eigen::Index i = 0; i < wu.size(); i += series.components) size += wu.segment(i, series.components).norm();
  else
    size = norm(series.weights, direction);
  if (!(size > 0)) return 0;
  const auto sum_components = [&](const VectorX& row) {
    VectorX out(row.size() / series.components);
    for (Eigen::Index i = 0; i < out.size(); ++i) out[i] = row.segment(i * series.components, series.components).sum();
    return out;
  };
  Interval total = wu.dot(series.constant);
  for (std::size_t s = 0; s < parts.size(); ++s) {
    const RatioPart& part = parts[s];
    const MatrixX& S = series.parts[s].rows;
    const MatrixX& T = series.parts[s].lengths.rows;
    const VectorX factors = S.transpose() * wu, own = Z0.segment(part.first, S.cols());
    const ShapeSum combined = enclose_sum(part, T, sum_components(wu.cwiseProduct(S * own)));
    Interval about = Interval(factors.dot(own)) - combined.value, direct(0.0);
    for (Eigen::Index f = 0; f < S.cols(); ++f) {
      const auto g = static_cast<std::size_t>(f);
      total = total + part.D[g] * factors[f];
      const Interval slope =
          Interval(factors[f]) - enclose_sum(part, T, sum_components(wu.cwiseProduct(S.col(f)))).value;
      about = about + slope * (part.Z[g] - own[f]);
      direct = direct + slope * part.Z[g];
    }
    narrow_to(about, direct);
    total = total + about;
    if (scores == nullptr) continue;
    // shares of the places: by the size of V, by z̄, and by the shape
    const double effect = combined.value.magnitude();
    double force = 0;
    for (const Interval& middle : springs[s].middle_forces) force += square(middle).upper;
    const double free_length = std::max(springs[s].free_length.value.magnitude(), 1e-3 * std::sqrt(part.mean.upper));
    VectorX shape = VectorX::Zero(scores->score.size());
    double shapes = 0;
    for (Eigen::Index j = 0; j < scores->score.size(); ++j) {
      const auto v = static_cast<std::size_t>(j);
      const double half = 0.5 * places.ranges()[v].width();
      double change = 0, slope = 0;
      for (const BoxForm& V : springs[s].forces) change += V.gradient[v].middle() * V.gradient[v].middle();
      for (std::size_t f = 0; f < part.active.size(); ++f) {
        slope += combined.slopes[static_cast<Eigen::Index>(f)] * part.slopes[f][v];
        shape[j] += std::abs(part.slopes[f][v]) * half;
      }
      shapes += shape[j];
      scores->score[j] +=
          (std::abs(slope) * half +
           effect * half *
               (std::sqrt(change / (force + 1e-300)) + 0.5 * std::abs(part.mean_slopes[v]) / part.middle_mean +
                std::abs(springs[s].free_length.gradient[v].middle()) / free_length)) /
          size;
    }
    if (shapes > 0) scores->score += 3 * combined.remainder / (shapes * size) * shape;
    scores->part_score[static_cast<Eigen::Index>(s)] += effect / size;
  }
  return std::max({total.lower, -total.upper, 0.0}) / size * (1 - 1e-12);
}

}  // namespace

LengthRatioBound bound_by_length_ratios(const SpringSeries& series, const std::vector<SpringRange>& springs,
                                        double cutoff, PlaceRange& places) {
  LengthRatioBound result;
  result.score = VectorX::Zero(static_cast<Eigen::Index>(places.ranges().size()));
  result.part_score = VectorX::Zero(static_cast<Eigen::Index>(springs.size()));
  std::vector<RatioPart> parts(springs.size());
  Eigen::Index first = 0;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    parts[s].first = first;
    first += series.parts[s].rows.cols();
    if (!describe_shape(series.parts[s], springs[s], places, parts[s])) return result;
  }
  result.is_feasible = false;
  constexpr int max_rounds = 2;
  for (int round = 0; round < max_rounds && series.inverse.size() > 0; ++round) {
    if (!narrow_forces(series, make_model(series, parts), cutoff, parts)) return result;
    for (RatioPart& part : parts)
      if (!narrow_products(part)) return result;
  }
  for (std::size_t s = 0; s < springs.size(); ++s) {
    for (std::size_t f = 0; f < springs[s].forces.size(); ++f)
      if (!places.narrow(springs[s].forces[f], springs[s].middle_forces[f], parts[s].V[f])) return result;
    if (!places.narrow(springs[s].free_length, springs[s].middle_free_length, parts[s].ratio * sqrt(parts[s].mean)))
      return result;
  }
  result.is_feasible = true;
  const RatioModel model = make_model(series, parts);
  const Eigen::Index m = model.unknowns;
  const MatrixX weighted = series.weights.asDiagonal() * model.B;
  const MatrixX Q = model.B.transpose() * weighted;
  const VectorX c = weighted.transpose() * model.a;
  VectorX delta = VectorX::Zero(2 * m);
  minimise_in_box(Q, c, model.half, delta);
  const VectorX product = Q * delta;
  const double value = model.a.cwiseAbs2().dot(series.weights) + 2 * c.dot(delta) + delta.dot(product);
  const double least = box_lower_bound(value, 2 * (product + c), delta, model.half);
  result.lower = std::max(0.0, std::sqrt(std::max(0.0, least)) - norm(series.weights, model.e));
  VectorX Z0(m);
  for (const RatioPart& part : parts)
    for (std::size_t f = 0; f < part.Z.size(); ++f) {
      const Eigen::Index j = part.first + static_cast<Eigen::Index>(f);
      Z0[j] = part.Z[f].middle() + delta[m + j];
    }
  const VectorX residual = model.a + model.B * delta;
  const bool has_inverse = series.inverse.size() > 0;
  if (has_inverse) {
    const VectorX orthogonal =
        residual - series.rows * (series.inverse * (series.rows.transpose() * series.weights.cwiseProduct(residual)));
    result.lower = std::max(result.lower, bound_by_direction(series, parts, orthogonal, Z0, springs, places, &result));
  }
  // the residual itself is better in small boxes only
  constexpr double near_share = 0.7;
  if (!has_inverse || (result.lower > near_share * cutoff && result.lower < cutoff))
    result.lower = std::max(result.lower, bound_by_direction(series, parts, residual, Z0, springs, places,
                                                             has_inverse ? nullptr : &result));
  return result;
}

}  // namespace balance::design
