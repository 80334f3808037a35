#include "balance/control/singularity_watch.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/motion/wording.hpp"

namespace balance {

SingularityWatch::SingularityWatch(const Mechanism& mechanism)
    : dynamics_(mechanism, {.preferred = mechanism.actuators}) {}

MotionOutcome SingularityWatch::look(double time, const VectorX& position, const VectorX& velocity) {
  const MotionOutcome outcome = dynamics_.set(time, position, velocity);
  if (outcome.status != MotionStatus::done) return outcome;
  const TreeEquation equation = dynamics_.tree_equation();
  const Eigen::Index n = equation.jacobian.cols();
  if (equation.jacobian.rows() + equation.input.cols() != n) return outcome;
  MatrixX together(n, n);
  together << equation.jacobian, equation.input.transpose();
  const double determinant = Eigen::PartialPivLU<MatrixX>(together).determinant();
  const int sign = determinant > 0 ? 1 : determinant < 0 ? -1 : 0;
  const bool passed = sign == 0 || (sign_ != 0 && sign != sign_);
  sign_ = sign;
  if (!passed) return outcome;
  return {MotionStatus::actuation_singularity,
          time,
          at_time(time) +
              "actuation singularity: the mechanism reached a configuration in which the actuators do not determine "
              "its motion",
          {}};
}

}  // namespace balance
