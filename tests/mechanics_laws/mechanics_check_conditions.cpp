#include "mechanics_check.hpp"

#include "finite_difference_state.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <random>

namespace laws {

using namespace balance;
using namespace balance::dynamics;

namespace {

/// The element's mass properties per unit of one of its parameters m, mx, my, … about its frame.
Mass unit_mass(const Parameter& parameter, bool planar) {
  Mass out;
  const std::string& symbol = parameter.symbol;
  const auto axis = [&](std::size_t i) { return symbol[i] - 'x'; };
  if (symbol == "m") out.m = 1;
  if (symbol.size() == 2 && symbol[0] == 'm') out.mc[axis(1)] = 1;
  if (symbol == "J") out.S.diagonal() << 0.5, 0.5, 0;
  if (symbol[0] != 'I') return out;
  Matrix3 I = Matrix3::Zero();
  I(axis(1), axis(2)) = I(axis(2), axis(1)) = 1;
  out.S = planar ? I : Matrix3(0.5 * I.trace() * Matrix3::Identity() - I);
  return out;
}

std::size_t element_of(const Parameter& parameter, const Mechanism& m) {
  const auto index = static_cast<std::size_t>(parameter.index);
  switch (parameter.owner_kind) {
    case ParameterOwner::body: return index - 1;
    case ParameterOwner::attachment: return m.bodies.size() - 1 + index;
    default: return m.bodies.size() - 1 + m.attachments.size() + index;
  }
}

/// Per parameter: linear and (about the world's origin) angular momentum at some moments of the run, unit lengths and masses.
MatrixX momenta(const Run& run, const std::vector<Parameter>& parameters, bool turning, int instants) {
  const bool planar = run.result.axes == 2;
  const std::vector<Element> parts = elements(run.mechanism);
  const int axes = planar ? 2 : 3, rows = axes + (turning ? planar ? 1 : 3 : 0);
  MatrixX out(instants * rows, parameters.size());
  for (int i = 0; i < instants; ++i) {
    const Instant now = instant(run, parts, (2 * i + 1) * (run.samples() - 1) / (2 * instants));
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      const Total unit =
          momentum(now.elements[element_of(parameters[p], run.mechanism)], unit_mass(parameters[p], planar));
      VectorX column(6);
      column << unit.force, (planar ? Vector3(unit.moment.z(), 0, 0) : unit.moment);
      out.col(static_cast<Eigen::Index>(p)).segment(i * rows, axes) = column.head(axes);
      if (turning)
        out.col(static_cast<Eigen::Index>(p)).segment(i * rows + axes, rows - axes) = column.segment(3, rows - axes);
    }
  }
  return out;
}

void judge_goal(const Run& run, GoalKind kind, int instants, Findings& findings) {
  const std::string goal = goal_name(Goal{kind, false});
  const Conditions conditions = derive_conditions(run.mechanism, {Goal{kind, false}});
  if (conditions.status == ConditionsStatus::rank_unclear) return;  // an answer, with its reason
  if (conditions.status != ConditionsStatus::done)
    return findings.say("no " + goal + " conditions: " + conditions.reason);
  std::vector<Parameter> inertial;
  std::vector<Eigen::Index> columns;
  for (std::size_t p = 0; p < static_cast<std::size_t>(conditions.parameter_columns()); ++p)
    if (conditions.parameters[p].owner_kind != ParameterOwner::spring)
      inertial.push_back(conditions.parameters[p]), columns.push_back(static_cast<Eigen::Index>(p));
  const MatrixX R = conditions.matrix(Eigen::all, columns);
  const MatrixX rows = momenta(run, inertial, kind == GoalKind::dynamic, instants);
  const double size = rows.cwiseAbs().maxCoeff();
  if (size == 0) return;
  // enough: parameters that meet the conditions have no momentum
  const Eigen::JacobiSVD<MatrixX> svd(R, Eigen::ComputeFullV);
  const MatrixX free = svd.matrixV().rightCols(R.cols() - conditions.rank);
  if (free.cols() > 0)
    findings.see("momentum where the " + goal + " conditions hold", (rows * free).cwiseAbs().maxCoeff() / size, 1e-7);
  // and never satisfied by less than this run shows
  const Eigen::JacobiSVD<MatrixX> seen(rows / size);
  int rank = 0;
  while (rank < seen.singularValues().size() && seen.singularValues()[rank] > 1e-6 * seen.singularValues()[0]) ++rank;
  if (rank > conditions.rank)
    findings.say(std::to_string(conditions.rank) + " " + goal + " conditions, but the run shows " +
                 std::to_string(rank));
}

}  // namespace

void judge_conditions(const Run& run, int instants, Findings& findings) {
  for (const GoalKind kind : {GoalKind::force, GoalKind::dynamic}) judge_goal(run, kind, instants, findings);
}

}  // namespace laws
