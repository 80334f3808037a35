#include "balance/synthesis/design/feature_map.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/sparse_polynomial.hpp"
#include "balance/synthesis/design/variable_classification.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

namespace balance::design {

// Polynomial interpolation of a function whose variables form small groups.

/// Features as polynomials of degree four or less in unit coordinates, interpolated from few samples and verified at
/// others.
/// @return std::nullopt if they are not such polynomials or if too many variables interact
std::optional<numerics::SparsePolynomial> fit_feature_polynomials(
    const VariableClassification& classification, const std::function<VectorX(const VectorX& u)>& features);

namespace {

constexpr int max_polynomial_degree = 4;
/// With more samples, building mechanisms costs more than it saves.
constexpr std::size_t max_fit_samples = 400;
/// Coefficients below this fraction of the feature's size are round-off; the verification has the same tolerance.
constexpr double fit_tolerance = 1e-12;

using Exponents = std::vector<int>;

/// All exponents of `size` variables with total degree at most `degree`, the constant first.
void list_exponents(int size, int degree, Exponents& head, std::vector<Exponents>& all) {
  if (static_cast<int>(head.size()) == size) {
    all.push_back(head);
    return;
  }
  for (int e = 0; e <= degree; ++e) {
    head.push_back(e);
    list_exponents(size, degree - e, head, all);
    head.pop_back();
  }
}

/// Union-find.
class DisjointSets {
 public:
  explicit DisjointSets(int n) : parent_(static_cast<std::size_t>(n)) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) {
    while (parent_[static_cast<std::size_t>(i)] != i) i = parent_[static_cast<std::size_t>(i)];
    return i;
  }
  void unite(int i, int j) {
    parent_[static_cast<std::size_t>(std::max(find(i), find(j)))] = std::min(find(i), find(j));
  }
  std::vector<std::vector<int>> groups(const std::vector<int>& members) {
    std::vector<std::vector<int>> all(parent_.size());
    for (const int i : members) all[static_cast<std::size_t>(find(i))].push_back(i);
    std::erase_if(all, [](const auto& g) { return g.empty(); });
    return all;
  }

 private:
  std::vector<int> parent_;
};

/// One sample of a group: variables with their values; all others stay at the base.
using SamplePoint = std::vector<std::pair<int, double>>;

/// A maximal set of variables linked by common features, and these features.
struct VariableGroup {
  std::vector<int> variables;
  std::vector<int> features;
  std::vector<std::vector<int>> interacting;  ///< the variables, grouped by common occurrence in products
  std::map<SamplePoint, VectorX> samples;     ///< values of all features
};

class PolynomialFit {
 public:
  PolynomialFit(const VariableClassification& classification, const std::function<VectorX(const VectorX&)>& features)
      : classification_(classification),
        features_(features),
        n_(static_cast<int>(classification.base.size())),
        size_(classification.base_features) {
    size_ = size_.cwiseAbs();
    for (const VectorX& sample : classification.perturbed_features) size_ = size_.cwiseMax(sample.cwiseAbs());
  }

  std::optional<numerics::SparsePolynomial> run() {
    if (!classification_.base_features.allFinite()) return std::nullopt;
    find_groups();
    if (!find_interactions()) return std::nullopt;
    checks_ = {check_point(1), check_point(2)};
    for (int degree = 1; degree <= max_polynomial_degree; ++degree) {
      const auto result = fit(degree);
      if (!result) return std::nullopt;
      if (is_confirmed(*result)) return result;
    }
    return std::nullopt;
  }

 private:
  void find_groups() {
    DisjointSets partition(n_);
    std::vector<int> effective_variables, last_variable(static_cast<std::size_t>(size_.size()), -1);
    for (int i = 0; i < n_; ++i) {
      bool is_effective = false;
      for (int f = 0; f < size_.size(); ++f) {
        if (!classification_.has_effect(i, f)) continue;
        is_effective = true;
        int& other = last_variable[static_cast<std::size_t>(f)];
        if (other >= 0) partition.unite(i, other);
        other = i;
      }
      if (is_effective) effective_variables.push_back(i);
    }
    for (const auto& members : partition.groups(effective_variables)) {
      VariableGroup group{members, {}, {}, {}};
      group.samples[{}] = classification_.base_features;
      for (const int i : members)
        group.samples[{{i, classification_.perturbed[i]}}] =
            classification_.perturbed_features[static_cast<std::size_t>(i)];
      for (int f = 0; f < size_.size(); ++f) {
        const int i = last_variable[static_cast<std::size_t>(f)];
        if (i >= 0 && partition.find(i) == partition.find(members[0])) group.features.push_back(f);
      }
      groups_.push_back(std::move(group));
    }
  }

