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

namespace balance {

namespace {

/// Configurations of the first mechanism, and how to look at them.
struct ResidualSample {
  VectorX y;
  VectorX velocity_seed;  ///< scaled; its part along the allowed velocities is the velocity probed
};

/// What is left of A π when the extra unknowns are chosen as well as they can be, for every column of π.
MatrixX project_out_unknowns(const MatrixX& rows, const MatrixX& parameters) {
  MatrixX all = rows.leftCols(parameters.rows()) * parameters;
  const Eigen::Index extra = rows.cols() - parameters.rows();
  if (extra == 0) return all;
  const MatrixX others = rows.rightCols(extra);
  return all - others * ColumnPivotingQr(others).solve(all);
}

}  // namespace

struct GoalResidual::Implementation {
  virtual ~Implementation() = default;
  /// Stacked rows in natural units, and per term what one SI unit of it counts there.
  using RowsCallback = std::function<void(const MatrixX& rows, const VectorX& per_unit)>;
  virtual bool collect(const Mechanism& mechanism, const RowsCallback& use) = 0;
  virtual VectorX values(const Mechanism& mechanism) const = 0;
};

namespace {

template <class S>
class ResidualSamples : public GoalResidual::Implementation {
 public:
  ResidualSamples(const Mechanism& mechanism, const Conditions& conditions, const ConditionOptions& options)
      : options_(options),
        goals_(conditions.goals),
        tree_(compile_tree<S>(mechanism, mechanism.actuators)),
        units_(mechanism, conditions.parameters),
        counts_(VectorX::Ones(conditions.matrix.cols())) {
    // what no parameter can balance stays as it is and would only hide what is left of the rest
    for (Eigen::Index k = 0; k < conditions.known_term_values.size(); ++k) {
      const Eigen::Index column = conditions.parameter_columns() + k;
      if (!conditions.is_variable_term(k) && conditions.matrix.col(column).head(conditions.parameter_rows()).isZero(0))
        counts_[column] = 0;
    }
    ConfigurationSampler<S> sampler(mechanism, tree_, options.seed);
    UniformRandom random(options.seed + 1);
    SampledConfiguration configuration;
    const int wanted = conditions.samples + 4;
    const bool loops = tree_.closure_rows > 0;
    SampledConfiguration first;
    for (int tries = 0; static_cast<int>(stations_.size()) < wanted && tries < 20 * wanted; ++tries) {
      // where loops must close with other numbers too, all configurations are near one
      if ((!loops || tries == 0) && !sampler.next(first)) break;
      freedoms_ = sampler.freedoms();
      configuration = first;
      if (loops && tries > 0 && !sample_near(first, random, configuration)) continue;
      stations_.push_back({configuration.y, random.normal(tree_.columns)});
      MatrixX rows;
      if (!rows_at(mechanism, tree_, {stations_.back()}, rows)) stations_.pop_back();
    }
    if (stations_.empty()) throw std::invalid_argument("no configuration of the mechanism was found");
  }

  bool collect(const Mechanism& mechanism, const RowsCallback& use) override {
    Tree<S> tree = compile_tree<S>(mechanism, mechanism.actuators);
    if (tree.columns != tree_.columns || tree.closure_rows != tree_.closure_rows) return false;
    for (const NodeId spherical : tree_.spherical_joints)
      tree.nodes[static_cast<std::size_t>(spherical)].R_PF = tree_.nodes[static_cast<std::size_t>(spherical)].R_PF;
    MatrixX rows;
    if (!rows_at(mechanism, tree, stations_, rows)) return false;
    use(rows, counts_.cwiseQuotient(units_.parameter) / units_.mass);
    return true;
  }

  VectorX values(const Mechanism& mechanism) const override { return term_values(mechanism, options_.loose_springs); }

 private:
  /// A configuration reached from another one in a single step of random length and direction: far enough away to tell
  /// mechanisms apart, not so far that with somewhat other lengths the loops would not close or close on the other side of a
  /// folded pose.
  bool sample_near(const SampledConfiguration& from, UniformRandom& random, SampledConfiguration& configuration) const {
    constexpr double max_sample_step = 0.6;
    ConstraintSystem<S> closures(tree_, Drive<S>{});
    const VectorX scale = column_scale(tree_);
    VectorX direction = from.null_space * random.normal(from.null_space.cols());
    direction.normalize();
    const double way = random.uniform(-max_sample_step, max_sample_step);
    const AssemblySolution moved = solve_assembly(closures, from.y + way * scale.cwiseProduct(direction), {}, 30);
    if (!moved.found) return false;
    const VectorX went = (moved.y - from.y).cwiseQuotient(scale);
    configuration.y = moved.y;
    return went.dot(direction) * (way < 0 ? -1 : 1) > 0.7 * went.norm() && went.norm() < 2 * std::abs(way);
  }

