#include "balance/synthesis/design/size_search.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/design/all_different.hpp"
#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/objective_builder.hpp"
#include "balance/synthesis/design/problem_functions.hpp"
#include "balance/synthesis/design/solve_design.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <list>
#include <memory>
#include <set>
#include <stdexcept>

namespace balance::design {

namespace {

/// Values that differ by less than this fraction count as equal: round-off of figures along different motions.
constexpr double equal_value_tolerance = 1e-9;
/// Residuals of conditions below this, from polynomials, are computed again from the mechanism itself.
constexpr double doubtful_residual_tolerance = 1e-7;

bool is_less(double a, double b) {
  return a < b - equal_value_tolerance * std::max(std::abs(a), std::abs(b)) || (std::isfinite(a) && !std::isfinite(b));
}

}  // namespace

bool DesignRating::is_better_than(const DesignRating& other) const {
  if (rank != other.rank) return rank < other.rank;
  if (is_less(value, other.value) || is_less(other.value, value)) return is_less(value, other.value);
  return is_less(added_mass, other.added_mass);
}

bool is_finite(const DesignProblem& problem) {
  return problem.cardinality_constraints.empty() &&
         std::all_of(problem.variables.begin(), problem.variables.end(),
                     [](const DesignVariable& variable) { return !variable.discrete_values.empty(); });
}

namespace {

/// Rates designs of a problem. The conditions are derived once unless the variables change the geometry.
class DesignRater {
 public:
  /// @param problem, budget must outlive this object
  DesignRater(const DesignProblem& problem, SearchBudget& budget) : context_(problem, budget) {
    if (problem.objective) objective_.emplace(context_, *problem.objective);
    if (objective_) round_off_ = objective_->round_off();
    for (const DesignLimit& limit : problem.limits) limits_.emplace_back(context_, limit.figure);
    if (context_.classification.has_geometric()) return;
    shared_conditions_ = context_.conditions_at(context_.scaling.start());
    if (shared_conditions_->status == ConditionsStatus::done) rows_.emplace(context_, *shared_conditions_);
  }

  const SolverContext& context() const { return context_; }

  /// @return std::nullopt if x is not a design, or certainly not better than `best`
  std::optional<DesignRating> rate(const VectorX& x, const std::optional<DesignRating>& best) const {
    ++context_.budget.evaluations;
    const VectorX u = context_.scaling.to_unit(x);
    if (!is_physical(u)) return std::nullopt;
    DesignRating rating;
    double residual = 0;
    const std::optional<bool> meets_conditions = check_conditions(u, residual);
    if (!meets_conditions || (!*meets_conditions && is_at_most(best, DesignRating::Rank::limits_violated)))
      return std::nullopt;
    const std::optional<double> violation = worst_violation(u, best);
    if (!violation) return std::nullopt;
    const bool keeps_limits = *violation <= limit_tolerance;
    using enum DesignRating::Rank;
    rating.rank = *meets_conditions ? (keeps_limits ? exact : limits_violated)
                                    : (keeps_limits ? conditions_violated : everything_violated);
    if (best && best->rank < rating.rank) return std::nullopt;
    const double figure = objective_ ? (*objective_)(u, nullptr) : 0;
    if (!std::isfinite(figure)) return std::nullopt;
    const bool is_residual =
        rating.rank == conditions_violated && (!objective_ || context_.problem.objective->is_secondary);
    rating.value = !keeps_limits ? *violation : is_residual ? residual : std::abs(figure) <= round_off_ ? 0 : figure;
    rating.added_mass = added_mass(u);
    if (best && !rating.is_better_than(*best)) return std::nullopt;
    return context_.invalidity_reason(u).empty() ? std::optional<DesignRating>(rating) : std::nullopt;
  }

  /// Why the mechanism cannot perform the required motions; empty if it can.
  std::string infeasibility_reason(const VectorX& x) const {
    return context_.classification.has_geometric() ? context_.infeasibility_reason(context_.scaling.to_unit(x)) : "";
  }

 private:
  static bool is_at_most(const std::optional<DesignRating>& best, DesignRating::Rank rank) {
    return best && best->rank <= rank;
  }

  bool is_physical(const VectorX& u) const {
    VectorX features;
    context_.features.evaluate(u, features, nullptr);
    return context_.physical_constraints.is_satisfied(features);
  }

