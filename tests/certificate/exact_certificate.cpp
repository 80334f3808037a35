#include "exact_certificate.hpp"

#include <boost/multiprecision/cpp_int.hpp>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <vector>

using namespace balance;
using namespace balance::certificate;

namespace {

using Rational = boost::multiprecision::cpp_rational;
using Exponents = std::vector<int>;
using Polynomial = std::map<Exponents, Rational>;

Polynomial sum(Polynomial a, const Polynomial& b, const Rational& factor = 1) {
  for (const auto& [exponents, coefficient] : b) a[exponents] += factor * coefficient;
  return a;
}

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial result;
  for (const auto& [x, u] : a)
    for (const auto& [y, v] : b) {
      Exponents exponents = x;
      for (std::size_t i = 0; i < exponents.size(); ++i) exponents[i] += y[i];
      result[exponents] += u * v;
    }
  return result;
}

Polynomial exact(const LengthPolynomial& p) {
  Polynomial result;
  for (const auto& [exponents, coefficient] : p.terms()) result[exponents] += Rational(coefficient.real());
  return result;
}

Rational binomial(int n, int k) {
  Rational value = 1;
  for (int i = 1; i <= k; ++i) value = value * (n - k + i) / i;
  return value;
}

Rational raised(const Rational& x, int n) {
  Rational value = 1;
  for (int i = 0; i < n; ++i) value *= x;
  return value;
}

class Box {
 public:
  explicit Box(const LengthBox& box) : box_(box) {}

  std::size_t size() const { return static_cast<std::size_t>(box_.lower.size()); }
  Rational lower(std::size_t i) const { return Rational(box_.lower[static_cast<Eigen::Index>(i)]); }
  Rational width(std::size_t i) const { return Rational(box_.upper[static_cast<Eigen::Index>(i)]) - lower(i); }

  Polynomial constant(const Rational& value) const { return {{Exponents(size(), 0), value}}; }
  /// 2t − 1 of a length.
  Polynomial centred(std::size_t i) const {
    Exponents linear(size(), 0);
    linear[i] = 1;
    Polynomial p = constant(-2 * lower(i) / width(i) - 1);
    p[linear] = 2 / width(i);
    return p;
  }
  /// Smallest Bernstein coefficient, in the degrees of `shape` or higher.
  Rational smallest(const Polynomial& p, const Polynomial& shape) const {
    const Polynomial all = coefficients(p, degrees_of({&p, &shape}));
    Rational least = all.begin()->second;
    for (const auto& [index, coefficient] : all) least = std::min(least, coefficient);
    return least;
  }
  std::vector<int> degrees_of(const std::vector<const Polynomial*>& polynomials) const {
    std::vector<int> degrees(size(), 0);
    for (const Polynomial* one : polynomials)
      for (const auto& [exponents, coefficient] : *one)
        for (std::size_t i = 0; i < size(); ++i) degrees[i] = std::max(degrees[i], exponents[i]);
    return degrees;
  }
  /// All Bernstein coefficients of given degrees, by their indices.
  Polynomial coefficients(Polynomial p, const std::vector<int>& degrees) const {
    for (std::size_t axis = 0; axis < size(); ++axis) {
      if (degrees[axis] == 0) continue;
      Polynomial converted;
      for (const auto& [exponents, coefficient] : p)
        for (int i = 0; i <= degrees[axis]; ++i) {
          Exponents index = exponents;
          index[axis] = i;
          for (int j = 0; j <= std::min(i, exponents[axis]); ++j)
            converted[index] += coefficient * binomial(i, j) / binomial(degrees[axis], j) *
                                binomial(exponents[axis], j) * raised(lower(axis), exponents[axis] - j) *
                                raised(width(axis), j);
        }
      p = std::move(converted);
    }
    std::vector<Exponents> indices{Exponents(size(), 0)};
    for (std::size_t axis = 0; axis < size(); ++axis)
      for (std::size_t n = indices.size(); n-- > 0;)
        for (int i = 1; i <= degrees[axis]; ++i) {
          indices.push_back(indices[n]);
          indices.back()[axis] = i;
        }
    for (const Exponents& index : indices) p.emplace(index, 0);
    return p;
  }

