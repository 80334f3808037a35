#include "balance/synthesis/design/product_relaxation.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace balance::design {

using numerics::Monomial;

namespace {

/// Maximum rounds of tangent cuts, and relative tolerances of residuals and certificates.
constexpr int max_cut_rounds = 40;
constexpr double product_residual_tolerance = 1e-7, certificate_tolerance = 1e-6;

/// Monomials of all terms, each divided by its maximum absolute value: |z| ≤ 1.
class MonomialBasis {
 public:
  MonomialBasis(const SolverContext& context, const numerics::SparsePolynomial& in_numbers) : context_(context) {
    for (const auto& term : in_numbers.terms()) index_of(term.monomial);
    index_of({});
    // For powers ≥ 2, adds the monomials with the power reduced by one and two.
    const std::vector<Monomial> terms = monomials_;
    for (const Monomial& monomial : terms)
      for (std::size_t k = 0; k < monomial.size(); ++k)
        if (monomial[k].second >= 2) {
          index_of(lower_power(monomial, k, 1));
          index_of(lower_power(monomial, k, 2));
        }
  }

  std::size_t size() const { return monomials_.size(); }
  int index_of(const Monomial& monomial) {
    const auto [entry, is_new] = index_.emplace(monomial, static_cast<int>(monomials_.size()));
    if (is_new) {
      monomials_.push_back(monomial);
      lower_.push_back(0);
      upper_.push_back(0);
      range(monomial, lower_.back(), upper_.back());
      scale_.push_back(std::max({std::abs(lower_.back()), std::abs(upper_.back()), 1e-300}));
    }
    return entry->second;
  }
  int find(const Monomial& monomial) const {
    const auto entry = index_.find(monomial);
    return entry == index_.end() ? -1 : entry->second;
  }
  const Monomial& monomial(std::size_t k) const { return monomials_[k]; }
  double lower(std::size_t k) const { return lower_[k] / scale_[k]; }
  double upper(std::size_t k) const { return upper_[k] / scale_[k]; }
  double scale(std::size_t k) const { return scale_[k]; }
  double lower_of(int variable) const { return context_.scaling.lower()[variable]; }
  double upper_of(int variable) const { return context_.scaling.upper()[variable]; }

  /// The monomial with one variable's power reduced by `decrement`.
  static Monomial lower_power(Monomial monomial, std::size_t k, int decrement) {
    monomial[k].second -= decrement;
    if (monomial[k].second == 0) monomial.erase(monomial.begin() + static_cast<std::ptrdiff_t>(k));
    return monomial;
  }

 private:
  void range(const Monomial& monomial, double& low, double& high) const {
    low = high = 1;
    for (const auto& [variable, power] : monomial) {
      const double a = elementary::pow(lower_of(variable), power), b = elementary::pow(upper_of(variable), power);
      const bool through_zero = power % 2 == 0 && lower_of(variable) < 0 && upper_of(variable) > 0;
      const double low_power = through_zero ? 0 : std::min(a, b), high_power = std::max(a, b);
      const auto [smallest, largest] =
          std::minmax({low * low_power, low * high_power, high * low_power, high * high_power});
      low = smallest;
      high = largest;
    }
  }

  const SolverContext& context_;
  std::vector<Monomial> monomials_;
  std::map<Monomial, int> index_;
  std::vector<double> lower_, upper_, scale_;
};

class ProductRelaxation {
 public:
  ProductRelaxation(const SolverContext& context, const Conditions& conditions,
                    const numerics::SparsePolynomial& in_numbers)
      : conditions_(conditions), products_(context, in_numbers) {
    const auto z = static_cast<Eigen::Index>(products_.size());
    rows_.setZero(conditions.matrix.rows(), z);
    for (const auto& term : in_numbers.terms()) {
      const auto column = static_cast<std::size_t>(products_.find(term.monomial));
      for (const auto& [output, coefficient] : term.coefficients)
        if (output < conditions.matrix.cols())
          rows_.col(static_cast<Eigen::Index>(column)) +=
              conditions.matrix.col(output).cwiseQuotient(conditions.row_scales) * coefficient *
              products_.scale(column);
    }
    add_square_cuts();
    add_mccormick_cuts();
  }

  std::optional<VectorX> run() {
    if (squares_.empty() && cuts_.empty()) return std::nullopt;
    for (int round = 0; round < max_cut_rounds; ++round) {
      const auto z = minimise_max_residual();
      if (!z) return std::nullopt;
      if (residual_ <= product_residual_tolerance) {
        if (!add_tangents(*z)) return std::nullopt;  // all products are consistent: nothing is proved
        continue;
      }
      if (auto factors = find_certificate()) return factors;
      if (!add_tangents(*z)) return std::nullopt;
    }
    return std::nullopt;
  }

