// Mechanisms that coast into a configuration where their closures lose rank are stopped there, however many do so at the same moment,
// and those that only pass dead centres go on. A parallelogram without weight turns at a constant rate, so that it is flat at a
// time that is known.

#include "plant_cases.hpp"

#include "balance/motion/control/closed_loop_run.hpp"

#include <cmath>
#include <numbers>

using namespace plants;

namespace {

constexpr double pi = std::numbers::pi;

enum class Kind {
  plane,
  space,            ///< a cylindrical and a spherical joint: no closure too many
  over_constrained  ///< as in the plane, three closures too many
};

/// Crank r about the origin, coupler l, rocker s about (base, 0); a slider on the line y = 0 instead of the rocker where base is zero.
struct Loop {
  double r = 0.1, l = 0.3, s = 0.1, base = 0.3;
  double from = 1, rate = -2;  ///< of the crank [rad, rad/s]
  double flywheel = 0.01;      ///< inertia of the crank

  bool slides() const { return base == 0; }
  /// Angle of the coupler.
  double coupler() const {
    const double x = r * std::cos(from), y = r * std::sin(from);
    if (slides()) return std::asin(-y / l);
    const double far = std::hypot(base - x, y), along = std::atan2(-y, base - x);
    return along + std::acos((far * far + l * l - s * s) / (2 * far * l));
  }
};

struct Text {
  std::string bodies, joints, ground, assembly, from, to;
};

std::string place(double x, double y, Kind kind) {
  return "[" + exact(x) + ", " + exact(y) + (kind == Kind::plane ? "]" : ", 0]");
}

std::string link(const std::string& name, double length, double inertia, Kind kind) {
  const std::string I = exact(inertia), about = kind == Kind::plane ? I : "[" + I + ", " + I + ", " + I + "]";
  return "  " + name + ": {mass: 1, com: " + place(length / 2, 0, kind) + ", inertia: " + about +
         ", points: {O: " + place(0, 0, kind) + ", E: " + place(length, 0, kind) + "}}\n";
}

void add(Text& text, const Loop& loop, const std::string& n, Kind kind) {
  const auto turning = [&](const std::string& name, const std::string& connects, const std::string& type = "revolute") {
    const bool axis = kind != Kind::plane && type != "spherical";
    text.joints += "  " + name + n + ": {type: " + type + ", connects: [" + connects + "]" +
                   (axis ? ", axis: [0, 0, 1]}\n" : "}\n");
  };
  const bool free = kind == Kind::space;
  text.bodies += link("c" + n, loop.r, loop.flywheel, kind) + link("l" + n, loop.l, 0.01, kind) +
                 link("r" + n, loop.slides() ? 0.1 : loop.s, 0.01, kind);
  text.ground += ", P" + n + ": " + place(loop.base, 0, kind);
  turning("A", "ground.O, c" + n + ".O");
  turning("B", "c" + n + ".E, l" + n + ".O", free ? "spherical" : "revolute");
  turning("C", "l" + n + ".E, r" + n + (loop.slides() ? ".O" : ".E"), free ? "cylindrical" : "revolute");
  if (loop.slides())
    text.joints += "  D" + n + ": {type: prismatic, connects: [ground.P" + n + ", r" + n + ".O], axis: [1, 0" +
                   (kind == Kind::plane ? "]}\n" : ", 0]}\n");
  else
    turning("D", "ground.P" + n + ", r" + n + ".O");
  const double way = loop.coupler(), x = loop.r * std::cos(loop.from) + loop.l * std::cos(way),
               y = loop.r * std::sin(loop.from) + loop.l * std::sin(way);
  const double output = loop.slides() ? x : std::atan2(y, x - loop.base);
  text.assembly += ", A" + n + ": " + exact(loop.from) + ", D" + n + ": " + exact(output);
  if (!free) text.assembly += ", B" + n + ": " + exact(way - loop.from);
  text.from += ", A" + n + ": " + exact(loop.from);
  text.to += ", A" + n + ": " + exact(loop.from + loop.rate);
}

/// As many loops side by side, each with a motor at its crank.
Study loops(const std::vector<Loop>& all, Kind kind, const std::string& more = "") {
  Text text;
  std::string motors;
  for (std::size_t k = 0; k < all.size(); ++k) {
    add(text, all[k], std::to_string(k), kind);
    motors += ", A" + std::to_string(k);
  }
  const std::string spec = std::string("space: ") + (kind == Kind::plane ? "planar" : "spatial") +
                           "\nground: {points: {O: " + place(0, 0, kind) + text.ground + "}}\nbodies:\n" + text.bodies +
                           "joints:\n" + text.joints + "actuators: [" + motors.substr(2) + "]\nassembly: {" +
                           text.assembly.substr(2) + "}\nmotion: {duration: 1, samples: 11, from: {joints: {" +
                           text.from.substr(2) + "}}, to: {joints: {" + text.to.substr(2) +
                           "}}}\ntrajectories: {go: {law: uniform, drive: joints}}\n" + more;
  return read_spec(spec, "loops.yaml");
}

/// Let go at its trajectory's start, or led from there.
RunResult coast(const Study& study, double duration = 1, const std::string& controller = "") {
  Controller chosen;
  chosen.type = study::ControllerType::none;
  for (const Controller& one : study.controllers)
    if (one.name == controller) chosen = one;
  return simulate_closed_loop(study.mechanism, study.trajectories.at(0), chosen, {.hold_time = duration - 1});
}

/// Ends as it should, and has lost none of its energy.
void check_passes(const Study& study, double duration) {
  const RunResult result = coast(study, duration);
  CHECK_MESSAGE(result.outcome.status == MotionStatus::done, result.outcome.reason);
  const VectorX energy = result.kinetic_energy.col(0) + result.potential_energy.col(0);
  CHECK((energy.array() - energy[0]).abs().maxCoeff() < 1e-6 * energy[0]);
}

constexpr Kind kinds[] = {Kind::plane, Kind::space, Kind::over_constrained};
const std::string still = "controllers: {still: {type: open-loop, torque: 0}}\n";

}  // namespace