 private:
  const LengthBox& box_;
};

class Checker {
 public:
  Checker(const LengthBox& box, double bound, const BoxCertificate& multipliers, const LengthGeometry& geometry)
      : bound_(bound), multipliers_(multipliers), geometry_(geometry), box_(box) {}

  std::string find_flaw() const {
    const BoxCertificate& multipliers = multipliers_;
    Polynomial objective = exact(geometry_.dual.fixed_size);
    const Polynomial scale = exact(geometry_.dual.fixed_masses.scale);
    if (box_.smallest(scale, {}) <= 0) return "the objective's scale may vanish";
    objective = sum(objective, height(geometry_.dual.fixed_masses), -1);
    for (std::size_t i = 0; i < geometry_.linkage.counterweights.size(); ++i) {
      const std::string flaw = find_counterweight_flaw(i);
      if (!flaw.empty()) return geometry_.linkage.counterweights[i].name + ": " + flaw;
      if (multipliers.limit_index[i] >= 0) objective = sum(objective, product(scale, limit(i)));
    }
    for (std::size_t i = 0; i < geometry_.linkage.inertias.size(); ++i) {
      const std::string flaw = find_inertia_flaw(i);
      if (!flaw.empty()) return geometry_.linkage.inertias[i].name + ": " + flaw;
      objective = sum(objective, product(scale, limit(geometry_.linkage.counterweights.size() + i)));
    }
    for (std::size_t c = 0; c < multipliers.conditions.size(); ++c) {
      const LengthCondition& condition = geometry_.conditions[static_cast<std::size_t>(multipliers.conditions[c])];
      const Rational multiplier(multipliers.condition_multipliers[static_cast<Eigen::Index>(c)]);
      if (!condition.is_equality && multiplier < 0) return "a condition has a negative multiplier";
      objective = sum(objective, exact(condition.polynomial), -multiplier);
    }
    objective = sum(objective, scale, -Rational(bound_));
    return box_.smallest(objective, objective_shape()) >= 0 ? "" : "the objective may be less than the bound";
  }

 private:
  /// A term with the degrees in which the multipliers were chosen: a condition may have higher ones than the objective,
  /// and coefficients of higher degrees are nearer to the polynomial.
  Polynomial objective_shape() const {
    Exponents degrees(box_.size(), 0);
    const auto raise = [&](const LengthPolynomial& p) {
      for (const auto& [exponents, coefficient] : p.terms())
        for (std::size_t i = 0; i < degrees.size(); ++i) degrees[i] = std::max(degrees[i], exponents[i]);
    };
    raise(geometry_.dual.fixed_size);
    raise(geometry_.dual.fixed_masses.scale);
    for (const LengthPolynomial& p : geometry_.dual.fixed_masses.coefficients) raise(p);
    for (const LengthCondition& condition : geometry_.conditions) raise(condition.polynomial);
    for (const int length : multipliers_.affine) ++degrees[static_cast<std::size_t>(length)];
    return {{degrees, Rational(0)}};
  }

  /// Constant part and those of the affine lengths.
  Polynomial multiplier(Eigen::Index column) const {
    Polynomial p = box_.constant(Rational(multipliers_.multipliers(0, column)));
    for (std::size_t a = 0; a < multipliers_.affine.size(); ++a)
      p = sum(p, box_.centred(static_cast<std::size_t>(multipliers_.affine[a])),
              Rational(multipliers_.multipliers(static_cast<Eigen::Index>(a) + 1, column)));
    return p;
  }
  /// @param element of the counterweights, then the inertias
  Polynomial limit(std::size_t element) const {
    return multiplier(multipliers_.unknowns + multipliers_.limit_index[element]);
  }
  Polynomial height(const VirtualHeight& virtual_height) const {
    Polynomial p;
    for (std::size_t j = 0; j < virtual_height.coefficients.size(); ++j)
      p = sum(p, product(exact(virtual_height.coefficients[j]), multiplier(static_cast<Eigen::Index>(j))));
    return p;
  }

