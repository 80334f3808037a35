#include "balance/analysis/front_study.hpp"

#include "balance/analysis/front_search.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace balance {

namespace {

/// Parts of the front's extent: by which a figure may be above its least one at an end, and by which designs differ.
constexpr double at_end = 1e-5, apart = 1e-4;
/// A gap of this part of the extent is none.
constexpr double no_gap = 1e-5;
/// Searches per point wanted, where some find nothing new.
constexpr int patience = 3;
constexpr int most_rounds = 4;

class FrontBuilder {
 public:
  FrontBuilder(const DesignSpace& space, const DesignStudyOptions& options)
      : wanted_(space.start.design.front.points),
        figures_(static_cast<int>(space.start.design.front.figures.size())),
        search_(space, options, wanted_ + figures_ * figures_) {}

  Front run() {
    if (find_ends()) figures_ == 2 ? fill_line() : fill_grid();
    drop_dominated();
    if (!front_.points.empty()) measure();
    for (FrontPoint& point : front_.points) point.optimality = judge(point), search_.tell_cases(point);
    front_.searches = search_.searches();
    front_.stopped = search_.stopped();
    return std::move(front_);
  }

 private:
  using Places = std::vector<FrontPoint>;

  /// Every figure alone, then the others as small as that allows. @return there is something between the ends
  bool find_ends() {
    for (int i = 0; i < figures_; ++i) {
      auto alone = search_.find({i, search_.no_limits(), {}});
      if (!alone && front_.points.empty()) front_.failure = search_.failure();
      if (!alone) return false;
      const DesignOutcome& outcome = alone->report.outcome;
      front_.ends.push_back({alone->values[i], outcome.lower_bound, outcome.optimality});
      front_.points.push_back(std::move(*alone));
    }
    measure();
    for (int i = 0; i < figures_; ++i) settle_end(front_.points[static_cast<std::size_t>(i)], i);
    measure();
    if ((extent_.array() > 0).any()) return true;
    front_.notes.emplace_back("the figures are no trade-off: one design is the best in all of them");
    front_.points.erase(front_.points.begin() + 1, front_.points.end());
    return false;
  }

  /// Least and extent of each figure over all points; an extent within round-off is none.
  void measure() {
    least_ = front_.points.front().values;
    VectorX most = least_;
    for (const FrontPoint& point : front_.points) {
      least_ = least_.cwiseMin(point.values);
      most = most.cwiseMax(point.values);
    }
    extent_ = most - least_;
    for (Eigen::Index j = 0; j < extent_.size(); ++j)
      if (!(extent_[j] > 1e-7 * std::abs(most[j]))) extent_[j] = 0;
  }

  Optimality judge(const FrontPoint& point) const {
    const bool proved = point.report.outcome.optimality == Optimality::proved_best;
    if (proved || point.gap() <= no_gap * extent_[point.minimized]) return Optimality::proved_best;
    return point.report.outcome.optimality == Optimality::stopped ? Optimality::stopped : Optimality::local_best;
  }

  VectorX slack() const { return apart * extent_; }

  /// Again, from there and from another end's design, while that helps and nothing is proved.
  void settle_end(FrontPoint& end, int i) {
    const double allowed = end.values[i];
    for (int round = 0; round < most_rounds; ++round) {
      const VectorX before = end.values;
      const FrontPoint& other = front_.points[static_cast<std::size_t>((i + 1) % figures_)];
      refine_end(end, i, allowed, (round % 2 == 0 ? end : other).report.outcome.x);
      const bool better = ((before - end.values).array() > slack().array()).any();
      if (end.report.outcome.optimality == Optimality::proved_best || search_.stopped()) return;
      if (round > 0 && !better) return;
    }
  }

  /// @param allowed of figure i
  void refine_end(FrontPoint& end, int i, double allowed, const VectorX& start) {
    VectorX limits = search_.no_limits();
    limits[i] = allowed + std::max(at_end * extent_[i], 1e-9 * std::abs(allowed));
    for (int k = 1; k < figures_; ++k) {
      const int j = (i + k) % figures_;
      if (extent_[i] == 0 && extent_[j] == 0) continue;
      VectorX others = limits;
      others[j] = std::numeric_limits<double>::quiet_NaN();
      auto better = search_.find({j, others, k == 1 ? start : end.report.outcome.x});
      if (!better) return;
      if (better->values[j] <= end.values[j]) end = std::move(*better);
      limits[j] = end.values[j] + std::max(at_end * extent_[j], 1e-9 * std::abs(end.values[j]));
    }
  }

  void sort() {
    std::stable_sort(front_.points.begin(), front_.points.end(),
                     [](const FrontPoint& a, const FrontPoint& b) { return a.values[0] < b.values[0]; });
  }

  bool is_new(const FrontPoint& point) const {
    return std::none_of(front_.points.begin(), front_.points.end(), [&](const FrontPoint& other) {
      return ((point.values - other.values).cwiseAbs().array() <= slack().array()).all();
    });
  }

  /// Of designs that do not differ the first stays.
  void drop_dominated() {
    if (front_.points.empty()) return;
    measure();
    sort();
    const Places all = std::exchange(front_.points, {});
    for (const FrontPoint& one : all) {
      const bool worse = std::any_of(all.begin(), all.end(), [&](const FrontPoint& other) {
        return dominates(other.values, one.values, VectorX::Zero(figures_));
      });
      if (!worse && is_new(one)) front_.points.push_back(one);
    }
  }

