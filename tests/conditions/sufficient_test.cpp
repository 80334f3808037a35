/// Masses that meet the conditions, whatever else they are, balance the mechanism; masses that miss one do not. Judged by
/// simulation, which knows nothing of conditions.

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/conditions/com_tool_map.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <doctest/doctest.h>

#include <random>

namespace sufficient_test {

using namespace balance;
using namespace balance::conditions;
using namespace balance::dynamics;

namespace {

Study load(const std::string& file) { return read_spec_file(std::string(BALANCE_CONFIGS "/") + file); }

/// Bodies with these parameters: they need not be physical for forces to follow from them.
Mechanism with_parameters(Mechanism mechanism, const std::vector<Parameter>& parameters, const VectorX& values) {
  const bool planar = mechanism.space == SpaceKind::planar;
  const int width = planar ? 4 : 10;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].owner_kind != ParameterOwner::body || parameters[p].slot != 0) continue;
    Body& body = mechanism.bodies[static_cast<std::size_t>(parameters[p].index)];
    const VectorX v = values.segment(static_cast<Eigen::Index>(p), width);
    body.mass = v[0];
    if (v[0] == 0) continue;  // what must not be there has no centre of mass
    body.com = planar ? Vector3(v[1], v[2], 0) / v[0] : Vector3(v.segment<3>(1) / v[0]);
    Matrix3 about_origin = Matrix3::Zero();
    if (planar)
      about_origin(2, 2) = v[3];
    else
      about_origin << v[4], v[7], v[8], v[7], v[5], v[9], v[8], v[9], v[6];
    const Matrix3 shift = v[0] * (body.com.squaredNorm() * Matrix3::Identity() - body.com * body.com.transpose());
    body.inertia = about_origin - shift;
    if (planar) body.inertia = Vector3(0, 0, body.inertia(2, 2)).asDiagonal();
  }
  return mechanism;
}

/// The bodies' parameters nearest to random ones that meet all conditions; what bodies carry stays as it is.
VectorX balanced(const Conditions& conditions, const VectorX& present, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> factor(0.5, 1.5);
  VectorX values = present;
  std::vector<Eigen::Index> bodies;
  for (std::size_t p = 0; p < conditions.parameters.size(); ++p)
    if (conditions.parameters[p].owner_kind == ParameterOwner::body) bodies.push_back(static_cast<Eigen::Index>(p));
  MatrixX own(conditions.rank, static_cast<Eigen::Index>(bodies.size()));
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    values[bodies[b]] = factor(random) * (std::abs(present[bodies[b]]) + 1e-3);
    own.col(static_cast<Eigen::Index>(b)) = conditions.matrix.col(bodies[b]);
  }
  const VectorX change = own.completeOrthogonalDecomposition().solve(conditions.matrix * values);
  for (std::size_t b = 0; b < bodies.size(); ++b) values[bodies[b]] -= change[static_cast<Eigen::Index>(b)];
  return values;
}

/// Motions that masses cannot change.
std::vector<Trajectory> motions(const Study& study) {
  std::vector<Trajectory> all;
  for (Trajectory trajectory : study.trajectories) {
    if (trajectory.drive == DriveKind::com) continue;
    trajectory.samples = 60;
    all.push_back(std::move(trajectory));
  }
  return all;
}

/// What the goal wants to vanish, largest over the run.
double shaken(const RunResult& result, GoalKind goal) {
  REQUIRE(result.outcome.status == MotionStatus::done);
  double size = 0;
  if (goal == GoalKind::statics) size = result.torque.cwiseAbs().maxCoeff();
  if (goal == GoalKind::force || goal == GoalKind::dynamic) size = result.shaking_force.cwiseAbs().maxCoeff();
  if (goal == GoalKind::moment || goal == GoalKind::dynamic)
    size = std::max(size, result.shaking_moment.cwiseAbs().maxCoeff());
  return size;
}

double shaken(const Mechanism& mechanism, std::vector<Trajectory> trajectories, GoalKind goal) {
  double size = 0;
  for (Trajectory& trajectory : trajectories) {
    if (goal == GoalKind::statics) trajectory.duration = 1e6;  // so slow that only weight is felt
    trajectory.about.setZero();
    size = std::max(size, shaken(simulate(mechanism, trajectory), goal));
  }
  return size;
}

