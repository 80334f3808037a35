// The same states, found along a trajectory and one by one.

#include "every_config.hpp"

#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <string_view>

namespace trajectory_test {

namespace {

using namespace balance;
using namespace balance::dynamics;

/// Columns of the independent coordinates.
std::vector<Eigen::Index> columns(const InverseDynamics& door) {
  std::vector<Eigen::Index> found;
  for (const std::string& name : door.independent())
    for (std::size_t c = 0; c < door.mechanism().coordinates.size(); ++c)
      if (door.mechanism().coordinates[c].name == name) found.push_back(static_cast<Eigen::Index>(c));
  return found;
}

Samples taken(const Samples& all, const std::vector<Eigen::Index>& columns) {
  Samples some(all.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) some.col(static_cast<Eigen::Index>(k)) = all.col(columns[k]);
  return some;
}

/// Of the terms that a quantity is the sum of: both ways solve the loops to 1e-12 of the length, and rates and forces grow near
/// singularities.
constexpr double tolerance = 1e-9;

/// How large a quantity is, or what it is the sum of where that cancels.
double size_of(const Quantity& quantity, const RunResult& run) {
  double size = quantity.samples->cwiseAbs().maxCoeff();
  for (const results::QuantityDefinition& kind : results::quantity_table())
    if (quantity.name == kind.name && kind.terms != nullptr && (run.term_magnitudes.*kind.terms).size() > 0)
      size = std::max(size, (run.term_magnitudes.*kind.terms).maxCoeff());
  return size;
}

void compare(const Mechanism& mechanism, const Trajectory& trajectory) {
  const RunResult run = simulate(mechanism, trajectory);
  if (run.outcome.status != MotionStatus::done) return;
  InverseDynamics door(mechanism, {.independent = {}, .about = trajectory.about, .time_scale = trajectory.duration});
  const std::vector<Eigen::Index> own = columns(door);
  std::vector<CoordinateGuess> near;
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    near.push_back({mechanism.coordinates[c].name, run.joint_position(0, static_cast<Eigen::Index>(c))});
  const Samples q = taken(run.joint_position, own), dq = taken(run.joint_velocity, own),
                ddq = taken(run.joint_acceleration, own);
  const auto start = door.assemble(q.row(0).transpose(), near);
  REQUIRE_MESSAGE(start, start.outcome.reason);
  const SampleBatch found = door.at_rows(q, dq, ddq, run.time);
  for (const FailedRow& failed : found.failures) FAIL_CHECK(failed.row, ": ", failed.outcome.reason);
  for (const Quantity& quantity : list_sampled_quantities(run)) {
    if (quantity.name == "mobility") continue;  // of another drive
    const Samples &expected = *quantity.samples, &got = found.result.*quantity.member;
    REQUIRE(got.cols() == expected.cols());
    CAPTURE(quantity.name);
    CHECK((got - expected).cwiseAbs().maxCoeff() <= tolerance * size_of(quantity, run));
  }
  const EffortBatch efforts = door.effort_rows(q, dq, ddq, run.time);
  CHECK(efforts.failures.empty());
  CHECK((efforts.efforts - found.result.torque).cwiseAbs().maxCoeff() <=
        1e-14 * (run.torque.cwiseAbs().maxCoeff() + run.term_magnitudes.effort.maxCoeff()));
}

}  // namespace

TEST_CASE("states taken from a trajectory have the trajectory's results, one by one") {
  for (const std::string& file : doors::every_config()) {
    const balance::Study study = balance::read_spec_file(file);
    if (has_velocity_constraints(study.mechanism)) {  // whose configuration no state tells
      CHECK_THROWS_AS(InverseDynamics(study.mechanism), std::invalid_argument);
      continue;
    }
    for (balance::Trajectory trajectory : study.trajectories) {
      CAPTURE(file);
      CAPTURE(trajectory.name);
      trajectory.samples = 201;
      compare(study.mechanism, trajectory);
    }
  }
}

}  // namespace trajectory_test
