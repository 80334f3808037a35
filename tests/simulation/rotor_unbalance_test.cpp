/// The unbalance of random rotors, judged by the forces of a simulated uniform turn.

#include "balance/motion/simulation/rotor_unbalance.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

namespace rotor_unbalance_test {

using namespace balance;
using namespace balance::simulation;

namespace {

constexpr double speed = 30;  // rad/s

/// A body on an axis in any direction through any point, which may be the joint's first or second body, with two
/// counterweights and a payload.
Study random_rotor(unsigned seed) {
  std::mt19937 bits(seed);
  const auto number = [&](double low, double high) { return low + (high - low) * (bits() * 0x1p-32); };
  const auto place = [&] { return Vector3(number(-1, 1), number(-1, 1), number(-1, 1)); };
  Study study;
  Mechanism& m = study.mechanism;
  m.space = SpaceKind::spatial;
  m.bodies.resize(2);
  m.bodies[0].name = "ground";
  Body& body = m.bodies[1];
  body.name = "rotor";
  body.mass = number(5, 10);
  body.com = place();
  const Matrix3 axes = rotation_from_rpy(3 * place());
  body.inertia = axes * Vector3(1, 1.3, 1.6).asDiagonal() * axes.transpose();
  Joint joint;
  joint.name = "S";
  joint.rotation = rotation_from_rpy(3 * place());
  joint.axis = place().normalized();
  joint.point_first = place();
  joint.point_second = place();
  (seed % 2 == 0 ? joint.second : joint.first) = 1;
  m.joints.push_back(joint);
  m.coordinates = model::list_coordinates(m.space, m.joints);
  m.actuators = {0};
  for (const char* name : {"a", "b", "load"})
    m.attachments.push_back({.name = name,
                             .kind = name[0] == 'l' ? AttachmentKind::payload : AttachmentKind::counterweight,
                             .body = 1,
                             .position = place(),
                             .mass = number(0.1, 2)});
  Trajectory turn;
  turn.name = "turn";
  turn.law.kind = MotionLawKind::uniform;
  turn.drive = DriveKind::joints;
  turn.from.joints = {{0, 0.0}};
  turn.to.joints = {{0, -2 * std::numbers::pi}};  // backwards
  turn.duration = 2 * std::numbers::pi / speed;
  turn.samples = 9;
  turn.about = seed % 2 == 0 ? joint.point_first : joint.point_second;  // a point of the ground on the axis
  study.trajectories = {turn};
  return study;
}

std::complex<double> vector_of(const UnbalanceVector& unbalance) {
  return std::polar(unbalance.magnitude, unbalance.angle);
}

}  // namespace

TEST_CASE("a rotor that turns uniformly pulls with its static unbalance times the square of its speed") {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    const Study study = random_rotor(seed);
    const RunResult run = simulate(study.mechanism, study.trajectories.front());
    REQUIRE(run.outcome.status == MotionStatus::done);
    const std::vector<RotorUnbalance> rotors = list_rotor_unbalances(study.mechanism, study.trajectories);
    REQUIRE(rotors.size() == 1);
    const RotorUnbalance& rotor = rotors.front();
    // round-off of a few operations on forces of 1e4 N
    CHECK(rotor.static_unbalance.magnitude * speed * speed ==
          doctest::Approx(run.shaking_force.row(4).norm()).epsilon(1e-12));

    // the moment about the joint's point is that of the two planes
    REQUIRE(rotor.planes.size() == 2);
    const CorrectionPlane &first = rotor.planes[0], &second = rotor.planes[1];
    const std::complex<double> U = vector_of(first.unbalance) + vector_of(second.unbalance),
                               D = first.position * vector_of(first.unbalance) +
                                   second.position * vector_of(second.unbalance);
    CHECK(std::abs(U - vector_of(rotor.static_unbalance)) < 1e-11);
    Vector3 across = run.shaking_moment.row(4).transpose();
    CHECK(std::abs(D) * speed * speed == doctest::Approx(across.norm()).epsilon(1e-11));

    // and the couple unbalance the moment about the centre of mass
    CHECK(rotor.couple_unbalance.magnitude * speed * speed ==
          doctest::Approx(run.shaking_moment_com.row(4).norm()).epsilon(1e-11));

    REQUIRE(rotor.qualities.size() == 1);
    CHECK(rotor.qualities[0].speed == doctest::Approx(speed));
    CHECK(first.share + second.share == doctest::Approx(1));
    const double worse = std::max(first.unbalance.magnitude / first.share, second.unbalance.magnitude / second.share);
    CHECK(rotor.qualities[0].quality == doctest::Approx(1000 * speed * worse / rotor.mass));
  }
}

TEST_CASE("masses opposite to the unbalances in both planes leave none") {
  Study study = random_rotor(3);
  const RotorUnbalance before = list_rotor_unbalances(study.mechanism, study.trajectories).front();
  const Joint& joint = study.mechanism.joints[0];  // the rotor is its first body
  REQUIRE(joint.first == 1);
  const Vector3 axis = joint.axis, x = (Vector3::UnitX() - axis.x() * axis).normalized(), y = axis.cross(x);
  REQUIRE(before.angle_reference == "x");
  for (const CorrectionPlane& plane : before.planes)
    study.mechanism.attachments.push_back({.name = "w" + plane.name,
                                           .kind = AttachmentKind::payload,
                                           .body = 1,
                                           .position = joint.point_first + plane.position * axis -
                                                       std::cos(plane.unbalance.angle) * x -
                                                       std::sin(plane.unbalance.angle) * y,
                                           .mass = plane.unbalance.magnitude});
  const RotorUnbalance after = list_rotor_unbalances(study.mechanism, study.trajectories).front();
  CHECK(after.static_unbalance.magnitude == 0);
  CHECK(after.couple_unbalance.magnitude < 1e-11);
  CHECK(after.qualities[0].grade == 0.4);
}

TEST_CASE("round-off across an unbalance does not turn its angle by a whole turn") {
  Study study = random_rotor(2);
  Mechanism& m = study.mechanism;
  m.attachments.clear();
  m.joints[0].axis = Vector3::UnitZ();
  m.joints[0].rotation.setIdentity();
  m.joints[0].point_first.setZero(), m.joints[0].point_second.setZero();
  m.bodies[1].com = Vector3(0.1, -1e-18, 0);
  const RotorUnbalance rotor = list_rotor_unbalances(study.mechanism, study.trajectories).front();
  CHECK(rotor.static_unbalance.magnitude == doctest::Approx(0.1 * m.bodies[1].mass).epsilon(1e-15));
  CHECK(rotor.static_unbalance.angle == 0);
}

TEST_CASE("planes are those of two places of counterweights, else of two places of points, else there are none") {
  Study study = random_rotor(2);
  CHECK(list_rotor_unbalances(study.mechanism, study.trajectories).front().planes[0].name == "a");
  study.mechanism.attachments.pop_back();
  study.mechanism.attachments.pop_back();
  CHECK(list_rotor_unbalances(study.mechanism, study.trajectories).front().planes.empty());
  study.mechanism.bodies[1].points = {{"A", Vector3(0, 0, 0)}, {"B", Vector3(1, 2, 3)}};
  const std::vector<CorrectionPlane> planes = list_rotor_unbalances(study.mechanism, study.trajectories).front().planes;
  REQUIRE(planes.size() == 2);
  CHECK((planes[0].name == "A" && planes[1].name == "B"));
}

}  // namespace rotor_unbalance_test
