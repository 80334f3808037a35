#include "balance/design/maxima_search.hpp"

#include "balance/base/extrema.hpp"
#include "balance/design/nlopt_search.hpp"
#include "balance/design/seek.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::design {

namespace {

/// Local searches, from points no nearer to each other than this in unit coordinates.
constexpr std::size_t max_epigraph_searches = 4;
constexpr double min_epigraph_start_distance = 0.3;
constexpr int max_epigraph_evaluations = 150;
/// Two ends from points apart, neither of which is better by more than this part, are one minimum that is not to be doubted.
constexpr double epigraph_optimum_tolerance = 1e-6;

/// The free numbers, then per maximum its bound, in units of what it is to begin with and less one.
class EpigraphProgram {
 public:
  EpigraphProgram(const SolverContext& context, const ScaledObjective& merit, const VectorX& from)
      : context_(context), objective_(merit), size_(static_cast<int>(from.size())) {
    evaluate_terms(from);
    if (!here_) return;
    for (std::size_t t = 0; t < here_->size(); ++t) {
      const MaxTerm& term = (*here_)[t];
      total_ += std::abs(term.weight * max_coefficient(term.values));
      if (term.values.size() < 2) continue;
      maxima_.push_back(
          {t, static_cast<int>(term.values.size()), std::max(std::abs(max_coefficient(term.values)), 1e-300)});
      rows_ += maxima_.back().count;
    }
    if (!(total_ > 0)) total_ = 1;
  }

  bool has_start_value() const { return here_.has_value(); }

  VectorX start(const VectorX& from) const {
    VectorX v = VectorX::Zero(size_ + static_cast<int>(maxima_.size()));
    v.head(size_) = from;
    return v;
  }

  NonlinearProgram program() {
    NonlinearProgram program;
    program.size = size_ + static_cast<int>(maxima_.size());
    program.objective = [this](const VectorX& v, VectorX* gradient) { return evaluate_objective(v, gradient); };
    program.inequality_count = rows_ + context_.physical_constraints.size();
    program.inequalities = [this](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      evaluate_inequalities(v, values, jacobian);
    };
    return program;
  }

  const std::optional<VectorX>& best() const { return best_; }

 private:
  /// A maximum of several functions.
  struct Maximum {
    std::size_t term;
    int count;
    double size;
  };

  /// What all functions are at the numbers; remembered.
  void evaluate_terms(const VectorX& u) {
    if (known_.size() == u.size() && known_ == u) return;
    known_ = u;
    ++context_.budget.evaluations;
    here_ = objective_.max_terms(u);
    for (const Maximum& maximum : maxima_)
      if (here_ && (*here_)[maximum.term].values.size() != maximum.count) here_.reset();
    if (!here_) return;
    double value = 0;
    for (const MaxTerm& term : *here_) value += term.weight * max_coefficient(term.values);
    if ((best_ && !(value < least_)) || !context_.is_admissible(u)) return;
    best_ = u;
    least_ = value;
  }

  double evaluate_objective(const VectorX& v, VectorX* gradient) {
    evaluate_terms(v.head(size_));
    if (!here_) return std::numeric_limits<double>::quiet_NaN();
    double value = 0;
    VectorX slope = VectorX::Zero(v.size());
    for (const MaxTerm& term : *here_)
      if (term.values.size() == 1) {
        value += term.weight * term.values[0];
        slope.head(size_) += term.weight * term.jacobian.row(0).transpose();
      }
    for (std::size_t m = 0; m < maxima_.size(); ++m) {
      const double weight = (*here_)[maxima_[m].term].weight * maxima_[m].size;
      const auto at = size_ + static_cast<Eigen::Index>(m);
      value += weight * (1 + v[at]);
      slope[at] += weight;
    }
    if (gradient != nullptr) *gradient = slope / total_;
    return value / total_;
  }

