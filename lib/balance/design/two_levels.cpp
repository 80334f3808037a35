#include "balance/design/two_levels.hpp"

#include "balance/base/error.hpp"
#include "balance/base/extrema.hpp"
#include "balance/design/inner_problem.hpp"
#include "balance/design/limits.hpp"
#include "balance/design/nlopt_search.hpp"
#include "balance/design/restricted.hpp"
#include "balance/design/seek.hpp"
#include "balance/design/solve.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

/// What is left of conditions that can be met, at round-off of the inner problem.
constexpr double met_by_search = 1e-7;
/// A descent is done where this little is left.
constexpr double as_good_as_none = 1e-10;
/// Points to start from; local searches.
constexpr int fewest_points = 48, points_per_number = 24, most_descents = 12, most_figure_descents = 5,
              descent_evaluations = 60;
/// Starts nearer to each other than this, in unit coordinates, are one.
constexpr double apart = 0.15;
/// Ends whose values differ by less than this part are as good as each other.
constexpr double same_end = 1e-5;
/// Part of the time that looking around may take.
constexpr double for_looking = 0.3;
/// Times that limits are tightened, by so many times what they are missed by; not those that are missed by more than that part.
constexpr int most_tightenings = 3;
constexpr double more_than_needed = 1.5, out_of_reach = 0.1;
/// Numbers that the model is not made for: its classification takes their square.
constexpr int most_numbers = 60;

class TwoLevels {
 public:
  TwoLevels(const Context& context, const VectorX& anchor, const FigureOfMerit* merit, bool regardless)
      : context_(context),
        anchor_(anchor),
        conditions_(!context.problem.goals.empty() && !regardless),
        figure_(merit != nullptr || context.problem.bounded_at != nullptr),
        merit_(merit) {}

  TwoLevelDesigns run() {
    TwoLevelDesigns designs;
    if (!able()) return designs;
    designs.able = true;
    const std::vector<InnerSolution> points = look_around();
    if (conditions_) balance_from(points);
    if (figure_) improve_from(points);
    if (context_.problem.bounded_at) tighten();
    collect(designs);
    return designs;
  }

 private:
  using Aim = InnerProblem::Aim;

  bool able() {
    if (context_.problem.modular || context_.box.size() > most_numbers) return false;
    if (merit_ != nullptr && !context_.problem.figures_at && !context_.problem.least_beyond) return false;
    const std::optional<std::vector<bool>> matters = what_matters();
    if (!matters) return false;
    model_.emplace(context_, anchor_, *matters);
    if (model_->outer().empty()) return false;
    if (merit_ != nullptr && !context_.problem.least_beyond) size_ = size_of_figure();
    return true;
  }

  /// What the figure is with the anchor's masses, or with middling ones: added mass may be none to begin with.
  double size_of_figure() const {
    VectorX middling = anchor_;
    for (const int i : inertial_numbers(context_)) middling[i] = 0;
    double size = 0;
    for (const VectorX& u : {anchor_, middling})
      if (const double value = std::abs((*merit_)(u, nullptr)); std::isfinite(value)) size = std::max(size, value);
    return size > 0 ? size : 1;
  }

  /// Terms that occur in a condition or in the figure.
  std::optional<std::vector<bool>> what_matters() const {
    const Mechanism mechanism = context_.mechanism(anchor_);
    std::vector<bool> matters(list_terms(mechanism, context_.options.loose_springs).size(), false);
    if (conditions_) {
      MatrixX rows;
      try {
        if (!GoalResidual(mechanism, context_.problem.goals, context_.options).rows(mechanism, rows)) return {};
      } catch (const std::invalid_argument&) {
        return {};
      }
      const double largest = max_abs(rows.colwise().norm());
      for (std::size_t k = 0; k < matters.size(); ++k)
        matters[k] = rows.col(static_cast<Eigen::Index>(k)).norm() > 1e-12 * largest;
    }
    const VectorX x = context_.box.numbers(anchor_);
    if (context_.problem.figures_at) {
      const auto figures = context_.problem.figures_at(x);
      if (!figures) return {};
      mark_what_matters(*figures, matters);
    }
    if (!context_.problem.bounded_at) return matters;
    const auto limits = context_.problem.bounded_at(x);
    if (!limits) return {};
    for (const BoundedFigures& limit : *limits) mark_what_matters(limit.figures, matters);
    return matters;
  }

  VectorX outer_of(const VectorX& u) const { return u(model_->outer()); }
  VectorX with(const VectorX& part) const {
    VectorX u = anchor_;
    u(model_->outer()) = clipped(part);
    return u;
  }