TEST_CASE("parallelograms that coast into their change points at once are stopped there (A1)") {
  for (const Kind kind : kinds)
    for (const std::size_t copies : {1u, 2u, 3u, 4u})
      for (const double rate : {-2.0, -9.0, 3.0}) {
        CAPTURE(static_cast<int>(kind));
        CAPTURE(copies);
        CAPTURE(rate);
        std::vector<Loop> all(copies);
        for (Loop& loop : all) loop.rate = rate;
        const Study study = loops(all, kind, still);
        for (const std::string controller : {"none", "still"}) {
          const RunResult result = coast(study, 1, controller);
          CHECK(result.outcome.status == MotionStatus::constraint_singularity);
          CHECK(result.outcome.time == doctest::Approx((rate < 0 ? -1 : pi - 1) / rate).epsilon(1e-4));
        }
      }
}

TEST_CASE("of parallelograms that are flat one shortly after the other the first one ends the motion (A1)") {
  for (const Kind kind : kinds)
    for (const double apart : {1e-2, 1e-4, 1e-6, 1e-9}) {
      CAPTURE(static_cast<int>(kind));
      CAPTURE(apart);
      std::vector<Loop> all(2);
      all[1].from += apart;
      const RunResult result = coast(loops(all, kind));
      CHECK(result.outcome.status == MotionStatus::constraint_singularity);
      CHECK(result.outcome.time == doctest::Approx(0.5).epsilon(1e-4));
    }
}

TEST_CASE("cranks go through the dead centres of their sliders and rockers, several at once") {
  for (const Kind kind : kinds)
    for (const std::size_t copies : {1u, 2u, 3u}) {
      CAPTURE(static_cast<int>(kind));
      CAPTURE(copies);
      std::vector<Loop> sliders(copies), rockers(copies);
      for (Loop& loop : sliders) loop.base = 0, loop.rate = -7, loop.flywheel = 1;
      for (Loop& loop : rockers) loop.s = 0.25, loop.base = 0.35, loop.rate = 7, loop.flywheel = 1;
      check_passes(loops(sliders, kind), 2);
      check_passes(loops(rockers, kind), 2);
    }
}

