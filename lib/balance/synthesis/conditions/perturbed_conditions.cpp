#include "balance/synthesis/conditions/perturbed_conditions.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"
#include "balance/synthesis/conditions/row_reduction.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>

namespace balance::conditions {

namespace {

/// A configuration of the first mechanism and the velocity to evaluate there.
struct SampledState {
  VectorX y;
  VectorX velocity_seed;  ///< scaled; its projection onto the admissible velocities is the velocity evaluated
};

/// What remains of rows · π, for every column of π, with the extra unknowns that fit best.
MatrixX project_out_unknowns(const MatrixX& rows, const MatrixX& parameters) {
  MatrixX products = rows.leftCols(parameters.rows()) * parameters;
  const Eigen::Index extra = rows.cols() - parameters.rows();
  if (extra == 0) return products;
  const MatrixX unknown_columns = rows.rightCols(extra);
  return products - unknown_columns * numerics::ColumnPivotingQr(unknown_columns).solve(products);
}

/// An order that the first mechanism lacks counts from this size on, relative to that of the quantity.
constexpr double min_order_weight = 1e-3;

/// Appends weighted rows of the parameters, which the other columns do not concern.
void append_columns_of(const MatrixX& rows, const VectorX& weights, MatrixX& stacked_rows) {
  const Eigen::Index first = stacked_rows.rows();
  stacked_rows.conservativeResize(first + rows.rows(), Eigen::NoChange);
  stacked_rows.bottomRows(rows.rows()).setZero();
  stacked_rows.block(first, 0, rows.rows(), rows.cols()) = weights.asDiagonal() * rows;
}

void stack_blocks(const std::vector<MatrixX>& blocks, Eigen::Index columns, MatrixX& stacked_rows) {
  Eigen::Index count = 0;
  for (const MatrixX& block : blocks) count += block.rows();
  stacked_rows.resize(count, columns);
  Eigen::Index first_row = 0;
  for (const MatrixX& block : blocks) {
    stacked_rows.middleRows(first_row, block.rows()) = block;
    first_row += block.rows();
  }
}

}  // namespace

struct GoalResidual::Implementation {
  virtual ~Implementation() = default;
  /// Stacked rows in natural units, and per term one SI unit of it in natural units.
  using RowsCallback = std::function<void(const MatrixX& rows, const VectorX& per_unit)>;
  virtual bool collect(const Mechanism& mechanism, const RowsCallback& callback) = 0;
  virtual VectorX values(const Mechanism& mechanism) const = 0;
};

namespace {

template <class S>
class ResidualSamples : public GoalResidual::Implementation {
 public:
  ResidualSamples(const Mechanism& mechanism, const Conditions& conditions, const ConditionOptions& options)
      : options_(options),
        goals_(conditions.goals),
        tree_(kinematics::compile_tree<S>(mechanism, list_needed_coordinates(mechanism, conditions.goals, options))),
        units_(mechanism, conditions.parameters),
        term_mask_(VectorX::Ones(conditions.matrix.cols())) {
    // terms that no parameter can balance are constant and would only hide the rest of the residual
    for (Eigen::Index k = 0; k < conditions.known_term_values.size(); ++k) {
      const Eigen::Index column = conditions.parameter_columns() + k;
      if (!conditions.is_variable_term(k) && conditions.matrix.col(column).head(conditions.parameter_rows()).isZero(0))
        term_mask_[column] = 0;
    }
    ConfigurationSampler<S> sampler(mechanism, tree_, options.seed);
    numerics::UniformRandom random(options.seed + 1);
    SampledConfiguration configuration;
    const int target_count = conditions.samples + 4;
    const bool has_loops = tree_.closure_rows > 0;
    SampledConfiguration first;
    for (int attempts = 0; static_cast<int>(samples_.size()) < target_count && attempts < 20 * target_count;
         ++attempts) {
      // where loops must close with other numbers, too, all configurations are near the first one
      if ((!has_loops || attempts == 0) && !sampler.next(first)) break;
      freedoms_ = sampler.freedoms();
      configuration = first;
      if (has_loops && attempts > 0 && !sample_near(first, random, configuration)) continue;
      samples_.push_back({configuration.y, random.sample_normal(tree_.columns)});
      MatrixX rows;
      if (!evaluate_rows(mechanism, tree_, {samples_.back()}, rows)) samples_.pop_back();
    }
    if (!conditions.orders.rows.empty()) {
      const MatrixX orders = scale_order_rows(conditions.orders, units_.parameter, term_mask_);
      order_weights_ = orders.rowwise().norm().cwiseMax(min_order_weight).cwiseInverse();
    }
    if (samples_.empty()) throw std::invalid_argument("no configuration of the mechanism was found");
  }

