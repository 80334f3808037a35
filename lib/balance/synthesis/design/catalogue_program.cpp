#include "balance/synthesis/design/catalogue_program.hpp"

#include "balance/foundation/expression/expression_evaluation.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/random.hpp"
#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/box_form.hpp"
#include "balance/synthesis/design/box_least_squares.hpp"
#include "balance/synthesis/design/geometry_features.hpp"
#include "balance/synthesis/design/length_ratio_bound.hpp"
#include "balance/synthesis/design/required_motions.hpp"
#include "balance/synthesis/design/trajectory_cost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>

namespace balance::design {

// The force of a spring on two bodies is (k − (k c + p)/l) d, where d is the vector between its ends, l its length, c
// the length of its cable, k its stiffness and p = k l₀ − F with the free length l₀ and the initial tension F of the
// coils. Along a given motion every effort and reaction is y = y₀ + Σ (k − (k c + p)/l) g(a, b) with bilinear functions
// g of the ends a and b in the axes of their bodies: the forces of a spring of zero free length (TrajectoryCost::rows).
// A row of a catalogue gives k and p. Over a box of rows and places, the mean value theorem encloses
//   y ∈ y(middle) + G δ ± e,  |δ| ≤ half widths,
// with the middles G and the radii of intervals that contain the derivatives, e = radii · half widths. With the weighted
// norm of the time average, ‖y‖ ≥ min ‖y(middle) + G δ‖ − ‖e‖; limits on lengths are linearised in the same way and
// enter with their multipliers. A peak is at least the weighted norm for any weights with sum one; weights that grow
// with the residuals (Lawson 1961) lead to the largest of these bounds.
//
// Where places are free, many of them balance a weight almost completely, and e would have to be small compared with what
// is left. There the bounds of length_ratio_bound are used first; they also narrow the box.

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Relative difference below which two numbers of mechanisms count as equal.
constexpr double equal_number_tolerance = 1e-10;
/// Limits on lengths are kept to this fraction of the characteristic length.
constexpr double length_tolerance = 1e-9;

/// The part of a graph that some expressions need.
class ExpressionExcerpt {
 public:
  ExpressionExcerpt(const study::Recording& recording, const std::vector<Expression>& wanted)
      : nodes_(recording.graph.nodes()) {
    is_needed_.assign(nodes_.size(), false);
    for (const Expression& expression : wanted)
      if (!expression.is_constant()) is_needed_[static_cast<std::size_t>(expression.node())] = true;
    for (std::size_t k = nodes_.size(); k-- > 0;)
      if (is_needed_[k])
        for (const int argument : nodes_[k].arguments)
          if (argument >= 0) is_needed_[static_cast<std::size_t>(argument)] = true;
  }

  template <class Algebra, class Input>
  std::vector<typename Algebra::Value> evaluate(const Algebra& algebra, const Input& input) const {
    using expression::Operation;
    std::vector<typename Algebra::Value> values(nodes_.size(), algebra.constant(0.0));
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      if (!is_needed_[k]) continue;
      const expression::ExpressionNode& node = nodes_[k];
      const auto argument = [&](std::size_t i) -> const typename Algebra::Value& {
        return values[node.arguments[i] < 0 ? k : static_cast<std::size_t>(node.arguments[i])];
      };
      if (node.operation == Operation::constant)
        values[k] = algebra.constant(node.constant);
      else if (node.operation == Operation::input)
        values[k] = input(node.input);
      else
        values[k] = algebra.apply(node, argument(0), argument(1), argument(2));
    }
    return values;
  }

 private:
  const std::vector<expression::ExpressionNode>& nodes_;
  std::vector<bool> is_needed_;
};

// Samples of a motion.

/// A quantity of a run as a function of the springs.
struct SampledQuantity {
  double weight = 1;  ///< in the objective
  bool is_peak = false;
  struct Series {
    Eigen::Index components = 1;
    VectorX time_weights;
    VectorX constant;                 ///< of everything but the varying springs, samples · components
    std::vector<MatrixX> per_spring;  ///< samples · components × features: forces per stiffness
  };
  std::vector<Series> series;  ///< the figure is that of the worst one
  int motion = 0;
};

/// Poses of the bodies along a motion.
struct SampledMotion {
  results::BodyPoses poses;
  Eigen::Index size() const { return poses.position.rows(); }
  Matrix3 rotation(Eigen::Index row, BodyId body) const {
    const double* q = &poses.orientation(row, 4 * body);
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  }
  Vector3 position(Eigen::Index row, BodyId body) const {
    const double* p = &poses.position(row, 3 * body);
    return {p[0], p[1], p[2]};
  }
};

/// Two points of bodies, in their axes.
struct PointPair {
  BodyId first = 0, second = 0;
  Vector3Of<Expression> a, b;
};

/// A spring whose numbers are free, or those of free rows.
struct VaryingSpring {
  int index = 0;    ///< into Mechanism::springs
  int choice = -1;  ///< whose rows give stiffness and lengths; −1: none
  PointPair ends;
  Expression stiffness, free_length;  ///< without a choice: as functions of the free numbers
  Expression cable;                   ///< with a choice: the free length, with its rows as read
  double cable_offset = 0;            ///< its value where the attributes of the rows were determined
};

/// Distances of two points at all samples of a motion lie between bounds.
struct DistanceLimit {
  int motion = 0;
  int spring = -1;  ///< whose travel it is; −1: of `points`
  PointPair points;
  double lower = -infinity, upper = infinity;  ///< unless the rows have them
};

// Attributes of the rows of a choice.
constexpr int stiffness_attribute = 0, preload_attribute = 1, free_length_attribute = 2, shortest_attribute = 3,
              longest_attribute = 4, cost_attribute = 5, first_limit_attribute = 6;

bool are_equal(const VectorX& a, const VectorX& b) {
  if (a.size() != b.size()) return false;
  return numerics::max_abs(a - b) <=
         equal_number_tolerance * (1e-300 + std::max(numerics::max_abs(a), numerics::max_abs(b)));
}

bool are_close(double a, double b, double scale) { return std::abs(a - b) <= equal_number_tolerance * scale; }

}  // namespace

// Sets of rows.

RowTree::RowTree(const MatrixX& attributes, const MatrixX& coordinates)
    : attributes_(attributes), coordinates_(coordinates) {
  rows_.resize(static_cast<std::size_t>(attributes.rows()));
  std::iota(rows_.begin(), rows_.end(), 0);
  build(0, static_cast<int>(rows_.size()));
}

int RowTree::build(int begin, int end) {
  const int index = static_cast<int>(sets_.size());
  sets_.push_back({begin, end, -1, -1, {}});
  const auto range_of = [&](const MatrixX& numbers, Eigen::Index j) {
    Interval range(infinity, -infinity);
    for (int i = begin; i < end; ++i) {
      const double value = numbers(rows_[static_cast<std::size_t>(i)], j);
      range = {std::min(range.lower, value), std::max(range.upper, value)};
    }
    return range;
  };
  for (Eigen::Index j = 0; j < attributes_.cols(); ++j)
    sets_[static_cast<std::size_t>(index)].range.push_back(range_of(attributes_, j));
  Eigen::Index widest = -1;
  double largest = 0;
  for (Eigen::Index j = 0; j < coordinates_.cols(); ++j)
    if (const double width = range_of(coordinates_, j).width(); width > largest) widest = j, largest = width;
  if (widest < 0) return index;
  const auto at = [&](int i) { return rows_.begin() + i; };
  const int middle = begin + (end - begin) / 2;
  std::sort(at(begin), at(end), [&](int a, int b) {
    return coordinates_(a, widest) != coordinates_(b, widest) ? coordinates_(a, widest) < coordinates_(b, widest)
                                                              : a < b;
  });
  const int left = build(begin, middle), right = build(middle, end);
  sets_[static_cast<std::size_t>(index)].left = left;
  sets_[static_cast<std::size_t>(index)].right = right;
  return index;
}

// Least squares with limits.

namespace {

/// a + B δ ± e, and linear limits A δ ≤ b.
struct LinearModel {
  MatrixX B;
  VectorX a, e;
  MatrixX A;
  VectorX b;
};

struct LeastNorm {
  double lower = 0;  ///< of ‖a + B δ‖ within the box and the limits
  VectorX delta;
  VectorX multipliers;
  bool is_feasible = true;
};

/// min ‖a + B δ‖ with weights. The multipliers of the limits are found by dual ascent; any give a bound.
LeastNorm minimise_norm(const LinearModel& model, const VectorX& weights, const VectorX& w) {
  constexpr int max_ascent_steps = 12;
  const MatrixX weighted = weights.asDiagonal() * model.B;
  const MatrixX Q = model.B.transpose() * weighted;
  const VectorX c = weighted.transpose() * model.a;
  const double constant = model.a.cwiseAbs2().dot(weights);
  LeastNorm best;
  best.delta = VectorX::Zero(w.size());
  VectorX lambda = VectorX::Zero(model.b.size()), delta = best.delta;
  const double trace = Q.trace();
  double best_bound = -infinity;
  for (int step = 0; step <= max_ascent_steps; ++step) {
    const VectorX linear = model.b.size() > 0 ? VectorX(c + model.A.transpose() * lambda) : c;
    minimise_in_box(Q, linear, w, delta);
    const VectorX product = Q * delta;
    // q(δ) = constant + 2 cᵀδ + δᵀQδ, plus 2 λᵀ(A δ − b)
    double value = constant + 2 * c.dot(delta) + delta.dot(product);
    if (model.b.size() > 0) value += 2 * lambda.dot(model.A * delta - model.b);
    const double bound = box_lower_bound(value, 2 * (product + linear), delta, w);
    if (bound > best_bound || step == 0) best_bound = bound, best.delta = delta, best.multipliers = lambda;
    if (model.b.size() == 0) break;
    const VectorX excess = model.A * delta - model.b;
    bool is_changed = false;
    for (Eigen::Index r = 0; r < excess.size(); ++r) {
      // largest reduction of the limit's left side within the box: if it is not enough, nothing keeps the limit
      const double reach = model.A.row(r).cwiseAbs().dot(w);
      if (-reach - model.b[r] > 0) {
        best.is_feasible = false;
        return best;
      }
      double curvature = 0;
      for (Eigen::Index j = 0; j < w.size(); ++j)
        if (w[j] > 0) curvature += model.A(r, j) * model.A(r, j) / std::max(Q(j, j), 1e-9 * trace + 1e-300);
      const double next = std::max(0.0, lambda[r] + excess[r] / std::max(curvature, 1e-300) * 0.8);
      if (std::abs(next - lambda[r]) > 1e-9 * (std::abs(lambda[r]) + 1e-300)) is_changed = true;
      lambda[r] = next;
    }
    if (!is_changed) break;
  }
  best.lower = std::sqrt(std::max(0.0, best_bound));
  if (lambda.size() > 0) best.delta = delta;  // the last one nearly keeps the limits
  return best;
}

}  // namespace