  std::string find_counterweight_flaw(std::size_t i) const {
    const MassLimits& limits = multipliers_.mass_limits[i];
    const bool has_limit = multipliers_.limit_index[i] >= 0;
    if (limits.is_left_out()) return has_limit ? "σ without a counterweight" : "";
    const bool has_upper = limits.is_upper_used;
    if (geometry_.linkage.balances_moments) return find_placed_flaw(i);
    for (const VirtualHeight& corner : geometry_.dual.corners[i]) {
      const Polynomial scale = exact(corner.scale);
      if (box_.smallest(scale, {}) <= 0) return "a scale may vanish";
      const Polynomial slack = sum(scale, height(corner), -1);
      // without the upper limit, the mass may be as large as it likes: h ≤ 1
      if (!has_upper && box_.smallest(slack, {}) < 0) return "a corner may be higher than 1";
      if (!has_limit) continue;
      const auto exceeds = [&](double mass) {
        const Polynomial room = sum(product(slack, box_.constant(Rational(mass))), product(scale, limit(i)), -1);
        return box_.smallest(room, {}) < 0;
      };
      if (has_upper && exceeds(limits.upper)) return "σ exceeds its upper limit";
      if (exceeds(limits.lower)) return "σ exceeds its lower limit";
    }
    return {};
  }

  /// Whether scale · (limit · (cost − h) − σ) ≥ 0 at all places and in all ratios: per Bernstein coefficient, exactly.
  /// @param limit none: cost − h ≥ 0
  bool holds_everywhere(const PlacedHeight& placed, const std::array<int, 3>& numbers, int cost,
                        const std::optional<double>& limit, const Polynomial& sigma) const {
    const Polynomial scale = exact(placed.scale), amount = box_.constant(limit ? Rational(*limit) : Rational(1));
    std::array<Polynomial, PlacedHeight::count> parts;
    parts[0] = product(scale, product(amount, box_.constant(cost)));
    if (limit) parts[0] = sum(parts[0], product(scale, sigma), -1);
    Polynomial shape = sum(scale, {});
    for (std::size_t f = 0; f < PlacedHeight::count; ++f)
      for (std::size_t j = 0; j < placed.coefficients[f].size(); ++j) {
        const Polynomial coefficient = exact(placed.coefficients[f][j]);
        for (const auto& [exponents, value] : coefficient) shape.emplace(exponents, 0);
        parts[f] = sum(parts[f], product(amount, product(coefficient, multiplier(static_cast<Eigen::Index>(j)))), -1);
      }
    std::vector<int> degrees = box_.degrees_of({&shape});
    for (const int length : multipliers_.affine) ++degrees[static_cast<std::size_t>(length)];
    std::array<Polynomial, PlacedHeight::count> coefficients;
    for (std::size_t f = 0; f < PlacedHeight::count; ++f) coefficients[f] = box_.coefficients(parts[f], degrees);
    for (const auto& [index, value] : coefficients[0]) {
      Rational least = value;
      for (std::size_t i = 0; i < 3; ++i) {
        if (numbers[i] < 0) continue;
        const Rational slope = coefficients[i < 2 ? PlacedHeight::x + i : PlacedHeight::ratio][index];
        const Rational curvature = i < 2 ? coefficients[PlacedHeight::square][index] : Rational(0);
        const auto number = static_cast<std::size_t>(numbers[i]);
        const Rational low = box_.lower(number), high = low + box_.width(number);
        const auto at = [&](const Rational& x) { return Rational(x * (slope + curvature * x)); };
        Rational part = std::min(at(low), at(high));
        if (curvature > 0) {
          const Rational vertex = -slope / (2 * curvature);
          if (vertex > low && vertex < high) part = at(vertex);
        }
        least += part;
      }
      if (least < 0) return false;
    }
    return true;
  }

