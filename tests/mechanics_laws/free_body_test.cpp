// Every body taken by itself: what acts on it gives it its acceleration.

#include "runs.hpp"

#include "balance/foundation/base/rotation.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

using namespace laws;

namespace {

constexpr double relative_tolerance = 3e-5;  // accelerations by differences, as in momentum_test.cpp

/// Largest reaction, weight and inertia force of the run [N].
double scale_of(const Run& run, const Cloud& points) {
  double scale = force_scale(run, points);
  for (const double m : points.mass) scale += m * run.mechanism.gravity.norm();
  return std::max(scale, run.result.joint_force.cwiseAbs().maxCoeff());
}

}  // namespace

TEST_CASE("joints, springs, loads and weight give every body the rate of its momentum") {
  for_each_run(401, [](const Run& run) {
    const Cloud points = cloud(run);
    const double scale = scale_of(run, points);
    Worst force, moment;
    for (long k = 0; k < run.samples(); ++k) {
      if (!run.smooth[k]) continue;
      const auto rates = momentum_rates(run, points, k), weight = weights(run, points, k), load = loads(run, k),
                 spring = springs(run, k), joint = reactions(run, k), keeper = keepers(run, k);
      for (std::size_t b = 1; b < run.mechanism.bodies.size(); ++b) {
        const Vector3 f =
            joint[b].force + keeper[b].force + spring[b].force + load[b].force + weight[b].force - rates[b].force;
        const Vector3 m =
            joint[b].moment + keeper[b].moment + spring[b].moment + load[b].moment + weight[b].moment - rates[b].moment;
        force.see((run.result.axes == 2 ? Vector3(f.x(), f.y(), 0) : f).norm() / scale, k);
        moment.see((run.result.axes == 2 ? Vector3(0, 0, m.z()) : m).norm() / (scale * run.length()), k);
      }
    }
    CHECK_MESSAGE(force.error < relative_tolerance, run.name << " sample " << force.sample << ": " << force.error);
    CHECK_MESSAGE(moment.error < relative_tolerance, run.name << " sample " << moment.sample << ": " << moment.error);
  });
}

TEST_CASE("the ground's joints, springs and discs carry what the frame is said to feel") {
  for_each_run(101, [](const Run& run) {
    const Cloud points = cloud(run);
    const double scale = scale_of(run, points);
    const auto on_ground = [](const balance::Disc& disc) { return disc.body == balance::model::ground; };
    const bool discs = std::any_of(run.mechanism.discs.begin(), run.mechanism.discs.end(), on_ground);
    Worst force, moment;
    for (long k = 0; k < run.samples(); ++k) {
      if (discs && !run.smooth[k]) continue;
      Total felt = reactions(run, k)[balance::model::ground];
      for (const Total& other : {springs(run, k)[balance::model::ground], keepers(run, k)[balance::model::ground]})
        felt.force += other.force, felt.moment += other.moment;
      if (discs) {
        const Total weight = weights(run, points, k)[balance::model::ground],
                    rate = momentum_rates(run, points, k)[balance::model::ground];
        felt.force += weight.force - rate.force, felt.moment += weight.moment - rate.moment;
      }
      force.see((felt.force - run.row(run.result.ground_force, k)).norm() / scale, k);
      const Vector3 about = felt.moment - run.result.moment_reference.cross(felt.force);
      const Vector3 off = about - run.moment(run.result.ground_moment, k);
      moment.see((run.result.axes == 2 ? std::abs(off.z()) : off.norm()) / (scale * run.length()), k);
    }
    const double allowed = discs ? relative_tolerance : 1e-9;
    CHECK_MESSAGE(force.error < allowed, run.name << " sample " << force.sample << ": " << force.error);
    CHECK_MESSAGE(moment.error < allowed, run.name << " sample " << moment.sample << ": " << moment.error);
  });
}