 private:
  /// first · third = second², with nonnegative first and third.
  struct SquareRelation {
    Eigen::Index first, second, third;
  };

  void add_square_cuts() {
    for (std::size_t k = 0; k < products_.size(); ++k) {
      const Monomial& monomial = products_.monomial(k);
      for (std::size_t v = 0; v < monomial.size(); ++v) {
        if (monomial[v].second < 2) continue;
        const int root = products_.find(MonomialBasis::lower_power(monomial, v, 1)),
                  base = products_.find(MonomialBasis::lower_power(monomial, v, 2));
        if (root < 0 || base < 0 || products_.lower(static_cast<std::size_t>(base)) < 0 || products_.lower(k) < 0)
          continue;
        squares_.push_back({base, root, static_cast<Eigen::Index>(k)});
        // (x − low)(x − high) ≤ 0
        const int x = monomial[v].first;
        const double low = products_.lower_of(x), high = products_.upper_of(x);
        VectorX cut = VectorX::Zero(static_cast<Eigen::Index>(products_.size()));
        cut[root] += (low + high) * products_.scale(static_cast<std::size_t>(root));
        cut[base] -= low * high * products_.scale(static_cast<std::size_t>(base));
        cut[static_cast<Eigen::Index>(k)] -= products_.scale(k);
        add(cut);
      }
    }
  }

  /// low · p ≤ p x ≤ high · p for nonnegative p.
  void add_mccormick_cuts() {
    for (std::size_t k = 0; k < products_.size(); ++k) {
      const Monomial& monomial = products_.monomial(k);
      for (std::size_t v = 0; v < monomial.size(); ++v) {
        const int base = products_.find(MonomialBasis::lower_power(monomial, v, 1));
        if (monomial.size() + static_cast<std::size_t>(monomial[v].second) <= 2 || base < 0 ||
            products_.lower(static_cast<std::size_t>(base)) < 0)
          continue;
        const int x = monomial[v].first;
        VectorX cut = VectorX::Zero(static_cast<Eigen::Index>(products_.size()));
        cut[static_cast<Eigen::Index>(k)] = products_.scale(k);
        cut[base] = -products_.lower_of(x) * products_.scale(static_cast<std::size_t>(base));
        add(cut);
        cut[static_cast<Eigen::Index>(k)] = -products_.scale(k);
        cut[base] = products_.upper_of(x) * products_.scale(static_cast<std::size_t>(base));
        add(cut);
      }
    }
  }

  void add(const VectorX& cut) {
    const double size = numerics::max_abs(cut);
    if (size > 0) cuts_.emplace_back(cut / size);
  }

  VectorX bounds(bool upper) const {
    VectorX values(static_cast<Eigen::Index>(products_.size()));
    for (std::size_t k = 0; k < products_.size(); ++k)
      values[static_cast<Eigen::Index>(k)] = upper ? products_.upper(k) : products_.lower(k);
    return values;
  }

  /// The point within all cuts that minimises the maximum residual of the conditions.
  std::optional<VectorX> minimise_max_residual() {
    const auto z = static_cast<Eigen::Index>(products_.size());
    numerics::LinearProgram program(z + 1);
    program.lower.head(z) = bounds(false);
    program.upper.head(z) = bounds(true);
    program.lower[z] = 0;
    program.cost[z] = 1;
    VectorX row = VectorX::Zero(z + 1);
    for (Eigen::Index k = 0; k < rows_.rows(); ++k) {
      row.head(z) = rows_.row(k).transpose();
      row[z] = 1;
      program.add_row(0, row, numerics::no_bound);
      row[z] = -1;
      program.add_row(-numerics::no_bound, row, 0);
    }
    row[z] = 0;
    for (const VectorX& cut : cuts_) {
      row.head(z) = cut;
      program.add_row(0, row, numerics::no_bound);
    }
    const numerics::LinearProgramSolution solution = solve_linear_program(program);
    if (solution.status != numerics::LinearProgramStatus::optimal) return std::nullopt;
    residual_ = solution.x[z];
    return solution.x.head(z);
  }

