#include "specs.hpp"

#include <cmath>
#include <filesystem>
#include <numbers>

namespace complete_spec_test {

using namespace balance;
using namespace balance::model;

namespace {
/// Sums and products of two or three numbers: a few roundings.
const double rounding = 1e-14;
}  // namespace

TEST_CASE("a planar spec becomes the mechanism that it describes") {
  const Study study = specs::read(specs::planar);
  const Mechanism& m = study.mechanism;
  CHECK(m.name == "test arm");
  CHECK(m.space == SpaceKind::planar);
  CHECK(m.gravity == Vector3(0, -9.81, 0));
  REQUIRE(m.bodies.size() == 4);
  CHECK(m.bodies[ground].name == "ground");
  CHECK(m.bodies[ground].mass == 0);
  REQUIRE(m.bodies[ground].points.size() == 2);
  CHECK(m.bodies[ground].points[1].position == Vector3(0, 1, 0));
  CHECK(m.bodies[1].name == "upper");
  CHECK(m.bodies[1].mass == 2);
  CHECK(m.bodies[1].com == Vector3(0.25, 0, 0));
  CHECK(m.bodies[1].inertia == Matrix3(Vector3(0, 0, 0.02).asDiagonal()));
  CHECK(m.bodies[3].points.empty());
  REQUIRE(m.joints.size() == 3);
  CHECK(m.joints[1].first == 1);
  CHECK(m.joints[1].second == 2);
  CHECK(m.joints[1].point_first == Vector3(0.5, 0, 0));
  CHECK(m.joints[2].type == JointType::pin_slot);
  CHECK(m.joints[2].axis == Vector3::UnitX());
  REQUIRE(m.coordinates.size() == 4);
  CHECK(m.coordinates[3].name == "D.angle");
  REQUIRE(m.couplings.size() == 1);
  CHECK(m.couplings[0].follower == 3);
  CHECK(m.couplings[0].leader.terms[0].coordinate == 1);
  CHECK(m.couplings[0].ratio == -1);
  CHECK(m.actuators == std::vector<CoordinateId>{0, 1, 2});
  REQUIRE(m.tool);
  CHECK(m.tool->body == 2);
  CHECK(m.tool->point == "H");
  CHECK(m.tool->position == Vector3(0.5, 0, 0));
  REQUIRE(m.assembly.size() == 2);
  CHECK(m.assembly[1].coordinate == 1);
  CHECK(m.assembly[1].value == 1);
  CHECK(study.spec_text == specs::planar);
  CHECK(study.spec_file == "s.yaml");
  CHECK(study.warnings.empty());
}

TEST_CASE("masses, discs, loads, springs and friction are read with their places") {
  const Mechanism m = specs::read(specs::planar).mechanism;
  REQUIRE(m.attachments.size() == 2);
  CHECK(m.attachments[0].kind == AttachmentKind::counterweight);
  CHECK(m.attachments[0].mass == 0);
  CHECK(m.attachments[1].kind == AttachmentKind::payload);
  CHECK(m.attachments[1].position == Vector3(0.5, 0, 0));
  CHECK(m.attachments[1].inertia(2, 2) == 0.001);
  REQUIRE(m.discs.size() == 1);
  CHECK(m.discs[0].follows.terms[0].coordinate == 1);
  CHECK(m.discs[0].ratio == -2);
  CHECK(m.discs[0].axis == Vector3::UnitZ());
  REQUIRE(m.loads.size() == 2);
  CHECK(m.loads[0].arguments.empty());
  CHECK(m.loads[0].point == Vector3(0.5, 0, 0));
  CHECK(m.loads[0].force == std::vector<Vector3>{Vector3(5, 0, 0)});
  CHECK(m.loads[0].moment == std::vector<Vector3>{Vector3(0, 0, 1)});
  CHECK(m.loads[1].point == Vector3::Zero());
  CHECK(m.loads[1].arguments == std::vector<double>{0, 1});
  CHECK(m.loads[1].force[1] == Vector3(3, 4, 0));
  REQUIRE(m.springs.size() == 1);
  CHECK(m.springs[0].first == ground);
  CHECK(m.springs[0].point_second == Vector3(0.5, 0, 0));
  CHECK(m.springs[0].stiffness == 100);
  CHECK(m.springs[0].free_length == 0.1);
  REQUIRE(m.friction.size() == 1);
  CHECK(m.friction[0].viscous == 0.1);
  CHECK(m.friction[0].coulomb == 0.2);
  CHECK(m.friction[0].static_limit(1) == 0.2);
  CHECK(m.friction[0].static_limit(-1) == 0.2);
}

TEST_CASE("a load's table may be rows, lists or a file") {
  const auto load = [](const std::string& table) {
    return specs::read(specs::with(specs::planar, "table: [[0, 1, 2], [1, 3, 4]]", table)).mechanism.loads[1];
  };
  const Load rows = load("table: [[0, 1, 2, 3], [1, 4, 5, 6]]");
  const Load lists = load("table: {time: [0, 1], force: [[1, 2], [4, 5]], moment: [3, 6]}");
  CHECK(rows.arguments == lists.arguments);
  CHECK(rows.force == lists.force);
  CHECK(rows.moment == lists.moment);
  CHECK(rows.moment[1] == Vector3(0, 0, 6));
  const Load file = load("file: \"" BALANCE_TEST_DATA "/forces.csv\"");
  CHECK(file.arguments == std::vector<double>{0, 2});
  CHECK(file.force[1] == Vector3(30, 0, 0));
  CHECK(file.moment[1] == Vector3(0, 0, 3));
}

TEST_CASE("a spatial spec becomes the mechanism that it describes") {
  const Mechanism m = specs::read(specs::spatial).mechanism;
  CHECK(m.name == "s");
  CHECK(m.space == SpaceKind::spatial);
  CHECK(m.gravity == Vector3(0, 0, -9.81));
  CHECK(m.bodies[2].inertia(0, 1) == 0.001);
  CHECK(m.bodies[2].inertia(1, 0) == 0.001);
  CHECK(m.joints[0].rotation == Matrix3::Identity());
  const Joint& u = m.joints[1];
  CHECK(u.axis == Vector3::UnitX());
  CHECK(u.axis2 == Vector3::UnitY());
  CHECK((u.rotation * Vector3::UnitY() - Vector3(0, std::cos(0.1), std::sin(0.1))).norm() < rounding);
  CHECK(m.loads[0].frame == Frame::body);
  CHECK(m.loads[0].moment[0] == Vector3::UnitZ());
  // about its axis 0.002, across it 0.001; the axis of U.1 is x
  CHECK(m.discs[0].axis == Vector3::UnitX());
  CHECK(m.discs[0].inertia.diagonal() == Vector3(0.002, 0.001, 0.001));
}

TEST_CASE("an inertia about the origin is moved to the centre of mass") {
  const Study planar = specs::read(specs::with(specs::planar, "inertia: 0.02", "inertia: {about: origin, value: 0.2}"));
  CHECK(planar.mechanism.bodies[1].inertia(2, 2) == doctest::Approx(0.2 - 2 * 0.25 * 0.25).epsilon(rounding));
  const Study spatial = specs::read(specs::with(specs::spatial, "inertia: [0.02, 0.02, 0.01], points",
                                                "inertia: {about: origin, value: [0.04, 0.05, 0.015]}, points"));
  const Vector3 expected(0.04 - 2 * 0.01, 0.05 - 2 * 0.01, 0.015);
  CHECK((spatial.mechanism.bodies[1].inertia - Matrix3(expected.asDiagonal())).norm() < rounding);
}

TEST_CASE("a thin plate's inertia passes though it is on the limit") {
  const Study plate = specs::read(specs::with(specs::spatial, "[0.02, 0.02, 0.01], points", "[0.1, 0.2, 0.3], points"));
  CHECK(plate.mechanism.bodies[1].inertia(2, 2) == 0.3);
}

TEST_CASE("a disc turns about the followed joint's axis as it lies in the carrier") {
  const std::string on_second = specs::with(specs::spatial, "on: a, at: P, follows: U.1", "on: b, at: Q, follows: U.2");
  const Study second = specs::read(on_second);
  // R = Rx(0.1): y of the first body seen from the second is turned back
  CHECK((second.mechanism.discs[0].axis - Vector3(0, std::cos(0.1), -std::sin(0.1))).norm() < rounding);
  const Study stated =
      specs::read(specs::with(specs::spatial, "follows: U.1, mass", "follows: R, axis: [0, 2, 0], mass"));
  CHECK(stated.mechanism.discs[0].axis == Vector3::UnitY());
}

TEST_CASE("axes are normalised and a planar joint's x direction is perpendicular to its axis") {
  const auto joint = [](const std::string& replace) {
    const std::string text = specs::with(specs::spatial, "actuators: [R, U.1, U.2]\n", "");
    return specs::read(specs::with(text, "type: revolute, connects: [ground.O, a.origin], axis: [0, 0, 1]", replace))
        .mechanism.joints[0];
  };
  const std::string planar = "type: planar, connects: [ground.O, a.origin]";
  CHECK(joint(planar).axis == Vector3::UnitZ());
  CHECK(joint(planar).axis2 == Vector3::UnitX());
  const Joint tilted = joint(planar + ", axis: [0, 3, 4]");
  CHECK((tilted.axis - Vector3(0, 0.6, 0.8)).norm() < rounding);
  CHECK(std::abs(tilted.axis2.dot(tilted.axis)) < rounding);
  CHECK(std::abs(tilted.axis2.norm() - 1) < rounding);
  const Joint stated = joint(planar + ", axis: [0, 0, 2], axis2: [0, -5, 0]");
  CHECK(stated.axis2 == Vector3(0, -1, 0));
  const Joint turned = joint("type: revolute, connects: [ground.O, a.origin], quaternion: [1, 0, 0, 1]");
  CHECK((turned.rotation * Vector3::UnitX() - Vector3::UnitY()).norm() < rounding);
}

TEST_CASE("a planar joint's angle turns the second body's frame at coordinate zero") {
  const Study study =
      specs::read(specs::with(specs::planar, "[upper.B, lower.B]}", "[upper.B, lower.B], angle: \"pi/2\"}"));
  CHECK((study.mechanism.joints[1].rotation * Vector3::UnitX() - Vector3::UnitY()).norm() < rounding);
}

TEST_CASE("every mechanism in configs is read without a complaint") {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS)) {
    if (entry.path().extension() != ".yaml") continue;
    INFO(entry.path().string());
    CHECK_NOTHROW(read_spec_file(entry.path().string()));
    ++count;
  }
  CHECK(count > 0);
}

}  // namespace complete_spec_test