void check_sufficient_and_necessary(const std::string& file, GoalKind goal) {
  CAPTURE(file);
  CAPTURE(study::goal_name({goal}));
  const Study study = load(file);
  const Conditions conditions = derive_conditions(study.mechanism, {{goal}});
  REQUIRE(conditions.status == ConditionsStatus::done);
  const std::vector<Trajectory> trajectories = motions(study);
  REQUIRE(!trajectories.empty());
  const VectorX present = parameter_values(study.mechanism);
  const VectorX values = balanced(conditions, present, 7);
  const Mechanism good = with_parameters(study.mechanism, conditions.parameters, values);
  REQUIRE(scaled_residuals(conditions, parameter_values(good)).cwiseAbs().maxCoeff() < 1e-13);

  // The size of the terms that cancel; 1e-10 of it leaves three digits for condition numbers of the loops.
  const double weight = total_mass(study.mechanism) * study.mechanism.gravity.norm();
  const double scale = goal == GoalKind::statics ? weight * characteristic_length(study.mechanism)
                                                 : shaken(study.mechanism, trajectories, goal);
  REQUIRE(scale > 0);
  CHECK(shaken(good, trajectories, goal) < 1e-10 * scale);

  for (Eigen::Index row = 0; row < conditions.rank; ++row) {
    const std::size_t pivot = static_cast<std::size_t>(conditions.pivots[static_cast<std::size_t>(row)]);
    if (conditions.parameters[pivot].owner_kind != ParameterOwner::body) continue;
    VectorX missed = values;
    missed[static_cast<Eigen::Index>(pivot)] += 0.1 * conditions.row_scales[row];
    const Mechanism bad = with_parameters(study.mechanism, conditions.parameters, missed);
    CAPTURE(conditions.parameters[pivot].name);
    CHECK(shaken(bad, trajectories, goal) > 1e-6 * scale);
  }
}

}  // namespace

TEST_CASE("without the static conditions' weights the actuators of planar mechanisms hold nothing") {
  for (const char* file : {"planar-rrr.yaml", "5r.yaml", "rr.yaml", "double-pendulum.yaml"})
    check_sufficient_and_necessary(file, GoalKind::statics);
}

TEST_CASE("the static conditions are necessary and sufficient in space") {
  for (const char* file : {"spatial-rrr.yaml", "scara.yaml", "delta.yaml"})
    check_sufficient_and_necessary(file, GoalKind::statics);
}

TEST_CASE("the force conditions are necessary and sufficient for a shaking force of zero") {
  for (const char* file :
       {"3rrr.yaml", "5r.yaml", "four-bar.yaml", "slider-crank.yaml", "geared-five-bar.yaml", "watt-six-bar.yaml",
        "whitworth.yaml", "parallelogram.yaml", "spatial-rrr.yaml", "delta.yaml", "stewart.yaml"})
    check_sufficient_and_necessary(file, GoalKind::force);
}

TEST_CASE("the moment conditions are necessary and sufficient for a shaking moment of zero") {
  for (const char* file : {"3rrr.yaml", "5r.yaml", "four-bar.yaml", "slider-crank.yaml", "rr.yaml"})
    check_sufficient_and_necessary(file, GoalKind::moment);
}

TEST_CASE("the dynamic conditions are necessary and sufficient for neither force nor moment") {
  for (const char* file : {"3rrr.yaml", "5r.yaml", "four-bar.yaml", "slider-crank.yaml", "spatial-rrr.yaml"})
    check_sufficient_and_necessary(file, GoalKind::dynamic);
}

TEST_CASE("masses that meet the proportional conditions make the centre of mass follow the tool") {
  const Study study = load("3rrr.yaml");
  const Conditions conditions = derive_conditions(study.mechanism, {{GoalKind::proportional}});
  REQUIRE(conditions.status == ConditionsStatus::done);
  const VectorX values = balanced(conditions, parameter_values(study.mechanism), 3);
  const Mechanism good = with_parameters(study.mechanism, conditions.parameters, values);
  const MatrixX A = fit_com_tool_matrix(good);
  for (const Trajectory& trajectory : motions(study)) {
    const RunResult result = simulate(good, trajectory);
    REQUIRE(result.outcome.status == MotionStatus::done);
    const Samples com = result.com_position.rowwise() - result.com_position.row(0);
    const Samples tool = result.tool_position.rowwise() - result.tool_position.row(0);
    CHECK((com - tool * A.transpose()).cwiseAbs().maxCoeff() < 1e-12);  // round-off of positions in metres
  }
}

}  // namespace sufficient_test