TEST_CASE("four-bars that are nearly parallelograms go through where these would stop") {
  for (const Kind kind : kinds)
    for (const double longer : {1e-2, 1e-3, 1e-4}) {
      CAPTURE(static_cast<int>(kind));
      CAPTURE(longer);
      std::vector<Loop> all(2);
      for (Loop& loop : all) loop.base += longer, loop.s += 2 * longer, loop.flywheel = 1;
      check_passes(loops(all, kind), 1);
    }
}

TEST_CASE("dead centres of several actuators at once end a run that inverts the dynamics (A1)") {
  // motors at the sliders, which stand still where crank and rod lie in one line, halfway through
  for (const Kind kind : kinds)
    for (const std::size_t copies : {1u, 2u, 3u}) {
      CAPTURE(static_cast<int>(kind));
      CAPTURE(copies);
      std::vector<Loop> all(copies);
      for (Loop& loop : all) loop.base = 0, loop.flywheel = 1;  // which carries the cranks over
      Study study = loops(all, kind, "controllers: {ct: {type: computed-torque}}\n");
      study.mechanism.actuators.clear();
      for (std::size_t c = 0; c < study.mechanism.coordinates.size(); ++c)
        if (study.mechanism.coordinates[c].name[0] == 'D') study.mechanism.actuators.push_back(static_cast<int>(c));
      const RunResult result = coast(study, 1, "ct");
      CHECK_MESSAGE(result.outcome.status == MotionStatus::actuation_singularity, result.outcome.reason);
      CHECK(result.outcome.time == doctest::Approx(0.5).epsilon(0.01));
    }
}

TEST_CASE("three parallel cranks out of line coast through the change points of each pair") {
  for (const bool space : {false, true}) {
    const std::string z = space ? ", 0]" : "]", inertia = space ? "[0.01, 0.01, 0.01]" : "0.01";
    const auto body = [&](const std::string& name, const std::string& points) {
      return "  " + name + ": {mass: 1, com: [0.05, 0" + z + ", inertia: " + inertia + ", points: {" + points + "}}\n";
    };
    const std::string crank = "O: [0, 0" + z + ", E: [0.1, 0" + z;
    const Study study = read_spec(
        std::string("space: ") + (space ? "spatial" : "planar") + "\nground: {points: {O: [0, 0" + z + ", P: [0.3, 0" +
            z + ", Q: [0.15, 0.1" + z + "}}\nbodies:\n" + body("c", crank) + body("d", crank) + body("e", crank) +
            body("l", "O: [0, 0" + z + ", E: [0.3, 0" + z + ", F: [0.15, 0.1" + z) +
            "joints:\n  A: {type: revolute, connects: [ground.O, c.O]}\n  B: {type: revolute, connects: [c.E, l.O]}\n"
            "  C: {type: revolute, connects: [l.E, d.E]}\n  D: {type: revolute, connects: [ground.P, d.O]}\n"
            "  E: {type: revolute, connects: [l.F, e.E]}\n  G: {type: revolute, connects: [ground.Q, e.O]}\n"
            "actuators: [A]\nassembly: {A: 1, D: 1, G: 1, B: -1}\n"
            "motion: {duration: 1, samples: 11, from: {joints: {A: 1}}, to: {joints: {A: -6}}}\n"
            "trajectories: {go: {law: uniform, drive: joints}}\n",
        "cranks.yaml");
    const RunResult result = coast(study, 2);
    REQUIRE_MESSAGE(result.outcome.status == MotionStatus::done, result.outcome.reason);
    CHECK((result.joint_velocity.col(0).array() + 7).abs().maxCoeff() < 1e-7);
  }
}
