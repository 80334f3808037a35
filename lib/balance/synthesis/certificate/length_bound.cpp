#include "balance/synthesis/certificate/length_bound.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/certificate/length_geometry.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <queue>
#include <stdexcept>

namespace balance {
namespace {

using namespace certificate;

constexpr double infinity = std::numeric_limits<double>::infinity();
/// Relative to the bound: lengths on which the active inequalities agree better have their worst value at a corner.
constexpr double conflict_tolerance = 1e-7;
/// Multipliers are affine in so many lengths: a program grows by powers.
constexpr std::size_t max_affine_lengths = 2, max_affine_lengths_with_conditions = 4;
/// Relative to the free interval: narrower boxes are not divided.
constexpr double min_relative_width = 1e-7;
/// Relative: a design must be better than the last by more.
constexpr double improvement_tolerance = 1e-10;
/// Relative to the terms of a condition on the lengths: by how much designs that are moved to its boundary meet it.
constexpr std::array condition_margins{1e-8, 1e-6, 1e-4};
constexpr int max_projection_steps = 20;
/// Compass search from designs found: steps relative to the free intervals, and its effort.
constexpr double first_compass_step = 0.25, min_compass_step = 1e-5;
constexpr int max_compass_evaluations = 400, max_compass_searches = 6;
/// Of conditions that are met, scaled.
constexpr double balance_tolerance = 1e-8;
/// Relative: changes of the bound that are kept for the progress.
constexpr double progress_step = 1e-5;
/// Relative: free numbers may leave their bounds by round-off.
constexpr double bound_tolerance = 1e-12;

/// Also false if the trajectory does not suit the mechanism.
bool can_follow(const Mechanism& mechanism, const Trajectory& trajectory) {
  try {
    return simulate(mechanism, trajectory).outcome.status == MotionStatus::done;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

class ConditionsJudge : public LengthDesignJudge {
 public:
  explicit ConditionsJudge(const DesignSpace& space) : space_(space), followed_(list_followed_trajectories(space)) {}

  bool accepts(const VectorX& x) const override {
    try {
      return is_design(x);
    } catch (const SpecError&) {  // an expression has no value
      return false;
    }
  }

 private:
  bool is_design(const VectorX& x) const {
    const DesignInstance instance = space_.instantiate(x);
    if (!instance.mode_issue.empty()) return false;
    const Conditions conditions = derive_conditions(instance.mechanism, space_.start.design.goals);
    if (conditions.status != ConditionsStatus::done) return false;
    if (max_abs(scaled_residuals(conditions, term_values(instance.mechanism))) > balance_tolerance) return false;
    return std::all_of(followed_.begin(), followed_.end(), [&](int index) {
      return can_follow(instance.mechanism, instance.trajectories[static_cast<std::size_t>(index)]);
    });
  }

  const DesignSpace& space_;
  std::vector<int> followed_;
};

/// The programs of a geometry, with and without its conditions on the lengths.
struct GeometryPrograms {
  BoxProgram conditional, unconditional;

  explicit GeometryPrograms(const LengthGeometry& geometry)
      : conditional(geometry.linkage, geometry.dual, geometry.conditions),
        unconditional(geometry.linkage, geometry.dual, {}) {}
};

struct Node {
  int geometry = 0;
  LengthBox box;
  double bound = 0;
  MatrixX conflict;
  std::vector<bool> upper_limits;
  int part = -1;  ///< in the proof; −1: none yet, or no proof is kept
};

struct HasHigherBound {
  bool operator()(const Node& a, const Node& b) const { return a.bound > b.bound; }
};

}  // namespace

class LengthBoundSearch::Tree {
 public:
  Tree(const DesignSpace& space, const LengthDesignJudge& judge, const LengthBoundOptions& options)
      : space_(space), judge_(judge), options_(options), start_time_(thread_cpu_time()) {
    if (!make_roots()) return;
    for (std::size_t g = 0; g < geometries_.size(); ++g) {
      Node root;
      root.geometry = static_cast<int>(g);
      root.box = geometries_[g].box;
      root.bound = geometries_[g].min_value;
      root.upper_limits.assign(geometries_[g].linkage.counterweights.size(), false);
      bound(root);
      root_parts_.push_back(root.part);
    }
    note_progress();
  }

  void run(const std::function<bool()>& interrupted) {
    while (!is_finished() && !(interrupted && interrupted())) {
      Node node = open_.top();
      open_.pop();
      try_designs(node);
      if (node.bound >= result_.best)
        close(node.bound);
      else
        divide(std::move(node));
      note_progress();
    }
  }

  void add_design(const VectorX& x, double mass) {
    if (!result_.reason.empty() || !(mass < result_.best)) return;
    result_.best = mass;
    result_.design = best_lengths_ = x;
    note_progress();
  }

  bool is_finished() const { return open_.empty() || result_.nodes >= options_.max_nodes || is_closed(); }

  LengthBound result() const {
    LengthBound result = result_;
    result.lower_bound = std::min(lower_bound(), result.best);
    result.progress.push_back({elapsed(), result.lower_bound, result.best});
    if (options_.keeps_proof)
      for (std::size_t g = 0; g < geometries_.size(); ++g)
        result.proof.push_back(recorder_.list_steps(root_parts_[g], geometries_[g], result.lower_bound));
    return result;
  }

 private:
  double elapsed() const { return thread_cpu_time() - start_time_; }
  double lower_bound() const { return open_.empty() ? closed_bound_ : std::min(open_.top().bound, closed_bound_); }

  bool is_closed() const {
    const double lower = lower_bound();
    return lower >= closed_bound_ ||
           (std::isfinite(result_.best) && result_.best - lower <= options_.gap_tolerance * std::abs(result_.best));
  }

  void note_progress() {
    const double lower = std::min(lower_bound(), result_.best);
    if (!result_.progress.empty()) {
      const LengthBoundProgress& last = result_.progress.back();
      if (result_.best == last.best && !(lower - last.lower_bound > progress_step * std::abs(lower))) return;
    }
    result_.progress.push_back({elapsed(), lower, result_.best});
  }

  bool make_roots() {
    LengthGeometries listed = list_length_geometries(space_, options_.required_trajectories);
    result_.reason = std::move(listed.reason);
    if (!result_.reason.empty()) return false;
    geometries_ = std::move(listed.geometries);
    if (BoxProgram(geometries_[0].linkage, geometries_[0].dual, {}).lengths().empty()) {
      result_.reason = "no length is free";
      return false;
    }
    result_.uncovered = std::move(listed.uncovered);
    for (const LengthGeometry& geometry : geometries_) {
      programs_.emplace_back(geometry);
      result_.geometries.push_back(geometry.name);
    }
    return true;
  }

  const LengthGeometry& geometry_of(const Node& node) const {
    return geometries_[static_cast<std::size_t>(node.geometry)];
  }
  const GeometryPrograms& programs_of(const Node& node) const {
    return programs_[static_cast<std::size_t>(node.geometry)];
  }

  /// Bounds a box whose bound so far is its parent's, and keeps it open if it may have better designs.
  void bound(Node& node) {
    const LengthGeometry& geometry = geometry_of(node);
    const BoxProgram& program = programs_of(node).conditional;
    ++result_.nodes;
    if (!contract_box(node)) return;  // it contains no lengths of the geometry
    BoxBound best = program.bound(node.box, {}, node.upper_limits);
    if (best.bound < result_.best && best.bound <= geometry.max_value && best.conflict.size() > 0) {
      const std::vector<int> affine = choose_affine_lengths(node, best, program);
      if (!affine.empty()) {
        BoxBound better = program.bound(node.box, affine, node.upper_limits);
        if (better.bound > best.bound) best = std::move(better);
      }
    }
    if (best.conflict.size() == 0) best.conflict = MatrixX::Zero(geometry.linkage.variables, 2);
    if (best.bound > node.bound) {
      node.bound = best.bound;
      if (options_.keeps_proof) recorder_.prove(node.part, best.bound, best.certificate);
    }
    node.conflict = std::move(best.conflict);
    if (node.bound > geometry.max_value)
      close(infinity);
    else if (node.bound >= result_.best)
      close(node.bound);
    else
      open_.push(node);
  }

  bool contract_box(Node& node) {
    if (!options_.keeps_proof) return contract(geometry_of(node).conditions, node.box);
    const LengthBox whole = node.box;
    std::vector<BoxCut> cuts;
    const bool is_left = contract(geometry_of(node).conditions, node.box, &cuts);
    node.part = recorder_.add(node.part, whole, std::move(cuts));
    return is_left;
  }

  /// Those in conflict, and those of conditions that take part.
  static std::vector<int> choose_affine_lengths(const Node& node, const BoxBound& bound, const BoxProgram& program) {
    std::vector<int> lengths = program.lengths();
    const auto conflict = [&](int length) { return std::min(bound.conflict(length, 0), bound.conflict(length, 1)); };
    std::stable_sort(lengths.begin(), lengths.end(), [&](int a, int b) { return conflict(a) > conflict(b); });
    std::vector<int> result;
    const double threshold = conflict_tolerance * std::max(1.0, std::abs(bound.bound));
    for (const int length : lengths)
      if (result.size() < max_affine_lengths && conflict(length) > threshold) result.push_back(length);
    for (const int condition : program.find_active_conditions(node.box))
      for (const int length : lengths)
        if (result.size() < max_affine_lengths_with_conditions &&
            program.conditions()[static_cast<std::size_t>(condition)].polynomial.has_variable(length) &&
            node.box.lower[length] < node.box.upper[length] &&
            std::find(result.begin(), result.end(), length) == result.end())
          result.push_back(length);
    return result;
  }

  void close(double bound) { closed_bound_ = std::min(closed_bound_, bound); }

  /// The corner that the active inequalities ask for, and the middle.
  void try_designs(const Node& node) {
    VectorX corner = node.box.lower;
    for (const int length : programs_of(node).conditional.lengths())
      if (node.conflict(length, 1) > node.conflict(length, 0)) corner[length] = node.box.upper[length];
    const double before = result_.best;
    for (const VectorX& lengths : {corner, node.box.middle()}) {
      if (meets_conditions(lengths, geometry_of(node)) && try_design(node, lengths)) continue;
      for (const double margin : condition_margins) {
        const std::optional<VectorX> moved = meet_conditions(lengths, geometry_of(node), margin);
        if (moved && try_design(node, *moved)) break;
      }
    }
    if (result_.best < before && node.bound < result_.best * (1 - options_.gap_tolerance)) search_nearby(node);
  }

  /// The least mass at these lengths, assembled or not; infinite if nothing balances.
  double point_value(const Node& node, const VectorX& lengths) const {
    std::vector<bool> upper_limits = node.upper_limits;
    const BoxBound point = programs_of(node).unconditional.bound({lengths, lengths}, {}, upper_limits);
    return point.corner_masses.empty() || point.bound > geometry_of(node).max_value ? infinity : point.bound;
  }

  /// Descends from the best design along one length at a time: an optimum between the corners is found long before
  /// boxes are small.
  void search_nearby(const Node& node) {
    if (searches_ >= max_compass_searches || best_lengths_.size() == 0) return;
    ++searches_;
    const LengthGeometry& geometry = geometry_of(node);
    VectorX lengths = best_lengths_;
    double value = result_.best;
    int evaluations = 0;
    for (double step = first_compass_step; step > min_compass_step && evaluations < max_compass_evaluations;) {
      bool has_improved = false;
      for (const int length : programs_of(node).conditional.lengths())
        for (const double sign : {-1.0, 1.0}) {
          VectorX moved = lengths;
          const double width = geometry.box.upper[length] - geometry.box.lower[length];
          moved[length] =
              std::clamp(moved[length] + sign * step * width, geometry.box.lower[length], geometry.box.upper[length]);
          if (moved[length] == lengths[length] || !meets_conditions(moved, geometry)) continue;
          ++evaluations;
          const double other = point_value(node, moved);
          if (!(other < value * (1 - improvement_tolerance))) continue;
          lengths = std::move(moved);
          value = other;
          has_improved = true;
        }
      if (!has_improved) step /= 2;
    }
    try_design(node, lengths);
  }

  static bool meets_conditions(const VectorX& lengths, const LengthGeometry& geometry) {
    const auto& conditions = geometry.conditions;
    return std::all_of(conditions.begin(), conditions.end(), [&](const LengthCondition& condition) {
      return !condition.is_equality && condition.polynomial.evaluate(lengths).real() >= 0;
    });
  }

  /// Moves lengths within the bounds until they meet the conditions, relative to the free intervals as little as
  /// possible: Gauss–Newton steps.
  /// @return none if there are no conditions, or the steps do not converge
  static std::optional<VectorX> meet_conditions(VectorX lengths, const LengthGeometry& geometry, double margin) {
    const auto& conditions = geometry.conditions;
    if (conditions.empty()) return {};
    const VectorX width = geometry.box.upper - geometry.box.lower;
    for (int step = 0; step < max_projection_steps; ++step) {
      std::vector<VectorX> gradients;
      std::vector<double> residuals;
      for (const LengthCondition& condition : conditions) {
        const double value = condition.polynomial.evaluate(lengths).real();
        const double target = condition.is_equality ? 0 : margin * condition_scale(condition, geometry);
        if (condition.is_equality ? value == 0 : value >= target / 2) continue;
        VectorX gradient = VectorX::Zero(lengths.size());
        for (Eigen::Index i = 0; i < lengths.size(); ++i)
          gradient[i] = condition.polynomial.derivative(static_cast<int>(i)).evaluate(lengths).real() * width[i];
        gradients.push_back(std::move(gradient));
        residuals.push_back(target - value);
      }
      if (residuals.empty()) return lengths;
      MatrixX jacobian(static_cast<Eigen::Index>(residuals.size()), lengths.size());
      VectorX right(jacobian.rows());
      for (std::size_t r = 0; r < residuals.size(); ++r) {
        jacobian.row(static_cast<Eigen::Index>(r)) = gradients[r].transpose();
        right[static_cast<Eigen::Index>(r)] = residuals[r];
      }
      MatrixX normal = jacobian * jacobian.transpose();
      normal.diagonal().array() += 1e-14 * normal.trace() + 1e-300;
      const VectorX change = jacobian.transpose() * normal.ldlt().solve(right);
      const VectorX before = lengths;
      lengths = (lengths + width.cwiseProduct(change)).cwiseMax(geometry.box.lower).cwiseMin(geometry.box.upper);
      if (!lengths.allFinite()) return {};
      if ((lengths - before).cwiseAbs().sum() <= 1e-16 * lengths.cwiseAbs().sum()) return lengths;
    }
    return lengths;
  }

  static double condition_scale(const LengthCondition& condition, const LengthGeometry& geometry) {
    const auto [low, high] = enclose_range(condition.polynomial, geometry.box);
    return std::max(std::abs(low), std::abs(high));
  }

  /// @return whether it is accepted, or no improvement
  bool try_design(const Node& node, const VectorX& lengths) {
    const LengthGeometry& geometry = geometry_of(node);
    std::vector<bool> upper_limits = node.upper_limits;
    const BoxBound point = programs_of(node).unconditional.bound({lengths, lengths}, {}, upper_limits);
    if (point.corner_masses.empty() || point.bound > geometry.max_value) return false;
    VectorX x = space_.start_values();
    for (const int length : programs_of(node).conditional.lengths()) x[length] = lengths[length];
    for (const auto& [number, value] : geometry.substitution) x[number] = value.evaluate(lengths).real();
    double value = geometry.linkage.fixed_size.evaluate(lengths).real();
    for (std::size_t i = 0; i < geometry.linkage.counterweights.size(); ++i) {
      place_counterweight(geometry.linkage.counterweights[i], point.corner_masses[i], x);
      value += point.mass(i);
    }
    if (!(value < result_.best * (1 - improvement_tolerance))) return true;
    if (!clamp_to_bounds(x) || !judge_.accepts(x)) return false;
    result_.best = value;
    result_.design = std::move(x);
    best_lengths_ = lengths;
    return true;
  }

  void place_counterweight(const FreeCounterweight& counterweight, const VectorX& masses, VectorX& x) const {
    const double mass = masses.sum();
    if (counterweight.mass_number >= 0) x[counterweight.mass_number] = mass;
    if (mass <= 0) return;
    // corners: x first, then y
    const bool has_two_y = counterweight.place_numbers[1] >= 0;
    VectorX high = VectorX::Zero(2);
    for (Eigen::Index c = 0; c < masses.size(); ++c) {
      if ((has_two_y ? c / 2 : c) == 1) high[0] += masses[c] / mass;
      if (has_two_y && c % 2 == 1) high[1] += masses[c] / mass;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      const int number = counterweight.place_numbers[i];
      if (number < 0) continue;
      const FreeNumber& free = space_.start.free_numbers[static_cast<std::size_t>(number)];
      x[number] = free.lower + high[static_cast<Eigen::Index>(i)] * (free.upper - free.lower);
    }
  }

  /// @return false if a number is outside its bounds by more than round-off, or is none of its sizes
  bool clamp_to_bounds(VectorX& x) const {
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const FreeNumber& number = space_.start.free_numbers[static_cast<std::size_t>(i)];
      const double margin = bound_tolerance * (std::abs(number.lower) + std::abs(number.upper));
      if (!(x[i] >= number.lower - margin && x[i] <= number.upper + margin)) return false;
      x[i] = std::clamp(x[i], number.lower, number.upper);
      const auto& sizes = number.discrete_values;
      if (!sizes.empty() && std::find(sizes.begin(), sizes.end(), x[i]) == sizes.end()) return false;
    }
    return true;
  }

  void divide(Node node) {
    const LengthGeometry& geometry = geometry_of(node);
    int widest = -1, branching_length = -1;
    double width = 0, conflict = 0;
    for (const int length : programs_of(node).conditional.lengths()) {
      const double whole = geometry.box.upper[length] - geometry.box.lower[length];
      const double relative = whole > 0 ? (node.box.upper[length] - node.box.lower[length]) / whole : 0;
      if (relative < min_relative_width) continue;
      if (relative > width) width = relative, widest = length;
      const double both = std::min(node.conflict(length, 0), node.conflict(length, 1));
      if (both > conflict) conflict = both, branching_length = length;
    }
    const bool has_conflict = conflict > 1e-2 * conflict_tolerance * std::max(1.0, std::abs(node.bound));
    const int length = has_conflict ? branching_length : widest;
    if (length < 0) {
      close(node.bound);
      return;
    }
    const double middle = (node.box.lower[length] + node.box.upper[length]) / 2;
    for (const bool is_upper : {false, true}) {
      Node part = node;
      (is_upper ? part.box.lower : part.box.upper)[length] = middle;
      bound(part);
    }
  }

  const DesignSpace& space_;
  const LengthDesignJudge& judge_;
  const LengthBoundOptions options_;
  double start_time_;
  std::vector<LengthGeometry> geometries_;
  std::deque<GeometryPrograms> programs_;  ///< refer to the geometries, which are not moved any more
  std::priority_queue<Node, std::vector<Node>, HasHigherBound> open_;
  double closed_bound_ = infinity;  ///< smallest bound of the boxes that are not divided any more
  VectorX best_lengths_;            ///< of the best design, in its geometry
  int searches_ = 0;
  ProofRecorder recorder_;
  std::vector<int> root_parts_;  ///< per geometry
  LengthBound result_;           ///< without its bound
};

std::vector<int> list_followed_trajectories(const DesignSpace& space) {
  std::vector<int> followed;
  for (std::size_t i = 0; i < space.start.trajectories.size(); ++i) {
    const Trajectory& trajectory = space.start.trajectories[i];
    if (trajectory.drive != DriveKind::com && !is_mechanism_dependent(trajectory) &&
        can_follow(space.start.mechanism, trajectory))
      followed.push_back(static_cast<int>(i));
  }
  return followed;
}

std::unique_ptr<LengthDesignJudge> make_length_design_judge(const DesignSpace& space) {
  return std::make_unique<ConditionsJudge>(space);
}

LengthBoundSearch::LengthBoundSearch(const DesignSpace& space, const LengthDesignJudge& judge,
                                     const LengthBoundOptions& options)
    : tree_(std::make_unique<Tree>(space, judge, options)) {}

LengthBoundSearch::~LengthBoundSearch() = default;

void LengthBoundSearch::run(const std::function<bool()>& interrupted) { tree_->run(interrupted); }

void LengthBoundSearch::add_design(const VectorX& x, double mass) { tree_->add_design(x, mass); }

bool LengthBoundSearch::is_finished() const { return tree_->is_finished(); }

LengthBound LengthBoundSearch::result() const { return tree_->result(); }

LengthBound bound_over_lengths(const DesignSpace& space, const LengthDesignJudge& judge,
                               const LengthBoundOptions& options) {
  LengthBoundSearch search(space, judge, options);
  search.run({});
  return search.result();
}

}  // namespace balance
