// Payloads that are taken up and set down while the mechanism moves under control.

#include "arms.hpp"
#include "plant_cases.hpp"

#include "balance/mechanics/results/metrics.hpp"
#include "balance/motion/control/payload_impact.hpp"

#include <algorithm>
#include <cstdio>

using namespace arms;

namespace {

constexpr double taken_up = 0.4, set_down = 0.7;

Study arm_with_passing_cargo(const std::string& gravity, const std::string& controllers = "") {
  std::string text = arm_text(controllers, gravity);
  text.replace(text.find("mass: 0.5}"), 10, "mass: 0.5, from: 0.4, until: 0.7}");
  return read_spec(text, "arm.yaml");
}

Controller constant_effort(double effort) {
  Controller c = controller(study::ControllerType::open_loop, 1000);
  c.efforts.time = {0, 1};
  c.efforts.effort = {all(1, effort), all(1, effort)};
  return c;
}

}  // namespace

TEST_CASE("an arm without weight that takes up a payload at rest keeps its moment of momentum") {
  const double u = 0.3;
  const RunResult r = run(arm_with_passing_cargo("0"), "rest", constant_effort(u), 41);
  const double before = u * taken_up / own_inertia, after = before * own_inertia / inertia,
               at_set_down = after + u * (set_down - taken_up) / inertia;
  for (Eigen::Index k = 0; k < r.time.size(); ++k) {
    const double t = r.time[k];
    const bool is_after = t > taken_up - 1e-9, is_free = t > set_down - 1e-9;
    const double speed = is_free    ? at_set_down + u * (t - set_down) / own_inertia
                         : is_after ? after + u * (t - taken_up) / inertia
                                    : u * t / own_inertia;
    CHECK(r.joint_velocity(k, 0) == doctest::Approx(speed).epsilon(1e-8));
    CHECK(r.joint_acceleration(k, 0) ==
          doctest::Approx(u / (is_after && !is_free ? inertia : own_inertia)).epsilon(1e-9));
  }
  // both sides of the jump are in the figures
  const RunResult& between = r.intermediate->rows;
  bool has_left_side = false;
  for (Eigen::Index k = 0; k < between.time.size(); ++k)
    has_left_side = has_left_side || (std::abs(between.time[k] - taken_up) < 1e-9 &&
                                      std::abs(between.joint_velocity(k, 0) - before) < 1e-8 * before);
  CHECK(has_left_side);
  const double loss = (own_inertia * before * before - inertia * after * after) / 2;
  char text[40];
  std::snprintf(text, sizeof text, "the impact takes %.4g J", loss);
  const auto& notes = r.outcome.notes;
  CHECK(std::any_of(notes.begin(), notes.end(), [&](const std::string& note) { return note.find(text) != note.npos; }));
}

TEST_CASE("a controller whose model knows the payload's times holds the arm still, one that does not lets it sag") {
  const std::string controllers =
      "controllers: {knows: {type: computed-torque, bandwidth: 5}, blind: {type: computed-torque, bandwidth: 5, "
      "model: {without: [cargo]}}}\n";
  const Study study = arm_with_passing_cargo("-9.81", controllers);
  const RunResult knows = run(study, "rest", controller(study, "knows"), 101),
                  blind = run(study, "rest", controller(study, "blind"), 101);
  CHECK(knows.tracking_error.cwiseAbs().maxCoeff() < 1e-9);
  for (Eigen::Index k = 0; k < knows.time.size(); ++k) {
    const bool carries = knows.time[k] > taken_up - 1e-9 && knows.time[k] < set_down - 1e-9;
    const double moment = own_moment + (carries ? cargo_moment : 0);
    CHECK(knows.torque(k, 0) == doctest::Approx(moment * g * std::cos(0.2)).epsilon(1e-8));
  }
  const double sag = blind.tracking_error.cwiseAbs().maxCoeff();
  CHECK(sag > 1e-4);
  CHECK(blind.tracking_error.topRows(40).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("what an impact takes is the energy of the lost rates and of the payload's own motion (Carnot)") {
  for (const char* file : {"5r.yaml", "control-rrr.yaml", "delta.yaml"}) {
    const Study study = plants::config(file);
    const plants::Known at = plants::moment_of(study, 0.3);
    Mechanism before = study.mechanism;
    for (Attachment& one : before.attachments)
      if (one.kind == AttachmentKind::payload) one.mass = 0, one.inertia.setZero();
    const control::PayloadImpact impact = control::take_up_payloads(before, study.mechanism, 0, at.q, at.dq);
    REQUIRE_MESSAGE(impact.outcome.status == MotionStatus::done, file);
    const auto kinetic = [&](const Mechanism& mechanism, const VectorX& dq) {
      return plants::started(mechanism, at.q, dq).observe(plants::nothing(mechanism)).kinetic_energy;
    };
    const double total = kinetic(before, at.dq);
    CHECK(total - kinetic(study.mechanism, impact.velocity) == doctest::Approx(impact.energy_loss).epsilon(1e-9));
    const double own = kinetic(study.mechanism, impact.velocity) - kinetic(before, impact.velocity);
    CHECK(kinetic(before, at.dq - impact.velocity) + own == doctest::Approx(impact.energy_loss).epsilon(1e-9));
    CHECK(impact.energy_loss > 1e-6 * total);
  }
}
