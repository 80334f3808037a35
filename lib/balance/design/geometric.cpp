#include "balance/design/geometric.hpp"

#include "balance/base/error.hpp"
#include "balance/design/exact.hpp"
#include "balance/design/optimum.hpp"
#include "balance/design/restricted.hpp"
#include "balance/design/seek.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace balance::designing {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
/// Exact designs whose lengths are looked at, and joint descents for them besides the start's.
constexpr int most_designs = 4, joint_starts = 12;
/// Lengths moved by this part of their range show whether designs exist around.
constexpr double nearby = 1e-3;

/// Numbers at one geometry, solved for by themselves.
struct Trial {
  VectorX u;              ///< all numbers
  bool possible = false;  ///< no obstacle
  bool balanced = false;
  double figure = none;    ///< the objective
  double residual = none;  ///< norm of what is left of the goal at the equations' samples
};

class GeometrySearch {
 public:
  GeometrySearch(const Context& context, const VectorX& anchor, const Equations& equations, const FigureOfMerit* merit)
      : context_(context),
        anchor_(anchor),
        equations_(equations),
        merit_(merit),
        lengths_(geometric_numbers(context)),
        others_(inertial_numbers(context)) {}

  GeometricDesign run() {
    std::vector<VectorX> exact = find_designs();
    Trial best;
    for (const VectorX& u : exact) {
      improve(best, as_it_is(u));
      if (merit_ == nullptr && best.balanced) break;
      improve(best, at(u));
      if (const auto special = at_special_lengths(context_, u); special && !best.balanced) improve(best, at(*special));
    }
    if (!best.balanced) improve(best, balanced_elsewhere());
    if (merit_ != nullptr && best.balanced) best = improved(best);
    if (!best.balanced) best = compromise(best);
    return report(best);
  }

 private:
  bool wants_figure() const { return merit_ != nullptr && !context_.problem.objective->size; }

