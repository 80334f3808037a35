#include "balance/conditions/nearby.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/conditions/reduce.hpp"
#include "balance/conditions/rows.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

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
  const PerturbedRank told = implementation_->solve_for_pivots(mechanism, found.matrix);
  if (told == PerturbedRank::unknown) return std::nullopt;
  found.status = told == PerturbedRank::unchanged ? ConditionsStatus::done : ConditionsStatus::rank_unclear;
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
