#include "balance/equations/run_states.hpp"

#include <stdexcept>

namespace balance {

StateTable extract_independent_states(const EquationTerms& terms, const RunResult& result) {
  if (result.joint_position.cols() != static_cast<Eigen::Index>(terms.mechanism().coordinates.size()))
    throw std::invalid_argument("the run has other coordinates than the mechanism");
  StateTable states;
  const auto d = static_cast<Eigen::Index>(terms.independent().size());
  for (Samples* all : {&states.q, &states.dq, &states.ddq}) all->resize(result.joint_position.rows(), d);
  for (Eigen::Index k = 0; k < d; ++k) {
    const int c = terms.independent()[static_cast<std::size_t>(k)];
    states.q.col(k) = result.joint_position.col(c);
    states.dq.col(k) = result.joint_velocity.col(c);
    states.ddq.col(k) = result.joint_acceleration.col(c);
  }
  return states;
}

MotionOutcome assemble_at_row(EquationTerms& terms, const RunResult& result, Eigen::Index row) {
  std::vector<CoordinateValue> near;
  for (Eigen::Index c = 0; c < result.joint_position.cols(); ++c)
    near.push_back({static_cast<int>(c), result.joint_position(row, c)});
  return terms.assemble(extract_independent_states(terms, result).q.row(row), near).outcome;
}

}  // namespace balance