  /// Evaluates the missing samples. Each mechanism serves one sample of every group, because groups share no features.
  bool sample(const std::vector<std::vector<SamplePoint>>& settings) {
    std::vector<std::vector<SamplePoint>> missing(groups_.size());
    std::size_t max_missing = 0;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      for (const SamplePoint& setting : settings[g])
        if (!groups_[g].samples.contains(setting)) missing[g].push_back(setting);
      if (groups_[g].samples.size() + missing[g].size() > max_fit_samples) return false;
      max_missing = std::max(max_missing, missing[g].size());
    }
    for (std::size_t k = 0; k < max_missing; ++k) {
      VectorX u = classification_.base;
      for (const auto& list : missing)
        if (k < list.size())
          for (const auto& [variable, value] : list[k]) u[variable] = value;
      const VectorX values = features_(u);
      if (!values.allFinite()) return false;
      size_ = size_.cwiseMax(values.cwiseAbs());
      for (std::size_t g = 0; g < groups_.size(); ++g)
        if (k < missing[g].size()) groups_[g].samples[missing[g][k]] = values;
    }
    return true;
  }

  /// Finds interactions by mixed differences of all pairs within a group.
  bool find_interactions() {
    std::vector<std::vector<SamplePoint>> settings(groups_.size());
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const auto& v = groups_[g].variables;
      for (std::size_t i = 0; i < v.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
          settings[g].push_back({{v[j], classification_.perturbed[v[j]]}, {v[i], classification_.perturbed[v[i]]}});
    }
    if (!sample(settings)) return false;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      DisjointSets partition(n_);
      for (const SamplePoint& setting : settings[g]) {
        const int i = setting[0].first, j = setting[1].first;
        const VectorX mixed =
            groups_[g].samples[setting] - classification_.perturbed_features[static_cast<std::size_t>(i)] -
            classification_.perturbed_features[static_cast<std::size_t>(j)] + classification_.base_features;
        for (const int f : groups_[g].features)
          if (std::abs(mixed[f]) > fit_tolerance * size_[f]) partition.unite(i, j);
      }
      groups_[g].interacting = partition.groups(groups_[g].variables);
    }
    return true;
  }

  /// Node e of a variable. The base is the first one, so that samples of a lower degree can be reused for higher ones.
  double node(int variable, int e) const {
    constexpr double interpolation_nodes[] = {0, 0, 0.9, -0.25, 0.6};
    return e == 0   ? classification_.base[variable]
           : e == 1 ? classification_.perturbed[variable]
                    : interpolation_nodes[e];
  }

  std::optional<numerics::SparsePolynomial> fit(int degree) {
    std::vector<std::vector<SamplePoint>> settings(groups_.size());
    for (std::size_t g = 0; g < groups_.size(); ++g)
      for (const auto& v : groups_[g].interacting)
        for (const Exponents& e : exponents(v, degree)) settings[g].push_back(setting_at(v, e));
    if (!sample(settings)) return std::nullopt;
    numerics::PolynomialBuilder collector(static_cast<int>(size_.size()));
    for (int f = 0; f < size_.size(); ++f) collector.add({}, f, classification_.base_features[f]);
    for (const VariableGroup& group : groups_)
      for (const auto& v : group.interacting) interpolate(group, v, exponents(v, degree), collector);
    return collector.build(n_, 0);
  }

  static std::vector<Exponents> exponents(const std::vector<int>& variables, int degree) {
    std::vector<Exponents> all;
    Exponents head;
    list_exponents(static_cast<int>(variables.size()), degree, head, all);
    return all;
  }

  /// Omits variables that stay at the base.
  SamplePoint setting_at(const std::vector<int>& variables, const Exponents& exponents) const {
    SamplePoint setting;
    for (std::size_t i = 0; i < variables.size(); ++i)
      if (exponents[i] > 0) setting.emplace_back(variables[i], node(variables[i], exponents[i]));
    return setting;
  }

  void interpolate(const VariableGroup& group, const std::vector<int>& v, const std::vector<Exponents>& all,
                   numerics::PolynomialBuilder& collector) const {
    const std::vector<int>& features = group.features;
    const auto n = static_cast<Eigen::Index>(all.size());
    MatrixX vandermonde(n, n), right(n, static_cast<Eigen::Index>(features.size()));
    for (Eigen::Index r = 0; r < n; ++r) {
      for (Eigen::Index c = 0; c < n; ++c) {
        vandermonde(r, c) = 1;
        for (std::size_t i = 0; i < v.size(); ++i)
          vandermonde(r, c) *=
              elementary::pow(node(v[i], all[static_cast<std::size_t>(r)][i]), all[static_cast<std::size_t>(c)][i]);
      }
      const VectorX& sample = group.samples.at(setting_at(v, all[static_cast<std::size_t>(r)]));
      for (std::size_t f = 0; f < features.size(); ++f)
        right(r, static_cast<Eigen::Index>(f)) = sample[features[f]] - classification_.base_features[features[f]];
    }
    const Eigen::PartialPivLU<MatrixX> factors(vandermonde);
    MatrixX c = factors.solve(right);
    c += factors.solve(right - vandermonde * c);
    for (Eigen::Index k = 0; k < n; ++k) {
      numerics::Monomial monomial;
      for (std::size_t i = 0; i < v.size(); ++i)
        if (all[static_cast<std::size_t>(k)][i] > 0) monomial.emplace_back(v[i], all[static_cast<std::size_t>(k)][i]);
      for (std::size_t f = 0; f < features.size(); ++f) {
        const double value = c(k, static_cast<Eigen::Index>(f));
        if (std::abs(value) > fit_tolerance * size_[features[f]]) collector.add(monomial, features[f], value);
      }
    }
  }

  std::pair<VectorX, VectorX> check_point(int which) {
    numerics::UniformRandom random(static_cast<std::uint64_t>(which));
    const VectorX u = random.sample_point(n_);
    return {u, features_(u)};
  }

  bool is_confirmed(const numerics::SparsePolynomial& polynomial) const {
    return std::all_of(checks_.begin(), checks_.end(), [&](const auto& check) {
      VectorX values;
      polynomial.evaluate(check.first, values, nullptr);
      return ((values - check.second).cwiseAbs().array() <= fit_tolerance * size_.array() + 1e-300).all();
    });
  }

  const VariableClassification& classification_;
  const std::function<VectorX(const VectorX&)>& features_;
  int n_;
  VectorX size_;  ///< of each feature
  std::vector<VariableGroup> groups_;
  std::vector<std::pair<VectorX, VectorX>> checks_;
};

}  // namespace