  /// Balanced before not, then by the objective, or by what is left.
  double cost(const Trial& trial) const {
    if (trial.balanced) return merit_ != nullptr ? trial.figure : 0;
    return wants_figure() ? trial.figure : trial.residual;
  }
  void improve(Trial& best, Trial trial) const {
    if (!trial.possible || !std::isfinite(cost(trial))) return;
    const bool better = !best.possible || (trial.balanced && !best.balanced) ||
                        (trial.balanced == best.balanced && cost(trial) < cost(best));
    if (better) best = std::move(trial);
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
      if (is_balanced(u)) valueless_ = u;
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

  /// A design of the joint search as it stands.
  Trial as_it_is(const VectorX& u) const {
    Trial trial{u, context_.obstacle(u).empty(), false, none, none};
    if (!trial.possible) return trial;
    trial.balanced = is_balanced(u);
    measure(trial);
    return trial;
  }

  /// By the conditions of its own geometry, derived anew.
  bool is_balanced(const VectorX& u) const {
    const Conditions conditions = context_.conditions_at(u);
    if (conditions.status != ConditionsStatus::done || !context_.is_physical(u)) return false;
    if (conditions.own_rows() == 0) return true;
    const VectorX residual =
        scaled_residuals(conditions, term_values(context_.mechanism(u), context_.options.loose_springs))
            .head(conditions.own_rows());
    return residual.cwiseAbs().maxCoeff() < met;
  }

  void measure(Trial& trial) const {
    if (merit_ != nullptr && !std::isfinite(trial.figure)) trial.figure = (*merit_)(trial.u, nullptr);
    VectorX values;
    trial.residual = equations_.conditions == 0                      ? 0
                     : equations_.evaluate(trial.u, values, nullptr) ? values.head(equations_.conditions).norm()
                                                                     : none;
  }

  /// At the lengths of u: the other numbers solved for by themselves.
  Trial at(const VectorX& u) const {
    Trial trial{u, false, false, none, none};
    if (!context_.obstacle(u).empty()) return trial;
    ++context_.budget.geometries;
    try {
      const VectorX x = context_.box.numbers(u);
      const DesignProblem inner = at_fixed_geometry(context_, x, context_.budget.left());
      const DesignOutcome outcome = solve(inner);
      if (outcome.status == DesignStatus::unsolved || outcome.status == DesignStatus::not_found) return trial;
      trial.balanced = outcome.status == DesignStatus::balanced || outcome.status == DesignStatus::not_asked;
      for (std::size_t k = 0; k < others_.size(); ++k) {
        const auto i = others_[k];
        const double half = context_.box.half()[i];
        trial.u[i] = half > 0 ? std::clamp((outcome.x[static_cast<Eigen::Index>(k)] - context_.box.centre()[i]) / half,
                                           -1.0, 1.0)
                              : 0;
      }
      trial.possible = context_.is_physical(trial.u);
      trial.figure = outcome.objective;
      measure(trial);
    } catch (const SpecError&) {
      trial.possible = false;  // an expression of the spec has no value here
    } catch (const std::invalid_argument&) {
      trial.possible = false;
    }
    return trial;
  }

  /// Where the joint search found nothing: the best of its samples, solved at their lengths.
  Trial balanced_elsewhere() {
    Trial best;
    improve(best, at(anchor_));
    for (std::size_t k = 0; k < std::min<std::size_t>(samples_.size(), joint_starts) && !best.balanced; ++k) {
      if (context_.budget.spent()) break;
      improve(best, at(samples_[k].second));
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
      if (at(u).balanced) return true;
    }
    return false;
  }

  /// Better lengths for an exact design.
  Trial improved(const Trial& from) {
    Trial best = from;
    if (!is_open(from)) {
      const auto back = [&](const VectorX& u) { return gauss_newton(equations_, u).u; };
      const VectorX u = best_exact(context_, *merit_, equations_, back, {from.u}).u;
      improve(best, as_it_is(u));
      improve(best, at(best.u));
      return best;
    }
    descend(best, [](const Trial& trial) { return trial.balanced; });
    return best;
  }

  /// Derivative-free over the lengths, from the best and from points that fill their box.
  void descend(Trial& best, const std::function<bool(const Trial&)>& counts) {
    Seek task;
    std::map<std::vector<double>, double> known;
    task.value = [&](const VectorX& part) {
      const std::vector<double> key(part.begin(), part.end());
      if (const auto at_key = known.find(key); at_key != known.end()) return at_key->second;
      VectorX u = best.u;
      u(lengths_) = part;
      const Trial trial = at(u);
      const double value = trial.possible && counts(trial) ? cost(trial) : none;
      if (std::isfinite(value)) improve(best, trial);
      known[key] = value;
      return value;
    };
    task.starts = {best.u(lengths_)};
    const auto n = static_cast<int>(lengths_.size());
    for (const VectorX& part : spread_points(4 + 4 * n, n, context_.problem.search.seed)) task.starts.push_back(part);
    const std::string& asked = context_.problem.search.local;
    task.method = asked == "cobyla" || asked == "sbplx" || asked == "bobyqa" ? asked : "bobyqa";
    task.descents = 2;
    task.evaluations = std::min(context_.problem.search.evaluations, 40 + 40 * n);
    task.finest = 1e-5;
    seek(task, context_.budget);
  }

  /// The least that can be had without balance.
  Trial compromise(Trial best) {
    improve(best, at(anchor_));
    if (best_descent_.values.size() > 0) improve(best, as_it_is(best_descent_.u));
    if (best.possible) descend(best, [](const Trial&) { return true; });
    return best;
  }

  GeometricDesign report(const Trial& best) const {
    GeometricDesign design;
    design.found = best.possible;
    design.balanced = best.balanced;
    design.by_residual = !best.balanced && !wants_figure();
    design.u = best.possible ? best.u : anchor_;
    if (!best.balanced) design.valueless = valueless_;
    return design;
  }

  const Context& context_;
  VectorX anchor_;
  const Equations& equations_;
  const FigureOfMerit* merit_;
  std::vector<int> lengths_, others_;
  std::optional<VectorX> valueless_;
  Descent best_descent_;
  std::vector<std::pair<double, VectorX>> samples_;
};

}  // namespace

GeometricDesign search_geometry(const Context& context, const VectorX& anchor, const Equations& equations,
                                const FigureOfMerit* merit) {
  return GeometrySearch(context, anchor, equations, merit).run();
}

}  // namespace balance::designing