struct CatalogueProgram::Implementation {
  const DesignSpace space;
  std::vector<SampledMotion> motions;
  std::vector<SampledQuantity> quantities;
  std::vector<VaryingSpring> springs;
  std::vector<DistanceLimit> limits;
  std::vector<RowTree> trees;  ///< of each choice
  /// Of a spring's bodies at a sample: the spring is offset + second b − first a.
  struct RelativePose {
    Matrix3 first, second;
    Vector3 offset;
  };
  std::vector<std::vector<std::vector<RelativePose>>> relative_poses;  ///< by motion, spring and sample
  std::vector<std::vector<SpringSeries>> ratio_series;                 ///< by quantity and series; empty without places
  struct RowLimit {
    int attribute;  ///< of the trees' rows: the sum over the choices is limited
    double lower, upper;
  };
  std::vector<RowLimit> row_limits;
  bool knows_limits = true;
  bool is_planar = true;
  VectorX lower, upper;
  double characteristic = 1;
  std::unique_ptr<ExpressionExcerpt> excerpt;

  Implementation(const DesignSpace& given, const std::vector<ObjectiveTerm>& terms) : space(given) { compile(terms); }

  int places() const { return static_cast<int>(lower.size()); }
  int variables() const { return places() + 2 * static_cast<int>(trees.size()); }
  int features() const { return is_planar ? 9 : 16; }
  int dimensions() const { return is_planar ? 2 : 3; }

  // Compilation.

  Mechanism mechanism_at(const std::vector<int>& rows, const VectorX& x) const {
    return instantiate_checked(space.with_rows(rows), x).mechanism;
  }

  static Mechanism without_springs(Mechanism mechanism) {
    mechanism.springs.clear();
    for (Body& body : mechanism.bodies) body.points.clear();
    return mechanism;
  }

  /// All numbers of a mechanism but those of its springs and named points.
  static VectorX numbers_of(const Mechanism& mechanism) {
    const Mechanism bare = without_springs(mechanism);
    const VectorX geometry = collect_geometry(bare, {}), masses = dynamics::parameter_values(bare);
    VectorX all(geometry.size() + masses.size() + 3);
    all << geometry, masses, bare.gravity;
    return all;
  }

  void compile(const std::vector<ObjectiveTerm>& terms) {
    const Study& start = space.start;
    const auto& choices = start.catalogue_choices;
    const std::size_t count = start.free_numbers.size();
    if (count > max_places) throw CatalogueProgramError("more than 8 numbers are free besides the rows");
    lower.resize(static_cast<Eigen::Index>(count)), upper = lower;
    for (std::size_t i = 0; i < count; ++i) {
      lower[static_cast<Eigen::Index>(i)] = start.free_numbers[i].lower;
      upper[static_cast<Eigen::Index>(i)] = start.free_numbers[i].upper;
      if (!start.free_numbers[i].discrete_values.empty())
        throw CatalogueProgramError("numbers with sizes are free besides the rows");
    }
    if (!start.design.goals.empty()) throw CatalogueProgramError("there is a goal");
    if (start.design.cases.size() > 0) throw CatalogueProgramError("there are load cases");
    if (!start.design.cardinality.empty()) throw CatalogueProgramError("elements may be left out");
    is_planar = start.mechanism.space == SpaceKind::planar;
    characteristic = characteristic_length(start.mechanism);
    std::vector<int> start_rows;
    for (const auto& choice : choices) start_rows.push_back(choice.row);
    check_independence(start_rows);
    find_springs(start_rows);
    for (const ObjectiveTerm& term : terms) add_term(term, start_rows);
    add_limits();
    for (std::size_t m = 0; m < motions.size(); ++m) merge_equal_samples(m);
    build_trees(start_rows, terms);
    if (places() > 0) build_ratio_series();
    std::vector<Expression> wanted;
    const auto want = [&](const PointPair& pair) {
      for (int i = 0; i < 3; ++i) wanted.push_back(pair.a[i]), wanted.push_back(pair.b[i]);
    };
    for (const VaryingSpring& spring : springs) {
      want(spring.ends);
      for (const Expression& e : {spring.stiffness, spring.free_length, spring.cable}) wanted.push_back(e);
    }
    for (const DistanceLimit& limit : limits) want(limit.points);
    excerpt = std::make_unique<ExpressionExcerpt>(*space.recording, wanted);
  }