std::optional<numerics::SparsePolynomial> fit_feature_polynomials(
    const VariableClassification& classification, const std::function<VectorX(const VectorX& u)>& features) {
  return PolynomialFit(classification, features).run();
}

FeatureMap::FeatureMap(const VariableScaling& scaling, const DesignProblem& problem,
                       const VariableClassification& classification)
    : scaling_(scaling),
      problem_(problem),
      loose_(classification.loose_springs),
      features_(static_cast<int>(classification.base_features.size())) {
  polynomial_ =
      fit_feature_polynomials(classification, [this](const VectorX& u) { return evaluate_from_mechanism(u); });
}

VectorX FeatureMap::evaluate_from_mechanism(const VectorX& u) const {
  try {
    return compute_features(problem_.model->build_mechanism(scaling_.to_variables(u)), loose_);
  } catch (const SpecError&) {
    return VectorX::Constant(features_, std::numeric_limits<double>::quiet_NaN());
  }
}

void FeatureMap::evaluate(const VectorX& u, VectorX& values, MatrixX* jacobian) const {
  if (polynomial_) {
    polynomial_->evaluate(u, values, jacobian);
    return;
  }
  values = evaluate_from_mechanism(u);
  if (jacobian != nullptr)
    *jacobian =
        central_difference_jacobian([this](const VectorX& v) { return evaluate_from_mechanism(v); }, u, features_);
}

}  // namespace balance::design
