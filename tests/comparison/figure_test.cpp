// Figures of runs against closed forms.

#include "balance/interface/comparison/figure_evaluation.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/study/study.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace balance;
using namespace balance::comparison;

namespace {

constexpr double pi = std::numbers::pi;

/// A link of length 2 m that turns from 0 to 1 rad in 1 s.
Study link(const std::string& law = "") {
  return read_spec(R"(space: planar
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: 1, com: [1, 0], inertia: 1, points: {A: [2, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, link.origin]}}
actuators: [J]
tool: link.A
motion: {duration: 1, samples: 401, from: {joints: {J: 0}}, to: {joints: {J: 1}})" +
                       law + "}\n",
                   "link.yaml");
}

struct Ran {
  Study study;
  NamedRun run;

  explicit Ran(Study of, const std::string& trajectory = "") : study(std::move(of)) {
    run.name = "run";
    run.result = simulate(study.mechanism, choose_trajectory(study, trajectory));
    REQUIRE(run.result.outcome.status == MotionStatus::done);
    run.mechanism = std::make_shared<const Mechanism>(study.mechanism);
  }

  EvaluatedFigure figure(const std::string& text) const {
    const Requirement requirement = parse_requirement(text + " == 0", {{"run"}, ""});
    FigureSubject subject;
    subject.run = &run.result;
    subject.mechanism = run.mechanism.get();
    subject.points = {{"D", 1, {1, 1, 0}}};
    FigureEvaluator evaluator(std::move(subject));
    return evaluator.evaluate(list_figures(requirement).at(0));
  }
  double value(const std::string& text) const {
    const EvaluatedFigure found = figure(text);
    INFO(text, ": ", found.reason, found.mistake);
    CHECK(found.has_value());
    return found.value;
  }
  std::string reason(const std::string& text) const { return figure(text).reason + figure(text).mistake; }
};

// of the cycloid from 0 to 1 in 1 s
double angle(double t) { return t - std::sin(2 * pi * t) / (2 * pi); }
double rate(double t) { return 1 - std::cos(2 * pi * t); }
double acceleration(double t) { return 2 * pi * std::sin(2 * pi * t); }

// The interpolant's error is 3/128 h⁴ f⁗ with h = 1/400: 1.5e-10 of an angle (f⁗ = 248), 9e-10 of a rate, 6e-9 of an
// acceleration.
constexpr double figure_tolerance = 1e-8;

}  // namespace

TEST_CASE("a value at a time is the motion law's") {
  const Ran ran(link());
  for (const double t : {0., 0.1234, 0.3, 0.777, 1.}) {
    const std::string at = std::to_string(t);
    CHECK(ran.value("value(joint_position[J], " + at + ")") ==
          doctest::Approx(angle(t)).epsilon(figure_tolerance).scale(1));
    CHECK(ran.value("value(joint_velocity[J], " + at + ")") ==
          doctest::Approx(rate(t)).epsilon(figure_tolerance).scale(1));
    CHECK(ran.value("value(joint_acceleration[J], " + at + ")") ==
          doctest::Approx(acceleration(t)).epsilon(figure_tolerance).scale(6));
  }
  CHECK(ran.value("value(joint_position[J], end)") == doctest::Approx(1).epsilon(1e-14));
  CHECK(ran.value("value(joint_position[J], start)") == 0);
  CHECK(ran.value("duration()") == 1);
  CHECK(ran.figure("value(joint_velocity[J], 0.3)").unit == "rad/s");
  CHECK(ran.figure("duration()").unit == "s");
}

TEST_CASE("a value where another quantity has a value, the first and the second time") {
  const Ran ran(link());
  // the rate is 1 at 1/4 and 3/4 of the time, the angle 1/2 in the middle
  CHECK(ran.value("time(joint_velocity[J] = 1)") == doctest::Approx(0.25).epsilon(figure_tolerance));
  CHECK(ran.value("time(joint_velocity[J] = 2/2 #2)") == doctest::Approx(0.75).epsilon(figure_tolerance));
  CHECK(ran.value("value(joint_velocity[J], joint_position[J] = 0.5)") == doctest::Approx(2).epsilon(figure_tolerance));
  CHECK(ran.value("value(joint_acceleration[J], joint_velocity[J] = 1 #2)") ==
        doctest::Approx(-2 * pi).epsilon(figure_tolerance));
  CHECK(ran.value("value(joint_position[J], peak(joint_velocity[J]))") ==
        doctest::Approx(0.5).epsilon(figure_tolerance));
  CHECK(ran.value("time(minimum(joint_acceleration[J]))") == doctest::Approx(0.75).epsilon(1e-5));
  CHECK(ran.reason("value(joint_velocity[J], joint_position[J] = 1.2)") ==
        "joint_position[J] never is 1.2: it is between 0 and 1 rad");
  CHECK(ran.reason("time(joint_velocity[J] = 1 #3)") == "joint_velocity[J] is 1 2 times, not 3 times");
  CHECK(ran.reason("value(joint_velocity[J], 1.5)") == "1.5 s is outside of the run, which lasts from 0 to 1 s");
}