  VectorX random_place(numerics::UniformRandom& random) const {
    VectorX x(lower.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = lower[i] + (upper[i] - lower[i]) * random(0.02, 0.98);
    return x;
  }
  std::vector<int> random_rows(numerics::UniformRandom& random) const {
    std::vector<int> rows;
    for (const auto& choice : space.start.catalogue_choices)
      rows.push_back(choice.is_free ? std::min(static_cast<int>(random(0, choice.rows())), choice.rows() - 1)
                                    : choice.row);
    return rows;
  }

  /// Only springs and named points may change with rows and free numbers.
  void check_independence(const std::vector<int>& start_rows) const {
    constexpr int tries = 6;
    numerics::UniformRandom random(1);
    const study::DesignInstance first = instantiate_checked(space.with_rows(start_rows), space.start_values());
    const VectorX numbers = numbers_of(first.mechanism);
    for (int k = 0; k < tries; ++k) {
      const study::DesignInstance other =
          instantiate_checked(space.with_rows(random_rows(random)), random_place(random));
      if (!are_equal(numbers, numbers_of(other.mechanism)))
        throw CatalogueProgramError("rows or free numbers change more than springs");
      for (std::size_t t = 0; t < first.trajectories.size(); ++t)
        if (!is_mechanism_dependent(first.trajectories[t]) &&
            !are_equal(collect_motion_numbers(without_springs(first.mechanism), first.trajectories[t]),
                       collect_motion_numbers(without_springs(other.mechanism), other.trajectories[t])))
          throw CatalogueProgramError("free numbers change the motion");
    }
  }

  static PointPair ends_of(const model::SpringOf<Expression>& spring) {
    return {spring.first, spring.second, spring.point_first, spring.point_second};
  }

  void find_springs(const std::vector<int>& start_rows) {
    numerics::UniformRandom random(2);
    const auto& choices = space.start.catalogue_choices;
    const auto& recorded = space.recording->mechanism.springs;
    const Mechanism first = mechanism_at(start_rows, space.start_values());
    std::vector<Mechanism> others;
    for (int k = 0; k < 4; ++k) others.push_back(mechanism_at(random_rows(random), random_place(random)));
    for (std::size_t s = 0; s < recorded.size(); ++s) {
      int choice = -1;
      for (std::size_t k = 0; k < choices.size(); ++k)
        if (choices[k].is_free && choices[k].path == "springs." + recorded[s].name) choice = static_cast<int>(k);
      const Spring& at_start = first.springs[s];
      const bool varies = choice >= 0 || std::any_of(others.begin(), others.end(), [&](const Mechanism& other) {
                            const Spring& one = other.springs[s];
                            return one.stiffness != at_start.stiffness || one.free_length != at_start.free_length ||
                                   one.preload != at_start.preload || one.point_first != at_start.point_first ||
                                   one.point_second != at_start.point_second;
                          });
      if (!varies) continue;
      if (at_start.is_joint_spring()) throw CatalogueProgramError("a spring in a joint is among the free ones");
      VaryingSpring spring;
      spring.index = static_cast<int>(s);
      spring.choice = choice;
      spring.ends = ends_of(recorded[s]);
      if (choice < 0) {
        spring.stiffness = recorded[s].stiffness;
        spring.free_length = recorded[s].free_length;
        if (at_start.slack_length) throw CatalogueProgramError("a spring without a catalogue has initial tension");
      } else {
        spring.cable = recorded[s].free_length;
      }
      springs.push_back(std::move(spring));
    }
    for (std::size_t k = 0; k < choices.size(); ++k)
      if (choices[k].is_free && std::none_of(springs.begin(), springs.end(), [&](const VaryingSpring& spring) {
            return spring.choice == static_cast<int>(k);
          }))
        throw CatalogueProgramError(choices[k].path + " is not a spring between points");
  }

  int motion_index(const std::string& name) {
    const auto known = motion_names_.find(name);
    if (known != motion_names_.end()) return known->second;
    const Trajectory* trajectory = study::find_by_name(space.start.trajectories, name);
    if (trajectory == nullptr) throw CatalogueProgramError("the trajectory is unknown");
    if (is_mechanism_dependent(*trajectory) || is_mass_dependent(*trajectory) || trajectory->free_motion ||
        !trajectory->adaptations.empty())
      throw CatalogueProgramError("a motion depends on the mechanism");
    const RunResult run = simulate(space.start.mechanism, *trajectory);
    if (run.outcome.status != MotionStatus::done) throw CatalogueProgramError("a motion cannot be followed");
    RunResult merged = run;
    merge_intermediate(run, merged);
    motions.push_back({results::body_poses(space.start.mechanism, merged)});
    return motion_names_[name] = static_cast<int>(motions.size()) - 1;
  }

  /// Joint coordinates at all points of the time averages, in order.
  static void merge_intermediate(const RunResult& run, RunResult& merged) {
    if (!run.intermediate || run.intermediate->next_sample.empty()) return;
    const auto extra = static_cast<Eigen::Index>(run.intermediate->next_sample.size());
    const Eigen::Index total = run.time.size() + extra;
    merged.joint_position.resize(total, run.joint_position.cols());
    merged.time.resize(total);
    Eigen::Index out = 0, j = 0;
    for (Eigen::Index k = 0; k < run.time.size(); ++k) {
      for (; j < extra && run.intermediate->next_sample[static_cast<std::size_t>(j)] == k; ++j, ++out) {
        merged.joint_position.row(out) = run.intermediate->rows.joint_position.row(j);
        merged.time[out] = run.intermediate->rows.time[j];
      }
      merged.joint_position.row(out) = run.joint_position.row(k);
      merged.time[out++] = run.time[k];
    }
  }

  void add_term(const ObjectiveTerm& term, const std::vector<int>& start_rows) {
    if (is_size_of_parts(term.size)) return;  // an attribute of the rows
    if (term.size != ObjectiveTerm::Size::none)
      throw CatalogueProgramError("the objective has a mass of the mechanism");
    if (term.run != ObjectiveTerm::RunMeasure::figure || term.deviation_multiple ||
        (term.figure != Statistic::rms && term.figure != Statistic::peak))
      throw CatalogueProgramError("the objective is neither an rms nor a peak");
    SampledQuantity quantity;
    quantity.weight = term.weight;
    quantity.is_peak = term.figure == Statistic::peak;
    quantity.motion = motion_index(term.trajectory);
    Mechanism mechanism = mechanism_at(start_rows, space.start_values());
    dynamics::FreeSprings loose(mechanism.springs.size(), false);
    for (const VaryingSpring& spring : springs) {
      Spring& own = mechanism.springs[static_cast<std::size_t>(spring.index)];
      own.free_length = 0;
      own.slack_length.reset();
      loose[static_cast<std::size_t>(spring.index)] = true;
    }
    const Trajectory& trajectory = *study::find_by_name(space.start.trajectories, term.trajectory);
    const auto all = TrajectoryCost(mechanism, trajectory, loose).rows({term.quantity});
    if (!all[0]) throw CatalogueProgramError("the quantity is not linear in forces");
    const std::vector<dynamics::Parameter> parameters = dynamics::list_parameters(mechanism, loose);
    VectorX values(static_cast<Eigen::Index>(parameters.size()) + 1);
    values << dynamics::parameter_values(mechanism, loose), 1.0;
    std::vector<Eigen::Index> first(springs.size());
    for (std::size_t p = 0; p < parameters.size(); ++p)
      for (std::size_t s = 0; s < springs.size(); ++s)
        if (parameters[p].owner_kind == dynamics::ParameterOwner::spring && parameters[p].index == springs[s].index) {
          if (parameters[p].slot == 0) first[s] = static_cast<Eigen::Index>(p);
          values[static_cast<Eigen::Index>(p)] = 0;
        }
    for (const AffineSeries& rows : *all[0]) {
      SampledQuantity::Series series;
      series.components = rows.components;
      series.time_weights = rows.time_weights;
      if (rows.time_weights.size() != motions[static_cast<std::size_t>(quantity.motion)].size())
        throw CatalogueProgramError("the samples of the motion differ");
      series.constant = rows.rows * values;
      for (std::size_t s = 0; s < springs.size(); ++s)
        series.per_spring.push_back(rows.rows.middleCols(first[s], features()));
      quantity.series.push_back(std::move(series));
    }
    quantities.push_back(std::move(quantity));
  }

  /// Limits on distances, and on sums over the parts. Others are left out: a bound without them holds, too.
  void add_limits() {
    const auto& recorded = space.recording->mechanism;
    for (const study::FigureLimit& limit : space.start.design.subject_to) {
      const ObjectiveTerm& term = limit.terms.front();
      if (limit.terms.size() == 1 && is_size_of_parts(term.size) && term.weight > 0) continue;  // in build_trees
      if (limit.terms.size() != 1 || term.size != ObjectiveTerm::Size::none || term.weight != 1 ||
          term.deviation_multiple) {
        knows_limits = false;
        continue;
      }
      DistanceLimit distance;
      bool is_known = false;
      const auto spring_of = [&](const std::string& quantity, const std::string& name) {
        for (std::size_t s = 0; s < springs.size(); ++s)
          if (quantity == name + "[" + recorded.springs[static_cast<std::size_t>(springs[s].index)].name + "]")
            return static_cast<int>(s);
        return -1;
      };
      if (term.run == ObjectiveTerm::RunMeasure::clearance && limit.is_lower && term.clearance.target.size() == 1) {
        is_known = locate(term.clearance.point, distance.points.first, distance.points.a) &&
                   locate(term.clearance.target[0], distance.points.second, distance.points.b);
        distance.lower = limit.bound;
      } else if (term.run == ObjectiveTerm::RunMeasure::figure) {
        const bool is_min = term.figure == Statistic::minimum && limit.is_lower;
        const bool is_max = (term.figure == Statistic::maximum || term.figure == Statistic::peak) && !limit.is_lower;
        if (const int s = spring_of(term.quantity, "spring_margin"); s >= 0 && is_min && limit.bound == 0) {
          is_known = springs[static_cast<std::size_t>(s)].choice >= 0;
          distance.spring = s;
        } else if (const int t = spring_of(term.quantity, "spring_length"); t >= 0 && (is_min || is_max)) {
          is_known = true;
          distance.points = springs[static_cast<std::size_t>(t)].ends;
          (is_min ? distance.lower : distance.upper) = limit.bound;
        }
      }
      if (is_known) {
        try {
          distance.motion = motion_index(term.trajectory);
          limits.push_back(std::move(distance));
          continue;
        } catch (const CatalogueProgramError&) {
        }
      }
      knows_limits = false;
    }
  }

  /// Poses of a workspace are visited several times, and the trajectory rests in them: one sample with all their time.
  void merge_equal_samples(std::size_t m) {
    constexpr double pose_tolerance = 1e-12;
    results::BodyPoses& poses = motions[m].poses;
    const Eigen::Index count = motions[m].size();
    struct ScaledSeries {
      SampledQuantity::Series* series;
      double constant;
      std::vector<double> per_spring;
    };
    std::vector<ScaledSeries> all;
    for (SampledQuantity& quantity : quantities)
      if (quantity.motion == static_cast<int>(m))
        for (SampledQuantity::Series& series : quantity.series) {
          all.push_back({&series, numerics::max_abs(series.constant), {}});
          for (const MatrixX& rows : series.per_spring) all.back().per_spring.push_back(numerics::max_abs(rows));
        }
    const auto are_equal_rows = [&](const auto& matrix, Eigen::Index a, Eigen::Index b, double scale) {
      return ((matrix.row(a) - matrix.row(b)).array().abs() <= pose_tolerance * scale).all();
    };
    const auto are_equal_samples = [&](Eigen::Index a, Eigen::Index b) {
      return are_equal_rows(poses.position, a, b, characteristic) && are_equal_rows(poses.orientation, a, b, 1) &&
             std::all_of(all.begin(), all.end(), [&](const ScaledSeries& one) {
               const SampledQuantity::Series& series = *one.series;
               for (Eigen::Index c = 0; c < series.components; ++c) {
                 const Eigen::Index i = a * series.components + c, j = b * series.components + c;
                 if (!are_equal_rows(series.constant, i, j, one.constant)) return false;
                 for (std::size_t s = 0; s < series.per_spring.size(); ++s)
                   if (!are_equal_rows(series.per_spring[s], i, j, one.per_spring[s])) return false;
               }
               return true;
             });
    };
    std::vector<Eigen::Index> kept, merged_into;
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto same =
          std::find_if(kept.begin(), kept.end(), [&](Eigen::Index other) { return are_equal_samples(i, other); });
      merged_into.push_back(same - kept.begin());
      if (same == kept.end()) kept.push_back(i);
    }
    if (static_cast<Eigen::Index>(kept.size()) == count) return;
    poses.position = MatrixX(poses.position(kept, Eigen::all));
    poses.orientation = MatrixX(poses.orientation(kept, Eigen::all));
    for (const ScaledSeries& one : all) {
      SampledQuantity::Series* const series = one.series;
      VectorX weights = VectorX::Zero(static_cast<Eigen::Index>(kept.size()));
      for (Eigen::Index i = 0; i < count; ++i)
        weights[merged_into[static_cast<std::size_t>(i)]] += series->time_weights[i];
      std::vector<Eigen::Index> rows;
      for (const Eigen::Index i : kept)
        for (Eigen::Index c = 0; c < series->components; ++c) rows.push_back(i * series->components + c);
      series->time_weights = weights;
      series->constant = VectorX(series->constant(rows));
      for (MatrixX& matrix : series->per_spring) matrix = MatrixX(matrix(rows, Eigen::all));
    }
  }

  void build_ratio_series() {
    std::vector<std::vector<SquaredLengths>> lengths;
    for (const SampledMotion& motion : motions) {
      lengths.emplace_back(), relative_poses.emplace_back();
      for (const VaryingSpring& spring : springs) {
        std::vector<RelativePose> poses;
        for (Eigen::Index row = 0; row < motion.size(); ++row)
          poses.push_back({motion.rotation(row, spring.ends.first), motion.rotation(row, spring.ends.second),
                           motion.position(row, spring.ends.second) - motion.position(row, spring.ends.first)});
        lengths.back().push_back(squared_lengths(poses));
        relative_poses.back().push_back(std::move(poses));
      }
    }
    for (const SampledQuantity& quantity : quantities) {
      ratio_series.emplace_back();
      for (const SampledQuantity::Series& series : quantity.series)
        ratio_series.back().emplace_back(series.components, quantity.is_peak,
                                         VectorX(series.time_weights / series.time_weights.sum()), series.constant,
                                         series.per_spring, lengths[static_cast<std::size_t>(quantity.motion)]);
    }
  }

