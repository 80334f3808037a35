// Nothing depends on where the ground lies, and units are a matter of taste.

#include "runs.hpp"
#include "transforms.hpp"

#include "balance/foundation/base/rotation.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <utility>

using namespace laws;

namespace {

/// Largest difference of two arrays, relative to the largest entry of either or to `least`.
double difference(const Samples& a, const Samples& b, double least) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return 1e300;
  if (a.size() == 0) return 0;
  const double scale = std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), least});
  const double worst = (a - b).cwiseAbs().maxCoeff() / scale;
  return a.allFinite() && b.allFinite() ? worst : 1e300;
}

/// Every vector of an array turned by R.
Samples turned(const Samples& array, const Matrix3& R, int axes) {
  if (axes == 1) return array;
  Samples out = array;
  for (long k = 0; k < array.rows(); ++k)
    for (long v = 0; v + axes <= array.cols(); v += axes)
      out.row(k).segment(v, axes) =
          (R.topLeftCorner(axes, axes) * array.row(k).segment(v, axes).transpose()).transpose();
  return out;
}

Matrix3 some_turn(bool planar) {
  return planar ? balance::rotation_about(Vector3::UnitZ(), 0.7) : balance::rotation_from_rpy({0.4, -0.9, 1.3});
}

/// Reactions that the mechanism determines: an over-constrained loop's depend on the axes in which their norm is least.
bool determined(const Run& run) {
  for (const std::string& note : run.result.outcome.notes)
    if (note.find("over-constrained") != std::string::npos) return false;
  return true;
}

}  // namespace

TEST_CASE("moving and turning the ground with all that acts on it leaves efforts as they are and turns every force") {
  for_each_run(101, [](const Run& run) {
    const Experiment here{run.mechanism, run.trajectory};
    if (!can_be_displaced(here)) return;
    const int axes = run.result.axes, turns = run.result.moment_axes;
    const Matrix3 R = some_turn(axes == 2);
    const double length = run.length();
    const Experiment there =
        displaced(here, R, axes == 2 ? length * Vector3(0.3, -0.2, 0) : length * Vector3(0.3, -0.2, 0.5));
    const Run moved = laws::run(run.name + ", displaced", there.mechanism, there.trajectory);
    if (moved.result.outcome.status != balance::MotionStatus::done) return;
    const RunResult &a = run.result, &b = moved.result;
    const double force =
        force_scale(run, cloud(run)) + balance::model::total_mass(run.mechanism) * run.mechanism.gravity.norm();
    // positions are solved to 1e-12, forces follow with the condition of the equations and the size of the accelerations
    CHECK_MESSAGE(difference(a.joint_position, b.joint_position, 1) < 1e-9, run.name);
    CHECK_MESSAGE(difference(a.torque, b.torque, force * length) < 1e-9, run.name);
    CHECK_MESSAGE(difference(turned(a.shaking_force, R, axes), b.shaking_force, force) < 1e-9, run.name);
    CHECK_MESSAGE(difference(turned(a.shaking_moment, R, turns), b.shaking_moment, force * length) < 1e-9, run.name);
    CHECK_MESSAGE(difference(turned(a.ground_force, R, axes), b.ground_force, force) < 1e-9, run.name);
    CHECK_MESSAGE(difference(turned(a.ground_moment, R, turns), b.ground_moment, force * length) < 1e-9, run.name);
    CHECK_MESSAGE(difference(a.kinetic_energy, b.kinetic_energy, 0) < 1e-9, run.name);
    if (!determined(run)) return;
    CHECK_MESSAGE(difference(turned(a.joint_force, R, axes), b.joint_force, force) < 1e-9, run.name);
    CHECK_MESSAGE(difference(turned(a.joint_moment, R, turns), b.joint_moment, force * length) < 1e-9, run.name);
  });
}

