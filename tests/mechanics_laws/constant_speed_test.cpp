// What the conditions of a goal at constant speed or of single components promise, judged by simulation, which knows nothing of them.

#include "random_mechanism_classes.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace laws {

using namespace balance;
using namespace balance::dynamics;

namespace {

/// Bodies with these parameters: they need not be physical for forces to follow from them.
Mechanism with_bodies(Mechanism m, const std::vector<Parameter>& parameters, const VectorX& values) {
  const bool planar = m.space == SpaceKind::planar;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].owner_kind != ParameterOwner::body || parameters[p].slot != 0) continue;
    Body& body = m.bodies[static_cast<std::size_t>(parameters[p].index)];
    const VectorX v = values.segment(static_cast<Eigen::Index>(p), planar ? 4 : 10);
    body.mass = v[0];
    body.com.setZero();  // of what must not be there
    if (v[0] != 0) body.com = planar ? Vector3(v[1], v[2], 0) / v[0] : Vector3(v.segment<3>(1) / v[0]);
    Matrix3 about_origin = Matrix3::Zero();
    if (planar)
      about_origin(2, 2) = v[3];
    else
      about_origin << v[4], v[7], v[8], v[7], v[5], v[9], v[8], v[9], v[6];
    body.inertia =
        about_origin - v[0] * (body.com.squaredNorm() * Matrix3::Identity() - body.com * body.com.transpose());
    if (planar) body.inertia = Vector3(0, 0, body.inertia(2, 2)).asDiagonal();
  }
  return m;
}

/// The bodies' parameters nearest to random ones that meet the conditions; what bodies carry stays as it is. Empty if
/// bodies alone cannot meet them.
VectorX balanced(const Conditions& conditions, const VectorX& present, std::uint32_t seed) {
  std::mt19937 random(seed);
  VectorX values = present;
  std::vector<Eigen::Index> bodies;
  for (std::size_t p = 0; p < conditions.parameters.size(); ++p)
    if (conditions.parameters[p].owner_kind == ParameterOwner::body) bodies.push_back(static_cast<Eigen::Index>(p));
  for (const Eigen::Index p : bodies) values[p] *= 0.5 + random() * 0x1p-32;
  const MatrixX own = conditions.matrix(Eigen::all, bodies);
  const VectorX change = own.completeOrthogonalDecomposition().solve(conditions.matrix * values);
  for (std::size_t b = 0; b < bodies.size(); ++b) values[bodies[b]] -= change[static_cast<Eigen::Index>(b)];
  const bool is_met = conditions.rank == 0 || scaled_residuals(conditions, values).cwiseAbs().maxCoeff() < 1e-12;
  return is_met ? values : VectorX();
}

/// The largest of what a goal promises to vanish, in N: moments over the mechanism's length.
double shaken(const RunResult& run, const Goal& goal, double length) {
  double size = 0;
  const auto see = [&](const Samples& samples, double unit) {
    for (Eigen::Index i = 0; i < samples.cols(); ++i)
      if (goal.component < 0 || goal.component == static_cast<int>(i))
        size = std::max(size, samples.col(i).cwiseAbs().maxCoeff() / unit);
  };
  if (goal.kind != GoalKind::moment) see(run.shaking_force, 1);
  if (goal.kind != GoalKind::force) see(run.shaking_moment, length);
  return size;
}

/// Whether all rows of one matrix are combinations of the other's.
double distance_from_rows(const MatrixX& rows, const MatrixX& space) {
  if (rows.rows() == 0) return 0;
  if (space.rows() == 0) return 1;
  const MatrixX rest =
      rows - (space.transpose().completeOrthogonalDecomposition().solve(rows.transpose())).transpose() * space;
  return rest.cwiseAbs().maxCoeff() / rows.cwiseAbs().maxCoeff();
}

struct Count {
  int judged = 0, free = 0, refused = 0;
};