  /// @param residual norm of the scaled residuals
  /// @return std::nullopt if there are no conditions at u
  std::optional<bool> check_conditions(const VectorX& u, double& residual) const {
    if (context_.problem.goals.empty()) return true;
    VectorX values;
    Eigen::Index parameter_rows = 0;
    if (shared_conditions_) {
      if (!rows_) return std::nullopt;
      parameter_rows = shared_conditions_->parameter_rows();
      rows_->evaluate(u, values, nullptr);
      if (numerics::max_abs(values.head(parameter_rows)) < doubtful_residual_tolerance)
        values = rows_->evaluate_from_mechanism(u);
    } else {
      const Conditions conditions = context_.conditions_at(u);
      if (conditions.status != ConditionsStatus::done) return std::nullopt;
      parameter_rows = conditions.parameter_rows();
      values =
          scaled_residuals(conditions, conditions::term_values(context_.mechanism(u), context_.options.loose_springs));
    }
    if (!values.allFinite()) return std::nullopt;
    residual = values.norm();
    return numerics::max_abs(values.head(parameter_rows)) < condition_tolerance;
  }

  /// @return std::nullopt if it makes u worse than `best`; infinite if a figure has no value
  std::optional<double> worst_violation(const VectorX& u, const std::optional<DesignRating>& best) const {
    double worst = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < limits_.size(); ++k) {
      const double violation = relative_violation(context_.problem.limits[k], limits_[k](u, nullptr));
      worst = std::isnan(violation) ? std::numeric_limits<double>::infinity() : std::max(worst, violation);
      if (worst <= limit_tolerance || !best) continue;
      using enum DesignRating::Rank;
      const bool is_worse = best->rank == exact || (best->rank == limits_violated && is_less(best->value, worst));
      if (is_worse) return std::nullopt;
    }
    return worst;
  }

  double added_mass(const VectorX& u) const {
    const Mechanism mechanism = context_.mechanism(u);
    return size_coefficients(ObjectiveTerm::Size::added_mass, mechanism, {}).dot(dynamics::parameter_values(mechanism));
  }

  SolverContext context_;
  std::optional<ScaledObjective> objective_;
  double round_off_ = 0;
  std::vector<ScaledObjective> limits_;
  std::optional<Conditions> shared_conditions_;
  std::optional<ConditionResidual> rows_;
};

/// Visits the combinations of sizes that differ where they must: the last variable changes first, each from its start
/// value outwards. No branch ends without a combination, because groups are disjoint.
class CombinationVisitor {
 public:
  CombinationVisitor(const DesignProblem& problem, std::vector<int> order)
      : all_different_(problem), order_(std::move(order)), is_set_(problem.variables.size(), false) {
    x_.setZero(static_cast<Eigen::Index>(problem.variables.size()));
    for (const int i : order_) {
      const DesignVariable& variable = problem.variables[static_cast<std::size_t>(i)];
      sizes_.push_back(variable.discrete_values);
      std::stable_sort(sizes_.back().begin(), sizes_.back().end(),
                       [&](double a, double b) { return std::abs(a - variable.start) < std::abs(b - variable.start); });
    }
  }

  /// @param visit returns false to end
  /// @return whether all combinations were visited
  bool run(const std::function<bool(const VectorX&)>& visit) {
    return !all_different_.can_complete(x_, is_set_) || descend(0, visit);
  }

 private:
  bool descend(std::size_t depth, const std::function<bool(const VectorX&)>& visit) {
    if (depth == order_.size()) return visit(x_);
    const int i = order_[depth];
    for (const double size : sizes_[depth]) {
      x_[i] = size;
      if (all_different_.is_violated_by(i, x_, is_set_)) continue;
      is_set_[static_cast<std::size_t>(i)] = true;
      const bool goes_on = !all_different_.can_complete(x_, is_set_) || descend(depth + 1, visit);
      is_set_[static_cast<std::size_t>(i)] = false;
      if (!goes_on) return false;
    }
    return true;
  }

  AllDifferent all_different_;
  std::vector<int> order_;
  std::vector<std::vector<double>> sizes_;  ///< of each variable in this order
  VectorX x_;
  std::vector<bool> is_set_;
};

/// Rates combinations of sizes, with one motion for each of the last few sets of lengths.
class CombinationRater {
 public:
  /// @param problem, budget must outlive this object
  CombinationRater(const DesignProblem& problem, SearchBudget& budget)
      : rater_(problem, budget),
        geometric_(geometric_variables(rater_.context())),
        inertial_(inertial_variables(rater_.context())) {}

  /// The variables, lengths first.
  std::vector<int> variable_order() const {
    std::vector<int> order = geometric_;
    order.insert(order.end(), inertial_.begin(), inertial_.end());
    return order;
  }

