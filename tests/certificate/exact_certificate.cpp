#include "exact_certificate.hpp"

#include <boost/multiprecision/cpp_int.hpp>

#include <algorithm>
#include <map>
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
  Rational smallest(Polynomial p, const Polynomial& shape) const {
    std::vector<int> degrees(size(), 0);
    for (const Polynomial* one : std::initializer_list<const Polynomial*>{&p, &shape})
      for (const auto& [exponents, coefficient] : *one)
        for (std::size_t i = 0; i < size(); ++i) degrees[i] = std::max(degrees[i], exponents[i]);
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
    std::size_t count = 1;
    for (const int degree : degrees) count *= static_cast<std::size_t>(degree) + 1;
    Rational least = p.size() < count ? Rational(0) : p.begin()->second;
    for (const auto& [index, coefficient] : p) least = std::min(least, coefficient);
    return least;
  }

 private:
  const LengthBox& box_;
};

class Checker {
 public:
  Checker(const LengthCertificate& certificate, const LengthGeometry& geometry)
      : certificate_(certificate), geometry_(geometry), box_(certificate.box) {}

  std::string find_flaw() const {
    const BoxCertificate& multipliers = certificate_.multipliers;
    Polynomial objective = exact(geometry_.dual.fixed_size);
    const Polynomial scale = exact(geometry_.dual.fixed_masses.scale);
    if (box_.smallest(scale, {}) <= 0) return "the objective's scale may vanish";
    objective = sum(objective, height(geometry_.dual.fixed_masses), -1);
    for (std::size_t i = 0; i < geometry_.linkage.counterweights.size(); ++i) {
      const std::string flaw = find_counterweight_flaw(i);
      if (!flaw.empty()) return geometry_.linkage.counterweights[i].name + ": " + flaw;
      if (multipliers.limit_index[i] >= 0) objective = sum(objective, product(scale, limit(i)));
    }
    for (std::size_t c = 0; c < multipliers.conditions.size(); ++c) {
      const LengthCondition& condition = geometry_.conditions[static_cast<std::size_t>(multipliers.conditions[c])];
      const Rational multiplier(multipliers.condition_multipliers[static_cast<Eigen::Index>(c)]);
      if (!condition.is_equality && multiplier < 0) return "a condition has a negative multiplier";
      objective = sum(objective, exact(condition.polynomial), -multiplier);
    }
    objective = sum(objective, scale, -Rational(certificate_.bound));
    return box_.smallest(objective, {}) >= 0 ? "" : "the objective may be less than the bound";
  }

 private:
  /// Constant part and those of the affine lengths.
  Polynomial multiplier(Eigen::Index column) const {
    Polynomial p = box_.constant(Rational(certificate_.multipliers.multipliers(0, column)));
    for (std::size_t a = 0; a < certificate_.multipliers.affine.size(); ++a)
      p = sum(p, box_.centred(static_cast<std::size_t>(certificate_.multipliers.affine[a])),
              Rational(certificate_.multipliers.multipliers(static_cast<Eigen::Index>(a) + 1, column)));
    return p;
  }
  Polynomial limit(std::size_t counterweight) const {
    return multiplier(certificate_.multipliers.unknowns + certificate_.multipliers.limit_index[counterweight]);
  }
  Polynomial height(const VirtualHeight& virtual_height) const {
    Polynomial p;
    for (std::size_t j = 0; j < virtual_height.coefficients.size(); ++j)
      p = sum(p, product(exact(virtual_height.coefficients[j]), multiplier(static_cast<Eigen::Index>(j))));
    return p;
  }

  std::string find_counterweight_flaw(std::size_t i) const {
    const MassLimits& limits = certificate_.multipliers.mass_limits[i];
    const bool has_limit = certificate_.multipliers.limit_index[i] >= 0;
    if (limits.is_left_out()) return has_limit ? "σ without a counterweight" : "";
    const bool has_upper = limits.is_upper_used;
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

  const LengthCertificate& certificate_;
  const LengthGeometry& geometry_;
  Box box_;
};

}  // namespace

std::string find_flaw(const LengthCertificate& certificate, const LengthGeometry& geometry) {
  if (certificate.multipliers.multipliers.size() == 0)
    return certificate.bound <= geometry.min_value ? "" : "a bound without multipliers";
  return Checker(certificate, geometry).find_flaw();
}
