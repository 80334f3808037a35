#include "balance/conditions/proportion.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/conditions/rows.hpp"

namespace balance {

namespace {

constexpr int samples = 24;

template <class S>
MatrixX fit(const Mechanism& mechanism, const ConditionOptions& options) {
  const std::vector<Parameter> parameters = list_parameters(mechanism, options.loose_springs);
  const NaturalUnits units(mechanism, parameters);
  Tree<S> tree = compile<S>(mechanism, mechanism.actuators);
  Sampler<S> sampler(mechanism, tree, options.seed);
  Configuration here;
  if (!sampler.next(here)) return {};
  GoalRows<S> goal_rows(mechanism, tree, units, {{GoalKind::proportional}}, options, sampler.freedoms());
  if (!goal_rows.mismatch().empty()) return {};
  MatrixX all(0, goal_rows.parameters() + goal_rows.extra()), rows;
  for (int k = 0; k < samples; ++k) {
    goal_rows.at(here, {here.null_space, VectorX::Zero(tree.columns)}, rows);
    all.conservativeResize(all.rows() + rows.rows(), Eigen::NoChange);
    all.bottomRows(rows.rows()) = rows;
    if (!sampler.next(here)) break;
  }
  // momentum − B · tool velocity = 0 with B = mass · A, row by row
  const VectorX momentum = all.leftCols(goal_rows.parameters()) *
                           parameter_values(mechanism, options.loose_springs).cwiseQuotient(units.parameter);
  const VectorX B = all.rightCols(goal_rows.extra()).colPivHouseholderQr().solve(-momentum);
  return Eigen::Map<const Samples>(B.data(), S::dimension, S::dimension) / tree.mass;
}

}  // namespace

MatrixX com_per_tool(const Mechanism& mechanism, const ConditionOptions& options) {
  if (!mechanism.tool) return {};
  return mechanism.space == SpaceKind::planar ? fit<Planar>(mechanism, options) : fit<Spatial>(mechanism, options);
}

}  // namespace balance