  Aim aim() const { return !figure_ ? Aim::residual : conditions_ ? Aim::both : Aim::figure; }

  /// The anchor and points that fill the box; where the anchor's configurations do not exist, with their own.
  std::vector<InnerSolution> look_around() {
    const auto n = static_cast<int>(model_->outer().size());
    std::vector<VectorX> places = {anchor_};
    for (const VectorX& part :
         spread_points(std::max(fewest_points, points_per_number * n), n, context_.problem.search.seed))
      places.push_back(with(part));
    const double reserve = (1 - for_looking) * context_.budget.left();
    InnerProblem near(context_, *model_, aim(), size_);
    const bool centred = near.centre(anchor_);
    std::vector<InnerSolution> points;
    for (const VectorX& u : places) {
      if (context_.budget.left() < reserve) break;
      InnerSolution solution = centred ? near.at(u) : InnerSolution{};
      if (!solution.found && conditions_ && context_.obstacle(u).empty()) {
        InnerProblem own(context_, *model_, aim(), size_);
        if (own.centre(u)) solution = own.at(u);
      }
      if (solution.found) points.push_back(std::move(solution));
    }
    return points;
  }

  /// The best by `cost` that are apart from each other.
  template <class Cost>
  std::vector<VectorX> best_apart(const std::vector<InnerSolution>& points, int count, const Cost& cost) const {
    std::vector<std::pair<double, VectorX>> all;
    for (const InnerSolution& point : points) all.emplace_back(cost(point), outer_of(point.u));
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<VectorX> chosen;
    for (const auto& [value, v] : all) {
      if (static_cast<int>(chosen.size()) >= count) break;
      if (std::none_of(chosen.begin(), chosen.end(), [&, &v = v](const VectorX& c) { return (c - v).norm() < apart; }))
        chosen.push_back(v);
    }
    return chosen;
  }

  void keep(const InnerSolution& solution) {
    if (solution.found) ends_.push_back(solution);
  }

  std::vector<InnerSolution>::const_iterator best_end() const {
    return std::min_element(ends_.begin(), ends_.end(), [](const auto& a, const auto& b) { return a.value < b.value; });
  }

  /// Of the local searches those that end as well as the best of them does.
  static int count_alike(const std::vector<double>& values) {
    if (values.empty()) return 0;
    const double best = *std::min_element(values.begin(), values.end());
    return static_cast<int>(std::count_if(values.begin(), values.end(), [best](double value) {
      return std::abs(value - best) <= same_end * std::abs(best);
    }));
  }

  /// Lengths at which the conditions can be met.
  void balance_from(const std::vector<InnerSolution>& points) {
    int found = 0;
    const bool open =
        std::any_of(points.begin(), points.end(), [](const auto& p) { return p.residual < met_by_search; });
    if (figure_ && open) return;  // the figure's own descents find their way
    for (const VectorX& v : best_apart(points, most_descents, [](const auto& p) { return p.residual; })) {
      if (context_.budget.spent() || found > (figure_ ? 2 : 0)) break;
      const InnerSolution end = to_balance(v);
      keep(end);
      if (end.found && end.residual < met_by_search) ++found;
    }
  }

  /// Levenberg–Marquardt on what is left with the best masses (variable projection).
  InnerSolution to_balance(const VectorX& start) {
    ++context_.budget.starts;
    InnerProblem inner(context_, *model_, Aim::residual, 1);
    InnerSolution last;
    if (!inner.centre(with(start))) return last;
    Equations equations;
    equations.evaluate = [&](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      if (!last.found || outer_of(last.u) != v) {
        InnerSolution next = inner.at(with(v));
        if (!next.found || (values.size() > 0 && next.left.size() != values.size())) return false;
        last = std::move(next);
      }
      values = last.left;
      if (last.residual < as_good_as_none || context_.budget.spent()) values.setZero();  // the end
      if (jacobian != nullptr) *jacobian = inner.reduced_jacobian(last);
      return jacobian == nullptr || jacobian->allFinite();
    };
    const Descent descent = gauss_newton(equations, start, 40);
    if (!last.found || outer_of(last.u) != descent.u) last = inner.at(with(descent.u));
    return last;
  }

  void improve_from(const std::vector<InnerSolution>& points) {
    std::vector<InnerSolution> all = points;
    for (const InnerSolution& end : ends_) all.push_back(end);
    const int count = std::min(most_figure_descents, 1 + static_cast<int>(model_->outer().size()));
    std::vector<double> values;
    for (const VectorX& v : best_apart(all, count, [](const auto& p) { return p.value; })) {
      if (context_.budget.spent()) break;
      const InnerSolution end = down_from(v);
      if (end.found) values.push_back(end.value);
      keep(end);
    }
    context_.budget.alike = count_alike(values);
    for (const InnerSolution& point : points) keep(point);
    const auto best = best_end();
    if (best != ends_.end() && !context_.budget.spent()) keep(polished_end(outer_of(best->u)));
  }