  bool collect(const Mechanism& mechanism, const RowsCallback& callback) override {
    kinematics::Tree<S> tree =
        kinematics::compile_tree<S>(mechanism, list_needed_coordinates(mechanism, goals_, options_));
    if (tree.columns != tree_.columns || tree.closure_rows != tree_.closure_rows) return false;
    for (const kinematics::NodeId spherical : tree_.spherical_joints)
      tree.nodes[static_cast<std::size_t>(spherical)].R_PF = tree_.nodes[static_cast<std::size_t>(spherical)].R_PF;
    MatrixX rows;
    if (!evaluate_rows(mechanism, tree, samples_, rows) || !append_order_rows(mechanism, tree, rows)) return false;
    callback(rows, term_mask_.cwiseQuotient(units_.parameter) / units_.mass);
    return true;
  }

  VectorX values(const Mechanism& mechanism) const override { return term_values(mechanism, options_.loose_springs); }

 private:
  /// Takes a single step of random length and direction from another configuration. It is long enough to distinguish
  /// mechanisms, and short enough that with slightly different lengths the loops still close, and on the same side of a
  /// folded pose.
  bool sample_near(const SampledConfiguration& reference, numerics::UniformRandom& random,
                   SampledConfiguration& configuration) const {
    constexpr double max_sample_step = 0.6;
    kinematics::ConstraintSystem<S> closures(tree_, kinematics::Drive<S>{});
    const VectorX scale = column_scale(tree_);
    VectorX direction = reference.null_space * random.sample_normal(reference.null_space.cols());
    direction.normalize();
    const double step_length = random(-max_sample_step, max_sample_step);
    const kinematics::AssemblySolution assembly =
        kinematics::solve_assembly(closures, reference.y + step_length * scale.cwiseProduct(direction), {}, 30);
    if (!assembly.found) return false;
    const VectorX displacement = (assembly.y - reference.y).cwiseQuotient(scale);
    configuration.y = assembly.y;
    return displacement.dot(direction) * (step_length < 0 ? -1 : 1) > 0.7 * displacement.norm() &&
           displacement.norm() < 2 * std::abs(step_length);
  }

  bool evaluate_rows(const Mechanism& mechanism, const kinematics::Tree<S>& tree,
                     const std::vector<SampledState>& samples, MatrixX& stacked_rows) {
    GoalRows<S> goal_rows(mechanism, tree, units_, goals_, options_, freedoms_);
    kinematics::ConstraintSystem<S> closures(tree, kinematics::Drive<S>{});
    std::vector<MatrixX> blocks(samples.size());
    for (std::size_t k = 0; k < samples.size(); ++k) {
      SampledConfiguration configuration;
      if (!project_onto_closures(closures, samples[k].y, freedoms_, configuration)) return false;
      // projected, since a basis would rotate as the numbers change
      const MatrixX projector = configuration.null_space * configuration.null_space.transpose();
      if (!goal_rows.evaluate(configuration, {projector, projector * samples[k].velocity_seed}, blocks[k]))
        return false;
    }
    stack_blocks(blocks, goal_rows.parameters() + goal_rows.extra_unknowns(), stacked_rows);
    return true;
  }