  /// Replaces `best` if x is better. @return whether it did
  bool keep_better(const VectorX& x, SizeSearchResult& best) {
    std::optional<DesignRating> rating;
    if (best.x.size() > 0) rating = best.rating;
    try {
      if (geometric_.empty() || inertial_.empty()) {
        rating = rater_.rate(x, rating);
        if (!rating || !rater_.infeasibility_reason(x).empty()) return false;
      } else {
        const FixedGeometry* geometry = geometry_at(x);
        if (geometry == nullptr) return false;
        rating = geometry->rater.rate(x(inertial_), rating);
        if (!rating) return false;
      }
    } catch (const SpecError&) {
      return false;  // an expression of the spec has no value here
    } catch (const std::invalid_argument&) {
      return false;  // there is no motion
    } catch (const DeadlineExceeded&) {
      return false;
    }
    best.x = x;
    best.rating = *rating;
    return true;
  }

 private:
  /// The problem of the other variables at one set of lengths.
  struct FixedGeometry {
    FixedGeometry(const SolverContext& context, const VectorX& x)
        : problem(make_fixed_geometry_problem(context, x, context.budget.remaining_time())),
          rater(problem, context.budget) {}

    DesignProblem problem;
    DesignRater rater;
  };

  /// @return nullptr if the mechanism cannot perform the required motions
  const FixedGeometry* geometry_at(const VectorX& x) {
    constexpr std::size_t max_geometries = 32;
    const VectorX lengths = x(geometric_);
    const auto known = std::find_if(geometries_.begin(), geometries_.end(),
                                    [&](const auto& geometry) { return geometry.first == lengths; });
    if (known != geometries_.end()) {
      geometries_.splice(geometries_.begin(), geometries_, known);
      return geometries_.front().second.get();
    }
    geometries_.emplace_front(lengths, nullptr);
    if (geometries_.size() > max_geometries) geometries_.pop_back();
    if (!rater_.infeasibility_reason(x).empty()) return nullptr;
    ++rater_.context().budget.geometries;
    geometries_.front().second = std::make_unique<const FixedGeometry>(rater_.context(), x);
    return geometries_.front().second.get();
  }

  DesignRater rater_;
  std::vector<int> geometric_, inertial_;
  std::list<std::pair<VectorX, std::unique_ptr<const FixedGeometry>>> geometries_;  ///< the last one used is first
};

}  // namespace

long count_combinations(const DesignProblem& problem, const std::vector<int>& variables, long limit) {
  double product = 1;
  for (const int i : variables)
    product *= static_cast<double>(problem.variables[static_cast<std::size_t>(i)].discrete_values.size());
  if (problem.all_different.empty()) return product < static_cast<double>(limit) ? static_cast<long>(product) : limit;
  long count = 0;
  CombinationVisitor(problem, variables).run([&](const VectorX&) { return ++count < limit; });
  return count;
}

namespace {

/// Relative difference below which two searches ended equally well, number of searches that must do so, and least
/// number of searches.
constexpr double equal_end_tolerance = 1e-6;
constexpr int min_equal_ends = 3, min_exchange_searches = 8;

class SizeExchange {
 public:
  /// @param rater of the problem
  SizeExchange(const DesignProblem& problem, SearchBudget& budget, CombinationRater& rater, long max_combinations)
      : problem_(problem),
        all_different_(problem),
        budget_(budget),
        max_combinations_(max_combinations),
        rater_(rater),
        order_(rater_.variable_order()),
        random_(problem.search.seed) {
    std::reverse(order_.begin(), order_.end());  // lengths last, because they need another motion
  }

  /// A single search, from the start values.
  SizeSearchResult descend_from_start() {
    const std::optional<VectorX> start = first_start();
    return start ? descend(*start) : SizeSearchResult{};
  }
  long tried_count() const { return static_cast<long>(tried_.size()); }
  bool has_tried(const VectorX& x) const { return tried_.contains(std::vector<double>(x.begin(), x.end())); }

  SizeSearchResult run() {
    std::vector<DesignRating> ends;
    budget_.local_searches = 0;
    const std::optional<VectorX> first = first_start();
    while (first && !is_spent() && !have_searches_agreed(ends)) {
      const SizeSearchResult end = descend(ends.empty() ? *first : random_start(*first));
      ++budget_.local_searches;
      if (end.x.size() == 0) continue;
      ends.push_back(end.rating);
      if (best_.x.size() == 0 || end.rating.is_better_than(best_.rating)) {
        best_.x = end.x;
        best_.rating = end.rating;
      }
    }
    budget_.ends.clear();
    for (const DesignRating& end : ends)
      budget_.ends.push_back(end.rank == best_.rating.rank ? end.value : std::numeric_limits<double>::quiet_NaN());
    return best_;
  }

 private:
  bool is_spent() { return best_.combinations >= max_combinations_ || (best_.combinations > 0 && budget_.is_spent()); }