  /// |o + R₂ b − R₁ a|² = |o|² + |a|² + |b|² + 2 oᵀR₂ b − 2 oᵀR₁ a − 2 aᵀR₁ᵀR₂ b.
  SquaredLengths squared_lengths(const std::vector<RelativePose>& poses) const {
    const Eigen::Index d = dimensions();
    SquaredLengths lengths;
    lengths.rows.resize(static_cast<Eigen::Index>(poses.size()), features() + 1);
    for (Eigen::Index i = 0; i < lengths.rows.rows(); ++i) {
      const RelativePose& pose = poses[static_cast<std::size_t>(i)];
      auto row = lengths.rows.row(i);
      row[0] = pose.offset.squaredNorm();
      const Vector3 a = -2 * pose.first.transpose() * pose.offset, b = 2 * pose.second.transpose() * pose.offset;
      const Matrix3 product = -2 * pose.first.transpose() * pose.second;
      for (Eigen::Index j = 0; j < d; ++j) {
        row[1 + j] = a[j], row[1 + d + j] = b[j];
        for (Eigen::Index k = 0; k < d; ++k) row[1 + 2 * d + d * j + k] = product(j, k);
      }
      row[features()] = 1;
    }
    lengths.mean = lengths.rows.colwise().mean().transpose();
    return lengths;
  }

  bool locate(const model::Landmark& landmark, BodyId& body, Vector3Of<Expression>& position) const {
    using Kind = model::Landmark::Kind;
    const auto& recorded = space.recording->mechanism;
    const auto at = [](int i) { return static_cast<std::size_t>(i); };
    switch (landmark.kind) {
      case Kind::origin: body = landmark.body; return true;
      case Kind::com: body = landmark.body, position = recorded.bodies[at(body)].com; return true;
      case Kind::point:
        body = landmark.body, position = recorded.bodies[at(body)].points[at(landmark.index)].position;
        return true;
      case Kind::attachment:
        if (recorded.attachments[at(landmark.index)].shape) return false;  // its surface counts
        body = recorded.attachments[at(landmark.index)].body,
        position = recorded.attachments[at(landmark.index)].position;
        return true;
      case Kind::disc:
        body = recorded.discs[at(landmark.index)].body, position = recorded.discs[at(landmark.index)].position;
        return true;
    }
    return false;
  }

  /// Stiffness and preload of each row, found from the mechanism at one place and checked at others.
  void build_trees(const std::vector<int>& start_rows, const std::vector<ObjectiveTerm>& terms) {
    const auto& choices = space.start.catalogue_choices;
    numerics::UniformRandom random(3);
    const VectorX x0 = space.start_values(), x1 = random_place(random), x2 = random_place(random);
    std::vector<const study::FigureLimit*> sums;
    for (const study::FigureLimit& limit : space.start.design.subject_to)
      if (limit.terms.size() == 1 && is_size_of_parts(limit.terms[0].size) && limit.terms[0].weight > 0)
        sums.push_back(&limit);
    const auto amount = [](const study::CatalogueChoice& choice, ObjectiveTerm::Size size, int r) {
      return size == ObjectiveTerm::Size::price ? choice.price_of(r) : choice.mass_of(r);
    };
    for (std::size_t k = 0; k < choices.size(); ++k) {
      const study::CatalogueChoice& choice = choices[k];
      const int rows = choice.is_free ? choice.rows() : 1;
      MatrixX attributes(rows, first_limit_attribute + static_cast<Eigen::Index>(sums.size()));
      int s = -1;
      for (std::size_t i = 0; i < springs.size(); ++i)
        if (springs[i].choice == static_cast<int>(k)) s = static_cast<int>(i);
      for (int i = 0; i < rows; ++i) {
        const int r = choice.is_free ? i : choice.row;
        double cost = 0;
        for (const ObjectiveTerm& term : terms)
          if (is_size_of_parts(term.size)) cost += term.weight * amount(choice, term.size, r);
        attributes.row(i).setZero();
        attributes(i, cost_attribute) = cost;
        for (std::size_t j = 0; j < sums.size(); ++j)
          attributes(i, first_limit_attribute + static_cast<Eigen::Index>(j)) =
              sums[j]->terms[0].weight * amount(choice, sums[j]->terms[0].size, r);
        attributes(i, longest_attribute) = max_length;
      }
      if (s >= 0) set_spring_attributes(k, springs[static_cast<std::size_t>(s)], start_rows, {x0, x1, x2}, attributes);
      trees.emplace_back(attributes, coordinates_of(attributes));
    }
    for (std::size_t j = 0; j < sums.size(); ++j)
      row_limits.push_back({first_limit_attribute + static_cast<int>(j), sums[j]->is_lower ? sums[j]->bound : -infinity,
                            sums[j]->is_lower ? infinity : sums[j]->bound});
  }

  /// Numbers by whose differences rows are similar: shares of the whole range.
  MatrixX coordinates_of(const MatrixX& attributes) const {
    MatrixX coordinates = attributes;
    if (places() > 0) {  // places make up for differences of stiffness in proportion
      coordinates.col(preload_attribute).setZero();
      const auto stiffness = attributes.col(stiffness_attribute);
      if (numerics::min_coefficient(stiffness) > 0)
        coordinates.col(stiffness_attribute) = stiffness.array().log().matrix();
    } else {
      coordinates.col(free_length_attribute).setZero();
    }
    for (Eigen::Index j = 0; j < coordinates.cols(); ++j) {
      const double range =
          numerics::max_coefficient(coordinates.col(j)) - numerics::min_coefficient(coordinates.col(j));
      constexpr double stiffness_share = 4;
      const double share = places() > 0 && j == stiffness_attribute ? stiffness_share : 1;
      if (range > 0) coordinates.col(j) *= share / range;
    }
    return coordinates;
  }

  /// Stands for a spring without a longest length [m].
  static constexpr double max_length = 1e6;

  /// The mechanism's spring for every row of a choice, without instantiating the whole mechanism each time.
  std::vector<Spring> springs_of_rows(std::size_t k, const VaryingSpring& spring, const std::vector<int>& start_rows,
                                      const VectorX& x) const {
    const study::CatalogueChoice& choice = space.start.catalogue_choices[k];
    const auto& recorded = space.recording->mechanism.springs[static_cast<std::size_t>(spring.index)];
    std::vector<Expression> wanted{recorded.stiffness, recorded.free_length};
    for (const auto* number : {&recorded.slack_length, &recorded.shortest_length, &recorded.longest_length})
      if (*number) wanted.push_back(**number);
    for (int i = 0; i < 3; ++i) wanted.push_back(recorded.point_first[i]), wanted.push_back(recorded.point_second[i]);
    const ExpressionExcerpt own(*space.recording, wanted);
    std::vector<double> inputs = space.with_rows(start_rows).inputs;
    for (std::size_t i = 0; i < space.free_inputs.size(); ++i)
      inputs[static_cast<std::size_t>(space.free_inputs[i])] = x[static_cast<Eigen::Index>(i)];
    std::vector<Spring> all;
    for (int r = 0; r < choice.rows(); ++r) {
      for (const study::CatalogueColumn& column : choice.columns)
        if (column.input >= 0)
          inputs[static_cast<std::size_t>(column.input)] = column.values[static_cast<std::size_t>(r)];
      const auto values = own.evaluate(expression::ScalarAlgebra<double>(),
                                       [&](int input) { return inputs[static_cast<std::size_t>(input)]; });
      const auto number = [&](const Expression& e) {
        return e.is_constant() ? e.value() : values[static_cast<std::size_t>(e.node())];
      };
      Spring one;
      one.stiffness = number(recorded.stiffness), one.free_length = number(recorded.free_length);
      if (recorded.slack_length) one.slack_length = number(*recorded.slack_length);
      if (recorded.shortest_length) one.shortest_length = number(*recorded.shortest_length);
      if (recorded.longest_length) one.longest_length = number(*recorded.longest_length);
      for (int i = 0; i < 3; ++i)
        one.point_first[i] = number(recorded.point_first[i]), one.point_second[i] = number(recorded.point_second[i]);
      all.push_back(one);
    }
    return all;
  }

  void set_spring_attributes(std::size_t k, VaryingSpring& spring, const std::vector<int>& start_rows,
                             const std::vector<VectorX>& places_to_try, MatrixX& attributes) {
    const std::vector<Spring> first = springs_of_rows(k, spring, start_rows, places_to_try[0]);
    const auto start_row = static_cast<std::size_t>(start_rows[k]);
    spring.cable_offset = first[start_row].free_length;
    const auto shortest = [](const Spring& one) {
      return std::max(one.slack_length.value_or(0), one.shortest_length.value_or(0));
    };
    for (std::size_t i = 1; i < places_to_try.size(); ++i) {
      const std::vector<Spring> other = springs_of_rows(k, spring, start_rows, places_to_try[i]);
      const double cable = other[start_row].free_length - first[start_row].free_length;
      for (std::size_t r = 0; r < first.size(); ++r) {
        const double length = std::abs(first[r].free_length) + std::abs(cable) + characteristic;
        const bool is_separable =
            are_close(other[r].stiffness, first[r].stiffness, first[r].stiffness) &&
            are_close(other[r].free_length, first[r].free_length + cable, length) &&
            are_close(shortest(other[r]), shortest(first[r]) + (has_shortest(first[r]) ? cable : 0), length) &&
            are_close(other[r].longest_length.value_or(0),
                      first[r].longest_length.value_or(0) + (first[r].longest_length ? cable : 0), length) &&
            numerics::max_abs(other[r].point_first - other[start_row].point_first) <=
                equal_number_tolerance * characteristic &&
            numerics::max_abs(other[r].point_second - other[start_row].point_second) <=
                equal_number_tolerance * characteristic;
        if (!is_separable) throw CatalogueProgramError("numbers of a row and free numbers are not separate");
      }
    }
    for (std::size_t r = 0; r < first.size(); ++r) {
      const auto i = static_cast<Eigen::Index>(r);
      attributes(i, stiffness_attribute) = first[r].stiffness;
      attributes(i, preload_attribute) = first[r].stiffness * first[r].free_length;
      attributes(i, free_length_attribute) = first[r].free_length;
      attributes(i, shortest_attribute) = has_shortest(first[r]) ? shortest(first[r]) : -max_length;
      attributes(i, longest_attribute) = first[r].longest_length.value_or(max_length);
    }
  }
  static bool has_shortest(const Spring& spring) { return spring.slack_length || spring.shortest_length; }

