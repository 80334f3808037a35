// A planar linkage that is written in space is the same mechanism: the same mode, the same components, the same figures.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

namespace {

std::string number(double value) { return std::to_string(value); }

/// One plane of the world: its coordinates at the places of x and y, and the axis of its turns.
struct Plane {
  bool space = false;
  int a = 0, b = 1;

  std::string point(double x, double y) const {
    if (!space) return "[" + number(x) + ", " + number(y) + "]";
    std::string all[3] = {"0", "0", "0"};
    all[a] = number(x), all[b] = number(y);
    return "[" + all[0] + ", " + all[1] + ", " + all[2] + "]";
  }
  int across() const { return 3 - a - b; }
  double sign() const { return (b - a + 3) % 3 == 1 ? 1 : -1; }  // of e_a × e_b along the third axis
  std::string axis() const {
    std::string all[3] = {"0", "0", "0"};
    all[across()] = number(sign());
    return "[" + all[0] + ", " + all[1] + ", " + all[2] + "]";
  }
  std::string joint(const std::string& points) const {
    return "{type: revolute, connects: [" + points + "]" + (space ? ", axis: " + axis() : "") + "}";
  }
  std::string body(double length) const {
    return "{mass: 1, com: " + point(length / 2, 0.02) + ", inertia: " + (space ? "[0.01, 0.01, 0.01]" : "0.01") +
           ", points: {O: " + point(0, 0) + ", E: " + point(length, 0) + ", F: " + point(length / 2, 0.1) + "}}";
  }
  std::string pose(const std::string& what, double x, double y) const {
    return "{" + what + ": " + point(x, y) + turn() + "}";
  }
  std::string turn() const { return what_turns ? (space ? ", rpy: [0, 0, 0]" : ", angle: 0") : ""; }

  bool what_turns = false;
};

std::string head(const Plane& plane, const std::string& ground) {
  return std::string("space: ") + (plane.space ? "spatial" : "planar") + "\ngravity: " + plane.point(0, -9.81) +
         "\nground: {points: {" + ground + "}}\n";
}

/// Five-bar with motors at its base.
std::string five_bar(const Plane& plane, const std::string& trajectory) {
  return head(plane, "O: " + plane.point(0, 0) + ", P: " + plane.point(0.4, 0)) + "bodies:\n  c: " + plane.body(0.25) +
         "\n  l: " + plane.body(0.3) + "\n  k: " + plane.body(0.3) + "\n  d: " + plane.body(0.25) +
         "\njoints:\n  A: " + plane.joint("ground.O, c.O") + "\n  B: " + plane.joint("c.E, l.O") +
         "\n  C: " + plane.joint("l.E, k.E") + "\n  E: " + plane.joint("d.E, k.O") +
         "\n  D: " + plane.joint("ground.P, d.O") +
         "\nactuators: [A, D]\ntool: l.E\nassembly: {A: 2.2, D: 0.94}\ntrajectories:\n  go: {duration: 1, samples: "
         "101, " +
         trajectory + "}\n";
}

/// Three cranks and couplers that carry a platform; motors at the cranks.
std::string three_legs(Plane plane, const std::string& drive,
                       const std::string& elbows = "B0: -1.65, B1: -1.71, B2: -2.85") {
  plane.what_turns = true;
  std::string ground, bodies, joints, platform = "H: " + plane.point(0, 0);
  for (int k = 0; k < 3; ++k) {
    const double angle = (4 * k - 1) * std::numbers::pi / 6, c = std::cos(angle), s = std::sin(angle);
    const std::string n = std::to_string(k);
    ground += (k ? ", O" : "O") + n + ": " + plane.point(0.25 * c, 0.25 * s);
    platform += ", P" + n + ": " + plane.point(0.0866 * c, 0.0866 * s);
    bodies += "  c" + n + ": " + plane.body(0.18) + "\n  d" + n + ": " + plane.body(0.18) + "\n";
    joints += "  A" + n + ": " + plane.joint("ground.O" + n + ", c" + n + ".O") + "\n  B" + n + ": " +
              plane.joint("c" + n + ".E, d" + n + ".O") + "\n  C" + n + ": " + plane.joint("d" + n + ".E, p.P" + n) +
              "\n";
  }
  return head(plane, ground) + "bodies:\n" + bodies + "  p: {mass: 1, com: " + plane.point(0.01, 0.02) +
         ", inertia: " + (plane.space ? "[0.01, 0.01, 0.01]" : "0.01") + ", points: {" + platform + "}}\njoints:\n" +
         joints + "actuators: [A0, A1, A2]\ntool: p.H\nassembly: {" + elbows +
         "}\n"
         "trajectories: {go: {law: cycloidal, duration: 1, samples: 101, drive: " +
         drive + ", from: " + plane.pose("tool", -0.1, -0.05) + ", to: " + plane.pose("tool", -0.07, -0.04) + "}}\n";
}

balance::RunResult go(const std::string& text) {
  const balance::Study study = balance::read_spec(text, "space.yaml");
  return balance::simulate(study.mechanism, study.trajectories.front());
}

void check_same(const balance::RunResult& plane, const balance::RunResult& space) {
  REQUIRE_MESSAGE(plane.outcome.status == balance::MotionStatus::done, plane.outcome.reason);
  REQUIRE_MESSAGE(space.outcome.status == balance::MotionStatus::done, space.outcome.reason);
  CHECK((plane.torque - space.torque).norm() < 1e-8 * plane.torque.norm());
}

const Plane in_plane, xy{true, 0, 1}, xz{true, 0, 2}, yz{true, 1, 2}, yx{true, 1, 0};

}  // namespace

