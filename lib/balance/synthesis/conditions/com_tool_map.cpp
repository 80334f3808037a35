#include "balance/synthesis/conditions/com_tool_map.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"

namespace balance::conditions {

namespace {

constexpr int com_fit_samples = 24;

template <class S>
ComToolMap fit_in_space(const Mechanism& mechanism, GoalKind kind, const ConditionOptions& options) {
  const std::vector<dynamics::Parameter> parameters = list_terms(mechanism, options.loose_springs);
  const NaturalUnits units(mechanism, parameters);
  kinematics::Tree<S> tree = kinematics::compile_tree<S>(mechanism, mechanism.actuators);
  ConfigurationSampler<S> sampler(mechanism, tree, options.seed);
  SampledConfiguration configuration;
  if (!sampler.next(configuration)) return {};
  GoalRows<S> goal_rows(mechanism, tree, units, {{kind}}, options, sampler.freedoms());
  if (!goal_rows.mismatch_reason().empty()) return {};
  MatrixX stacked_rows(0, goal_rows.parameters() + goal_rows.extra_unknowns()), rows;
  for (int k = 0; k < com_fit_samples; ++k) {
    goal_rows.evaluate(configuration, {configuration.null_space, VectorX::Zero(tree.columns)}, rows);
    stacked_rows.conservativeResize(stacked_rows.rows() + rows.rows(), Eigen::NoChange);
    stacked_rows.bottomRows(rows.rows()) = rows;
    if (!sampler.next(configuration)) break;
  }
  // momentum − X · (tool velocity, rates of axes) = 0 with X = mass · (A, B), row by row
  const VectorX momentum = stacked_rows.leftCols(goal_rows.parameters()) *
                           term_values(mechanism, options.loose_springs).cwiseQuotient(units.parameter);
  numerics::CompleteOrthogonalDecomposition solver;  // minimum norm: B = 0 if the body does not rotate
  solver.setThreshold(1e-9);
  const VectorX X = solver.compute(stacked_rows.rightCols(goal_rows.extra_unknowns())).solve(-momentum);
  const Eigen::Index d = S::dimension, width = X.size() / d;
  const MatrixX maps = Eigen::Map<const Samples>(X.data(), d, width) / tree.mass;
  return {maps.leftCols(d), width > d ? MatrixX(units.length * maps.rightCols(width - d)) : MatrixX::Zero(d, d)};
}

}  // namespace

ComToolMap fit_com_tool_map(const Mechanism& mechanism, GoalKind kind, const ConditionOptions& options) {
  if (!mechanism.tool) return {};
  return kinematics::dispatch_space(mechanism.space,
                                    [&]<class S>(S) { return fit_in_space<S>(mechanism, kind, options); });
}

MatrixX fit_com_tool_matrix(const Mechanism& mechanism, const ConditionOptions& options) {
  return fit_com_tool_map(mechanism, GoalKind::proportional, options).A;
}

}  // namespace balance::conditions