namespace {

struct Motion {
  Vector3 turn = Vector3::Zero(),
          slide = Vector3::Zero();  ///< of the second body per unit of the coordinate, world axes
};

Motion unit_motion(const Run& run, long k, const balance::Joint& joint, int index, const double* q) {
  using balance::JointType;
  const Matrix3& R = run.poses[k][joint.first].R;
  const bool planar = run.result.axes == 2;
  const Vector3 u = R * joint.axis, v = R * joint.axis2, z = planar ? Vector3(0, 0, 1) : u;
  switch (joint.type) {
    case JointType::revolute: return {z, {0, 0, 0}};
    case JointType::prismatic: return {{0, 0, 0}, u};
    case JointType::pin_slot: return index == 0 ? Motion{{0, 0, 0}, u} : Motion{Vector3::UnitZ(), {0, 0, 0}};
    case JointType::cylindrical: return index == 0 ? Motion{u, {0, 0, 0}} : Motion{{0, 0, 0}, u};
    case JointType::universal:
      return {index == 0 ? u : Vector3(R * balance::rotation_about(joint.axis, q[0]) * joint.axis2), {0, 0, 0}};
    case JointType::planar:
      return index == 2 ? Motion{u, {0, 0, 0}} : Motion{{0, 0, 0}, index == 0 ? v : Vector3(u.cross(v))};
    case JointType::free:
      if (index < 3) return {{0, 0, 0}, R.col(index)};
      index -= 3, q += 3;
      [[fallthrough]];
    case JointType::spherical: {
      Matrix3 turned = R;
      if (index > 0) turned = turned * balance::rotation_about(Vector3::UnitX(), q[0]);
      if (index > 1) turned = turned * balance::rotation_about(Vector3::UnitY(), q[1]);
      return {turned.col(index), {0, 0, 0}};
    }
    case JointType::rolling_disc:  // no direction of theirs is free of force
    case JointType::rolling_sphere:
    case JointType::fixed: break;
  }
  return {};
}

/// Coordinates that gears or discs act on besides motors.
std::set<int> geared(const Mechanism& mechanism) {
  std::set<int> out;
  for (const balance::Coupling& coupling : mechanism.couplings)
    for (out.insert(coupling.follower); const balance::model::CoordinateTerm& term : coupling.leader.terms)
      out.insert(term.coordinate);
  for (const balance::Disc& disc : mechanism.discs)
    for (const balance::model::CoordinateTerm& term : disc.follows.terms) out.insert(term.coordinate);
  return out;
}

}  // namespace

TEST_CASE(
    "along its free motion a joint passes on what its motor supplies less springs in it and friction, and else "
    "nothing") {
  for_each_run(101, [](const Run& run) {
    const Mechanism& m = run.mechanism;
    const std::set<int> skipped = geared(m);
    const double scale = scale_of(run, cloud(run));
    Worst worst;
    for (long k = 0; k < run.samples(); ++k) {
      const VectorX q = run.result.joint_position.row(k).transpose();
      for (int c = 0; c < static_cast<int>(m.coordinates.size()); ++c) {
        const balance::Coordinate& coordinate = m.coordinates[c];
        if (skipped.count(c) || balance::model::is_rolling(m.joints[coordinate.joint].type)) continue;
        const Motion unit =
            unit_motion(run, k, m.joints[coordinate.joint], coordinate.index, q.data() + c - coordinate.index);
        double passed = run.row(run.result.joint_force, k, coordinate.joint).dot(unit.slide) +
                        run.moment(run.result.joint_moment, k, coordinate.joint).dot(unit.turn);
        for (std::size_t a = 0; a < m.actuators.size(); ++a)
          if (m.actuators[a] == c) passed -= run.result.torque(k, static_cast<long>(a));
        for (const balance::Spring& spring : m.springs)
          if (spring.coordinate == c) passed += spring.stiffness * q[c] - spring.preload;
        for (const balance::ForceElement& element : m.force_elements)
          if (element.coordinate == c) passed -= balance::model::ForceLawOf<double>(element.table).force(q[c]);
        for (const balance::Friction& friction : m.friction) {
          const double rate = run.result.joint_velocity(k, friction.coordinate);
          if (friction.coordinate != c) continue;
          const double fastest = run.result.joint_velocity.row(k).cwiseAbs().maxCoeff();
          const bool rests = std::abs(rate) <= 1e-10 * std::max(fastest, 1 / run.result.time[run.samples() - 1]);
          passed +=
              friction.viscous * rate + (rests ? 0 : std::copysign(friction.dry_friction(rate < 0 ? -1 : 1), rate));
        }
        const bool angle = coordinate.kind == balance::CoordinateKind::angle;
        worst.see(std::abs(passed) / (scale * (angle ? run.length() : 1)), k);
      }
    }
    CHECK_MESSAGE(worst.error < 1e-9, run.name << " sample " << worst.sample << ": " << worst.error);
  });
}