TEST_CASE("signed extremes, and statistics of every column and component") {
  const Ran ran(link());
  CHECK(ran.value("minimum(joint_acceleration[J])") == doctest::Approx(-2 * pi).epsilon(1e-12));
  CHECK(ran.value("maximum(joint_acceleration[J])") == doctest::Approx(2 * pi).epsilon(1e-12));
  CHECK(ran.value("peak(joint_velocity[J])") == doctest::Approx(2).epsilon(1e-12));
  CHECK(ran.value("mean(joint_velocity[J])") == doctest::Approx(1).epsilon(1e-12));  // periodic: the rule is exact
  CHECK(ran.value("rms(joint_velocity[J])") == doctest::Approx(std::sqrt(1.5)).epsilon(1e-12));
  CHECK(ran.value("range(joint_acceleration[J])") == doctest::Approx(4 * pi).epsilon(1e-12));
  CHECK(ran.value("maximum(tool_position[y])") == doctest::Approx(2 * std::sin(1)).epsilon(1e-12));
  CHECK(ran.value("minimum(tool_position.x)") == doctest::Approx(2 * std::cos(1)).epsilon(1e-12));
}

TEST_CASE("the sides of a jump") {
  const Ran ran(link(), "bang-bang");
  CHECK(ran.value("value(joint_acceleration[J], 0.5, before)") == doctest::Approx(4).epsilon(1e-12));
  CHECK(ran.value("value(joint_acceleration[J], 0.5, after)") == doctest::Approx(-4).epsilon(1e-12));
  CHECK(ran.value("value(joint_acceleration[J], 0.5)") == doctest::Approx(-4).epsilon(1e-12));
  CHECK(ran.value("value(joint_acceleration[J], joint_position[J] = 0.5, before)") ==
        doctest::Approx(4).epsilon(1e-12));
  CHECK(ran.value("rms(joint_acceleration[J])") == doctest::Approx(4).epsilon(1e-12));
  CHECK(ran.value("value(joint_velocity[J], 0.5)") == doctest::Approx(2).epsilon(1e-12));
}

TEST_CASE("positions, velocities and accelerations of points, the tool and bodies") {
  const Ran ran(link());
  const double t = 0.3, q = angle(t), w = rate(t), a = acceleration(t);
  // D is at (1, 1) on the link
  const Vector2 d(std::cos(q) - std::sin(q), std::sin(q) + std::cos(q)), turned(-d.y(), d.x());
  const Vector2 velocity = w * turned, acceleration_of_d = a * turned - w * w * d;
  const auto is = [](double value) { return doctest::Approx(value).epsilon(1e-7).scale(1); };  // six digits of t⁗
  CHECK(ran.value("value(point_position[D].x, 0.3)") == is(d.x()));
  CHECK(ran.value("value(point_position[D][y], 0.3)") == is(d.y()));
  CHECK(ran.value("value(point_velocity[D].x, 0.3)") == is(velocity.x()));
  CHECK(ran.value("value(point_velocity[D].y, 0.3)") == is(velocity.y()));
  CHECK(ran.value("value(point_acceleration[D].x, 0.3)") == is(acceleration_of_d.x()));
  CHECK(ran.value("value(point_acceleration[D].y, 0.3)") == is(acceleration_of_d.y()));
  CHECK(ran.value("value(point_acceleration[D], 0.3)") == is(acceleration_of_d.norm()));
  CHECK(ran.value("value(tool_velocity, 0.3)") == is(2 * w));
  CHECK(ran.value("value(tool_acceleration, 0.3)") == is(2 * std::hypot(a, w * w)));
  CHECK(ran.value("value(body_angular_velocity[link], 0.3)") == is(w));
  CHECK(ran.value("value(body_angular_acceleration[link], 0.3)") == is(a));
  CHECK(ran.value("value(body_orientation[link], 0.3)") == is(q));
  CHECK(ran.figure("value(point_acceleration[D], 0.3)").unit == "m/s^2");
}