  /// third ≥ 2 t second − t² first for all t; the most violated tangent has t = second / first.
  bool add_tangents(const VectorX& z) {
    bool has_new_cuts = false;
    for (const SquareRelation& s : squares_) {
      const auto size = [&](Eigen::Index k) { return products_.scale(static_cast<std::size_t>(k)); };
      const double first = z[s.first] * size(s.first), second = z[s.second] * size(s.second);
      if (!(first > 1e-9 * size(s.first))) continue;
      const double t = second / first;
      VectorX cut = VectorX::Zero(z.size());
      cut[s.third] += size(s.third);
      cut[s.second] -= 2 * t * size(s.second);
      cut[s.first] += t * t * size(s.first);
      if (cut.dot(z) >= -1e-9 * numerics::max_abs(cut)) continue;
      add(cut);
      has_new_cuts = true;
    }
    return has_new_cuts;
  }

  /// Multipliers λ of the conditions and μ ≥ 0 of the cuts for which the combination minus the cuts is at least 1
  /// within the bounds: λᵀ rows − μᵀ cuts = rise − fall.
  std::optional<VectorX> find_certificate() const {
    const Eigen::Index n = rows_.rows(), z = rows_.cols(), c = static_cast<Eigen::Index>(cuts_.size());
    const Eigen::Index rise = 2 * n + c, fall = rise + z, total = fall + z;
    const VectorX low = bounds(false), high = bounds(true);
    numerics::LinearProgram program(total);
    program.lower.setZero();
    program.cost.head(2 * n).setOnes();
    VectorX minimum_row = VectorX::Zero(total);
    for (Eigen::Index j = 0; j < z; ++j) {
      VectorX rate = VectorX::Zero(total);
      rate.head(n) = rows_.col(j);
      rate.segment(n, n) = -rows_.col(j);
      for (Eigen::Index k = 0; k < c; ++k) rate[2 * n + k] = -cuts_[static_cast<std::size_t>(k)][j];
      rate[rise + j] = -1;
      rate[fall + j] = 1;
      program.add_row(0, rate, 0);
      minimum_row[rise + j] = low[j];
      minimum_row[fall + j] = -high[j];
    }
    program.add_row(1, minimum_row, numerics::no_bound);
    const numerics::LinearProgramSolution solution = solve_linear_program(program);
    if (solution.status != numerics::LinearProgramStatus::optimal) return std::nullopt;
    const VectorX factors = solution.x.head(n) - solution.x.segment(n, n);
    return is_valid_certificate(factors, solution.x.segment(2 * n, c)) ? std::optional<VectorX>(factors) : std::nullopt;
  }

  /// Recomputes the minimum of the combination independently of the linear program.
  bool is_valid_certificate(const VectorX& factors, const VectorX& cut_multipliers) const {
    VectorX rate = rows_.transpose() * factors;
    double size = numerics::max_abs(rate);
    for (std::size_t k = 0; k < cuts_.size(); ++k) {
      const double factor = std::max(0.0, cut_multipliers[static_cast<Eigen::Index>(k)]);
      rate -= factor * cuts_[k];
      size = std::max(size, factor);
    }
    const VectorX low = bounds(false), high = bounds(true);
    double minimum = 0;
    for (Eigen::Index j = 0; j < rate.size(); ++j) minimum += std::min(rate[j] * low[j], rate[j] * high[j]);
    return minimum > certificate_tolerance * size;
  }

  const Conditions& conditions_;
  MonomialBasis products_;
  MatrixX rows_;  ///< scaled conditions × products
  std::vector<SquareRelation> squares_;
  std::vector<VectorX> cuts_;  ///< cut · z ≥ 0
  double residual_ = 0;
};

}  // namespace

std::optional<conditions::InfeasibilityCertificate> certify_by_product_relaxation(
    const SolverContext& context, const Conditions& conditions, const numerics::SparsePolynomial& in_numbers) {
  const auto factors = ProductRelaxation(context, conditions, in_numbers).run();
  if (!factors) return std::nullopt;
  conditions::InfeasibilityCertificate proof;
  proof.kind = conditions::InfeasibilityCertificate::Kind::product_relaxation;
  proof.combination = factors->cwiseQuotient(conditions.row_scales);
  proof.coefficients = conditions.matrix.transpose() * proof.combination;
  const double largest = numerics::max_abs(proof.coefficients);
  if (!(largest > 0)) return std::nullopt;
  proof.combination /= largest;
  proof.coefficients /= largest;
  // Drops coefficients that are round-off of the linear program.
  for (double& c : proof.coefficients)
    if (std::abs(c) < 1e-9) c = 0;
  proof.statement = conditions::linear_combination_text(conditions.parameters, proof.coefficients) +
                    " = 0 cannot hold: with the fixed numbers it is positive for all values within the bounds, as no "
                    "square is negative";
  return proof;
}

}  // namespace balance::design
