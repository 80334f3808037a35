#include "balance/synthesis/certificate/length_bound.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <queue>
#include <stdexcept>

namespace balance::certificate {
namespace {

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
/// Programs to find masses with sizes, and elements, at given lengths.
constexpr int max_point_programs = 60;
/// Boxes for a number of elements before a larger number is tried as well, and boxes between such decisions.
constexpr long count_lead = 400, count_boxes = 100;

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
  ConditionsJudge(const DesignSpace& space, std::vector<int> trajectories)
      : space_(space), trajectories_(std::move(trajectories)) {}

  bool accepts(const VectorX& x) const override {
    try {
      return is_design(x);
    } catch (const SpecError&) {  // an expression has no value
      return false;
    }
  }

 private:
  bool is_design(const VectorX& x) const {
    const study::DesignInstance instance = space_.instantiate(x);
    if (!instance.mode_issue.empty()) return false;
    ConditionOptions options;
    options.about = find_moment_reference(space_);
    const Conditions conditions = derive_conditions(instance.mechanism, space_.start.design.goals, options);
    if (conditions.status != ConditionsStatus::done) return false;
    if (numerics::max_abs(scaled_residuals(conditions, conditions::term_values(instance.mechanism))) >
        balance_tolerance)
      return false;
    return std::all_of(trajectories_.begin(), trajectories_.end(), [&](int index) {
      return can_follow(instance.mechanism, instance.trajectories[static_cast<std::size_t>(index)]);
    });
  }

  const DesignSpace& space_;
  std::vector<int> trajectories_;
};

/// The programs of a geometry, with and without its conditions on the lengths.
struct GeometryPrograms {
  BoxProgram conditional, unconditional;

  explicit GeometryPrograms(const LengthGeometry& geometry)
      : conditional(geometry.linkage, geometry.dual, geometry.conditions),
        unconditional(geometry.linkage, geometry.dual, {}) {}
};

struct Node : DesignPart {
  int geometry = 0;
  double bound = 0;
  MatrixX conflict;
  VectorX relaxed_masses;   ///< per counterweight
  LengthCertificate proof;  ///< of the bound: its own, or that of a box that contains it
  int part = -1;            ///< in the recorder; −1: none yet, or nothing is recorded
};

/// Adds what is known to what was known before, if it tells more.
void append_progress(const LengthBoundProgress& known, std::vector<LengthBoundProgress>& progress) {
  const bool is_news = progress.empty() || known.best != progress.back().best ||
                       known.lower_bound - progress.back().lower_bound > progress_step * std::abs(known.lower_bound);
  if (is_news) progress.push_back(known);
}

struct HasHigherBound {
  bool operator()(const Node& a, const Node& b) const { return a.bound > b.bound; }
};

/// What the trees of different numbers of elements have in common.
struct LengthProblem {
  const DesignSpace& space;
  const LengthDesignJudge& judge;
  LengthBoundOptions options;
  double start_time;
  std::vector<LengthGeometry> geometries;
  std::deque<GeometryPrograms> programs;  ///< refer to the geometries, which are not moved any more
  std::vector<std::string> uncovered;
  std::string reason;  ///< as in LengthBound

  LengthProblem(const DesignSpace& design_space, const LengthDesignJudge& design_judge,
                const LengthBoundOptions& bound_options)
      : space(design_space), judge(design_judge), options(bound_options), start_time(thread_cpu_time()) {
    if (!space.start.design.cardinality.empty() && options.choices.empty()) {
      reason = "elements may be left out";
      return;
    }
    LengthGeometries listed = list_length_geometries(space, options.required_trajectories);
    reason = std::move(listed.reason);
    if (!reason.empty()) return;
    geometries = std::move(listed.geometries);
    uncovered = std::move(listed.uncovered);
    for (const LengthGeometry& geometry : geometries) programs.emplace_back(geometry);
    if (programs.front().unconditional.lengths().empty()) reason = "no length is free";
  }