  // Evaluation.

  /// Values and derivatives of everything about the springs at one place, or over a box of places.
  struct SpringForms {
    std::array<BoxForm, 3> a, b;
    BoxForm cable, stiffness, free_length;
    std::vector<BoxForm> features;
  };

  /// @param forms of the free numbers
  std::vector<BoxForm> evaluate_graph(const BoxAlgebra& algebra, const std::vector<BoxForm>& forms) const {
    return excerpt->evaluate(algebra, [&](int input) {
      for (std::size_t i = 0; i < space.free_inputs.size(); ++i)
        if (space.free_inputs[i] == input) return forms[i];
      return algebra.constant(space.inputs[static_cast<std::size_t>(input)]);
    });
  }

  /// The linear model of all quantities over a box.
  struct Model {
    std::vector<std::vector<LinearModel>> quantities;  ///< by quantity and series
    MatrixX A;                                         ///< limits, linearised
    VectorX b;
    bool is_feasible = true;
    double cost = 0;  ///< least cost of the parts
    VectorX half;     ///< of the variables
  };

  static BoxForm form_of(const Expression& e, const std::vector<BoxForm>& values, const BoxAlgebra& algebra) {
    return e.is_constant() ? algebra.constant(e.value()) : values[static_cast<std::size_t>(e.node())];
  }

  std::vector<SpringForms> spring_forms(const BoxAlgebra& algebra, const std::vector<BoxForm>& graph) const {
    std::vector<SpringForms> all;
    for (const VaryingSpring& spring : springs) {
      SpringForms forms;
      for (std::size_t i = 0; i < 3; ++i) {
        forms.a[i] = form_of(spring.ends.a[static_cast<Eigen::Index>(i)], graph, algebra);
        forms.b[i] = form_of(spring.ends.b[static_cast<Eigen::Index>(i)], graph, algebra);
      }
      forms.cable = algebra.subtract(form_of(spring.cable, graph, algebra), algebra.constant(spring.cable_offset));
      forms.stiffness = form_of(spring.stiffness, graph, algebra);
      forms.free_length = form_of(spring.free_length, graph, algebra);
      const auto d = static_cast<std::size_t>(dimensions());
      forms.features.push_back(algebra.constant(1.0));
      for (const auto* end : {&forms.a, &forms.b})
        for (std::size_t i = 0; i < d; ++i) forms.features.push_back((*end)[i]);
      for (std::size_t i = 0; i < d; ++i)
        for (std::size_t j = 0; j < d; ++j) forms.features.push_back(algebra.multiply(forms.a[i], forms.b[j]));
      all.push_back(std::move(forms));
    }
    return all;
  }

  /// Distance of two points.
  BoxForm distance(const BoxAlgebra& algebra, const SampledMotion& motion, Eigen::Index row, const PointPair& pair,
                   const std::array<BoxForm, 3>& a, const std::array<BoxForm, 3>& b) const {
    const Matrix3 Ra = motion.rotation(row, pair.first), Rb = motion.rotation(row, pair.second);
    const Vector3 offset = motion.position(row, pair.second) - motion.position(row, pair.first);
    BoxForm sum = algebra.constant(0.0);
    for (int i = 0; i < dimensions(); ++i) {
      BoxForm component = algebra.constant(offset[i]);
      for (int j = 0; j < dimensions(); ++j) {
        component = algebra.add(component, algebra.scale(b[static_cast<std::size_t>(j)], Rb(i, j)));
        component = algebra.subtract(component, algebra.scale(a[static_cast<std::size_t>(j)], Ra(i, j)));
      }
      sum = algebra.add(sum, algebra.square(component));
    }
    return algebra.sqrt(sum);
  }

  struct Ranges {
    std::vector<Interval> places;
    std::vector<std::vector<Interval>> attributes;  ///< of each choice
  };

  bool keeps_sums(const Ranges& box) const {
    return std::all_of(row_limits.begin(), row_limits.end(), [&](const RowLimit& limit) {
      double least = 0, most = 0;
      for (const auto& attributes : box.attributes) {
        least += attributes[static_cast<std::size_t>(limit.attribute)].lower;
        most += attributes[static_cast<std::size_t>(limit.attribute)].upper;
      }
      const double scale = 1e-12 * (std::abs(least) + std::abs(most));
      return least <= limit.upper + scale && most >= limit.lower - scale;
    });
  }

  static double cost_lower_bound(const Ranges& box) {
    double cost = 0;
    for (const auto& attributes : box.attributes) cost += attributes[cost_attribute].lower;
    return cost;
  }

  /// @param box over which derivatives are enclosed, and lengths checked
  /// @param middle at which values are computed
  Model linearise(const Ranges& box, const Ranges& middle, const VectorX& half) const {
    const int n = places();
    const BoxAlgebra algebra(n), point_algebra(0);
    std::vector<BoxForm> over, at;
    for (int i = 0; i < n; ++i) {
      over.push_back(algebra.place(i, box.places[static_cast<std::size_t>(i)]));
      at.push_back(point_algebra.constant(middle.places[static_cast<std::size_t>(i)]));
    }
    const std::vector<BoxForm> graph = evaluate_graph(algebra, over), point_graph = evaluate_graph(point_algebra, at);
    const std::vector<SpringForms> forms = spring_forms(algebra, graph),
                                   points = spring_forms(point_algebra, point_graph);
    Model model;
    model.half = half;
    // lengths of springs, by motion, spring and sample
    std::vector<std::vector<std::vector<BoxForm>>> lengths(motions.size()), point_lengths(motions.size());
    for (std::size_t m = 0; m < motions.size(); ++m)
      for (std::size_t s = 0; s < springs.size(); ++s) {
        lengths[m].emplace_back(), point_lengths[m].emplace_back();
        for (Eigen::Index row = 0; row < motions[m].size(); ++row) {
          lengths[m][s].push_back(distance(algebra, motions[m], row, springs[s].ends, forms[s].a, forms[s].b));
          point_lengths[m][s].push_back(
              distance(point_algebra, motions[m], row, springs[s].ends, points[s].a, points[s].b));
        }
      }
    for (const SampledQuantity& quantity : quantities) {
      model.quantities.emplace_back();
      for (const SampledQuantity::Series& series : quantity.series)
        model.quantities.back().push_back(linearise_series(series, box, middle, half, forms, points,
                                                           lengths[static_cast<std::size_t>(quantity.motion)],
                                                           point_lengths[static_cast<std::size_t>(quantity.motion)]));
    }
    add_length_limits(box, half, graph, point_graph, forms, points, lengths, point_lengths, model);
    if (!keeps_sums(box)) model.is_feasible = false;
    model.cost = cost_lower_bound(box);
    return model;
  }

  LinearModel linearise_series(const SampledQuantity::Series& series, const Ranges& box, const Ranges& middle,
                               const VectorX& half, const std::vector<SpringForms>& forms,
                               const std::vector<SpringForms>& points, const std::vector<std::vector<BoxForm>>& lengths,
                               const std::vector<std::vector<BoxForm>>& point_lengths) const {
    const int n = places();
    const BoxAlgebra algebra(n), point_algebra(0);
    const Eigen::Index rows = series.constant.size();
    LinearModel linear;
    linear.a = series.constant;
    linear.B = MatrixX::Zero(rows, variables());
    linear.e = VectorX::Zero(rows);
    MatrixX radius = MatrixX::Zero(rows, variables());
    for (std::size_t s = 0; s < springs.size(); ++s) {
      const int choice = springs[s].choice;
      for (Eigen::Index i = 0; i < rows; ++i) {
        const auto sample = static_cast<std::size_t>(i / series.components);
        BoxForm g = algebra.constant(0.0), g0 = point_algebra.constant(0.0);
        for (int f = 0; f < features(); ++f) {
          const double factor = series.per_spring[s](i, f);
          if (factor == 0) continue;
          g = algebra.add(g, algebra.scale(forms[s].features[static_cast<std::size_t>(f)], factor));
          g0 = point_algebra.add(g0, point_algebra.scale(points[s].features[static_cast<std::size_t>(f)], factor));
        }
        const BoxForm h = algebra.multiply(g, algebra.inverse(lengths[s][sample]));
        const BoxForm h0 = point_algebra.multiply(g0, point_algebra.inverse(point_lengths[s][sample]));
        const auto add = [&](int variable, const Interval& slope) {
          linear.B(i, variable) += slope.middle();
          radius(i, variable) += 0.5 * slope.width();
        };
        if (choice >= 0) {
          const auto& range = box.attributes[static_cast<std::size_t>(choice)];
          const auto& centre = middle.attributes[static_cast<std::size_t>(choice)];
          const Interval k = range[stiffness_attribute], p = range[preload_attribute];
          const Interval pull = k * forms[s].cable.value + p;
          for (int j = 0; j < n; ++j) {
            const auto v = static_cast<std::size_t>(j);
            add(j, k * g.gradient[v] - pull * h.gradient[v] - k * forms[s].cable.gradient[v] * h.value);
          }
          add(n + 2 * choice, g.value - forms[s].cable.value * h.value);
          add(n + 2 * choice + 1, -h.value);
          const double k0 = centre[stiffness_attribute].middle(), p0 = centre[preload_attribute].middle();
          linear.a[i] += k0 * g0.value.middle() - (k0 * points[s].cable.value.middle() + p0) * h0.value.middle();
        } else {
          const BoxForm force =
              algebra.multiply(forms[s].stiffness, algebra.subtract(g, algebra.multiply(forms[s].free_length, h)));
          for (int j = 0; j < n; ++j) add(j, force.gradient[static_cast<std::size_t>(j)]);
          linear.a[i] += points[s].stiffness.value.middle() *
                         (g0.value.middle() - points[s].free_length.value.middle() * h0.value.middle());
        }
      }
    }
    linear.e = radius * half;
    return linear;
  }

