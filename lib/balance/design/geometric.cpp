#include "balance/design/geometric.hpp"

#include "balance/design/exact.hpp"
#include "balance/design/limits.hpp"
#include "balance/design/maxima_search.hpp"
#include "balance/design/optimum.hpp"
#include "balance/design/restricted.hpp"
#include "balance/design/seek.hpp"
#include "balance/design/trial.hpp"
#include "balance/design/two_levels.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace balance::designing {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
/// Exact designs whose lengths are looked at, and joint descents for them besides the start's.
constexpr int most_designs = 4, joint_starts = 12;
/// Of the designs that two levels find.
constexpr std::size_t most_looks = 3;
/// Lengths moved by this part of their range show whether designs exist around.
constexpr double nearby = 1e-3;

class GeometrySearch {
 public:
  GeometrySearch(const Context& context, const VectorX& anchor, const Equations& equations, const FigureOfMerit* merit)
      : context_(context),
        anchor_(anchor),
        equations_(equations),
        merit_(merit),
        trials_(context, equations, merit),
        lengths_(geometric_numbers(context)),
        others_(inertial_numbers(context)) {}

  GeometricDesign run() {
    Trial best;
    const bool able = try_two_levels(best);
    if (!best.balanced)
      for (const VectorX& u : find_designs()) {
        consider(best, u);
        if (merit_ == nullptr && best.balanced) break;
      }
    if (!best.balanced) trials_.improve(best, balanced_elsewhere());
    if (merit_ != nullptr && best.balanced)
      best = improved(best, able && context_.limits->size() == context_.problem.bounded);
    if (!best.balanced) best = compromise(best);
    if (best.possible && equations_.conditions == 0 && context_.limits->size() == 0) descend_together(best);
    return report(best);
  }

 private:
  /// @return the problem is of the kind that it is made for
  bool try_two_levels(Trial& best) {
    const TwoLevelDesigns designs = search_two_levels(context_, anchor_, merit_, false);
    std::size_t looked = 0;
    for (const VectorX& u : designs.balanced) {
      if (best.balanced && (merit_ == nullptr || ++looked >= most_looks || context_.budget.spent())) break;
      if (!context_.obstacle(u).empty()) continue;
      consider(best, equations_.conditions > 0 ? gauss_newton(equations_near(context_, u, equations_), u).u : u);
      trials_.improve(best, trials_.at(u));
    }
    others_found_ = designs.others;
    return designs.able;
  }

  /// An exact design, or nearly one, as it stands and with the masses solved for.
  void consider(Trial& best, const VectorX& u) const {
    trials_.improve(best, trials_.as_it_is(u));
    if (merit_ == nullptr && best.balanced) return;
    trials_.improve(best, trials_.at(u));
    if (const auto special = at_special_lengths(context_, u); special && !best.balanced)
      trials_.improve(best, trials_.at(*special));
  }

  /// Joint Gauss–Newton on all numbers.
  std::vector<VectorX> find_designs() {
    if (equations_.conditions == 0) return {anchor_};
    Effort effort;
    effort.first.push_back(anchor_);
    for (const VectorX& u : prepared()) effort.first.push_back(u);
    effort.restarts = context_.problem.search.restarts;
    effort.wanted = merit_ == nullptr ? 1 : most_designs;
    effort.usable = [this](const VectorX& u) {
      if (!context_.obstacle(u).empty()) return false;
      if (merit_ == nullptr || std::isfinite((*merit_)(u, nullptr))) return true;
      if (trials_.is_balanced(u)) valueless_ = u;
      return false;
    };
    ExactSearch search = find_exact(context_, equations_, effort);
    best_descent_ = search.best;
    for (VectorX& u : search.solutions)
      if (const VectorX better = gauss_newton(equations_, u).u; is_exact(context_, equations_, better)) u = better;
    return search.solutions;
  }

  /// Lengths that fill their box, each with the other numbers that leave the least there: the best of them.
  std::vector<VectorX> prepared() {
    std::vector<std::pair<double, VectorX>> points;
    const int count = 8 + 8 * static_cast<int>(lengths_.size());
    for (const VectorX& part : spread_points(count, static_cast<int>(lengths_.size()), context_.problem.search.seed)) {
      if (context_.budget.spent()) break;
      VectorX u = anchor_;
      u(lengths_) = part;
      ++context_.budget.geometries;
      const Descent descent = others_only(u);
      if (descent.values.size() > 0 && context_.obstacle(descent.u).empty())
        points.emplace_back(descent.values.squaredNorm(), descent.u);
    }
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<VectorX> starts;
    for (std::size_t k = 0; k < std::min<std::size_t>(points.size(), joint_starts); ++k)
      starts.push_back(points[k].second);
    samples_ = std::move(points);
    return starts;
  }

  /// Gauss–Newton on the numbers that do not change the geometry, on the goal's rows at fixed samples.
  Descent others_only(const VectorX& u) const {
    Equations part = equations_;
    part.evaluate = [this, &u](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      VectorX all = u;
      all(others_) = v;
      MatrixX slopes;
      if (!equations_.evaluate(all, values, jacobian != nullptr ? &slopes : nullptr)) return false;
      if (jacobian != nullptr) *jacobian = slopes(Eigen::all, others_);
      return true;
    };
    Descent descent = gauss_newton(part, u(others_), 30);
    VectorX all = u;
    all(others_) = descent.u;
    descent.u = all;
    return descent;
  }