  bool append_order_rows(const Mechanism& mechanism, const kinematics::Tree<S>& tree, MatrixX& rows) const {
    if (order_weights_.size() == 0) return true;
    const OrderRows orders =
        compute_order_rows(mechanism, goals_, options_.motions, options_.loose_springs, units_.parameter);
    if (!orders.mismatch.empty()) return false;
    const GoalRows<S> goal_rows(mechanism, tree, units_, goals_, options_, freedoms_);
    append_columns_of(scale_order_rows(orders, units_.parameter, goal_rows.term_mask()), order_weights_, rows);
    return true;
  }

  ConditionOptions options_;
  std::vector<Goal> goals_;
  kinematics::Tree<S> tree_;  ///< of the first mechanism, with the reference orientations of its spherical joints
  NaturalUnits units_;
  VectorX order_weights_;  ///< per row of an order: it is of unit size for the first mechanism
  VectorX term_mask_;      ///< per term: 0 for known terms that no parameter can balance, else 1
  int freedoms_ = 0;
  std::vector<SampledState> samples_;
};

}  // namespace

GoalResidual::GoalResidual(const Mechanism& mechanism, const std::vector<Goal>& goals,
                           const ConditionOptions& options) {
  const Conditions conditions = derive_conditions(mechanism, goals, options);
  if (conditions.status != ConditionsStatus::done) throw std::invalid_argument(conditions.reason);
  kinematics::dispatch_space(mechanism.space, [&]<class S>(S) {
    implementation_ = std::make_unique<ResidualSamples<S>>(mechanism, conditions, options);
  });
}

GoalResidual::~GoalResidual() = default;
GoalResidual::GoalResidual(GoalResidual&&) noexcept = default;
GoalResidual& GoalResidual::operator=(GoalResidual&&) noexcept = default;

bool GoalResidual::evaluate(const Mechanism& mechanism, VectorX& residual) {
  return implementation_->collect(mechanism, [&](const MatrixX& rows, const VectorX& per_unit) {
    residual = project_out_unknowns(rows, implementation_->values(mechanism).cwiseProduct(per_unit));
  });
}

bool GoalResidual::rows(const Mechanism& mechanism, MatrixX& rows) const {
  return implementation_->collect(mechanism, [&](const MatrixX& all, const VectorX& per_unit) {
    rows = project_out_unknowns(all, per_unit.asDiagonal().toDenseMatrix());
  });
}

namespace {

constexpr int min_perturbed_samples = 4, max_perturbed_samples = 400;
/// Relative to a condition's largest coefficient: accuracy to which the known conditions must be reproduced, and to
/// which perturbed ones must hold at all configurations. Coefficients are compared to seven digits.
constexpr double reproduction_tolerance = 1e-9, perturbed_row_tolerance = 1e-8;
/// A residual above this, far larger than round-off, shows that there are more conditions than the known ones.
constexpr double rank_change_threshold = 1e-5;

/// What the configurations reveal about a perturbed mechanism's rank.
enum class PerturbedRank { unchanged, changed, unknown };

}  // namespace

struct PerturbedConditions::Implementation {
  virtual ~Implementation() = default;
  virtual PerturbedRank solve_for_pivots(const Mechanism& mechanism, MatrixX& matrix) const = 0;
  Conditions known_conditions;
};

namespace {

template <class S>
class PerturbedRows : public PerturbedConditions::Implementation {
 public:
  PerturbedRows(const Mechanism& mechanism, const Conditions& conditions, const ConditionOptions& options)
      : options_(options),
        tree_(kinematics::compile_tree<S>(mechanism, list_needed_coordinates(mechanism, conditions.goals, options))) {
    known_conditions.goals = conditions.goals;
    known_conditions.parameters = conditions.parameters;
    known_conditions.known_term_values = conditions.known_term_values;
    known_conditions.pivots = conditions.pivots;
    known_conditions.rank = conditions.rank;
    if (conditions.matrix.rows() == 0) return;
    ConfigurationSampler<S> sampler(mechanism, tree_, options.seed);
    numerics::UniformRandom random(options.seed + 2);
    SampledConfiguration configuration;
    for (int target_count = min_perturbed_samples; target_count <= max_perturbed_samples; target_count *= 2) {
      while (static_cast<int>(y_.size()) < target_count) {
        if (!sampler.next(configuration)) return;
        freedoms_ = sampler.freedoms();
        y_.push_back(configuration.y);
        velocity_seeds_.push_back(random.sample_normal(tree_.columns));
      }
      MatrixX reproduced;
      reproduces_known_ = true;
      reproduces_known_ = PerturbedRows::solve_for_pivots(mechanism, reproduced) == PerturbedRank::unchanged &&
                          is_reproduced(reproduced, conditions.matrix);
      if (reproduces_known_) return;
    }
  }