  /// Only the samples at which a length is extreme enter the linear model; all are checked by intervals.
  void add_length_limits(const Ranges& box, const VectorX& half, const std::vector<BoxForm>& graph,
                         const std::vector<BoxForm>& point_graph, const std::vector<SpringForms>& forms,
                         const std::vector<SpringForms>& points,
                         const std::vector<std::vector<std::vector<BoxForm>>>& lengths,
                         const std::vector<std::vector<std::vector<BoxForm>>>& point_lengths, Model& model) const {
    const int n = places();
    const BoxAlgebra algebra(n), point_algebra(0);
    std::vector<VectorX> left;
    std::vector<double> right;
    for (const DistanceLimit& limit : limits) {
      const SampledMotion& motion = motions[static_cast<std::size_t>(limit.motion)];
      const bool is_travel = limit.spring >= 0;
      std::vector<BoxForm> own, own_points;
      if (!is_travel) {
        std::array<BoxForm, 3> a, b, a0, b0;
        for (std::size_t i = 0; i < 3; ++i) {
          const auto e = static_cast<Eigen::Index>(i);
          a[i] = form_of(limit.points.a[e], graph, algebra), b[i] = form_of(limit.points.b[e], graph, algebra);
          a0[i] = form_of(limit.points.a[e], point_graph, point_algebra);
          b0[i] = form_of(limit.points.b[e], point_graph, point_algebra);
        }
        for (Eigen::Index row = 0; row < motion.size(); ++row) {
          own.push_back(distance(algebra, motion, row, limit.points, a, b));
          own_points.push_back(distance(point_algebra, motion, row, limit.points, a0, b0));
        }
      }
      const auto s = static_cast<std::size_t>(limit.spring);
      const std::vector<BoxForm>& over = is_travel ? lengths[static_cast<std::size_t>(limit.motion)][s] : own;
      const std::vector<BoxForm>& at =
          is_travel ? point_lengths[static_cast<std::size_t>(limit.motion)][s] : own_points;
      double least = limit.lower, most = limit.upper, cable0 = 0;
      BoxForm cable = algebra.constant(0.0);
      if (is_travel) {
        const auto& range = box.attributes[static_cast<std::size_t>(springs[s].choice)];
        least = range[shortest_attribute].lower, most = range[longest_attribute].upper;
        cable = forms[s].cable, cable0 = points[s].cable.value.middle();
      }
      std::size_t longest = 0, shortest = 0;
      const double slack = length_tolerance * characteristic;
      for (std::size_t i = 0; i < over.size(); ++i) {
        const Interval free = over[i].value - cable.value;
        if (free.lower > most + slack || free.upper < least - slack) model.is_feasible = false;
        if (at[i].value.middle() > at[longest].value.middle()) longest = i;
        if (at[i].value.middle() < at[shortest].value.middle()) shortest = i;
      }
      const auto add = [&](std::size_t sample, double sign, double bound) {
        if (std::abs(bound) >= 0.5 * max_length) return;
        VectorX row = VectorX::Zero(variables());
        double error = 0;
        for (int j = 0; j < n; ++j) {
          const auto v = static_cast<std::size_t>(j);
          const Interval slope = over[sample].gradient[v] - cable.gradient[v];
          row[j] = sign * slope.middle();
          error += 0.5 * slope.width() * half[j];
        }
        left.push_back(row);
        right.push_back(sign * (bound - (at[sample].value.middle() - cable0)) + error + slack);
      };
      add(longest, 1, most);
      add(shortest, -1, least);
    }
    model.A.resize(static_cast<Eigen::Index>(left.size()), variables());
    model.b.resize(static_cast<Eigen::Index>(left.size()));
    for (std::size_t r = 0; r < left.size(); ++r) {
      model.A.row(static_cast<Eigen::Index>(r)) = left[r].transpose();
      model.b[static_cast<Eigen::Index>(r)] = right[r];
    }
  }

  Ranges ranges_of(const CatalogueBox& box) const {
    Ranges ranges;
    for (Eigen::Index i = 0; i < box.lower.size(); ++i) ranges.places.push_back({box.lower[i], box.upper[i]});
    for (std::size_t k = 0; k < trees.size(); ++k)
      ranges.attributes.push_back(trees[k].sets()[static_cast<std::size_t>(box.sets[k])].range);
    return ranges;
  }

  static Ranges middle_of(const Ranges& box) {
    Ranges middle = box;
    for (Interval& place : middle.places) place = place.middle();
    for (auto& attributes : middle.attributes)
      for (Interval& value : attributes) value = value.middle();
    return middle;
  }

  VectorX half_of(const Ranges& box) const {
    VectorX half = VectorX::Zero(variables());
    for (int i = 0; i < places(); ++i) half[i] = 0.5 * box.places[static_cast<std::size_t>(i)].width();
    for (std::size_t k = 0; k < trees.size(); ++k)
      for (const int attribute : {stiffness_attribute, preload_attribute})
        half[places() + 2 * static_cast<int>(k) + attribute] =
            0.5 * box.attributes[k][static_cast<std::size_t>(attribute)].width();
    return half;
  }

  /// A bound of one figure, with the effect of each variable on what is lost.
  struct FigureBound {
    double lower = 0;
    VectorX delta;
    VectorX weights;
    bool is_feasible = true;
  };

  FigureBound bound_series(const SampledQuantity& quantity, const SampledQuantity::Series& series, LinearModel& linear,
                           const Model& model, bool is_exact) const {
    constexpr int lawson_steps = 6;
    linear.A = model.A, linear.b = model.b;
    VectorX weights(linear.a.size());
    for (Eigen::Index i = 0; i < weights.size(); ++i) weights[i] = series.time_weights[i / series.components];
    FigureBound best;
    const int steps = quantity.is_peak ? lawson_steps : 1;
    for (int step = 0; step < steps; ++step) {
      const LeastNorm least = minimise_norm(linear, weights, model.half);
      if (!least.is_feasible) {
        best.is_feasible = false;
        return best;
      }
      const double error = is_exact ? 0 : std::sqrt(linear.e.cwiseAbs2().dot(weights));
      double norm = std::max(0.0, least.lower - error);
      const VectorX residual = linear.a + linear.B * least.delta;
      if (!is_exact) {
        // directly by intervals, which is better for large boxes
        const VectorX reach = linear.B.cwiseAbs() * model.half + linear.e;
        const VectorX distance = (linear.a.cwiseAbs() - reach).cwiseMax(0.0);
        norm = std::max(norm, std::sqrt(distance.cwiseAbs2().dot(weights)));
      }
      if (step == 0 || norm > best.lower) best.lower = norm, best.delta = least.delta, best.weights = weights;
      if (step + 1 == steps) break;
      double sum = 0;
      for (Eigen::Index i = 0; i < weights.size(); i += series.components) {
        const double size = residual.segment(i, series.components).norm();
        for (Eigen::Index c = 0; c < series.components; ++c) weights[i + c] *= size;
        sum += weights[i];
      }
      if (!(sum > 0)) break;
      weights /= sum;
    }
    return best;
  }