  std::string find_placed_flaw(std::size_t i) const {
    const MassLimits& limits = multipliers_.mass_limits[i];
    const bool has_limit = multipliers_.limit_index[i] >= 0;
    const FreeCounterweight& counterweight = geometry_.linkage.counterweights[i];
    const PlacedHeight& placed = geometry_.dual.placed[i];
    if (box_.smallest(exact(placed.scale), {}) <= 0) return "a scale may vanish";
    const std::array<int, 3> numbers{counterweight.place_numbers[0], counterweight.place_numbers[1],
                                     counterweight.spin.ratio_number};
    if (!limits.is_upper_used && !holds_everywhere(placed, numbers, 1, {}, {})) return "a place may be higher than 1";
    if (!has_limit) return {};
    if (limits.is_upper_used && !holds_everywhere(placed, numbers, 1, limits.upper, limit(i)))
      return "σ exceeds its upper limit";
    return holds_everywhere(placed, numbers, 1, limits.lower, limit(i)) ? "" : "σ exceeds its lower limit";
  }

  std::string find_inertia_flaw(std::size_t i) const {
    const FreeInertia& inertia = geometry_.linkage.inertias[i];
    const PlacedHeight& placed = geometry_.dual.inertias[i];
    if (box_.smallest(exact(placed.scale), {}) <= 0) return "a scale may vanish";
    const Polynomial sigma = limit(geometry_.linkage.counterweights.size() + i);
    const std::array<int, 3> numbers{-1, -1, inertia.spin.ratio_number};
    for (const double amount : {inertia.lower, inertia.upper})
      if (!holds_everywhere(placed, numbers, 0, amount, sigma)) return "σ exceeds a limit";
    return {};
  }

  double bound_;
  const BoxCertificate& multipliers_;
  const LengthGeometry& geometry_;
  Box box_;
};

/// Whether a condition that excludes a box is not met by any of its lengths.
bool is_excluded(const LengthCondition& condition, const LengthBox& box) {
  const Polynomial p = exact(condition.polynomial);
  if (Box(box).smallest(sum({}, p, -1), {}) > 0) return true;
  return condition.is_equality && Box(box).smallest(p, {}) > 0;
}

/// The objective's largest value within the mass limits.
Rational max_value(const LengthGeometry& geometry) {
  Rational value = -Box(geometry.box).smallest(sum({}, exact(geometry.linkage.fixed_size), -1), {});
  for (const FreeCounterweight& counterweight : geometry.linkage.counterweights) value += Rational(counterweight.upper);
  return value;
}

}  // namespace

std::string find_flaw(const LengthBox& box, double bound, const BoxCertificate& multipliers,
                      const LengthGeometry& geometry) {
  return Checker(box, bound, multipliers, geometry).find_flaw();
}

std::string find_flaw(const LengthCertificate& certificate, const LengthGeometry& geometry) {
  if (certificate.multipliers.multipliers.size() == 0)
    return certificate.bound <= geometry.min_value ? "" : "a bound without multipliers";
  return find_flaw(certificate.box, certificate.bound, certificate.multipliers, geometry);
}

std::string find_flaw(const GeometryProof& proof, double bound) {
  std::vector<LengthBox> open{proof.geometry.box};
  for (const ProofStep& step : proof.steps) {
    if (open.empty()) return "there are more boxes than the whole has parts";
    LengthBox box = open.back();
    open.pop_back();
    if (step.box.lower != box.lower || step.box.upper != box.upper) return "a box is not a part of the whole";
    if (step.kind == ProofStep::Kind::split) {
      if (!(step.at >= box.lower[step.length] && step.at <= box.upper[step.length])) return "a split outside its box";
      LengthBox upper = box;
      upper.lower[step.length] = box.upper[step.length] = step.at;
      open.push_back(std::move(upper));
      open.push_back(std::move(box));
    } else if (step.kind == ProofStep::Kind::excluded) {
      if (!is_excluded(proof.geometry.conditions[static_cast<std::size_t>(step.condition)], box))
        return "a box is not excluded";
    } else {
      if (step.bound < bound && Rational(step.bound) <= max_value(proof.geometry)) return "a bound is too low";
      const std::string flaw = find_flaw(box, step.bound, step.multipliers, proof.geometry);
      if (!flaw.empty()) return flaw;
    }
  }
  return open.empty() ? "" : "a box is missing";
}