  PerturbedRank solve_for_pivots(const Mechanism& mechanism, MatrixX& matrix) const override {
    if (!reproduces_known_) return PerturbedRank::unknown;
    kinematics::Tree<S> tree =
        kinematics::compile_tree<S>(mechanism, list_needed_coordinates(mechanism, known_conditions.goals, options_));
    if (tree.columns != tree_.columns || tree.closure_rows != tree_.closure_rows ||
        tree.spherical_joints != tree_.spherical_joints)
      return PerturbedRank::unknown;
    for (const kinematics::NodeId spherical : tree_.spherical_joints)
      tree.nodes[static_cast<std::size_t>(spherical)].R_PF = tree_.nodes[static_cast<std::size_t>(spherical)].R_PF;
    const NaturalUnits units(mechanism, known_conditions.parameters);
    MatrixX rows;
    return stack_rows(mechanism, tree, units, rows) ? solve(rows, units, matrix) : PerturbedRank::unknown;
  }

 private:
  bool stack_rows(const Mechanism& mechanism, const kinematics::Tree<S>& tree, const NaturalUnits& units,
                  MatrixX& stacked_rows) const {
    GoalRows<S> goal_rows(mechanism, tree, units, known_conditions.goals, options_, freedoms_);
    if (!goal_rows.mismatch_reason().empty()) return false;
    kinematics::ConstraintSystem<S> closures(tree, kinematics::Drive<S>{});
    std::vector<MatrixX> blocks;
    for (std::size_t k = 0; k < y_.size(); ++k) {
      SampledConfiguration configuration;
      MatrixX rows;
      if (!project_onto_closures(closures, y_[k], freedoms_, configuration)) return false;
      const VectorX velocity = configuration.null_space * (configuration.null_space.transpose() * velocity_seeds_[k]);
      if (!goal_rows.evaluate(configuration, {configuration.null_space, velocity}, rows))
        continue;  // not held well there by the actuators
      blocks.push_back(std::move(rows));
    }
    stack_blocks(blocks, goal_rows.parameters() + goal_rows.extra_unknowns(), stacked_rows);
    return append_order_rows(mechanism, goal_rows, units, stacked_rows);
  }

  /// Those that are more than round-off, with the same length.
  bool append_order_rows(const Mechanism& mechanism, const GoalRows<S>& goal_rows, const NaturalUnits& units,
                         MatrixX& stacked_rows) const {
    constexpr double min_size = 1e-8;
    if (study::select_goal_motions(known_conditions.goals, options_.motions).empty()) return true;
    const OrderRows orders = compute_order_rows(mechanism, known_conditions.goals, options_.motions,
                                                options_.loose_springs, units.parameter);
    if (!orders.mismatch.empty()) return false;
    const MatrixX scaled = scale_order_rows(orders, units.parameter, goal_rows.term_mask());
    const VectorX sizes = scaled.rowwise().norm();
    append_columns_of(scaled, (sizes.array() > min_size).select(sizes.cwiseInverse(), 0.0), stacked_rows);
    return true;
  }