  /// Ranges of the springs over a box of places and rows, for length_ratio_bound.
  std::vector<SpringRange> spring_ranges(const Ranges& box, const std::vector<SpringForms>& forms,
                                         const std::vector<SpringForms>& points, const SpringSeries& series,
                                         const std::vector<std::vector<Interval>>& squares) const {
    const BoxAlgebra algebra(places());
    std::vector<SpringRange> ranges;
    for (std::size_t s = 0; s < springs.size(); ++s) {
      SpringRange range;
      range.features = forms[s].features;
      BoxForm size = algebra.constant(0.0);
      double middle_size = 0;
      for (const auto* end : {&forms[s].a, &forms[s].b})
        for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions()); ++i)
          size = algebra.add(size, algebra.square((*end)[i]));
      for (const auto* end : {&points[s].a, &points[s].b})
        for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions()); ++i)
          middle_size += (*end)[i].value.middle() * (*end)[i].value.middle();
      range.features.push_back(size);
      for (const BoxForm& feature : points[s].features) range.middle_features.push_back(feature.value.middle());
      range.middle_features.push_back(middle_size);
      const int choice = springs[s].choice;
      for (const int f : series.parts[s].features) {
        const BoxForm& feature = range.features[static_cast<std::size_t>(f)];
        const double middle = range.middle_features[static_cast<std::size_t>(f)];
        if (choice >= 0) {
          const Interval& k = box.attributes[static_cast<std::size_t>(choice)][stiffness_attribute];
          range.forces.push_back(algebra.scale(feature, k));
          range.middle_forces.push_back(k * middle);
        } else {
          range.forces.push_back(algebra.multiply(forms[s].stiffness, feature));
          range.middle_forces.emplace_back(points[s].stiffness.value.middle() * middle);
        }
      }
      if (choice >= 0) {
        const Interval& own = box.attributes[static_cast<std::size_t>(choice)][free_length_attribute];
        range.free_length = algebra.add(forms[s].cable, algebra.constant(own));
        range.middle_free_length = points[s].cable.value.middle() + own;
      } else {
        range.free_length = forms[s].free_length;
        range.middle_free_length = points[s].free_length.value.middle();
      }
      range.squares = squares[s];
      ranges.push_back(std::move(range));
    }
    return ranges;
  }

  /// Of the springs' lengths in a motion, by spring and sample.
  std::vector<std::vector<Interval>> squared_length_ranges(std::size_t motion,
                                                           const std::vector<SpringForms>& forms) const {
    std::vector<std::vector<Interval>> all(springs.size());
    for (std::size_t s = 0; s < springs.size(); ++s)
      for (const RelativePose& pose : relative_poses[motion][s]) {
        Interval sum = 0.0;
        for (int i = 0; i < dimensions(); ++i) {
          Interval component = pose.offset[i];
          for (int j = 0; j < dimensions(); ++j)
            component = component + forms[s].b[static_cast<std::size_t>(j)].value * pose.second(i, j) -
                        forms[s].a[static_cast<std::size_t>(j)].value * pose.first(i, j);
          sum = sum + balance::square(component);
        }
        all[s].push_back(sum);
      }
    return all;
  }

  /// Narrows a box to what may be better than the cutoff, and bounds what is left.
  /// @return false: nothing is
  /// @throws EnclosureError for an operation that cannot be enclosed
  bool bound_ratios(CatalogueBox& box, double cutoff, double& least, VectorX& score) const {
    const Ranges ranges = ranges_of(box), middle = middle_of(ranges);
    if (!keeps_sums(ranges)) return false;
    const int n = places();
    const BoxAlgebra algebra(n), point_algebra(0);
    std::vector<BoxForm> over, at;
    for (int i = 0; i < n; ++i) {
      over.push_back(algebra.place(i, ranges.places[static_cast<std::size_t>(i)]));
      at.push_back(point_algebra.constant(middle.places[static_cast<std::size_t>(i)]));
    }
    const std::vector<SpringForms> forms = spring_forms(algebra, evaluate_graph(algebra, over)),
                                   points = spring_forms(point_algebra, evaluate_graph(point_algebra, at));
    std::vector<std::vector<std::vector<Interval>>> squares;
    for (std::size_t m = 0; m < motions.size(); ++m) squares.push_back(squared_length_ranges(m, forms));
    PlaceRange range(half_of(ranges).head(n));
    for (const DistanceLimit& limit : limits)
      if (limit.spring >= 0 && !narrow_to_travel(limit, ranges, forms, points, squares, range)) return false;
    const double cost = cost_lower_bound(ranges);
    double sum = cost;
    score.setZero(variables());
    for (std::size_t k = 0; k < trees.size(); ++k)
      score[n + 2 * static_cast<int>(k)] += ranges.attributes[k][cost_attribute].width();
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      double worst = 0;
      for (const SpringSeries& series : ratio_series[q]) {
        const auto& own_squares = squares[static_cast<std::size_t>(quantities[q].motion)];
        const std::vector<SpringRange> given = spring_ranges(ranges, forms, points, series, own_squares);
        const LengthRatioBound one =
            bound_by_length_ratios(series, given, (cutoff - cost) / quantities[q].weight, range);
        if (!one.is_feasible) return false;
        worst = std::max(worst, one.lower);
        score.head(n) += quantities[q].weight * one.score;
        for (std::size_t s = 0; s < springs.size(); ++s)
          if (springs[s].choice >= 0)
            score[n + 2 * springs[s].choice] +=
                quantities[q].weight * one.part_score[static_cast<Eigen::Index>(s)] *
                relative_width(ranges.attributes[static_cast<std::size_t>(springs[s].choice)], given[s],
                               own_squares[s]);
      }
      sum += quantities[q].weight * worst;
    }
    least = std::max(least, std::min(sum, cutoff));
    for (Eigen::Index i = 0; i < n; ++i) {
      const Interval& delta = range.ranges()[static_cast<std::size_t>(i)];
      const double at_middle = middle.places[static_cast<std::size_t>(i)].middle();
      box.lower[i] = std::clamp(at_middle + delta.lower, box.lower[i], box.upper[i]);
      box.upper[i] = std::clamp(at_middle + delta.upper, box.lower[i], box.upper[i]);
    }
    return true;
  }

  /// How far the rows of a set differ in what matters for a spring.
  static double relative_width(const std::vector<Interval>& attributes, const SpringRange& spring,
                               const std::vector<Interval>& squares) {
    double longest = 1e-300;
    for (const Interval& square : squares) longest = std::max(longest, std::sqrt(square.upper));
    const Interval& k = attributes[stiffness_attribute];
    const double free_length = std::max(spring.free_length.value.magnitude(), 1e-3 * longest);
    const double travel =
        std::min(attributes[shortest_attribute].width() + attributes[longest_attribute].width(), longest);
    return k.width() / (k.lower + k.upper + 1e-300) + 0.5 * attributes[free_length_attribute].width() / free_length +
           0.5 * travel / longest;
  }

  /// The places where the cable leaves a length within some row's travel.
  bool narrow_to_travel(const DistanceLimit& limit, const Ranges& ranges, const std::vector<SpringForms>& forms,
                        const std::vector<SpringForms>& points,
                        const std::vector<std::vector<std::vector<Interval>>>& squares, PlaceRange& range) const {
    const auto s = static_cast<std::size_t>(limit.spring);
    const auto& attributes = ranges.attributes[static_cast<std::size_t>(springs[s].choice)];
    double max_length_bound = -infinity, min_length = infinity;
    for (const Interval& square : squares[static_cast<std::size_t>(limit.motion)][s]) {
      max_length_bound = std::max(max_length_bound, std::sqrt(std::max(square.lower, 0.0)));
      min_length = std::min(min_length, std::sqrt(square.upper));
    }
    const double slack = length_tolerance * characteristic;
    return range.narrow(forms[s].cable, points[s].cable.value.middle(),
                        {max_length_bound - attributes[longest_attribute].upper - slack,
                         min_length - attributes[shortest_attribute].lower + slack});
  }

  CatalogueBound bound(const CatalogueBox& given, double cutoff) const {
    CatalogueBound result;
    CatalogueBox box = given;
    VectorX score = VectorX::Zero(variables());
    bool has_ratios = places() > 0;
    constexpr int max_passes = 2;
    constexpr double worthwhile_reduction = 0.7;
    for (int pass = 0; pass < max_passes && has_ratios; ++pass) {
      const VectorX before = box.upper - box.lower;
      try {
        if (!bound_ratios(box, std::min(cutoff, max_cutoff), box.bound, score)) {
          result.is_feasible = false;
          return result;
        }
      } catch (const EnclosureError&) {
        has_ratios = false;
      }
      const VectorX after = box.upper - box.lower;
      if (box.bound >= cutoff || (after.array() >= worthwhile_reduction * before.array()).all()) break;
    }
    result.lower = box.bound;
    if (box.bound >= cutoff) return result;
    const Ranges ranges = ranges_of(box), middle = middle_of(ranges);
    const VectorX half = half_of(ranges);
    VectorX delta = VectorX::Zero(variables());
    const bool has_distances =
        std::any_of(limits.begin(), limits.end(), [](const DistanceLimit& limit) { return limit.spring < 0; });
    constexpr double small_share = 0.01;
    const bool is_small = ((box.upper - box.lower).array() <= small_share * (upper - lower).array()).all();
    if (!has_ratios || has_distances || is_small)
      bound_linear(box, ranges, middle, half, !has_ratios, delta, score, result);
    if (result.is_feasible) describe(box, middle, half, delta, score, result);
    return result;
  }

  /// Stands for a cutoff that is not known yet.
  static constexpr double max_cutoff = 1e30;

  void bound_linear(const CatalogueBox& box, const Ranges& ranges, const Ranges& middle, const VectorX& half,
                    bool sets_score, VectorX& delta, VectorX& score, CatalogueBound& result) const {
    Model model;
    try {
      model = linearise(ranges, middle, half);
    } catch (const EnclosureError&) {
      return;
    }
    if (!model.is_feasible) {
      result.is_feasible = false;
      return;
    }
    double sum = model.cost;
    double largest_share = -1;
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      double worst = 0;
      for (std::size_t s = 0; s < quantities[q].series.size(); ++s) {
        LinearModel& linear = model.quantities[q][s];
        const FigureBound one = bound_series(quantities[q], quantities[q].series[s], linear, model, false);
        if (!one.is_feasible) {
          result.is_feasible = false;
          return;
        }
        worst = std::max(worst, one.lower);
        if (quantities[q].weight * one.lower <= largest_share && largest_share >= 0) continue;
        largest_share = quantities[q].weight * one.lower;
        delta = one.delta;
        if (sets_score) set_scores(linear, one, half, box, score);
      }
      sum += quantities[q].weight * worst;
    }
    result.lower = std::max(result.lower, sum);
  }

  /// How much of the bound is lost by the width of each variable.
  void set_scores(const LinearModel& linear, const FigureBound& one, const VectorX& half, const CatalogueBox& box,
                  VectorX& score) const {
    const int n = places();
    // radii of the derivatives, shared out by half widths: e is their sum
    const double total = std::sqrt(linear.e.cwiseAbs2().dot(one.weights));
    double reach = 0;
    VectorX spread(variables());
    for (int j = 0; j < variables(); ++j) {
      spread[j] = std::sqrt(linear.B.col(j).cwiseAbs2().dot(one.weights)) * half[j];
      reach += spread[j];
    }
    for (int j = 0; j < variables(); ++j) {
      score[j] = reach > 0 ? total * spread[j] / reach : half[j];
      if (j < n) continue;
      const auto& set = trees[static_cast<std::size_t>((j - n) / 2)]
                            .sets()[static_cast<std::size_t>(box.sets[static_cast<std::size_t>((j - n) / 2)])];
      score[j] += 0.3 * spread[j];
      if (set.left < 0) score[j] = 0;
    }
  }

  /// Designs near the bound, and the halves of the box.
  void describe(const CatalogueBox& box, const Ranges& middle, const VectorX& half, const VectorX& delta,
                const VectorX& score, CatalogueBound& result) const {
    const int n = places();
    result.x.resize(n);
    for (int i = 0; i < n; ++i)
      result.x[i] = std::clamp(middle.places[static_cast<std::size_t>(i)].middle() + delta[i], lower[i], upper[i]);
    for (std::size_t k = 0; k < trees.size(); ++k) {
      const RowTree& tree = trees[k];
      const RowTree::Set& set = tree.sets()[static_cast<std::size_t>(box.sets[k])];
      const int j = n + 2 * static_cast<int>(k);
      int best = tree.rows()[static_cast<std::size_t>(set.begin)];
      double best_distance = infinity;
      constexpr int max_scanned_rows = 256;
      for (int i = set.begin; i < std::min(set.end, set.begin + max_scanned_rows); ++i) {
        const int row = tree.rows()[static_cast<std::size_t>(i)];
        double distance = 0;
        for (const int attribute : {stiffness_attribute, preload_attribute}) {
          const double target =
              middle.attributes[k][static_cast<std::size_t>(attribute)].middle() + delta[j + attribute];
          if (half[j + attribute] > 0)
            distance += std::abs(tree.attributes()(row, attribute) - target) / half[j + attribute];
        }
        if (distance < best_distance) best = row, best_distance = distance;
      }
      result.rows.push_back(space.start.catalogue_choices[k].is_free ? best : space.start.catalogue_choices[k].row);
    }
    split(box, score, half, result);
  }

  void split(const CatalogueBox& box, const VectorX& score, const VectorX& half, CatalogueBound& result) const {
    const int n = places();
    int widest = -1;
    double largest = 0;
    const auto is_divisible = [&](int j) {
      if (j < n) return half[j] > 0;
      const auto k = static_cast<std::size_t>((j - n) / 2);
      return trees[k].sets()[static_cast<std::size_t>(box.sets[k])].left >= 0;
    };
    for (int j = 0; j < variables(); ++j)
      if (score[j] > largest && is_divisible(j)) widest = j, largest = score[j];
    if (widest < 0) {  // rows first
      int size = 1;
      for (std::size_t k = 0; k < trees.size(); ++k) {
        const RowTree::Set& set = trees[k].sets()[static_cast<std::size_t>(box.sets[k])];
        if (set.left >= 0 && set.end - set.begin > size)
          size = set.end - set.begin, widest = n + 2 * static_cast<int>(k);
      }
      double width = 1e-12;
      for (int i = 0; i < n && widest < n && size == 1; ++i)
        if (const double share = 2 * half[i] / (upper[i] - lower[i] + 1e-300); share > width) widest = i, width = share;
    }
    if (widest < 0) return;
    std::array<CatalogueBox, 2> halves{box, box};
    if (widest >= n) {
      const auto k = static_cast<std::size_t>((widest - n) / 2);
      const RowTree::Set& set = trees[k].sets()[static_cast<std::size_t>(box.sets[k])];
      if (set.left < 0) return;
      halves[0].sets[k] = set.left, halves[1].sets[k] = set.right;
    } else {
      const double at = 0.5 * (box.lower[widest] + box.upper[widest]);
      if (!(at > box.lower[widest] && at < box.upper[widest])) return;
      halves[0].upper[widest] = at, halves[1].lower[widest] = at;
    }
    result.halves.push_back(std::move(halves));
  }

  Ranges point_ranges(const std::vector<int>& rows, const VectorX& x) const {
    Ranges ranges;
    for (Eigen::Index i = 0; i < x.size(); ++i) ranges.places.emplace_back(x[i]);
    for (std::size_t k = 0; k < trees.size(); ++k) {
      ranges.attributes.emplace_back();
      const Eigen::Index row = space.start.catalogue_choices[k].is_free ? rows[k] : 0;
      for (Eigen::Index j = 0; j < trees[k].attributes().cols(); ++j)
        ranges.attributes.back().emplace_back(trees[k].attributes()(row, j));
    }
    return ranges;
  }

  double objective_of(const Model& model) const {
    double sum = model.cost;
    for (std::size_t q = 0; q < quantities.size(); ++q) {
      double worst = 0;
      for (std::size_t s = 0; s < quantities[q].series.size(); ++s) {
        const SampledQuantity::Series& series = quantities[q].series[s];
        const VectorX& a = model.quantities[q][s].a;
        const auto sizes = a.reshaped(series.components, series.time_weights.size()).colwise().norm();
        worst =
            std::max(worst, quantities[q].is_peak ? numerics::max_abs(VectorX(sizes.transpose()))
                                                  : std::sqrt(sizes.cwiseAbs2().dot(series.time_weights.transpose())));
      }
      sum += quantities[q].weight * worst;
    }
    return sum;
  }

  /// The largest excess over a limit on lengths, in characteristic lengths; infinite for sums that are not kept.
  double violation_of(const Model& model) const {
    double worst = -infinity;
    for (Eigen::Index r = 0; r < model.b.size(); ++r) worst = std::max(worst, -model.b[r] / characteristic);
    return model.is_feasible ? std::min(worst, 0.0) : std::max(worst, 1e-300);
  }

  CatalogueDesign evaluate(const std::vector<int>& rows, const VectorX& x) const {
    const Ranges at = point_ranges(rows, x);
    CatalogueDesign design{rows, x, infinity, infinity};
    try {
      const Model model = linearise(at, at, VectorX::Zero(variables()));
      design.value = objective_of(model);
      design.violation = violation_of(model);
    } catch (const EnclosureError&) {
    }
    return design;
  }

  /// Gauss–Newton steps within a trust region, with the limits on lengths linearised.
  CatalogueDesign improve(const CatalogueDesign& start) const {
    constexpr int max_steps = 25;
    CatalogueDesign best = evaluate(start.rows, start.x);
    if (places() == 0 || quantities.empty()) return best;
    const auto is_better = [](const CatalogueDesign& a, const CatalogueDesign& b) {
      if ((a.violation > 0) != (b.violation > 0)) return a.violation <= 0;
      return a.violation > 0 ? a.violation < b.violation : a.value < b.value;
    };
    VectorX radius = 0.25 * (upper - lower);
    for (int step = 0; step < max_steps && numerics::max_abs(radius) > 1e-10 * numerics::max_abs(upper - lower);
         ++step) {
      const Ranges at = point_ranges(best.rows, best.x);
      try {
        // the trust region within the bounds, about its own middle
        const VectorX low = (best.x - radius).cwiseMax(lower), high = (best.x + radius).cwiseMin(upper);
        const VectorX shift = 0.5 * (low + high) - best.x;
        VectorX half = VectorX::Zero(variables());
        half.head(places()) = 0.5 * (high - low);
        Model model = linearise(at, at, VectorX::Zero(variables()));
        model.half = half;
        VectorX moved = VectorX::Zero(variables());
        moved.head(places()) = shift;
        if (model.b.size() > 0) {
          model.b -= model.A * moved;
          model.b.array() -= 2 * length_tolerance * characteristic;  // strictly inside
        }
        double largest = -1;
        VectorX delta = VectorX::Zero(variables());
        for (std::size_t q = 0; q < quantities.size(); ++q)
          for (std::size_t s = 0; s < quantities[q].series.size(); ++s) {
            LinearModel& linear = model.quantities[q][s];
            linear.a += linear.B * moved;
            Model with_slack = model;
            for (Eigen::Index r = 0; r < with_slack.b.size(); ++r)  // as nearly as the region allows
              with_slack.b[r] = std::max(with_slack.b[r], -0.999 * with_slack.A.row(r).cwiseAbs().dot(half));
            const FigureBound one = bound_series(quantities[q], quantities[q].series[s], linear, with_slack, true);
            if (!one.is_feasible || quantities[q].weight * one.lower <= largest) continue;
            largest = quantities[q].weight * one.lower;
            delta = one.delta;
          }
        CatalogueDesign next =
            evaluate(best.rows, (best.x + shift + delta.head(places())).cwiseMax(lower).cwiseMin(upper));
        if (is_better(next, best)) {
          const bool is_done = best.violation <= 0 && best.value - next.value <= 1e-12 * best.value;
          best = std::move(next);
          if (is_done) break;
          radius *= 1.5;
        } else {
          radius *= 0.3;
        }
      } catch (const EnclosureError&) {
        break;
      }
    }
    return best;
  }

 private:
  std::map<std::string, int> motion_names_;
};

CatalogueProgram::CatalogueProgram(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms)
    : implementation_(std::make_unique<const Implementation>(space, terms)) {}
CatalogueProgram::~CatalogueProgram() = default;
CatalogueProgram::CatalogueProgram(CatalogueProgram&&) noexcept = default;

CatalogueBox CatalogueProgram::root() const {
  return {std::vector<int>(implementation_->trees.size(), 0), implementation_->lower, implementation_->upper, 0};
}
CatalogueBound CatalogueProgram::bound(const CatalogueBox& box, double cutoff) const {
  return implementation_->bound(box, cutoff);
}
CatalogueDesign CatalogueProgram::improve(const CatalogueDesign& start) const {
  return implementation_->improve(start);
}
CatalogueDesign CatalogueProgram::evaluate(const std::vector<int>& rows, const VectorX& x) const {
  return implementation_->evaluate(rows, x);
}
const std::vector<int>& CatalogueProgram::similar_rows(int choice) const {
  return implementation_->trees[static_cast<std::size_t>(choice)].rows();
}
bool CatalogueProgram::knows_all_limits() const { return implementation_->knows_limits; }

}  // namespace balance::design