  /// Looks at points and keeps the best.
  struct Lookout {
    const TwoLevels& search;
    InnerProblem inner;
    InnerSolution best = {};

    double operator()(const VectorX& v, VectorX* slope) {
      ++search.context_.budget.evaluations;
      InnerSolution here = inner.at(search.with(v));
      if (!here.found) return std::numeric_limits<double>::quiet_NaN();
      if (slope != nullptr) *slope = inner.gradient(here);
      if (slope != nullptr && !slope->allFinite()) slope->setZero(v.size());
      const double value = here.value;
      if (!best.found || value < best.value) best = std::move(here);
      return value;
    }
  };

  /// How far the design is beyond the limits as they are told; what the search knows of them are few samples.
  double beyond(const InnerSolution& end) const {
    VectorX g;
    context_.limits->evaluate(model_->recovered(end.u, end.unknowns), g, nullptr);
    return g.size() == 0 ? 0 : g.allFinite() ? -min_coefficient(g) : std::numeric_limits<double>::infinity();
  }

  /// From the best end on, with as much to spare as it is beyond the limits.
  void tighten() {
    if (ends_.empty()) return;
    InnerSolution end = *best_end();
    for (int round = 0; round < most_tightenings && !context_.budget.spent(); ++round) {
      const double over = beyond(end);
      if (!(over > kept && over < out_of_reach)) return;
      spare_ += more_than_needed * over;
      end = down_from(outer_of(end.u));
      if (end.found) end = polished_end(outer_of(end.u));
      if (!end.found) return;
      keep(end);
    }
  }

  /// Down the figure's slope.
  InnerSolution down_from(const VectorX& start) {
    Lookout look{*this, InnerProblem(context_, *model_, aim(), size_, spare_)};
    const std::string& asked = context_.problem.search.local;
    if (!look.inner.centre(with(start))) return {};
    ++context_.budget.descents;
    Program program;
    program.size = static_cast<int>(start.size());
    program.objective = [&](const VectorX& v, VectorX* slope) { return look(v, slope); };
    const SearchLimits limits{descent_evaluations, context_.budget.left(), 1e-9, 0.1, context_.budget.stopper()};
    search_locally(asked == "auto" ? "slsqp" : asked, program, start, limits);
    return look.best;
  }

  /// Kinks, at which slopes mislead, are left to a search without them.
  InnerSolution polished_end(const VectorX& start) {
    Lookout look{*this, InnerProblem(context_, *model_, aim(), size_, spare_)};
    if (!look.inner.centre(with(start))) return {};
    Seek task;
    task.value = [&](const VectorX& v) { return look(v, nullptr); };
    task.starts = {start};
    task.method = "bobyqa";
    task.descents = 1;
    task.evaluations = 16 + 16 * static_cast<int>(start.size());
    task.step = 0.02;
    task.finest = 1e-6;
    seek(task, context_.budget);
    return look.best;
  }

  void collect(TwoLevelDesigns& designs) {
    const auto cost = [&](const InnerSolution& s) { return figure_ ? s.value : s.residual; };
    std::stable_sort(ends_.begin(), ends_.end(), [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
    if (context_.problem.bounded_at)
      std::stable_partition(ends_.begin(), ends_.end(), [&](const InnerSolution& end) { return beyond(end) <= kept; });
    for (const InnerSolution& end : ends_) {
      const VectorX u = model_->recovered(end.u, end.unknowns);
      std::vector<VectorX>& list = end.residual < met_by_search ? designs.balanced : designs.others;
      const bool known = std::any_of(list.begin(), list.end(), [&](const VectorX& k) { return max_abs(k - u) < 1e-6; });
      if (!known && list.size() < 6) list.push_back(u);
    }
  }

  const Context& context_;
  const VectorX& anchor_;
  bool conditions_, figure_;
  const FigureOfMerit* merit_;
  std::optional<InertialModel> model_;
  double size_ = 1, spare_ = 0;
  std::vector<InnerSolution> ends_;
};

}  // namespace

TwoLevelDesigns search_two_levels(const Context& context, const VectorX& anchor, const FigureOfMerit* merit,
                                  bool regardless) {
  return TwoLevels(context, anchor, merit, regardless).run();
}

}  // namespace balance::designing