  double elapsed() const { return thread_cpu_time() - start_time; }

  /// Of the objective in any geometry.
  double min_value() const {
    double value = infinity;
    for (const LengthGeometry& geometry : geometries) value = std::min(value, geometry.min_value);
    return value;
  }

  /// Names of those whose conditions take part.
  std::vector<std::string> list_restricting_trajectories() const {
    const auto is_restricted = [](const LengthGeometry& geometry) {
      return std::any_of(geometry.conditions.begin(), geometry.conditions.end(),
                         [](const LengthCondition& condition) { return !condition.is_equality; });
    };
    std::vector<std::string> names;
    if (std::any_of(geometries.begin(), geometries.end(), is_restricted))
      for (const int index : options.required_trajectories)
        names.push_back(space.start.trajectories[static_cast<std::size_t>(index)].name);
    return names;
  }
};

/// Branch and bound for one number of elements.
class Tree {
 public:
  /// @param min_count limit of the choices that ask for as few elements as possible
  Tree(const LengthProblem& problem, int min_count)
      : space_(problem.space),
        judge_(problem.judge),
        options_(problem.options),
        problem_(problem),
        geometries_(problem.geometries),
        programs_(problem.programs) {
    result_.uncovered = problem.uncovered;
    const auto has_sizes = [](const FreeNumber& number) { return !number.discrete_values.empty(); };
    const auto& numbers = space_.start.free_numbers;
    is_recorded_ = options_.keeps_certificates && options_.choices.empty() &&
                   std::none_of(numbers.begin(), numbers.end(), has_sizes);
    for (std::size_t g = 0; g < geometries_.size(); ++g) {
      result_.geometries.push_back(geometries_[g].name);
      domains_.emplace_back(space_, geometries_[g], programs_[g].conditional.lengths(), options_.choices, min_count);
      Node root;
      static_cast<DesignPart&>(root) = domains_.back().root();
      root.geometry = static_cast<int>(g);
      root.bound = geometries_[g].min_value;
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
        close(node);
      else if (has_closed_gap(node.bound))
        open_.push(std::move(node));
      else
        divide(node);
      note_progress();
    }
  }

  void add_design(const VectorX& x, double mass) {
    if (!(mass < result_.best)) return;
    result_.best = mass;
    result_.design = best_lengths_ = x;
    note_progress();
  }

  bool is_finished() const { return open_.empty() || result_.nodes >= options_.max_nodes || is_closed(); }
  bool is_impossible() const { return std::isinf(lower_bound()); }
  bool has_design() const { return std::isfinite(result_.best); }
  double best() const { return result_.best; }
  /// Of the designs with at most this number of elements.
  double lower_bound() const { return open_.empty() ? closed_bound_ : std::min(open_.top().bound, closed_bound_); }
  long nodes() const { return result_.nodes; }

  LengthBound result() const {
    LengthBound result = result_;
    result.lower_bound = std::min(lower_bound(), result.best);
    result.progress.push_back({elapsed(), result.lower_bound, result.best});
    if (options_.keeps_certificates)
      for (auto open = open_; !open.empty(); open.pop()) result.certificates.push_back(open.top().proof);
    if (is_recorded_)
      for (std::size_t g = 0; g < geometries_.size(); ++g)
        result.proof.push_back(recorder_.list_steps(root_parts_[g], geometries_[g], result.lower_bound));
    return result;
  }

 private:
  double elapsed() const { return problem_.elapsed(); }
  bool is_closed() const {
    const double lower = lower_bound();
    return lower >= closed_bound_ || has_closed_gap(lower);
  }
  bool has_closed_gap(double bound) const {
    return std::isfinite(result_.best) && result_.best - bound <= options_.gap_tolerance * std::abs(result_.best);
  }

  void note_progress() {
    append_progress({elapsed(), std::min(lower_bound(), result_.best), result_.best}, result_.progress);
  }