  /// Where the joint search found nothing: the best of its samples, solved at their lengths.
  Trial balanced_elsewhere() {
    Trial best;
    trials_.improve(best, trials_.at(anchor_));
    for (std::size_t k = 0; k < std::min<std::size_t>(samples_.size(), joint_starts) && !best.balanced; ++k) {
      if (context_.budget.spent()) break;
      trials_.improve(best, trials_.at(samples_[k].second));
    }
    return best;
  }

  /// Designs exist at lengths around these, not only at them.
  bool is_open(const Trial& trial) const {
    for (const double by : {nearby, -nearby}) {
      VectorX u = trial.u;
      for (std::size_t k = 0; k < lengths_.size(); ++k) {
        double& value = u[lengths_[k]];
        value += value > 0.9 ? -nearby : value < -0.9 ? nearby : (k % 2 == 0 ? by : -by);
      }
      if (trials_.at(u).balanced) return true;
    }
    return false;
  }

  /// Better lengths for an exact design.
  /// @param looked around already, where designs exist at all lengths: two levels do so where they know all limits
  Trial improved(const Trial& from, bool looked) {
    Trial best = from;
    if (!is_open(from)) {
      const Equations here = equations_near(context_, from.u, equations_);
      const auto back = [&](const VectorX& u) { return gauss_newton(here, u).u; };
      const VectorX u = best_exact(context_, *merit_, here, back, {from.u}).u;
      trials_.improve(best, trials_.as_it_is(u));
      trials_.improve(best, trials_.at(best.u));
    } else if (!looked || context_.limits->size() > 0) {  // two levels know peaks by few samples
      descend(
          best, [](const Trial& trial) { return trial.balanced; }, looked);
    }
    return best;
  }

  /// Derivative-free over the lengths, from the best and from points that fill their box.
  /// @param near from the best alone, in small steps
  void descend(Trial& best, const std::function<bool(const Trial&)>& counts, bool near = false) {
    Seek task;
    std::map<std::vector<double>, double> known;
    task.value = [&](const VectorX& part) {
      const std::vector<double> key(part.begin(), part.end());
      if (const auto at_key = known.find(key); at_key != known.end()) return at_key->second;
      VectorX u = best.u;
      u(lengths_) = part;
      const Trial trial = trials_.at(u);
      const double value = trial.possible && counts(trial) ? trials_.cost(trial) : none;
      if (std::isfinite(value)) trials_.improve(best, trial);
      known[key] = value;
      return value;
    };
    task.starts = {best.u(lengths_)};
    const auto n = static_cast<int>(lengths_.size());
    if (!near)
      for (const VectorX& part : spread_points(4 + 4 * n, n, context_.problem.search.seed)) task.starts.push_back(part);
    const std::string& asked = context_.problem.search.local;
    task.method = asked == "cobyla" || asked == "sbplx" || asked == "bobyqa" ? asked : "bobyqa";
    task.descents = near ? 1 : 2;
    task.evaluations = std::min(context_.problem.search.evaluations, near ? 8 + 8 * n : 40 + 40 * n);
    if (near) task.step = 0.01;
    task.finest = 1e-5;
    seek(task, context_.budget);
  }

  /// Without conditions all numbers may go down the figure's slopes at once.
  void descend_together(Trial& best) const {
    if (merit_ == nullptr || !merit_->has_pieces() || context_.budget.spent()) return;
    if (const auto end = least_maxima_from(context_, *merit_, best.u)) trials_.improve(best, trials_.as_it_is(*end));
  }

  /// The least that can be had without balance.
  Trial compromise(Trial best) {
    trials_.improve(best, trials_.at(anchor_));
    if (best_descent_.values.size() > 0) trials_.improve(best, trials_.as_it_is(best_descent_.u));
    for (const VectorX& u : others_found_) trials_.improve(best, trials_.at(u));
    TwoLevelDesigns designs;
    if (trials_.wants_figure()) designs = search_two_levels(context_, anchor_, merit_, true);
    for (const VectorX& u : designs.balanced) trials_.improve(best, trials_.at(u));
    if (best.possible && !designs.able) descend(best, [](const Trial&) { return true; });
    return best;
  }

  GeometricDesign report(const Trial& best) const {
    GeometricDesign design;
    design.found = best.possible;
    design.balanced = best.balanced;
    design.by_residual = !best.balanced && !trials_.wants_figure();
    design.u = best.possible ? best.u : anchor_;
    if (!best.balanced) design.valueless = valueless_;
    return design;
  }

  const Context& context_;
  VectorX anchor_;
  const Equations& equations_;
  const FigureOfMerit* merit_;
  Trials trials_;
  std::vector<int> lengths_, others_;
  std::optional<VectorX> valueless_;
  Descent best_descent_;
  std::vector<VectorX> others_found_;
  std::vector<std::pair<double, VectorX>> samples_;
};

}  // namespace

GeometricDesign search_geometry(const Context& context, const VectorX& anchor, const Equations& equations,
                                const FigureOfMerit* merit) {
  return GeometrySearch(context, anchor, equations, merit).run();
}

}  // namespace balance::designing
