#include "specs.hpp"

#include <algorithm>
#include <numbers>

namespace {

using namespace balance;
using namespace balance::study;

const Controller& find(const Study& study, const std::string& name) {
  const auto at = std::find_if(study.controllers.begin(), study.controllers.end(),
                               [&](const Controller& c) { return c.name == name; });
  REQUIRE_MESSAGE(at != study.controllers.end(), name);
  return *at;
}

const std::string section = R"(controllers:
  a: {type: pd, rate: 500, kp: {J1: 3, J2: l, D.slide: 5}, kd: [1, 2, 3], torque_limit: 7, gravity: ignored}
  b: {type: sliding-mode, period: 0.002, lambda: 4, k: [1, 2, 3], switching: {boundary_layer: 0.1}}
  c: {type: extended-sliding-mode, lambda: 4, k: 2, projection: identity, bandwidth: 3}
  d: {type: computed-torque, model: {without: [cargo, s], mass_scale: {upper: 2}, set: {m: 3, "bodies.lower.com[0]": 0.1}}}
  e: {type: open-loop, table: [[0, 1, 2, 3], [1, 4, 5, 6]], initial_error: {joints: {J1: 0.1}}}
  f: {type: pd, measurement: {position_step: 0.01, position_noise: [0, 0.1, 0.2], velocity: difference, seed: 9}}
  g: {type: none, initial_error: {tool: [0.1, 0], angle: 0.2}}
)";

}  // namespace

TEST_CASE("controllers say what they are, in SI, per actuator, and the built-in ones are there") {
  const Study study = specs::read(specs::planar + section);
  REQUIRE(study.controllers.size() == 7 + 6);
  const Controller &a = find(study, "a"), &b = find(study, "b"), &c = find(study, "c");
  CHECK(a.type == ControllerType::pd);
  CHECK(a.period == 1.0 / 500);
  CHECK(a.kp == Vector3(3, 0.5, 5));
  CHECK(a.kd == Vector3(1, 2, 3));
  CHECK(a.torque_limit == Vector3(7, 7, 7));
  CHECK(a.gravity == GravityCompensation::ignored);
  CHECK(a.natural_frequency() == doctest::Approx(2 * std::numbers::pi * 5));
  CHECK(b.period == 0.002);
  CHECK(b.lambda == Vector3(4, 4, 4));
  CHECK(b.switching_gain == Vector3(1, 2, 3));
  CHECK(b.boundary_layer == Vector3(0.1, 0.1, 0.1));
  CHECK(c.lambda.size() == 1);
  CHECK(c.switching_gain.size() == 1);
  CHECK(c.projection == AccelerationProjection::identity);
  CHECK(*c.bandwidth == 3);
  const Controller& f = find(study, "f");
  CHECK(f.measurement.position_noise == Vector3(0, 0.1, 0.2));
  CHECK(f.measurement.velocity == VelocitySource::difference);
  CHECK(f.measurement.seed == 9);
  const Controller& e = find(study, "e");
  REQUIRE(e.efforts.time.size() == 2);
  CHECK(e.efforts.effort[1] == Vector3(4, 5, 6));
  CHECK(e.initial_error.joints.at(0).value == 0.1);
  CHECK(find(study, "g").initial_error.angle == 0.2);
  CHECK(find(study, "sliding-mode").type == ControllerType::sliding_mode);
}

TEST_CASE("a controller's model is the mechanism with other numbers, factors and things left out, in this order") {
  const Study study = specs::read(specs::planar + section);
  const balance::Mechanism &truth = study.mechanism, &model = find(study, "d").model.value();
  CHECK(truth.bodies[1].mass == 2);
  CHECK(model.bodies[1].mass == 6);  // m is 3 there, times 2
  CHECK(model.bodies[1].inertia(2, 2) == doctest::Approx(2 * truth.bodies[1].inertia(2, 2)));
  CHECK(model.bodies[2].com.x() == 0.1);
  CHECK(model.bodies[2].mass == truth.bodies[2].mass);
  CHECK(model.attachments.size() == truth.attachments.size() - 1);
  CHECK(model.springs.empty());
  CHECK(model.discs.size() == 1);
  CHECK(!find(study, "a").model);
}

TEST_CASE("gains have the spec's units: N m per degree is 180/pi per radian") {
  const std::string text =
      specs::with(specs::planar, "units: {length: m, angle: rad}", "units: {length: mm, angle: deg}");
  const Study study =
      specs::read(text + "controllers: {a: {type: pd, kp: 1, kd: 1}, s: {type: sliding-mode, k: 90}}\n");
  const double torque = 1e-6, force = 1e-3, turn = 180 / std::numbers::pi;  // kg mm²/s², kg mm/s²
  CHECK(find(study, "a").kp[0] == doctest::Approx(torque * turn));
  CHECK(find(study, "a").kp[2] == doctest::Approx(force / 1e-3));
  CHECK(find(study, "s").switching_gain[0] == doctest::Approx(std::numbers::pi / 2));
  CHECK(find(study, "s").switching_gain[2] == doctest::Approx(0.09));
}

