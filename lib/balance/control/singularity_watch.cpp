#include "balance/control/singularity_watch.hpp"

#include "balance/motion/regularity.hpp"
#include "balance/motion/wording.hpp"

namespace balance {

ActuationMonitor::ActuationMonitor(const Mechanism& mechanism)
    : mechanism_(mechanism), dynamics_(mechanism, {.preferred = mechanism.actuators}) {}

/// Closures above actuated coordinates, lengths in characteristic ones: of full column rank where these determine the motion.
MatrixX ActuationMonitor::matrix() {
  const TreeEquation equation = dynamics_.tree_equation();
  const double length = characteristic_length(mechanism_);
  MatrixX out(equation.jacobian.rows() + equation.input.cols(), equation.jacobian.cols());
  out << equation.jacobian, equation.input.transpose();
  const std::vector<CoordinateId>& leaders = dynamics_.tree();
  for (std::size_t c = 0; c < leaders.size(); ++c)
    if (mechanism_.coordinates[static_cast<std::size_t>(leaders[c])].kind == CoordinateKind::length)
      out.col(static_cast<Eigen::Index>(c)) *= length;
  return out;
}

MotionOutcome ActuationMonitor::check(double time, const VectorX& position, const VectorX& velocity) {
  MotionOutcome outcome = dynamics_.set_state(time, position, velocity);
  if (outcome.status != MotionStatus::done) return outcome;
  if (static_cast<int>(mechanism_.actuators.size()) < dynamics_.freedoms()) return outcome;
  const bool regular = watched_.factorise(matrix()) > singular_pivot_threshold;
  const bool passed = has_previous_ && regular && watched_.loses_rank_since_stored();
  watched_.store();
  has_previous_ = true;
  if (regular && !passed) return outcome;
  return {MotionStatus::actuation_singularity,
          time,
          format_time_prefix(time) +
              "actuation singularity: the mechanism reached a configuration in which the actuators do not determine "
              "its motion",
          {}};
}

}  // namespace balance