  const LengthGeometry& geometry_of(const Node& node) const {
    return geometries_[static_cast<std::size_t>(node.geometry)];
  }
  const GeometryPrograms& programs_of(const Node& node) const {
    return programs_[static_cast<std::size_t>(node.geometry)];
  }
  const DiscreteDomain& domain_of(const Node& node) const { return domains_[static_cast<std::size_t>(node.geometry)]; }
  /// Of the objective, with a margin: a larger bound shows that the part has no design.
  double max_value(const Node& node, const DesignPart& part) const {
    const LengthGeometry& geometry = geometry_of(node);
    return geometry.max_fixed_size + geometry.impossibility_margin +
           domain_of(node).max_mass(part) * (1 + mass_sum_tolerance);
  }

  /// Bounds a box whose bound so far is its parent's, and keeps it open if it may have better designs.
  void bound(Node& node) {
    const LengthGeometry& geometry = geometry_of(node);
    const BoxProgram& program = programs_of(node).conditional;
    ++result_.nodes;
    // otherwise it contains no design of the geometry
    if (!contract_box(node) || !domain_of(node).propagate(node)) return;
    const double largest = max_value(node, node);
    BoxBound best = program.bound(node.box, {}, node.masses);
    if (best.bound < result_.best && best.bound <= largest && best.conflict.size() > 0) {
      const std::vector<int> affine = choose_affine_lengths(node, best, program);
      if (!affine.empty()) {
        BoxBound better = program.bound(node.box, affine, node.masses);
        if (better.bound > best.bound) best = std::move(better);
      }
    }
    if (best.conflict.size() == 0) best.conflict = MatrixX::Zero(geometry.linkage.variables, 2);
    node.relaxed_masses = masses_of(best, node.masses.size());
    if (best.bound > node.bound) {
      node.bound = best.bound;
      if (is_recorded_) recorder_.prove(node.part, best.bound, best.certificate);
      node.proof = {node.geometry, node.box, best.bound, std::move(best.certificate)};
    }
    node.conflict = std::move(best.conflict);
    if (node.bound > largest)
      close(node, infinity);
    else if (node.bound >= result_.best)
      close(node);
    else
      open_.push(node);
  }

  bool contract_box(Node& node) {
    if (!is_recorded_) return contract(geometry_of(node).conditions, node.box);
    const LengthBox whole = node.box;
    std::vector<BoxCut> cuts;
    const bool is_left = contract(geometry_of(node).conditions, node.box, &cuts);
    node.part = recorder_.add(node.part, whole, std::move(cuts));
    return is_left;
  }