TEST_CASE("--set reaches what the controllers believe, whose own set comes after it") {
  const Study study = specs::read(specs::planar + "controllers: {a: {type: pd, model: {set: {l: 0.6}}}}\n",
                                  {.set = {{"m", "5"}, {"l", "0.4"}}});
  CHECK(study.mechanism.bodies[1].com.x() == 0.2);
  CHECK(find(study, "a").model->bodies[1].com.x() == doctest::Approx(0.3));
  CHECK(find(study, "a").model->bodies[1].mass == 5);
}

TEST_CASE("mistakes in controllers are reported with their place and the nearest name") {
  const specs::Mistake mistakes[] = {
      {"type: pd, rate: 500", "type: pid, rate: 500",
       "s.yaml:39:13: controllers.a.type: expected a type of controller (none, open-loop, pd, computed-torque, "
       "sliding-mode or extended-sliding-mode), found 'pid'; nearest is 'pd'"},
      {"type: pd, rate: 500", "rate: 500", "s.yaml:39:6: controllers.a: missing key: expected 'type'"},
      {"rate: 500", "raet: 500", "s.yaml:39:17: controllers.a.raet: unknown key: expected"},
      {"rate: 500", "rate: 500, period: 1",
       "s.yaml:39:23: controllers.a.rate: expected 'rate' or 'period', found both"},
      {"rate: 500", "rate: 0", "s.yaml:39:23: controllers.a.rate: must be positive"},
      {"rate: 500", "lambda: 5",
       "s.yaml:39:25: controllers.a.lambda: expected no 'lambda' with 'type: pd', which has speeds, kp"},
      {"D.slide: 5}", "J3: 5}",
       "s.yaml:39:47: controllers.a.kp.J3: unknown key: expected J1, J2 or D.slide, found 'J3'"},
      {"kd: [1, 2, 3], torque", "kd: [1, 2], torque",
       "s.yaml:39:64: controllers.a.kd: expected a number, or 3 numbers, one for each of the actuators J1, J2 and "
       "D.slide, found a list of 2"},
      {"torque_limit: 7", "torque_limit: -7", "s.yaml:39:89: controllers.a.torque_limit: must not be negative"},
      {"torque_limit: 7", "torque_limit: {free: [1, 2]}", "s.yaml:39:90: controllers.a.torque_limit"},
      {"lambda: 4, k: 2, proj", "lambda: [1, 2, 3], k: 2, proj",
       "s.yaml:41:44: controllers.c.lambda: expected one number for all coordinates"},
      {"[cargo, s]", "[crago, s]",
       "s.yaml:42:48: controllers.d.model.without[0]: expected something that can be left out"},
      {"{upper: 2}", "{uper: 2}",
       "s.yaml:42:72: controllers.d.model.mass_scale.uper: expected something with a mass (upper, lower, wheel, cw, "
       "cargo "
       "or disc), found 'uper'; nearest is 'upper'"},
      {"{m: 3, ", "{mm: 3, ",
       "s.yaml:42:89: controllers.d.model.set.mm: expected a parameter (l, m or k) or the path of a number such as "
       "bodies.link1.mass, found 'mm'; nearest is 'm'"},
      {"bodies.lower.com[0]", "bodies.lowr.com[0]",
       "s.yaml:42:95: controllers.d.model.set.bodies.lowr.com[0]: expected a parameter or a "
       "number of this spec, found 'bodies.lowr.com[0]': there is no 'lowr' in 'bodies'"},
      {"{m: 3, ", "{m: -3, ",
       "s.yaml:42:88: controllers.d.model.set: expected numbers that give a valid mechanism, but these lead to: "},
      {"[1, 4, 5, 6]]", "[1, 4, 5]]", "s.yaml:43:46: controllers.e.table[1]"},
      {"{joints: {J1: 0.1}}", "{joints: {D.angle: 0.1}}",
       "s.yaml:43:86: controllers.e.initial_error.joints.D.angle: expected an actuated coordinate"},
      {"{joints: {J1: 0.1}}", "{}", "s.yaml:43:76: controllers.e.initial_error: expected an initial error with either"},
      {"velocity: difference", "velocity: difference, velocity_noise: 1",
       "s.yaml:44:121: controllers.f.measurement.velocity_noise: expected no 'velocity_noise'"},
      {"type: none, ", "type: none, rate: 5, ",
       "s.yaml:45:25: controllers.g.rate: expected no 'rate' with 'type: none'"},
  };
  specs::check(specs::planar + section, mistakes);
}
