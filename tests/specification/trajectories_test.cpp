#include "specs.hpp"

#include "balance/interface/specification/balanced_spec.hpp"

#include <cmath>
#include <numbers>

using namespace balance;
using namespace balance::specification;
using namespace balance::trajectory;

namespace {

const Trajectory& named(const Study& study, const std::string& name) {
  for (const Trajectory& t : study.trajectories)
    if (t.name == name) return t;
  FAIL("no trajectory " << name);
  return study.trajectories.front();
}

/// The trajectory `line` of the planar spec with other contents.
Trajectory line(const std::string& contents) {
  return named(specs::read(specs::with(specs::planar, "line: {law: cubic, drive: tool}", "line: {" + contents + "}")),
               "line");
}

std::string file(const std::string& name) { return "path: {file: \"" BALANCE_TEST_DATA "/" + name + "\"}"; }

}  // namespace

TEST_CASE("declared trajectories come first and take from motion what they do not say") {
  const Study study = specs::read(specs::planar);
  REQUIRE(study.trajectories.size() == 5);
  CHECK(study.trajectories[0].name == "line");
  CHECK(study.trajectories[1].name == "swing");
  CHECK(study.trajectories[2].name == "via");
  CHECK(study.trajectories[3].name == "cycloid");
  CHECK(study.trajectories[4].name == "bang-bang");
  const Trajectory& l = study.trajectories[0];
  CHECK(l.law.kind == MotionLawKind::cubic);
  CHECK(l.drive == DriveKind::tool);
  CHECK(l.duration == 1);
  CHECK(l.samples == 101);
  CHECK(*l.from.tool == Vector3(0.6, 0.1, 0));
  CHECK(*l.to.angle == 2);
  CHECK(std::holds_alternative<LinePath>(l.path));
  const Trajectory& swing = study.trajectories[1];
  CHECK(swing.law.kind == MotionLawKind::trapezoidal_velocity);
  CHECK(swing.law.ramp_up == 0.2);
  CHECK(swing.law.ramp_down == 0.2);
  CHECK(swing.to.joints[1].value == 2);
}

TEST_CASE("the built-in trajectories drive what motion gives") {
  const Study by_tool = specs::read(specs::planar);
  CHECK(named(by_tool, "cycloid").drive == DriveKind::tool);
  CHECK(named(by_tool, "bang-bang").drive == DriveKind::com);
  const std::string joints =
      specs::with(specs::planar, "from: {tool: [0.6, 0.1], angle: 1}, to: {tool: [0.1, 0.6], angle: 2}",
                  "from: {joints: {J1: 0, J2: 1}}, to: {joints: {J2: 2, J1: 1}}");
  const std::string undeclared = specs::with(
      joints,
      joints.substr(joints.find("trajectories:"), joints.find("counterweights:") - joints.find("trajectories:")), "");
  const Study by_joints = specs::read(undeclared);
  REQUIRE(by_joints.trajectories.size() == 2);
  CHECK(named(by_joints, "cycloid").drive == DriveKind::joints);
  CHECK(named(by_joints, "bang-bang").drive == DriveKind::joints);
  // both ends name the coordinates in the same order
  CHECK(named(by_joints, "cycloid").to.joints[0].coordinate == 0);
  CHECK(named(by_joints, "cycloid").to.joints[0].value == 1);
}

TEST_CASE("a declared cycloid replaces the built-in one") {
  const Study study = specs::read(specs::with(specs::planar, "  line:", "  cycloid:"));
  CHECK(study.trajectories.size() == 4);
  CHECK(named(study, "cycloid").law.kind == MotionLawKind::cubic);
}