TEST_CASE("a mechanism that stands a thousand times its size away moves and costs the same") {
  for_each_run(51, [](const Run& run) {
    const Experiment here{run.mechanism, run.trajectory};
    if (!can_be_displaced(here)) return;
    const Vector3 far =
        1000 * run.length() * (run.result.axes == 2 ? Vector3(0.6, -0.8, 0) : Vector3(0.6, -0.48, 0.64));
    const Experiment there = displaced(here, Matrix3::Identity(), far);
    const Run moved = laws::run(run.name + ", far away", there.mechanism, there.trajectory);
    if (moved.result.outcome.status != balance::MotionStatus::done) return;
    const double force =
        force_scale(run, cloud(run)) + balance::model::total_mass(run.mechanism) * run.mechanism.gravity.norm();
    // round-off of positions grows a thousandfold
    CHECK_MESSAGE(difference(run.result.torque, moved.result.torque, force * run.length()) < 1e-7, run.name);
    CHECK_MESSAGE(difference(run.result.shaking_force, moved.result.shaking_force, force) < 1e-7, run.name);
    CHECK_MESSAGE(difference(run.result.shaking_moment, moved.result.shaking_moment, force * run.length()) < 1e-7,
                  run.name);
  });
}

TEST_CASE("lengths, masses and times multiplied by powers of two multiply every result by its own power") {
  // Multiplying by a power of two is exact, and all comparisons inside are relative: the same operations with the same digits.
  for_each_run(51, [](const Run& run) {
    for (const Units& by : {Units{4, 0.5, 2}, Units{0x1p-20, 0x1p-30, 0x1p-10}}) {
      const Experiment large = scaled({run.mechanism, run.trajectory}, by);
      const Run other = laws::run(run.name + ", scaled", large.mechanism, large.trajectory);
      if (other.result.outcome.status != balance::MotionStatus::done) continue;
      const RunResult &a = run.result, &b = other.result;
      const double size = force_scale(run, cloud(run));
      const double force = size * by.force(), moment = size * run.length() * by.moment();
      for (long c = 0; c < a.joint_position.cols(); ++c) {
        const double unit = run.mechanism.coordinates[c].kind == balance::CoordinateKind::length ? by.length : 1;
        CHECK_MESSAGE(difference(a.joint_position.col(c) * unit, b.joint_position.col(c), unit * 1e-3) < 1e-12,
                      run.name);
        CHECK_MESSAGE(difference(a.joint_acceleration.col(c) * (unit / (by.time * by.time)),
                                 b.joint_acceleration.col(c), unit) < 1e-10,
                      run.name);
      }
      for (long c = 0; c < a.torque.cols(); ++c) {
        const bool slide = a.actuator_units[c] == "N";
        CHECK_MESSAGE(difference(a.torque.col(c) * (slide ? by.force() : by.moment()), b.torque.col(c),
                                 slide ? force : moment) < 1e-12,
                      run.name << ", " << a.actuator_names[c]);
      }
      CHECK_MESSAGE(difference(a.shaking_force * by.force(), b.shaking_force, force) < 1e-12, run.name);
      CHECK_MESSAGE(difference(a.shaking_moment * by.moment(), b.shaking_moment, moment) < 1e-12, run.name);
      CHECK_MESSAGE(difference(a.ground_force * by.force(), b.ground_force, force) < 1e-12, run.name);
      CHECK_MESSAGE(difference(a.kinetic_energy * by.moment(), b.kinetic_energy, 0) < 1e-12, run.name);
      CHECK_MESSAGE(difference(a.joint_force * by.force(), b.joint_force, force) < 1e-10, run.name);
    }
  });
}