TEST_CASE("a tool that moves in a plane of space is led in that plane, its turn included (A2)") {
  const balance::RunResult plane = go(three_legs(in_plane, "tool"));
  for (const Plane& space : {xy, xz, yz, yx}) check_same(plane, go(three_legs(space, "tool")));
}

TEST_CASE("a centre of mass that moves in a plane of space drives what it does in the plane (A2)") {
  check_same(go(three_legs(in_plane, "com")), go(three_legs(xy, "com")));
  check_same(go(three_legs(in_plane, "com")), go(three_legs(xz, "com")));
}

TEST_CASE("two coordinates of a point go round circles and along arcs of their plane (A2)") {
  for (const Plane& space : {xy, xz, yz}) {
    const auto circle = [](const Plane& p) {
      return five_bar(p, "law: cubic, drive: tool, from: {tool: " + p.point(0.2, 0.38) + "}, path: {circle: {centre: " +
                             p.point(0.2, 0.4) + ", turns: 1" + (p.space ? ", normal: " + p.axis() : "") + "}}");
    };
    check_same(go(circle(in_plane)), go(circle(space)));
    const auto arc = [](const Plane& p) {
      return five_bar(p, "law: cubic, drive: tool, from: {tool: " + p.point(0.17, 0.38) + "}, to: {tool: " +
                             p.point(0.23, 0.38) + "}, path: {arc: {via: " + p.point(0.2, 0.41) + "}}");
    };
    check_same(go(arc(in_plane)), go(arc(space)));
  }
}

TEST_CASE("of the assembly modes the nearest to the stated values is taken, in the plane and in space (A2)") {
  // The third leg is folded, 2.85 rad to one side or the other: 0.6 rad apart, and on the mean of three elbows not far.
  const auto leg = [](const Plane& plane, const std::string& elbows) { return go(three_legs(plane, "tool", elbows)); };
  const balance::RunResult left = leg(in_plane, "A0: 2.18, B0: 1.655, A1: -1.15, B1: -1.714, A2: -0.77, B2: 2.85");
  const balance::RunResult right = leg(in_plane, "A0: 2.18, B0: 1.655, A1: -1.15, B1: -1.714, A2: 2.08, B2: -2.85");
  CHECK((left.torque - right.torque).norm() > 0.1 * left.torque.norm());
  for (const Plane& plane : {in_plane, xy, xz}) {
    check_same(left, leg(plane, "B0: 1.6, B1: -1.55, B2: 3.02"));
    check_same(left, leg(plane, "B0: 1.56, B1: -1.75, B2: 2.96"));
    check_same(right, leg(plane, "B0: 1.69, B1: -1.65, B2: -2.99"));
    check_same(right, leg(plane, "B0: 1.7, B1: -1.59, B2: -2.86"));
  }
}