void judge_goal(const Member& member, const Goal& goal, std::uint32_t seed, Count& count) {
  CAPTURE(goal_name(goal));
  Mechanism mechanism = member.experiment.mechanism;
  Trajectory trajectory = member.experiment.trajectory;
  mechanism.actuators.resize(trajectory.from.joints.size());  // one of them may be redundant
  if (!goal.coordinates.empty() && mechanism.actuators.size() < 2) return;
  trajectory.drive = DriveKind::joints;
  trajectory.law = {};
  trajectory.law.kind = goal.is_at_constant_speed ? MotionLawKind::uniform : MotionLawKind::polynomial_345;
  trajectory.samples = 41;
  ConditionOptions options;
  options.about = trajectory.about;
  const Conditions conditions = derive_conditions(mechanism, {goal}, options);
  if (conditions.status == ConditionsStatus::rank_unclear) return;
  REQUIRE_MESSAGE(conditions.status == ConditionsStatus::done, conditions.reason);

  // a momentum that is zero does not change: the form asks for nothing that the goal itself does not
  const Goal whole{.kind = goal.kind};
  const Conditions of_whole = derive_conditions(mechanism, {whole}, options);
  REQUIRE(of_whole.status == ConditionsStatus::done);
  CHECK(conditions.rank <= of_whole.rank);
  CHECK(distance_from_rows(conditions.matrix, of_whole.matrix) < 1e-6);

  const VectorX values = balanced(conditions, conditions::term_values(mechanism, {}), seed);
  const RunResult before = simulate(mechanism, trajectory);
  if (before.outcome.status != MotionStatus::done || values.size() == 0) {
    ++count.refused;
    return;
  }
  const Mechanism after = with_bodies(mechanism, conditions.parameters, values);
  const bool is_representable =  // no first moment without a mass
      total_mass(after) > 0 &&
      (conditions.rank == 0 ||
       scaled_residuals(conditions, conditions::term_values(after, {})).cwiseAbs().maxCoeff() < 1e-10);
  if (!is_representable) {
    ++count.refused;
    return;
  }
  const RunResult run = simulate(after, trajectory);
  REQUIRE_MESSAGE(run.outcome.status == MotionStatus::done, run.outcome.reason);
  // Terms that cancel are larger where constant speeds leave the forces small; levers and inertia in unphysical bodies
  // take three digits more than in conditions that are met to 1e-12.
  const double length = characteristic_length(mechanism);
  const double scale = shaken(before, whole, length) + shaken(run, {.kind = GoalKind::dynamic}, length);
  CHECK(shaken(run, goal, length) < 1e-8 * scale);
  ++count.judged;
  if (conditions.rank < of_whole.rank) ++count.free;
}

}  // namespace

TEST_CASE(
    "random mechanisms that meet the conditions of a component, or at constant speed, have no such shaking force and "
    "moment") {
  constexpr std::uint32_t seeds = 6;
  for (const Kind kind : kinds) {
    Count count;
    const bool planar = kind == Kind::planar_tree || kind == Kind::planar_loop || kind == Kind::planar_loops;
    for (std::uint32_t seed = 1; seed <= seeds; ++seed) {
      CAPTURE(name_of(kind));
      CAPTURE(seed);
      const Member one = member(kind, seed);
      std::vector<Goal> goals{{.kind = GoalKind::force, .component = static_cast<int>(seed % 2)}};
      if (!planar) goals.push_back({.kind = GoalKind::moment, .component = static_cast<int>(seed % 3)});
      for (const GoalKind of : {GoalKind::force, GoalKind::moment, GoalKind::dynamic})
        goals.push_back({.kind = of, .is_at_constant_speed = true});
      goals.push_back({.kind = GoalKind::force, .is_at_constant_speed = true, .component = 1});
      for (const Goal& goal : goals) judge_goal(one, goal, seed, count);
    }
    // discs may ask for what bodies cannot give, and masses that must vanish have no centre of mass
    CHECK_MESSAGE(2 * count.judged > count.refused, name_of(kind));
    CHECK_MESSAGE(count.free > 0, name_of(kind));
  }
}

}  // namespace laws