  void evaluate_inequalities(const VectorX& v, VectorX& values, MatrixX* jacobian) {
    evaluate_terms(v.head(size_));
    values.setConstant(rows_ + context_.physical_constraints.size(), std::numeric_limits<double>::quiet_NaN());
    if (jacobian != nullptr) jacobian->setZero(values.size(), v.size());
    if (!here_) return;
    Eigen::Index row = 0;
    for (std::size_t m = 0; m < maxima_.size(); ++m) {
      const MaxTerm& term = (*here_)[maxima_[m].term];
      const auto at = size_ + static_cast<Eigen::Index>(m);
      const int count = maxima_[m].count;
      values.segment(row, count) = (1 + v[at]) - term.values.array() / maxima_[m].size;
      if (jacobian != nullptr) {
        jacobian->block(row, 0, count, size_) = -term.jacobian / maxima_[m].size;
        jacobian->col(at).segment(row, count).setOnes();
      }
      row += count;
    }
    VectorX features, physical;
    MatrixX slopes, physical_slopes;
    context_.features.evaluate(v.head(size_), features, jacobian != nullptr ? &slopes : nullptr);
    context_.physical_constraints.evaluate(features, &slopes, physical,
                                           jacobian != nullptr ? &physical_slopes : nullptr);
    values.tail(context_.physical_constraints.size()) = physical;
    if (jacobian != nullptr) jacobian->bottomLeftCorner(context_.physical_constraints.size(), size_) = physical_slopes;
  }

  const SolverContext& context_;
  const ScaledObjective& objective_;
  int size_, rows_ = 0;
  std::vector<Maximum> maxima_;
  double total_ = 0;
  VectorX known_;
  std::optional<std::vector<MaxTerm>> here_;
  std::optional<VectorX> best_;
  double least_ = 0;
};

/// The two best ends are as good as each other.
bool has_repeated_optimum(std::vector<std::pair<double, VectorX>> ends) {
  if (ends.size() < 2) return false;
  std::sort(ends.begin(), ends.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return ends[1].first - ends[0].first <= epigraph_optimum_tolerance * std::abs(ends[0].first);
}

}  // namespace

std::optional<VectorX> minimise_max_terms_from(const SolverContext& context, const ScaledObjective& merit,
                                               const VectorX& from) {
  EpigraphProgram epigraph(context, merit, from);
  if (!epigraph.has_start_value()) return std::nullopt;
  ++context.budget.local_searches;
  const StoppingCriteria limits{std::min(context.problem.search.max_evaluations, max_epigraph_evaluations),
                                context.budget.remaining_time(), 1e-8, 0};
  if (search_locally("slsqp", epigraph.program(), epigraph.start(from), limits).is_budget_exhausted &&
      context.budget.is_spent())
    context.budget.stopped = true;
  return epigraph.best();
}

std::vector<VectorX> minimise_max_terms(const SolverContext& context, const ScaledObjective& merit,
                                        const VectorX& start) {
  const int size = static_cast<int>(start.size());
  std::vector<std::pair<double, VectorX>> points;
  const auto look = [&](const VectorX& u) {
    if (points.empty() || !context.budget.is_spent())
      if (const double value = merit(u, nullptr); std::isfinite(value)) points.emplace_back(value, u);
  };
  look(start);
  const std::size_t from_start = points.size();
  for (const VectorX& u : low_discrepancy_points(8 + 2 * size, size, context.problem.search.seed)) look(u);
  std::stable_sort(points.begin() + static_cast<std::ptrdiff_t>(from_start), points.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<VectorX> used;
  std::vector<std::pair<double, VectorX>> ends;
  for (const auto& [value, u] : points) {
    if (used.size() >= max_epigraph_searches || context.budget.is_spent() || has_repeated_optimum(ends)) break;
    if (std::any_of(used.begin(), used.end(),
                    [&, &u = u](const VectorX& v) { return (u - v).norm() < min_epigraph_start_distance; }))
      continue;
    used.push_back(u);
    if (const auto end = minimise_max_terms_from(context, merit, u)) ends.emplace_back(merit(*end, nullptr), *end);
  }
  std::stable_sort(ends.begin(), ends.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<VectorX> found;
  for (auto& [value, u] : ends)
    if (std::isfinite(value)) found.push_back(std::move(u));
  return found;
}

}  // namespace balance::design