  bool rows_at(const Mechanism& mechanism, const Tree<S>& tree, const std::vector<ResidualSample>& stations,
               MatrixX& all) {
    GoalRows<S> goal_rows(mechanism, tree, units_, goals_, options_, freedoms_);
    ConstraintSystem<S> closures(tree, Drive<S>{});
    all.resize(0, goal_rows.parameters() + goal_rows.extra_unknowns());
    MatrixX rows;
    for (const ResidualSample& station : stations) {
      SampledConfiguration here;
      if (!project_onto_closures(closures, station.y, freedoms_, here)) return false;
      // projected instead of written in a basis, which would turn with the numbers
      const MatrixX allowed = here.null_space * here.null_space.transpose();
      if (!goal_rows.evaluate(here, {allowed, allowed * station.velocity_seed}, rows)) return false;
      all.conservativeResize(all.rows() + rows.rows(), Eigen::NoChange);
      all.bottomRows(rows.rows()) = rows;
    }
    return true;
  }

  ConditionOptions options_;
  std::vector<Goal> goals_;
  Tree<S> tree_;  ///< of the first mechanism, with the reference orientations of its spherical joints
  NaturalUnits units_;
  VectorX counts_;  ///< per term: 0 if it is known to stay whatever the parameters are
  int freedoms_ = 0;
  std::vector<ResidualSample> stations_;
};

}  // namespace

GoalResidual::GoalResidual(const Mechanism& mechanism, const std::vector<Goal>& goals,
                           const ConditionOptions& options) {
  const Conditions conditions = derive_conditions(mechanism, goals, options);
  if (conditions.status != ConditionsStatus::done) throw std::invalid_argument(conditions.reason);
  dispatch_space(mechanism.space, [&]<class S>(S) {
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
/// Of a condition's largest coefficient: how exactly the known ones must come out again, and how exactly others must hold at
/// all configurations. Coefficients are compared to seven digits.
constexpr double reproduction_tolerance = 1e-9, perturbed_row_tolerance = 1e-8;
/// Known ones that miss by so much more than round-off are not all: there are more, of another rank.
constexpr double rank_change_threshold = 1e-5;

/// What the stations tell of a changed mechanism.
enum class PerturbedRank { unchanged, changed, unknown };

}  // namespace

struct PerturbedConditions::Implementation {
  virtual ~Implementation() = default;
  virtual PerturbedRank solve_for_pivots(const Mechanism& mechanism, MatrixX& matrix) const = 0;
  Conditions known;
};

namespace {

template <class S>
class PerturbedRows : public PerturbedConditions::Implementation {
 public:
  PerturbedRows(const Mechanism& mechanism, const Conditions& conditions, const ConditionOptions& options)
      : options_(options), tree_(compile_tree<S>(mechanism, mechanism.actuators)) {
    known.goals = conditions.goals;
    known.parameters = conditions.parameters;
    known.known_term_values = conditions.known_term_values;
    known.pivots = conditions.pivots;
    known.rank = conditions.rank;
    if (conditions.matrix.rows() == 0) return;
    ConfigurationSampler<S> sampler(mechanism, tree_, options.seed);
    UniformRandom random(options.seed + 2);
    SampledConfiguration here;
    for (int wanted = min_perturbed_samples; wanted <= max_perturbed_samples; wanted *= 2) {
      while (static_cast<int>(y_.size()) < wanted) {
        if (!sampler.next(here)) return;
        freedoms_ = sampler.freedoms();
        y_.push_back(here.y);
        push_.push_back(random.normal(tree_.columns));
      }
      MatrixX again;
      useful_ = true;
      useful_ = PerturbedRows::solve_for_pivots(mechanism, again) == PerturbedRank::unchanged &&
                same(again, conditions.matrix);
      if (useful_) return;
    }
  }

  PerturbedRank solve_for_pivots(const Mechanism& mechanism, MatrixX& matrix) const override {
    if (!useful_) return PerturbedRank::unknown;
    Tree<S> tree = compile_tree<S>(mechanism, mechanism.actuators);
    if (tree.columns != tree_.columns || tree.closure_rows != tree_.closure_rows ||
        tree.spherical_joints != tree_.spherical_joints)
      return PerturbedRank::unknown;
    for (const NodeId spherical : tree_.spherical_joints)
      tree.nodes[static_cast<std::size_t>(spherical)].R_PF = tree_.nodes[static_cast<std::size_t>(spherical)].R_PF;
    const NaturalUnits units(mechanism, known.parameters);
    MatrixX rows;
    return stack(mechanism, tree, units, rows) ? solve(rows, units, matrix) : PerturbedRank::unknown;
  }

 private:
  bool stack(const Mechanism& mechanism, const Tree<S>& tree, const NaturalUnits& units, MatrixX& all) const {
    GoalRows<S> goal_rows(mechanism, tree, units, known.goals, options_, freedoms_);
    if (!goal_rows.mismatch_reason().empty()) return false;
    ConstraintSystem<S> closures(tree, Drive<S>{});
    std::vector<MatrixX> blocks;
    Eigen::Index count = 0;
    for (std::size_t k = 0; k < y_.size(); ++k) {
      SampledConfiguration here;
      MatrixX rows;
      if (!project_onto_closures(closures, y_[k], freedoms_, here)) return false;
      const VectorX velocity = here.null_space * (here.null_space.transpose() * push_[k]);
      if (!goal_rows.evaluate(here, {here.null_space, velocity}, rows)) continue;  // not held well there
      count += rows.rows();
      blocks.push_back(std::move(rows));
    }
    all.resize(count, goal_rows.parameters() + goal_rows.extra_unknowns());
    Eigen::Index at = 0;
    for (const MatrixX& block : blocks) {
      all.middleRows(at, block.rows()) = block;
      at += block.rows();
    }
    return true;
  }

  /// rows = X R with R the identity at the pivots, so that X is what the rows are there.
  PerturbedRank solve(const MatrixX& rows, const NaturalUnits& units, MatrixX& matrix) const {
    const MatrixX own = eliminate_extra_unknowns(rows, static_cast<int>(units.parameter.size()));
    const auto rank = static_cast<Eigen::Index>(known.pivots.size());
    if (own.rows() <= rank) return PerturbedRank::unknown;
    const MatrixX X = own(Eigen::all, known.pivots);
    const ColumnPivotingQr qr(X);
    const auto diagonal = qr.matrixQR().diagonal().cwiseAbs();
    if (!(min_coefficient(diagonal) > reproduction_tolerance * max_coefficient(diagonal)))
      return PerturbedRank::unknown;
    MatrixX R = qr.solve(own);
    const double missed = max_abs(own - X * R) / max_abs(own);
    if (!(missed < perturbed_row_tolerance))
      return missed > rank_change_threshold ? PerturbedRank::changed : PerturbedRank::unknown;
    for (Eigen::Index r = 0; r < rank; ++r) round_row(R, r);
    VectorX pivot_units(rank);
    for (Eigen::Index r = 0; r < rank; ++r) pivot_units[r] = units.parameter[known.pivots[static_cast<std::size_t>(r)]];
    matrix = pivot_units.asDiagonal() * R * units.parameter.cwiseInverse().asDiagonal();
    return PerturbedRank::unchanged;
  }

  void round_row(MatrixX& R, Eigen::Index row) const {
    const double largest = max_abs(R.row(row));
    R.row(row) = (R.row(row).array().abs() < 0.1 * reproduction_tolerance * largest).select(0.0, R.row(row));
    for (std::size_t r = 0; r < known.pivots.size(); ++r)
      R(row, known.pivots[r]) = static_cast<Eigen::Index>(r) == row ? 1 : 0;
  }

  static bool same(const MatrixX& one, const MatrixX& other) {
    for (Eigen::Index row = 0; row < other.rows(); ++row)
      if (!(max_abs(one.row(row) - other.row(row)) < reproduction_tolerance * max_abs(other.row(row)))) return false;
    return true;
  }

  ConditionOptions options_;
  Tree<S> tree_;  ///< of the known mechanism, with the reference orientations of its spherical joints
  int freedoms_ = 0;
  bool useful_ = false;
  std::vector<VectorX> y_, push_;
};

}  // namespace

PerturbedConditions::PerturbedConditions(const Mechanism& mechanism, const Conditions& conditions,
                                         const ConditionOptions& options) {
  dispatch_space(mechanism.space, [&]<class S>(S) {
    implementation_ = std::make_unique<PerturbedRows<S>>(mechanism, conditions, options);
  });
}

PerturbedConditions::~PerturbedConditions() = default;
PerturbedConditions::PerturbedConditions(PerturbedConditions&&) noexcept = default;
PerturbedConditions& PerturbedConditions::operator=(PerturbedConditions&&) noexcept = default;

std::optional<Conditions> PerturbedConditions::derive(const Mechanism& mechanism) const {
  Conditions found = implementation_->known;
  const PerturbedRank rank = implementation_->solve_for_pivots(mechanism, found.matrix);
  if (rank == PerturbedRank::unknown) return std::nullopt;
  found.status = rank == PerturbedRank::unchanged ? ConditionsStatus::done : ConditionsStatus::rank_unclear;
  return found;
}

std::function<Conditions(const Mechanism&)> make_perturbed_derivation(
    const std::function<Conditions(const Mechanism&)>& derive,
    const std::function<Mechanism(const Mechanism&)>& prepare, const Mechanism& mechanism, const Conditions& conditions,
    const ConditionOptions& options) {
  // shared because a std::function must be copyable; there is one owner in fact
  const auto nearby = std::make_shared<PerturbedConditions>(prepare(mechanism), conditions, options);
  return [=](const Mechanism& other) {
    std::optional<Conditions> found = nearby->derive(prepare(other));
    return found ? *std::move(found) : derive(other);
  };
}

}  // namespace balance