TEST_CASE("every law of motion has its name") {
  const std::pair<const char*, MotionLawKind> laws[] = {{"cycloidal", MotionLawKind::cycloidal},
                                                        {"cycloid", MotionLawKind::cycloidal},
                                                        {"bang-bang", MotionLawKind::bang_bang},
                                                        {"uniform", MotionLawKind::uniform},
                                                        {"cubic", MotionLawKind::cubic},
                                                        {"3-4-5", MotionLawKind::polynomial_345},
                                                        {"poly-345", MotionLawKind::polynomial_345},
                                                        {"4-5-6-7", MotionLawKind::polynomial_4567},
                                                        {"harmonic", MotionLawKind::harmonic},
                                                        {"modified-sine", MotionLawKind::modified_sine},
                                                        {"modified-trapezoidal", MotionLawKind::modified_trapezoidal},
                                                        {"trapezoidal-velocity", MotionLawKind::trapezoidal_velocity}};
  for (const auto& [name, kind] : laws) CHECK(line("drive: tool, law: " + std::string(name)).law.kind == kind);
}

TEST_CASE("paths are circles, arcs and waypoints") {
  const Study spatial = specs::read(specs::spatial);
  const auto circle = std::get<CirclePath>(named(spatial, "turn").path);
  CHECK(circle.centre == Vector3(0, 0, 0.6));
  CHECK(circle.normal == Vector3::UnitZ());
  CHECK(circle.angle == 2 * std::numbers::pi);
  CHECK(std::get<ArcPath>(named(spatial, "bow").path).via == Vector3(0.2, 0, 0.6));
  const auto waypoints = std::get<WaypointPath>(named(specs::read(specs::planar), "via").path);
  CHECK(waypoints.spline);
  REQUIRE(waypoints.points.size() == 1);
  CHECK(*waypoints.points[0].tool == Vector3(0.4, 0.4, 0));
  CHECK(waypoints.fractions == std::vector<double>{0.4});
}

TEST_CASE("a circle needs no end") {
  const std::string text = specs::with(specs::spatial, ", to: {tool: [0.2, 0.1, 0.6]}", "");
  const std::string only_circle =
      specs::with(text, "  bow: {law: cycloidal, drive: tool, path: {arc: {via: [0.2, 0, 0.6]}}}\n", "");
  CHECK(specs::read(only_circle).trajectories.size() == 1);
}

TEST_CASE("components and remaining coordinates are read in their order") {
  CHECK(line("law: cubic, drive: tool, components: [y, angle]").components ==
        std::vector<Component>{Component::y, Component::rz});
  CHECK(line("law: cubic, drive: com, remaining: [J2, D.slide]").remaining_coordinates ==
        std::vector<CoordinateId>{1, 2});
}

TEST_CASE("remaining quantities have courses of their own") {
  const Trajectory t = line("law: cubic, drive: com, remaining: {J2: line, angle: {spline: [0.1, l], jump: true}}");
  CHECK(t.remaining_coordinates == std::vector<CoordinateId>{1});
  CHECK(t.remaining_angle);
  REQUIRE(t.secondary_tasks.size() == 1);
  CHECK(t.secondary_tasks[0].coordinate == -1);
  const auto& spline = std::get<SplineTask>(t.secondary_tasks[0].kind);
  CHECK(spline.coefficients == std::vector<double>{0.1, 0.5});
  CHECK(spline.has_middle_jump);
  CHECK(spline.over_time);
  const Trajectory kept = line("law: cubic, drive: com, remaining: {D.slide: {momentum: zero}}");
  CHECK(std::holds_alternative<MomentumTask>(kept.secondary_tasks.at(0).kind));
}

TEST_CASE("free coefficients are a list of free numbers, and are written as one") {
  const std::string text = specs::with(
      specs::planar, "law: cubic, drive: tool",
      "law: cubic, drive: com, remaining: {angle: {spline: {free: [-1, 1], knots: 3, start: 0.5}, jump: true}}");
  const Study study = specs::read(text);
  std::vector<std::string> paths;
  for (const FreeNumber& number : study.free_numbers) paths.push_back(number.key_path);
  REQUIRE(paths.size() == 5);  // and the counterweight's mass
  CHECK(paths[0] == "trajectories.line.remaining.angle.spline[0]");
  CHECK(paths[3] == "trajectories.line.remaining.angle.spline[3]");
  CHECK(std::get<SplineTask>(study.trajectories[0].secondary_tasks[0].kind).coefficients ==
        std::vector<double>(4, 0.5));
  VectorX x(5);
  x << 0.1, 0.2, 0.3, 0.4, 2;
  const std::string written = format_balanced_spec(study, x);
  CHECK(written.find("remaining: {angle: {spline: [0.1, 0.2, 0.3, 0.4], jump: true}}") != std::string::npos);
}

