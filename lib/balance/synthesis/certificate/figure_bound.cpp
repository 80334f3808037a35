#include "balance/synthesis/certificate/figure_bound.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>

namespace balance::certificate {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();
/// Relative to the free interval: narrower boxes are not divided.
constexpr double min_divided_width = 1e-6;
/// Relative: changes of the bound that are kept for the progress.
constexpr double figure_progress_step = 1e-4;
/// Relative: at fixed lengths the bound is the least objective, which is computed independently.
constexpr double point_agreement_tolerance = 1e-4;

struct FigureNode {
  LengthBox box;
  double bound = 0;
  VectorX losses;
};

struct HasHigherFigureBound {
  bool operator()(const FigureNode& a, const FigureNode& b) const { return a.bound > b.bound; }
};

}  // namespace

class FigureBoundSearch::Tree {
 public:
  Tree(const DesignSpace& space, const FigureProblem& problem, const ForceRowModel& rows,
       const FigureBoundOptions& options)
      : space_(space), problem_(problem), rows_(rows), options_(options), start_time_(thread_cpu_time()) {
    result_.geometries = {general_lengths_name};
    result_.trajectories = {space.start.trajectories[static_cast<std::size_t>(problem.trajectory)].name};
    FigureNode root;
    root.box = {problem.lower, problem.upper};
    root.losses.setZero(static_cast<Eigen::Index>(problem.lengths.size()));
    result_.reason = find_disagreement();
    if (!result_.reason.empty()) return;
    bound(std::move(root));
    note_progress();
  }

  void run(const std::function<bool()>& interrupted) {
    while (!is_finished() && !(interrupted && interrupted())) {
      FigureNode node = open_.top();
      open_.pop();
      divide(node);
      note_progress();
    }
  }

  void add_design(const VectorX& x, double value) {
    if (!(value < result_.best)) return;
    result_.best = value;
    result_.design = x;
    note_progress();
  }

  bool is_finished() const {
    return !result_.reason.empty() || open_.empty() || result_.nodes >= options_.max_nodes ||
           lower_bound() >= closed_bound_ ||
           (std::isfinite(result_.best) &&
            result_.best - lower_bound() <= options_.gap_tolerance * std::abs(result_.best));
  }

  const VectorX& promising() const { return promising_; }
  double promised_value() const { return promised_value_; }

  LengthBound result() const {
    LengthBound result = result_;
    if (!result.reason.empty()) return result;
    result.lower_bound = std::min(lower_bound(), result.best);
    result.progress.push_back({elapsed(), result.lower_bound, result.best});
    return result;
  }

 private:
  double elapsed() const { return thread_cpu_time() - start_time_; }
  double lower_bound() const {
    const double bound = std::min(open_.empty() ? closed_bound_ : open_.top().bound, closed_bound_);
    return std::isinf(bound) ? result_.best : bound;
  }

  void note_progress() {
    if (!result_.reason.empty()) return;
    const LengthBoundProgress known{elapsed(), std::min(lower_bound(), result_.best), result_.best};
    if (result_.progress.empty() || known.best != result_.progress.back().best ||
        known.lower_bound - result_.progress.back().lower_bound > figure_progress_step * std::abs(known.lower_bound))
      result_.progress.push_back(known);
  }

  VectorX with_lengths(const VectorX& lengths) const {
    VectorX x = space_.start_values();
    for (const int number : problem_.lengths) x[number] = lengths[number];
    return x;
  }

  /// The best masses at given lengths and their multipliers; null: the motion cannot be followed.
  const FigureDual* dual_at(const VectorX& lengths) {
    std::vector<double> key;
    for (const int number : problem_.lengths) key.push_back(lengths[number]);
    const auto [entry, is_new] = duals_.try_emplace(key);
    if (is_new) entry->second = solve_at(with_lengths(lengths));
    return entry->second ? &*entry->second : nullptr;
  }

  std::optional<FigureDual> solve_at(const VectorX& x) {
    try {
      const std::optional<ForceRows> rows = rows_.evaluate(x);
      if (!rows || rows->figures.empty()) return {};
      const VectorX& weights = rows->figures.front().front().time_weights;
      if (time_weights_.size() == 0) time_weights_ = weights;
      if (weights.size() != time_weights_.size()) return {};
      std::optional<FigureDual> dual = solve_figure_dual(problem_, space_.instantiate(x).mechanism, *rows, x);
      if (dual && dual->value < promised_value_) {
        promised_value_ = dual->value;
        promising_ = dual->x;
      }
      return dual;
    } catch (const SpecError&) {  // an expression has no value
      return {};
    }
  }