  /// Halves the longest open stretch between neighbours until there are enough points. What a better design makes dominated goes,
  /// and its stretch is searched again from the designs beside it.
  void fill_line() {
    const int most = search_.searches() + patience * wanted_;
    for (drop_dominated(); static_cast<int>(front_.points.size()) < wanted_ && search_.searches() < most;) {
      const int k = longest_open();
      if (k < 0) return;
      halve(static_cast<std::size_t>(k));
      if (search_.stopped()) return;
    }
  }

  double length(std::size_t k) const {
    return ((front_.points[k + 1].values - front_.points[k].values).array() / extent_.array()).matrix().norm();
  }

  std::pair<double, double> stretch(std::size_t k) const {
    return {front_.points[k].values[0], front_.points[k + 1].values[0]};
  }

  int longest_open() const {
    int longest = -1;
    for (std::size_t k = 0; k + 1 < front_.points.size(); ++k)
      if (closed_.count(stretch(k)) == 0 && (longest < 0 || length(k) > length(static_cast<std::size_t>(longest))))
        longest = static_cast<int>(k);
    return longest;
  }

  void halve(std::size_t k) {
    const FrontPoint &a = front_.points[k], &b = front_.points[k + 1];
    const VectorX change = ((b.values - a.values).array() / extent_.array()).abs();
    const int limited = change[1] >= change[0] ? 1 : 0;
    const FrontPoint& within = limited == 1 ? b : a;
    FrontWish wish{1 - limited, search_.no_limits(), within.report.outcome.x};
    wish.limits[limited] = (a.values[limited] + b.values[limited]) / 2;
    const VectorX here = within.report.outcome.x, there = (limited == 1 ? a : b).report.outcome.x;
    auto found = search_.find(wish);
    for (const VectorX& start : {VectorX((here + there) / 2), there}) {  // a search may stay where it starts
      if (found && is_new(*found)) break;
      wish.start = start;
      found = search_.find(wish);
    }
    if (!found || !is_new(*found)) return void(closed_.insert(stretch(k)));
    front_.points.push_back(std::move(*found));
    drop_dominated();
    measure();  // an end may have been dominated
  }

  /// Rows of points: the second figure is limited at places spread over its extent, and each row is spread over what that leaves to the
  /// third.
  void fill_grid() {
    const int side = std::max(2, static_cast<int>(std::sqrt(static_cast<double>(wanted_))));
    for (int row = 0; row < side && !search_.stopped(); ++row) fill_row(row / (side - 1.0), side);
  }

  void fill_row(double part, int side) {
    VectorX limits = search_.no_limits();
    limits[1] = least_[1] + std::max(std::max(part, at_end) * extent_[1], 1e-9 * std::abs(least_[1]));
    const auto first = best_in(0, limits), last = best_in(2, limits);
    if (!first || !last) return;
    for (int column = 1; column + 1 < side; ++column) {
      limits[2] = last->values[2] + column / (side - 1.0) * (first->values[2] - last->values[2]);
      if (first->values[2] - last->values[2] > slack()[2]) best_in(0, limits);
    }
  }

  /// Kept if it is new. Where a limit is not reached, its figure may still become smaller for nothing; so may one without a limit.
  std::optional<FrontPoint> best_in(int i, const VectorX& limits) {
    auto found = search_.find({i, limits, nearest_within(limits)});
    if (!found || !is_new(*found)) {  // a search may stay where it starts
      auto other = search_.find({i, limits, {}});
      if (other && (!found || other->values[i] < found->values[i] || is_new(*other))) found = std::move(other);
    }
    if (!found) return found;
    for (int j = 0; j < figures_; ++j)
      if (j != i && !(found->values[j] >= limits[j] - slack()[j])) refine(*found, j);
    if (is_new(*found)) front_.points.push_back(*found);
    return found;
  }

  void refine(FrontPoint& point, int j) {
    FrontWish wish{j, point.values, point.report.outcome.x};
    for (int i = 0; i < figures_; ++i)
      wish.limits[i] += std::max(at_end * extent_[i], 1e-9 * std::abs(point.values[i]));
    wish.limits[j] = std::numeric_limits<double>::quiet_NaN();
    auto better = search_.find(wish);
    if (better && better->values[j] <= point.values[j]) point = std::move(*better);
  }

  /// The known design that is least beyond the limits.
  VectorX nearest_within(const VectorX& limits) const {
    const auto beyond = [&](const FrontPoint& point) {
      double worst = -std::numeric_limits<double>::infinity();
      for (int j = 0; j < figures_; ++j)
        if (!std::isnan(limits[j]))
          worst = std::max(worst, (point.values[j] - limits[j]) / std::max(extent_[j], 1e-300));
      return worst;
    };
    const auto best = std::min_element(front_.points.begin(), front_.points.end(),
                                       [&](const FrontPoint& a, const FrontPoint& b) { return beyond(a) < beyond(b); });
    return best->report.outcome.x;
  }

  int wanted_, figures_;
  FrontSearch search_;
  Front front_;
  VectorX least_, extent_;
  std::set<std::pair<double, double>>
      closed_;  ///< stretches, by the first figure's values, between which nothing was found
};

}  // namespace

Front front_study(const DesignSpace& space, const DesignStudyOptions& options) {
  if (!space.start.design.front) throw std::invalid_argument("the spec asks for no front");
  return FrontBuilder(space, options).run();
}

}  // namespace balance