  int count_equal_ends(const std::vector<DesignRating>& ends) const {
    return static_cast<int>(std::count_if(ends.begin(), ends.end(), [&](const DesignRating& end) {
      return end.rank == best_.rating.rank &&
             std::abs(end.value - best_.rating.value) <= equal_end_tolerance * std::abs(best_.rating.value);
    }));
  }

  bool have_searches_agreed(const std::vector<DesignRating>& ends) const {
    const int searches = budget_.local_searches;
    return searches >= min_exchange_searches && count_equal_ends(ends) >= min_equal_ends;
  }

  /// The combination nearest to the start values, number by number; std::nullopt if there is none.
  std::optional<VectorX> first_start() const {
    std::optional<VectorX> start;
    CombinationVisitor(problem_, order_).run([&](const VectorX& first) {
      start = first;
      return false;
    });
    return start;
  }

  /// @param any a combination, whose sizes do not matter
  VectorX random_start(const VectorX& any) {
    VectorX x = any;
    std::vector<bool> is_set(problem_.variables.size(), false);
    for (const int i : order_) {
      const auto k = static_cast<std::size_t>(i);
      std::vector<double> sizes = problem_.variables[k].discrete_values;
      is_set[k] = true;
      std::erase_if(sizes, [&](double size) {
        x[i] = size;
        return all_different_.is_violated_by(i, x, is_set) || !all_different_.can_complete(x, is_set);
      });
      x[i] = sizes[static_cast<std::size_t>(random_(0, static_cast<double>(sizes.size())))];
    }
    return x;
  }

  /// x with another size of a variable. If another variable must differ from it and has that size, they are swapped.
  /// @return std::nullopt if that is impossible
  std::optional<VectorX> exchange(const VectorX& x, int variable, double size) const {
    VectorX y = x;
    y[variable] = size;
    for (const int other : all_different_.find_equal(variable, y)) {
      const std::vector<double>& sizes = problem_.variables[static_cast<std::size_t>(other)].discrete_values;
      y[other] = *std::min_element(sizes.begin(), sizes.end(), [own = x[variable]](double a, double b) {
        return std::abs(a - own) < std::abs(b - own);
      });
    }
    return all_different_.is_violated(y) ? std::nullopt : std::optional<VectorX>(y);
  }

  bool try_combination(const VectorX& x, SizeSearchResult& end) {
    tried_.emplace(x.begin(), x.end());
    const bool is_better = rater_.keep_better(x, end);
    ++best_.combinations;
    return is_better;
  }

  /// The best design that single exchanges lead to.
  SizeSearchResult descend(const VectorX& start) {
    SizeSearchResult end;
    try_combination(start, end);
    VectorX x = start;
    for (bool has_improved = true; has_improved;) {
      has_improved = false;
      for (const int i : order_)
        for (const double size : problem_.variables[static_cast<std::size_t>(i)].discrete_values) {
          if (is_spent()) return end;
          if (size == x[i]) continue;
          const std::optional<VectorX> candidate = exchange(x, i, size);
          if (!candidate || !try_combination(*candidate, end)) continue;
          x = end.x;
          has_improved = true;
        }
    }
    return end;
  }

  const DesignProblem& problem_;
  AllDifferent all_different_;
  SearchBudget& budget_;
  long max_combinations_;
  CombinationRater& rater_;
  std::vector<int> order_;
  numerics::UniformRandom random_;
  SizeSearchResult best_;
  std::set<std::vector<double>> tried_;
};

}  // namespace

SizeSearchResult try_all_sizes(const DesignProblem& problem, SearchBudget& budget) {
  constexpr long max_single_descent = 1000;
  SizeSearchResult result;
  budget.begin_search();
  CombinationRater rater(problem, budget);
  SizeExchange exchange(problem, budget, rater, max_single_descent);
  result = exchange.descend_from_start();
  result.combinations = exchange.tried_count();
  result.is_exhausted = CombinationVisitor(problem, rater.variable_order()).run([&](const VectorX& x) {
    if (budget.is_spent()) return false;
    if (exchange.has_tried(x)) return true;
    rater.keep_better(x, result);
    if (budget.is_past_deadline()) return false;
    ++result.combinations;
    return true;
  });
  budget.finish_search();
  return result;
}

SizeSearchResult exchange_sizes(const DesignProblem& problem, SearchBudget& budget, long max_combinations) {
  budget.begin_search();
  CombinationRater rater(problem, budget);
  SizeSearchResult result = SizeExchange(problem, budget, rater, max_combinations).run();
  budget.finish_search();
  return result;
}

}  // namespace balance::design