namespace {

/// Of a coordinate in a mirror: what turns, and the second slide of a planar joint, which is to the left of the first.
int mirror_sign(const balance::Mechanism& m, balance::CoordinateId c) {
  const balance::Coordinate& coordinate = m.coordinates[c];
  const bool is_left =
      m.joints[static_cast<std::size_t>(coordinate.joint)].type == balance::JointType::planar && coordinate.index == 1;
  return coordinate.kind == balance::CoordinateKind::angle || is_left ? -1 : 1;
}

/// What a mirror at the plane y = 0 (z too in space: a half turn leaves handedness alone) would show of a planar mechanism.
Experiment mirrored(Experiment e) {
  const auto flip = [](Vector3& v) { v.y() = -v.y(); };
  balance::Mechanism& m = e.mechanism;
  const auto changes_sign = [&](balance::CoordinateId c) { return mirror_sign(m, c) < 0; };
  flip(m.gravity);
  for (auto& body : m.bodies) {
    flip(body.com);
    for (auto& point : body.points) flip(point.position);
  }
  for (auto& joint : m.joints) {
    flip(joint.point_first), flip(joint.point_second), flip(joint.axis);
    joint.rotation.transposeInPlace();
    if (joint.type == balance::JointType::revolute) joint.axis = Vector3::UnitZ();
    if (joint.type == balance::JointType::planar) flip(joint.axis2);
  }
  for (auto& extra : m.attachments) flip(extra.position);
  for (auto& disc : m.discs) {
    flip(disc.position);
    for (auto& term : disc.follows.terms)
      if (!changes_sign(term.coordinate)) term.ratio = -term.ratio;
  }
  for (auto& load : m.loads) {
    flip(load.point);
    for (auto& force : load.force) flip(force);
    for (auto& moment : load.moment) moment = -moment;
    if (!load.is_over_coordinate() || !changes_sign(load.coordinate)) continue;
    for (auto& argument : load.arguments) argument = -argument;
    std::reverse(load.arguments.begin(), load.arguments.end());
    std::reverse(load.force.begin(), load.force.end());
    std::reverse(load.moment.begin(), load.moment.end());
  }
  for (auto& spring : m.springs) {
    flip(spring.point_first), flip(spring.point_second);
    if (spring.is_joint_spring() && changes_sign(spring.coordinate)) spring.preload = -spring.preload;
  }
  for (auto& element : m.force_elements) {
    flip(element.point_first), flip(element.point_second);
    if (!element.is_in_joint() || !changes_sign(element.coordinate)) continue;
    auto& table = element.table;
    std::reverse(table.displacement.begin(), table.displacement.end());
    std::reverse(table.force.begin(), table.force.end());
    for (auto* numbers : {&table.displacement, &table.force})
      for (double& number : *numbers) number = -number;
  }
  for (auto& coupling : m.couplings) {
    coupling.ratio *= mirror_sign(m, coupling.follower);
    for (auto& term : coupling.leader.terms) term.ratio *= mirror_sign(m, term.coordinate);
    coupling.offset *= mirror_sign(m, coupling.follower);
  }
  if (m.tool) flip(m.tool->position);
  for (auto& friction : m.friction)  // what turned forwards turns backwards
    if (changes_sign(friction.coordinate) && friction.coulomb_backward)
      std::swap(friction.coulomb, *friction.coulomb_backward);
  const auto turn_back = [&](balance::CoordinateValue& value) {
    if (changes_sign(value.coordinate)) value.value = -value.value;
  };
  for (auto& rough : m.assembly) turn_back(rough);
  for (balance::trajectory::PoseTarget* pose : {&e.trajectory.from, &e.trajectory.to}) {
    if (pose->tool) flip(*pose->tool);
    if (pose->com) flip(*pose->com);
    if (pose->angle) pose->angle = -*pose->angle;
    for (auto& joint : pose->joints) turn_back(joint);
  }
  if (auto* circle = std::get_if<balance::trajectory::CirclePath>(&e.trajectory.path))
    flip(circle->centre), circle->angle = -circle->angle;
  flip(e.trajectory.about);
  return e;
}

}  // namespace

TEST_CASE("a planar mechanism in a mirror has mirrored forces, and efforts of turning motors change their sign") {
  for_each_run(51, [](const Run& run) {
    if (run.result.axes != 2) return;
    const Experiment glass = mirrored({run.mechanism, run.trajectory});
    const Run other = laws::run(run.name + ", mirrored", glass.mechanism, glass.trajectory);
    if (other.result.outcome.status != balance::MotionStatus::done) return;
    const double force = force_scale(run, cloud(run)), moment = force * run.length();
    Samples flipped = run.result.shaking_force;
    flipped.col(1) *= -1;
    CHECK_MESSAGE(difference(flipped, other.result.shaking_force, force) < 1e-9, run.name);
    CHECK_MESSAGE(difference(-run.result.shaking_moment, other.result.shaking_moment, moment) < 1e-9, run.name);
    for (long c = 0; c < run.result.torque.cols(); ++c) {
      const bool slide = run.result.actuator_units[c] == "N";
      const double sign = mirror_sign(run.mechanism, run.mechanism.actuators[static_cast<std::size_t>(c)]);
      CHECK_MESSAGE(
          difference(sign * run.result.torque.col(c), other.result.torque.col(c), slide ? force : moment) < 1e-9,
          run.name << ", " << run.result.actuator_names[c]);
    }
  });
}
