#include "balance/synthesis/conditions/com_tool_map.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"

namespace balance {

namespace {

constexpr int com_fit_samples = 24;

template <class S>
ComToolMap fit_in_space(const Mechanism& mechanism, GoalKind kind, const ConditionOptions& options) {
  const std::vector<Parameter> parameters = list_terms(mechanism, options.loose_springs);
  const NaturalUnits units(mechanism, parameters);
  Tree<S> tree = compile_tree<S>(mechanism, mechanism.actuators);
  ConfigurationSampler<S> sampler(mechanism, tree, options.seed);
  SampledConfiguration here;
  if (!sampler.next(here)) return {};
  GoalRows<S> goal_rows(mechanism, tree, units, {{kind}}, options, sampler.freedoms());
  if (!goal_rows.mismatch_reason().empty()) return {};
  MatrixX all(0, goal_rows.parameters() + goal_rows.extra_unknowns()), rows;
  for (int k = 0; k < com_fit_samples; ++k) {
    goal_rows.evaluate(here, {here.null_space, VectorX::Zero(tree.columns)}, rows);
    all.conservativeResize(all.rows() + rows.rows(), Eigen::NoChange);
    all.bottomRows(rows.rows()) = rows;
    if (!sampler.next(here)) break;
  }
  // momentum − X · (tool velocity, rates of axes) = 0 with X = mass · (A, B), row by row
  const VectorX momentum = all.leftCols(goal_rows.parameters()) *
                           term_values(mechanism, options.loose_springs).cwiseQuotient(units.parameter);
  CompleteOrthogonalDecomposition least;  // of a body that does not turn B is nothing
  least.setThreshold(1e-9);
  const VectorX X = least.compute(all.rightCols(goal_rows.extra_unknowns())).solve(-momentum);
  const Eigen::Index d = S::dimension, width = X.size() / d;
  const MatrixX both = Eigen::Map<const Samples>(X.data(), d, width) / tree.mass;
  return {both.leftCols(d), width > d ? MatrixX(units.length * both.rightCols(width - d)) : MatrixX::Zero(d, d)};
}

}  // namespace

ComToolMap fit_com_tool_map(const Mechanism& mechanism, GoalKind kind, const ConditionOptions& options) {
  if (!mechanism.tool) return {};
  return dispatch_space(mechanism.space, [&]<class S>(S) { return fit_in_space<S>(mechanism, kind, options); });
}

MatrixX fit_com_tool_matrix(const Mechanism& mechanism, const ConditionOptions& options) {
  return fit_com_tool_map(mechanism, GoalKind::proportional, options).A;
}

}  // namespace balance