  /// At the start values' lengths, compares the enclosures with the program's own forces.
  std::string find_disagreement() {
    const VectorX start = space_.start_values();
    const FigureDual* dual = dual_at(start);
    if (!dual) return "the forces along the motion could not be computed at the start values";
    const LengthBox point{with_lengths(start), with_lengths(start)};
    const SampledMotion motion = sample_planar_motion(space_, problem_, with_lengths(start));
    if (motion.points.size() != static_cast<std::size_t>(time_weights_.size()))
      return "the motion has other samples than its figures";
    const std::vector<const FigureDual*> corners(std::size_t(1) << problem_.lengths.size(), dual);
    const FigureBoxBound box = bound_figures(space_, problem_, point, motion, corners, time_weights_);
    if (box.enclosed == 0) return "its closures could not be enclosed at the start values";
    const double scale = std::max(std::abs(dual->value), 1e-9);
    if (dual->value > 1e-9 && std::abs(box.bound - dual->value) > point_agreement_tolerance * scale)
      return "the forces that it encloses are not those of the motion";
    return {};
  }

  /// Bounds a box whose bound so far is its parent's, and keeps it open if it may have better designs.
  void bound(FigureNode node) {
    ++result_.nodes;
    const std::size_t count = problem_.lengths.size();
    std::vector<const FigureDual*> corners;
    for (std::size_t c = 0; c < std::size_t(1) << count; ++c) {
      VectorX corner = node.box.lower;
      for (std::size_t k = 0; k < count; ++k)
        if (c >> k & 1U) corner[problem_.lengths[k]] = node.box.upper[problem_.lengths[k]];
      corners.push_back(dual_at(corner));
    }
    const VectorX middle = with_lengths(node.box.middle());
    if (std::none_of(corners.begin(), corners.end(), [](const FigureDual* dual) { return dual; }))
      corners.front() = dual_at(middle);
    if (std::any_of(corners.begin(), corners.end(), [](const FigureDual* dual) { return dual; })) {
      const FigureBoxBound own = bound_figures(space_, problem_, node.box,
                                               sample_planar_motion(space_, problem_, middle), corners, time_weights_);
      node.bound = std::max(node.bound, own.bound);
      node.losses = own.enclosed > 0 ? own.losses : VectorX::Zero(static_cast<Eigen::Index>(count));
    }
    if (node.bound >= result_.best)
      closed_bound_ = std::min(closed_bound_, node.bound);
    else
      open_.push(std::move(node));
  }

  double relative_width(const FigureNode& node, std::size_t k) const {
    const int length = problem_.lengths[k];
    return (node.box.upper[length] - node.box.lower[length]) / (problem_.upper[length] - problem_.lower[length]);
  }

  /// Along the length that costs most of the bound, or the widest.
  void divide(const FigureNode& node) {
    std::size_t chosen = 0;
    double highest_score = -1;
    const bool has_losses = numerics::max_abs(node.losses) > 0;
    for (std::size_t k = 0; k < problem_.lengths.size(); ++k) {
      const double width = relative_width(node, k);
      const double score = width <= min_divided_width ? -1
                           : has_losses               ? node.losses[static_cast<Eigen::Index>(k)]
                                                      : width;
      if (score <= highest_score) continue;
      highest_score = score;
      chosen = k;
    }
    if (highest_score < 0) {  // too narrow
      closed_bound_ = std::min(closed_bound_, node.bound);
      return;
    }
    const int length = problem_.lengths[chosen];
    const double middle = node.box.middle()[length];
    for (const bool is_upper : {false, true}) {
      FigureNode part = node;
      (is_upper ? part.box.lower : part.box.upper)[length] = middle;
      bound(std::move(part));
    }
  }

  const DesignSpace& space_;
  const FigureProblem& problem_;
  const ForceRowModel& rows_;
  FigureBoundOptions options_;
  double start_time_;
  LengthBound result_;
  VectorX time_weights_, promising_;
  double promised_value_ = unbounded;
  std::map<std::vector<double>, std::optional<FigureDual>> duals_;  ///< by lengths
  std::priority_queue<FigureNode, std::vector<FigureNode>, HasHigherFigureBound> open_;
  double closed_bound_ = unbounded;
};

FigureBoundSearch::FigureBoundSearch(const DesignSpace& space, const FigureProblem& problem, const ForceRowModel& rows,
                                     const FigureBoundOptions& options)
    : tree_(std::make_unique<Tree>(space, problem, rows, options)) {}

FigureBoundSearch::~FigureBoundSearch() = default;

void FigureBoundSearch::run(const std::function<bool()>& interrupted) { tree_->run(interrupted); }
void FigureBoundSearch::add_design(const VectorX& x, double value) { tree_->add_design(x, value); }
bool FigureBoundSearch::is_finished() const { return tree_->is_finished(); }
const VectorX& FigureBoundSearch::promising() const { return tree_->promising(); }
double FigureBoundSearch::promised_value() const { return tree_->promised_value(); }
LengthBound FigureBoundSearch::result() const { return tree_->result(); }

}  // namespace balance::certificate