  /// rows = X R with R the identity at the pivots, so X consists of the rows' pivot columns.
  PerturbedRank solve(const MatrixX& rows, const NaturalUnits& units, MatrixX& matrix) const {
    const MatrixX parameter_rows = eliminate_extra_unknowns(rows, static_cast<int>(units.parameter.size()));
    const auto rank = static_cast<Eigen::Index>(known_conditions.pivots.size());
    if (parameter_rows.rows() <= rank) return PerturbedRank::unknown;
    const MatrixX X = parameter_rows(Eigen::all, known_conditions.pivots);
    const numerics::ColumnPivotingQr qr(X);
    const auto diagonal = qr.matrixQR().diagonal().cwiseAbs();
    if (!(numerics::min_coefficient(diagonal) > reproduction_tolerance * numerics::max_coefficient(diagonal)))
      return PerturbedRank::unknown;
    MatrixX R = qr.solve(parameter_rows);
    const double relative_residual = numerics::max_abs(parameter_rows - X * R) / numerics::max_abs(parameter_rows);
    if (!(relative_residual < perturbed_row_tolerance))
      return relative_residual > rank_change_threshold ? PerturbedRank::changed : PerturbedRank::unknown;
    for (Eigen::Index r = 0; r < rank; ++r) round_row(R, r);
    VectorX pivot_units(rank);
    for (Eigen::Index r = 0; r < rank; ++r)
      pivot_units[r] = units.parameter[known_conditions.pivots[static_cast<std::size_t>(r)]];
    matrix = pivot_units.asDiagonal() * R * units.parameter.cwiseInverse().asDiagonal();
    return PerturbedRank::unchanged;
  }

  void round_row(MatrixX& R, Eigen::Index row) const {
    const double largest = numerics::max_abs(R.row(row));
    R.row(row) = (R.row(row).array().abs() < 0.1 * reproduction_tolerance * largest).select(0.0, R.row(row));
    for (std::size_t r = 0; r < known_conditions.pivots.size(); ++r)
      R(row, known_conditions.pivots[r]) = static_cast<Eigen::Index>(r) == row ? 1 : 0;
  }

  static bool is_reproduced(const MatrixX& matrix, const MatrixX& expected) {
    for (Eigen::Index row = 0; row < expected.rows(); ++row)
      if (!(numerics::max_abs(matrix.row(row) - expected.row(row)) <
            reproduction_tolerance * numerics::max_abs(expected.row(row))))
        return false;
    return true;
  }

  ConditionOptions options_;
  kinematics::Tree<S> tree_;  ///< of the known mechanism, with the reference orientations of its spherical joints
  int freedoms_ = 0;
  bool reproduces_known_ = false;
  std::vector<VectorX> y_, velocity_seeds_;
};

}  // namespace

PerturbedConditions::PerturbedConditions(const Mechanism& mechanism, const Conditions& conditions,
                                         const ConditionOptions& options) {
  kinematics::dispatch_space(mechanism.space, [&]<class S>(S) {
    implementation_ = std::make_unique<PerturbedRows<S>>(mechanism, conditions, options);
  });
}

PerturbedConditions::~PerturbedConditions() = default;
PerturbedConditions::PerturbedConditions(PerturbedConditions&&) noexcept = default;
PerturbedConditions& PerturbedConditions::operator=(PerturbedConditions&&) noexcept = default;

std::optional<Conditions> PerturbedConditions::derive(const Mechanism& mechanism) const {
  Conditions conditions = implementation_->known_conditions;
  const PerturbedRank rank = implementation_->solve_for_pivots(mechanism, conditions.matrix);
  if (rank == PerturbedRank::unknown) return std::nullopt;
  conditions.status = rank == PerturbedRank::unchanged ? ConditionsStatus::done : ConditionsStatus::rank_unclear;
  return conditions;
}

std::function<Conditions(const Mechanism&)> make_perturbed_derivation(
    const std::function<Conditions(const Mechanism&)>& derive,
    const std::function<Mechanism(const Mechanism&)>& prepare, const Mechanism& mechanism, const Conditions& conditions,
    const ConditionOptions& options) {
  // shared only because a std::function must be copyable
  const auto perturbed_conditions = std::make_shared<PerturbedConditions>(prepare(mechanism), conditions, options);
  return [=](const Mechanism& other) {
    std::optional<Conditions> perturbed = perturbed_conditions->derive(prepare(other));
    return perturbed ? *std::move(perturbed) : derive(other);
  };
}

}  // namespace balance::conditions