  static VectorX masses_of(const BoxBound& bound, std::size_t counterweights) {
    VectorX masses = VectorX::Zero(static_cast<Eigen::Index>(counterweights));
    for (std::size_t i = 0; i < bound.corner_masses.size(); ++i) masses[static_cast<Eigen::Index>(i)] = bound.mass(i);
    return masses;
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

  void close(const Node& node) { close(node, node.bound); }
  void close(const Node& node, double value) {
    closed_bound_ = std::min(closed_bound_, value);
    if (options_.keeps_certificates) result_.certificates.push_back(node.proof);
  }

  /// The corner that the active inequalities ask for, and the middle.
  void try_designs(const Node& node) {
    VectorX corner = node.box.lower;
    for (const int length : programs_of(node).conditional.lengths())
      if (node.conflict(length, 1) > node.conflict(length, 0)) corner[length] = node.box.upper[length];
    const double before = result_.best;
    for (const VectorX& lengths : {corner, domain_of(node).round_lengths(node, node.box.middle())}) {
      if (meets_conditions(lengths, geometry_of(node)) && try_design(node, lengths)) continue;
      for (const double margin : condition_margins) {
        const std::optional<VectorX> moved = meet_conditions(lengths, node, margin);
        if (moved && try_design(node, *moved)) break;
      }
    }
    if (result_.best < before && node.bound < result_.best * (1 - options_.gap_tolerance)) search_nearby(node);
  }

  /// Masses at given lengths.
  struct PointDesign {
    bool is_feasible = true;  ///< without sizes and choices
    double value = infinity;  ///< infinite: there is none below the limit, or none was found
    BoxBound masses;          ///< without corner_masses: none
    int programs = 0;         ///< that were solved

    bool has_masses() const { return !masses.corner_masses.empty(); }
  };

  /// The lightest masses of a node at these lengths, assembled or not, with sizes and choices.
  /// @param limit only lighter ones matter
  PointDesign find_masses(const Node& node, const VectorX& lengths, double limit) const {
    const DiscreteDomain& domain = domain_of(node);
    PointDesign best;
    best.value = limit;
    std::vector<DesignPart> open{DesignPart(static_cast<const DesignPart&>(node))};
    for (const int length : programs_of(node).conditional.lengths())
      open.back().box.lower[length] = open.back().box.upper[length] = lengths[length];
    while (!open.empty() && best.programs < max_point_programs) {
      DesignPart part = std::move(open.back());
      open.pop_back();
      const bool is_first = best.programs++ == 0;
      if (!domain.propagate(part)) continue;
      const BoxProgram& program = programs_of(node).unconditional;
      BoxBound point = program.bound(program.point_box(lengths, part.box), {}, part.masses);
      if (point.corner_masses.empty() || point.bound > max_value(node, part)) {
        best.is_feasible = best.is_feasible && !is_first;
        continue;
      }
      if (!(point.bound < best.value)) continue;
      const VectorX masses = masses_of(point, part.masses.size());
      double distance = 0;
      std::vector<DesignPart> parts = domain.divide_elements(part, masses);
      if (parts.empty()) parts = domain.divide_masses(part, masses, distance);
      if (parts.empty()) settle(program, lengths, part, point);
      if (parts.empty() && point.bound < best.value) {
        best.value = point.bound;
        best.masses = std::move(point);
      }
      for (DesignPart& one : parts) open.push_back(std::move(one));
    }
    if (!best.has_masses()) best.value = infinity;
    return best;
  }

  /// With moments, the relaxation may have a counterweight at several places. Where it stands at their centre, inertias
  /// and ratios may take up the difference.
  static void settle(const BoxProgram& program, const VectorX& lengths, DesignPart& part, BoxBound& point) {
    if (program.places().empty()) return;
    LengthBox box = program.point_box(lengths, part.box);
    const std::map<int, double> centres = program.list_centres(point);
    for (const int number : program.places())
      if (const auto found = centres.find(number); found != centres.end())
        box.lower[number] = box.upper[number] = found->second;
    point = program.bound(box, {}, part.masses);
    if (point.corner_masses.empty()) point.bound = infinity;
  }

  /// Descends from the best design along one length at a time: an optimum between the corners is found long before
  /// boxes are small.
  void search_nearby(const Node& node) {
    if (searches_ >= max_compass_searches || best_lengths_.size() == 0) return;
    ++searches_;
    const LengthGeometry& geometry = geometry_of(node);
    const Node root = root_of(node);
    VectorX lengths = best_lengths_;
    double value = result_.best;
    int evaluations = 0;
    for (double step = first_compass_step; step > min_compass_step && evaluations < max_compass_evaluations;) {
      bool has_improved = false;
      for (const int length : programs_of(node).conditional.lengths())
        for (const double sign : {-1.0, 1.0}) {
          VectorX moved = lengths;
          const double width = geometry.box.upper[length] - geometry.box.lower[length];
          moved[length] = std::clamp(domain_of(node).step_length(length, moved[length], sign * step * width),
                                     geometry.box.lower[length], geometry.box.upper[length]);
          if (moved[length] == lengths[length] || !meets_conditions(moved, geometry)) continue;
          const PointDesign point = find_masses(root, moved, value);
          evaluations += point.programs;
          const double other = point.value;
          if (!(other < value * (1 - improvement_tolerance)) || !try_design(root, moved)) continue;
          lengths = std::move(moved);
          value = result_.best;
          has_improved = true;
        }
      if (!has_improved) step /= 2;
    }
  }

  /// Without the node's decisions, for designs that are not in it.
  Node root_of(const Node& node) const {
    Node root;
    static_cast<DesignPart&>(root) = domain_of(node).root();
    root.geometry = node.geometry;
    for (std::size_t i = 0; i < root.masses.size(); ++i) root.masses[i].is_upper_used = node.masses[i].is_upper_used;
    return root;
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
  std::optional<VectorX> meet_conditions(VectorX lengths, const Node& node, double margin) const {
    const LengthGeometry& geometry = geometry_of(node);
    const auto& conditions = geometry.conditions;
    if (conditions.empty()) return {};
    VectorX width = geometry.box.upper - geometry.box.lower;
    for (const int length : programs_of(node).conditional.lengths())
      if (domain_of(node).has_sizes(length)) width[length] = 0;
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
    const PointDesign point = find_masses(node, lengths, result_.best * (1 - improvement_tolerance));
    if (!point.is_feasible) return false;
    if (!point.has_masses()) return true;
    VectorX x = space_.start_values();
    for (const int length : programs_of(node).conditional.lengths()) x[length] = lengths[length];
    for (const auto& [number, value] : geometry.substitution) x[number] = value.evaluate(lengths).real();
    for (std::size_t i = 0; i < geometry.linkage.counterweights.size(); ++i)
      place_counterweight(geometry.linkage.counterweights[i], i, point.masses, x);
    for (const auto& [number, place] : programs_of(node).unconditional.list_centres(point.masses)) x[number] = place;
    for (std::size_t i = 0; i < geometry.linkage.inertias.size(); ++i) {
      const FreeInertia& inertia = geometry.linkage.inertias[i];
      if (inertia.number >= 0) x[inertia.number] = point.masses.inertias[i];
      if (inertia.spin.ratio_number >= 0 && point.masses.inertias[i] > 0)
        x[inertia.spin.ratio_number] = point.masses.ratios[i];
    }
    if (!domain_of(node).complete(x) || !judge_.accepts(x)) return false;
    double value = geometry.linkage.fixed_size.evaluate(lengths).real();
    for (std::size_t i = 0; i < geometry.linkage.counterweights.size(); ++i) {
      const int number = geometry.linkage.counterweights[i].mass_number;
      value += number >= 0 ? x[number] : point.masses.mass(i);
    }
    if (!(value < result_.best)) return true;
    result_.best = value;
    result_.design = std::move(x);
    best_lengths_ = lengths;
    return true;
  }

  /// @param index of the counterweight
  void place_counterweight(const FreeCounterweight& counterweight, std::size_t index, const BoxBound& point,
                           VectorX& x) const {
    const VectorX& masses = point.corner_masses[index];
    const double mass = masses.sum();
    if (counterweight.mass_number >= 0) x[counterweight.mass_number] = mass;
    if (mass <= 0) return;
    if (!point.places.empty()) return;  // it has been placed
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

  /// Elements first, then the length or the mass with sizes that matters more.
  void divide(const Node& node) {
    const LengthGeometry& geometry = geometry_of(node);
    const DiscreteDomain& domain = domain_of(node);
    if (const auto parts = domain.divide_elements(node, node.relaxed_masses); !parts.empty()) {
      bound_parts(node, parts);
      return;
    }
    int widest = -1, branching_length = -1;
    double width = 0, conflict = 0;
    std::vector<int> numbers = programs_of(node).conditional.lengths();
    const std::size_t lengths = numbers.size();
    const std::vector<int>& places = programs_of(node).conditional.places();
    numbers.insert(numbers.end(), places.begin(), places.end());
    for (std::size_t n = 0; n < numbers.size(); ++n) {
      const int length = numbers[n];
      const double whole = geometry.box.upper[length] - geometry.box.lower[length];
      const double relative = whole > 0 ? (node.box.upper[length] - node.box.lower[length]) / whole : 0;
      if (relative < min_relative_width) continue;
      if (n < lengths && relative > width) width = relative, widest = length;
      const double both = std::min(node.conflict(length, 0), node.conflict(length, 1));
      if (both > conflict) conflict = both, branching_length = length;
    }
    double distance = 0;
    const auto mass_parts = domain.divide_masses(node, node.relaxed_masses, distance);
    if (!mass_parts.empty() && distance >= conflict) {
      bound_parts(node, mass_parts);
      return;
    }
    const bool has_conflict = conflict > 1e-2 * conflict_tolerance * std::max(1.0, std::abs(node.bound));
    const int length = has_conflict ? branching_length : widest;
    if (length < 0) {
      close(node);
      return;
    }
    bound_parts(node, domain.divide_length(node, length));
  }

  void bound_parts(const Node& node, const std::vector<DesignPart>& parts) {
    for (const DesignPart& part : parts) {
      Node child = node;
      static_cast<DesignPart&>(child) = part;
      bound(child);
    }
  }

  const DesignSpace& space_;
  const LengthDesignJudge& judge_;
  const LengthBoundOptions& options_;
  const LengthProblem& problem_;
  const std::vector<LengthGeometry>& geometries_;
  const std::deque<GeometryPrograms>& programs_;
  std::deque<DiscreteDomain> domains_;  ///< per geometry
  std::priority_queue<Node, std::vector<Node>, HasHigherBound> open_;
  double closed_bound_ = infinity;  ///< smallest bound of the boxes that are not divided any more
  VectorX best_lengths_;            ///< of the best design, in its geometry
  int searches_ = 0;
  bool is_recorded_ = false;  ///< with sizes or choices, boxes are no proof by themselves
  ProofRecorder recorder_;
  std::vector<int> root_parts_;  ///< per geometry
  LengthBound result_;           ///< without its bound
};

}  // namespace

/// One tree or, where as few elements as possible are asked for, one for each number of them.
class LengthBoundSearch::Trees {
 public:
  Trees(const DesignSpace& space, const LengthDesignJudge& judge, const LengthBoundOptions& options)
      : problem_(space, judge, options) {
    if (!problem_.reason.empty()) return;
    for (const ElementChoice& choice : options.choices) {
      if (choice.max_count >= 0) continue;
      is_count_free_ = true;
      max_count_ += static_cast<int>(choice.elements.size());
    }
    find_possible_counts();
  }

  void run(const std::function<bool()>& interrupted) {
    if (!problem_.reason.empty()) return;
    while (const std::optional<std::size_t> count = choose_count()) {
      make_trees(static_cast<int>(*count));
      long boxes = 0;
      bool is_interrupted = false;
      trees_[*count]->run([&] {
        is_interrupted = interrupted && interrupted();
        return is_interrupted || (is_count_free_ && ++boxes > count_boxes);
      });
      if (!is_interrupted) find_possible_counts();
      note_progress();
      if (is_interrupted) return;
    }
  }

  void add_design(const VectorX& x, double mass) {
    if (!problem_.reason.empty()) return;
    const int count = is_count_free_ ? count_min_elements(problem_.options.choices, x) : 0;
    make_trees(count);
    trees_[static_cast<std::size_t>(count)]->add_design(x, mass);
    note_progress();
  }

  bool is_finished() const { return !problem_.reason.empty() || !choose_count(); }
  bool has_design() const { return problem_.reason.empty() && trees_[shown_count()]->has_design(); }

  LengthBound result() const {
    LengthBound result;
    result.reason = problem_.reason;
    if (!result.reason.empty()) return result;
    const std::size_t count = shown_count();
    result = trees_[count]->result();
    result.trajectories = problem_.list_restricting_trajectories();
    if (!is_count_free_) return result;
    result.lower_bound = lower_bound();
    result.progress = progress_;
    result.progress.push_back({problem_.elapsed(), result.lower_bound, result.best});
    result.nodes = 0;
    for (const auto& tree : trees_) result.nodes += tree->nodes();
    result.count = static_cast<int>(count);
    result.is_count_proved = count == first_possible_;
    return result;
  }

 private:
  void make_trees(int count) {
    for (int next = static_cast<int>(trees_.size()); next <= count; ++next)
      trees_.push_back(std::make_unique<Tree>(problem_, next));
  }

  /// Skips the numbers of elements that are proved too few, but for the largest.
  void find_possible_counts() {
    make_trees(static_cast<int>(first_possible_));
    while (trees_[first_possible_]->is_impossible() && static_cast<int>(first_possible_) < max_count_)
      make_trees(static_cast<int>(++first_possible_));
  }

  /// The smallest number with a design, or else the smallest that may have one.
  std::size_t shown_count() const {
    for (std::size_t count = first_possible_; count < trees_.size(); ++count)
      if (trees_[count]->has_design()) return count;
    return first_possible_;
  }

  /// Of the lightest design with the least number, while that may still change: it is one of those with at most as many
  /// elements as the smallest known design, or as there are.
  double lower_bound() const {
    const bool has_design = trees_[shown_count()]->has_design();
    double bound = problem_.min_value();
    for (std::size_t count = has_design ? shown_count() : static_cast<std::size_t>(max_count_); count < trees_.size();
         ++count)
      bound = std::max(bound, trees_[count]->lower_bound());
    return has_design ? std::min(bound, trees_[shown_count()]->best()) : bound;
  }

  void note_progress() {
    if (is_count_free_) append_progress({problem_.elapsed(), lower_bound(), trees_[shown_count()]->best()}, progress_);
  }

  /// The number to go on with: small ones have a lead, and none beyond the first with a design matters.
  std::optional<std::size_t> choose_count() const {
    std::optional<std::size_t> chosen;
    long min_effort = 0;
    const std::size_t shown = shown_count();
    const std::size_t last = trees_[shown]->has_design() ? shown : static_cast<std::size_t>(max_count_);
    for (std::size_t count = first_possible_; count <= last; ++count) {
      const bool is_new = count >= trees_.size();
      if (!is_new && trees_[count]->is_finished()) continue;
      const long effort = (is_new ? 0 : trees_[count]->nodes()) + count_lead * static_cast<long>(count);
      if (!chosen || effort < min_effort) {
        chosen = count;
        min_effort = effort;
      }
      if (is_new) break;
    }
    return chosen;
  }

  LengthProblem problem_;
  bool is_count_free_ = false;
  int max_count_ = 0;                         ///< of elements, where as few as possible are asked for
  std::vector<std::unique_ptr<Tree>> trees_;  ///< by number of elements
  std::size_t first_possible_ = 0;
  std::vector<LengthBoundProgress> progress_;  ///< where the least number is asked for
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

std::unique_ptr<LengthDesignJudge> make_length_design_judge(const DesignSpace& space, std::vector<int> trajectories) {
  return std::make_unique<ConditionsJudge>(space, std::move(trajectories));
}

LengthBoundSearch::LengthBoundSearch(const DesignSpace& space, const LengthDesignJudge& judge,
                                     const LengthBoundOptions& options)
    : trees_(std::make_unique<Trees>(space, judge, options)) {}

LengthBoundSearch::~LengthBoundSearch() = default;

void LengthBoundSearch::run(const std::function<bool()>& interrupted) { trees_->run(interrupted); }

void LengthBoundSearch::add_design(const VectorX& x, double mass) { trees_->add_design(x, mass); }

bool LengthBoundSearch::is_finished() const { return trees_->is_finished(); }

bool LengthBoundSearch::has_design() const { return trees_->has_design(); }

LengthBound LengthBoundSearch::result() const { return trees_->result(); }

LengthBound bound_over_lengths(const DesignSpace& space, const LengthDesignJudge& judge,
                               const LengthBoundOptions& options) {
  LengthBoundSearch search(space, judge, options);
  search.run({});
  return search.result();
}

}  // namespace balance::certificate