TEST_CASE("a whole turn counts on: orientations are continuous") {
  const Ran ran(read_spec(R"(space: planar
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: 1, com: [1, 0], inertia: 1}}
joints: {J: {type: revolute, connects: [ground.O, link.origin]}}
actuators: [J]
motion: {duration: 1, samples: 401, from: {joints: {J: 0}}, to: {joints: {J: 10}}}
)",
                          "turns.yaml"));
  CHECK(ran.value("value(body_orientation[link], end)") == doctest::Approx(10).epsilon(1e-12));
}

TEST_CASE("mistakes name the nearest quantity, what is missing, and what there is") {
  const Ran ran(link());
  CHECK(ran.reason("value(joint_velocty[J], 0.3)") ==
        "no run has a quantity 'joint_velocty[J]'; nearest is 'joint_velocity[J]'");
  CHECK(ran.reason("time(joint_positon[J] = 1)") ==
        "no run has a quantity 'joint_positon[J]'; nearest is 'joint_position[J]'");
  CHECK(ran.reason("peak(shaking_force[z])") == "shaking_force has no component 'z', only x and y");
  CHECK(ran.reason("minimum(kinetic_energy[x])") == "kinetic_energy is a number: it has no component 'x'");
  CHECK(ran.reason("value(torque[J])").starts_with("value(torque[J]) of a run needs a moment: value(torque[J], 0.3)"));
  CHECK(ran.reason("added_mass()") == "added_mass() needs a case with 'design: true' or 'run: design'");
  CHECK(ran.reason("rank()") == "rank() needs a case with 'run: conditions'");
  CHECK(ran.reason("number(parameters.l)") == "number(…) needs a case with a design or with 'solve'");
}

TEST_CASE("requirements of several runs evaluate each run's figures") {
  std::vector<NamedRun> runs{Ran(link()).run, Ran(link(), "bang-bang").run};
  runs[0].name = "cycloid", runs[1].name = "bang";
  const auto holds = [&](const std::string& text) {
    const std::vector<RequirementVerdict> verdicts = judge_requirements({text}, runs);
    INFO(text, ": ", describe_verdict(verdicts.at(0)));
    return verdicts.at(0).holds;
  };
  CHECK(holds("value(joint_velocity[J], 0.5) == base"));  // both 2 rad/s
  CHECK(holds("value(joint_acceleration[J], bang, 0.25) == 4"));
  CHECK(holds("value(joint_acceleration[J], 0.5, before, bang) == 4"));
  CHECK(holds("value(joint_acceleration[J], 'bang', 0.5, after) == -4"));
  CHECK(holds("minimum(joint_acceleration[J]) > base"));
  CHECK(holds("abs(value(joint_position[J], base, 0.25) - 0.25 + 1 / (2 * pi)) < 1e-8"));
  CHECK_FALSE(holds("value(joint_velocity[J], joint_position[J] = 1.2) < 1e9"));
  CHECK(describe_verdict(judge_requirements({"value(joint_velocity[J], joint_position[J] = 1.2) < 1"}, runs).at(0)) ==
        "bang: joint_position[J] never is 1.2: it is between 0 and 1 rad");
  CHECK(judge_requirements({"value(joint_velocity[J], 0.25) <= 3"}, runs).at(0).compared.at(0).unit == "rad/s");
  const auto message = [&](const std::string& text) {
    try {
      judge_requirements({text}, runs);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  CHECK(message("value(joint_velocty[J], 0.3) < 1") ==
        "'value(joint_velocty[J], 0.3) < 1': column 7: no run has a quantity 'joint_velocty[J]'; nearest is "
        "'joint_velocity[J]'");
  CHECK(message("1 < value(joint_velocity[J], joint_positon[J] = 1)").find("column 30: no run has a quantity") !=
        std::string::npos);
  CHECK(message("peak(torqe) < 1").find("column 6: no run has a quantity 'torqe'; nearest is 'torque'") !=
        std::string::npos);
}