TEST_CASE("turns say where the one driven joint ends") {
  const Trajectory t = line("law: cubic, drive: joints, turns: 2, from: {joints: {J1: 0.5}}");
  CHECK(t.to.joints.at(0).value == doctest::Approx(0.5 + 4 * std::numbers::pi).epsilon(1e-15));
}

TEST_CASE("a table brings its own times, poses and components") {
  const Trajectory t = line("drive: tool, path: {table: [[1, 0.6, 0.1], [2, 0.5, 0.2], [3, 0.4, 0.3], [4, 0.3, 0.5]]}");
  const auto& table = std::get<TablePath>(t.path);
  CHECK(table.time == std::vector<double>{1, 2, 3, 4});
  CHECK(table.values[3] == std::vector<double>{0.3, 0.5});
  CHECK(t.duration == 3);
  CHECK(t.components == std::vector<Component>{Component::x, Component::y});
  CHECK(*t.from.tool == Vector3(0.6, 0.1, 0));
  CHECK(*t.to.tool == Vector3(0.3, 0.5, 0));
}

TEST_CASE("a table of joint coordinates names its columns or takes the actuators") {
  const Trajectory named_columns =
      line("drive: joints, path: {columns: [J2, J1], table: [[0, 1, 2], [1, 3, 4], [2, 5, 6], [3, 7, 8]]}");
  CHECK(named_columns.from.joints[0].coordinate == 1);
  CHECK(named_columns.to.joints[1].value == 8);
  const Trajectory actuators =
      line("drive: joints, path: {table: [[0, 1, 2, 0], [1, 3, 4, 0], [2, 5, 6, 0], [3, 7, 8, 0]]}");
  CHECK(actuators.from.joints.size() == 3);
  CHECK(actuators.from.joints[1].coordinate == 1);
}

TEST_CASE("a CSV file may have its columns in any order") {
  const Trajectory t = line("drive: tool, " + file("motion.csv"));
  const auto& table = std::get<TablePath>(t.path);
  CHECK(table.time == std::vector<double>{0, 0.25, 0.5, 0.75, 1});
  CHECK(table.values[1] == std::vector<double>{0.5, 0.2, 1.25});
  CHECK(t.components == std::vector<Component>{Component::x, Component::y, Component::rz});
  CHECK(*t.to.tool == Vector3(0.1, 0.6, 0));
}

TEST_CASE("an HDF5 file has a dataset for every column and may hold others") {
  const Trajectory t = line("drive: joints, " + file("joints.h5"));
  const auto& table = std::get<TablePath>(t.path);
  CHECK(table.time.size() == 5);
  REQUIRE(t.from.joints.size() == 2);
  CHECK(t.from.joints[0].coordinate == 0);
  CHECK(table.values[2] == std::vector<double>{0.5, 1.25});
}

TEST_CASE("a table file that does not fit is named with what is wrong in it") {
  const auto complaint = [](const std::string& contents) {
    return specs::complaint(specs::with(specs::planar, "line: {law: cubic, drive: tool}", "line: {" + contents + "}"));
  };
  CHECK(complaint("drive: joints, " + file("motion.csv"))
            .find("motion.csv: expected the columns time, J1, J2, D.slide or D.angle, found 'y'") != std::string::npos);
  CHECK(complaint("drive: joints, " + file("uneven.h5"))
            .find("uneven.h5: 'J1': expected 5 values as in 'time', found 4") != std::string::npos);
  CHECK(complaint("drive: tool, " + file("joints.h5")).find("joints.h5: expected columns besides 'time'") !=
        std::string::npos);
  CHECK(complaint("drive: tool, " + file("specs.hpp")).find("specs.hpp: line") != std::string::npos);
  CHECK(complaint("drive: tool, " + file("forces.csv"))
            .find("forces.csv: expected the columns time, x, y or angle, found 'm'") != std::string::npos);
  CHECK(complaint("drive: tool, " + file(".")).find("expected a file, found a folder at") != std::string::npos);
}
