#include "balance/conditions/conditions.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/conditions/reduce.hpp"
#include "balance/conditions/rows.hpp"

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
  /// @param use is shown the stacked rows in natural units, and per term what one SI unit of it counts there
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

}  // namespace balance
